//! The joints' way from the pose where the skin is to the next one, cut into sub-poses.

use crate::{
    field::evaluate::GroupFrame,
    math::{affine_inverse, polar, product},
    rig::{Pose, Rig, Role, group_frames},
    schedule::{TrackOptions, Tracking},
};
use glam::{Mat4, Quat, Vec3, Vec4};

crate::gpu_struct! {
    /// A joint at a sub-pose.
    pub struct TrackJoint {
        /// Scene space at rest to scene space posed.
        pub matrix: Mat4,
        /// What the joint adds to a point that it carries here from the sub-pose before: from its place to its displacement.
        pub carry: Mat4,
        /// Direction into which a limb has swung, in scene space at rest, and in `w` how far the gate that it opens is open.
        pub swing: Vec4,
    }
}

crate::gpu_struct! {
    /// An instance's way to its pose.
    pub struct Way {
        /// Sub-poses.
        pub count: u32,
        /// How far one of them turns a joint, in `direct_degrees`, at most 1.
        pub turn: f32,
        /// 1 where the instance has got a pose since it was played last: all others stay as they are.
        pub posed: u32,
    }
}

/// One sub-pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SubPose {
    /// One per joint.
    pub joints: Vec<TrackJoint>,
    /// One per field group.
    pub groups: Vec<GroupFrame>,
}

/// Where the joints are under a skin; at rest by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    /// Palette of the pose where the skin is; empty at rest.
    palette: Vec<Mat4>,
}

/// A joint that turns by less than this, radians, stands still.
const STILL_TURN: f32 = 1e-5;
/// A joint that moves by less than this share of the character's height stands still.
const STILL_SHARE: f32 = 1e-6;

impl Path {
    /// The sub-poses to a pose as the options have it: [`Path::advance`] or [`Path::leap`].
    pub fn lead(&mut self, rig: &Rig, pose: &Pose, options: &TrackOptions) -> (Way, Vec<SubPose>) {
        match options.mode {
            Tracking::History => self.advance(rig, pose, options),
            Tracking::SinglePose => self.leap(rig, pose),
        }
    }

    /// A pose as the only sub-pose, whatever came before: nothing is carried there. The path then stands there.
    pub fn leap(&mut self, rig: &Rig, pose: &Pose) -> (Way, Vec<SubPose>) {
        self.palette.clone_from(&pose.palette);
        let sub_pose =
            SubPose { joints: joints(rig, &pose.palette, &pose.palette), groups: group_frames(rig, &pose.palette) };
        (Way { count: 1, turn: 0.0, posed: 1 }, vec![sub_pose])
    }

    /// The sub-poses from here to a pose, which is the last one of them: none where it is the pose that the skin is in already. The
    /// path then stands there.
    ///
    /// Joints turn about their own centres, relative to their parents, by at most `options.degrees` per sub-pose; turns of up
    /// to `options.direct_degrees` are one.
    pub fn advance(&mut self, rig: &Rig, pose: &Pose, options: &TrackOptions) -> (Way, Vec<SubPose>) {
        let starts = self.palette.len() != pose.palette.len();
        if starts {
            self.palette = vec![Mat4::IDENTITY; pose.palette.len()];
        }
        let local = |palette: &[Mat4]| -> Vec<Turn> { (0..palette.len()).map(|j| Turn::of(rig, palette, j)).collect() };
        let (from, to) = (local(&self.palette), local(&pose.palette));
        let moving = moving_joints(rig);
        let angle = (0..from.len())
            .filter(|&j| moving[j])
            .map(|j| from[j].rotation.angle_between(to[j].rotation))
            .fold(0.0, f32::max);
        let still = STILL_SHARE * rig.character.height_rest();
        let moved = |j: usize| {
            let (a, b) = (&self.palette[j], &pose.palette[j]);
            let centre = rig.character.joints[j].bind().w_axis.truncate();
            a.transform_point3(centre).distance(b.transform_point3(centre)) > still || from[j].differs(&to[j])
        };
        if !starts && !(0..from.len()).any(moved) {
            return (Way { posed: 1, ..Way::default() }, Vec::new());
        }
        let count = options.sub_poses(angle);
        let mut before = self.palette.clone();
        let sub_poses = (1..=count)
            .map(|k| {
                let palette = match k == count {
                    true => pose.palette.clone(),
                    false => between(rig, &from, &to, k as f32 / count as f32),
                };
                let joints = joints(rig, &before, &palette);
                let groups = group_frames(rig, &palette);
                before = palette;
                SubPose { joints, groups }
            })
            .collect();
        self.palette.clone_from(&pose.palette);
        let turn = (angle.to_degrees() / (count as f32 * options.direct_degrees)).min(1.0);
        (Way { count, turn, posed: 1 }, sub_poses)
    }
}

