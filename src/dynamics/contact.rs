//! What a particle touches: other muscles, bones, the skin from within.

use super::{
    BoneRest, Link, MovedJoint, MuscleBody,
    chain::{Plane, plane},
};
use crate::{
    field::{GroupGrid, grid, muscle::axis::run},
    math::{transform_point, transpose_vector},
};
use glam::{Vec3, Vec4, Vec4Swizzles};

/// What all muscles of one instance are surrounded by.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// All muscles of the character.
    pub muscles: &'a [MuscleBody],
    /// Its bones.
    pub bones: &'a [BoneRest],
    /// Who can touch whom.
    pub links: &'a [Link],
    /// Its joints at the end of the substep.
    pub moved: &'a [MovedJoint],
    /// Cached fields of its groups.
    pub grids: &'a [GroupGrid],
    /// Grid nodes of groups and bones.
    pub nodes: &'a [Vec4],
    /// Half of the iterates that is read: all muscles as the last dispatch left them.
    pub iterates: &'a [Vec4],
}

/// A contact: the unit normal that leads out of it, and the distance by which it is kept, metres; less than 0 where it is
/// not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    pub normal: Vec3,
    pub distance: f32,
}

impl Contact {
    /// Nothing is near.
    pub const NONE: Contact = Contact { normal: Vec3::ZERO, distance: f32::MAX };

    /// As a plane about the particle's place.
    pub fn plane(&self, place: Vec3) -> Vec4 {
        if self.distance == f32::MAX { Vec4::ZERO } else { plane(place, self.normal, self.distance) }
    }
}

/// The point of a segment that is nearest to `p`.
pub(super) fn nearest_on_segment(from: Vec3, to: Vec3, p: Vec3) -> Vec3 {
    let span = to - from;
    let share = ((p - from).dot(span) / span.length_squared().max(1e-12)).clamp(0.0, 1.0);
    from + span * share
}

/// Cosine of the angle by which a kept plane's normal may be off before it turns, and the share of the way that it then
/// turns in one iteration.
pub(crate) const FACING: f32 = 0.99;
/// See [`FACING`].
pub(crate) const TURN: f32 = 0.2;

/// The way out of a contact whose normal is given that goes along another one, where it would lead into that one: a
/// particle between a bone and the skin is in neither after few passes.
pub(super) fn along(normal: Vec3, other: Vec3) -> Vec3 {
    let facing = normal.dot(other).min(0.0);
    (normal - other * facing) * (1.0 / (1.0 - facing * facing).max(LEAST_TURN))
}

/// Square of the way, square metres, by which a contact pass is to have moved a particle for another one to follow: of a
/// micrometre, ten times what coordinates of a character are rounded to.
pub(crate) const LEAST_WAY_SQUARED: f32 = 1e-12;

/// Square of the sine of the angle between two normals from which on the way along one is that long.
pub(crate) const LEAST_TURN: f32 = 0.1;

/// A plane brought from scene space at rest of a joint to posed scene space, its normal of length one.
pub(super) fn posed(plane: &Plane, joint: &MovedJoint) -> Plane {
    let normal = transpose_vector(&joint.to_rest, plane.xyz());
    let scale = 1.0 / normal.length().max(1e-9);
    (normal * scale).extend((plane.w - plane.xyz().dot(joint.to_rest.w_axis.xyz())) * scale)
}

/// The inverse of [`posed`], but for the normal's length.
pub(super) fn rest(plane: &Plane, joint: &MovedJoint) -> Plane {
    transpose_vector(&joint.matrix, plane.xyz()).extend(plane.w - plane.xyz().dot(joint.matrix.w_axis.xyz()))
}

/// The plane of a contact, with play: where one was kept before, it stays as far as it is right to within `play`, metres,
/// and its normal to within [`FACING`].
pub(super) fn follow(before: Option<Plane>, contact: &Contact, p: Vec3, play: f32) -> Plane {
    let Some(before) = before.filter(|_| play > 0.0) else { return contact.plane(p) };
    let facing = before.xyz().dot(contact.normal);
    if facing <= 0.0 {
        return contact.plane(p);
    }
    let kept = before.xyz().dot(p) - before.w;
    let distance = kept.clamp(contact.distance - play, contact.distance + play);
    let turned = before.xyz() * (1.0 - TURN) + contact.normal * TURN;
    let normal = if facing > FACING { before.xyz() } else { turned * (1.0 / turned.length().max(1e-9)) };
    plane(p, normal, distance)
}

