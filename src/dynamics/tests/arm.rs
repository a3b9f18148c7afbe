//! Real characters: what touches stays out, what is held comes to rest.

use super::*;
use crate::field::muscle::axis::half;
use crate::rig::{BuildOptions, Pose, Rig, muscle_file};
use crate::schedule::{Contacts, DynamicsOptions, Solver};
use glam::Vec4Swizzles;
use std::path::Path;
use std::sync::Arc;

/// A character of the test data with the muscles of its fixture.
pub struct Actor {
    pub scene: crate::clip::Scene,
    pub rig: Rig,
    pub bodies: Arc<Bodies>,
}

impl Actor {
    /// `keep` chooses muscles by parts of their names, all where it is empty; they collide with one another in `group`, or
    /// in the fixture's own groups.
    pub fn new(file: &str, group: Option<&str>, keep: &[&str]) -> Option<Actor> {
        let data = std::env::var_os("SINEW_DATA").map(std::path::PathBuf::from)?;
        let scene = crate::io::gltf::read(&data.join(format!("humans/{file}.glb"))).expect("the character");
        let path = format!("{}/kernels-tests/fixtures/{file}.muscles.toml", env!("CARGO_MANIFEST_DIR"));
        let mut muscles = muscle_file::read(Path::new(&path)).expect("the fixture").muscles;
        muscles.retain(|m| keep.is_empty() || keep.iter().any(|k| m.name.contains(k)));
        muscles.iter_mut().for_each(|m| m.collision_group = group.map_or(m.collision_group.clone(), String::from));
        let rig = Rig::build(scene.character.clone(), &muscles, &BuildOptions::default()).expect("a rig");
        let bodies = Arc::new(Bodies::new(&rig));
        Some(Actor { scene, rig, bodies })
    }

    pub fn arm(group: Option<&str>, keep: &[&str]) -> Option<Actor> {
        Actor::new("arm_nohand_dense_2172", group, keep)
    }

    pub fn inputs(&self, clip: &str, time: f64, activation: Option<f32>) -> FrameInputs {
        let clip = self.scene.choose_clip(Some(clip)).expect("the clip");
        let mut pose: Pose = self.scene.pose(clip, time as f32);
        pose.activations = activation.map(|a| vec![a; self.rig.specs.len()]).unwrap_or_default();
        FrameInputs::new(&self.rig, &pose).expect("a pose")
    }

    pub fn frame(&self, simulation: &mut Simulation, inputs: &FrameInputs, time: f64, options: &DynamicsOptions) {
        simulation.advance(Skins::of(&self.rig), inputs, time, options);
    }

    /// Plays `biceps_curl` to where the elbow is bent by 130 degrees, holds it for 1.6 s, and gives the inputs there.
    fn held(&self, activation: f32, options: &DynamicsOptions) -> (Simulation, FrameInputs) {
        let mut simulation = Simulation::new(Arc::clone(&self.bodies));
        let bent = self.inputs("biceps_curl", 43.0 / 30.0, Some(activation));
        for k in 0..=91 {
            let time = f64::from(k) / 30.0;
            let inputs = if k < 43 { self.inputs("biceps_curl", time, Some(activation)) } else { bent.clone() };
            self.frame(&mut simulation, &inputs, time, options);
        }
        (simulation, bent)
    }

    /// Farthest that any particle is from where it was at first, in one more second, metres, seen every substep.
    fn wander(&self, simulation: &mut Simulation, inputs: &FrameInputs, options: &DynamicsOptions) -> f32 {
        let before: Vec<Vec3> = simulation.particles.iter().map(|p| p.position.xyz()).collect();
        let mut most = 0.0f32;
        for k in 1..=240 {
            self.frame(simulation, inputs, 91.0 / 30.0 + f64::from(k) / 240.0, options);
            let pairs = simulation.particles.iter().zip(&before);
            most = pairs.fold(most, |m, (p, q)| m.max(p.position.xyz().distance(*q)));
        }
        most
    }

    fn measure(&self, simulation: &Simulation, inputs: &FrameInputs) -> Measured {
        let half = half(self.bodies.muscles.len() as u32, simulation.particles.len() as u32);
        let depths = depths(&self.bodies, Skins::of(&self.rig), &inputs.joints, &simulation.iterates[..half]);
        let most = |value: fn(&Depth) -> f32| depths.iter().map(value).fold(0.0, f32::max);
        let mut found = Measured { outside: most(|d| d.outside), overlap: most(|d| d.muscle), ..Measured::default() };
        for muscle in &self.bodies.muscles {
            let own = muscle.first_point as usize..=(muscle.first_point + muscle.segments) as usize;
            let (own, depths) = (&simulation.particles[own.clone()], &depths[own]);
            let (n, start) = (own.len() - 1, own[0].position.xyz());
            let end = own[n].position.xyz();
            for (i, particle) in own.iter().enumerate().filter(|(_, p)| p.traits.x >= 1.0) {
                found.bow = found.bow.max(particle.position.xyz().distance(start.lerp(end, i as f32 / n as f32)));
                found.speed = found.speed.max(particle.velocity.xyz().length());
                found.bones.push((depths[i].bone / depths[i].radius, depths[i].bone));
            }
        }
        found
    }

