//! Geometric skinning: linear blending and dual quaternions, the march's starting point and baselines of their own.
//!
//! A vertex may have any number of influences. Positions are `Vec4` with `w = 1` throughout.

use crate::{
    math::transform_point,
    rig::{Influence, JointFrame},
};
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

crate::gpu_struct! {
    /// Sizes that a per-vertex kernel needs.
    pub struct VertexParams {
        /// Vertices of the character.
        pub vertex_count: u32,
        /// Instances in the batch.
        pub instance_count: u32,
        /// Joints of the character.
        pub joint_count: u32,
        /// Unused.
        pub pad_0: u32,
    }
}

/// Vertices per parallel task: fixed, so that the same input is cut the same way everywhere.
const CHUNK: usize = 1024;

/// What both skinning methods read: one character at one moment.
#[derive(Clone, Copy)]
pub struct SkinInput<'a> {
    /// Joints of this instance.
    pub joints: &'a [JointFrame],
    /// Positions at rest.
    pub positions_rest: &'a [Vec4],
    /// Where each vertex's influences begin; one longer than the vertices.
    pub offsets: &'a [u32],
    /// Influences of all vertices.
    pub influences: &'a [Influence],
}

impl<'a> SkinInput<'a> {
    fn influences_of(&self, vertex: usize) -> &'a [Influence] {
        &self.influences[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }

    fn run(&self, skinned: &mut [Vec4], one: impl Fn(&Self, usize) -> Vec4 + Sync) {
        skinned.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
            for (i, position) in out.iter_mut().enumerate() {
                *position = one(self, chunk * CHUNK + i);
            }
        });
    }
}

/// Linear blend skinning (paper A's reference 1; background 5): `v' = sum w_i M_i v`. Twin of `skin_linear`.
pub fn linear(input: &SkinInput, skinned: &mut [Vec4]) {
    input.run(skinned, linear_vertex);
}

/// Dual quaternion skinning after a first linear pass of the joints' stretch (Kavan 2008; background 5).
/// Twin of `skin_dual_quaternion`.
pub fn dual_quaternion(input: &SkinInput, skinned: &mut [Vec4]) {
    input.run(skinned, dual_quaternion_vertex);
}

fn linear_vertex(input: &SkinInput, vertex: usize) -> Vec4 {
    let mut m = Mat4::ZERO;
    for influence in input.influences_of(vertex) {
        let matrix = &input.joints[influence.joint as usize].matrix;
        m.x_axis += matrix.x_axis * influence.weight;
        m.y_axis += matrix.y_axis * influence.weight;
        m.z_axis += matrix.z_axis * influence.weight;
        m.w_axis += matrix.w_axis * influence.weight;
    }
    let p = input.positions_rest[vertex];
    let mut posed = m.x_axis * p.x + m.y_axis * p.y + m.z_axis * p.z + m.w_axis;
    posed.w = 1.0;
    posed
}

fn dual_quaternion_vertex(input: &SkinInput, vertex: usize) -> Vec4 {
    let influences = input.influences_of(vertex);
    let rest = input.positions_rest[vertex].xyz();
    let Some(first) = influences.first() else { return rest.extend(1.0) };
    // The strongest influence comes first: every other rotation is taken in its hemisphere.
    let pivot = input.joints[first.joint as usize].real;
    let (mut real, mut dual, mut p) = (Vec4::ZERO, Vec4::ZERO, Vec3::ZERO);
    for influence in influences {
        let joint = &input.joints[influence.joint as usize];
        let signed = if dot4(joint.real, pivot) < 0.0 { -influence.weight } else { influence.weight };
        real += joint.real * signed;
        dual += joint.dual * signed;
        p += transform_point(&joint.stretch, rest) * influence.weight;
    }
    let length = dot4(real, real).sqrt();
    let (real, dual) = (real / length, dual / length);
    let (r, d) = (real.xyz(), dual.xyz());
    let turned = r.cross(r.cross(p) + p * real.w);
    let moved = d * real.w - r * dual.w + r.cross(d);
    (p + turned * 2.0 + moved * 2.0).extend(1.0)
}

/// Four products summed in a stated order: glam's own sum pairs them another way than kernels do.
fn dot4(a: Vec4, b: Vec4) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w
}