/// Which joints move skin that the tracker holds, below a joint that does as well: a root turns everything alike.
fn moving_joints(rig: &Rig) -> Vec<bool> {
    let mut moving = vec![false; rig.character.joints.len()];
    for (v, target) in rig.targets.vertices.iter().enumerate() {
        if target.role == Role::Active as u32 {
            rig.character.influences_of(v).iter().for_each(|i| moving[i.joint as usize] = true);
        }
    }
    for (j, joint) in rig.character.joints.iter().enumerate() {
        moving[j] &= joint.parent.is_some();
    }
    moving
}

/// A joint relative to its parent: what turns it about its centre, and where its centre is.
struct Turn {
    rotation: Quat,
    stretch: Mat4,
    centre: Vec3,
}

impl Turn {
    fn of(rig: &Rig, palette: &[Mat4], j: usize) -> Turn {
        let joint = &rig.character.joints[j];
        let above = joint.parent.map_or(Mat4::IDENTITY, |p| affine_inverse(&palette[p as usize]).0);
        let relative = above * palette[j];
        let (rotation, _, stretch) = polar(&relative);
        let centre = relative.transform_point3(joint.bind().w_axis.truncate());
        Turn { rotation, stretch, centre }
    }

    fn differs(&self, other: &Turn) -> bool {
        // The chord: an angle from a rounded cosine is off by up to 1e-3, and equal rotations would differ.
        let (a, b) = (Vec4::from(self.rotation), Vec4::from(other.rotation));
        let turn = 2.0 * (a - b).length().min((a + b).length());
        turn > STILL_TURN || !self.stretch.abs_diff_eq(other.stretch, STILL_TURN)
    }
}

/// The palette at a share of the way.
fn between(rig: &Rig, from: &[Turn], to: &[Turn], share: f32) -> Vec<Mat4> {
    let mut palette: Vec<Mat4> = Vec::with_capacity(from.len());
    for (j, (a, b)) in from.iter().zip(to).enumerate() {
        let rotation = a.rotation.slerp(b.rotation, share);
        let stretch = a.stretch * (1.0 - share) + b.stretch * share;
        let mut relative = Mat4::from_quat(rotation) * stretch;
        let joint = &rig.character.joints[j];
        let off = a.centre.lerp(b.centre, share) - relative.transform_point3(joint.bind().w_axis.truncate());
        relative.w_axis += off.extend(0.0);
        let above = joint.parent.map_or(Mat4::IDENTITY, |p| palette[p as usize]);
        palette.push(above * relative);
    }
    palette
}

fn joints(rig: &Rig, before: &[Mat4], palette: &[Mat4]) -> Vec<TrackJoint> {
    let joint = |(from, to): (&Mat4, &Mat4)| {
        let carry = if from == to { Mat4::ZERO } else { product(&(*to - *from), &affine_inverse(from).0) };
        TrackJoint { matrix: *to, carry, swing: Vec4::ZERO }
    };
    let mut joints: Vec<TrackJoint> = before.iter().zip(palette).map(joint).collect();
    for swing in &rig.swings {
        let (direction, open) = swing.direction(palette);
        joints[swing.joint as usize].swing = direction.extend(open);
    }
    joints
}
