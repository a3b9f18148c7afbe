//! Errors of building fields from a character's skin.

use thiserror::Error;

/// Why Hermite samples could not be interpolated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HrbfError {
    /// Fewer distinct samples than an interpolant with a closed surface needs.
    #[error("{found} distinct samples, at least {needed} are needed")]
    TooFewSamples {
        /// Samples left after duplicates were dropped.
        found: usize,
        /// The least number that is accepted.
        needed: usize,
    },
    /// A sample holds a NaN or an infinity, or its normal has no direction.
    #[error("sample {sample} has a non-finite position or normal, or a normal of length zero")]
    BadSample {
        /// Index into the given samples.
        sample: usize,
    },
    /// The system has no reliable solution.
    #[error("the interpolation system is singular: pivot ratio {pivot_ratio:.1e}, residual {residual:.1e} of the size")]
    Singular {
        /// Smallest over largest pivot of the factorisation.
        pivot_ratio: f64,
        /// Largest error of value and gradient at the samples, in units of the samples' extent.
        residual: f64,
    },
}

/// Why a character's field groups could not be turned into fields.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FieldError {
    /// A group's samples could not be interpolated.
    #[error(
        "field group `{group}` ({vertices} vertices) cannot be fitted: {source}; \
         merge its joints into a neighbour or leave it to linear skinning"
    )]
    Fit {
        /// Name of the group.
        group: String,
        /// Vertices the group owns.
        vertices: usize,
        /// What went wrong.
        source: HrbfError,
    },
    /// An option lies outside what is supported.
    #[error("field option `{option}` is {given}, allowed are {least} to {most}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// The value asked for.
        given: u32,
        /// Smallest value allowed.
        least: u32,
        /// Largest value allowed.
        most: u32,
    },
    /// The grids together could need more memory than fields may take.
    #[error("the field grids may need {nodes} nodes, at most {most} are allowed; lower the grid resolution")]
    TooManyNodes {
        /// Nodes of all groups, if every grid were a cube.
        nodes: u64,
        /// Most nodes that are allowed.
        most: u64,
    },
}

/// Why a mesh has no distance field.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshDistanceError {
    /// More triangles than are looked through.
    #[error("{triangles} triangles, at most {most} are read; give a simpler mesh or a capsule")]
    TooManyTriangles {
        /// Triangles of the mesh.
        triangles: usize,
        /// Most triangles that are read.
        most: usize,
    },
    /// Nothing to be near to, or nothing that f32 can place.
    #[error("it has no size, or lies too far from the origin for its size; give another one or a capsule")]
    NoSize,
    /// Triangles lie over one another in great numbers.
    #[error("too many of its triangles lie over one another; give a simpler mesh or a capsule")]
    Tangled,
}
