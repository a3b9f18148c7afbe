//! Volume of muscles in motion.

use super::arm::Actor;
use crate::field::muscle::{MuscleFrame, volume};
use crate::reference::{Motion, Reference};
use crate::rig::FrameInputs;
use crate::schedule::{DynamicsOptions, FrameOptions};
use rayon::prelude::*;

/// Edge of the cells that volumes are counted in, metres.
const CELL: f32 = 1.8e-3;

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
            (volume(&muscle, muscle.points(&trace.axes), CELL) / wanted - 1.0).abs()
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
