//! The composed field of the whole character at a point of posed scene space.

use super::{
    Fold, GroupGrid, Sample,
    compose::{JointOperatorParams, clean_union, detail_samples, joint},
    grid,
    muscle::{self, AxisPoint, MuscleFrame},
    transfer::transfer,
};
use crate::math::{transform_point, transpose_vector};
use glam::{Mat4, Vec3, Vec4};

crate::gpu_struct! {
    /// One field group at one moment.
    pub struct GroupFrame {
        /// Scene space posed to scene space at rest: the inverse of the driving joint's palette entry.
        pub to_rest: Mat4,
        /// The group's cached field.
        pub grid: GroupGrid,
        /// Centre of a sphere around the grid's box, posed, and in `w` the square of its radius, metres: the group has no field
        /// beyond it. Negative where muscles may reach further and have not been looked at
        /// ([`bound`](super::bound::bound)).
        pub bounds: Vec4,
        /// What its first joint displaces as it folds.
        pub fold_start: Fold,
        /// What the joint at its other end displaces.
        pub fold_end: Fold,
        /// How much the pose enlarges the group: the cube root of its volume factor.
        pub scale: f32,
        /// 1 where the group takes part, 0 where its pose cannot be inverted.
        pub present: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
    }
}

crate::gpu_struct! {
    /// A group as one vertex sees it: through a frame of its own, and past what overlaps at rest.
    pub struct Place {
        /// Scene space posed to scene space at rest.
        pub to_rest: Mat4,
        /// The group.
        pub group: u32,
        /// Field of the group above which the vertex is in contact with it.
        pub limit: f32,
        /// What joins the group to the vertex's own where the two overlap at rest, and the vertex lies on the surface of both
        /// together: a [`JointOperator::code`](super::compose::JointOperator::code); [`APART`] elsewhere.
        pub join: u32,
        /// Unused.
        pub pad_0: u32,
    }
}

impl GroupFrame {
    /// Whether the group has no field at a point, seen through its own frame: exact, since fields end with their support.
    #[inline]
    pub fn is_beyond(&self, p_posed: Vec3) -> bool {
        let away = p_posed - self.bounds.truncate();
        self.bounds.w >= 0.0 && away.dot(away) > self.bounds.w
    }
}

/// Two groups that do not overlap at rest: nothing joins them.
pub const APART: u32 = u32::MAX;
/// No group reaches the point.
pub const NO_GROUP: u32 = u32::MAX;

/// A sample of the composed field, and which group it came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupSample {
    /// Value, and gradient in posed scene space.
    pub sample: Sample,
    /// Index of the group with the largest value, [`NO_GROUP`] where all are 0.
    pub group: u32,
}

/// What the composed field is made of: one character at one moment.
#[derive(Clone, Copy)]
pub struct FieldInput<'a> {
    /// Field groups of this instance.
    pub groups: &'a [GroupFrame],
    /// Grid nodes of all groups.
    pub nodes: &'a [Vec4],
    /// Muscles of this instance.
    pub muscles: &'a [MuscleFrame],
    /// Points of their axes.
    pub axes: &'a [AxisPoint],
}

impl FieldInput<'_> {
    /// The field of one group at a posed point: limb surface with the clean union of its muscles set in
    /// (background 3.3 and 3.4).
    #[inline]
    pub fn group(&self, frame: &GroupFrame, p_posed: Vec3) -> Sample {
        self.group_from(frame, &frame.to_rest, p_posed)
    }

    /// [`FieldInput::group`] seen through another frame.
    #[inline]
    pub fn group_from(&self, frame: &GroupFrame, to_rest: &Mat4, p_posed: Vec3) -> Sample {
        let p_rest = transform_point(to_rest, p_posed);
        let mut limb = Sample::default();
        if let Some((mut distance, mut slope)) = grid::sample(&frame.grid, self.nodes, p_rest) {
            for fold in [&frame.fold_start, &frame.fold_end] {
                let (lift, lift_slope) = fold.lift(p_rest);
                distance += lift;
                slope += lift_slope;
            }
            let (value, by_distance) = transfer(distance, frame.grid.support_radius);
            limb = Sample { value, gradient: slope * by_distance };
        }
        let mut set_in = Sample::default();
        for m in &self.muscles[frame.grid.muscle_begin as usize..frame.grid.muscle_end as usize] {
            if m.reaches(p_rest) {
                set_in = clean_union(set_in, muscle::evaluate(m, m.points(self.axes), p_rest));
            }
        }
        let composed = if set_in.value > 0.0 { detail_samples(limb, set_in) } else { limb };
        Sample { value: composed.value, gradient: transpose_vector(to_rest, composed.gradient) }
    }

    /// The composed field at a posed point: the largest of the groups' fields.
    #[inline]
    pub fn composed(&self, p_posed: Vec3) -> GroupSample {
        let mut result = GroupSample { sample: Sample::default(), group: NO_GROUP };
        for (index, frame) in self.groups.iter().enumerate() {
            if frame.present == 0 {
                continue;
            }
            let sample = self.group(frame, p_posed);
            if sample.value > result.sample.value {
                result = GroupSample { sample, group: index as u32 };
            }
        }
        result
    }
}

