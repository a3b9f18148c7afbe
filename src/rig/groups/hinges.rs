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

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f32 = 0.05;

    /// A straight limb along Y that folds about X at the origin.
    fn elbow(settings: Settings) -> FoldRest {
        FoldRest { parent: 0, child: 1, origin: Vec3::ZERO, axes: [Vec3::NEG_Y, Vec3::Y], radius: RADIUS, settings }
    }

    fn bent(fold: &FoldRest, degrees: f32) -> [Fold; 2] {
        let common = Mat4::from_rotation_z(0.4) * Mat4::from_translation(Vec3::X);
        let child = common * Mat4::from_rotation_x(degrees.to_radians());
        let frame = |m: Mat4| GroupFrame { to_rest: m.inverse(), ..GroupFrame::default() };
        fold.posed(&[frame(common), frame(child)])
    }

    #[test]
    fn folds_displace_nothing_at_rest_and_more_the_further_they_go() {
        let fold = elbow(OF_LIMBS);
        let offset = |degrees: f32| bent(&fold, degrees)[0].offset;
        assert!(offset(0.0).abs() < 1e-9);
        for degrees in 1..=130 {
            assert!(offset(degrees as f32) > offset(degrees as f32 - 1.0), "at {degrees}");
        }
        // tan(65 degrees) - 65 degrees in radians: 2.144507 - 1.134464.
        assert!((offset(130.0) - 0.19 * RADIUS * 1.010_043).abs() < 1e-7, "{}", offset(130.0));
        assert!((bent(&elbow(OF_BODIES), 130.0)[1].offset - 0.25 * RADIUS * 1.010_043).abs() < 1e-7);
        assert_eq!(offset(179.0), MOST_OFFSET * RADIUS, "no further than half a radius");
        assert!((offset(100.0) - offset(-100.0)).abs() < 1e-8, "either way");
        // A limb that is drawn bent has that for its rest.
        let bind = elbow(OF_LIMBS);
        let half = Mat4::from_rotation_x(0.7).transform_vector3(Vec3::Y);
        let drawn = FoldRest { axes: [Vec3::NEG_Y, half], ..bind };
        assert!(bent(&drawn, 0.0)[0].offset.abs() < 1e-9);
        let g = |angle: f32| (0.5 * angle).tan() - 0.5 * angle;
        let expected = 0.19 * RADIUS * (g(1.7) - g(0.7));
        assert!((bent(&drawn, 1f32.to_degrees())[0].offset - expected).abs() < 1e-7);
        assert_eq!(bent(&drawn, (-0.5f32).to_degrees())[0].offset, 0.0, "straightened further nothing is pressed");
    }

    #[test]
    fn both_ends_bulge_on_the_side_that_they_fold_to() {
        let [parent, child] = bent(&elbow(OF_LIMBS), 90.0);
        // Turned about X the forearm goes from Y to Z.
        assert!(parent.inner.truncate().abs_diff_eq(Vec3::Z, 1e-6), "{}", parent.inner);
        assert!(child.inner.truncate().abs_diff_eq(Vec3::Z, 1e-6), "{}", child.inner);
        assert!(parent.centre.truncate().abs_diff_eq(Vec3::NEG_Y * 1.25 * RADIUS, 1e-6));
        assert!(child.centre.truncate().abs_diff_eq(Vec3::Y * 1.25 * RADIUS, 1e-6));
        assert!((parent.centre.w - 3.25 * RADIUS).abs() < 1e-6 && (parent.axis.w - 2.25 * RADIUS).abs() < 1e-6);
        assert_eq!(parent.inner.w, OUTER_LACK);
        let flat = elbow(OF_LIMBS).posed(&[GroupFrame::default(), GroupFrame::default()]);
        assert!(flat.iter().all(|f| f.offset.is_finite() && f.inner.is_finite()), "frames without volume");
    }

    #[test]
    fn gates_open_with_the_swing() {
        let swing = Swing { group: 1, joint: 1, parent: 0, origin: Vec3::ZERO, axis: Vec3::NEG_Y };
        let at = |degrees: f32| {
            let parent = Mat4::from_rotation_y(1.0);
            swing.direction(&[parent, parent * Mat4::from_rotation_z(degrees.to_radians())])
        };
        assert!(at(0.0).1 < 1e-3);
        let (direction, open) = at(7.5);
        // An arm that hangs down and turns about Z goes to X.
        assert!(direction.abs_diff_eq(Vec3::X, 1e-5) && (open - 0.5).abs() < 1e-4, "{direction} {open}");
        assert_eq!(at(40.0).1, 1.0);
        let flat = swing.direction(&[Mat4::ZERO, Mat4::IDENTITY]);
        assert!(flat.0.is_finite() && flat.1.is_finite(), "{flat:?}");
    }
}
