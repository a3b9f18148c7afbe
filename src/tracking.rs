//! Moving skin vertices to their rest iso-value in the posed field (background 1.12). Twin of the kernel `march`.

pub use crate::field::evaluate::FieldInput;

use crate::{
    field::evaluate::{GroupSample, NO_GROUP},
    rig::VertexTarget,
    schedule::{Counts, MarchOptions},
};
use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

crate::gpu_struct! {
    /// Sizes and settings of the march.
    pub struct MarchParams {
        /// Vertices of the character.
        pub vertex_count: u32,
        /// Instances in the batch.
        pub instance_count: u32,
        /// Field groups of the character.
        pub group_count: u32,
        /// Muscles of the character.
        pub muscle_count: u32,
        /// Most steps of a vertex.
        pub max_steps: u32,
        /// Share sigma of the Newton step that is taken.
        pub relaxation: f32,
        /// A vertex has arrived when its field value is this close to its target.
        pub tolerance: f32,
        /// Longest step, in support radii of the group that the vertex is in.
        pub max_step_radii: f32,
        /// Points of all of the character's muscles' axes.
        pub point_count: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
        /// Unused.
        pub pad_2: u32,
    }
}

impl MarchParams {
    /// Parameters for a batch of `instance_count` instances, the same on both sides.
    pub fn new(counts: &Counts, instance_count: u32, options: &MarchOptions) -> MarchParams {
        MarchParams {
            vertex_count: counts.vertices,
            instance_count,
            group_count: counts.groups,
            muscle_count: counts.muscles,
            max_steps: options.max_steps,
            relaxation: options.relaxation,
            tolerance: options.tolerance,
            max_step_radii: options.max_step_radii,
            point_count: counts.points,
            ..MarchParams::default()
        }
    }
}

crate::gpu_struct! {
    /// How the march of one vertex ended.
    pub struct MarchReport {
        /// A [`StopReason`] as a number.
        pub stop: u32,
        /// Steps taken.
        pub steps: u32,
        /// Field value at the end less the target.
        pub residual: f32,
        /// Smallest cosine between gradients of successive steps: under cos 55 degrees Implicit Skinning calls it a
        /// contact. Recorded, never acted on.
        pub turn_cosine: f32,
    }
}

/// Why a vertex stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum StopReason {
    /// Not an active vertex: it follows geometric skinning.
    Passive = 0,
    /// Within tolerance of its target.
    Converged = 1,
    /// Every field's gradient vanishes there.
    NoGradient = 2,
    /// The last step took it further from its target: it went back, and stays.
    Pit = 3,
    /// The steps ran out.
    StepLimit = 4,
    /// A value that is not finite appeared: it went back to geometric skinning.
    NonFinite = 5,
}

impl StopReason {
    /// Every reason, in numeric order.
    pub const ALL: [StopReason; 6] = [
        StopReason::Passive,
        StopReason::Converged,
        StopReason::NoGradient,
        StopReason::Pit,
        StopReason::StepLimit,
        StopReason::NonFinite,
    ];
}

/// Larger than any difference of field values.
pub(crate) const INFINITE_GAP: f32 = 3.0e38;

/// Squared gradient, per square metre, under which a field gives no direction (background 1.12).
pub(crate) const MIN_GRADIENT_SQUARED: f32 = 1e-5;

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

/// The composed field at many points: `xyz` is the gradient, `w` the value. Twin of the kernel `field_sample`.
pub fn sample(field: &FieldInput, points_posed: &[Vec4], samples: &mut [Vec4]) {
    samples.par_iter_mut().with_min_len(64).zip(points_posed).for_each(|(out, p)| {
        let sample = field.composed(p.xyz()).sample;
        *out = sample.gradient.extend(sample.value);
    });
}

/// Marches every active vertex from its geometrically skinned place to its rest iso-value; copies the others.
///
/// All slices have one entry per vertex.
pub fn march(
    params: &MarchParams,
    field: &FieldInput,
    targets: &[VertexTarget],
    skinned: &[Vec4],
    tracked: &mut [Vec4],
    reports: &mut [MarchReport],
) {
    tracked.par_iter_mut().zip(reports).with_min_len(64).enumerate().for_each(|(vertex, (out, report))| {
        let (position, ended) = march_vertex(params, field, &targets[vertex], skinned[vertex].xyz());
        *out = position.extend(1.0);
        *report = ended;
    });
}

fn march_vertex(params: &MarchParams, field: &FieldInput, target: &VertexTarget, start: Vec3) -> (Vec3, MarchReport) {
    let mut report = MarchReport { stop: StopReason::Passive as u32, turn_cosine: 1.0, ..MarchReport::default() };
    if target.follows == 0 {
        return (start, report);
    }
    let mut p = start;
    let mut previous = start;
    let mut previous_gap = INFINITE_GAP;
    let mut direction = Vec3::ZERO;
    report.stop = StopReason::StepLimit as u32;
    for step in 0..=params.max_steps {
        let GroupSample { sample, group } = field.own_side(target.owner, target.limit, p);
        let gap = sample.value - target.iso;
        let squared = sample.gradient.dot(sample.gradient);
        if not_finite(gap) || not_finite(squared) {
            report = MarchReport { stop: StopReason::NonFinite as u32, steps: step, residual: 0.0, ..report };
            return (start, report);
        }
        if gap.abs() > previous_gap {
            report.stop = StopReason::Pit as u32;
            return (previous, report);
        }
        report.steps = step;
        report.residual = gap;
        if gap.abs() < params.tolerance {
            report.stop = StopReason::Converged as u32;
            break;
        }
        if squared < MIN_GRADIENT_SQUARED || group == NO_GROUP {
            report.stop = StopReason::NoGradient as u32;
            break;
        }
        if step == params.max_steps {
            break;
        }
        let length = squared.sqrt();
        let unit = sample.gradient / length;
        if step > 0 {
            report.turn_cosine = report.turn_cosine.min(unit.dot(direction));
        }
        direction = unit;
        let frame = &field.groups[group as usize];
        let longest = params.max_step_radii * frame.grid.support_radius * frame.scale;
        let wanted = params.relaxation * -gap / length;
        previous = p;
        previous_gap = gap.abs();
        p += unit * wanted.clamp(-longest, longest);
    }
    (p, report)
}

/// Bit test, because drivers fold `x != x` away.
#[inline]
fn not_finite(x: f32) -> bool {
    (x.to_bits() & 0x7fff_ffff) >= 0x7f80_0000
}
