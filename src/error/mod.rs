//! Typed errors: what failed, in which file and element, and what to do about it.

mod clip;
mod device;
mod extract;
mod field;
mod figure;
mod gltf;
mod output;
mod rig;
mod setup;
mod table;

pub use clip::ClipError;
pub use device::DeviceError;
pub use extract::{ExtractError, ExtractNote};
pub use field::{FieldError, HrbfError, MeshDistanceError};
pub use figure::FigureError;
pub use gltf::GltfError;
pub(crate) use gltf::{is_unprintable, one_line};
pub use output::OutputError;
pub use rig::{BoneError, GroupError, JointError, MuscleError, MuscleFileError, PoseError, RigError, WeightError};
pub use setup::SetupError;
pub use table::TableError;
