//! Muscles in motion: position based axes under tension that collide with bones, with one another and with the skin
//! (paper A, section 6; background 4).
//!
//! Time goes in substeps of a fixed length that end at whole multiples of it, whatever the frame rate is. A substep is
//! 1. [`joints::step`]: where every joint is now, and how it carries along what hangs on it;
//! 2. [`predict::predict`]: ends to their joints, inner particles onward with their velocity relative to the bones, radii
//!    from the length that the axis has now;
//! 3. [`project::project`], once per outer iteration: each muscle alone, against the others as the last dispatch left
//!    them.
//!
//! At last the first two run once more, to carry the axes on to the frame, which may fall between two substeps.
//!
//! # The elastic constraint
//! A segment from `p` to `q` with rest length `l0` is the spring of energy `K (|q - p| - l0)^2 / 2`. Its multiplier is a
//! vector, and one projection solves the segment with everything else as it is: without its own pull its span would be
//! `e`, and the pull `(|e| - l0) / (w_p + w_q + 1 / (K h^2)) e / |e|` is the solution. Sweeps in two colours are
//! therefore a descent of the substep's energy; where rest lengths are small, as between the tendons, they are
//! Gauss-Seidel on a tridiagonal, symmetric and positive definite system, they cannot diverge as Newton's steps on the
//! scalar constraint do (prototypes 1), and the over-relaxation that is best for them is known
//! ([`MuscleBody::looseness`]). Contacts are planes with multipliers of their own that never pull.
//!
//! # Spaces and units
//! Everything here is in posed scene space, metres, seconds and kilograms, unless it says `_rest`.

pub mod body;
mod chain;
pub mod clock;
mod contact;
mod course;
pub(crate) mod jiggle;
pub mod joints;
mod measure;
pub mod predict;
pub mod project;
mod residual;
mod simulation;

#[cfg(feature = "gpu")]
pub(crate) use {
    chain::{JACOBI_SHARE, NO_DIRECTION},
    contact::{FACING, LEAST_TURN, LEAST_WAY_SQUARED, TURN},
};

pub use body::{Bodies, BoneRest, Link, MuscleBody, NO_INDEX};
pub use clock::{Clock, StepClock, Turn};
pub use contact::Surroundings;
pub use joints::MovedJoint;
pub use measure::{Depth, depths, elastic};
pub use residual::{Residual, residuals};
pub use simulation::{Simulation, Skins, settle};

#[cfg(test)]
mod tests;

use crate::field::muscle::axis;
use crate::schedule::{Counts, DynamicsOptions, Mode, Solver};
use glam::Vec4;

crate::gpu_struct! {
    /// What the kernels of the dynamics are told.
    pub struct DynamicsParams {
        /// Muscles of the character.
        pub muscle_count: u32,
        /// Instances in the batch.
        pub instance_count: u32,
        /// Joints of the character.
        pub joint_count: u32,
        /// Field groups of the character.
        pub group_count: u32,
        /// Axis points of all of the character's muscles.
        pub point_count: u32,
        /// Half of the iterates that is read; the other one is written.
        pub from_half: u32,
        /// 1 in the outer iteration that ends a substep.
        pub ends_substep: u32,
        /// Inner iterations.
        pub inner: u32,
        /// Contact passes that end a substep, at most.
        pub final_passes: u32,
        /// 1 where constraints are averaged, 0 where they go in two colours.
        pub jacobi: u32,
        /// 1 for the paper's own stiffness, 0 for compliance.
        pub pbd: u32,
        /// What collides: bit 0 bones, bit 1 muscles, bit 2 skin.
        pub contacts: u32,
        /// 1 where joints and axes are carried on to the frame, and nothing is simulated.
        pub carries: u32,
        /// Inner iterations of the substep's earlier outer iterations.
        pub done: u32,
        /// Threads that share one muscle in the projection.
        pub threads_per_muscle: u32,
        /// How far a plane between muscles may be off before it follows, metres.
        pub play: f32,
        /// Length of a substep, seconds.
        pub seconds: f32,
        /// Frequency of a muscle of stiffness .4, hertz.
        pub frequency: f32,
        /// Coefficient of friction.
        pub friction: f32,
        /// Displacement under which a particle that presses against a muscle stays where it is in a substep, metres.
        pub deadband: f32,
    }
}

crate::gpu_struct! {
    /// One point of a muscle's axis in motion.
    pub struct Particle {
        /// Position, and in `w` the muscle's mean radius there, metres.
        pub position: Vec4,
        /// Velocity, m/s, and in `w` one over the mass, 1/kg; 0 at the kinematic ends.
        pub velocity: Vec4,
        /// Multiplier of the segment that begins here, kg m, and in `w` its rest length, metres at rest.
        pub spring: Vec4,
        /// Multipliers of the contacts with two muscles, a bone and the skin, kg m.
        pub pushes: Vec4,
        /// Half spaces that neighbours keep it in, in scene space at rest of the joint that drives the muscle's field:
        /// `n . p >= w`; the zero normal is none.
        pub peer_0: Vec4,
        /// The second one of them.
        pub peer_1: Vec4,
        /// Share of the radius that is kept clear of bones, less than 1 in the tendons; in `y` how many times stiffer than
        /// the muscle the segment that begins here is; `zw`, but at the ends, are the muscles of those half spaces, counted from
        /// 1, 0 for none. At the origin they are the state of the lengthwise jiggle, at the insertion unused.
        pub traits: Vec4,
    }
}

/// Colliding kinds, as bits of [`DynamicsParams::contacts`] and of [`MuscleBody::collides`].
pub(crate) const BONES: u32 = 1;
/// See [`BONES`].
pub(crate) const MUSCLES: u32 = 2;
/// See [`BONES`].
pub(crate) const SKIN: u32 = 4;

pub(crate) fn kinds(bones: bool, muscles: bool, skin: bool) -> u32 {
    let bit = |on: bool, bit| if on { bit } else { 0 };
    bit(bones, BONES) | bit(muscles, MUSCLES) | bit(skin, SKIN)
}

impl DynamicsParams {
    /// The parameters of one outer iteration; predictions take those of iteration 0.
    pub fn new(counts: &Counts, instance_count: u32, joint_count: u32, options: &DynamicsOptions, outer: u32) -> Self {
        DynamicsParams {
            muscle_count: counts.muscles,
            instance_count,
            joint_count,
            group_count: counts.groups,
            point_count: counts.points,
            from_half: outer % 2,
            ends_substep: (outer + 1 == options.outer).into(),
            inner: options.inner,
            final_passes: options.final_passes,
            jacobi: (options.solver == Solver::Jacobi).into(),
            pbd: (options.mode == Mode::Pbd).into(),
            contacts: kinds(options.contacts.bones, options.contacts.muscles, options.contacts.skin),
            carries: 0,
            done: outer * options.inner,
            threads_per_muscle: counts.threads_per_muscle(),
            play: options.play,
            seconds: options.seconds(),
            frequency: options.frequency,
            friction: options.friction,
            deadband: options.deadband,
        }
    }

    /// Entries of one half of one instance's iterates.
    pub fn half(&self) -> usize {
        axis::half(self.muscle_count, self.point_count)
    }
}
