//! Where joints are at the end of a substep, and how they carry what hangs on them. Twin of the kernel `joint_step`.

use super::StepClock;
use crate::math::{affine_inverse, cube_root, product};
use crate::rig::JointFrame;
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};

crate::gpu_struct! {
    /// One joint at the end of a substep.
    pub struct MovedJoint {
        /// Scene space at rest to posed scene space.
        pub matrix: Mat4,
        /// What the joint adds to a point that it carries through the substep: from the point's place before to its
        /// displacement. All zero where the joint stands still.
        pub carry: Mat4,
        /// Posed scene space to scene space at rest; the identity where the joint has no volume.
        pub to_rest: Mat4,
        /// How much the joint enlarges: the cube root of its volume factor.
        pub scale: f32,
        /// 1 while the instance has substeps left, 0 afterwards.
        pub runs: u32,
        /// Share of a velocity relative to the bones that outlives the substep.
        pub retention: f32,
        /// 1 where nothing is simulated but the axes are carried along, to a moment between two substeps.
        pub carries: u32,
    }
}

/// Moves all joints of one instance on by one substep; or, where `carries`, to the frame itself.
///
/// `joints` are first those at the end of the last frame's last substep, then those of the frame, `joint_count` each.
pub fn step(clock: &StepClock, carries: bool, joints: &[JointFrame], moved: &mut [MovedJoint]) {
    let (before, now) = joints.split_at(joints.len() / 2);
    let runs = carries || clock.turn < clock.turns;
    let turn = clock.turn.min(clock.turns);
    // A settling substep moves nothing: the joints stand where the frame has them.
    let share = |turn: u32| if turn == 0 { 0.0 } else { clock.first + clock.step * (turn - 1) as f32 };
    let (from, to) = if carries { (share(turn), 1.0) } else { (share(turn), share(turn + 1)) };
    for ((before, now), out) in before.iter().zip(now).zip(moved) {
        let start = between(before, now, from);
        let matrix = between(before, now, to);
        let (inverse, volume) = affine_inverse(&start);
        let (to_rest, _) = affine_inverse(&matrix);
        *out = MovedJoint {
            matrix,
            carry: product(&(matrix - start), &inverse),
            to_rest,
            scale: cube_root(volume.abs()),
            runs: runs.into(),
            retention: clock.retention(),
            carries: carries.into(),
        };
    }
}

/// The matrix at a share of the way.
fn between(before: &JointFrame, now: &JointFrame, share: f32) -> Mat4 {
    // A joint that stands still stands still to the bit, whatever the share is.
    if share <= 0.0 || before.matrix == now.matrix {
        return before.matrix;
    }
    if share >= 1.0 {
        return now.matrix;
    }
    let (q, s) = parts_between(before, now, share);
    let turned = |v: Vec4| rotate(q, v.xyz()).extend(0.0);
    let place = before.matrix.w_axis * (1.0 - share) + now.matrix.w_axis * share;
    Mat4::from_cols(turned(s.x_axis), turned(s.y_axis), turned(s.z_axis), place)
}

/// Rotation, by the shorter way, and stretch at a share of the way.
fn parts_between(before: &JointFrame, now: &JointFrame, share: f32) -> (Vec4, Mat4) {
    let rest = 1.0 - share;
    let (a, b) = (before.real, now.real);
    let sign = if a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w < 0.0 { -share } else { share };
    let q = a * rest + b * sign;
    let q = q / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
    let mix = |a: Vec4, b: Vec4| a * rest + b * share;
    let (s, t) = (&before.stretch, &now.stretch);
    let stretch = Mat4::from_cols(
        mix(s.x_axis, t.x_axis),
        mix(s.y_axis, t.y_axis),
        mix(s.z_axis, t.z_axis),
        mix(s.w_axis, t.w_axis),
    );
    (q, stretch)
}

/// A joint at a share of the way from one moment to another, for a clock that stands there.
pub(super) fn frame_between(before: &JointFrame, now: &JointFrame, share: f32) -> JointFrame {
    let (real, stretch) = parts_between(before, now, share);
    JointFrame { matrix: between(before, now, share), real, dual: before.dual, stretch }
}

