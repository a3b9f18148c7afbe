//! The composed field of the whole character at a point of posed scene space.

use super::{
    GroupGrid, Sample,
    compose::detail_samples,
    grid,
    muscle::{self, MuscleFrame},
    transfer::transfer,
};
use crate::math::{transform_point, transpose_vector};
use glam::{Mat4, Vec3, Vec4};

crate::gpu_struct! {
    /// One field group at one moment.
    pub struct GroupFrame {
        /// Scene space posed to scene space at rest: the inverse of the driving joint's palette entry.
        pub to_rest: Mat4,
        /// The group's cached field.
        pub grid: GroupGrid,
        /// How much the pose enlarges the group: the cube root of its volume factor.
        pub scale: f32,
        /// 1 where the group takes part, 0 where its pose cannot be inverted.
        pub present: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
    }
}

/// No group reaches the point.
pub const NO_GROUP: u32 = u32::MAX;

/// A sample of the composed field, and which group it came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupSample {
    /// Value, and gradient in posed scene space.
    pub sample: Sample,
    /// Index of the group with the largest value, [`NO_GROUP`] where all are 0.
    pub group: u32,
}

/// The field of one group at a posed point: limb surface with its muscles set in (background 3.4).
#[inline]
pub fn group(frame: &GroupFrame, nodes: &[Vec4], muscles: &[MuscleFrame], p_posed: Vec3) -> Sample {
    let p_rest = transform_point(&frame.to_rest, p_posed);
    let mut limb = Sample::default();
    if let Some((distance, distance_gradient)) = grid::sample(&frame.grid, nodes, p_rest) {
        let (value, slope) = transfer(distance, frame.grid.support_radius);
        limb = Sample { value, gradient: distance_gradient * slope };
    }
    let mut best = Sample::default();
    for m in &muscles[frame.grid.muscle_begin as usize..frame.grid.muscle_end as usize] {
        let sample = muscle::evaluate(m, p_rest);
        if sample.value > best.value {
            best = sample;
        }
    }
    let composed = if best.value > 0.0 { detail_samples(limb, best) } else { limb };
    Sample { value: composed.value, gradient: transpose_vector(&frame.to_rest, composed.gradient) }
}

/// The composed field at a posed point: the largest of the groups' fields.
///
/// `groups` and `muscles` belong to one instance; `nodes` holds the grids of all groups.
#[inline]
pub fn composed(groups: &[GroupFrame], nodes: &[Vec4], muscles: &[MuscleFrame], p_posed: Vec3) -> GroupSample {
    let mut result = GroupSample { sample: Sample::default(), group: NO_GROUP };
    for (index, frame) in groups.iter().enumerate() {
        if frame.present == 0 {
            continue;
        }
        let sample = group(frame, nodes, muscles, p_posed);
        if sample.value > result.sample.value {
            result = GroupSample { sample, group: index as u32 };
        }
    }
    result
}
