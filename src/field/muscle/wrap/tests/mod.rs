//! Paths round obstacles: worked figures, odd cases, what turning a joint does, the shortest path, OpenSim's muscles.

mod continuity;
mod geodesic;
mod opensim;

use super::cylinder::{self, Cylinder};
use super::sphere::{self, Side};
use super::{CLEARANCE, WrapPath};
use glam::{Vec2, Vec3, Vec3Swizzles};
use proptest::prelude::*;
use std::f32::consts::{PI, TAU};

/// Fails where a path is no path: not from end to end, into the obstacle (`depth` of a point, metres), with a corner, or of
/// another length than its points.
fn check(path: &WrapPath, depth: impl Fn(Vec3) -> f32) {
    let mut points = [Vec3::ZERO; 257];
    path.sample(&mut points);
    assert!(points.iter().all(|p| p.is_finite()), "{path:?}");
    assert!(points[0].distance(path.origin) < 1e-7 && points[256] == path.insertion, "{path:?}");
    let step = path.length() / 256.0;
    let mut sum = 0.0;
    for (i, pair) in points.windows(2).enumerate() {
        sum += pair[0].distance(pair[1]);
        assert!(depth(pair[0]) < 2e-6, "{} m inside at point {i}: {path:?}", depth(pair[0]));
        let (here, next) = (path.direction(step * i as f32), path.direction(step * (i as f32 + 1.0)));
        let bend = if path.touches() { step / path.outward.length() } else { 0.0 };
        assert!(here.distance(next) < 1.01 * bend + 2e-3, "a corner of {} at point {i}: {path:?}", here.distance(next));
        if step > 1e-4 {
            assert!((pair[1] - pair[0]).normalize().distance(here) < bend + 2e-3, "point {i}: {path:?}");
        }
    }
    // Chords are shorter than their arcs by the square of the angle between points over 24.
    assert!((sum / path.length() - 1.0).abs() < 2e-4 || path.length() < 1e-6, "{sum} along {path:?}");
}

fn checked_round_bone(origin: Vec3, insertion: Vec3, cylinder: &Cylinder, side: f32) -> WrapPath {
    let path = cylinder::path(origin, insertion, cylinder, side);
    check(
        &path,
        |p| if (cylinder.low..=cylinder.high).contains(&p.z) { cylinder.radius - p.xy().length() } else { 0.0 },
    );
    path
}

fn checked_round_joint(origin: Vec3, insertion: Vec3, radius: f32, side: &Side) -> WrapPath {
    let path = sphere::path(origin, insertion, radius, side);
    check(&path, |p| radius - p.length());
    path
}

fn side_of(origin: Vec3, insertion: Vec3, cylinder: &Cylinder, locator: Vec3) -> f32 {
    cylinder::side_at_rest(origin, insertion, cylinder, Some(locator)).expect("a side")
}

fn near(a: f32, b: f64, within: f64) -> bool {
    (f64::from(a) - b).abs() <= within
}

#[test]
fn the_worked_case_is_met_to_its_digits() {
    // Background 6.5; its k1 and k2 are the legs over the arc.
    let (origin, insertion) = (Vec3::new(1.0, 0.2, 0.0), Vec3::new(-0.9, 0.3, 1.2));
    let bone = Cylinder::endless(0.5);
    let shorter = cylinder::side_at_rest(origin, insertion, &bone, None).expect("a side");
    let other = side_of(origin, insertion, &bone, Vec3::NEG_Y);
    assert_eq!(side_of(origin, insertion, &bone, Vec3::Y), shorter);
    let figures = [
        (shorter, [1.255769, 1.804167, 3.241513, 2.940295, 0.541621, 0.708710, 2.306062]),
        (other, [-0.860978, -2.447668, 1.120344, 1.016236, 0.428624, 0.811206, 2.762623]),
    ];
    for (side, expected) in figures {
        let path = checked_round_bone(origin, insertion, &bone, side);
        let [first, second] = path.tangent_points();
        let angle = |p: Vec3| p.y.atan2(p.x);
        let [leg_1, arc, leg_2] = path.parts;
        let found = [angle(first), angle(second), leg_1 / arc, leg_2 / arc, first.z, second.z, path.length()];
        for (found, expected) in found.into_iter().zip(expected) {
            // Six digits are given; the quotients by the arc magnify rounding.
            assert!(near(found, expected, 4e-6), "{found} for {expected}");
        }
        let thinner = cylinder::path(origin, insertion, &Cylinder::endless(0.4999), side);
        assert!(!near(thinner.length(), expected[6], 4e-6), "another radius must be seen");
    }
}

