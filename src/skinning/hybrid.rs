//! Linear skinning by bones and by muscles (paper B, equation 3).

use super::CHUNK;
use crate::rig::{Influence, JointFrame};
use glam::{Mat4, Vec4};
use rayon::prelude::*;

/// What it reads: one character at one moment.
#[derive(Clone, Copy)]
pub struct HybridInput<'a> {
    /// Joints of this instance.
    pub joints: &'a [JointFrame],
    /// Matrices of its muscles' joints.
    pub muscle_joints: &'a [Mat4],
    /// Positions at rest.
    pub positions_rest: &'a [Vec4],
    /// Where each vertex's influences begin; one longer than the vertices.
    pub offsets: &'a [u32],
    /// Influences of all vertices; muscles' joints are counted on from the character's.
    pub influences: &'a [Influence],
}

/// `v' = sum w_i M_i v` over bones and muscles. Twin of `skin_hybrid`.
pub fn hybrid(input: &HybridInput, skinned: &mut [Vec4]) {
    skinned.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
        for (i, position) in out.iter_mut().enumerate() {
            *position = hybrid_vertex(input, chunk * CHUNK + i);
        }
    });
}

fn hybrid_vertex(input: &HybridInput, vertex: usize) -> Vec4 {
    let bones = input.joints.len();
    let p = input.positions_rest[vertex];
    let mut posed = Vec4::ZERO;
    for influence in &input.influences[input.offsets[vertex] as usize..input.offsets[vertex + 1] as usize] {
        let joint = influence.joint as usize;
        let m = if joint < bones { &input.joints[joint].matrix } else { &input.muscle_joints[joint - bones] };
        posed += (m.x_axis * p.x + m.y_axis * p.y + m.z_axis * p.z + m.w_axis) * influence.weight;
    }
    posed.w = 1.0;
    posed
}