/// A vector turned by a unit quaternion `xyzw`.
fn rotate(q: Vec4, v: Vec3) -> Vec3 {
    let u = q.xyz();
    let t = u.cross(v) * 2.0;
    v + t * q.w + u.cross(t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{polar, transform_point};
    use glam::Quat;

    fn frame(matrix: Mat4) -> JointFrame {
        let (rotation, _, stretch) = polar(&matrix);
        JointFrame { matrix, real: rotation.into(), dual: Vec4::ZERO, stretch }
    }

    fn posed(angle: f32, scale: f32) -> Mat4 {
        Mat4::from_scale_rotation_translation(
            Vec3::splat(scale),
            Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), angle),
            Vec3::new(0.3 * angle, 1.0, -0.2),
        )
    }

    fn clock(turn: u32) -> StepClock {
        StepClock { first: 0.25, step: 0.25, turns: 4, turn, ..StepClock::default() }
    }

    fn moved(joints: &[JointFrame; 2], turn: u32, carries: bool) -> MovedJoint {
        let mut out = [MovedJoint::default()];
        step(&clock(turn), carries, joints, &mut out);
        out[0]
    }

    #[test]
    fn joints_turn_by_equal_parts_and_arrive() {
        let joints = [frame(posed(0.0, 1.0)), frame(posed(0.4, 1.2))];
        for turn in 0..4 {
            let share = (turn + 1) as f32 / 4.0;
            let found = moved(&joints, turn, false);
            let expected = posed(0.4 * share, 1.0 + 0.2 * share);
            assert!(found.matrix.abs_diff_eq(expected, 3e-4), "{share}: {} {expected}", found.matrix);
            assert!(!found.matrix.abs_diff_eq(posed(0.4 * share + 0.01, 1.0), 3e-4), "another angle must differ");
            assert!((found.to_rest * found.matrix).abs_diff_eq(Mat4::IDENTITY, 1e-5));
            assert_eq!(found.runs, 1);
        }
        assert_eq!(moved(&joints, 3, false).matrix, joints[1].matrix, "to the bit");
        assert_eq!(moved(&joints, 4, false).runs, 0, "no substep is left");
    }

    #[test]
    fn carried_points_stay_on_their_joint() {
        let joints = [frame(posed(0.1, 1.0)), frame(posed(0.5, 0.9))];
        let local = Vec3::new(0.1, -0.2, 0.3);
        let mut place = transform_point(&joints[0].matrix, local);
        for turn in 0..4 {
            let joint = moved(&joints, turn, false);
            place += transform_point(&joint.carry, place);
            assert!(place.distance(transform_point(&joint.matrix, local)) < 1e-6, "{turn}");
        }
        let mut out = [MovedJoint::default()];
        let uneven = StepClock { first: 0.13, step: 0.21, turns: 4, turn: 2, ..StepClock::default() };
        step(&uneven, false, &[joints[0], joints[0]], &mut out);
        assert!(out[0].carry.to_cols_array().iter().all(|c| *c == 0.0), "nothing moves, not even by rounding");
    }

    #[test]
    fn axes_are_carried_from_the_last_substep_to_the_frame() {
        let joints = [frame(posed(0.0, 1.0)), frame(posed(0.4, 1.0))];
        let mut out = [MovedJoint::default()];
        let uneven = StepClock { first: 0.2, step: 0.25, turns: 3, turn: 3, ..StepClock::default() };
        step(&uneven, true, &joints, &mut out);
        assert_eq!((out[0].matrix, out[0].runs, out[0].carries), (joints[1].matrix, 1, 1));
        let local = Vec3::new(0.1, -0.2, 0.3);
        let before = transform_point(&between(&joints[0], &joints[1], 0.7), local);
        let after = before + transform_point(&out[0].carry, before);
        assert!(after.distance(transform_point(&joints[1].matrix, local)) < 1e-6);
    }

    #[test]
    fn a_joint_without_volume_harms_nothing() {
        let flat = frame(Mat4::from_scale(Vec3::new(0.0, 1.0, 1.0)));
        let found = moved(&[flat, flat], 0, false);
        assert!(found.to_rest == Mat4::IDENTITY && found.carry.is_finite() && found.scale == 0.0);
    }
}
