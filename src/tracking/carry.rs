//! Where the tracker starts in a sub-pose, and what of it goes to the copies at seams. Twins of the kernels `track_carry`,
//! `track_place` and `track_spread`.

use super::{ENDS, RUNS, StopReason, Track, TrackJoint, TrackParams, Way, is_finite, point};
use crate::{
    field::evaluate::Place,
    math::{affine_inverse, smoothstep, transform_point},
    rig::{Influence, NO_JOINT, Reach, Role, VertexTarget},
};
use glam::{Mat4, Vec4, Vec4Swizzles};
use rayon::prelude::*;

/// Vertices per parallel task: fixed, so that the same input is cut the same way everywhere.
pub(super) const CHUNK: usize = 256;

/// What [`carry`] reads: one character at one sub-pose.
#[derive(Clone, Copy)]
pub struct CarryInput<'a> {
    /// Joints at the sub-pose.
    pub joints: &'a [TrackJoint],
    /// Positions at rest.
    pub positions_rest: &'a [Vec4],
    /// Where each vertex's influences begin; one longer than the vertices.
    pub offsets: &'a [u32],
    /// Influences of all vertices.
    pub influences: &'a [Influence],
    /// Targets of all vertices.
    pub targets: &'a [VertexTarget],
}

/// Carries every vertex on from the sub-pose before, by its joints' motion blended linearly, and draws it to where linear
/// skinning from the rest pose has it: wholly where it is passive, by the anchor where nothing presses it (prototypes 3).
/// Without a sub-pose it only says what is left to do.
pub fn carry(params: &TrackParams, way: &Way, input: &CarryInput, positions: &mut [Vec4], tracks: &mut [Track]) {
    let chunks = positions.par_chunks_mut(CHUNK).zip(tracks.par_chunks_mut(CHUNK)).enumerate();
    chunks.for_each(|(chunk, (positions, tracks))| {
        for (k, (position, track)) in positions.iter_mut().zip(tracks).enumerate() {
            if params.sub_pose >= way.count {
                (track.runs, track.passes) = if way.posed != 0 { (ENDS, 0) } else { (0, track.passes) };
                continue;
            }
            carry_one(params.anchor * way.turn, input, chunk * CHUNK + k, position, track);
        }
    });
}

fn carry_one(anchor: f32, input: &CarryInput, vertex: usize, position: &mut Vec4, track: &mut Track) {
    let target = &input.targets[vertex];
    if target.role == Role::Copy as u32 {
        return;
    }
    let (mut matrix, mut carry) = (Mat4::ZERO, Mat4::ZERO);
    for influence in &input.influences[input.offsets[vertex] as usize..input.offsets[vertex + 1] as usize] {
        let joint = &input.joints[influence.joint as usize];
        matrix += joint.matrix * influence.weight;
        carry += joint.carry * influence.weight;
    }
    let linear = transform_point(&matrix, point(&input.positions_rest[vertex]));
    let broken = track.stop == StopReason::NonFinite as u32;
    (track.runs, track.passes, track.stop) = (RUNS, 0, 0);
    if target.role == Role::Passive as u32 || broken {
        *position = linear.extend(1.0);
        return;
    }
    let p = point(position);
    let carried = p + transform_point(&carry, p);
    let way = linear - carried;
    let away = way.dot(way).sqrt() / target.normal_rest.w.max(LEAST_AWAY);
    let drawn = carried + way * pull(anchor * (1.0 - track.contact), away);
    *position = if is_finite(drawn) { drawn } else { linear }.extend(1.0);
}

/// How far a vertex is drawn to linear skinning, 0..=1, that is `away` from it in the distance from which it counts as lost
/// ([`VertexTarget::normal_rest`]): by its anchor, and further where it is lost, pressed or not. Where bones pass through each other
/// skin is torn along them, every vertex on its own surface, and neither the field nor the relaxation untangles it.
fn pull(anchor: f32, away: f32) -> f32 {
    anchor + (LOST_PULL - anchor).max(0.0) * (away - 1.0).clamp(0.0, 1.0)
}

/// How far a sub-pose draws a vertex that is lost wholly, at twice that distance: whatever its joints turn, unlike the anchor, so that
/// slow motion finds back too.
pub(crate) const LOST_PULL: f32 = 0.3;
/// The least such distance, metres.
pub(crate) const LEAST_AWAY: f32 = 1e-6;

/// The frames through which vertices see the groups of their reaches: joints blended, and drawn to another one's beside
/// hips and opening shoulders (prototypes 5). One place per reach.
pub fn place(joints: &[TrackJoint], reaches: &[Reach], blends: &[Influence], places: &mut [Place]) {
    places.par_chunks_mut(CHUNK).zip(reaches.par_chunks(CHUNK)).for_each(|(places, reaches)| {
        for (place, reach) in places.iter_mut().zip(reaches) {
            *place = place_one(joints, reach, blends);
        }
    });
}

fn place_one(joints: &[TrackJoint], reach: &Reach, blends: &[Influence]) -> Place {
    let mut matrix = Mat4::ZERO;
    for influence in &blends[reach.blend_begin as usize..reach.blend_end as usize] {
        matrix += joints[influence.joint as usize].matrix * influence.weight;
    }
    if reach.other != NO_JOINT {
        matrix += (joints[reach.other as usize].matrix - matrix) * drawn_share(joints, reach);
    }
    Place {
        to_rest: affine_inverse(&matrix).0,
        group: reach.group,
        limit: reach.limit,
        join: reach.join,
        ..Place::default()
    }
}

/// By how much a reach's frame is drawn to its other joint's, 0..=1: its share, as far as the gate is open.
#[inline]
pub fn drawn_share(joints: &[TrackJoint], reach: &Reach) -> f32 {
    if reach.gate == NO_JOINT {
        return reach.share;
    }
    let swing = joints[reach.gate as usize].swing;
    let towards = reach.side.xyz().dot(swing.xyz());
    reach.share * (smoothstep((OPEN_FROM - towards) / OPEN_RANGE) * swing.w)
}

/// Cosine between a vertex's side of a shoulder and the arm's swing under which the shoulder opens there, and the range
/// over which it does.
pub(crate) const OPEN_FROM: f32 = 0.2;
/// See [`OPEN_FROM`].
pub(crate) const OPEN_RANGE: f32 = 0.6;

/// The positions of all vertices, from those of the first copies.
pub fn spread(targets: &[VertexTarget], positions: &[Vec4], tracked: &mut [Vec4]) {
    tracked.iter_mut().zip(targets).for_each(|(out, target)| *out = positions[target.copy_of as usize]);
}
