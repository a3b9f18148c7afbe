//! Plays a schedule on the CPU and keeps every intermediate: the judge of the GPU, and what runs without one.

mod explain;
mod track;

pub use explain::{Explained, SeenGroup, SeenMuscle, SeenReach, Sight};

use crate::{
    dynamics::{Bodies, DynamicsParams, Particle, Simulation, Skins},
    error::PoseError,
    field::muscle::{AxisPoint, MuscleFrame, axis::half},
    normals::{self, Fans},
    rig::{FrameInputs, Pose, Rig},
    schedule::{self, Counts, FrameOptions, KernelId, Positions, Skinning, Step},
    skinning::{self, HybridInput, MuscleJointInput, SkinInput, WeightedInput},
    tracking::{Skin, SubPose, Track},
    wrap::{self, ShapeInput},
};
use glam::{Mat4, Vec4};
use std::sync::Arc;
use track::UnderWay;

/// Everything one frame produced, stage by stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The steps that were played.
    pub steps: Vec<Step>,
    /// Geometrically skinned positions, scene space, `w = 1`.
    pub skinned: Vec<Vec4>,
    /// Muscles as shaped for this frame; empty without a field.
    pub muscles: Vec<MuscleFrame>,
    /// Points of the muscles' axes.
    pub axes: Vec<AxisPoint>,
    /// Points of the muscles in motion; empty without dynamics.
    pub particles: Vec<Particle>,
    /// Matrices of the muscles' joints; empty where the skin does not follow them.
    pub muscle_joints: Vec<Mat4>,
    /// Tracked positions, or those displaced to muscles; empty without either.
    pub tracked: Vec<Vec4>,
    /// What the tracker keeps of every vertex; empty without it.
    pub tracks: Vec<Track>,
    /// Unit normals of the final positions, `w = 0`.
    pub normals: Vec<Vec4>,
}

impl Trace {
    /// The frame's final positions.
    pub fn positions(&self) -> &[Vec4] {
        if self.tracked.is_empty() { &self.skinned } else { &self.tracked }
    }
}

/// What one character's frames hand on to the next one. A clone is a checkpoint.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Muscles in motion; none where they have no dynamics.
    pub simulation: Option<Simulation>,
    /// The skin; none where it is not tracked.
    pub skin: Option<Skin>,
}

impl Motion {
    /// The start of a motion of these options.
    pub fn new(rig: &Rig, options: &FrameOptions) -> Motion {
        let counts = counts(rig);
        let moving = counts.dynamics(options);
        let tracked = options.skinning == Skinning::Implicit && counts.groups > 0;
        Motion {
            simulation: moving.map(|_| Simulation::new(Arc::new(Bodies::new(rig)))),
            skin: tracked.then(|| Skin::rest(&rig.positions_rest, rig.fold_patches.len())),
        }
    }

    /// Lets the next frame start anew, as after a teleport.
    pub fn reset(&mut self, rig: &Rig) {
        if let Some(simulation) = &mut self.simulation {
            simulation.reset();
        }
        if let Some(skin) = &mut self.skin {
            *skin = Skin::rest(&rig.positions_rest, rig.fold_patches.len());
        }
    }
}

/// The CPU side of one character.
#[derive(Clone, Copy, Debug)]
pub struct Reference<'a> {
    rig: &'a Rig,
}

impl<'a> Reference<'a> {
    /// A reference for a rig.
    pub fn new(rig: &'a Rig) -> Reference<'a> {
        Reference { rig }
    }

    /// The rig that it plays.
    pub fn rig(&self) -> &'a Rig {
        self.rig
    }

    /// Computes one frame by itself. With dynamics, muscles settle in its pose, as in the first frame of a motion.
    ///
    /// # Errors
    /// The pose is another character's or not finite.
    pub fn frame(&self, pose: &Pose, options: &FrameOptions) -> Result<Trace, PoseError> {
        let mut motion = Motion::new(self.rig, options);
        self.next(&mut motion, pose, options)
    }

    /// Computes the next frame of a motion.
    ///
    /// # Errors
    /// The pose is another character's or not finite; the motion has not changed then.
    pub fn next(&self, motion: &mut Motion, pose: &Pose, options: &FrameOptions) -> Result<Trace, PoseError> {
        self.play_where(motion, pose, options, Trace::default(), |_| true)
    }

