//! Typed errors: what failed, in which file and element, and what to do about it.

mod field;
mod rig;
mod setup;

pub use field::{FieldError, HrbfError};
pub use rig::{MuscleError, MuscleFileError, PoseError, RigError};
pub use setup::SetupError;
mod device;

pub use device::DeviceError;
mod output;

pub use output::OutputError;
