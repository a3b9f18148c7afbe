//! The skin's way to its rest iso-values in the posed field, from where it was a frame ago (background 2; prototypes 3
//! and 5).
//!
//! A pose is reached in sub-poses. In each, the skin is carried along by the joints ([`carry`]); vertices see the field
//! groups around them through frames of their own ([`place`]); then passes of one Newton step each ([`march`]) alternate
//! with relaxation along the field ([`turn`], [`span`], [`slide`]), and the last passes only project. What a frame leaves behind is
//! where the next one starts.
//!
//! Or a pose is reached from dual quaternion skinning of its own ([`start`]), and relaxes towards the mean of neighbours
//! ([`average`]): then no frame depends on another.

mod average;
mod carry;
mod fold;
mod march;
mod path;
mod relax;

pub use crate::field::evaluate::FieldInput;
pub use average::{AverageInput, average, start};
pub use carry::{CarryInput, carry, drawn_share, place, spread};
pub use fold::{FOLD_LANES, FoldInput, fold};
pub use march::{march, sample};
pub use path::{Path, SubPose, TrackJoint, Way};
pub use relax::{RelaxInput, slide, span, turn};

#[cfg(feature = "gpu")]
pub(crate) use carry::{LEAST_AWAY, LOST_PULL, OPEN_FROM, OPEN_RANGE};
#[cfg(feature = "gpu")]
pub(crate) use fold::{FOLD_GAIN, LEAST_FOLD_WEIGHT};
#[cfg(feature = "gpu")]
pub(crate) use march::{MIN_GRADIENT_SQUARED, SETTLED};
#[cfg(feature = "gpu")]
pub(crate) use relax::{TURNS, WEAKEST_TURN};

use crate::{
    field::evaluate::Place,
    rig::{Pose, Rig},
    schedule::{Counts, TrackOptions, Tracking},
};
use glam::{Vec4, Vec4Swizzles};

crate::gpu_struct! {
    /// Sizes and settings of the tracker's kernels.
    pub struct TrackParams {
        /// Vertices of the character.
        pub vertex_count: u32,
        /// Instances in the batch.
        pub instance_count: u32,
        /// Joints of the character.
        pub joint_count: u32,
        /// Field groups of the character.
        pub group_count: u32,
        /// Muscles of the character.
        pub muscle_count: u32,
        /// Points of all of the character's muscles' axes.
        pub point_count: u32,
        /// Reaches of all of its vertices.
        pub reach_count: u32,
        /// Which sub-pose it is: 0 is the pose itself, which comes last.
        pub sub_pose: u32,
        /// Share of the Newton step that is taken.
        pub relaxation: f32,
        /// A vertex has arrived when its field value is this close to its target.
        pub tolerance: f32,
        /// Longest step, in support radii of the group that the vertex is in.
        pub max_step_radii: f32,
        /// How far a sub-pose of the usual turn draws vertices without contact to linear skinning, 0..=1.
        pub anchor: f32,
        /// How strongly rotations follow the field's normal.
        pub normal_weight: f32,
        /// 1 in the passes that only take the step.
        pub projects: u32,
        /// Share of a relaxation's way that pressed vertices are spared, 0..=1.
        pub contact_hold: f32,
        /// Joints that fold.
        pub fold_count: u32,
        /// Passes that relax, before those that only take the step.
        pub passes: u32,
        /// Vertices that are marched.
        pub marched_count: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
    }
}

impl TrackParams {
    /// Parameters for a batch of `instance_count` instances, the same on both sides.
    pub fn new(
        counts: &Counts,
        instance_count: u32,
        options: &TrackOptions,
        sub_pose: u32,
        projects: bool,
    ) -> TrackParams {
        TrackParams {
            vertex_count: counts.vertices,
            instance_count,
            joint_count: counts.joints,
            group_count: counts.groups,
            muscle_count: counts.muscles,
            point_count: counts.points,
            reach_count: counts.reaches,
            sub_pose,
            projects: projects.into(),
            relaxation: if projects { options.projection } else { options.relaxation },
            tolerance: options.tolerance,
            max_step_radii: options.max_step_radii,
            anchor: options.anchor,
            normal_weight: options.normal_weight,
            contact_hold: options.contact_hold,
            fold_count: counts.folds,
            passes: options.passes,
            marched_count: counts.marched,
            ..TrackParams::default()
        }
    }
}

