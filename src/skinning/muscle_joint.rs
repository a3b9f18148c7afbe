//! Muscles as joints of linear skinning: one at every point of an axis, which moves aside and turns with it, and swells as the
//! muscle does (paper B, "Skin Deformation").

use crate::{
    field::muscle::{AxisPoint, MuscleFrame, MuscleRest, axis::smooth_tangent, project},
    math::{product, smoothstep},
    rig::{JointFrame, MuscleJoint},
};
use glam::{Mat4, Vec3, Vec4Swizzles};
use rayon::prelude::*;

/// Least and most that skin swells, as a share of its distance from the axis: what a muscle has left does not sink to the bone.
pub(crate) const SWELLS: [f32; 2] = [-0.25, 1.0];
/// Cosine of the largest turn of an axis that has a shortest way, less one.
pub(crate) const LEAST_TURN: f32 = 1e-3;

/// Shares of its length at rest below and above which a muscle moves no skin, and from which and up to which it does wholly. No
/// muscle does that; a straight axis past a joint that it has no wrap for does.
pub(crate) const SHORT: [f32; 2] = [0.3, 0.55];
/// See [`SHORT`].
pub(crate) const LONG: [f32; 2] = [2.0, 1.6];

/// What the joints are made from: one character at one moment.
#[derive(Clone, Copy)]
pub struct MuscleJointInput<'a> {
    /// Joints of this instance.
    pub joints: &'a [JointFrame],
    /// Muscles of the character.
    pub muscles_rest: &'a [MuscleRest],
    /// Their joints at rest, one per point of their axes.
    pub joints_rest: &'a [MuscleJoint],
    /// Muscles of this instance.
    pub muscles: &'a [MuscleFrame],
    /// Points of their axes.
    pub axes: &'a [AxisPoint],
}

/// The matrices of all muscles' joints, scene space at rest to scene space posed. Twin of `muscle_joint`.
///
/// A muscle slides under the skin (paper B, "Bending Around a Joint"): its joints stay where its bone carries them along it. Across
/// it they go with the axis, from where that passed at rest to where it passes now; they turn from its direction there at rest to
/// the one it has now, and swell by what the muscle that is there now is thicker than what was there at rest. The more the muscle
/// has left from under the skin, and where it is much shorter or longer than any becomes, the more its bone alone moves them.
pub fn muscle_joints(input: &MuscleJointInput, out: &mut [Mat4]) {
    out.par_iter_mut().zip(input.joints_rest).for_each(|(out, rest)| *out = muscle_joint(input, rest));
}

fn muscle_joint(input: &MuscleJointInput, at: &MuscleJoint) -> Mat4 {
    let rest = &input.muscles_rest[at.muscle as usize];
    let muscle = &input.muscles[at.muscle as usize];
    let to_posed = &input.joints[rest.joint as usize].matrix;
    if muscle.present == 0 {
        return *to_posed;
    }
    let place = at.place.xyz();
    let points = muscle.points(input.axes);
    let foot = project(points, place);
    let tangent = smooth_tangent(points, foot.arc);
    let aside = foot.offset - tangent * tangent.dot(foot.offset);
    let radius = muscle.width * muscle.profile().at(foot.arc * muscle.inverse_length).0;
    let swell = |now: f32, before: f32, per_metre: f32| ((now - before) * per_metre).clamp(SWELLS[0], SWELLS[1]);
    let long = swell(radius * muscle.long_squared.sqrt(), at.place.w, at.swell_long);
    let short = swell(radius * muscle.short_squared.sqrt(), at.tangent.w, at.swell_short);
    let (before, normal) = (at.tangent.xyz(), at.normal.xyz());
    let square = before.cross(normal);
    let column = |axis: Vec3| {
        let swollen = axis + normal * (normal.dot(axis) * long) + square * (square.dot(axis) * short);
        turned(swollen, before, tangent)
    };
    let (x, y, z) = (column(Vec3::X), column(Vec3::Y), column(Vec3::Z));
    let moved = place - aside - (x * place.x + y * place.y + z * place.z);
    // From the bone's own motion towards the muscle's.
    let ratio = muscle.length / rest.origin_normal.w;
    let within = |[none, whole]: [f32; 2]| smoothstep((ratio - none) / (whole - none));
    // An axis that has gone aside by more than the muscle is thick is not under the skin any more.
    let gone = aside.dot(aside) * (at.swell_long * at.swell_short);
    let hold = within(SHORT) * within(LONG) / (1.0 + gone).sqrt();
    let held = |axis: Vec3, column: Vec3| axis + (column - axis) * hold;
    let (x, y, z, moved) = (held(Vec3::X, x), held(Vec3::Y, y), held(Vec3::Z, z), moved * hold);
    product(to_posed, &Mat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), moved.extend(1.0)))
}

/// A vector turned the shortest way that takes one unit vector to another.
#[inline]
fn turned(v: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    let (cosine, axis) = (from.dot(to), from.cross(to));
    v * cosine + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cosine).max(LEAST_TURN))
}
