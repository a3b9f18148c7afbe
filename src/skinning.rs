//! Geometric skinning: linear blending and dual quaternions, the march's starting point and baselines of their own; and
//! linear blending that muscles displace by weights, or take part in as joints.
//!
//! A vertex may have any number of influences. Positions are `Vec4` with `w = 1` throughout.

mod hybrid;
mod muscle_joint;
mod weighted;

pub use hybrid::{HybridInput, hybrid};
pub use muscle_joint::{MuscleJointInput, muscle_joints};
pub use weighted::{WeightedInput, WeightedParams, weighted};

#[cfg(feature = "gpu")]
pub(crate) use {
    muscle_joint::{LEAST_TURN, LONG, SHORT, SWELLS},
    weighted::{HELD, LEAST_SLOPE, LEFT, LONGEST, STEPS, TOLERANCE},
};

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
}

/// Linear blend skinning (paper A's reference 1; background 5): `v' = sum w_i M_i v`. Twin of `skin_linear`.
pub fn linear(input: &SkinInput, skinned: &mut [Vec4]) {
    skinned.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| linear_run_fastest(input, chunk * CHUNK, out));
}

/// Dual quaternion skinning after a first linear pass of the joints' stretch (Kavan 2008; background 5).
/// Twin of `skin_dual_quaternion`.
pub fn dual_quaternion(input: &SkinInput, skinned: &mut [Vec4]) {
    skinned.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
        for (i, position) in out.iter_mut().enumerate() {
            *position = dual_quaternion_vertex(input, chunk * CHUNK + i);
        }
    });
}

/// Skins `out.len()` vertices from `first` on.
#[inline(always)]
fn linear_run(input: &SkinInput, first: usize, out: &mut [Vec4]) {
    for (i, position) in out.iter_mut().enumerate() {
        let mut m = Mat4::ZERO;
        for influence in input.influences_of(first + i) {
            let matrix = &input.joints[influence.joint as usize].matrix;
            let weight = Vec4::splat(influence.weight);
            m.x_axis += matrix.x_axis * weight;
            m.y_axis += matrix.y_axis * weight;
            m.z_axis += matrix.z_axis * weight;
            m.w_axis += matrix.w_axis * weight;
        }
        let p = input.positions_rest[first + i];
        let mut posed = m.x_axis * p.x + m.y_axis * p.y + m.z_axis * p.z + m.w_axis;
        posed.w = 1.0;
        *position = posed;
    }
}

/// [`linear_run`] in the three-operand instructions of processors with AVX2: a third fewer, the same bits.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn linear_run_avx2(input: &SkinInput, first: usize, out: &mut [Vec4]) {
    linear_run(input, first, out);
}

#[cfg(target_arch = "x86_64")]
#[allow(
    unsafe_code,
    reason = "a function compiled for AVX2 may be called where the processor has it, which is asked first"
)]
fn linear_run_fastest(input: &SkinInput, first: usize, out: &mut [Vec4]) {
    if std::is_x86_feature_detected!("avx2") {
        // SAFETY: the feature has just been found.
        unsafe { linear_run_avx2(input, first, out) }
    } else {
        linear_run(input, first, out);
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn linear_run_fastest(input: &SkinInput, first: usize, out: &mut [Vec4]) {
    linear_run(input, first, out);
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

/// Bit test on a vector's size, because drivers fold `x != x` away.
fn is_finite(v: Vec3) -> bool {
    (v.dot(v).to_bits() & 0x7fff_ffff) < 0x7f80_0000
}

/// Four products summed in a stated order: glam's own sum pairs them another way than kernels do.
fn dot4(a: Vec4, b: Vec4) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_width_gives_the_same_bits() {
        let joint = |k: f32| JointFrame {
            matrix: glam::Mat4::from_rotation_y(k) * glam::Mat4::from_scale(Vec3::new(1.0, 1.1, 0.9 + k)),
            ..JointFrame::default()
        };
        let joints = [joint(0.3), joint(1.2), joint(-0.7)];
        let n = 500;
        let positions_rest: Vec<Vec4> =
            (0..n).map(|i| Vec4::new((i as f32).sin(), i as f32 * 0.01, 0.3, 1.0)).collect();
        let influences: Vec<Influence> = (0..3 * n as u32)
            .map(|i| Influence { joint: i % 3, weight: [0.5, 0.3, 0.2][(i as usize * 7 / 3) % 3] })
            .collect();
        let offsets: Vec<u32> = (0..=n as u32).map(|v| 3 * v).collect();
        let input =
            SkinInput { joints: &joints, positions_rest: &positions_rest, offsets: &offsets, influences: &influences };
        let (mut plain, mut fastest) = (vec![Vec4::ZERO; n], vec![Vec4::ZERO; n]);
        linear_run(&input, 0, &mut plain);
        linear_run_fastest(&input, 0, &mut fastest);
        assert_eq!(plain, fastest);
        let other = SkinInput { joints: &[joint(0.31), joint(1.2), joint(-0.7)], ..input };
        linear_run(&other, 0, &mut plain);
        assert_ne!(plain, fastest);
    }
}
