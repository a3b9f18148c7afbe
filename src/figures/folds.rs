//! Implicit Skinning's folds: a joint bent by linear and dual quaternion skinning and by the tracked skin, side by side.

use super::limb::{Bent, Effect, Limb};
use super::plot::{Align, Label};
use super::scene::{Studio, sheet};
use super::{Drawn, Finding};
use crate::error::FigureError;
use crate::gpu::Headless;
use crate::render::{Camera, Direction, Frame, Light, Look, SkinMesh, Surface, View, vertex_buffer};
use crate::rig::groups::BodyPart;
use crate::schedule::Skinning;
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use std::sync::Arc;

const PANEL: [u32; 2] = [330, 320];
const ANGLES: [f32; 4] = [0.0, 45.0, 90.0, 130.0];
/// Of a finger's middle joint.
const FINGER_ANGLES: [f32; 4] = [0.0, 40.0, 80.0, 110.0];
const ROWS: [(Skinning, &str); 3] =
    [(Skinning::Linear, "linear"), (Skinning::DualQuaternion, "dual quaternion"), (Skinning::Implicit, "ours")];
/// Up to this many groups a character is a limb and not a body.
const LIMB_GROUPS: usize = 4;
/// Pixels over the first row: see [`sheet`].
const TOP: u32 = 56;

/// The figure.
pub(super) fn figure(headless: &Headless, limb: &Limb) -> Result<Drawn, FigureError> {
    let studio = Studio::new(headless, PANEL[0], PANEL[1])?;
    let look = Arc::new(Look::of(headless, studio.renderer(), &limb.rig.character)?);
    let mesh = SkinMesh::of(headless, &look, &limb.rig.character)?;
    let angles = if limb.part == Some(BodyPart::Hand) { FINGER_ANGLES } else { ANGLES };
    let skins = ROWS.map(|(skinning, _)| limb.skins(skinning, &angles));
    let mut camera = None;
    let (mut rows, mut effects) = (Vec::new(), Vec::new());
    for skins in skins {
        let skins = skins?;
        // One camera for all of them, by the first row.
        let camera = camera.get_or_insert_with(|| hold(limb, &skins, studio.aspect()));
        let mut row = Vec::new();
        for skin in &skins {
            let points = |list: &[Vec4]| list.iter().map(|p| p.xyz()).collect::<Vec<Vec3>>();
            let vertices = vertex_buffer(headless, &points(&skin.positions), &points(&skin.normals))?;
            let surfaces = [Surface { mesh: &mesh, vertices: vertices.slice(..), model: Mat4::IDENTITY }];
            let frame =
                Frame { camera, view: View::Skin, light: Light::Paper, surfaces: &surfaces, solids: &[], marks: &[] };
            row.push(studio.frame(&frame)?);
        }
        rows.push(row);
        effects.push(skins.iter().map(|skin| limb.effect(skin)).collect::<Vec<Effect>>());
    }
    let titles = angles.map(|angle| format!("{angle:.0}°"));
    let mut page = sheet(&titles.each_ref().map(String::as_str), &rows, &[])?;
    let mut findings = Vec::new();
    for ((row, (_, name)), effects) in (0..).zip(ROWS).zip(&effects) {
        let top = f64::from(TOP + row * PANEL[1]);
        let title = Label { rimmed: true, ..Label::new(name, 18.0).align(Align::Left) };
        title.draw(&mut page, 14.0, top + 16.0)?;
        for ((column, angle), effect) in (0..).zip(angles).zip(effects) {
            let [low, high] = effect.areas;
            // Of a whole body a joint is too small a share to be told in percent.
            let volume = effect.volume.map_or(String::new(), |[at_rest, change]| match limb.rig.groups.groups.len() {
                0..=LIMB_GROUPS => format!("volume {:+.1} %, ", 100.0 * change / at_rest),
                _ => format!("volume {:+.0} ml, ", 1e6 * change),
            });
            let note = format!("{volume}areas {low:.2} to {high:.2}");
            let middle = f64::from(PANEL[0]) * (f64::from(column) + 0.5);
            let note = Label { rimmed: true, ..Label::new(&note, 14.0) };
            note.draw(&mut page, middle, top + f64::from(PANEL[1]) - 14.0)?;
            let named = |what: &str| format!("{name}, {angle:.0} degrees: {what}");
            if let Some([at_rest, change]) = effect.volume {
                findings.push(Finding::new(named("change of the volume"), 1e6 * change, "ml"));
                findings.push(Finding::new(named("change of the volume, relative"), 100.0 * change / at_rest, "%"));
            }
            findings.push(Finding::new(named("smallest ratio of a triangle's areas"), low, ""));
            findings.push(Finding::new(named("largest ratio of a triangle's areas"), high, ""));
            findings.push(Finding::new(named("change of the angle at 99.5 % of the edges"), effect.crease, "degrees"));
        }
    }
    Ok(Drawn { image: page.finish(), findings })
}

/// The camera that looks along the hinge, from outside, and holds what is near it in all skins.
fn hold(limb: &Limb, skins: &[Bent], aspect: f32) -> Camera {
    let toward = limb.outside;
    let direction = Direction {
        azimuth: toward.x.atan2(toward.z).to_degrees(),
        elevation: toward.y.clamp(-1.0, 1.0).asin().to_degrees(),
    };
    let near = limb.near();
    let points: Vec<Vec3> = skins.iter().flat_map(|skin| near.iter().map(|&v| skin.positions[v].xyz())).collect();
    Camera::around(&points, direction, aspect)
}