/// Field values that neighbouring groups must differ by at a contact: how far skin stops short of skin.
pub const CONTACT_GAP: f32 = 0.04;

/// Cosine between two groups' gradients from which they agree, and the range over which they part (prototypes 3).
pub(crate) const CONTACT_AGREE: f32 = 0.95;
/// See [`CONTACT_AGREE`].
pub(crate) const CONTACT_TURN: f32 = 0.1;

/// What a vertex tracks, at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnSide {
    /// Value, and gradient in posed scene space.
    pub sample: Sample,
    /// The group with the largest field, [`NO_GROUP`] where all are 0.
    pub group: u32,
    /// How much the vertex presses against another group: 0 where it does not, 1 where that one faces it.
    pub contact: f32,
}

/// Which side of the field a vertex is on.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    /// Its group: the one with the largest field at rest.
    pub owner: u32,
    /// Field of a group above which the vertex is in contact with it, unless a place says otherwise.
    pub limit: f32,
    /// What the join of the groups adds to the owner's field at rest.
    pub lift: f32,
}

/// A vertex's own group and the other one that matters to it, at one point.
#[derive(Clone, Copy)]
struct Neighbours {
    own: Sample,
    /// The other group with the largest field, of those that overlap the own one at rest, and what joins it.
    other: GroupSample,
    join: u32,
    /// The other group that is furthest above its limit, and by how much; 0 for none.
    pressing: Sample,
    excess: f32,
}

