//! Muscles out of the finished skin (paper B): sections across limbs, trunk and neck, the bumps in their outlines, ellipses in the
//! bumps, chains of ellipses along the muscle, and of every chain a muscle that paper A's primitive can be.
//!
//! In order: [`section`] cuts the skin by a plane, [`window`] leaves out what is another part of the body, [`outline`] samples and
//! smooths the rest, [`bump`] triangulates it and prunes the triangles (background 6.1), or finds where near-planar ones vary,
//! [`ellipse`] fits a bump's crest (6.2), [`chain`] links bumps from section to section, [`stretch`] and [`chain`] tell muscles from
//! what only looks like one (prototypes 2), [`fit`] gives them profile and size. [`limb`] and [`trunk`] lay the planes across a
//! [`body`], [`muscle`] writes what was found as muscles of a file, [`name`] proposes what they are, and
//! [`loft`] draws them as closed meshes.

pub mod body;
pub mod bump;
pub mod chain;
pub mod check;
pub mod ellipse;
pub mod extraction;
pub mod fit;
pub mod limb;
pub mod loft;
pub mod mark;
pub mod muscle;
pub mod name;
pub mod outline;
pub mod section;
pub mod stretch;
pub mod trunk;
mod trunk_muscle;
pub mod window;
mod wrap;

pub use extraction::{Extraction, extract};
pub use mark::Mark;
pub use muscle::Extracted;

#[cfg(test)]
mod tests;
