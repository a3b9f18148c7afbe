//! Muscles out of the finished skin (paper B): sections across the limbs, the bumps in their outlines, ellipses in the
//! bumps, chains of ellipses along the bone, and of every chain a muscle that paper A's primitive can be.
//!
//! In order: [`section`] cuts the skin by a plane, [`outline`] samples and smooths what it cut, [`bump`] triangulates it and
//! prunes the triangles (background 6.1), [`ellipse`] fits a bump's crest (6.2), [`chain`] links bumps from section to
//! section and tells muscles from what only looks like one (prototypes 2), [`fit`] gives them profile and size.
//! [`limb`] lays the planes across a character's limbs, and [`muscle`] writes what was found as muscles of a file.

pub mod bump;
pub mod chain;
pub mod ellipse;
pub mod fit;
pub mod limb;
pub mod muscle;
pub mod outline;
pub mod section;

pub use muscle::{Extracted, Extraction, extract};

#[cfg(test)]
mod tests;
