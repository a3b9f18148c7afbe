//! A muscle's path from its attachments, and the shape that its length gives it at constant volume.
//!
//! The path is the straight segment from origin to insertion. Twin of the kernel `muscle_shape`.

use crate::{
    field::{
        evaluate::GroupFrame,
        muscle::{MuscleFrame, MuscleRest, straight},
    },
    math::{transform_point, transform_vector},
    rig::JointFrame,
};
use glam::Vec4Swizzles;

crate::gpu_struct! {
    /// Sizes that a per-muscle kernel needs.
    pub struct MuscleParams {
        /// Muscles of the character.
        pub muscle_count: u32,
        /// Instances in the batch.
        pub instance_count: u32,
        /// Joints of the character.
        pub joint_count: u32,
        /// Field groups of the character.
        pub group_count: u32,
    }
}

/// Shapes every muscle of one instance: length, width `w = sqrt(V / (pi l))` (paper A, equation 3), frame.
///
/// `muscles` and `shaped` have one entry per muscle; everything in `shaped` is in scene space at rest of the
/// muscle's field group, so that the pose's scale does not change its volume.
pub fn shape(muscles: &[MuscleRest], joints: &[JointFrame], groups: &[GroupFrame], shaped: &mut [MuscleFrame]) {
    for (rest, out) in muscles.iter().zip(shaped) {
        *out = shape_one(rest, joints, groups);
    }
}

fn shape_one(rest: &MuscleRest, joints: &[JointFrame], groups: &[GroupFrame]) -> MuscleFrame {
    let to_rest = &groups[rest.group as usize].to_rest;
    let from = &joints[rest.origin_joint as usize].matrix;
    let to = &joints[rest.insertion_joint as usize].matrix;
    let origin = transform_point(to_rest, transform_point(from, rest.origin.xyz()));
    let insertion = transform_point(to_rest, transform_point(to, rest.insertion.xyz()));
    let normal = transform_vector(to_rest, transform_vector(from, rest.origin_normal.xyz()))
        + transform_vector(to_rest, transform_vector(to, rest.insertion_normal.xyz()));
    straight(rest, origin, insertion, normal)
}
