//! Typed errors: what failed, in which file and element, and what to do about it.

mod device;

pub use device::DeviceError;
mod clip;
mod gltf;

pub use clip::ClipError;
pub use gltf::GltfError;
pub(crate) use gltf::one_line;
