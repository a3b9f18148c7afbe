//! Paper B's figure 3 on the built-in arm: its muscles, and its skin by hybrid and by smooth skinning.

use super::actor::{Actor, Seen, camera};
use super::plot::{INK, Label, PALE, Page};
use super::scene::Studio;
use super::{Arm, Drawn, Figure, Finding};
use crate::error::FigureError;
use crate::gpu::Headless;
use crate::render::{Camera, ColorMesh, View};
use crate::rig::{Image, Pose};
use crate::schedule::{FrameOptions, Skinning};
use glam::Vec3;

const PANEL: [u32; 2] = [400, 400];
const TITLE: u32 = 60;
/// Hybrid and smooth skinning where they are laid over one another, linear RGB.
const HYBRID: [f32; 3] = [0.06, 0.30, 0.62];
const SMOOTH: [f32; 3] = [0.80, 0.42, 0.10];

/// The arm by one skinning in some poses.
struct Shown<'a> {
    actor: Actor<'a>,
}

impl<'a> Shown<'a> {
    fn new(studio: &'a Studio<'a>, arm: &Arm, skinning: Skinning) -> Result<Shown<'a>, FigureError> {
        let options = FrameOptions { skinning, ..FrameOptions::default() };
        Ok(Shown { actor: Actor::with(studio, &arm.rig, &options)? })
    }

    fn pose(&mut self, camera: &Camera, pose: &Pose, view: View) -> Result<(Image, Seen), FigureError> {
        let seen = self.actor.show(pose)?;
        Ok((self.actor.draw(camera, pose, &seen, view)?, seen))
    }
}

fn colored(arm: &Arm, seen: &Seen, color: [f32; 3]) -> ColorMesh {
    ColorMesh {
        colors: vec![color; seen.positions.len()],
        positions: seen.positions.clone(),
        normals: seen.normals.clone(),
        triangles: arm.rig.character.triangles.clone(),
    }
}

/// Root mean square and largest distance of two skins' vertices, metres.
fn apart(one: &[Vec3], other: &[Vec3]) -> [f64; 2] {
    let squares = one.iter().zip(other).map(|(a, b)| f64::from(a.distance_squared(*b)));
    let (sum, most) = squares.fold((0.0, 0.0f64), |(sum, most), x| (sum + x, most.max(x)));
    [(sum / one.len().max(1) as f64).sqrt(), most.sqrt()]
}

/// The figure.
pub(super) fn figure(headless: &Headless, arm: &Arm) -> Result<Drawn, FigureError> {
    let lacks = || Figure::Hybrid.lacks("the built-in arm in motion");
    let (start, end) = (arm.curl.first().ok_or_else(lacks)?, arm.curl.last().ok_or_else(lacks)?);
    let middle = &arm.curl[arm.curl.len() / 2];
    let rest = Pose::rest(&arm.rig.character);
    let studio = Studio::new(headless, PANEL[0], PANEL[1])?;
    let straight = camera(&arm.rig, &[&rest, start], studio.aspect())?;
    let camera = camera(&arm.rig, &[middle, end], studio.aspect())?;
    let mut hybrid = Shown::new(&studio, arm, Skinning::Hybrid)?;
    let mut smooth = Shown::new(&studio, arm, Skinning::Linear)?;
    let mut images = vec![("(a) at rest, with its muscles", hybrid.pose(&straight, &rest, View::Xray)?.0)];
    images.push(("(b) on its way", hybrid.pose(&camera, middle, View::Skin)?.0));
    images.push(("(c) bones and muscles at rest", hybrid.pose(&straight, &rest, View::Muscles)?.0));
    images.push(("(d) the muscles bent", hybrid.pose(&camera, end, View::Muscles)?.0));
    let (skin, by_muscles) = hybrid.pose(&camera, end, View::Skin)?;
    let (plain, by_bones) = smooth.pose(&camera, end, View::Skin)?;
    let over = [colored(arm, &by_muscles, HYBRID), colored(arm, &by_bones, SMOOTH)];
    images.push(("(e) hybrid over smooth skinning", studio.solids(&camera, &over)?));
    images.push(("(f) by hybrid skinning", skin));
    images.push(("beside: by smooth skinning", plain));
    let mut page = Page::new(4 * PANEL[0], 2 * (PANEL[1] + TITLE))?;
    for (k, (title, image)) in (0..).zip(&images) {
        let (left, top) = (k % 4 * PANEL[0], k / 4 * (PANEL[1] + TITLE));
        page.paste(image, left, top + TITLE);
        Label::new(title, 19.0).color(INK).draw(&mut page, f64::from(left + PANEL[0] / 2), f64::from(top) + 26.0)?;
    }
    let notes = ["(e): blue where hybrid skinning", "is outside, orange where smooth"];
    let (x, y) = (f64::from(3 * PANEL[0] + PANEL[0] / 2), f64::from(PANEL[1] + TITLE + 200));
    for (line, note) in (0..).zip(notes) {
        Label::new(note, 16.0).color(PALE).draw(&mut page, x, y + 26.0 * f64::from(line))?;
    }
    let [mean, most] = apart(&by_muscles.positions, &by_bones.positions);
    let findings = vec![
        Finding::new("bent: hybrid from smooth skinning, root mean square", 1000.0 * mean, "mm"),
        Finding::new("bent: hybrid from smooth skinning, most", 1000.0 * most, "mm"),
    ];
    Ok(Drawn { image: page.finish(), findings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_of_vertices_that_belong_together() {
        let one = [Vec3::ZERO, Vec3::X];
        assert_eq!(apart(&one, &one), [0.0, 0.0]);
        assert_eq!(apart(&one, &[Vec3::ZERO, Vec3::X * 4.0]), [4.5f64.sqrt(), 3.0]);
    }
}
