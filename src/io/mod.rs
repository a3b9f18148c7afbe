//! Files in and out.

pub mod gltf;