impl Surroundings<'_> {
    /// A particle against one bone.
    ///
    /// The particle is a sphere of `radius`; in a tendon only the share `clear` of it counts, and the rest of the way the
    /// depth at which the bone holds the muscle's end, on the side of it that `share` says.
    pub(super) fn bone(&self, link: &Link, p: Vec3, radius: f32, clear: f32, share: f32) -> Contact {
        let bone = &self.bones[link.index as usize];
        let joint = &self.moved[bone.joint as usize];
        let held = if share < 0.5 { link.origin_depth } else { link.insertion_depth };
        let wanted = radius * clear + held * joint.scale * (1.0 - clear);
        if bone.grid.size_x == 0 {
            let from = transform_point(&joint.matrix, bone.start.xyz());
            let to = transform_point(&joint.matrix, bone.end.xyz());
            let away = p - nearest_on_segment(from, to, p);
            let distance = away.length();
            let reach = bone.start.w * joint.scale + wanted;
            return Contact { normal: away / distance.max(1e-9), distance: distance - reach };
        }
        match grid::sample(&bone.grid, self.nodes, transform_point(&joint.to_rest, p)) {
            None => Contact::NONE,
            Some((distance, gradient)) => {
                let outward = transpose_vector(&joint.to_rest, gradient);
                // A distance already, whose gradient shrinks where two sides of the bone are equally near.
                Contact { normal: outward / outward.length().max(1e-9), distance: distance * joint.scale - wanted }
            }
        }
    }

    /// The skin around a particle, from within: of all groups' surfaces that hold the muscle, the one that it is deepest
    /// inside of. Beyond all of them it is drawn to `refuge`.
    pub(super) fn skin(&self, links: &[Link], p: Vec3, refuge: Vec3) -> Contact {
        let mut deepest = Contact { normal: Vec3::ZERO, distance: -f32::MAX };
        for link in links {
            let grid = &self.grids[link.index as usize];
            let joint = &self.moved[link.joint as usize];
            let Some((raw, gradient)) = grid::sample(grid, self.nodes, transform_point(&joint.to_rest, p)) else {
                continue;
            };
            let outward = transpose_vector(&joint.to_rest, gradient);
            let slope = outward.length().max(1e-6);
            if -raw / slope > deepest.distance {
                deepest = Contact { normal: -outward / slope, distance: -raw / slope };
            }
        }
        if deepest.distance > -f32::MAX {
            return deepest;
        }
        let way = refuge - p;
        let distance = way.length();
        if distance > 1e-9 { Contact { normal: way / distance, distance: -distance } } else { Contact::NONE }
    }

    /// A sphere against another muscle's own field `f_M`, with its radii straight from point to point; nothing beyond that
    /// muscle's box.
    pub(super) fn muscle(&self, link: &Link, p: Vec3, radius: f32) -> Contact {
        let other = &self.muscles[link.index as usize];
        let first = run(link.index as usize, other.first_point);
        let (lowest, highest) = (self.iterates[first].xyz(), self.iterates[first + 1].xyz());
        if (p + radius).cmplt(lowest).any() || (p - radius).cmpgt(highest).any() {
            return Contact::NONE;
        }
        self.axis(&self.iterates[first + 2..], other.segments as usize, p, radius)
    }

    /// One muscle's axis, two entries a point.
    fn axis(&self, points: &[Vec4], segments: usize, p: Vec3, radius: f32) -> Contact {
        let (mut nearest, mut least, mut at) = (0, f32::MAX, 0.0);
        for j in 0..segments {
            let start = points[2 * j].xyz();
            let span = points[2 * j + 2].xyz() - start;
            let share = ((p - start).dot(span) / span.length_squared().max(1e-12)).clamp(0.0, 1.0);
            let away = p - (start + span * share);
            let squared = away.length_squared();
            if squared < least {
                (nearest, least, at) = (j, squared, share);
            }
        }
        let (start, end) = (points[2 * nearest], points[2 * nearest + 2]);
        let span = end.xyz() - start.xyz();
        let away = p - (start.xyz() + span * at);
        let distance = away.length();
        if distance < 1e-9 {
            return Contact::NONE;
        }
        let outward = away / distance;
        let own = start.w + (end.w - start.w) * at;
        let (n0, n1) = (points[2 * nearest + 1], points[2 * nearest + 3]);
        let cosine = outward.dot(n0.xyz() * (1.0 - at) + n1.xyz() * at);
        let polar = if n0.w > 0.0 {
            let squared = (cosine * cosine).min(1.0);
            1.0 / (n0.w * squared + (1.0 - squared) / n0.w).sqrt()
        } else {
            1.0
        };
        // Where the muscle grows thicker, its surface leans.
        let lean = span * ((end.w - start.w) * polar / span.length_squared().max(1e-12));
        let lean = if at > 0.0 && at < 1.0 { lean } else { Vec3::ZERO };
        let gradient = outward - lean;
        let slope = gradient.length().max(1e-6);
        Contact { normal: gradient / slope, distance: (distance - own * polar - radius) / slope }
    }
}