impl FieldInput<'_> {
    /// What a vertex of group `owner` tracks: the field of its group and of those that overlap it at rest, and at a
    /// contact its own side of it (prototypes 3). A stranger's surface is nothing to track, even where the own field ends.
    ///
    /// With `n` the directions of the owner's field and of another one, `w` goes from 0 to 1 as they part, and
    /// `G = (1 - w) join(own, other) + w (own + lift) - w max(0, other - limit)`: where skin faces skin, a vertex stays on
    /// its own surface and out of the other one. Of several, the one furthest above its limit counts. The derivative of `w`
    /// is left out, as in the authors' operators. `places` are the groups that the vertex sees through frames of its own,
    /// ascending by group.
    #[inline]
    pub fn own_side(&self, side: &Side, places: &[Place], p_posed: Vec3) -> OwnSide {
        let owner = side.owner;
        let Neighbours { own, other, join, pressing, excess } = self.neighbours(owner, side.limit, places, p_posed);
        let union = GroupSample {
            sample: joint(own, other.sample, &JointOperatorParams::of_code(join)),
            group: if other.sample.value > own.value { other.group } else { owner },
        };
        let facing = if excess > 0.0 { pressing } else { other.sample };
        let product = own.gradient.dot(own.gradient) * facing.gradient.dot(facing.gradient);
        if product <= 0.0 {
            return OwnSide { sample: union.sample, group: union.group, contact: 0.0 };
        }
        let cosine = own.gradient.dot(facing.gradient) / product.sqrt();
        let w = crate::math::smoothstep((CONTACT_AGREE - cosine) / CONTACT_TURN);
        let mut value = (1.0 - w) * union.sample.value + w * (own.value + side.lift);
        let mut gradient = union.sample.gradient * (1.0 - w) + own.gradient * w;
        let mut contact = 0.0;
        if excess > 0.0 {
            value -= w * excess;
            gradient -= facing.gradient * w;
            contact = w;
        }
        OwnSide { sample: Sample { value, gradient }, group: union.group, contact }
    }

    #[inline]
    fn neighbours(&self, owner: u32, limit: f32, places: &[Place], p_posed: Vec3) -> Neighbours {
        let mut found = Neighbours {
            own: Sample::default(),
            other: GroupSample { sample: Sample::default(), group: NO_GROUP },
            join: 0,
            pressing: Sample::default(),
            excess: 0.0,
        };
        let mut next = 0;
        for (index, frame) in (0..).zip(self.groups) {
            let mut to_rest = &frame.to_rest;
            let mut limit = limit;
            let (mut beyond, mut join) = (frame.is_beyond(p_posed), APART);
            if let Some(place) = places.get(next).filter(|place| place.group == index) {
                (to_rest, limit, beyond, join) = (&place.to_rest, place.limit, false, place.join);
                next += 1;
            }
            if frame.present == 0 || beyond {
                continue;
            }
            let sample = self.group_from(frame, to_rest, p_posed);
            if index == owner {
                found.own = sample;
                continue;
            }
            if join != APART && sample.value > found.other.sample.value {
                found.other = GroupSample { sample, group: index };
                found.join = join;
            }
            if sample.value - limit > found.excess {
                found.pressing = sample;
                found.excess = sample.value - limit;
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::super::compose::JointOperator;
    use super::*;

    /// Two slabs facing each other: group 0's surface at x = 0 with its inside at x < 0, group 1's at `x = gap` with
    /// its inside beyond, both with support 1 m and a gradient of length one.
    fn slabs(gap: f32) -> ([GroupFrame; 2], Vec<Vec4>) {
        let mut nodes = Vec::new();
        let mut slab = |direction: f32, surface: f32| {
            let offset = nodes.len() as u32;
            nodes.extend((0..8).map(|i| {
                let x = (i & 1) as f32 * 4.0 - 2.0;
                Vec3::new(direction, 0.0, 0.0).extend(direction * (x - surface))
            }));
            let scale = Vec3::new(0.25, 0.25, 0.25);
            let to_grid = Mat4::from_translation(Vec3::splat(0.5)) * Mat4::from_scale(scale);
            let grid = GroupGrid {
                rest_to_grid: to_grid,
                offset,
                size_x: 2,
                size_y: 2,
                size_z: 2,
                support_radius: 1.0,
                ..GroupGrid::default()
            };
            let bounds = Vec4::new(0.0, 0.0, 0.0, 100.0);
            GroupFrame { to_rest: Mat4::IDENTITY, grid, bounds, scale: 1.0, present: 1, ..GroupFrame::default() }
        };
        ([slab(1.0, 0.0), slab(-1.0, gap)], nodes)
    }

    fn with<'a>(groups: &'a [GroupFrame], nodes: &'a [Vec4]) -> FieldInput<'a> {
        FieldInput { groups, nodes, muscles: &[], axes: &[] }
    }

    fn side(owner: u32, limit: f32) -> Side {
        Side { owner, limit, lift: 0.0 }
    }

    fn at(x: f32) -> Vec3 {
        Vec3::new(x, 0.1, -0.2)
    }

    #[test]
    fn facing_slabs_are_tracked_on_the_own_side() {
        let (groups, nodes) = slabs(-0.2);
        for x in [-0.3, -0.15, -0.05, 0.1] {
            let field = |g: usize| with(&groups, &nodes).group(&groups[g], at(x));
            let found = with(&groups, &nodes).own_side(&side(0, 0.46), &[], at(x)).sample;
            let expected = field(0).value - (field(1).value - 0.46).max(0.0);
            assert!((found.value - expected).abs() < 1e-6, "x = {x}: {} {expected}", found.value);
            assert!(found.gradient.x < 0.0, "inward of its own group at x = {x}");
            let other = with(&groups, &nodes).own_side(&side(1, 0.46), &[], at(x)).sample;
            assert!(other.gradient.x > 0.0, "the other group's vertices go the other way");
        }
        let contact = with(&groups, &nodes).own_side(&side(0, 0.46), &[], at(-0.1)).sample.value;
        assert!(contact < with(&groups, &nodes).composed(at(-0.1)).sample.value - 0.05, "the maximum has no contact");
    }

    #[test]
    fn fields_that_agree_and_fields_alone_are_the_maximum() {
        let (mut groups, nodes) = slabs(0.0);
        groups[1].grid.offset = 0;
        groups[1].to_rest = Mat4::from_translation(Vec3::X * 0.1);
        for x in [-0.4, 0.0, 0.3] {
            let kin = [Place { to_rest: groups[0].to_rest, ..Place::default() }];
            let found = with(&groups, &nodes).own_side(&side(1, 0.0), &kin, at(x));
            // Parallel gradients give no weight to a contact, whatever the limit.
            assert_eq!(found.sample.value, with(&groups, &nodes).composed(at(x)).sample.value);
        }
        let place_of_0 = Place { to_rest: groups[0].to_rest, limit: 0.9, ..Place::default() };
        let alone = with(&groups[..1], &nodes).own_side(&side(0, 0.3), &[], at(0.05));
        assert_eq!(alone.sample, with(&groups[..1], &nodes).composed(at(0.05)).sample);
        let away =
            |join| with(&groups[..1], &nodes).own_side(&side(7, 0.3), &[Place { join, ..place_of_0 }], at(0.05)).sample;
        assert_eq!(away(0), alone.sample, "a vertex whose group is gone takes what overlapped it at rest");
        assert_eq!(away(APART), Sample::default(), "and no stranger");
    }

    #[test]
    fn a_place_shows_its_group_through_its_own_frame() {
        let (groups, nodes) = slabs(-0.2);
        let moved = Mat4::from_translation(Vec3::X * -0.03);
        let places = [Place { to_rest: moved, group: 1, limit: 0.5, join: APART, ..Place::default() }];
        let found = with(&groups, &nodes).own_side(&side(0, 0.46), &places, at(-0.1));
        let mut shifted = groups;
        shifted[1].to_rest = moved;
        assert_eq!(found, with(&shifted, &nodes).own_side(&side(0, 0.5), &[], at(-0.1)));
        assert_ne!(found, with(&groups, &nodes).own_side(&side(0, 0.46), &[], at(-0.1)));
        assert!(found.contact > 0.99, "{found:?}");
    }

    #[test]
    fn groups_that_overlap_at_rest_are_joined_by_their_operator() {
        let (mut groups, nodes) = slabs(0.0);
        // The other slab turned by 60 degrees: a blend opens between the two, and no contact yet.
        groups[1].grid.offset = 0;
        groups[1].to_rest = Mat4::from_rotation_z(f32::to_radians(-15.0));
        let at_it = |operator: JointOperator, lift: f32| {
            let place =
                Place { to_rest: groups[1].to_rest, group: 1, limit: 1.0, join: operator.code(), ..Place::default() };
            with(&groups, &nodes).own_side(&Side { owner: 0, limit: 1.0, lift }, &[place], at(-0.02))
        };
        let [own, other] = [0, 1].map(|g: usize| with(&groups, &nodes).group(&groups[g], at(-0.02)));
        let union = at_it(JointOperator::Union, 0.0).sample;
        assert_eq!(union.value, own.value.max(other.value));
        let blend = at_it(JointOperator::Blend, 0.0).sample;
        assert_eq!(blend, joint(own, other, &JointOperator::Blend.params()), "no contact, so the join alone");
        assert!(blend.value > union.value + 0.02, "{} {}", blend.value, union.value);
        assert_eq!(at_it(JointOperator::Blend, 0.1).sample, blend, "a lift belongs to the contact");
        // Where the two face each other only the own side counts, lifted by what the join had added at rest.
        let (groups, nodes) = slabs(-0.2);
        let place = Place { to_rest: groups[1].to_rest, group: 1, limit: 0.46, ..Place::default() };
        let faced =
            |lift| with(&groups, &nodes).own_side(&Side { owner: 0, limit: 0.46, lift }, &[place], at(-0.1)).sample;
        assert!((faced(0.03).value - faced(0.0).value - 0.03).abs() < 1e-6);
    }
}
