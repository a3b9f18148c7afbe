//! The dynamics of one instance on the CPU.

use super::{
    Bodies, Clock, DynamicsParams, MovedJoint, Particle,
    clock::Turn,
    contact::Surroundings,
    joints,
    predict::{self, Predicted},
    project,
};
use crate::{
    field::{
        GroupGrid,
        muscle::{
            AxisPoint,
            axis::{half, run},
            smooth,
            wrap::{Course, Spacing},
        },
    },
    rig::{FrameInputs, JointFrame, Rig, SettledPoint},
    schedule::{Counts, DynamicsOptions},
};
use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;
use std::sync::Arc;

/// The cached fields of a character's groups and bones.
#[derive(Clone, Copy, Debug)]
pub struct Skins<'a> {
    /// Per group.
    pub grids: &'a [GroupGrid],
    /// Nodes of all grids.
    pub nodes: &'a [Vec4],
}

impl<'a> Skins<'a> {
    /// Those of a rig.
    pub fn of(rig: &'a Rig) -> Skins<'a> {
        Skins { grids: &rig.grids, nodes: &rig.nodes }
    }
}

/// One instance's muscles in motion. A clone is a checkpoint: what follows it is the same to the bit.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The bodies that move.
    pub bodies: Arc<Bodies>,
    /// When its joints were last where.
    pub clock: Clock,
    /// Points of all muscles, posed scene space.
    pub particles: Vec<Particle>,
    /// Two halves of iterates ([`half`]).
    pub iterates: Vec<Vec4>,
    /// Axes as last shaped; those at rest where the motion has just begun.
    pub axes: Vec<AxisPoint>,
    moved: Vec<MovedJoint>,
    turn: Turn,
    /// Joints before and after the frame.
    joints: Vec<JointFrame>,
}

impl Simulation {
    /// Nothing has moved yet.
    pub fn new(bodies: Arc<Bodies>) -> Simulation {
        let points = bodies.particles_rest.len();
        let half = half(bodies.muscles.len() as u32, points as u32);
        Simulation {
            clock: Clock::default(),
            particles: bodies.particles_rest.clone(),
            iterates: vec![Vec4::ZERO; 2 * half],
            axes: bodies.axes_rest.clone(),
            moved: Vec::new(),
            turn: Turn::default(),
            joints: Vec::new(),
            bodies,
        }
    }

    /// Forgets the motion: the next frame starts anew, as after a teleport.
    pub fn reset(&mut self) {
        self.clock.reset();
    }

    /// Goes on from the particles and axes that another side has for the same frame.
    pub fn resume(&mut self, particles: &[Particle], axes: &[AxisPoint]) {
        self.particles.copy_from_slice(particles);
        self.axes.copy_from_slice(axes);
    }

    /// Goes on to a frame at `time`, seconds: sets the clock, and puts the muscles in place where the motion starts.
    /// Returns how many substeps the frame has.
    pub fn begin(&mut self, inputs: &FrameInputs, time: f64, options: &DynamicsOptions) -> u32 {
        self.turn = self.clock.advance(time, &inputs.joints, options);
        if self.turn.starts {
            self.particles = self.bodies.particles(&inputs.joints);
            self.axes.clone_from(&self.bodies.axes_rest);
        }
        self.joints.clear();
        self.joints.extend(&self.turn.joints_before);
        self.joints.extend(&inputs.joints);
        self.moved.resize(inputs.joints.len(), MovedJoint::default());
        self.turn.clock.turns
    }

    /// Moves the joints on by a substep, or to the frame.
    pub fn step_joints(&mut self, carries: bool) {
        joints::step(&self.turn.clock, carries, &self.joints, &mut self.moved);
    }

    /// Predicts all muscles, and counts the substep.
    pub fn predict(&mut self, params: &DynamicsParams, inputs: &FrameInputs) {
        let (first, _) = self.iterates.split_at_mut(params.half());
        let (moved, axes, muscles, wraps) = (&self.moved, &self.axes, &self.bodies.muscles, &self.bodies.wraps);
        runs(&self.bodies, &mut self.particles, first).for_each(|(index, own, out)| {
            let muscle = &muscles[index];
            let axis = &axes[muscle.first_point as usize..][..own.len()];
            let wrap = muscle.wrap(wraps);
            let predicted = Predicted { muscle, input: &inputs.muscles[index], axis, wrap };
            predict::predict(params, &predicted, moved, own, out);
        });
        self.turn.clock.turn = (self.turn.clock.turn + 1).min(self.turn.clock.turns);
    }

