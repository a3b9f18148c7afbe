//! Offscreen pictures: skin, x-ray and muscles, with 4 samples a pixel, lit so that form shows.
//!
//! Objects by lifetime: [`Renderer`] per device, [`Targets`] per picture size, [`Look`] and [`SkinMesh`] per character,
//! [`Frame`] per picture. The skin is drawn straight from the deformer's vertex buffer; only muscles, which are small,
//! come from the host each frame.

mod axes;
mod bones;
mod camera;
mod color_mesh;
mod frame;
mod heat;
mod mesh;
mod muscles;
mod picture;
mod renderer;
pub mod shader;
mod targets;

pub use axes::{Paths, axis_meshes};
pub use bones::{bone_meshes, capsule_mesh};
pub use camera::{Camera, Direction, enclose};
pub use color_mesh::{ColorMesh, activation_color};
pub use frame::{Frame, Light, Surface, View};
pub use heat::{colored_skin, signed_color};
pub use mesh::{Look, MaterialParams, Run, SkinMesh, VERTEX_STRIDE, interleaved, vertex_buffer};
pub use muscles::{muscle_mesh, muscle_meshes};
pub use picture::{Picture, contact_sheet};
pub use renderer::Renderer;
pub use targets::Targets;
