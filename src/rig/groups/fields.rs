//! One field per group: samples of the patch, caps at the joints, an interpolant, a grid.

use super::shape::Shape;
use super::{
    FieldGroups, Group,
    hinges::{self, FoldRest, Swing},
};
use crate::error::{FieldError, HrbfError};
use crate::field::GroupGrid;
use crate::field::grid::{self, FilledGrid};
use crate::field::hrbf::{HermiteSample, Hrbf};
use crate::field::poisson::{self, SurfaceSample};
use crate::rig::Character;
use glam::{DMat3, Vec4};
use rayon::prelude::*;

/// Support radius as a share of the median distance of a group's vertices from its bone. Groups that carry muscles would
/// have .5 to .75 (background 3.4), but under a fold of 130 degrees fields of .75 are 1 without a slope, and say nothing
/// to the skin there; of the prototypes' .75 to 1 it is 1.
pub const SUPPORT_SHARE: f64 = 1.0;
/// Up to this many groups a character counts as a limb and not as a body.
const LIMB_GROUPS: usize = 4;
/// Samples per group of a limb, and of a body.
const SAMPLES: [u32; 2] = [50, 100];
/// A cap nearer to a sample than this share of the samples' spacing is left out.
const CAP_CLEARANCE: f64 = 0.5;
/// Rejection as it is meant, then weaker until enough of the patch is left: share of [`Shape::is_clear`]'s drop, and
/// whether folds are rejected.
const REJECTIONS: [(f64, bool); 4] = [(1.0, true), (0.5, true), (0.0, true), (0.0, false)];
/// Rejection is weakened where more than this share of the patch's area would be lost.
const MOST_REJECTED: f64 = 0.8;

/// Most nodes of all grids, counted as cubes: 4 GiB, sixteen groups at the finest resolution.
const MOST_NODES: u64 = 1 << 28;

/// How fields are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldOptions {
    /// Samples per group, 8 to 400; `None` takes 50 for limbs (up to four groups) and 100 for bodies.
    pub samples: Option<u32>,
    /// Nodes along the longest side of a grid, 8 to 256.
    pub grid_resolution: u32,
    /// Seed of the sampling.
    pub seed: u64,
}

impl Default for FieldOptions {
    fn default() -> Self {
        FieldOptions { samples: None, grid_resolution: 48, seed: 1 }
    }
}

/// How well a group's field follows its patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FitReport {
    /// Name of the group.
    pub group: String,
    /// Vertices the group owns.
    pub vertices: u32,
    /// Samples interpolated, without caps.
    pub samples: u32,
    /// Closing caps interpolated.
    pub caps: u32,
    /// Share of the patch's area that was kept from sampling: next to joints and in folds, 0..=1.
    pub rejected: f32,
    /// Support radius, metres.
    pub support_radius: f32,
    /// Root mean square of the raw distance at the group's vertices away from joints, metres.
    pub rms_distance: f32,
    /// Median of its size there, metres.
    pub median_distance: f32,
    /// Largest size there, metres.
    pub max_distance: f32,
    /// Smallest over largest pivot of the fit.
    pub pivot_ratio: f64,
    /// Edge of a grid cell, metres.
    pub cell: f32,
    /// Nodes on the grid's faces whose distance was raised to close the support; above 0 the field ends at its box.
    pub raised_nodes: u32,
}

/// The fields of a character.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    /// One grid per group, in the groups' order; their muscle ranges are empty.
    pub grids: Vec<GroupGrid>,
    /// Nodes of all grids.
    pub nodes: Vec<Vec4>,
    /// One report per group.
    pub fits: Vec<FitReport>,
    /// Joints between groups.
    pub swings: Vec<Swing>,
    /// Those that fold.
    pub folds: Vec<FoldRest>,
}

