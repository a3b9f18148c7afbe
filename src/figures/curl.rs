//! Figure 14: the bent arm, the same with a wider biceps, and where they differ.

use super::plot::{Axis, INK, Label, Page, Rect, bar};
use super::scene::{Studio, linear};
use super::{Arm, Drawn, Finding};
use crate::error::FigureError;
use crate::gpu::{Headless, Instance, Kernels, Output, RigBuffers, readback};
use crate::render::{Camera, ColorMesh, Direction, Frame, Light, Look, SkinMesh, Surface, View};
use crate::rig::{FrameInputs, Image, Key, Keyed, Pose, Rig};
use crate::skinning::{self, SkinInput};
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use std::sync::Arc;

/// Which muscle is made wider, and by which factor.
const MUSCLE: &str = "biceps";
const WIDER: f32 = 1.3;
const PANEL: [u32; 2] = [460, 470];
const TITLE: u32 = 60;
const BAR: u32 = 100;
/// From the inner side, where the biceps shows.
const DIRECTION: Direction = Direction { azimuth: -75.0, elevation: 5.0 };

/// A skin as deformed: positions and normals.
struct Skin {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

/// The pose with the muscle's width scaled.
fn widened(pose: &Pose, factor: f32) -> Pose {
    let mut pose = pose.clone();
    pose.keyed.push(Keyed { muscle: MUSCLE.into(), key: Key::Width(factor) });
    pose
}

/// Farthest that any vertex lies from its counterpart, metres.
fn farthest(one: &[Vec3], other: &[Vec3]) -> f32 {
    one.iter().zip(other).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

/// The colour of a movement of a share of the largest: grey where nothing moved.
fn moved_color(share: f64) -> [u8; 3] {
    const FROM: [f64; 3] = [205.0, 207.0, 210.0];
    const TO: [f64; 3] = [190.0, 70.0, 0.0];
    let share = share.clamp(0.0, 1.0);
    std::array::from_fn(|c| (FROM[c] + (TO[c] - FROM[c]) * share).round() as u8)
}

/// The camera that holds a pose, by linear skinning: fields move the skin by less than the camera's margin.
fn camera(rig: &Rig, pose: &Pose, aspect: f32) -> Result<Camera, FigureError> {
    let inputs = FrameInputs::new(rig, pose)?;
    let mut skinned = vec![Vec4::ZERO; rig.character.vertex_count()];
    let input = SkinInput {
        joints: &inputs.joints,
        positions_rest: &rig.positions_rest,
        offsets: &rig.character.influence_offsets,
        influences: &rig.character.influences,
    };
    skinning::linear(&input, &mut skinned);
    Ok(Camera::around(&skinned.iter().map(|p| p.xyz()).collect::<Vec<_>>(), DIRECTION, aspect))
}

/// The skin in several poses, deformed on the device and drawn from there.
fn deformed(
    studio: &Studio<'_>,
    rig: &Arc<Rig>,
    poses: &[Pose],
    camera: &Camera,
) -> Result<Vec<(Skin, Image)>, FigureError> {
    let headless = studio.headless();
    let (device, queue) = (&headless.device, &headless.queue);
    let kernels = Kernels::new(device)?;
    let buffers = Arc::new(RigBuffers::upload(device, Arc::clone(rig))?);
    let mut instance = Instance::new(&kernels, device, queue, &buffers, Output::Owned)?;
    let look = Arc::new(Look::of(headless, studio.renderer(), &rig.character)?);
    let mesh = SkinMesh::of(headless, &look, &rig.character)?;
    let mut drawn = Vec::new();
    for pose in poses {
        instance.set_pose(queue, pose)?;
        let output = instance.output().clone();
        let surfaces = [Surface { mesh: &mesh, vertices: output.slice(..), model: Mat4::IDENTITY }];
        let frame =
            Frame { camera, view: View::Skin, light: Light::Paper, surfaces: &surfaces, solids: &[], marks: &[] };
        let image = studio.deformed(&frame, &mut instance)?;
        let vertices: Vec<[f32; 6]> = readback::read(headless, &output, ..rig.character.vertex_count())?;
        let skin = Skin {
            positions: vertices.iter().map(|v| Vec3::new(v[0], v[1], v[2])).collect(),
            normals: vertices.iter().map(|v| Vec3::new(v[3], v[4], v[5])).collect(),
        };
        drawn.push((skin, image));
    }
    Ok(drawn)
}

/// The figure.
pub(super) fn figure(headless: &Headless, arm: &Arm) -> Result<Drawn, FigureError> {
    let bend = arm.curl.last().cloned().unwrap_or_default();
    let studio = Studio::new(headless, PANEL[0], PANEL[1])?;
    let poses = [bend.clone(), widened(&bend, WIDER)];
    let camera = camera(&arm.rig, &bend, studio.aspect())?;
    let (skins, mut images): (Vec<Skin>, Vec<Image>) =
        deformed(&studio, &arm.rig, &poses, &camera)?.into_iter().unzip();
    let most = farthest(&skins[0].positions, &skins[1].positions);
    let moved = skins[0].positions.iter().zip(&skins[1].positions).map(|(a, b)| a.distance(*b));
    let map = ColorMesh {
        colors: moved.map(|d| linear(moved_color(f64::from(d / most.max(1e-9))))).collect(),
        positions: skins[1].positions.clone(),
        normals: skins[1].normals.clone(),
        triangles: arm.rig.character.triangles.clone(),
    };
    images.push(studio.solids(&camera, &[map])?);
    let mut page = Page::new(3 * PANEL[0] + BAR, PANEL[1] + TITLE)?;
    let titles = ["Curl", "The same, biceps 30 % wider", "Movement of the skin"];
    for ((image, title), left) in images.iter().zip(titles).zip([0, PANEL[0], 2 * PANEL[0]]) {
        page.paste(image, left, TITLE);
        Label::new(title, 20.0).color(INK).draw(&mut page, f64::from(left + PANEL[0] / 2), 30.0)?;
    }
    let most = f64::from(most) * 1000.0;
    let value = Axis { name: "mm", range: 0.0..most, ticks: 5, digits: 1 };
    let place = Rect { left: 3 * PANEL[0] + 12, top: 120, width: 18, height: 320 };
    bar(&mut page, place, &value, &|v| moved_color(v / most.max(1e-9)))?;
    Ok(Drawn { image: page.finish(), findings: vec![Finding::new("largest movement of the skin", most, "mm")] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_width_of_the_biceps_is_keyed() {
        let pose = widened(&Pose::default(), WIDER);
        assert_eq!(pose.keyed, [Keyed { muscle: "biceps".into(), key: Key::Width(1.3) }]);
        let here = [Vec3::ZERO, Vec3::X];
        assert_eq!(farthest(&here, &here), 0.0);
        assert_eq!(farthest(&here, &[Vec3::ZERO, Vec3::X * 1.5]), 0.5);
    }
}
