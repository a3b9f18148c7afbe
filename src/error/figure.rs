//! What can go wrong in drawing a figure.

use super::{DeviceError, PoseError, RigError, SetupError};

/// Why a figure could not be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// There is no figure of that name.
    #[error("{wanted:?} is no figure; choose among {known}")]
    Unknown {
        /// What was asked for.
        wanted: String,
        /// The figures there are.
        known: String,
    },
    /// The plotting library failed.
    #[error("a plot cannot be drawn: {problem}")]
    Draw {
        /// In its words.
        problem: String,
    },
    /// A figure needs what the stage lacks.
    #[error("figure {figure} needs {what}")]
    Lacks {
        /// The figure.
        figure: &'static str,
        /// What it needs.
        what: &'static str,
    },
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The device cannot take the character.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A pose does not fit its character.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// A made-up character does not hold.
    #[error(transparent)]
    Rig(#[from] RigError),
}
