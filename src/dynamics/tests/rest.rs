//! The rest pose stays at rest.

use super::arm::Actor;
use crate::reference::{Motion, Reference};
use crate::rig::{Around, BuildOptions, Pose, Rig, Wrap};
use crate::schedule::{DynamicsOptions, FrameOptions};

/// Farthest that any vertex is from its place at rest in a second of the rest pose at 30 fps, metres.
fn strays(rig: &Rig, frames: u32) -> f32 {
    let options = FrameOptions { dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() };
    let reference = Reference::new(rig);
    let mut motion = Motion::new(rig, &options);
    let mut most = 0.0f32;
    for frame in 0..=frames {
        let mut pose = Pose::rest(&rig.character);
        pose.time = frame as f32 / 30.0;
        let trace = reference.next(&mut motion, &pose, &options).expect("a frame");
        let pairs = trace.positions().iter().zip(&rig.positions_rest);
        most = pairs.fold(most, |m, (p, q)| m.max(p.truncate().distance(q.truncate())));
    }
    most
}

fn settled(mut actor: Actor) -> Rig {
    super::settle(&mut actor.rig, &DynamicsOptions::default());
    actor.rig
}

#[test]
fn skin_stays_where_it_is_in_the_rest_pose() {
    let Some(arm) = Actor::arm(None, &[]) else { return };
    let mut rig = settled(arm);
    let still = strays(&rig, 30);
    println!("the arm's skin strays by {still} m in the rest pose");
    assert!(still < 1e-5, "{still} m");
    // The same axes, but not the contacts that hold them.
    let axes: Vec<_> = rig.muscles_at_rest().1.iter().map(|p| p.position.truncate()).collect();
    rig.set_axes_rest(&axes);
    let loose = strays(&rig, 30);
    println!("without the settled contacts it strays by {loose} m");
    assert!(loose > 1e-4, "without the contacts as they were it moves: {loose} m");
}

#[test]
fn skin_stays_where_muscles_lie_round_a_joint() {
    let Some(arm) = Actor::arm(None, &[]) else { return };
    let mut muscles = arm.rig.specs.clone();
    for muscle in muscles.iter_mut().filter(|m| m.name.starts_with("triceps")) {
        let around = Around::Joint("lowerarm_l".into());
        muscle.wrap = Some(Wrap { around, radius: 0.022, side: Some(glam::Vec3::new(0.0, 0.0, -0.1)) });
    }
    let rig = Rig::build(arm.scene.character.clone(), &muscles, &BuildOptions::default()).expect("a rig");
    let still = strays(&settled(Actor { rig, ..arm }), 30);
    println!("with muscles round the elbow the arm's skin strays by {still} m in the rest pose");
    assert!(still < 1e-5, "{still} m");
}

#[test]
fn the_skin_of_a_whole_body_stays_too() {
    let Some(body) = Actor::new("mh_male_athletic", None, &[]) else { return };
    let still = strays(&settled(body), 6);
    println!("the body's skin strays by {still} m in the rest pose");
    assert!(still < 1e-5, "{still} m");
}
