//! Normals of the deformed skin from its faces, and the output vertex. Twin of the kernel `normals`.

mod crease;

pub use crease::Creases;

use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

crate::gpu_struct! {
    /// Sizes, and where a vertex goes in the output, in 32-bit words.
    pub struct NormalParams {
        /// Vertices of the character.
        pub vertex_count: u32,
        /// Instances in the batch.
        pub instance_count: u32,
        /// Words before the first vertex.
        pub offset: u32,
        /// Words from one vertex to the next.
        pub stride: u32,
        /// Words from a vertex's start to its position.
        pub position_at: u32,
        /// Words from a vertex's start to its normal.
        pub normal_at: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
    }
}

/// Corner indices of the triangles and, per vertex, the triangles around it.
///
/// Vertices that share position and normal at rest share their triangles, so that seams shade smoothly and hard
/// edges stay hard.
#[derive(Clone, Copy)]
pub struct Fans<'a> {
    /// Corner indices, three per triangle.
    pub triangles: &'a [u32],
    /// Per vertex, where its triangles begin and end in `members`.
    pub fans: &'a [[u32; 2]],
    /// Triangle indices.
    pub members: &'a [u32],
}

/// Area-weighted face normals of one instance: `normals` gets one unit normal per vertex, +Y where faces cancel.
pub fn from_faces(fans: &Fans, positions: &[Vec4], normals: &mut [Vec4]) {
    normals.par_iter_mut().with_min_len(256).enumerate().for_each(|(vertex, normal)| {
        let mut sum = Vec3::ZERO;
        let [begin, end] = fans.fans[vertex];
        for &triangle in &fans.members[begin as usize..end as usize] {
            let corner = |i: u32| positions[fans.triangles[(3 * triangle + i) as usize] as usize].xyz();
            let (a, b, c) = (corner(0), corner(1), corner(2));
            sum += (b - a).cross(c - a);
        }
        let squared = sum.dot(sum);
        let unit = if squared > 1e-30 { sum / squared.sqrt() } else { Vec3::Y };
        *normal = unit.extend(0.0);
    });
}