crate::gpu_struct! {
    /// What the tracker keeps of a vertex besides its position.
    pub struct Track {
        /// Direction of the field's gradient where the vertex was in the last pass, and in `w` the field value there less
        /// the target.
        pub normal: Vec4,
        /// How the skin around the vertex has turned since the rest pose: a unit quaternion `xyzw`.
        pub rotation: Vec4,
        /// How much it presses against another group, 0..=1.
        pub contact: f32,
        /// A [`StopReason`] as a number.
        pub stop: u32,
        /// Passes since the frame began.
        pub passes: u32,
        /// Whether its instance takes part in the frame: `RUNS` in a sub-pose, `ENDS` where only the last passes are
        /// left, else 0.
        pub runs: u32,
    }
}

/// A vertex whose instance is in a sub-pose.
pub(crate) const RUNS: u32 = 1;
/// A vertex whose instance has no sub-pose here, and gets the last passes.
pub(crate) const ENDS: u32 = 2;

impl Track {
    /// A vertex at rest.
    pub const REST: Track = Track { normal: Vec4::ZERO, rotation: Vec4::W, contact: 0.0, stop: 0, passes: 0, runs: 0 };

    /// Field value less the target after the last pass but before its step.
    pub fn residual(&self) -> f32 {
        self.normal.w
    }
}

/// How the tracking of a vertex ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum StopReason {
    /// Not an active vertex: it follows linear skinning, or the vertex that it is a copy of.
    Passive = 0,
    /// Within tolerance of its target.
    Converged = 1,
    /// Every field's gradient vanishes there.
    NoGradient = 2,
    /// The passes ran out.
    Short = 3,
    /// The passes ran out against another group's skin.
    Pressed = 4,
    /// A value that is not finite appeared: it follows linear skinning.
    NonFinite = 5,
}

impl StopReason {
    /// Every reason, in numeric order.
    pub const ALL: [StopReason; 6] = [
        StopReason::Passive,
        StopReason::Converged,
        StopReason::NoGradient,
        StopReason::Short,
        StopReason::Pressed,
        StopReason::NonFinite,
    ];
}

crate::gpu_struct! {
    /// Sizes that sampling the field at given points needs.
    pub struct SampleParams {
        /// Points per instance.
        pub point_count: u32,
        /// Instances in the batch.
        pub instance_count: u32,
        /// Field groups of the character.
        pub group_count: u32,
        /// Muscles of the character.
        pub muscle_count: u32,
        /// Points of all of the character's muscles' axes.
        pub axis_point_count: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
        /// Unused.
        pub pad_2: u32,
    }
}

/// Where one character's skin is: what the tracker hands on from frame to frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Per vertex, posed, `w = 1`; of later copies nothing.
    pub positions: Vec<Vec4>,
    /// Per vertex.
    pub tracks: Vec<Track>,
    /// How its vertices see the groups around them, one per reach: as in the last sub-pose.
    pub places: Vec<Place>,
    /// What its folding joints displace, metres.
    pub offsets: Vec<f32>,
    /// Where its joints are.
    pub path: Path,
}

impl Skin {
    /// A skin at rest.
    pub fn rest(positions_rest: &[Vec4], folds: usize) -> Skin {
        Skin {
            positions: positions_rest.to_vec(),
            tracks: vec![Track::REST; positions_rest.len()],
            places: Vec::new(),
            offsets: vec![0.0; folds],
            path: Path::default(),
        }
    }

    /// The sub-poses that lead the skin to a pose: from where it is, or at once, and then nothing is left of what it was.
    pub fn lead(&mut self, rig: &Rig, pose: &Pose, options: &TrackOptions) -> (Way, Vec<SubPose>) {
        if options.mode == Tracking::SinglePose {
            self.offsets.fill(0.0);
        }
        self.path.lead(rig, pose, options)
    }
}

/// A point without its `w`.
#[inline]
fn point(p: &Vec4) -> glam::Vec3 {
    p.xyz()
}

/// Bit test, because drivers fold `x != x` away.
#[inline]
fn not_finite(x: f32) -> bool {
    (x.to_bits() & 0x7fff_ffff) >= 0x7f80_0000
}

/// Whether a vector's size is a number.
#[inline]
fn is_finite(v: glam::Vec3) -> bool {
    !not_finite(v.dot(v))
}

#[cfg(test)]
mod tests;
