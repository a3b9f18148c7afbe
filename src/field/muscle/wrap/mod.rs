//! Paths of muscles that lie round a bone or a joint.
//!
//! [`cylinder`] and [`sphere`] are those paths (paper B, "Bending Around a Joint" and "Bending Around a Bone"), each a pure
//! function of its two ends in the obstacle's own frame; [`circle`] is the plane problem under both, and [`WrapPath`] what
//! they give. [`MuscleWrap`] is an obstacle as a rig holds it, and [`Course`] the path of one muscle round it in one pose.

pub mod circle;
mod course;
pub mod cylinder;
mod path;
pub mod sphere;
#[cfg(test)]
mod tests;

pub use course::{Course, MuscleWrap, Spacing, points_at_rest};
pub(crate) use course::{REST_SHARE, TENDON_STIFFNESS};
pub use path::WrapPath;
#[cfg(feature = "gpu")]
pub(crate) use {
    circle::POINT,
    sphere::{HOLD, SHORT},
};

/// An end inside its obstacle is moved out to this many radii: at the radius itself its tangent is its own normal, and no
/// step along it leaves the end.
pub const CLEARANCE: f32 = 1.0 + 1e-4;
