//! Muscles as joints of linear skinning, and the vertices that they move (paper B, "Skin Deformation").

use super::{Influence, PaintedMuscle, Rig, muscle_weights::LEAST as LEAST_WEIGHT};
use crate::{
    field::muscle::{AxisPoint, MuscleFrame, MuscleWeight, axis::smooth_tangent, project},
    math::smoothstep,
};
use glam::{Vec4, Vec4Swizzles};
use rayon::prelude::*;

crate::gpu_struct! {
    /// A muscle's joint at rest: one at every point of its axis, in scene space at rest.
    pub struct MuscleJoint {
        /// The point, and in `w` the muscle's radius there along the section's long axis, metres.
        pub place: Vec4,
        /// Unit tangent of the axis, and in `w` the muscle's radius across both, metres.
        pub tangent: Vec4,
        /// Unit vector along the section's long axis; `w` unused.
        pub normal: Vec4,
        /// What a metre more of the radius along the long axis swells the skin by, 1/m.
        pub swell_long: f32,
        /// The same across it.
        pub swell_short: f32,
        /// The muscle.
        pub muscle: u32,
        /// Unused.
        pub pad_0: u32,
    }
}

/// The muscles' joints at rest, and what moves every vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MuscleJoints {
    /// One per point of all axes.
    pub joints: Vec<MuscleJoint>,
    /// Where each vertex's influences begin; one longer than the vertices.
    pub offsets: Vec<u32>,
    /// What moves the vertices: their own joints first, then the muscles', which are counted on from the character's.
    pub influences: Vec<Influence>,
}

/// Least radius, as a share of the muscle's largest, that skin swells in proportion to: over a tendon there is more between the
/// axis and the skin than muscle.
const LEAST_RADIUS: f32 = 0.4;
/// Radius, as a share of the muscle's largest, from which it takes the skin with it wholly.
const BELLY: f32 = 0.6;
/// Shares of joints below this are left out.
const LEAST: f32 = 1e-4;

impl MuscleJoints {
    /// Of a rig with its muscles at rest. A vertex follows muscles by its weights of them ([`MuscleWeights`](super::MuscleWeights)),
    /// of several together by one less the product of what each leaves, and its own joints by the rest. Weights that are found,
    /// not painted, fade out over the tendons.
    pub(super) fn new(rig: &Rig) -> MuscleJoints {
        let mut found = MuscleJoints::default();
        if rig.muscles.is_empty() {
            return found;
        }
        let (shaped, axes) = rig.muscles_at_rest();
        for (m, frame) in (0..).zip(&shaped) {
            let own = frame.points(&axes);
            found.joints.extend(own.iter().map(|point| joint(m, frame, own, point)));
        }
        let influences: Vec<Vec<Influence>> =
            (0..rig.character.vertex_count()).into_par_iter().map(|v| influences(rig, &shaped, &axes, v)).collect();
        found.offsets.push(0);
        for own in influences {
            found.influences.extend(own);
            found.offsets.push(found.influences.len() as u32);
        }
        found
    }
}

/// The joint on one point of a muscle's axis at rest.
fn joint(muscle: u32, frame: &MuscleFrame, points: &[AxisPoint], point: &AxisPoint) -> MuscleJoint {
    let tangent = smooth_tangent(points, point.arc());
    let flat = point.normal.xyz() - tangent * point.normal.xyz().dot(tangent);
    let normal = flat.try_normalize().unwrap_or_else(|| tangent.any_orthonormal_vector());
    let profile = frame.profile();
    let radius = frame.width * profile.at(point.arc() * frame.inverse_length).0;
    let over = radius.max(LEAST_RADIUS * frame.width * profile.max());
    let (long, short) = (frame.long_squared.sqrt(), frame.short_squared.sqrt());
    MuscleJoint {
        place: point.position.xyz().extend(radius * long),
        tangent: tangent.extend(radius * short),
        normal: normal.extend(0.0),
        swell_long: 1.0 / (over * long),
        swell_short: 1.0 / (over * short),
        muscle,
        pad_0: 0,
    }
}

