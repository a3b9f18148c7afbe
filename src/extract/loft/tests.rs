//! Lofts of a made limb's muscle: closed, under the skin, as large as the muscle, and moved without losing volume.

use super::super::{
    chain::{Settings, bellies, link},
    section::{Plane, cut},
    tests::{Known, LENGTH, limb},
    window::Outline,
};
use super::*;
use crate::field::muscle::{
    MuscleInput, MuscleRest, Profile, shape as shaped, straighten,
    wrap::{Course, MuscleWrap, Spacing, sphere::Side},
};
use std::collections::HashMap;

/// Every edge once in each direction.
fn is_closed(surface: &Surface) -> bool {
    let mut edges = HashMap::new();
    let sides = surface.triangles.iter().flat_map(|t| (0..3).map(move |k| (t[k], t[(k + 1) % 3])));
    sides.for_each(|side| *edges.entry(side).or_insert(0) += 1);
    edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
}

const KNOWN: Known =
    Known { angle: 0.5, away: 0.024, radius: 0.019, flat: 1.0, from: 0.12, to: 0.88, exponents: (3, 3) };

/// The loft of a limb's only muscle, and the limb's skin.
fn lofted() -> (Loft, crate::extract::section::Surface) {
    let skin = limb(&[KNOWN], 0.004, 0.0);
    let section = |k: usize| {
        let plane = Plane::across(DVec3::Z * LENGTH * (0.01 + 0.98 * k as f64 / 32.0), DVec3::Z, DVec3::X);
        let cuts = cut(&skin, &plane);
        Section::new(k, plane, &Outline::whole(&cuts[0]), &Settings::ARM).expect("simple")
    };
    let sections: Vec<Section> = (0..33).map(section).collect();
    let belly = link(&sections, &Settings::ARM).iter().flat_map(|chain| bellies(&sections, chain)).next();
    let belly = belly.expect("a muscle");
    let end = |share: f64| (DVec2::from_angle(KNOWN.angle) * KNOWN.away).extend(LENGTH * share);
    let ends = [end(KNOWN.from), end(KNOWN.to)];
    (Loft::new(&sections, &belly.links, &belly.roots_rest, ends).expect("a loft"), skin)
}

/// An axis between two points, straight or on a course.
fn axis(ends: [Vec3; 2], course: Option<&Course>) -> Vec<AxisPoint> {
    let rest = MuscleRest { origin: ends[0].extend(7e-5), segments: 29, ..MuscleRest::default() };
    let mut points = vec![AxisPoint::default(); 30];
    match course {
        Some(course) => course.put(&mut points),
        None => straighten(&mut points, ends[0], ends[1]),
    }
    shaped(&rest, &MuscleInput::new(&Profile::of(3, 3), 0.0), &mut points, Vec3::X, Vec3::X);
    points
}

#[test]
fn a_loft_is_closed_and_as_large_as_its_muscle_and_under_the_skin() {
    let (loft, skin) = lofted();
    let mesh = loft.surface_rest();
    assert!(is_closed(&mesh));
    let mut torn = mesh.clone();
    torn.triangles.pop();
    assert!(!is_closed(&torn), "a hole is seen");
    // Root mean square radius of the known muscle's profile.
    let profile = Profile::of(3, 3);
    let volume =
        std::f64::consts::PI * (KNOWN.radius / f64::from(profile.max())).powi(2) * (KNOWN.to - KNOWN.from) * LENGTH;
    println!("{} of {volume} cubic metres", mesh.volume());
    assert!((mesh.volume() / volume - 1.0).abs() < 0.3, "{} of {volume}", mesh.volume());
    // The skin is 120 vertices around in 121 rings.
    let outside = |p: &Vec3, by: f64| {
        let p = p.as_dvec3();
        let ring = (p.z / LENGTH * 120.0).clamp(0.0, 119.0);
        let turn = p.truncate().to_angle().rem_euclid(TAU) / TAU * 120.0;
        let at = |r: usize, k: usize| skin.positions_rest[r * 120 + k % 120].truncate().length();
        let (r, k) = (ring as usize, turn as usize);
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let row = |r: usize| mix(at(r, k), at(r, k + 1), turn.fract());
        p.truncate().length() - mix(row(r), row(r + 1), ring.fract()) + by
    };
    let most = |by| mesh.positions.iter().map(|p| outside(p, by)).fold(f64::MIN, f64::max);
    assert!(most(0.0) < 0.0, "{} m outside of the skin", most(0.0));
    assert!(most(0.003) > 0.0, "its crest is just under the skin: {}", most(0.0));
}

