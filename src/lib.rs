//! Sinew deforms a character's skin from the muscles under it.

pub mod clip;
pub mod error;
pub mod field;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod io;
pub mod math;
#[cfg(feature = "gpu")]
pub mod render;
pub mod rig;
