//! Relaxation of the skin along the field: as rigid as possible (background 2.2, with the normal term of prototypes 3).
//! Twins of the kernels `track_turn`, `track_span` and `track_slide`.

use super::{Track, TrackParams, carry::CHUNK, is_finite, not_finite, point};
use crate::rig::{Role, SkinEdge, VertexTarget};
use glam::{Mat3, Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

/// Iterations of the rotation's extraction, from where it was a pass ago.
pub(crate) const TURNS: u32 = 3;
/// Neighbours give no rotation where they agree with one by less than this share of what they could.
pub(crate) const WEAKEST_TURN: f32 = 1e-3;

/// What relaxation reads of a character.
#[derive(Clone, Copy)]
pub struct RelaxInput<'a> {
    /// Targets of all vertices.
    pub targets: &'a [VertexTarget],
    /// Edges of all vertices.
    pub edges: &'a [SkinEdge],
    /// Positions at rest.
    pub positions_rest: &'a [Vec4],
}

impl<'a> RelaxInput<'a> {
    fn edges_of(&self, target: &VertexTarget) -> &'a [SkinEdge] {
        &self.edges[target.edge_begin as usize..target.edge_end as usize]
    }
}

/// Turns the rotation of every vertex that is asked for one to the one that takes its edges at rest nearest to what they are, and the field's normal
/// at rest to what it is.
///
/// `S = sum w e e0^T + wn (sum w |e0|²) n n0^T`, and the nearest rotation by a few steps of Müller's extraction (2016) in
/// the form without sines: `q <- normalize(q + (omega, 0) q / 2)`.
pub fn turn(params: &TrackParams, input: &RelaxInput, positions: &[Vec4], tracks: &mut [Track]) {
    tracks.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, tracks)| {
        for (k, track) in tracks.iter_mut().enumerate() {
            let vertex = chunk * CHUNK + k;
            if input.targets[vertex].turns != 0 {
                track.rotation = turn_one(params, input, positions, vertex, track);
            }
        }
    });
}

fn turn_one(params: &TrackParams, input: &RelaxInput, positions: &[Vec4], vertex: usize, track: &Track) -> Vec4 {
    let target = &input.targets[vertex];
    let (p, p_rest) = (point(&positions[vertex]), point(&input.positions_rest[vertex]));
    let (mut x, mut y, mut z) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
    let mut size = 0.0;
    for edge in input.edges_of(target) {
        let e = p - point(&positions[edge.neighbour as usize]);
        let rest = (p_rest - point(&input.positions_rest[edge.neighbour as usize])) * edge.weight;
        (x, y, z) = (x + e * rest.x, y + e * rest.y, z + e * rest.z);
        let e_rest = p_rest - point(&input.positions_rest[edge.neighbour as usize]);
        size += edge.weight * e_rest.dot(e_rest);
    }
    let normal = track.normal.xyz() * (params.normal_weight * size);
    let rest = target.normal_rest.xyz();
    (x, y, z) = (x + normal * rest.x, y + normal * rest.y, z + normal * rest.z);
    let mut q = track.rotation;
    for _ in 0..TURNS {
        let r = matrix(q);
        let along = (r.x_axis.dot(x) + r.y_axis.dot(y) + r.z_axis.dot(z)).abs();
        let around = r.x_axis.cross(x) + r.y_axis.cross(y) + r.z_axis.cross(z);
        let least = WEAKEST_TURN * size;
        if along <= least && around.dot(around) <= least * least {
            break;
        }
        q = turned(q, around / along.max(least));
    }
    if not_finite(q.x + q.y + q.z + q.w) { Vec4::W } else { q }
}

/// `normalize(q + (omega, 0) q / 2)`.
fn turned(q: Vec4, omega: Vec3) -> Vec4 {
    let half = omega * 0.5;
    let v = q.xyz();
    let sum = (v + half * q.w + half.cross(v)).extend(q.w - half.dot(v));
    sum / (sum.x * sum.x + sum.y * sum.y + sum.z * sum.z + sum.w * sum.w).sqrt()
}