    /// What all frames of a clip at 30 fps measure together, `from` the first one on.
    fn played(&self, clip: &str, frames: std::ops::Range<u32>, options: &DynamicsOptions) -> Measured {
        let mut simulation = Simulation::new(Arc::clone(&self.bodies));
        let mut all = Measured::default();
        for k in 0..frames.end {
            let time = f64::from(k) / 30.0;
            let inputs = self.inputs(clip, time, None);
            self.frame(&mut simulation, &inputs, time, options);
            if frames.contains(&k) {
                all.join(self.measure(&simulation, &inputs));
            }
        }
        all
    }
}

/// What particles outside the tendons do.
#[derive(Default, Debug)]
struct Measured {
    /// Depth in bones: share of the radius, and metres.
    bones: Vec<(f32, f32)>,
    /// Farthest outside the skin, metres.
    outside: f32,
    /// Deepest in another muscle, metres.
    overlap: f32,
    /// Fastest, m/s.
    speed: f32,
    /// Farthest from the straight axis, metres.
    bow: f32,
}

impl Measured {
    fn join(&mut self, other: Measured) {
        self.bones.extend(other.bones);
        self.outside = self.outside.max(other.outside);
        self.overlap = self.overlap.max(other.overlap);
        self.bow = self.bow.max(other.bow);
    }

    /// Share of the radius that 95 % of the particles are in bones at most, and the deepest one: share and metres.
    fn depths(&mut self) -> (f32, (f32, f32)) {
        self.bones.sort_by(|a, b| a.0.total_cmp(&b.0));
        let at = |q: f32| self.bones[((self.bones.len() - 1) as f32 * q) as usize];
        (at(0.95).0, at(1.0))
    }
}

pub fn one_by_one() -> DynamicsOptions {
    let contacts = Contacts { muscles: false, ..Contacts::ALL };
    DynamicsOptions { contacts, ..DynamicsOptions::default() }
}

#[test]
fn a_held_curl_comes_to_rest() {
    let Some(arm) = Actor::arm(Some(""), &[]) else { return };
    for solver in [Solver::RedBlack, Solver::Jacobi] {
        for activation in [0.0, 1.0] {
            let options = DynamicsOptions { solver, ..one_by_one() };
            let (simulation, inputs) = arm.held(activation, &options);
            let mut found = arm.measure(&simulation, &inputs);
            assert!(found.speed < 1e-3, "{solver:?} {activation}: {} m/s", found.speed);
            assert!(found.depths().1.0 < 0.02 && found.outside < 1e-4, "{found:?}");
            assert!(found.bow > 5e-3, "bones push it aside by {}", found.bow);
        }
    }
}

#[test]
fn muscles_that_press_on_one_another_come_to_rest() {
    let Some(arm) = Actor::arm(None, &[]) else { return };
    let options = DynamicsOptions::default();
    // Wander and overlap with the deadband and without it, side by side.
    let sides = [options, DynamicsOptions { deadband: 0.0, ..options }];
    let rests = |arm: &Actor, activation: f32, options: &DynamicsOptions| {
        let (mut simulation, inputs) = arm.held(activation, options);
        let wander = arm.wander(&mut simulation, &inputs, options);
        (wander, arm.measure(&simulation, &inputs).overlap)
    };
    for activation in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let found = sides.each_ref().map(|options| rests(&arm, activation, options));
        println!("held curl, activation {activation}, with the deadband and without: wander and overlap {found:?} m");
        assert!(found.iter().all(|(wander, overlap)| *wander < 1e-4 && *overlap < 2.5e-3), "{activation}: {found:?}");
    }
    let curl = arm.played("biceps_curl", 0..60, &options);
    assert!(curl.overlap < 2.5e-3, "overlap {} m over the curl", curl.overlap);
    // All in one group press harder, and without play it never ends.
    let crowd = Actor::arm(Some("arm"), &[]).expect("as above");
    for activation in [0.0, 1.0] {
        let found = sides.each_ref().map(|options| rests(&crowd, activation, options));
        println!("all in one group, activation {activation}, with the deadband and without: {found:?} m");
    }
    let (wander, _) = rests(&crowd, 0.0, &DynamicsOptions { play: 0.0, deadband: 0.0, ..options });
    println!("all in one group, without play and deadband: wanders {wander} m");
    assert!(wander > 5e-4, "without play it rests: {wander} m");
}

