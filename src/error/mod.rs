//! Typed errors: what failed, in which file and element, and what to do about it.

mod device;

pub use device::DeviceError;
