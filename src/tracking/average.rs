//! A pose by itself: where its skin starts, and relaxation towards the mean of neighbours (Implicit Skinning 2013;
//! background 1.13 and 1.14). Twins of the kernels `track_start` and `track_average`.

use super::{RUNS, Track, TrackParams, Way, carry::CHUNK, is_finite, point};
use crate::rig::{Role, SkinEdge, VertexTarget};
use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

/// Puts every vertex where geometric skinning has it, and forgets what the tracker kept of it. A skin without a new pose stays
/// as it is.
pub fn start(way: &Way, skinned: &[Vec4], positions: &mut [Vec4], tracks: &mut [Track]) {
    if way.count == 0 {
        tracks.iter_mut().for_each(|track| track.runs = 0);
        return;
    }
    positions.copy_from_slice(skinned);
    tracks.fill(Track { runs: RUNS, ..Track::REST });
}

/// What averaging reads of a character.
#[derive(Clone, Copy)]
pub struct AverageInput<'a> {
    /// Targets of all vertices.
    pub targets: &'a [VertexTarget],
    /// Edges of all vertices.
    pub edges: &'a [SkinEdge],
    /// Mean value coordinates at rest, one per edge.
    pub mean_values: &'a [f32],
}

/// One sweep of relaxation. In the passes every active vertex goes along the field towards where its mean value coordinates
/// at rest would have it among its neighbours, by a share that falls to nothing as it arrives:
///
/// `v <- v + mu (I - n n^T) sum w_j (v_j - v)`, `mu = 1 - (1 - |f - iso|)^4`, where n and f are those of the last step. After
/// them it goes to its neighbours' plain mean where skin presses against skin, by `beta`, the mean of how much it
/// and its neighbours press.
pub fn average(
    params: &TrackParams,
    input: &AverageInput,
    tracks: &[Track],
    positions: &[Vec4],
    averaged: &mut [Vec4],
) {
    averaged.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, averaged)| {
        for (k, out) in averaged.iter_mut().enumerate() {
            *out = average_one(params, input, tracks, positions, chunk * CHUNK + k);
        }
    });
}

fn average_one(
    params: &TrackParams,
    input: &AverageInput,
    tracks: &[Track],
    positions: &[Vec4],
    vertex: usize,
) -> Vec4 {
    let target = &input.targets[vertex];
    let own = positions[vertex];
    if target.role != Role::Active as u32 || target.slides == 0 {
        return own;
    }
    let (p, track) = (point(&own), &tracks[vertex]);
    let (mut mean, mut sum) = (Vec3::ZERO, Vec3::ZERO);
    let mut contact = track.contact;
    for k in target.edge_begin as usize..target.edge_end as usize {
        let other = input.edges[k].neighbour as usize;
        let e = point(&positions[other]) - p;
        mean += e;
        sum += e * input.mean_values[k];
        contact += tracks[other].contact;
    }
    let count = (target.edge_end - target.edge_begin) as f32;
    let moved = if params.projects != 0 {
        p + mean * (contact / ((count + 1.0) * count))
    } else {
        let left = 1.0 - track.residual().abs().min(1.0);
        let squared = left * left;
        let normal = track.normal.xyz();
        p + (sum - normal * normal.dot(sum)) * (1.0 - squared * squared)
    };
    if is_finite(moved) { moved.extend(1.0) } else { own }
}
