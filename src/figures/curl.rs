//! Figure 14: the bent arm, the same with a wider biceps, and where they differ.

use super::actor::{Actor, camera};
use super::plot::{Axis, INK, Label, Page, Rect, bar};
use super::scene::{Studio, linear};
use super::{Arm, Drawn, Finding};
use crate::error::FigureError;
use crate::gpu::Headless;
use crate::render::{ColorMesh, View};
use crate::rig::{Key, Keyed, Pose};
use glam::Vec3;

/// Which muscle is made wider, and by which factor.
const MUSCLE: &str = "biceps";
const WIDER: f32 = 1.3;
const PANEL: [u32; 2] = [460, 470];
const TITLE: u32 = 60;
const BAR: u32 = 100;

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

/// The figure.
pub(super) fn figure(headless: &Headless, arm: &Arm) -> Result<Drawn, FigureError> {
    let bend = arm.curl.last().cloned().unwrap_or_default();
    let studio = Studio::new(headless, PANEL[0], PANEL[1])?;
    let camera = camera(&arm.rig, &[&bend], studio.aspect())?;
    let mut actor = Actor::new(&studio, &arm.rig, None)?;
    let (mut skins, mut images) = (Vec::new(), Vec::new());
    for pose in [bend.clone(), widened(&bend, WIDER)] {
        let seen = actor.show(&pose)?;
        images.push(actor.draw(&camera, &pose, &seen, View::Skin)?);
        skins.push(seen);
    }
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