#[test]
fn a_real_muscle_is_met_to_its_digits() {
    // The brachialis of OpenSim's Arm26 at 0 degrees, in the frame of its wrap TRI (notes, prototypes 4).
    let origin = Vec3::new(0.022_039_935, 0.114_350_45, 0.019_725_735);
    let insertion = Vec3::new(-0.003_275_13, -0.021_301_514, -0.007_585_449);
    let bone = Cylinder::endless(0.016);
    let side = cylinder::side_at_rest(origin, insertion, &bone, None).expect("a side");
    let path = checked_round_bone(origin, insertion, &bone, side);
    let [first, second] = path.tangent_points();
    let legs = [origin.xy().distance(first.xy()), path.parts[1], second.xy().distance(insertion.xy())];
    for (found, expected) in legs.into_iter().zip([0.115350706, 0.015250235, 0.014438870]) {
        assert!(near(found, expected, 1e-7), "{found} for {expected}");
    }
    let expected =
        [Vec3::new(0.015_977_89, -0.000840851, -0.002034608), Vec3::new(0.008789775, -0.013369362, -0.004861627)];
    assert!(first.distance(expected[0]) < 1e-7 && second.distance(expected[1]) < 1e-7, "{first} {second}");
    assert!(near(path.length(), 0.147329031, 1e-7) && side < 0.0, "{}", path.length());
    assert!(near(origin.distance(insertion), 0.140670573, 1e-7), "without a wrap");
    let other = cylinder::path(origin, insertion, &bone, side + TAU);
    assert!(near(other.length(), 0.148519376, 1e-7), "the other way: {}", other.length());
}

#[test]
fn ends_inside_are_moved_out() {
    let bone = Cylinder { radius: 0.03, low: 0.0, high: 0.2 };
    let outside = Vec3::new(-0.05, 0.01, 0.12);
    for inside in [Vec3::new(0.01, 0.005, 0.08), Vec3::new(0.0, 0.0, 0.08), Vec3::new(0.03, 0.0, 0.08)] {
        let path = checked_round_bone(inside, outside, &bone, 2.0);
        assert!((path.origin.xy().length() / 0.03 - CLEARANCE).abs() < 1e-6 && path.origin.z == 0.08, "{path:?}");
        assert!(path.insertion == outside && path.touches());
        let side = Side { axis: Vec3::Z, swept: 2.0 };
        let path = checked_round_joint(inside * 0.3, outside, 0.03, &side);
        assert!((path.origin.length() / 0.03 - CLEARANCE).abs() < 1e-6, "{path:?}");
    }
    // Beyond its ends a bone is round, and then no more.
    for (z, expected) in [(0.2, 0.03 * CLEARANCE), (0.21, (0.03f32.powi(2) - 0.01f32.powi(2)).sqrt()), (0.26, 0.0)] {
        let moved = bone.pushed_out(Vec3::new(0.0, -1e-9, z)).xy().length();
        assert!((moved - expected).abs() < 1e-5, "{moved} at height {z}");
    }
}

