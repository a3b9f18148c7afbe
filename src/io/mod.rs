//! Files in and out.

pub mod atomic;
pub mod gltf;
pub mod obj;
pub mod pc2;
pub mod png;
