//! Animations of translation, rotation and scale, and of muscles.

use super::accessor::Source;
use super::muscle_keys::{self, Lifted};
use super::nodes::unit;
use super::{Context, label};
use crate::clip::{Channel, Clip, Interpolation, Local, MuscleChannel, Scene, Track};
use crate::error::{GltfError, one_line};
use glam::{Quat, Vec3};
use gltf::json;
use gltf::json::accessor::Type;
use gltf::json::animation::{Interpolation as Joined, Property};
use gltf::json::validation::Checked;

/// Reads all animations into the scene.
pub(super) fn read(source: &Source, mut lifted: &[Lifted], scene: &mut Scene) -> Result<(), GltfError> {
    for (index, animation) in source.root.animations.iter().enumerate() {
        let element = label("animation", index, animation.name.as_deref());
        let mut channels = Vec::with_capacity(animation.channels.len());
        for (number, channel) in animation.channels.iter().enumerate() {
            let place = format!("{element}, channel {number}");
            if let Some(channel) = read_channel(source, animation, channel, &place, scene)? {
                channels.push(channel);
            }
        }
        let mut muscle_channels = Vec::new();
        // They come in the file's order.
        let (own, others) = lifted.split_at(lifted.partition_point(|l| l.animation <= index));
        lifted = others;
        for lifted in own {
            muscle_channels.extend(muscle_keys::read(source, animation, lifted)?);
        }
        let times = || {
            let of_nodes = channels.iter().map(|c| c.times.as_slice());
            of_nodes.chain(muscle_channels.iter().map(MuscleChannel::times))
        };
        let start = times().filter_map(|t| t.first().copied()).reduce(f32::min).unwrap_or(0.0);
        let end = times().filter_map(|t| t.last().copied()).reduce(f32::max).unwrap_or(0.0);
        let name = match animation.name.as_deref() {
            Some(name) if !name.is_empty() => one_line(name),
            _ => format!("#{index}"),
        };
        scene.clips.push(Clip { name, start, end, channels, muscle_channels });
    }
    Ok(())
}

fn read_channel(
    source: &Source,
    animation: &json::Animation,
    channel: &json::animation::Channel,
    place: &str,
    scene: &mut Scene,
) -> Result<Option<Channel>, GltfError> {
    let cx = source.cx;
    let node = channel.target.node.value();
    if node >= scene.nodes.len() {
        return Err(cx.dangling(place, "node", node, scene.nodes.len()));
    }
    let (index, samplers) = (channel.sampler.value(), &animation.samplers);
    let Some(sampler) = samplers.get(index) else { return Err(cx.dangling(place, "sampler", index, samplers.len())) };
    let interpolation = interpolation(sampler, cx, place)?;
    let times = times(source, sampler, place)?;
    if times.is_empty() {
        cx.note(format!("{place}: it has no keys and is not read"));
        return Ok(None);
    }
    let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let track = match channel.target.path.as_ref() {
        Checked::Valid(Property::Translation) => Track::Translation(vectors(source, sampler, place)?),
        Checked::Valid(Property::Scale) => Track::Scale(vectors(source, sampler, place)?),
        Checked::Valid(Property::Rotation) => Track::Rotation(rotations(source, sampler, per_key, place)?),
        _ => return Ok(None),
    };
    if track.len() != times.len() * per_key {
        let what = format!("it has {} keys and {} values, {per_key} a key are needed", times.len(), track.len());
        return Err(cx.malformed(place, what, "export the animation again"));
    }
    make_animatable(source, scene, node, place);
    Ok(Some(Channel { node: node as u32, times, interpolation, track }))
}

/// How a sampler joins its keys.
pub(super) fn interpolation(
    sampler: &json::animation::Sampler,
    cx: &Context,
    place: &str,
) -> Result<Interpolation, GltfError> {
    match sampler.interpolation.as_ref() {
        Checked::Valid(Joined::Linear) => Ok(Interpolation::Linear),
        Checked::Valid(Joined::Step) => Ok(Interpolation::Step),
        Checked::Valid(Joined::CubicSpline) => Ok(Interpolation::CubicSpline),
        Checked::Invalid => Err(cx.malformed(place, "its interpolation is unknown", "export the file again")),
    }
}

/// The key times of a sampler, finite and ascending.
pub(super) fn times(source: &Source, sampler: &json::animation::Sampler, place: &str) -> Result<Vec<f32>, GltfError> {
    let times = source.decimals(sampler.input, &[Type::Scalar], &format!("{place}, key times"))?;
    if let Some(key) = times.iter().position(|t| !t.is_finite()) {
        return Err(source.cx.non_finite(place, format!("the time of key {key}")));
    }
    if let Some(key) = times.windows(2).position(|w| w[1] < w[0]) {
        let what = format!("key {} at {} s comes before key {key} at {} s", key + 1, times[key + 1], times[key]);
        return Err(source.cx.malformed(place, what, "sort the keys by time and export again"));
    }
    Ok(times)
}

fn vectors(source: &Source, sampler: &json::animation::Sampler, place: &str) -> Result<Vec<Vec3>, GltfError> {
    let flat = source.decimals(sampler.output, &[Type::Vec3], &format!("{place}, values"))?;
    let vectors: Vec<Vec3> = flat.chunks_exact(3).map(Vec3::from_slice).collect();
    match vectors.iter().position(|v| !v.is_finite()) {
        Some(value) => Err(source.cx.non_finite(place, format!("value {value}"))),
        None => Ok(vectors),
    }
}

/// Rotations at length 1; of cubic splines only as they are, because tangents have any length.
fn rotations(
    source: &Source,
    sampler: &json::animation::Sampler,
    per_key: usize,
    place: &str,
) -> Result<Vec<Quat>, GltfError> {
    let flat = source.decimals(sampler.output, &[Type::Vec4], &format!("{place}, values"))?;
    let mut rotations: Vec<Quat> = flat.chunks_exact(4).map(Quat::from_slice).collect();
    if let Some(value) = rotations.iter().position(|q| !q.is_finite()) {
        return Err(source.cx.non_finite(place, format!("value {value}")));
    }
    for (value, rotation) in rotations.iter_mut().enumerate() {
        let is_tangent = per_key == 3 && value % 3 != 1;
        match unit(*rotation) {
            _ if is_tangent => {}
            None => {
                let what = format!("value {value} is the zero quaternion, which is no rotation");
                return Err(source.cx.malformed(place, what, "export the animation again"));
            }
            Some(unit) if per_key == 1 => *rotation = unit,
            Some(_) => {}
        }
    }
    Ok(rotations)
}

/// glTF lets no animation touch a node with a matrix; where one does, the matrix is taken apart.
fn make_animatable(source: &Source, scene: &mut Scene, node: usize, place: &str) {
    if let Local::Matrix(matrix) = scene.nodes[node].local {
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        let scale = if scale.is_finite() { scale } else { Vec3::ONE };
        let rotation = if rotation.is_finite() { unit(rotation).unwrap_or_default() } else { Quat::IDENTITY };
        scene.nodes[node].local = Local::Parts { translation, rotation, scale };
        source.cx.note(format!("{place}: it moves node {node}, which has a matrix; the matrix is taken apart"));
    }
}
