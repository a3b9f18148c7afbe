//! One Newton step of every vertex towards its rest iso-value (background 1.12). Twin of the kernel `track_march`.

use super::{RUNS, StopReason, Track, TrackParams, carry::CHUNK, not_finite, point};
use crate::{
    field::evaluate::{FieldInput, NO_GROUP, Place},
    rig::{Role, VertexTarget},
};
use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

/// Squared gradient, per square metre, under which a field gives no direction (background 1.12).
pub(crate) const MIN_GRADIENT_SQUARED: f32 = 1e-5;

/// The composed field at many points: `xyz` is the gradient, `w` the value. Twin of the kernel `field_sample`.
pub fn sample(field: &FieldInput, points_posed: &[Vec4], samples: &mut [Vec4]) {
    samples.par_iter_mut().with_min_len(64).zip(points_posed).for_each(|(out, p)| {
        let sample = field.composed(p.xyz()).sample;
        *out = sample.gradient.extend(sample.value);
    });
}

/// Moves every active vertex by one relaxed Newton step along the gradient of the field that it tracks
/// ([`FieldInput::own_side`]), and notes where it stood.
///
/// `targets`, `positions` and `tracks` have one entry per vertex, `places` one per reach.
pub fn march(
    params: &TrackParams,
    field: &FieldInput,
    targets: &[VertexTarget],
    places: &[Place],
    positions: &mut [Vec4],
    tracks: &mut [Track],
) {
    let chunks = positions.par_chunks_mut(CHUNK).zip(tracks.par_chunks_mut(CHUNK)).zip(targets.par_chunks(CHUNK));
    chunks.for_each(|((positions, tracks), targets)| {
        for ((position, track), target) in positions.iter_mut().zip(tracks).zip(targets) {
            if target.role == Role::Active as u32 && track.stop != StopReason::NonFinite as u32 && !rests(params, track)
            {
                let own = &places[target.reach_begin as usize..target.reach_end as usize];
                *position = step(params, field, target, own, point(position), track).extend(1.0);
            }
        }
    });
}

/// Field difference from which the last passes leave a vertex alone: their step before has left a fifth of it.
pub(crate) const SETTLED: f32 = 1e-4;

/// Whether a vertex has arrived in one of the last passes, between which nothing moves but its own step.
fn rests(params: &TrackParams, track: &Track) -> bool {
    let relaxed = if track.runs == RUNS { params.passes } else { 0 };
    params.projects != 0 && track.passes > relaxed && track.normal.w.abs() < SETTLED
}

fn step(
    params: &TrackParams,
    field: &FieldInput,
    target: &VertexTarget,
    places: &[Place],
    p: Vec3,
    track: &mut Track,
) -> Vec3 {
    let found = field.own_side(&target.side(), places, p);
    let gap = found.sample.value - target.iso;
    let gradient = found.sample.gradient;
    let squared = gradient.dot(gradient);
    if not_finite(gap) || not_finite(squared) {
        *track = Track { stop: StopReason::NonFinite as u32, ..Track::REST };
        return p;
    }
    track.passes += 1;
    track.contact = found.contact;
    if squared < MIN_GRADIENT_SQUARED || found.group == NO_GROUP {
        track.normal = Vec3::ZERO.extend(gap);
        track.stop = StopReason::NoGradient as u32;
        return p;
    }
    let length = squared.sqrt();
    let unit = gradient / length;
    track.normal = unit.extend(gap);
    track.stop = if gap.abs() < params.tolerance {
        StopReason::Converged as u32
    } else if found.contact > 0.0 {
        StopReason::Pressed as u32
    } else {
        StopReason::Short as u32
    };
    let frame = &field.groups[found.group as usize];
    let longest = params.max_step_radii * frame.grid.support_radius * frame.scale;
    let wanted = params.relaxation * -gap / length;
    p + unit * wanted.clamp(-longest, longest)
}
