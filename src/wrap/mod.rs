//! A muscle's path from its attachments, and the shape that its length gives it at constant volume.
//!
//! [`shape`] is what a frame runs. [`cylinder`] and [`sphere`] are the paths of muscles that lie round a bone or a joint
//! (paper B, "Bending Around a Joint" and "Bending Around a Bone"), each a pure function of its two ends in the obstacle's
//! own frame; [`circle`] is the plane problem under both, and [`WrapPath`] what they give.

pub mod circle;
pub mod cylinder;
mod path;
mod shape;
pub mod sphere;
#[cfg(test)]
mod tests;

pub use path::WrapPath;
pub use shape::{MuscleParams, ShapeInput, posed_surface, shape};

/// An end inside its obstacle is moved out to this many radii: at the radius itself its tangent is its own normal, and no
/// step along it leaves the end.
pub const CLEARANCE: f32 = 1.0 + 1e-4;
