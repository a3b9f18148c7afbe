//! What moves a muscle's parameters: keys, drivers, tables over time, attack and decay (paper A, section 8.4.1).
//!
//! ```text
//! drivers in order, joined by max, add or multiply      length ratio | joint angle | constant | table over time
//!   -> the activation key, joined as the muscle says    the pose's, else the file's
//!   -> 0..=1; attack and decay where Effort advances    -> MuscleParameters
//! ```

mod curve;
mod drives;
mod effort;
mod parameters;
mod source;
mod table;

#[cfg(test)]
mod tests;

pub use drives::Drives;
pub use effort::Effort;
pub use parameters::{MuscleParameters, ShapeBlend};
pub use table::{Table, load_tables};