#[test]
fn odd_cases_have_a_path() {
    let bone = Cylinder::endless(0.02);
    let straight = |origin, insertion, side| {
        let path = checked_round_bone(origin, insertion, &bone, side);
        assert!(!path.touches() && path.length() == origin.distance(insertion), "{path:?}");
    };
    // Along the bone, at the same angle (theta = 0), of no length.
    straight(Vec3::new(0.03, 0.0, 0.1), Vec3::new(0.03, 0.0, 0.4), 0.0);
    straight(Vec3::new(0.03, 0.0, 0.1), Vec3::new(0.05, 0.0, 0.1), 0.0);
    straight(Vec3::new(0.03, 0.0, 0.1), Vec3::new(0.03, 0.0, 0.1), 0.0);
    assert_eq!(cylinder::side_at_rest(Vec3::new(0.03, 0.0, 0.1), Vec3::new(0.05, 0.0, 0.4), &bone, None), Some(0.0));
    // Through the axis (theta = pi): the ends do not say on which side, a locator does.
    let (from, to) = (Vec3::new(0.04, 0.0, 0.1), Vec3::new(-0.06, 0.0, 0.2));
    assert_eq!(cylinder::side_at_rest(from, to, &bone, None), None);
    assert_eq!(cylinder::side_at_rest(from, to, &bone, Some(Vec3::Z)), None, "a locator on the axis");
    for (locator, sense) in [(Vec3::Y, 1.0), (Vec3::NEG_Y, -1.0)] {
        let side = side_of(from, to, &bone, locator);
        assert!((side - PI * sense).abs() < 2e-6, "{side}");
        let path = checked_round_bone(from, to, &bone, side);
        let [first, second] = path.tangent_points();
        assert!(first.y * sense > 0.0 && second.y * sense > 0.0 && path.touches());
    }
    // The same of a sphere.
    let (from, to) = (Vec3::new(0.04, 0.0, 0.0), Vec3::new(-0.06, 0.0, 0.0));
    assert_eq!(Side::at_rest(from, to, 0.02, None), None);
    assert_eq!(Side::at_rest(from, to, 0.02, Some(Vec3::X)), None, "a locator on the line");
    let side = Side::at_rest(from, to, 0.02, Some(Vec3::new(0.01, 0.0, 0.5))).expect("a side");
    let path = checked_round_joint(from, to, 0.02, &side);
    assert!((side.swept - PI).abs() < 2e-6 && path.touches());
    assert!(path.point(path.length() * 0.4).z > 0.0199, "over the locator's side");
    for (from, to) in [(Vec3::Y * 0.03, Vec3::Y * 0.03), (Vec3::Y * 0.03, Vec3::Y * 0.05), (from, Vec3::Z * 0.02)] {
        checked_round_joint(from, to, 0.02, &side);
    }
    // Along the side's own axis, about which nothing turns: straight, through the sphere.
    check(&sphere::path(side.axis * 0.05, side.axis * -0.07, 0.02, &side), |_| 0.0);
    // No obstacle at all.
    assert!(!cylinder::path(from, to, &Cylinder::endless(0.0), 0.0).touches());
    assert!(!sphere::path(from, to, 0.0, &side).touches());
}

#[test]
fn sides_are_kept() {
    // The insertion goes round the bone: past the line through the axis the path goes on over its own side.
    let bone = Cylinder::endless(0.02);
    let origin = Vec3::new(0.05, 0.0, 0.0);
    let at = |degrees: f32| (Vec2::from_angle(degrees.to_radians()) * 0.06).extend(0.1);
    let side = cylinder::side_at_rest(origin, at(150.0), &bone, None).expect("a side");
    for degrees in [60.0, 150.0, 179.0, 181.0, 240.0, 320.0] {
        let path = checked_round_bone(origin, at(degrees), &bone, side);
        let wound = degrees.to_radians() - (0.4f32).acos() - (1.0f32 / 3.0).acos();
        assert!((path.angle - wound.max(0.0)).abs() < 1e-5, "{degrees}: {} for {wound}", path.angle);
    }
    let shorter = cylinder::side_at_rest(origin, at(240.0), &bone, None).expect("a side");
    assert!(shorter < 0.0, "chosen there, it would be the other side");
    // A muscle that lies along the bone winds either way.
    let side = cylinder::side_at_rest(origin, at(0.0), &bone, None).expect("a side");
    let (left, right) =
        (cylinder::path(origin, at(170.0), &bone, side), cylinder::path(origin, at(-170.0), &bone, side));
    assert!(left.touches() && (left.length() - right.length()).abs() < 1e-6);
    assert!(left.tangent_points()[0].y > 0.0 && right.tangent_points()[0].y < 0.0);
}

#[test]
fn a_locator_chooses_the_nearer_way() {
    let bone = Cylinder::endless(0.02);
    let (origin, insertion) = (Vec3::new(0.05, 0.01, 0.0), Vec3::new(-0.04, 0.02, 0.1));
    for (locator, way) in [(Vec3::Y, 1.0), (Vec3::NEG_Y, -1.0), (Vec3::new(0.001, 0.01, 7.0), 1.0)] {
        assert_eq!(side_of(origin, insertion, &bone, locator).signum(), way, "{locator}");
        let insertion = insertion.with_z(0.0);
        let side = Side::at_rest(origin, insertion, 0.02, Some(locator.with_z(0.0))).expect("a side");
        let path = checked_round_joint(origin, insertion, 0.02, &side);
        assert!(path.point(0.5 * path.length()).y * way > 0.0, "{locator}");
    }
}