/// The rotation matrix of a unit quaternion.
fn matrix(q: Vec4) -> Mat3 {
    let (x2, y2, z2) = (q.x + q.x, q.y + q.y, q.z + q.z);
    let (xx, xy, xz) = (q.x * x2, q.x * y2, q.x * z2);
    let (yy, yz, zz) = (q.y * y2, q.y * z2, q.z * z2);
    let (wx, wy, wz) = (q.w * x2, q.w * y2, q.w * z2);
    Mat3::from_cols(
        Vec3::new(1.0 - (yy + zz), xy + wz, xz - wy),
        Vec3::new(xy - wz, 1.0 - (xx + zz), yz + wx),
        Vec3::new(xz + wy, yz - wx, 1.0 - (xx + yy)),
    )
}

/// What the edges of every vertex at rest come to, turned as the skin around them has: `xyz` is
/// `sum w (R_i + R_j) / 2 (v0_i - v0_j) / sum w`, metres, and `w` one over the sum of weights; nothing of vertices that do not
/// slide. All sweeps of a pass share it, since only positions change between them.
pub fn span(input: &RelaxInput, tracks: &[Track], spans: &mut [Vec4]) {
    spans.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, spans)| {
        for (k, out) in spans.iter_mut().enumerate() {
            *out = span_one(input, tracks, chunk * CHUNK + k);
        }
    });
}

fn span_one(input: &RelaxInput, tracks: &[Track], vertex: usize) -> Vec4 {
    let target = &input.targets[vertex];
    if target.role != Role::Active as u32 || target.slides == 0 {
        return Vec4::ZERO;
    }
    let rotation = matrix(tracks[vertex].rotation);
    let p_rest = point(&input.positions_rest[vertex]);
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for edge in input.edges_of(target) {
        let other = edge.neighbour as usize;
        let e = p_rest - point(&input.positions_rest[other]);
        sum += (apply(&rotation, e) + apply(&matrix(tracks[other].rotation), e)) * (0.5 * edge.weight);
        weights += edge.weight;
    }
    let share = 1.0 / weights;
    (sum * share).extend(share)
}

/// One sweep of Jacobi's method on the elastic energy, along the field alone: every active vertex goes to where its
/// neighbours' edges would have it, less the way across the field's surface.
///
/// `v* = sum w (v_j + (R_i + R_j) / 2 (v0_i - v0_j)) / sum w`, then `v <- v + (I - n n^T)(v* - v)`; less than that where
/// skin presses against skin: a fold's crumpled edges, stretched out at once, would cross the fold. `spans` are [`span`]'s.
pub fn slide(
    params: &TrackParams,
    input: &RelaxInput,
    tracks: &[Track],
    spans: &[Vec4],
    positions: &[Vec4],
    slid: &mut [Vec4],
) {
    slid.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, slid)| {
        for (k, out) in slid.iter_mut().enumerate() {
            let vertex = chunk * CHUNK + k;
            *out = slide_one(params, input, &tracks[vertex], &spans[vertex], positions, vertex);
        }
    });
}

fn slide_one(
    params: &TrackParams,
    input: &RelaxInput,
    track: &Track,
    span: &Vec4,
    positions: &[Vec4],
    vertex: usize,
) -> Vec4 {
    let target = &input.targets[vertex];
    let own = positions[vertex];
    let normal = track.normal.xyz();
    if target.role != Role::Active as u32 || target.slides == 0 {
        return own;
    }
    let mut sum = Vec3::ZERO;
    for edge in input.edges_of(target) {
        sum += point(&positions[edge.neighbour as usize]) * edge.weight;
    }
    let way = sum * span.w + span.xyz() - point(&own);
    let share = 1.0 - params.contact_hold * track.contact;
    let slid = point(&own) + (way - normal * normal.dot(way)) * share;
    if is_finite(slid) { slid.extend(1.0) } else { own }
}

/// A matrix times a vector, column by column.
fn apply(m: &Mat3, v: Vec3) -> Vec3 {
    m.x_axis * v.x + m.y_axis * v.y + m.z_axis * v.z
}
