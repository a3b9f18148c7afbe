//! Volume of muscles in motion.

use super::arm::Actor;
use crate::field::muscle::{AxisPoint, MuscleFrame, evaluate};
use crate::reference::{Motion, Reference};
use crate::rig::FrameInputs;
use crate::schedule::{DynamicsOptions, FrameOptions};
use glam::{Mat3, Vec3, Vec4Swizzles};
use rayon::prelude::*;

/// Edge of the cells that volumes are counted in, metres.
const CELL: f32 = 2.5e-3;

/// Volume inside the surface of a muscle's field, cubic metres: cells that the surface cuts count by its distance from
/// their middle. A muscle's mesh would not do where its sections turn quickly: its triangles cut them short.
fn volume(muscle: &MuscleFrame, points: &[AxisPoint]) -> f64 {
    // In a box along the chord.
    let (start, end) = (points[0].position.xyz(), points[points.len() - 1].position.xyz());
    let along = (end - start).normalize();
    let across = along.any_orthonormal_vector();
    let turn = Mat3::from_cols(across, along.cross(across), along);
    let turned = points.iter().map(|p| turn.transpose() * p.position.xyz());
    let (low, high) = turned.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let most = (0..=40).map(|i| muscle.radius(i as f32 / 40.0, 1.0)).fold(0.0, f32::max) + CELL;
    let counts = ((high - low + 2.0 * most) / CELL).as_uvec3();
    let at = |i: u32, j: u32, k: u32| turn * (low - most + (glam::UVec3::new(i, j, k).as_vec3() + 0.5) * CELL);
    let inside = |q: Vec3| {
        let found = evaluate(muscle, points, q);
        let slope = found.gradient.length().max(1e-6);
        f64::from((0.5 + (found.value - 0.5) / (slope * CELL)).clamp(0.0, 1.0))
    };
    let row = |j: u32, k: u32| -> f64 { (0..=counts.x).map(|i| inside(at(i, j, k))).sum() };
    let slice = |k: u32| -> f64 { (0..=counts.y).map(|j| row(j, k)).sum() };
    (0..=counts.z).map(slice).sum::<f64>() * f64::from(CELL).powi(3)
}

/// Largest deviation of any muscle's volume from what it is to have, seen every `every`th frame of a clip at 30 fps; muscles
/// are made `wider` by a factor.
fn deviation(actor: &Actor, clip: &str, frames: u32, every: u32, options: &DynamicsOptions, wider: f32) -> f64 {
    let options = FrameOptions { dynamics: Some(*options), ..FrameOptions::default() };
    let reference = Reference::new(&actor.rig);
    let mut motion = Motion::new(&actor.rig, &options);
    let mut most = 0.0f64;
    for frame in 0..=frames {
        let choice = actor.scene.choose_clip(Some(clip)).expect("the clip");
        let pose = actor.scene.pose(choice, frame as f32 / 30.0);
        let trace = reference.advance(&mut motion, &pose, &options).expect("a frame");
        if frame % every != 0 {
            continue;
        }
        let inputs = FrameInputs::new(&actor.rig, &pose).expect("a pose").muscles;
        let all: Vec<_> = actor.rig.muscles.iter().zip(&trace.muscles).zip(&inputs).collect();
        let one = all.into_par_iter().map(|((rest, muscle), input)| {
            let wanted = f64::from(rest.origin.w) * f64::from(input.width).powi(2);
            let muscle = MuscleFrame { width: muscle.width * wider, ..*muscle };
            (volume(&muscle, muscle.points(&trace.axes)) / wanted - 1.0).abs()
        });
        most = one.reduce(|| most, f64::max);
    }
    most
}

#[test]
fn muscles_in_motion_keep_their_volume() {
    let Some(arm) = Actor::arm(None, &[]) else { return };
    for (clip, frequency) in [("biceps_curl", 12.0), ("arm_shake", 6.0), ("arm_shake", 24.0)] {
        let options = DynamicsOptions { frequency, ..DynamicsOptions::default() };
        let found = deviation(&arm, clip, 45, 9, &options, 1.0);
        println!("{clip} at {frequency} Hz: volumes are off by {:.2} % at most", 100.0 * found);
        assert!(found < 0.01, "{clip} at {frequency} Hz: {found}");
    }
    let wider = deviation(&arm, "biceps_curl", 0, 1, &DynamicsOptions::default(), 1.01);
    assert!(wider > 0.01, "muscles 1 % wider must be seen: {wider}");
}

#[test]
fn so_do_those_of_a_walk() {
    let Some(body) = Actor::new("mh_male_athletic", None, &[]) else { return };
    let found = deviation(&body, "walk", 36, 18, &DynamicsOptions::default(), 1.0);
    println!("walk: volumes are off by {:.2} % at most", 100.0 * found);
    assert!(found < 0.01, "{found}");
}
