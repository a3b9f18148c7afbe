//! Scalar fields: 0..=1 with compact support, surface at 0.5, gradient inward. Raw distances are negative inside.

pub mod bound;
pub mod compose;
pub mod evaluate;
pub mod fold;
pub mod grid;
pub mod hrbf;
pub mod mesh_distance;
pub mod muscle;
pub mod poisson;
pub mod transfer;

pub use fold::Fold;

use glam::Vec3;

/// A field's value and gradient at one point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// 0 outside every support, 0.5 on the surface, 1 deep inside.
    pub value: f32,
    /// Points inward, per metre.
    pub gradient: Vec3,
}

crate::gpu_struct! {
    /// A field group's cached raw field: an oriented grid over the group's support, in scene space at rest.
    ///
    /// Node `(x, y, z)` is `nodes[offset + x + size_x * (y + size_y * z)]`, holding the gradient of the raw distance
    /// in `xyz` (scene space at rest) and the distance itself in `w`, metres.
    pub struct GroupGrid {
        /// Scene space at rest to grid coordinates: node `(x, y, z)` sits at exactly `(x, y, z)`.
        pub rest_to_grid: glam::Mat4,
        /// Index of the grid's first node in the shared node array.
        pub offset: u32,
        /// Nodes along the first axis.
        pub size_x: u32,
        /// Nodes along the second axis.
        pub size_y: u32,
        /// Nodes along the third axis.
        pub size_z: u32,
        /// Support radius r of the transfer, metres: the field is 0 where the distance is r or more.
        pub support_radius: f32,
        /// Index of the first muscle of this group.
        pub muscle_begin: u32,
        /// One past the index of its last muscle.
        pub muscle_end: u32,
        /// The joint that drives the group.
        pub joint: u32,
    }
}

impl crate::math::WgslType for GroupGrid {
    const WGSL: &'static str = <GroupGrid as crate::math::GpuStruct>::NAME;
}
