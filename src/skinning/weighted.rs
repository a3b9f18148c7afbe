//! Geometric skinning displaced by muscles alone, without a field of the skin (paper A, section 8.7).

use super::CHUNK;
use crate::{
    field::muscle::{AxisPoint, MuscleFrame, MuscleWeight, Pull, pull},
    math::{affine_inverse, smoothstep},
    rig::{JointFrame, WeightTarget},
};
use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

crate::gpu_struct! {
    /// Sizes that the displacement by weights needs.
    pub struct WeightedParams {
        /// Vertices of the character.
        pub vertex_count: u32,
        /// Instances in the batch.
        pub instance_count: u32,
        /// Joints of the character.
        pub joint_count: u32,
        /// Muscles of the character.
        pub muscle_count: u32,
        /// Points of all of the character's muscles' axes.
        pub point_count: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
        /// Unused.
        pub pad_2: u32,
    }
}

/// What the displacement reads: one character at one moment.
#[derive(Clone, Copy)]
pub struct WeightedInput<'a> {
    /// Joints of this instance.
    pub joints: &'a [JointFrame],
    /// Muscles of this instance.
    pub muscles: &'a [MuscleFrame],
    /// Points of their axes.
    pub axes: &'a [AxisPoint],
    /// One per vertex.
    pub targets: &'a [WeightTarget],
    /// Weights of all vertices.
    pub weights: &'a [MuscleWeight],
    /// Positions after geometric skinning.
    pub skinned: &'a [Vec4],
}

/// Most steps of Newton's method. Three to six are the rule: the field is smooth, and steeper the nearer the surface.
pub(crate) const STEPS: u32 = 16;
/// Field difference at which a vertex has arrived: less than a hundredth of a millimetre where the field has half its slope.
pub(crate) const TOLERANCE: f32 = 1e-5;
/// Longest step, in support radii.
pub(crate) const LONGEST: f32 = 0.25;
/// Slope, per metre, that the field has at least where a step's length is asked: it has none on a muscle's axis.
pub(crate) const LEAST_SLOPE: f32 = 1e-3;
/// Share of its rest iso-value from which the field where a vertex starts draws it wholly, and that up to which not at all. Skin
/// sinks a little where a muscle leaves it; what the muscle has left for good stays, since nothing else would stop it from
/// sinking to the bone.
pub(crate) const HELD: f32 = 0.8;
/// See [`HELD`].
pub(crate) const LEFT: f32 = 0.3;

/// From where it was skinned, every vertex goes along the gradient of its muscles' union to the value that this has at rest, and
/// then back to the share of the way that the weights say. Twin of `skin_weighted`.
pub fn weighted(input: &WeightedInput, displaced: &mut [Vec4]) {
    displaced.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
        for (i, position) in out.iter_mut().enumerate() {
            *position = weighted_vertex(input, chunk * CHUNK + i);
        }
    });
}

fn weighted_vertex(input: &WeightedInput, vertex: usize) -> Vec4 {
    let target = &input.targets[vertex];
    let start = input.skinned[vertex];
    let weights = &input.weights[target.begin as usize..target.end as usize];
    if weights.is_empty() {
        return start;
    }
    let to_rest = |joint: u32| affine_inverse(&input.joints[joint as usize].matrix);
    let at = |p: Vec3| pull(input.muscles, input.axes, weights, to_rest, p);
    let mut p = start.xyz();
    let mut found = at(p);
    let mut hold = smoothstep((found.sample.value / target.iso - LEFT) / (HELD - LEFT));
    // What has come out of a muscle's back cannot be drawn to it.
    if found.sample.value < target.iso {
        hold *= found.facing();
    }
    let gap = (found.sample.value - target.iso).abs();
    let mut longest = LONGEST * found.reach;
    let mut before = 0.0;
    for _ in 0..STEPS {
        let Some(step) = step(&found, target.iso, before, &mut longest) else { break };
        p += step.1 * step.0;
        before = step.0;
        found = at(p);
    }
    // Who cannot get there stays: beside a thin end there may be no way in on which the value is reached.
    let arrived = 1.0 - ((found.sample.value - target.iso).abs() / gap.max(TOLERANCE)).min(1.0);
    let moved = start.xyz() + (p - start.xyz()) * (found.weight * hold * arrived);
    if super::is_finite(moved) { moved.extend(1.0) } else { start }
}

/// How far to go, metres, and the direction inward; none where the point has arrived or left the field.
///
/// A step back over the surface halves the longest one, so that steps cannot go to and fro.
#[inline]
fn step(found: &Pull, iso: f32, before: f32, longest: &mut f32) -> Option<(f32, Vec3)> {
    let gap = found.sample.value - iso;
    if gap.abs() < TOLERANCE || found.sample.value <= 0.0 {
        return None;
    }
    let gradient = found.sample.gradient;
    let wanted = -gap / gradient.dot(gradient).sqrt().max(LEAST_SLOPE);
    if wanted * before < 0.0 {
        *longest = 0.5 * before.abs();
    }
    Some((wanted.clamp(-*longest, *longest), found.direction()))
}
