//! Oracles of the dynamics: closed forms, a direct solve in f64, conservation.

mod arm;
mod elastic;
mod measure;
mod rest;
mod shake;
mod volume;
mod wrapped;

use super::*;
use crate::field::muscle::{AxisPoint, MuscleInput, MuscleRest, Profile, straighten};
use crate::rig::{Attachment, FrameInputs, JointFrame, MuscleSize, MuscleSpec};
use glam::{Mat4, Vec3, Vec4};

/// Length, metres, and width of the test muscles.
pub const LENGTH: f32 = 0.3;
pub const WIDTH: f32 = 0.02;

/// Straight muscles side by side along Y, each between the same two joints, all colliding in one group where asked.
pub fn muscles(places: &[Vec3], change: impl Fn(usize, &mut MuscleSpec), touch: bool) -> Bodies {
    let mut bodies = Bodies::default();
    for (index, place) in places.iter().enumerate() {
        let end = |y: f32| Attachment { bone: "b".into(), offset: *place + Vec3::Y * y, normal: Vec3::X };
        let mut spec = MuscleSpec::new("m", "b", end(0.0), end(LENGTH), MuscleSize::Width(WIDTH));
        change(index, &mut spec);
        let volume = std::f32::consts::PI * WIDTH * WIDTH * LENGTH;
        let rest = MuscleRest {
            origin: place.extend(volume),
            insertion: (*place + Vec3::Y * LENGTH).extend(0.03),
            origin_normal: Vec3::X.extend(LENGTH),
            segments: spec.segments,
            insertion_joint: 1,
            first_point: bodies.particles_rest.len() as u32,
            ..MuscleRest::default()
        };
        let mut axis = vec![AxisPoint::default(); spec.segments as usize + 1];
        straighten(&mut axis, rest.origin.truncate(), rest.insertion.truncate());
        let particles = body::particles(&rest, &spec, &axis);
        let begin = bodies.links.len() as u32;
        if touch {
            let others = (0..places.len() as u32).filter(|&i| i as usize != index);
            bodies.links.extend(others.map(|index| Link { index, ..Link::default() }));
        }
        let end = bodies.links.len() as u32;
        bodies.muscles.push(MuscleBody {
            bones_begin: begin,
            peers_begin: begin,
            skins_begin: end,
            links_end: end,
            ..body::muscle_body(&rest, &spec, &particles)
        });
        bodies.particles_rest.extend(particles);
        bodies.axes_rest.extend(axis);
    }
    bodies
}

/// Inputs of joints at given palettes.
pub fn inputs(joints: &[Mat4], count: usize, stiffness: f32) -> FrameInputs {
    let joint = |matrix: &Mat4| {
        let (rotation, _, stretch) = crate::math::polar(matrix);
        JointFrame { matrix: *matrix, real: rotation.into(), dual: Vec4::ZERO, stretch }
    };
    let input = MuscleInput { stiffness, ..MuscleInput::new(&Profile::of(3, 3), 0.0) };
    FrameInputs { joints: joints.iter().map(joint).collect(), groups: Vec::new(), muscles: vec![input; count] }
}

pub const NO_SKIN: Skins<'static> = Skins { grids: &[], nodes: &[] };
