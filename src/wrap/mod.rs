//! A muscle's path from its attachments, and the shape that its length gives it at constant volume.
//!
//! [`shape`] is what a frame runs. The paths round bones and joints are in [`field::muscle::wrap`](crate::field::muscle::wrap).

mod shape;
#[cfg(test)]
mod tests;

pub use shape::{MuscleParams, ShapeInput, posed_surface, shape};
