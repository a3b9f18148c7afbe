//! Against the shortest path that a string of many points finds by itself, in f64.

use super::*;
use glam::DVec3;

/// Points of the finest string.
const POINTS: usize = 257;

/// Where a point is put that is inside.
type PushOut = fn(DVec3, f64) -> DVec3;

fn out_of_cylinder(p: DVec3, radius: f64) -> DVec3 {
    let away = p.truncate().length();
    if away < radius { (p.truncate() * (radius / away)).extend(p.z) } else { p }
}

fn out_of_sphere(p: DVec3, radius: f64) -> DVec3 {
    if p.length() < radius { p * (radius / p.length()) } else { p }
}

/// Length of a string that has pulled itself tight from `start`, a coarse line round the obstacle on the side that is meant.
fn tight(start: &[DVec3], radius: f64, push_out: PushOut) -> f64 {
    let mut line = start.to_vec();
    loop {
        // Every point goes to the middle of its neighbours and beyond (successive over-relaxation), and out of the obstacle.
        let over = 2.0 / (1.0 + (std::f64::consts::PI / line.len() as f64).sin());
        for sweep in 0..12 * line.len() {
            let over = if sweep > 10 * line.len() { 1.0 } else { over };
            for i in 1..line.len() - 1 {
                let middle = 0.5 * (line[i - 1] + line[i + 1]);
                line[i] = push_out(line[i] + (middle - line[i]) * over, radius);
            }
        }
        if line.len() >= POINTS {
            return line.windows(2).map(|w| w[0].distance(w[1])).sum();
        }
        let finer = line.windows(2).flat_map(|w| [w[0], push_out(0.5 * (w[0] + w[1]), radius)]);
        line = finer.chain(line.last().copied()).collect();
    }
}

/// A coarse line over given corners.
fn over(corners: &[Vec3]) -> Vec<DVec3> {
    let corners: Vec<DVec3> = corners.iter().map(|c| c.as_dvec3()).collect();
    let parts = corners.windows(2).flat_map(|w| (0..4).map(move |i| w[0].lerp(w[1], f64::from(i) / 4.0)));
    parts.chain(corners.last().copied()).collect()
}

/// The string's chords cut the corner of every arc by a 24th of the square of their angle.
const CHORDS: f64 = 2e-5;

/// Fails where a path is not as long as the shortest one.
fn shortest(path: &WrapPath, string: f64) {
    let ratio = f64::from(path.length()) / string;
    assert!(ratio > 1.0 - 1e-6, "shorter than can be, by {}: {path:?}", 1.0 - ratio);
    assert!(ratio < 1.0 + CHORDS, "longer than the shortest, by {}: {path:?}", ratio - 1.0);
}

#[test]
fn paths_round_a_bone_are_shortest() {
    let bone = Cylinder::endless(0.02);
    let cases = [
        (Vec3::new(0.05, 0.01, -0.05), Vec3::new(-0.03, 0.005, 0.06)),
        (Vec3::new(0.021, 0.001, 0.0), Vec3::new(-0.04, -0.03, 0.2)),
        (Vec3::new(0.03, -0.02, 0.0), Vec3::new(-0.022, -0.005, 0.0)),
        (Vec3::new(0.1, 0.01, 0.0), Vec3::new(-0.12, 0.02, 0.01)),
    ];
    for (origin, insertion) in cases {
        for locator in [Vec3::Y, Vec3::NEG_Y] {
            let side = side_of(origin, insertion, &bone, locator);
            let path = checked_round_bone(origin, insertion, &bone, side);
            assert!(path.touches());
            let corner = |x: f32, z: f32| Vec3::new(x, 0.04 * locator.y, origin.z + (insertion.z - origin.z) * z);
            let string = over(&[origin, corner(0.03, 0.3), corner(-0.03, 0.7), insertion]);
            shortest(&path, tight(&string, 0.02, out_of_cylinder));
            let wider = cylinder::path(origin, insertion, &Cylinder::endless(0.0203), side);
            let seen = std::panic::catch_unwind(|| shortest(&wider, tight(&string, 0.02, out_of_cylinder)));
            assert!(seen.is_err(), "a path round something wider must be seen");
        }
    }
}

#[test]
fn paths_round_a_joint_are_shortest() {
    let cases = [
        (Vec3::new(0.05, 0.01, -0.02), Vec3::new(-0.03, 0.01, 0.01)),
        (Vec3::new(0.021, 0.006, 0.0), Vec3::new(-0.04, 0.01, 0.015)),
        (Vec3::new(0.01, 0.03, 0.2), Vec3::new(0.0, 0.01, -0.03)),
    ];
    for (origin, insertion) in cases {
        let side = Side::at_rest(origin, insertion, 0.02, None).expect("a side");
        let path = checked_round_joint(origin, insertion, 0.02, &side);
        assert!(path.touches());
        let along = (insertion - origin).normalize();
        let foot = (origin - along * origin.dot(along)).normalize() * 0.04;
        let string = over(&[origin, foot - along * 0.02, foot + along * 0.02, insertion]);
        shortest(&path, tight(&string, 0.02, out_of_sphere));
        let wider = sphere::path(origin, insertion, 0.0203, &side);
        let seen = std::panic::catch_unwind(|| shortest(&wider, tight(&string, 0.02, out_of_sphere)));
        assert!(seen.is_err(), "a path round something wider must be seen");
    }
}
