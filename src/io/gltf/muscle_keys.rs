//! Keys of muscles: `KHR_animation_pointer` channels aimed at this project's own extension of the file's root.
//!
//! ```json
//! {"extensions": {"SINEW_muscles": {"muscles": [{"name": "biceps_l"}]}}}
//! ```
//! Pointers `/extensions/SINEW_muscles/muscles/N/` + `activation`, `eccentricity`, `width`, `stiffness` (`SCALAR`) or
//! `shape` (`VEC2`: alpha and beta). The `gltf` crate refuses such channels, so they are lifted out of the JSON first.

use super::accessor::Source;
use super::animation;
use super::{Context, label};
use crate::clip::{Interpolation, MuscleChannel, MuscleTrack};
use crate::error::{GltfError, one_line};
use crate::rig::muscle::{Curve, Ease, MuscleSpec, ShapeCurve};
use gltf::json;
use gltf::json::accessor::Type;
use serde_json::Value;
use std::ops::RangeInclusive;

/// Name of the extension.
pub(super) const EXTENSION: &str = "SINEW_muscles";
const REMEDY: &str =
    "point at /extensions/SINEW_muscles/muscles/N/ and one of activation, eccentricity, width, stiffness, shape";

/// A parameter that a pointer may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Parameter {
    Activation,
    Eccentricity,
    Width,
    Stiffness,
    Shape,
}

impl Parameter {
    fn named(name: &str) -> Option<Parameter> {
        Some(match name {
            "activation" => Parameter::Activation,
            "eccentricity" => Parameter::Eccentricity,
            "width" => Parameter::Width,
            "stiffness" => Parameter::Stiffness,
            "shape" => Parameter::Shape,
            _ => return None,
        })
    }

    /// What its keys may be.
    fn range(self) -> RangeInclusive<f32> {
        match self {
            Parameter::Activation => MuscleSpec::ACTIVATION_RANGE,
            Parameter::Eccentricity => MuscleSpec::ECCENTRICITY_RANGE,
            Parameter::Width => 0.0..=MuscleSpec::MAX_WIDTH,
            Parameter::Stiffness => MuscleSpec::STIFFNESS_RANGE,
            Parameter::Shape => {
                let (least, most) = MuscleSpec::EXPONENTS_RANGE.into_inner();
                least as f32..=most as f32
            }
        }
    }
}

/// One channel that was lifted out.
#[derive(Clone, Debug)]
pub(super) struct Lifted {
    /// The animation and the channel, as the file counts them.
    pub animation: usize,
    channel: usize,
    sampler: usize,
    muscle: String,
    parameter: Parameter,
}

/// The pointer of a channel, where it aims at our extension.
fn pointer(channel: &Value) -> Option<&str> {
    let target = channel.get("target")?;
    if target.get("path").and_then(Value::as_str) != Some("pointer") {
        return None;
    }
    let pointer = target.get("extensions")?.get("KHR_animation_pointer")?.get("pointer")?.as_str()?;
    let rest = pointer.strip_prefix("/extensions/")?.strip_prefix(EXTENSION)?;
    (rest.is_empty() || rest.starts_with('/')).then_some(pointer)
}

/// Takes the channels aimed at our extension out of the file's JSON.
pub(super) fn lift(file: &mut Value, cx: &Context) -> Result<Vec<Lifted>, GltfError> {
    let muscles = file.get("extensions").and_then(|e| e.get(EXTENSION)).and_then(|e| e.get("muscles"));
    let muscles = muscles.and_then(Value::as_array).cloned().unwrap_or_default();
    let mut lifted = Vec::new();
    let animations = file.get_mut("animations").and_then(Value::as_array_mut).into_iter().flatten();
    for (index, animation) in animations.enumerate() {
        let element = label("animation", index, animation.get("name").and_then(Value::as_str));
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else { continue };
        for (number, channel) in channels.iter().enumerate() {
            let Some(pointer) = pointer(channel) else { continue };
            let place = format!("{element}, channel {number}");
            let (muscle, parameter) = aim(pointer, &muscles, &place, cx)?;
            let sampler = whole(channel.get("sampler"));
            let sampler = sampler.ok_or_else(|| cx.malformed(place, "it has no sampler", "export the file again"))?;
            lifted.push(Lifted { animation: index, channel: number, sampler, muscle, parameter });
        }
        channels.retain(|channel| pointer(channel).is_none());
    }
    Ok(lifted)
}

