//! Why no muscles can be found, and what makes it hard.

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
    /// A marked region is none of the character's.
    #[error("--must {mark}: there is no such region; there are {regions}")]
    NoRegion {
        /// What was asked for.
        mark: String,
        /// What there is.
        regions: String,
    },
    /// A marked region has no skin from which a muscle could be made.
    #[error("--must {mark}: fewer than five sections have skin in that range; widen it")]
    NothingThere {
        /// What was asked for.
        mark: String,
    },
}

/// What is odd about a character whose muscles were sought, and what was done about it.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExtractNote {
    /// The skin has borders.
    #[error("the skin is open at {edges} edges; planes that meet a hole around a limb are left out")]
    Open {
        /// Edges of one triangle.
        edges: usize,
    },
    /// The skin branches.
    #[error("{edges} edges have more than two triangles; sections end there")]
    Crowded {
        /// Such edges.
        edges: usize,
    },
    /// Triangles without area.
    #[error("{triangles} triangles have no area")]
    Flat {
        /// Such triangles.
        triangles: usize,
    },
    /// More than one part.
    #[error("the skin is of {shells} parts that do not hang together; a section is the innermost line round its bone")]
    Shells {
        /// Parts.
        shells: usize,
    },
    /// Triangles turned the wrong way.
    #[error("the skin is inside out; sections take no heed of it")]
    InsideOut,
    /// No trunk.
    #[error(
        "trunk, shoulders and neck are not searched: that takes two arms, two legs and feet or knees that tell the front"
    )]
    NoBody,
    /// A bone with little skin around it.
    #[error("{bone}: only {sections} of {planes} planes meet a closed skin around it")]
    FewSections {
        /// The bone's joint, or the group of planes.
        bone: String,
        /// Sections that it has.
        sections: usize,
        /// Planes that were laid.
        planes: usize,
    },
}