/// The muscles that vertex `v` follows: the index, how far along its axis the vertex lies, metres, and how far it follows, 0..=1.
fn followed(rig: &Rig, shaped: &[MuscleFrame], axes: &[AxisPoint], v: usize) -> Vec<(usize, f32, f32)> {
    let of_muscle = |own: &MuscleWeight| {
        let m = own.muscle as usize;
        let frame = &shaped[m];
        let arc = project(frame.points(axes), rig.positions_rest[v].xyz()).arc;
        let profile = frame.profile();
        let thick = profile.at(arc * frame.inverse_length).0 / (BELLY * profile.max());
        (m, arc, if rig.is_painted(m, v) { own.weight } else { own.weight * smoothstep(thick) })
    };
    rig.weights.of(v).iter().map(of_muscle).filter(|(_, _, weight)| *weight >= LEAST_WEIGHT).collect()
}

/// What moves vertex `v`.
fn influences(rig: &Rig, shaped: &[MuscleFrame], axes: &[AxisPoint], v: usize) -> Vec<Influence> {
    let weights = followed(rig, shaped, axes, v);
    let left: f32 = weights.iter().map(|(_, _, weight)| 1.0 - weight).product();
    let sum: f32 = weights.iter().map(|(_, _, weight)| weight).sum();
    let own = rig.character.influences_of(v).iter();
    let mut found: Vec<Influence> = own.map(|i| Influence { weight: i.weight * left, ..*i }).collect();
    found.retain(|i| i.weight > 0.0);
    for (m, arc, weight) in weights {
        let frame = &shaped[m];
        let share = (1.0 - left) * (weight / sum);
        for (i, part) in along(frame.points(axes), arc) {
            let joint = rig.character.joints.len() as u32 + frame.first_point + i;
            if share * part >= LEAST {
                found.push(Influence { joint, weight: share * part });
            }
        }
    }
    let whole: f32 = found.iter().map(|i| i.weight).sum();
    found.iter_mut().for_each(|i| i.weight /= whole);
    found
}

impl Rig {
    /// How far every muscle takes the skin with it, part by part, as a file paints it: in [`MuscleJoints`] where `hybrid`, else in
    /// [`MuscleWeights`](super::MuscleWeights). Of the fibres of a set it is the largest. Muscles that move nothing of a part
    /// have no weights of it.
    pub fn painted_weights(&self, hybrid: bool) -> Vec<PaintedMuscle> {
        let (shaped, axes) = self.muscles_at_rest();
        let of_vertex = |v: usize| -> Vec<(usize, f32)> {
            if hybrid {
                return followed(self, &shaped, &axes, v).into_iter().map(|(m, _, weight)| (m, weight)).collect();
            }
            self.weights.of(v).iter().map(|own| (own.muscle as usize, own.weight)).collect()
        };
        let mut found = Vec::new();
        for part in &self.character.parts {
            let first = part.vertices.start as usize;
            let mut of_muscles = vec![vec![0.0f32; part.vertices.len()]; self.specs.len()];
            for v in part.vertices.clone() {
                for (m, weight) in of_vertex(v as usize) {
                    let own = &mut of_muscles[self.spec_of[m] as usize][v as usize - first];
                    *own = own.max(weight);
                }
            }
            let moves = |(_, weights): &(u32, Vec<f32>)| weights.iter().any(|w| *w > 0.0);
            let painted = |(muscle, weights)| PaintedMuscle { muscle, vertices: part.vertices.clone(), weights };
            found.extend((0..).zip(of_muscles).filter(moves).map(painted));
        }
        found
    }
}

/// The points whose joints move what lies at `arc` metres along an axis, with their shares: a cubic B-spline's, which is smooth
/// and leaves a straight line straight.
fn along(points: &[AxisPoint], arc: f32) -> [(u32, f32); 4] {
    let last = points.len() as u32 - 1;
    let i = (points.partition_point(|p| p.arc() <= arc) as u32).clamp(1, last) - 1;
    let f = ((arc - points[i as usize].arc()) / points[i as usize].tangent.w.max(1e-9)).clamp(0.0, 1.0);
    let g = 1.0 - f;
    let inner = |x: f32| 3.0 * x * x * x - 6.0 * x * x + 4.0;
    let shares = [g * g * g, inner(f), inner(g), f * f * f];
    std::array::from_fn(|k| ((i + k as u32).saturating_sub(1).min(last), shares[k] / 6.0))
}
