//! Why a motion cannot be chosen.

use thiserror::Error;

/// Why [`Scene::choose_clip`](crate::clip::Scene::choose_clip) found nothing.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ClipError {
    /// Neither a keyword nor the name or index of an animation.
    #[error("{character}: there is no clip `{wanted}`; choose rest, default{available}")]
    Unknown {
        /// The character.
        character: String,
        /// What was asked for.
        wanted: String,
        /// The animations that there are, each after a comma.
        available: String,
    },
    /// A clip made by code that moves what the skeleton does not have.
    #[error("{character}: clip `{clip}` needs {missing}, and the skeleton shows none; choose another clip")]
    Limb {
        /// The character.
        character: String,
        /// The clip.
        clip: &'static str,
        /// What was looked for.
        missing: &'static str,
    },
}
