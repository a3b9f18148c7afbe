//! What a character is: skeleton, mesh, influences, field groups, muscles; and what one pose makes of it.

mod character;
pub mod groups;

pub use character::{Character, Image, Influence, Joint, Material, Part, Pose};