/// Fits and caches the field of every group. The same input gives the same bytes.
///
/// # Errors
/// Refuses options out of range, groups whose samples cannot be interpolated, and grids that could pass 2^28 nodes.
pub fn build_fields(character: &Character, groups: &FieldGroups, options: &FieldOptions) -> Result<Fields, FieldError> {
    let samples = options.samples.unwrap_or(SAMPLES[usize::from(groups.groups.len() > LIMB_GROUPS)]);
    let check = |option, given, least, most| match (least..=most).contains(&given) {
        true => Ok(()),
        false => Err(FieldError::Option { option, given, least, most }),
    };
    check("samples", samples, 8, 400)?;
    check("grid_resolution", options.grid_resolution, 8, 256)?;

    let nodes = groups.groups.len() as u64 * u64::from(options.grid_resolution).pow(3);
    if nodes > MOST_NODES {
        return Err(FieldError::TooManyNodes { nodes, most: MOST_NODES });
    }

    let shapes = Shape::of_groups(character, groups);
    // Collected before the first error is looked for, so that the same group is named every time.
    let built: Vec<Result<(FilledGrid, FitReport), FieldError>> = groups
        .groups
        .par_iter()
        .zip(&shapes)
        .enumerate()
        .map(|(g, (group, shape))| {
            let seed = options.seed ^ (g as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            build(character, group, shape, samples as usize, options.grid_resolution, seed)
        })
        .collect();
    let built: Vec<(FilledGrid, FitReport)> = built.into_iter().collect::<Result<_, _>>()?;

    let total: usize = built.iter().map(|(filled, _)| filled.nodes.len()).sum();
    let mut fields = Fields {
        nodes: Vec::with_capacity(total),
        swings: hinges::swings(character, groups, &shapes),
        folds: hinges::folds(groups, &shapes, groups.groups.len() <= LIMB_GROUPS),
        ..Fields::default()
    };
    for (filled, fit) in built {
        fields.grids.push(GroupGrid { offset: fields.nodes.len() as u32, ..filled.grid });
        fields.nodes.extend(filled.nodes);
        fields.fits.push(fit);
    }
    Ok(fields)
}

/// Builds one group's field.
fn build(
    character: &Character,
    group: &Group,
    shape: &Shape,
    samples: usize,
    resolution: u32,
    seed: u64,
) -> Result<(FilledGrid, FitReport), FieldError> {
    let (sampling, drop) = REJECTIONS
        .iter()
        .map(|&(drop, folds)| {
            let keep = |s: &SurfaceSample| shape.is_clear(s.position, drop) && (!folds || shape.faces_out(s));
            (poisson::sample_patch(&shape.patch, samples, seed, keep), drop)
        })
        .find(|(sampling, _)| sampling.rejected <= MOST_REJECTED && !sampling.samples.is_empty())
        .unwrap_or_else(|| (poisson::sample_patch(&shape.patch, samples, seed, |_| true), 0.0));
    let mut points: Vec<HermiteSample> =
        sampling.samples.iter().map(|s| HermiteSample { position: s.position, normal: s.normal }).collect();
    let sample_count = points.len();
    for cap in shape.caps(&points) {
        let clearance = CAP_CLEARANCE * sampling.radius;
        if points.iter().all(|p| p.position.distance(cap.position) > clearance) {
            points.push(cap);
        }
    }
    let hrbf = Hrbf::fit(&points)
        // Caps that contradict the samples make the system singular; an open field is better than none.
        .or_else(|error| match error {
            HrbfError::Singular { .. } => Hrbf::fit(&points[..sample_count]),
            other => Err(other),
        })
        .map_err(|source| FieldError::Fit { group: group.name.clone(), vertices: shape.vertices.len(), source })?;

    let support_radius = SUPPORT_SHARE * shape.median_radius;
    let (y, z) = shape.axis.any_orthonormal_pair();
    let mut filled = grid::fill(&hrbf, DMat3::from_cols(shape.axis, y, z), support_radius, resolution);
    filled.grid.joint = group.joint;

    let mut distances: Vec<f64> = shape
        .vertices
        .par_iter()
        .map(|&v| character.positions_rest[v as usize].as_dvec3())
        .filter(|&p| shape.is_clear(p, drop))
        .map(|p| hrbf.sample(p).0.abs())
        .collect();
    distances.sort_by(f64::total_cmp);
    let count = distances.len().max(1) as f64;
    let fit = FitReport {
        group: group.name.clone(),
        vertices: shape.vertices.len() as u32,
        samples: sample_count as u32,
        caps: (points.len() - sample_count) as u32,
        rejected: sampling.rejected as f32,
        support_radius: support_radius as f32,
        rms_distance: (distances.iter().map(|d| d * d).sum::<f64>() / count).sqrt() as f32,
        median_distance: distances.get(distances.len() / 2).copied().unwrap_or(0.0) as f32,
        max_distance: distances.last().copied().unwrap_or(0.0) as f32,
        pivot_ratio: hrbf.pivot_ratio,
        cell: filled.cell,
        raised_nodes: filled.raised,
    };
    Ok((filled, fit))
}
