//! The composed field of the whole character at a point of posed scene space.

use super::{
    GroupGrid, Sample,
    compose::detail_samples,
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
    /// The field of one group at a posed point: limb surface with its muscles set in (background 3.4).
    #[inline]
    pub fn group(&self, frame: &GroupFrame, p_posed: Vec3) -> Sample {
        let p_rest = transform_point(&frame.to_rest, p_posed);
        let mut limb = Sample::default();
        if let Some((distance, distance_gradient)) = grid::sample(&frame.grid, self.nodes, p_rest) {
            let (value, slope) = transfer(distance, frame.grid.support_radius);
            limb = Sample { value, gradient: distance_gradient * slope };
        }
        let mut best = Sample::default();
        for m in &self.muscles[frame.grid.muscle_begin as usize..frame.grid.muscle_end as usize] {
            if m.reaches(p_rest) {
                let sample = muscle::evaluate(m, m.points(self.axes), p_rest);
                if sample.value > best.value {
                    best = sample;
                }
            }
        }
        let composed = if best.value > 0.0 { detail_samples(limb, best) } else { limb };
        Sample { value: composed.value, gradient: transpose_vector(&frame.to_rest, composed.gradient) }
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

    /// Largest field of any group but `owner` at a point.
    pub fn strongest_other(&self, owner: u32, p_posed: Vec3) -> f32 {
        let others = self.groups.iter().enumerate();
        let others = others.filter(|(index, frame)| *index as u32 != owner && frame.present != 0);
        others.map(|(_, frame)| self.group(frame, p_posed).value).fold(0.0, f32::max)
    }
}

/// Field values that neighbouring groups must differ by at a contact: how far skin stops short of skin.
pub const CONTACT_GAP: f32 = 0.04;

/// Cosine between two groups' gradients from which they agree, and the range over which they part (prototypes 3).
pub(crate) const CONTACT_AGREE: f32 = 0.95;
/// See [`CONTACT_AGREE`].
pub(crate) const CONTACT_TURN: f32 = 0.1;

impl FieldInput<'_> {
    /// What a vertex of group `owner` tracks: the composed field, and at a contact its own side of it (prototypes 3).
    ///
    /// With `n` the directions of the owner's field and of the strongest other field, `w` goes from 0 to 1 as they part,
    /// and `G = (1 - w) max(own, other) + w own - w max(0, other - limit)`: where skin faces skin, a vertex stays on its
    /// own surface and out of the other one. The derivative of `w` is left out, as in the authors' operators.
    #[inline]
    pub fn own_side(&self, owner: u32, limit: f32, p_posed: Vec3) -> GroupSample {
        let mut own = Sample::default();
        let mut other = GroupSample { sample: Sample::default(), group: NO_GROUP };
        for (index, frame) in self.groups.iter().enumerate() {
            if frame.present == 0 {
                continue;
            }
            let sample = self.group(frame, p_posed);
            if index as u32 == owner {
                own = sample;
            } else if sample.value > other.sample.value {
                other = GroupSample { sample, group: index as u32 };
            }
        }
        let union = if other.sample.value > own.value { other } else { GroupSample { sample: own, group: owner } };
        let product = own.gradient.dot(own.gradient) * other.sample.gradient.dot(other.sample.gradient);
        if product <= 0.0 {
            return union;
        }
        let cosine = own.gradient.dot(other.sample.gradient) / product.sqrt();
        let t = ((CONTACT_AGREE - cosine) / CONTACT_TURN).clamp(0.0, 1.0);
        let w = t * t * (3.0 - 2.0 * t);
        let mut value = (1.0 - w) * union.sample.value + w * own.value;
        let mut gradient = union.sample.gradient * (1.0 - w) + own.gradient * w;
        if other.sample.value > limit {
            value -= w * (other.sample.value - limit);
            gradient -= other.sample.gradient * w;
        }
        GroupSample { sample: Sample { value, gradient }, group: union.group }
    }
}

#[cfg(test)]
mod tests {
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
            GroupFrame { to_rest: Mat4::IDENTITY, grid, scale: 1.0, present: 1, ..GroupFrame::default() }
        };
        ([slab(1.0, 0.0), slab(-1.0, gap)], nodes)
    }

    fn with<'a>(groups: &'a [GroupFrame], nodes: &'a [Vec4]) -> FieldInput<'a> {
        FieldInput { groups, nodes, muscles: &[], axes: &[] }
    }

    fn at(x: f32) -> Vec3 {
        Vec3::new(x, 0.1, -0.2)
    }

    #[test]
    fn facing_slabs_are_tracked_on_the_own_side() {
        let (groups, nodes) = slabs(-0.2);
        for x in [-0.3, -0.15, -0.05, 0.1] {
            let field = |g: usize| with(&groups, &nodes).group(&groups[g], at(x));
            let found = with(&groups, &nodes).own_side(0, 0.46, at(x)).sample;
            let expected = field(0).value - (field(1).value - 0.46).max(0.0);
            assert!((found.value - expected).abs() < 1e-6, "x = {x}: {} {expected}", found.value);
            assert!(found.gradient.x < 0.0, "inward of its own group at x = {x}");
            let other = with(&groups, &nodes).own_side(1, 0.46, at(x)).sample;
            assert!(other.gradient.x > 0.0, "the other group's vertices go the other way");
        }
        let contact = with(&groups, &nodes).own_side(0, 0.46, at(-0.1)).sample.value;
        assert!(contact < with(&groups, &nodes).composed(at(-0.1)).sample.value - 0.05, "the maximum has no contact");
    }

    #[test]
    fn fields_that_agree_and_fields_alone_are_the_maximum() {
        let (mut groups, nodes) = slabs(0.0);
        groups[1].grid.offset = 0;
        groups[1].to_rest = Mat4::from_translation(Vec3::X * 0.1);
        for x in [-0.4, 0.0, 0.3] {
            let found = with(&groups, &nodes).own_side(1, 0.0, at(x));
            // Parallel gradients give no weight to a contact, whatever the limit.
            assert_eq!(found.sample.value, with(&groups, &nodes).composed(at(x)).sample.value);
        }
        let alone = with(&groups[..1], &nodes).own_side(0, 0.3, at(0.05));
        assert_eq!(alone, with(&groups[..1], &nodes).composed(at(0.05)));
        let away = with(&groups[..1], &nodes).own_side(7, 0.3, at(0.05));
        assert_eq!(away.sample, alone.sample, "a vertex whose group is gone takes what is there");
    }

    #[test]
    fn strongest_other_leaves_the_owner_out() {
        let (groups, nodes) = slabs(0.3);
        let p = at(-0.1);
        assert_eq!(with(&groups, &nodes).strongest_other(0, p), with(&groups, &nodes).group(&groups[1], p).value);
        assert_eq!(with(&groups, &nodes).strongest_other(1, p), with(&groups, &nodes).group(&groups[0], p).value);
        assert_eq!(with(&groups[..1], &nodes).strongest_other(0, p), 0.0);
    }
}
