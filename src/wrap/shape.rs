//! The shape that a muscle's length gives it at constant volume.
//!
//! The path is the straight segment from origin to insertion, or round what the muscle lies round, or where the dynamics have
//! taken the axis. Twin of the kernel `muscle_shape`.

use crate::{
    field::muscle::{
        self, AxisPoint, MuscleFrame, MuscleInput, MuscleRest, axis,
        mesh::{self, Detail, Surface},
        wrap::{Course, MuscleWrap, Spacing},
    },
    math::{affine_inverse, product, transform_point, transform_vector},
    rig::JointFrame,
};
use glam::{Mat3, Mat4, Vec4, Vec4Swizzles};

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
        /// Axis points of all of the character's muscles.
        pub point_count: u32,
        /// 1 where axes come from the iterates of the dynamics, 0 where they follow their paths.
        pub moving: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
    }
}

/// What shaping reads: one instance's joints and muscle inputs.
#[derive(Clone, Copy)]
pub struct ShapeInput<'a> {
    /// One per joint.
    pub joints: &'a [JointFrame],
    /// One per muscle.
    pub inputs: &'a [MuscleInput],
    /// First half of the iterates of the dynamics ([`axis::half`]); empty where axes follow their paths.
    pub iterates: &'a [Vec4],
    /// What the rig's muscles lie round.
    pub wraps: &'a [MuscleWrap],
}

/// Shapes every muscle of one instance: axis, length, width `w = sqrt(V / (pi l))` (paper A, equation 3), section
/// normals.
///
/// `muscles` and `shaped` have one entry per muscle, `axes` one per axis point of all of them; everything in them is in
/// scene space at rest of the muscle's joint, so that the pose's scale does not change its volume.
pub fn shape(muscles: &[MuscleRest], input: &ShapeInput, shaped: &mut [MuscleFrame], axes: &mut [AxisPoint]) {
    for (index, ((rest, own), out)) in muscles.iter().zip(input.inputs).zip(shaped).enumerate() {
        let first = rest.first_point as usize;
        *out = shape_one(index, rest, own, input, &mut axes[first..=first + rest.segments as usize]);
    }
}

fn shape_one(
    index: usize,
    rest: &MuscleRest,
    own: &MuscleInput,
    input: &ShapeInput,
    points: &mut [AxisPoint],
) -> MuscleFrame {
    let (to_rest, _) = affine_inverse(&input.joints[rest.joint as usize].matrix);
    let to_rest = &to_rest;
    let from = &input.joints[rest.origin_joint as usize].matrix;
    let to = &input.joints[rest.insertion_joint as usize].matrix;
    let origin = transform_point(to_rest, transform_point(from, rest.origin.xyz()));
    let insertion = transform_point(to_rest, transform_point(to, rest.insertion.xyz()));
    let spacing = if input.iterates.is_empty() { Spacing::Even } else { Spacing::Tension };
    let course = rest.wrap(input.wraps).map(|wrap| {
        let around = &input.joints[wrap.joint as usize].matrix;
        Course::new(wrap, &product(to_rest, &product(around, &wrap.to_rest)), origin, insertion, spacing)
    });
    let mut own = *own;
    if input.iterates.is_empty() {
        match &course {
            Some(course) => course.put(points),
            None => muscle::straighten(points, origin, insertion),
        }
    } else {
        let moved = &input.iterates[axis::run(index, rest.first_point) + 2..];
        for (point, moved) in points.iter_mut().zip(moved.iter().step_by(2)) {
            point.position = transform_point(to_rest, moved.xyz()).extend(0.0);
        }
        match &course {
            Some(course) => course.smooth(points),
            None => muscle::smooth(points),
        }
        own.shift = moved[2 * rest.segments as usize + 1].w;
    }
    let origin_normal = transform_vector(to_rest, transform_vector(from, rest.origin_normal.xyz()));
    let insertion_normal = transform_vector(to_rest, transform_vector(to, rest.insertion_normal.xyz()));
    muscle::shape(rest, &own, points, origin_normal, insertion_normal)
}

/// The surface of a shaped muscle in scene space, metres; `points` are its own and `to_posed` the matrix of the joint that
/// drives its field group. Corners are the same at the same detail in every frame: a muscle that has no field in this one
/// has all its vertices at its origin.
pub fn posed_surface(muscle: &MuscleFrame, points: &[AxisPoint], to_posed: &Mat4, detail: Detail) -> Surface {
    let mut surface = match muscle.present {
        0 => Surface::collapsed(detail, points[0].position.xyz()),
        _ => mesh::surface(muscle, points, detail),
    };
    let turn = Mat3::from_mat4(*to_posed).inverse().transpose();
    surface.positions.iter_mut().for_each(|p| *p = to_posed.transform_point3(*p));
    surface.normals.iter_mut().for_each(|n| *n = (turn * *n).normalize_or_zero());
    surface
}