#[test]
fn ends_arrive_along_the_root_curve() {
    let (loft, _) = lofted();
    let count = loft.rings_rest.len();
    for (end, near, far) in [(0, 0, 1), (1, count - 1, count - 2)] {
        let size = |r: usize| loft.rings_rest[r][0].distance(loft.rings_rest[r][AROUND / 2]);
        assert!(size(near) < 0.5 * size(far).max(1e-9) + 1e-3, "it closes towards its end");
        let middle = loft.rings_rest[near].iter().sum::<DVec3>() / AROUND as f64;
        let way = loft.ends_rest[1] - loft.ends_rest[0];
        let off = (middle - loft.ends_rest[end]).reject_from(way).length();
        assert!(off < 0.004, "{off}");
    }
}

#[test]
fn a_bound_loft_is_itself_at_rest_and_keeps_its_volume_where_it_shortens_and_bends() {
    let (loft, _) = lofted();
    let ends = loft.ends_rest.map(|p| p.as_vec3());
    let bound = loft.bound(&axis(ends, None));
    let rest = loft.surface_rest();
    let posed = |points: &[AxisPoint]| bound.posed(points, &Mat4::IDENTITY);
    let same = posed(&axis(ends, None));
    let off = same.positions.iter().zip(&rest.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(off < 1e-6, "{off}");
    for stretch in [0.7, 0.85, 1.2] {
        let moved = posed(&axis([ends[0], ends[0] + (ends[1] - ends[0]) * stretch], None));
        let ratio = moved.volume() / rest.volume();
        println!("length {stretch}: volume {ratio:.4}");
        assert!(is_closed(&moved) && (ratio - 1.0).abs() < 0.01, "{stretch}: {ratio}");
    }
    // Round a joint half way, bent by 60 degrees: beside the axis it lies deeper in, and loses little.
    let centre = (ends[0] + ends[1]) * 0.5 - Vec3::X * 0.05;
    let turned = glam::Quat::from_rotation_y(-1.0) * (ends[1] - centre);
    let side = Side::at_rest(ends[0] - centre, ends[1] - centre, 0.04, None).expect("a side");
    let wrap = MuscleWrap {
        to_rest: Mat4::from_translation(centre),
        side: side.axis.extend(side.swept),
        radius: 0.04,
        sphere: 1,
        segments: 29,
        ..MuscleWrap::default()
    };
    let course = Course::new(&wrap, &wrap.to_rest, ends[0], centre + turned, Spacing::Even);
    assert!(course.path().angle > 0.2, "it touches the joint");
    let bent = posed(&axis([ends[0], centre + turned], Some(&course)));
    let ratio = bent.volume() / rest.volume();
    println!("bent: volume {ratio:.4}");
    assert!(is_closed(&bent) && (ratio - 1.0).abs() < 0.05, "{ratio}");
}

/// Check values of background 6.6.
#[test]
fn growth_has_the_backgrounds_values() {
    let areas = [0, 1, 2].map(|n| {
        let steps = 20_000;
        let at = |k: i32| {
            let u = f64::from(2 * k + 1) / f64::from(steps) - 1.0;
            let belly = 1.0 - u * u;
            (0.2 * belly + 0.02) * (0.12 * belly + 0.02) * belly.powi(2 * n)
        };
        (0..steps).map(at).sum::<f64>() / f64::from(steps)
    });
    for (stretch, kappa) in [(0.7, 0.26185), (0.8, 0.15888), (1.2, -0.11877), (1.5, -0.25225)] {
        let grown = growth(areas, stretch);
        assert!((grown(0.5) - 1.0 - kappa).abs() < 1e-5, "{stretch}: {}", grown(0.5));
        assert!(grown(0.0) == 1.0 && grown(1.0) == 1.0, "ends stay");
    }
    assert!((growth(areas, 10.0)(0.0) - 0.1f64.sqrt()).abs() < 1e-12, "stretched tenfold it thins evenly");
}
