//! The built-in arm's muscles in motion: on the CPU, and the poses that they are taken through.

use super::Arm;
use crate::dynamics::{Simulation, Skins};
use crate::error::FigureError;
use crate::field::muscle::{MuscleFrame, axis::half};
use crate::rig::{ColliderShape, FrameInputs, Pose, Rig};
use crate::schedule::DynamicsOptions;
use crate::wrap::{self, ShapeInput};
use glam::Vec3;
use std::sync::Arc;

/// The muscle whose bulge is looked at, and the bone under it.
pub(super) const BICEPS: &str = "biceps";
const HUMERUS: &str = "upperarm";
/// What bends the elbow.
const FLEXORS: [&str; 3] = [BICEPS, "brachialis", "brachioradialis"];
/// Frames a second.
pub(super) const FPS: f32 = 30.0;
/// Frames for which a pose is held until nothing moves: a second.
const HELD: u32 = 30;

/// Muscles of a rig on their way through poses.
#[derive(Clone)]
pub(super) struct Play<'a> {
    rig: &'a Rig,
    options: DynamicsOptions,
    /// Their state after the last pose.
    pub simulation: Simulation,
    /// What the last pose came to.
    pub inputs: FrameInputs,
    /// The muscles in it, each in the space of its field group at rest; points of their axes are the simulation's.
    pub shaped: Vec<MuscleFrame>,
}

impl<'a> Play<'a> {
    /// Nothing has moved yet.
    pub fn new(rig: &'a Rig, options: &DynamicsOptions) -> Play<'a> {
        let simulation = Simulation::new(Arc::new(crate::dynamics::Bodies::new(rig)));
        let shaped = vec![MuscleFrame::default(); rig.muscles.len()];
        Play { rig, options: *options, simulation, inputs: FrameInputs::default(), shaped }
    }

    /// Goes on to a pose.
    pub fn next(&mut self, pose: &Pose) -> Result<(), FigureError> {
        self.advance(pose)?;
        self.shape();
        Ok(())
    }

    /// Moves the muscles on to a pose; [`Play::shape`] is to follow.
    pub fn advance(&mut self, pose: &Pose) -> Result<(), FigureError> {
        self.inputs = FrameInputs::new(self.rig, pose)?;
        self.simulation.advance(Skins::of(self.rig), &self.inputs, pose.time.into(), &self.options);
        Ok(())
    }

    /// Gives the muscles their shape along their axes.
    pub fn shape(&mut self) {
        let muscles = &self.rig.muscles;
        let half = half(muscles.len() as u32, self.rig.point_count);
        let FrameInputs { joints, muscles: inputs, .. } = &self.inputs;
        let wraps = &self.simulation.bodies.wraps;
        let input = ShapeInput { joints, inputs, iterates: &self.simulation.iterates[..half], wraps };
        wrap::shape(muscles, &input, &mut self.shaped, &mut self.simulation.axes);
    }
}

/// The pose, and then the same until nothing moves.
pub(super) fn held(pose: &Pose) -> impl Iterator<Item = Pose> {
    let pose = pose.clone();
    (0..=HELD).map(move |k| Pose { time: pose.time + k as f32 / FPS, ..pose.clone() })
}

/// The pose with the elbow's flexors activated in full, and nothing else.
pub(super) fn activated(rig: &Rig, pose: Pose) -> Pose {
    let activation = |name: &str| if FLEXORS.contains(&name) { 1.0 } else { 0.0 };
    Pose { activations: rig.specs.iter().map(|spec| activation(&spec.name)).collect(), ..pose }
}

/// From the stretched arm to the bent one, activated all the way, and held there.
pub(super) fn flexed(arm: &Arm) -> Vec<Pose> {
    let Some((last, before)) = arm.curl.split_last() else { return Vec::new() };
    before.iter().cloned().chain(held(last)).map(|pose| activated(&arm.rig, pose)).collect()
}

/// A muscle of a rig, by its name.
pub(super) fn muscle(rig: &Rig, name: &str) -> Option<usize> {
    rig.muscle_names.iter().position(|n| n == name)
}

/// A bone's ends in a pose, scene space, and its radius; metres.
pub(super) fn capsule(rig: &Rig, pose: &Pose, joint: usize) -> Option<([Vec3; 2], f32)> {
    let bone = rig.bones.iter().find(|bone| bone.joint as usize == joint)?;
    let ColliderShape::Capsule { from, to, radius } = bone.shape else { return None };
    let to_posed = *pose.palette.get(joint)? * rig.character.joints[joint].bind();
    Some(([from, to].map(|p| to_posed.transform_point3(p)), radius))
}

/// The upper arm's bone: see [`capsule`].
pub(super) fn humerus(rig: &Rig, pose: &Pose) -> Option<([Vec3; 2], f32)> {
    capsule(rig, pose, rig.character.joints.iter().position(|j| j.name == HUMERUS)?)
}

/// From a line to a point, square to it.
pub(super) fn away([from, to]: [Vec3; 2], point: Vec3) -> Vec3 {
    (point - from).reject_from(to - from)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::rig::{BuildOptions, muscle_file};
    use std::path::Path;

    impl Play<'_> {
        /// Goes through poses.
        pub fn all(&mut self, poses: &[Pose]) -> Result<(), FigureError> {
            poses.iter().try_for_each(|pose| self.next(pose))
        }
    }

    /// The built-in arm, as the command makes it.
    pub fn arm() -> Arm {
        let scene = crate::io::gltf::from_bytes(include_bytes!("../../assets/arm.glb"), "arm").expect("the arm");
        let text = include_str!("../../assets/arm.muscles.toml");
        let file = muscle_file::parse(text, Path::new("arm.muscles.toml")).expect("good");
        let rig = Rig::build(scene.character.clone(), &file.muscles, &BuildOptions::default()).expect("a rig");
        let mut settled = rig.clone();
        crate::dynamics::settle(&mut settled, &DynamicsOptions::default());
        let poses = |name, frames: u32| {
            let clip = scene.choose_clip(Some(name)).expect("the clip");
            (0..=frames).map(|k| scene.pose(clip, k as f32 / FPS)).collect()
        };
        Arm { rig: Arc::new(rig), settled: Arc::new(settled), curl: poses("curl", 30), shake: poses("shake", 60) }
    }

    #[test]
    fn a_held_pose_comes_to_rest_and_the_way_there_does_not() {
        let arm = arm();
        let poses = flexed(&arm);
        let mut play = Play::new(&arm.settled, &DynamicsOptions::default());
        let fastest =
            |play: &Play| play.simulation.particles.iter().map(|p| p.velocity.truncate().length()).fold(0.0, f32::max);
        play.all(&poses[..25]).expect("frames");
        assert!(fastest(&play) > 0.1, "{} m/s", fastest(&play));
        play.all(&poses[25..]).expect("frames");
        assert!(fastest(&play) < 2e-3, "{} m/s", fastest(&play));
    }
}