    /// Moves the skin of a motion on to a pose over muscles that have been shaped for it.
    ///
    /// # Errors
    /// As [`Reference::next`].
    pub fn skin(
        &self,
        motion: &mut Motion,
        pose: &Pose,
        options: &FrameOptions,
        muscles: Vec<MuscleFrame>,
        axes: Vec<AxisPoint>,
    ) -> Result<Trace, PoseError> {
        let shaped = Trace { muscles, axes, ..Trace::default() };
        let options = FrameOptions { dynamics: None, ..*options };
        self.play_where(motion, pose, &options, shaped, |step| step.kernel != KernelId::MuscleShape)
    }

    /// Goes on to the next frame of a motion without its output. What comes after is the same, to the bit, as after
    /// [`Reference::next`].
    ///
    /// # Errors
    /// As [`Reference::next`].
    pub fn advance(&self, motion: &mut Motion, pose: &Pose, options: &FrameOptions) -> Result<Trace, PoseError> {
        self.play_where(motion, pose, options, Trace::default(), Step::is_of_motion)
    }

    /// Shapes the muscles of a frame again, on the axes that `motion` has now, and the skin with them: so that what
    /// follows from another side's muscles can be judged by itself. The skin of `motion` is that of the frame before, and
    /// `trace` is the frame's, played last.
    ///
    /// # Errors
    /// As [`Reference::next`].
    pub fn reshape(
        &self,
        motion: &mut Motion,
        pose: &Pose,
        options: &FrameOptions,
        trace: &mut Trace,
    ) -> Result<(), PoseError> {
        let inputs = FrameInputs::new(self.rig, pose)?;
        let mut under_way = self.lead(motion, &inputs, pose, options);
        let steps = trace.steps.clone();
        for step in steps.iter().filter(|step| !step.moves()) {
            self.play(step, &inputs, options, motion, &mut under_way, trace);
        }
        if let Some(skin) = &motion.skin {
            trace.tracks.clone_from(&skin.tracks);
        }
        Ok(())
    }

    /// The sub-poses that lead a motion's skin to a pose.
    fn lead(&self, motion: &mut Motion, inputs: &FrameInputs, pose: &Pose, options: &FrameOptions) -> UnderWay {
        let still = SubPose { groups: inputs.groups.clone(), ..SubPose::default() };
        let mut under_way = UnderWay { still, ..UnderWay::default() };
        if let Some(skin) = &mut motion.skin {
            (under_way.way, under_way.sub_poses) = skin.lead(self.rig, pose, &options.track);
        }
        under_way
    }

    /// [`Reference::next`], telling of every step before it is played: for measuring stages.
    ///
    /// # Errors
    /// The pose is another character's or not finite.
    pub fn watched(
        &self,
        motion: &mut Motion,
        pose: &Pose,
        options: &FrameOptions,
        mut watch: impl FnMut(&Step),
    ) -> Result<Trace, PoseError> {
        self.play_where(motion, pose, options, Trace::default(), |step| {
            watch(step);
            true
        })
    }

    /// Plays the chosen steps of the next frame.
    fn play_where(
        &self,
        motion: &mut Motion,
        pose: &Pose,
        options: &FrameOptions,
        mut trace: Trace,
        mut chosen: impl FnMut(&Step) -> bool,
    ) -> Result<Trace, PoseError> {
        let inputs = FrameInputs::new(self.rig, pose)?;
        let counts = counts(self.rig);
        let turns = match (&mut motion.simulation, counts.dynamics(options)) {
            (Some(simulation), Some(dynamics)) => simulation.begin(&inputs, pose.time.into(), &dynamics),
            _ => 0,
        };
        let mut under_way = self.lead(motion, &inputs, pose, options);
        trace.steps.clear();
        for step in schedule::frame(&counts, options, turns, under_way.way.count) {
            if chosen(&step) {
                self.play(&step, &inputs, options, motion, &mut under_way, &mut trace);
                trace.steps.push(step);
            }
        }
        if let Some(simulation) = &mut motion.simulation {
            simulation.axes.clone_from(&trace.axes);
            trace.particles.clone_from(&simulation.particles);
        }
        if let Some(skin) = &motion.skin {
            trace.tracks.clone_from(&skin.tracks);
        }
        Ok(trace)
    }

