//! Files in and out.

pub mod atomic;
pub mod obj;
pub mod pc2;
pub mod png;
pub mod gltf;
