//! How far each muscle takes each vertex with it where muscles alone displace the skin (paper A, section 8.7).

use super::Rig;
use crate::{
    error::WeightError,
    field::muscle::{AxisPoint, MuscleFrame, MuscleWeight, evaluate, pull, widened},
    math::smoothstep,
};
use glam::{Mat4, Vec4Swizzles};
use rayon::prelude::*;
use std::ops::Range;

crate::gpu_struct! {
    /// Where the muscles that a vertex follows take it.
    pub struct WeightTarget {
        /// Where its weights begin.
        pub begin: u32,
        /// One past the last of them.
        pub end: u32,
        /// Value at rest of the union of these muscles.
        pub iso: f32,
        /// Unused.
        pub pad_0: u32,
    }
}

/// Weights of one muscle that come with a part of the character: `_MUSCLE_n` of a glTF primitive.
#[derive(Clone, Debug, PartialEq)]
pub struct PaintedMuscle {
    /// Number of the muscle in the muscle file, from 0; it stands for all fibres of a set.
    pub muscle: u32,
    /// The part's vertices.
    pub vertices: Range<u32>,
    /// One per vertex of the part, 0..=1.
    pub weights: Vec<f32>,
}

/// The muscles that every vertex follows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MuscleWeights {
    /// One per vertex.
    pub vertices: Vec<WeightTarget>,
    /// Of all vertices; ascending by muscle within one.
    pub weights: Vec<MuscleWeight>,
}

/// Field of a muscle at rest from which it takes the skin with it wholly: that at a quarter of its support outside its surface,
/// where most of what lies over a muscle is.
const WHOLE: f32 = 0.25;
/// Weights below this are left out.
pub(super) const LEAST: f32 = 1e-3;

impl MuscleWeights {
    /// Weights of a rig's skin, with its muscles at rest. What the file paints comes first; elsewhere a muscle's weight goes by its
    /// field at the vertex, to 0 at its support, and by the share of the vertex that its field group's joints move, so that
    /// nothing of it is left beyond the joint.
    pub(super) fn new(rig: &Rig) -> MuscleWeights {
        let mut result = MuscleWeights::default();
        if rig.muscles.is_empty() {
            return result;
        }
        let (muscles, axes) = rig.muscles_at_rest();
        let found: Vec<(f32, Vec<MuscleWeight>)> =
            (0..rig.positions_rest.len()).into_par_iter().map(|v| of_vertex(rig, &muscles, &axes, v)).collect();
        for (iso, weights) in found {
            let begin = result.weights.len() as u32;
            result.weights.extend(weights);
            let end = result.weights.len() as u32;
            result.vertices.push(WeightTarget { begin, end, iso, pad_0: 0 });
        }
        result
    }

    /// The weights of vertex `v`.
    pub fn of(&self, v: usize) -> &[MuscleWeight] {
        self.vertices.get(v).map_or(&[], |t| &self.weights[t.begin as usize..t.end as usize])
    }

    /// Vertices that follow some muscle.
    pub fn followers(&self) -> usize {
        self.vertices.iter().filter(|t| t.begin < t.end).count()
    }
}

/// A vertex's weights, and the value of their muscles' union at rest.
fn of_vertex(rig: &Rig, muscles: &[MuscleFrame], axes: &[AxisPoint], v: usize) -> (f32, Vec<MuscleWeight>) {
    let p = rig.positions_rest[v].xyz();
    let weight = |m: usize| -> Option<MuscleWeight> {
        let muscle = widened(&muscles[m]);
        // Where a muscle has no field, no paint makes it move the skin.
        let sample = muscle.reaches(p).then(|| evaluate(&muscle, muscle.points(axes), p)).filter(|s| s.value > 0.0)?;
        let weight = match rig.paint(m, v) {
            Some(painted) => painted.weights[v - painted.vertices.start as usize],
            None => smoothstep(sample.value / WHOLE) * moved_share(rig, rig.muscles[m].group, v),
        };
        let inward = sample.gradient.normalize_or_zero().extend(0.0);
        let (muscle, joint) = (m as u32, rig.muscles[m].joint);
        (weight >= LEAST).then_some(MuscleWeight { inward, muscle, joint, weight, pad_0: 0 })
    };
    let weights: Vec<MuscleWeight> = (0..muscles.len()).filter_map(weight).collect();
    let iso = pull(muscles, axes, &weights, |_| (Mat4::IDENTITY, 1.0), p).sample.value;
    (iso, weights)
}

/// Share of a vertex that the joints of a field group move.
fn moved_share(rig: &Rig, group: u32, v: usize) -> f32 {
    let of_group = |joint: u32| rig.groups.group_of_joint.get(joint as usize) == Some(&group);
    rig.character.influences_of(v).iter().filter(|i| of_group(i.joint)).map(|i| i.weight).sum()
}

impl Rig {
    /// What the character's file paints at vertex `v` for muscle `m`, or rather for its author's entry.
    fn paint(&self, m: usize, v: usize) -> Option<&PaintedMuscle> {
        let vertex = v as u32;
        let own = |painted: &&PaintedMuscle| painted.muscle == self.spec_of[m] && painted.vertices.contains(&vertex);
        self.character.painted.iter().find(own)
    }

    /// Whether the weight of muscle `m` at vertex `v` is painted.
    pub(super) fn is_painted(&self, m: usize, v: usize) -> bool {
        self.paint(m, v).is_some()
    }

    /// Whether muscles can displace the skin by weights: where this is an error, such a skinning is linear skinning.
    ///
    /// # Errors
    /// The rig has no muscles, its file paints one that is not there, or no vertex follows any.
    pub fn check_weights(&self) -> Result<(), WeightError> {
        if self.muscles.is_empty() {
            return Err(WeightError::NoMuscles);
        }
        let beyond = |painted: &&PaintedMuscle| painted.muscle as usize >= self.specs.len();
        if let Some(painted) = self.character.painted.iter().find(beyond) {
            return Err(WeightError::Unknown { muscle: painted.muscle, muscles: self.specs.len() });
        }
        match self.weights.followers() {
            0 => Err(WeightError::NoVertex { character: self.character.name.clone() }),
            _ => Ok(()),
        }
    }
}
