//! Why no muscles can be found.

use thiserror::Error;

/// Why [`extract`](crate::extract::extract) found nothing to cut.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExtractError {
    /// The skeleton shows neither arms nor legs.
    #[error("{character}: the skeleton shows no arms and no legs to cut across; `sinew inspect` lists its joints")]
    NoLimbs {
        /// The character.
        character: String,
    },
    /// No plane across any limb met a closed outline around its bone.
    #[error(
        "{character}: none of {planes} planes across {bones} bones meets a closed skin around its bone; the skin is open, or \
         elsewhere than its joints"
    )]
    NoOutlines {
        /// The character.
        character: String,
        /// Planes that were tried.
        planes: usize,
        /// Bones that they were laid across.
        bones: usize,
    },
}
