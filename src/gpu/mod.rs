//! The GPU side: device, kernels, buffers by lifetime.

mod headless;
pub mod readback;
mod timing;

pub use headless::{DeviceChoice, Headless, adapters};
pub use timing::Timer;