#[test]
fn a_muscle_slides_off_a_bones_end() {
    let bone = Cylinder { radius: 0.02, low: -0.1, high: 0.1 };
    let ends = |z: f32| (Vec3::new(0.05, 0.003, z), Vec3::new(-0.06, 0.004, z + 0.01));
    let (origin, insertion) = ends(0.0);
    let side = cylinder::side_at_rest(origin, insertion, &bone, None).expect("a side");
    let mut before: Option<WrapPath> = None;
    for i in 0..=1200 {
        let (origin, insertion) = ends(i as f32 * 1e-4 * 1.5);
        let path = cylinder::path(origin, insertion, &bone, side);
        // Near the end it sinks as one piece, and what is not over the end yet dips into the bone.
        check(&path, |p| if p.z < 0.1 { 0.02 - 1e-4 - p.xy().length() } else { 0.0 });
        if let Some(before) = before {
            assert!(path.length() - before.length() < 2e-7, "it only ever gets shorter, at step {i}");
            assert!(before.length() - path.length() < 1.5e-4, "no jump, at step {i}");
            assert!(path.direction(0.0).angle_between(before.direction(0.0)).to_degrees() < 0.5, "step {i}");
        }
        before = Some(path);
    }
    assert!(!before.expect("steps").touches(), "it is off in the end");
    let held = cylinder::path(origin, insertion, &bone, side);
    let endless = cylinder::path(origin, insertion, &Cylinder::endless(0.02), side);
    assert_eq!(held, endless, "between its ends a bone's length is of no matter");
}

#[test]
fn points_lie_at_even_distances() {
    let bone = Cylinder::endless(0.03);
    let path = checked_round_bone(Vec3::new(0.04, 0.0, 0.0), Vec3::new(-0.02, -0.03, 0.15), &bone, 4.0);
    assert!(path.angle > 1.5 && path.rise.z > 0.03, "{path:?}");
    for count in [2, 3, 30] {
        let mut points = vec![Vec3::ZERO; count];
        path.sample(&mut points);
        let step = path.length() / (count - 1) as f32;
        for (i, point) in points.iter().enumerate() {
            assert!(point.distance(path.point(step * i as f32)) < 1e-6);
        }
    }
    path.sample(&mut []);
    let mut one = [Vec3::ZERO];
    path.sample(&mut one);
    assert_eq!(one[0], path.origin);
    assert_eq!((path.point(-1.0), path.point(9.0)), (path.origin, path.insertion));
    let broken = WrapPath { centre: path.centre + Vec3::X * 0.002, ..path };
    assert!(std::panic::catch_unwind(|| check(&broken, |_| 0.0)).is_err(), "a shifted helix must be seen");
    let deep = WrapPath { outward: path.outward * 0.99, onward: path.onward * 0.99, ..path };
    assert!(
        std::panic::catch_unwind(|| check(&deep, |p| 0.03 - p.xy().length())).is_err(),
        "a path inside must be seen"
    );
}

fn place() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(prop_oneof![4 => -0.15f32..0.15, 1 => Just(0.0)]).prop_map(Vec3::from)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

    #[test]
    fn any_ends_have_a_path_outside(
        (origin, insertion) in (place(), place()),
        (radius, half) in (1e-3f32..0.1, prop_oneof![Just(f32::MAX), 0.01f32..0.2]),
        (side, axis) in (-PI..PI, place()),
    ) {
        let bone = Cylinder { radius, low: -half, high: half };
        let endless = half == f32::MAX;
        let of_bone = cylinder::path(origin, insertion, &bone, side);
        let axis = axis.try_normalize().unwrap_or(Vec3::Z);
        let of_joint = sphere::path(origin, insertion, radius, &Side { axis, swept: side.abs() });
        let own = Side::at_rest(origin, insertion, radius, None).unwrap_or(Side { axis: origin.normalize_or(Vec3::X).any_orthonormal_vector(), swept: PI });
        let own = sphere::path(origin, insertion, radius, &own);
        // A path may pass a bone beyond its ends, and a joint where an end is on an axis that is not its own.
        let of_bone = (of_bone, if endless { radius } else { 0.0 }, Vec3::new(1.0, 1.0, 0.0));
        for (path, least, across) in [of_bone, (of_joint, 0.0, Vec3::ONE), (own, radius, Vec3::ONE)] {
            let mut points = [Vec3::ZERO; 65];
            path.sample(&mut points);
            let chord = path.origin.distance(path.insertion);
            prop_assert!(path.length() > chord - 1e-6 && path.length() < chord + TAU * radius + 0.5, "{:?}", path);
            let step = path.length() / 64.0;
            for (i, point) in points.iter().enumerate() {
                prop_assert!(point.is_finite() && path.direction(step * i as f32).is_finite(), "{:?}", path);
                let away = (*point * across).length();
                prop_assert!(away > least - 3e-6, "{} inside at point {i}: {:?}", least - away, path);
            }
            for pair in points.windows(2) {
                prop_assert!(pair[0].distance(pair[1]) < step + 2e-6, "{:?}", path);
            }
        }
    }
}