    /// Plays one step: reads what earlier steps left in `trace`, and adds its own result.
    fn play(
        &self,
        step: &Step,
        inputs: &FrameInputs,
        options: &FrameOptions,
        motion: &mut Motion,
        under_way: &mut UnderWay,
        trace: &mut Trace,
    ) {
        let rig = self.rig;
        let skin = SkinInput {
            joints: &inputs.joints,
            positions_rest: &rig.positions_rest,
            offsets: &rig.character.influence_offsets,
            influences: &rig.character.influences,
        };
        let vertices = rig.character.vertex_count();
        match step.kernel {
            KernelId::SkinLinear => {
                trace.skinned.resize(vertices, Vec4::ZERO);
                skinning::linear(&skin, &mut trace.skinned);
            }
            KernelId::SkinDualQuaternion => {
                trace.skinned.resize(vertices, Vec4::ZERO);
                skinning::dual_quaternion(&skin, &mut trace.skinned);
            }
            KernelId::SkinWeighted => {
                trace.tracked.resize(vertices, Vec4::ZERO);
                let input = WeightedInput {
                    joints: &inputs.joints,
                    muscles: &trace.muscles,
                    axes: &trace.axes,
                    targets: &rig.weights.vertices,
                    weights: &rig.weights.weights,
                    skinned: &trace.skinned,
                };
                skinning::weighted(&input, &mut trace.tracked);
            }
            KernelId::MuscleJoint => {
                trace.muscle_joints.resize(rig.point_count as usize, Mat4::IDENTITY);
                let input = MuscleJointInput {
                    joints: &inputs.joints,
                    muscles_rest: &rig.muscles,
                    joints_rest: &rig.muscle_joints.joints,
                    muscles: &trace.muscles,
                    axes: &trace.axes,
                };
                skinning::muscle_joints(&input, &mut trace.muscle_joints);
            }
            KernelId::SkinHybrid => {
                trace.skinned.resize(vertices, Vec4::ZERO);
                let input = HybridInput {
                    joints: &inputs.joints,
                    muscle_joints: &trace.muscle_joints,
                    positions_rest: &rig.positions_rest,
                    offsets: &rig.muscle_joints.offsets,
                    influences: &rig.muscle_joints.influences,
                };
                skinning::hybrid(&input, &mut trace.skinned);
            }
            KernelId::MuscleShape => {
                trace.muscles.resize(rig.muscles.len(), MuscleFrame::default());
                trace.axes.resize(rig.point_count as usize, AxisPoint::default());
                let half = half(rig.muscles.len() as u32, rig.point_count);
                let iterates = motion.simulation.as_ref().map_or(&[][..], |s| &s.iterates[..half]);
                let input = ShapeInput { joints: &inputs.joints, inputs: &inputs.muscles, iterates, wraps: &rig.wraps };
                wrap::shape(&rig.muscles, &input, &mut trace.muscles, &mut trace.axes);
            }
            KernelId::GroupBound
            | KernelId::TrackStart
            | KernelId::TrackCarry
            | KernelId::TrackPlace
            | KernelId::TrackFold
            | KernelId::TrackMarch
            | KernelId::TrackTurn
            | KernelId::TrackSpan
            | KernelId::TrackSlide
            | KernelId::TrackAverage
            | KernelId::TrackSpread => {
                if let Some(skin) = &mut motion.skin {
                    self.track(step, options, skin, under_way, trace);
                }
            }
            KernelId::Normals => {
                trace.normals.resize(vertices, Vec4::ZERO);
                let fans =
                    Fans { triangles: &rig.topology.corners, fans: &rig.topology.fans, members: &rig.topology.members };
                let positions = match step.reads {
                    Some(Positions::Tracked) => &trace.tracked,
                    _ => &trace.skinned,
                };
                normals::from_faces(&fans, positions, &mut trace.normals);
            }
            KernelId::JointStep | KernelId::MusclePredict | KernelId::MuscleProject => {
                let counts = counts(rig);
                if let (Some(simulation), Some(dynamics)) = (&mut motion.simulation, counts.dynamics(options)) {
                    let params = DynamicsParams::new(&counts, 1, counts.joints, &dynamics, step.outer);
                    match step.kernel {
                        KernelId::JointStep => simulation.step_joints(step.carries),
                        KernelId::MusclePredict => simulation.predict(&params, inputs),
                        _ => simulation.project(&params, Skins::of(rig)),
                    }
                }
            }
            KernelId::FieldSample | KernelId::MuscleSample | KernelId::OperatorSample => {}
        }
    }
}