/// The muscle's name, cut to a line as all names are, and the parameter that a pointer aims at.
fn aim(pointer: &str, muscles: &[Value], place: &str, cx: &Context) -> Result<(String, Parameter), GltfError> {
    let steps: Vec<&str> = pointer.split('/').skip(3).collect();
    let nowhere = || {
        let what = format!("its pointer `{}` names no parameter of a muscle", one_line(pointer));
        cx.malformed(place, what, REMEDY)
    };
    let ["muscles", index, parameter] = steps[..] else { return Err(nowhere()) };
    let (Ok(index), Some(parameter)) = (index.parse::<usize>(), Parameter::named(parameter)) else {
        return Err(nowhere());
    };
    let Some(muscle) = muscles.get(index) else { return Err(cx.dangling(place, "muscle", index, muscles.len())) };
    match muscle.get("name").and_then(Value::as_str) {
        Some(name) if !name.is_empty() => Ok((one_line(name), parameter)),
        _ => {
            let what = format!("muscle {index} of {EXTENSION} has no name");
            Err(cx.malformed(place, what, "name it as the muscle file does"))
        }
    }
}

/// An index, which some exporters write as a decimal.
fn whole(value: Option<&Value>) -> Option<usize> {
    let value = value?;
    let decimal = || value.as_f64().filter(|d| d.fract() == 0.0 && (0.0..1e9).contains(d)).map(|d| d as u64);
    value.as_u64().or_else(decimal).and_then(|n| usize::try_from(n).ok())
}

/// Reads the keys of one lifted channel; `None` where it has none.
pub(super) fn read(
    source: &Source,
    animation: &json::Animation,
    lifted: &Lifted,
) -> Result<Option<MuscleChannel>, GltfError> {
    let cx = source.cx;
    let place =
        format!("{}, channel {}", label("animation", lifted.animation, animation.name.as_deref()), lifted.channel);
    let samplers = &animation.samplers;
    let Some(sampler) = samplers.get(lifted.sampler) else {
        return Err(cx.dangling(place, "sampler", lifted.sampler, samplers.len()));
    };
    let interpolation = animation::interpolation(sampler, cx, &place)?;
    let times = animation::times(source, sampler, &place)?;
    if times.is_empty() {
        cx.note(format!("{place}: it has no keys and is not read"));
        return Ok(None);
    }
    let shape = lifted.parameter == Parameter::Shape;
    let (kind, numbers) = if shape { (Type::Vec2, 2) } else { (Type::Scalar, 1) };
    let flat = source.decimals(sampler.output, &[kind], &format!("{place}, values"))?;
    let cubic = interpolation == Interpolation::CubicSpline;
    let per_key = if cubic { 3 } else { 1 };
    if flat.len() != times.len() * per_key * numbers {
        let (keys, values) = (times.len(), flat.len() / numbers);
        let what = format!("it has {keys} keys and {values} values, {per_key} a key are needed");
        return Err(cx.malformed(place, what, "export the animation again"));
    }
    if let Some(value) = flat.iter().position(|v| !v.is_finite()) {
        return Err(cx.non_finite(place, format!("value {}", value / numbers)));
    }
    // Of a cubic spline's three values per key the middle one is the key's.
    let keys: Vec<&[f32]> = flat.chunks_exact(numbers).skip(per_key / 2).step_by(per_key).collect();
    let range = lifted.parameter.range();
    for (key, value) in keys.iter().enumerate() {
        let good = value.iter().all(|v| range.contains(v) && !(shape && v.fract() != 0.0));
        if !good {
            let (kind, value) =
                if shape { (" in whole numbers", format!("{value:?}")) } else { ("", value[0].to_string()) };
            let what = format!(
                "key {key} is {value}, and {} must be in {} to {}{kind}",
                format!("{:?}", lifted.parameter).to_lowercase(),
                range.start(),
                range.end()
            );
            return Err(cx.malformed(place, what, "correct the key and export again"));
        }
    }
    let ease = match interpolation {
        Interpolation::Linear => Ease::Linear,
        Interpolation::Step => Ease::Step,
        Interpolation::CubicSpline => Ease::Cubic,
    };
    let track = if shape {
        if cubic {
            cx.note(format!(
                "{place}: shapes are blended straight from key to key; its cubic spline's tangents are not read"
            ));
        }
        let shapes = keys.iter().map(|pair| (pair[0] as u32, pair[1] as u32)).collect();
        MuscleTrack::Shape(ShapeCurve { ease, times, shapes })
    } else {
        let values = keys.iter().map(|v| v[0]).collect();
        let tangents = if cubic { flat.chunks_exact(3).map(|v| [v[0], v[2]]).collect() } else { Vec::new() };
        let curve = Curve { ease, times, values, tangents };
        match lifted.parameter {
            Parameter::Activation => MuscleTrack::Activation(curve),
            Parameter::Eccentricity => MuscleTrack::Eccentricity(curve),
            Parameter::Width => MuscleTrack::Width(curve),
            Parameter::Stiffness | Parameter::Shape => MuscleTrack::Stiffness(curve),
        }
    };
    Ok(Some(MuscleChannel { muscle: lifted.muscle.clone(), track }))
}
