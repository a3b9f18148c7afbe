//! The GPU side, objects by lifetime: [`Kernels`] once per device, [`RigBuffers`] once per character, [`Instance`] or
//! [`Batch`] per thing that moves, poses and options per frame.
//!
//! On this path the library never submits, polls, maps or makes a device: only [`Headless`] and [`readback`] do.

mod buffers;
mod checkpoint;
mod headless;
mod instance;
mod kernels;
mod output;
pub mod readback;
mod rig_buffers;

pub use checkpoint::Checkpoint;
pub use headless::{DeviceChoice, Headless, adapters};
pub use instance::{Batch, Instance};
pub use kernels::Kernels;
pub use output::{Output, OutputLayout};
pub use rig_buffers::RigBuffers;
