//! The axis of a muscle that lies round something is its path.

use super::*;
use crate::field::muscle::wrap::{
    Course, MuscleWrap, Spacing,
    cylinder::{self, Cylinder},
    sphere::Side,
};
use crate::field::muscle::{AxisPoint, MuscleFrame, MuscleInput, MuscleRest, Profile, axis};
use crate::math::polar;
use crate::rig::JointFrame;
use glam::{Mat4, Quat, Vec3, Vec4, Vec4Swizzles};
use std::f32::consts::PI;

const RADIUS: f32 = 0.02;
const VOLUME: f32 = 1e-4;

/// A muscle from one bone to the other, along Y past a hinge about Z at the origin, round a sphere or a cylinder there.
fn muscle(sphere: bool) -> (MuscleRest, MuscleWrap) {
    let (origin, insertion) = (Vec3::new(0.026, -0.2, 0.004), Vec3::new(0.025, 0.1, -0.01));
    let (low, high) = (-0.05, 0.05);
    let side = if sphere {
        let side = Side::at_rest(origin, insertion, RADIUS, None).expect("a side");
        side.axis.extend(side.swept)
    } else {
        let bone = Cylinder { radius: RADIUS, low, high };
        Vec3::Z.extend(cylinder::side_at_rest(origin, insertion, &bone, None).expect("a side"))
    };
    let length = origin.distance(insertion);
    let wrap = MuscleWrap {
        to_rest: Mat4::IDENTITY,
        side,
        radius: RADIUS,
        low,
        high,
        rest_length: length,
        sphere: sphere.into(),
        tendon: 3,
        segments: 29,
        ..MuscleWrap::default()
    };
    let rest = MuscleRest {
        origin: origin.extend(VOLUME),
        insertion: insertion.extend(0.02),
        origin_normal: Vec3::Z.extend(length),
        insertion_normal: Vec3::Z.extend(0.0),
        insertion_joint: 1,
        segments: 29,
        wrap: 1,
        ..MuscleRest::default()
    };
    (rest, wrap)
}

/// The hinge bent by an angle away from the muscle's side, all of it moved by `whole`.
fn joints(angle: f32, whole: Mat4) -> [JointFrame; 2] {
    [whole, whole * Mat4::from_rotation_z(angle)].map(|matrix| {
        let (rotation, _, stretch) = polar(&matrix);
        JointFrame { matrix, real: rotation.into(), dual: Vec4::ZERO, stretch }
    })
}

fn shaped(
    rest: &MuscleRest,
    wrap: &MuscleWrap,
    joints: &[JointFrame],
    iterates: &[Vec4],
) -> (MuscleFrame, Vec<AxisPoint>) {
    let mut points = vec![AxisPoint::default(); 30];
    let mut frame = [MuscleFrame::default()];
    let inputs = [MuscleInput::new(&Profile::of(3, 3), 0.0)];
    let input = ShapeInput { joints, inputs: &inputs, iterates, wraps: std::slice::from_ref(wrap) };
    shape(std::slice::from_ref(rest), &input, &mut frame, &mut points);
    (frame[0], points)
}

#[test]
fn the_axis_has_the_paths_length_and_tangents() {
    for sphere in [true, false] {
        let (rest, wrap) = muscle(sphere);
        for angle in [0.0f32, 0.6, 1.3, 2.2] {
            let joints = joints(angle, Mat4::IDENTITY);
            let (frame, points) = shaped(&rest, &wrap, &joints, &[]);
            let to = joints[1].matrix.transform_point3(rest.insertion.xyz());
            let course = Course::new(&wrap, &Mat4::IDENTITY, rest.origin.xyz(), to, Spacing::Even);
            let (path, step) = (course.path(), course.path().length() / 29.0);
            // A chord of an arc of phi is shorter by phi^2/24 of it.
            let most = path.parts[1] * (step / RADIUS).powi(2) / 24.0 + 2.0 * step * (step / RADIUS) / 8.0;
            let missing = path.length() - frame.length;
            assert!((-1e-6..=most + 1e-6).contains(&missing), "{angle}: {missing} of {most}");
            for (i, point) in points[..29].iter().enumerate() {
                let wanted = path.direction(step * (i as f32 + 0.5));
                let apart = point.tangent.xyz().angle_between(wanted);
                assert!(apart < 0.5 * step / RADIUS + 1e-3, "{angle}, segment {i}: {apart}");
            }
            let straight = rest.origin.xyz().distance(to);
            assert!(angle < 1.0 || frame.length > straight * 1.005, "{angle}: {} {straight}", frame.length);
            let volume = PI * frame.width * frame.width * frame.length;
            assert!((volume / VOLUME - 1.0).abs() < 1e-5, "{volume}");
        }
    }
}

#[test]
fn the_axis_turns_with_the_character() {
    let (rest, wrap) = muscle(true);
    let whole =
        Mat4::from_scale_rotation_translation(Vec3::splat(1.7), Quat::from_rotation_x(0.8), Vec3::new(3.0, -1.0, 2.0));
    let (_, here) = shaped(&rest, &wrap, &joints(1.3, Mat4::IDENTITY), &[]);
    let (_, there) = shaped(&rest, &wrap, &joints(1.3, whole), &[]);
    let apart = |a: &[AxisPoint], b: &[AxisPoint]| {
        a.iter().zip(b).map(|(a, b)| a.position.xyz().distance(b.position.xyz())).fold(0.0, f32::max)
    };
    assert!(apart(&here, &there) < 5e-6, "{}", apart(&here, &there));
    let (_, other) = shaped(&rest, &wrap, &joints(1.31, whole), &[]);
    assert!(apart(&here, &other) > 1e-4, "another angle must be seen");
}

/// Particles on the path as springs have them, and one of them aside; the axis is the path, and smooth beside it.
#[test]
fn an_axis_in_motion_is_smoothed_beside_its_path() {
    let (rest, wrap) = muscle(true);
    let joints = joints(1.8, Mat4::IDENTITY);
    let to = joints[1].matrix.transform_point3(rest.insertion.xyz());
    let course = Course::new(&wrap, &Mat4::IDENTITY, rest.origin.xyz(), to, Spacing::Tension);
    let iterates = |aside: f32| {
        let mut iterates = vec![Vec4::ZERO; axis::half(1, 30)];
        for i in 0..30u32 {
            let place = course.point(i) + if i == 15 { Vec3::Z * aside } else { Vec3::ZERO };
            iterates[2 + 2 * i as usize] = place.extend(0.01);
        }
        iterates
    };
    let off = |points: &[AxisPoint]| {
        (0..).zip(points).map(|(i, p)| p.position.xyz().distance(course.point(i))).fold(0.0, f32::max)
    };
    let (_, on) = shaped(&rest, &wrap, &joints, &iterates(0.0));
    assert!(off(&on) < 1e-6, "{}", off(&on));
    let (_, aside) = shaped(&rest, &wrap, &joints, &iterates(5e-3));
    assert!((5e-4..2e-3).contains(&off(&aside)), "a kink of one point is spread: {}", off(&aside));
    let straight = MuscleRest { wrap: 0, ..rest };
    let (_, cut) = shaped(&straight, &wrap, &joints, &iterates(0.0));
    assert!(off(&cut) > 1e-3, "smoothed as if it were straight, the path's corner is cut: {}", off(&cut));
}
