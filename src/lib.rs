#![doc = include_str!("../README.md")]

pub mod clip;
pub mod dynamics;
pub mod error;
pub mod extract;
pub mod field;
#[cfg(feature = "figures")]
pub mod figures;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod io;
#[cfg(feature = "gpu")]
pub mod kernel;
pub mod math;
pub mod normals;
pub mod parity;
pub mod reference;
#[cfg(feature = "gpu")]
pub mod render;
pub mod rig;
pub mod schedule;
pub mod skinning;
pub mod tracking;
pub mod wrap;

#[cfg(feature = "gpu")]
pub use wgpu;
