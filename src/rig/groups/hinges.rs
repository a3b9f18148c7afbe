//! Joints between groups: which way a limb swings, and what folding displaces.

use super::{BodyPart, FieldGroups, shape::Shape};
use crate::{
    field::{Fold, evaluate::GroupFrame},
    math::transform_vector,
    rig::Character,
};
use glam::{Mat4, Vec3};

/// The joint that a group hangs on another one with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// The group that swings.
    pub group: u32,
    /// The joint that moves it.
    pub joint: u32,
    /// The nearest joint above that belongs to another group.
    pub parent: u32,
    /// Centre of the joint, metres at rest.
    pub origin: Vec3,
    /// Unit vector along the group's bone at rest.
    pub axis: Vec3,
}

/// Swing from which a gate is open, radians.
const WIDE_SWING: f32 = 15.0 * std::f32::consts::PI / 180.0;

impl Swing {
    /// The direction into which the bone has swung since the rest pose, in scene space at rest, and how far the gate of
    /// [`crate::rig::Reach`] is open, 0..=1.
    pub fn direction(&self, palette: &[Mat4]) -> (Vec3, f32) {
        let back = palette[self.parent as usize].inverse();
        let axis =
            transform_vector(&back, transform_vector(&palette[self.joint as usize], self.axis)).normalize_or_zero();
        let across = axis.reject_from_normalized(self.axis);
        let angle = axis.angle_between(self.axis);
        let open = if angle.is_finite() { (angle / WIDE_SWING).min(1.0) } else { 0.0 };
        (across.normalize_or_zero(), open)
    }
}

/// An elbow, a knee, or a joint like them: two groups that fold against each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoldRest {
    /// The group above.
    pub parent: u32,
    /// The group below.
    pub child: u32,
    /// Centre of the joint, metres at rest.
    origin: Vec3,
    /// Unit vectors out of the joint along the two bones.
    axes: [Vec3; 2],
    /// Mean of the two groups' median radii, metres.
    radius: f32,
    settings: Settings,
}

/// What the prototypes found to give the lost volume back (5).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Settings {
    /// Offset per radius and per unit of g.
    gain: f32,
    /// Where the bulge stands, and where it ends, in radii out of the joint.
    height_at: f32,
    end_at: f32,
}

const OF_LIMBS: Settings = Settings { gain: 0.19, height_at: 1.25, end_at: 4.5 };
const OF_BODIES: Settings = Settings { gain: 0.25, height_at: 1.0, end_at: 4.0 };
/// Share of the offset that the fold's outer side lacks.
const OUTER_LACK: f32 = 0.75;
/// Largest gain of a closed loop: it sees twist and muscles too, which are not to pass for a fold.
const MOST_GAIN: f32 = 0.3;
/// Largest offset, in radii.
const MOST_OFFSET: f32 = 0.5;

impl FoldRest {
    /// Whether a point at rest lies within the bulge of the group above, or below, the joint.
    pub fn reaches(&self, p_rest: Vec3, of_parent: bool) -> bool {
        let axis = self.axes[usize::from(!of_parent)];
        (p_rest - self.origin).dot(axis) <= self.settings.end_at * self.radius
    }

    /// The two groups' ends in a pose: the parent's, then the child's. Their offset is the open loop of prototypes 5.
    pub fn posed(&self, groups: &[GroupFrame]) -> [Fold; 2] {
        let (parent, child) = (&groups[self.parent as usize].to_rest, &groups[self.child as usize].to_rest);
        let to_parent = *parent * child.inverse();
        let to_child = *child * parent.inverse();
        let seen = [
            transform_vector(&to_parent, self.axes[1]).normalize_or_zero(),
            transform_vector(&to_child, self.axes[0]).normalize_or_zero(),
        ];
        let [offset, most] = self.offsets(seen[0]);
        let end = |own: Vec3, other: Vec3| Fold {
            centre: (self.origin + own * (self.settings.height_at * self.radius))
                .extend((self.settings.end_at - self.settings.height_at) * self.radius),
            axis: own.extend((1.0 + self.settings.height_at) * self.radius),
            inner: other.reject_from_normalized(own).normalize_or_zero().extend(OUTER_LACK),
            offset,
            most,
            ..Fold::default()
        };
        [end(self.axes[0], seen[0]), end(self.axes[1], seen[1])]
    }

    /// `c R (g(theta) - g(theta at rest))` with `g = tan(theta / 2) - theta / 2`, and the most that a closed loop may make of
    /// it, metres; `child` is the child's axis as the parent sees it.
    fn offsets(&self, child: Vec3) -> [f32; 2] {
        let g = |axis: Vec3| {
            let half = 0.5 * (-self.axes[0]).angle_between(axis);
            if half.is_finite() { half.min(1.5).tan() - half.min(1.5) } else { 0.0 }
        };
        let grown = (g(child) - g(self.axes[1])).max(0.0);
        [self.settings.gain, MOST_GAIN].map(|gain| (gain * self.radius * grown).min(MOST_OFFSET * self.radius))
    }
}

/// All joints between groups.
pub(super) fn swings(character: &Character, groups: &FieldGroups, shapes: &[Shape]) -> Vec<Swing> {
    let of = |(g, shape): (u32, &Shape)| {
        let other = |j: &u32| {
            !matches!(groups.group_of_joint[*j as usize], u32::MAX) && groups.group_of_joint[*j as usize] != g
        };
        let mut above = std::iter::successors(character.joints[shape.joint as usize].parent, |&j| {
            character.joints[j as usize].parent
        });
        let parent = above.find(other)?;
        let (origin, axis) = (shape.start.as_vec3(), shape.axis.as_vec3());
        Some(Swing { group: g, joint: shape.joint, parent, origin, axis })
    };
    (0..).zip(shapes).filter_map(of).collect()
}

/// The joints of a character that fold: elbows, knees, and unnamed joints between a group and its only child.
pub(super) fn folds(groups: &FieldGroups, shapes: &[Shape], limb: bool) -> Vec<FoldRest> {
    let of = |(g, group): (u32, &super::Group)| {
        let parent = group.parent?;
        let above = &groups.groups[parent as usize];
        let folds = match (above.part, group.part) {
            (Some(BodyPart::UpperArm), Some(BodyPart::Forearm)) | (Some(BodyPart::Thigh), Some(BodyPart::Calf)) => true,
            (None, None) => groups.children(parent).count() == 1,
            _ => false,
        };
        let (up, down) = (&shapes[parent as usize], &shapes[g as usize]);
        folds.then(|| FoldRest {
            parent,
            child: g,
            origin: down.start.as_vec3(),
            axes: [-up.axis.as_vec3(), down.axis.as_vec3()],
            radius: (0.5 * (up.median_radius + down.median_radius)) as f32,
            settings: if limb { OF_LIMBS } else { OF_BODIES },
        })
    };
    (0..).zip(&groups.groups).filter_map(of).collect()
}