/// Sizes of a rig that schedules depend on.
fn counts(rig: &Rig) -> Counts {
    Counts {
        vertices: rig.character.vertex_count() as u32,
        marched: rig.targets.marched.len() as u32,
        joints: rig.character.joints.len() as u32,
        reaches: rig.targets.reaches.len() as u32,
        folds: rig.fold_patches.len() as u32,
        muscles: rig.muscles.len() as u32,
        points: rig.point_count,
        most_segments: rig.most_segments(),
        groups: rig.grids.len() as u32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        clip::Scene,
        rig::{BuildOptions, muscle_file},
        schedule::DynamicsOptions,
    };
    use std::path::Path;

    pub(super) fn arm() -> (Scene, Rig, FrameOptions) {
        let scene = crate::io::gltf::from_bytes(include_bytes!("../assets/arm.glb"), "arm").expect("the arm");
        let text = include_str!("../assets/arm.muscles.toml");
        let file = muscle_file::parse(text, Path::new("arm.muscles.toml")).expect("good");
        let rig = Rig::build(scene.character.clone(), &file.muscles, &BuildOptions::default()).expect("a rig");
        (scene, rig, FrameOptions { dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() })
    }

    pub(super) fn pose(scene: &Scene, frame: u32) -> Pose {
        scene.pose(scene.choose_clip(Some("shake")).expect("the clip"), frame as f32 / 30.0)
    }

    #[test]
    fn a_clone_goes_on_as_its_original_does() {
        let (scene, rig, options) = arm();
        let reference = Reference::new(&rig);
        let mut motion = Motion::new(&rig, &options);
        let mut saved = Vec::new();
        for frame in 0..=10 {
            reference.advance(&mut motion, &pose(&scene, frame), &options).expect("a frame");
            saved.push(motion.clone());
        }
        let on = |mut motion: Motion| {
            let frames = (11..15).map(|frame| reference.next(&mut motion, &pose(&scene, frame), &options));
            frames.collect::<Result<Vec<Trace>, _>>().expect("frames")
        };
        let expected = on(motion);
        assert!(on(saved[10].clone()) == expected);
        assert!(on(saved[9].clone()) != expected, "a checkpoint of another frame must be seen");
    }

    #[test]
    fn what_is_passed_over_leaves_the_same_motion() {
        let (scene, rig, options) = arm();
        let reference = Reference::new(&rig);
        let play = |passed: std::ops::Range<u32>| {
            let mut motion = Motion::new(&rig, &options);
            let mut last = None;
            for frame in 0..=12 {
                let pose = pose(&scene, frame);
                let trace = match passed.contains(&frame) {
                    true => reference.advance(&mut motion, &pose, &options),
                    false => reference.next(&mut motion, &pose, &options),
                };
                last = Some(trace.expect("a frame"));
            }
            last.expect("a frame")
        };
        let expected = play(0..0);
        assert!(play(0..12) == expected && play(4..9) == expected);
        let passed = play(0..13);
        assert!((passed.muscles == expected.muscles) && passed.tracked.is_empty() && passed.skinned.is_empty());
    }

    #[test]
    fn a_frame_is_shaped_again_on_other_axes() {
        let (scene, rig, options) = arm();
        let reference = Reference::new(&rig);
        let mut motion = Motion::new(&rig, &options);
        let expected = reference.next(&mut motion, &pose(&scene, 0), &options).expect("a frame");
        let mut trace = expected.clone();
        let mut again = |motion: &mut Motion| {
            motion.skin = Some(Skin::rest(&rig.positions_rest, rig.fold_patches.len()));
            reference.reshape(motion, &pose(&scene, 0), &options, &mut trace).expect("a frame");
            trace.clone()
        };
        assert!(again(&mut motion) == expected, "the same axes");
        let simulation = motion.simulation.as_mut().expect("dynamics");
        simulation.iterates[20] += Vec4::new(0.0, 0.0, 0.01, 0.0);
        let other = again(&mut motion);
        assert!(other.axes != expected.axes && other.tracked != expected.tracked, "an axis a centimetre off");
        assert!(other.particles == expected.particles && other.skinned == expected.skinned);
    }
}
