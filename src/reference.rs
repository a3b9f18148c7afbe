//! Plays a schedule on the CPU and keeps every intermediate: the judge of the GPU, and what runs without one.

use crate::{
    dynamics::{Bodies, DynamicsParams, Particle, Simulation, Skins},
    error::PoseError,
    field::muscle::{AxisPoint, MuscleFrame, axis::half},
    normals::{self, Fans},
    rig::{FrameInputs, Pose, Rig},
    schedule::{self, Counts, FrameOptions, KernelId, Positions, Step},
    skinning::{self, SkinInput},
    tracking::{self, FieldInput, MarchParams, MarchReport},
    wrap::{self, ShapeInput},
};
use glam::Vec4;
use std::sync::Arc;

/// Everything one frame produced, stage by stage.
#[derive(Clone, Debug, PartialEq)]
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
    /// Marched positions; empty without a march.
    pub tracked: Vec<Vec4>,
    /// How each vertex's march ended; empty without a march.
    pub reports: Vec<MarchReport>,
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
}

impl Motion {
    /// The start of a motion of these options.
    pub fn new(rig: &Rig, options: &FrameOptions) -> Motion {
        let moving = counts(rig).dynamics(options);
        Motion { simulation: moving.map(|_| Simulation::new(Arc::new(Bodies::new(rig)))) }
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
        self.play_where(motion, pose, options, |_| true)
    }

    /// Goes on to the next frame of a motion without its skin: only muscles are moved and shaped. What comes after is the
    /// same, to the bit, as after [`Reference::next`].
    ///
    /// # Errors
    /// As [`Reference::next`].
    pub fn advance(&self, motion: &mut Motion, pose: &Pose, options: &FrameOptions) -> Result<Trace, PoseError> {
        self.play_where(motion, pose, options, Step::is_of_muscles)
    }

    /// Plays the chosen steps of the next frame.
    fn play_where(
        &self,
        motion: &mut Motion,
        pose: &Pose,
        options: &FrameOptions,
        chosen: impl Fn(&Step) -> bool,
    ) -> Result<Trace, PoseError> {
        let inputs = FrameInputs::new(self.rig, pose)?;
        let counts = counts(self.rig);
        let turns = match (&mut motion.simulation, counts.dynamics(options)) {
            (Some(simulation), Some(dynamics)) => simulation.begin(&inputs, pose.time.into(), &dynamics),
            _ => 0,
        };
        let mut steps = schedule::frame(&counts, options, inputs.joints.len() as u32, turns);
        steps.retain(chosen);
        let mut trace = Trace {
            steps,
            skinned: Vec::new(),
            muscles: Vec::new(),
            axes: Vec::new(),
            particles: Vec::new(),
            tracked: Vec::new(),
            reports: Vec::new(),
            normals: Vec::new(),
        };
        for step in trace.steps.clone() {
            self.play(&step, &inputs, options, motion, &mut trace);
        }
        if let Some(simulation) = &mut motion.simulation {
            simulation.axes.clone_from(&trace.axes);
            trace.particles.clone_from(&simulation.particles);
        }
        Ok(trace)
    }

    /// Plays one step: reads what earlier steps left in `trace`, and adds its own result.
    pub fn play(
        &self,
        step: &Step,
        inputs: &FrameInputs,
        options: &FrameOptions,
        motion: &mut Motion,
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
            KernelId::MuscleShape => {
                trace.muscles.resize(rig.muscles.len(), MuscleFrame::default());
                trace.axes.resize(rig.point_count as usize, AxisPoint::default());
                let half = half(rig.muscles.len() as u32, rig.point_count);
                let iterates = motion.simulation.as_ref().map_or(&[][..], |s| &s.iterates[..half]);
                let (joints, groups) = (&inputs.joints, &inputs.groups);
                let input = ShapeInput { joints, groups, inputs: &inputs.muscles, iterates };
                wrap::shape(&rig.muscles, &input, &mut trace.muscles, &mut trace.axes);
            }
            KernelId::March => {
                trace.tracked.resize(vertices, Vec4::ZERO);
                trace.reports.resize(vertices, MarchReport::default());
                let field = FieldInput {
                    groups: &inputs.groups,
                    nodes: &rig.nodes,
                    muscles: &trace.muscles,
                    axes: &trace.axes,
                };
                let params = MarchParams::new(&counts(rig), 1, &options.march);
                let (skinned, tracked) = (&trace.skinned, &mut trace.tracked);
                tracking::march(&params, &field, &rig.targets, skinned, tracked, &mut trace.reports);
            }
            KernelId::Normals => {
                trace.normals.resize(vertices, Vec4::ZERO);
                let fans =
                    Fans { triangles: &rig.topology.corners, fans: &rig.topology.fans, members: &rig.topology.members };
                let positions = match step.reads {
                    Some(Positions::Tracked) => &trace.tracked,
                    Some(Positions::Skinned) | None => &trace.skinned,
                };
                normals::from_faces(&fans, positions, &mut trace.normals);
            }
            KernelId::JointStep | KernelId::MusclePredict | KernelId::MuscleProject => {
                if let (Some(simulation), Some(dynamics)) = (&mut motion.simulation, &options.dynamics) {
                    let joints = inputs.joints.len() as u32;
                    let params = DynamicsParams::new(&counts(rig), 1, joints, dynamics, step.outer);
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

    fn arm() -> (Scene, Rig, FrameOptions) {
        let scene = crate::io::gltf::from_bytes(include_bytes!("../assets/arm.glb"), "arm").expect("the arm");
        let text = include_str!("../assets/arm.muscles.toml");
        let file = muscle_file::parse(text, Path::new("arm.muscles.toml")).expect("good");
        let rig = Rig::build(scene.character.clone(), &file.muscles, &BuildOptions::default()).expect("a rig");
        (scene, rig, FrameOptions { dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() })
    }

    fn pose(scene: &Scene, frame: u32) -> Pose {
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
}