    /// One outer iteration of all muscles.
    pub fn project(&mut self, params: &DynamicsParams, skins: Skins) {
        let (first, second) = self.iterates.split_at_mut(params.half());
        let (read, write) = if params.from_half == 0 { (&*first, second) } else { (&*second, first) };
        let around = Surroundings {
            muscles: &self.bodies.muscles,
            bones: &self.bodies.bones,
            links: &self.bodies.links,
            moved: &self.moved,
            grids: skins.grids,
            nodes: skins.nodes,
            iterates: read,
        };
        runs(&self.bodies, &mut self.particles, write)
            .for_each(|(index, own, out)| project::project(params, index, &around, own, out));
    }

    /// Positions of all axes' points in the rest pose, smoothed, metres in scene space.
    fn smoothed(&self) -> Vec<Vec3> {
        let point = |p: &Particle| AxisPoint { position: p.position.xyz().extend(0.0), ..AxisPoint::default() };
        let mut axes: Vec<AxisPoint> = self.particles.iter().map(point).collect();
        for muscle in &self.bodies.muscles {
            let own = &mut axes[muscle.first_point as usize..][..=muscle.segments as usize];
            match muscle.wrap(&self.bodies.wraps) {
                Some(wrap) => {
                    let (origin, insertion) = (muscle.origin.xyz(), muscle.insertion.xyz());
                    Course::new(wrap, &wrap.to_rest, origin, insertion, Spacing::Tension).smooth(own);
                }
                None => smooth(own),
            }
        }
        axes.iter().map(|p| p.position.xyz()).collect()
    }

    /// Plays all of a frame's substeps.
    pub fn advance(&mut self, skins: Skins, inputs: &FrameInputs, time: f64, options: &DynamicsOptions) {
        let counts = Counts {
            muscles: self.bodies.muscles.len() as u32,
            points: self.particles.len() as u32,
            most_segments: self.bodies.muscles.iter().map(|m| m.segments).max().unwrap_or(0),
            groups: skins.grids.len() as u32,
            ..Counts::default()
        };
        let joints = inputs.joints.len() as u32;
        let turns = self.begin(inputs, time, options);
        let params: Vec<DynamicsParams> =
            (0..options.outer).map(|outer| DynamicsParams::new(&counts, 1, joints, options, outer)).collect();
        for _ in 0..turns {
            self.step_joints(false);
            self.predict(&params[0], inputs);
            for params in &params {
                self.project(params, skins);
            }
        }
        self.step_joints(true);
        self.predict(&params[0], inputs);
    }
}

/// Lets the muscles of a rig settle in the rest pose, and takes the result for their axes at rest: where they have been
/// pushed aside before anything moves. The skin's targets follow, and motions start there.
///
/// Without this, skin would move in the rest pose.
pub fn settle(rig: &mut Rig, options: &DynamicsOptions) {
    let rest = crate::rig::Pose::rest(&rig.character);
    let Ok(inputs) = FrameInputs::new(rig, &rest) else { return };
    if rig.muscles.is_empty() {
        return;
    }
    let inputs = FrameInputs { muscles: rig.rest_inputs(), ..inputs };
    let mut simulation = Simulation::new(Arc::new(Bodies::new(rig)));
    // No velocity outlives a substep.
    let options = DynamicsOptions { retention: 0.0, ..*options };
    let mut axes = Vec::new();
    for frame in 0..=SETTLE_FRAMES {
        simulation.advance(Skins::of(rig), &inputs, f64::from(frame) / SETTLE_RATE, &options);
        axes = simulation.smoothed();
        // Sections turn with the axes, and others touch them.
        simulation.axes = rig.muscles_along(&axes).1;
    }
    rig.set_settled(&axes, simulation.particles.iter().map(settled).collect());
}

/// Frames in which muscles settle in the rest pose after the first one, and how many there are in a second.
const SETTLE_FRAMES: u32 = 60;
const SETTLE_RATE: f64 = 30.0;

/// What a particle at rest has that its muscle's shape does not say.
fn settled(particle: &Particle) -> SettledPoint {
    SettledPoint {
        position: particle.position.xyz(),
        planes: [particle.peer_0, particle.peer_1],
        muscles: [particle.traits.z, particle.traits.w].map(|muscle| muscle as u32),
    }
}

/// Every muscle's particles and its run of iterates.
fn runs<'a>(
    bodies: &Bodies,
    mut particles: &'a mut [Particle],
    mut iterates: &'a mut [Vec4],
) -> impl ParallelIterator<Item = (usize, &'a mut [Particle], &'a mut [Vec4])> + use<'a> {
    let mut runs = Vec::with_capacity(bodies.muscles.len());
    let whole = iterates.len();
    for (index, muscle) in bodies.muscles.iter().enumerate() {
        debug_assert_eq!(run(index, muscle.first_point) + iterates.len(), whole);
        let points = muscle.segments as usize + 1;
        let (own, others) = particles.split_at_mut(points);
        let (out, further) = iterates.split_at_mut(2 + 2 * points);
        runs.push((index, own, out));
        (particles, iterates) = (others, further);
    }
    runs.into_par_iter()
}