#[test]
fn muscles_stay_out_of_bones_and_in_the_skin() {
    let Some(arm) = Actor::arm(Some(""), &[]) else { return };
    let mut curl = arm.played("biceps_curl", 0..60, &one_by_one());
    let (_, deepest) = curl.depths();
    assert!(deepest.0 <= 0.02 && curl.outside <= 1e-4, "curl: {deepest:?} {}", curl.outside);
    for frequency in [6.0, 12.0, 24.0] {
        let mut shake = arm.played("arm_shake", 0..60, &DynamicsOptions { frequency, ..one_by_one() });
        let (most, deepest) = shake.depths();
        println!("arm_shake at {frequency} Hz: {} m off the straight axis", shake.bow);
        assert!(most <= 0.02 && (deepest.0 <= 0.03 || deepest.1 <= 2e-4), "{frequency} Hz: {most} {deepest:?}");
        assert!(shake.outside <= 1e-4, "{frequency} Hz: {}", shake.outside);
    }
    let contacts = Contacts::NONE;
    let mut through = arm.played("arm_shake", 0..60, &DynamicsOptions { contacts, frequency: 6.0, ..one_by_one() });
    let deepest = through.depths().1;
    assert!(deepest.0 > 0.2 && through.outside > 1e-3, "without contacts they do not: {deepest:?} {}", through.outside);
}

#[test]
fn a_whole_body_walks_and_jumps() {
    let Some(body) = Actor::new("mh_male_athletic", Some(""), &[]) else { return };
    // Shares of the radius, and the metres that may be more than that.
    for (clip, bound, least) in [("walk", 0.02, 0.0), ("jump", 0.03, 2e-4)] {
        let mut found = body.played(clip, 0..36, &one_by_one());
        let (most, deepest) = found.depths();
        println!("{clip}: p95 {most}, deepest {deepest:?}, outside {}", found.outside);
        assert!(most <= 0.02 && (deepest.0 <= bound || deepest.1 <= least), "{clip}: {most} {deepest:?}");
        assert!(found.outside <= 1e-4, "{clip}: {}", found.outside);
    }
}

/// Farthest of the biceps' surface from the upper arm's bone, metres.
fn height(arm: &Actor, simulation: &Simulation, inputs: &FrameInputs) -> f32 {
    let index = arm.rig.muscle_names.iter().position(|n| n.starts_with("biceps")).expect("the biceps");
    let muscle = &arm.bodies.muscles[index];
    let bone = arm.bodies.bones.iter().find(|b| arm.rig.character.joints[b.joint as usize].name == "upperarm_l");
    let bone = bone.expect("a humerus");
    let matrix = inputs.joints[bone.joint as usize].matrix;
    let [start, end] = [bone.start, bone.end].map(|p| matrix.transform_point3(p.xyz()));
    let own = &simulation.particles[muscle.first_point as usize..][..=muscle.segments as usize];
    let away = |p: &Particle| {
        let axis = (end - start).normalize();
        let offset = p.position.xyz() - start;
        (offset - axis * offset.dot(axis)).length() + p.position.w
    };
    own.iter().map(away).fold(0.0, f32::max)
}

#[test]
fn a_bone_raises_the_muscle_on_it() {
    let Some(arm) = Actor::arm(Some(""), &[]) else { return };
    let through = DynamicsOptions { contacts: Contacts::NONE, ..one_by_one() };
    let stretched = {
        let mut simulation = Simulation::new(Arc::clone(&arm.bodies));
        let inputs = arm.inputs("biceps_curl", 0.0, Some(0.0));
        arm.frame(&mut simulation, &inputs, 0.0, &through);
        height(&arm, &simulation, &inputs)
    };
    let [with, without] = [one_by_one(), through].map(|options| {
        let (simulation, inputs) = arm.held(1.0, &options);
        height(&arm, &simulation, &inputs)
    });
    println!(
        "the biceps' surface is {with} m from the bone's axis with bones, {without} m without; {stretched} m stretched"
    );
    assert!(with - without >= 8e-3, "{with} {without}");
    // It rises with bones, and sinks without them.
    assert!(
        with - stretched >= 8e-3 && with - stretched >= 1.5 * (without - stretched),
        "{with} {without} {stretched}"
    );
}
