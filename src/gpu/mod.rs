//! The GPU side: device, kernels, buffers by lifetime.

mod headless;
pub mod readback;

pub use headless::{DeviceChoice, Headless, adapters};
