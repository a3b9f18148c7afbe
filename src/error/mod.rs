//! Typed errors: what failed, in which file and element, and what to do about it.

mod device;
mod field;
mod output;
mod rig;
mod setup;

pub use device::DeviceError;
pub use field::{FieldError, HrbfError};
pub use output::OutputError;
pub use rig::{MuscleError, MuscleFileError, PoseError, RigError};
pub use setup::SetupError;
