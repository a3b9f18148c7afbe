//! The field of a muscle against its own differences, closed forms and symmetries.

use super::*;
use crate::field::muscle::tests::{along, arc_muscle, muscle};
use crate::field::muscle::{MuscleInput, Profile};
use proptest::prelude::*;
use rayon::prelude::*;
use std::ops::Range;

#[test]
fn points_beyond_all_numbers_project_on_some_segment() {
    let (m, points) = muscle(0.0, (3, 3));
    for q in [Vec3::NAN, Vec3::INFINITY, Vec3::splat(1e30)] {
        // Its numbers may be none; it must end.
        let _ = project(&points, q);
        assert_eq!(evaluate(&m, &points, q).value, 0.0);
    }
}

/// Halton's points of these numbers from 1: evenly spread, and the same every time.
fn spread(numbers: Range<usize>) -> impl IndexedParallelIterator<Item = Vec3> {
    let radical = |mut i: usize, base: usize| {
        let (mut f, mut r) = (1.0, 0.0);
        while i > 0 {
            f /= base as f64;
            r += f * (i % base) as f64;
            i /= base;
        }
        r as f32
    };
    numbers.into_par_iter().map(move |i| Vec3::new(radical(i, 2), radical(i, 3), radical(i, 5)))
}

/// Squared distance of a point from a segment, in f64, and the segment's own squared length.
fn exact(points: &[AxisPoint], k: usize, q: Vec3) -> (f64, f64) {
    let (p, end) = (points[k].position.xyz().as_dvec3(), points[k + 1].position.xyz().as_dvec3());
    let (span, h) = (end - p, q.as_dvec3() - p);
    let share = (h.dot(span) / span.length_squared().max(1e-30)).clamp(0.0, 1.0);
    ((h - span * share).length_squared(), span.length_squared())
}

#[test]
fn a_key_names_a_segment_as_near_as_the_nearest() {
    let (mut next_fails, mut seen) = (0, 0);
    for (_, points) in [muscle(0.0, (3, 3)), arc_muscle(2.6, 29, (3, 3), 0.0), arc_muscle(1.0, 5, (3, 3), 0.0)] {
        for u in spread(1..20_001).collect::<Vec<_>>() {
            // Near the axis, as far as a muscle reaches, and far beyond.
            let at = points[seen % points.len()].position.xyz();
            let q = at + (u - 0.5) * [1e-5, 1e-3, 0.02, 0.2, 5.0][seen / 7 % 5];
            let (k, squared) = nearest(&points, q);
            let least = (0..points.len() - 1).map(|k| exact(&points, k, q).0).fold(f64::INFINITY, f64::min);
            let (own, length) = exact(&points, k, q);
            let tolerance = 1.2e-5 * least + 1e-6 * length;
            assert!(own <= least + tolerance, "{q}: {own} {least}");
            assert!((f64::from(squared) - least).abs() <= tolerance, "{q}: {squared} {least}");
            let (other, _) = exact(&points, if k > 1 { k - 2 } else { k + 2 }, q);
            next_fails += usize::from(other > least + tolerance);
            seen += 1;
        }
    }
    assert!(next_fails * 10 > seen * 9, "a segment further on must be told from the nearest: {next_fails} of {seen}");
}

/// Whether any of the declared kinks lies within `h` of a point: the surface, the axis, the ends, the border of the
/// support, and the planes at the axis' points where feet come and go.
fn near_a_kink(m: &MuscleFrame, points: &[AxisPoint], q: Vec3, h: f32) -> bool {
    let on = project(points, q);
    let Some((d, _, radius, _)) = raw(m, points, q, nearest(points, q).0) else { return true };
    let close = |a: f32, b: f32| (a - b).abs() < 4.0 * h;
    let planes = points[..points.len() - 1].iter().any(|p| {
        let along = (q - p.position.xyz()).dot(p.tangent.xyz());
        close(along, 0.0) || close(along, p.tangent.w)
    });
    // Of two wedges that both hold the point, the nearer one counts: the border between them is a kink too.
    let shared = points.windows(2).any(|w| close(q.distance(w[0].position.xyz()), q.distance(w[1].position.xyz())));
    // At a bend, and at the ends, the foot goes round the corner.
    let corners = points.iter().any(|p| (on.arc - p.arc()).abs() < 8.0 * h);
    close(d, radius) || d < 1e-3 || close(d - radius, m.support_radius) || corners || planes || shared || radius < 6e-3
}

/// How far a gradient is from central differences, over its own length and 30 per metre.
#[derive(Clone, Copy, Debug, Default)]
struct Differences {
    /// Largest of the field's own gradient.
    worst: f32,
    /// Largest of a gradient 5 % too long.
    longer: f32,
    /// Points away from the kinks, where the two were compared.
    compared: usize,
}

impl Differences {
    fn and(self, other: Differences) -> Differences {
        Differences {
            worst: self.worst.max(other.worst),
            longer: self.longer.max(other.longer),
            compared: self.compared + other.compared,
        }
    }

    /// Over so many points of a muscle's box.
    fn over(m: &MuscleFrame, points: &[AxisPoint], numbers: Range<usize>) -> Differences {
        let (low, high) = (m.lowest.xyz(), m.highest.xyz());
        spread(numbers).map(|u| Differences::at(m, points, low + (high - low) * u)).reduce(Default::default, Self::and)
    }

    fn at(m: &MuscleFrame, points: &[AxisPoint], q: Vec3) -> Differences {
        let h = 1e-4;
        let sample = evaluate(m, points, q);
        assert!((0.0..=1.0).contains(&sample.value) && sample.gradient.is_finite());
        if sample.value < 1e-3 || near_a_kink(m, points, q, h) {
            return Differences::default();
        }
        // In f64 the differences of two f32 values are still off by an ulp of 1 over 2 h: .3 per metre.
        let slope = |axis: Vec3| {
            (evaluate(m, points, q + axis * h).value - evaluate(m, points, q - axis * h).value) / (2.0 * h)
        };
        let measured = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z));
        let off = |gradient: Vec3| (measured - gradient).length() / (30.0 + measured.length());
        Differences { worst: off(sample.gradient), longer: off(sample.gradient * 1.05), compared: 1 }
    }
}

/// Points are drawn from each case in turn until 10^5 in all are away from the kinks: those alone are compared.
#[test]
fn gradient_is_that_of_the_value_straight_and_bent() {
    const COMPARED: usize = 100_000;
    const ROUND: usize = 40_000;
    let cases = [
        muscle(0.0, (3, 3)),
        muscle(0.8, (4, 7)),
        arc_muscle(2.0, 12, (3, 4), 0.0),
        arc_muscle(1.2, 8, (3, 3), 0.7),
        arc_muscle(2.6, 29, (4, 5), 0.5),
    ];
    let mut found = [Differences::default(); 5];
    let mut drawn = 1;
    while found.iter().map(|case| case.compared).sum::<usize>() < COMPARED {
        assert!(drawn < 50 * ROUND, "few points are away from the kinks: {found:?}");
        for ((m, points), case) in cases.iter().zip(&mut found) {
            *case = case.and(Differences::over(m, points, drawn..drawn + ROUND));
        }
        drawn += ROUND;
    }
    for (i, case) in found.iter().enumerate() {
        assert!(case.compared > 1000, "case {i}: {case:?}");
        assert!(case.worst < 0.02, "case {i}: {case:?}");
        assert!(case.longer > 0.02, "case {i}: a gradient 5 % too long must be seen: {case:?}");
    }
}

#[test]
fn surface_value_is_a_half_and_the_axis_is_one() {
    let (m, points) = muscle(0.6, (3, 4));
    for i in 1..20 {
        let s = i as f32 / 20.0;
        let on_axis = points[0].position.xyz() + points[0].tangent.xyz() * (s * m.length);
        assert!(evaluate(&m, &points, on_axis).value > 0.999);
        let long = m.radius(s, 1.0);
        let value = evaluate(&m, &points, on_axis + points[0].normal.xyz() * long).value;
        assert!((value - 0.5).abs() < 1e-3, "s = {s}: {value}");
        let off = evaluate(&m, &points, on_axis + points[0].normal.xyz() * (long + 1e-3)).value;
        assert!((off - 0.5).abs() > 1e-2, "off the surface");
    }
}

/// The projection to the nearest segment alone, which algorithm 1 mends.
fn plain_arc(points: &[AxisPoint], q: Vec3) -> f32 {
    let k = nearest(points, q).0;
    points[k].arc() + Foot::new(&points[k], q).at
}

/// Largest jump of the arc length between neighbours on circles within `reach` of a bend of two unit segments.
fn largest_jump(reach: f32, arc: impl Fn(&[AxisPoint], Vec3) -> f32) -> f32 {
    let mut worst = 0.0f32;
    for degrees in [20, 45, 70, 90, 110] {
        let turn = Vec3::new((degrees as f32).to_radians().cos(), (degrees as f32).to_radians().sin(), 0.0);
        let corners = [Vec3::NEG_X * 2.0, Vec3::NEG_X, Vec3::ZERO, turn, turn * 2.0];
        let (_, points) = along(&corners, (3, 3), 0.0, Vec3::Z);
        let steps = 4000;
        for ring in 1..=5 {
            let at = |i: u32| {
                let a = i as f32 / steps as f32 * std::f32::consts::TAU;
                Vec3::new(a.cos(), a.sin(), 0.2) * (reach * ring as f32 / 5.0)
            };
            for i in 0..steps {
                worst = worst.max((arc(&points, at(i)) - arc(&points, at(i + 1))).abs());
            }
        }
    }
    worst
}

#[test]
fn round_a_single_bend_the_projection_has_no_jump() {
    let ours = largest_jump(0.9, |points, q| project(points, q).arc);
    // Steps on the circles are up to 1.4 mm of a metre; the map stretches them where it turns fast.
    assert!(ours < 0.02, "{ours}");
    let plain = largest_jump(0.9, plain_arc);
    assert!(plain > 0.2, "the plain projection jumps: {plain}");
}

#[test]
fn on_the_bisector_of_a_bend_the_projection_is_the_shared_point() {
    let turn = Vec3::new(0.3, 1.0, 0.0).normalize();
    let (_, points) = along(&[Vec3::NEG_X, Vec3::ZERO, turn, turn * 2.0], (3, 3), 0.0, Vec3::Z);
    for reach in [0.1, 0.3, 0.6] {
        let q = (turn - Vec3::X).normalize() * reach;
        assert!((project(&points, q).arc - 1.0).abs() < 1e-6, "{}", project(&points, q).arc);
        assert!((project(&points, q + Vec3::X * 0.05).arc - 1.0).abs() > 1e-3, "off the bisector");
    }
}

prop_compose! {
    /// A polyline that does not fold back, with normals and a blended shape.
    fn any_muscle()(
        turns in prop::collection::vec((-0.15f32..0.15, -0.15f32..0.15), 3..40),
        step in 0.002f32..0.02,
        normals in (prop::array::uniform3(-1.0f32..1.0), prop::array::uniform3(-1.0f32..1.0)),
        exponents in ((1u32..=9, 1u32..=9), (1u32..=9, 1u32..=9)),
        activation in 0.0f32..=1.0,
        eccentricity in 0.0f32..=0.95,
        point in prop::array::uniform3(-0.3f32..0.3),
    ) -> (Vec<Vec3>, (Vec3, Vec3), Profile, f32, Vec3) {
        let mut direction = Vec3::X;
        let mut positions = vec![Vec3::ZERO];
        for (y, z) in turns {
            direction = (direction + Vec3::new(0.0, y, z)).normalize();
            positions.push(positions[positions.len() - 1] + direction * step);
        }
        let shapes = [(exponents.0, 1.0 - activation), (exponents.1, activation)];
        let at = positions[positions.len() / 2] + Vec3::from(point) * 0.1;
        (positions, (normals.0.into(), normals.1.into()), Profile::blend(&shapes), eccentricity, at)
    }
}

/// A muscle of 1e-4 cubic metres along positions.
fn made(
    positions: &[Vec3],
    normals: (Vec3, Vec3),
    profile: &Profile,
    eccentricity: f32,
) -> (MuscleFrame, Vec<AxisPoint>) {
    let mut points: Vec<AxisPoint> =
        positions.iter().map(|p| AxisPoint { position: p.extend(0.0), ..AxisPoint::default() }).collect();
    let rest = crate::field::muscle::MuscleRest {
        origin: Vec3::ZERO.extend(1e-4),
        insertion: Vec3::ZERO.extend(0.02),
        segments: points.len() as u32 - 1,
        ..Default::default()
    };
    let input = MuscleInput::new(profile, eccentricity);
    let frame = crate::field::muscle::shape(&rest, &input, &mut points, normals.0, normals.1);
    (frame, points)
}

/// Volume under the radius that a muscle has along its axis and round it, by quadrature in f64 (equation 3).
fn swept_volume(m: &MuscleFrame) -> f64 {
    const ALONG: u32 = 256;
    const ROUND: u32 = 48;
    let middle = |i: u32, n: u32| (i as f32 + 0.5) / n as f32;
    let section = |s: f32| -> f64 {
        let square = |k| f64::from(m.radius(s, (middle(k, ROUND) * std::f32::consts::TAU).cos())).powi(2);
        (0..ROUND).map(square).sum::<f64>() * std::f64::consts::PI / f64::from(ROUND)
    };
    (0..ALONG).map(|i| section(middle(i, ALONG))).sum::<f64>() * f64::from(m.length) / f64::from(ALONG)
}

/// Terms of a profile with alpha and beta exchanged.
fn reversed(profile: &Profile) -> Profile {
    let swap = |byte: u32| (byte & 15) << 4 | (byte >> 4) & 15;
    let exponents = (0..4).map(|k| swap(profile.exponents >> (8 * k) & 255) << (8 * k)).sum();
    Profile { exponents, ..*profile }
}

proptest! {
    #[test]
    fn any_muscle_is_finite_and_keeps_its_volume((positions, normals, profile, e, q) in any_muscle()) {
        let (m, points) = made(&positions, normals, &profile, e);
        let sample = evaluate(&m, &points, q);
        prop_assert!((0.0..=1.0).contains(&sample.value) && sample.gradient.is_finite(), "{sample:?}");
        if let Some((d, gradient, radius, radius_gradient)) = raw(&m, &points, q, nearest(&points, q).0) {
            prop_assert!(d >= 0.0 && radius >= 0.0 && gradient.is_finite() && radius_gradient.is_finite());
        }
        // Midpoints are off by a twenty-fourth of the squared step times the slopes at the ends: of a blunt end's, up to
        // 272 of (1, 9), under 2e-4 of the whole.
        let volume = swept_volume(&m);
        prop_assert!((volume / 1e-4 - 1.0).abs() < 5e-4, "{volume}");
        let wider = swept_volume(&MuscleFrame { width: m.width * 1.001, ..m });
        prop_assert!((wider / 1e-4 - 1.0).abs() > 5e-4, "a muscle .1 % wider must be seen: {wider}");
        prop_assert!(m.reaches(q) || sample.value == 0.0, "a field outside its box");
    }

    #[test]
    fn a_wild_polyline_is_finite_too(
        corners in prop::collection::vec(prop::array::uniform3(-3i32..=3), 4..24),
        normal in prop::array::uniform3(-1i32..=1),
        e in 0.0f32..=0.99,
        q in prop::array::uniform3(-4i32..=4),
    ) {
        // On a coarse lattice corners coincide, segments fold back on themselves, and points lie on the axis.
        let at = |p: [i32; 3]| Vec3::from(p.map(|x| x as f32)) * 0.02;
        let positions: Vec<Vec3> = corners.into_iter().map(at).collect();
        let (m, points) = made(&positions, (at(normal), -at(normal)), &Profile::of(1, 3), e);
        for offset in [Vec3::ZERO, Vec3::splat(1e-7), Vec3::new(0.003, -0.001, 0.002)] {
            let sample = evaluate(&m, &points, at(q) + offset);
            prop_assert!((0.0..=1.0).contains(&sample.value) && sample.gradient.is_finite(), "{sample:?}");
        }
    }

    #[test]
    fn reversal_exchanges_alpha_and_beta((positions, normals, profile, e, q) in any_muscle()) {
        let (m, points) = made(&positions, normals, &profile, e);
        let back: Vec<Vec3> = positions.iter().rev().copied().collect();
        let (n, reverse) = made(&back, (normals.1, normals.0), &reversed(&profile), e);
        let (a, b) = (evaluate(&m, &points, q).value, evaluate(&n, &reverse, q).value);
        // Lengths add up in the other order; a slope of 50 per metre makes 1e-4 of it.
        prop_assert!((a - b).abs() < 2e-3, "{a} {b}");
    }

    #[test]
    fn a_mirrored_muscle_has_the_mirrored_field((positions, normals, profile, e, q) in any_muscle()) {
        let mirror = |v: Vec3| Vec3::new(v.x, -v.y, v.z);
        let (m, points) = made(&positions, normals, &profile, e);
        let other: Vec<Vec3> = positions.iter().copied().map(mirror).collect();
        let (n, others) = made(&other, (mirror(normals.0), mirror(normals.1)), &profile, e);
        let (a, b) = (evaluate(&m, &points, q), evaluate(&n, &others, mirror(q)));
        prop_assert!((a.value - b.value).abs() < 2e-3, "{} {}", a.value, b.value);
        let off = |gradient: Vec3| (gradient - b.gradient).length() / (30.0 + b.gradient.length());
        prop_assert!(off(mirror(a.gradient)) < 1e-3, "{} {}", a.gradient, b.gradient);
        let across = 2.0 * a.gradient.y.abs() / (30.0 + a.gradient.length());
        prop_assert!(across < 0.01 || off(a.gradient) > 5e-3, "the gradient as it was must be seen: {}", a.gradient);
    }
}

#[test]
fn a_reversed_muscle_with_unchanged_exponents_is_another_one() {
    let line: Vec<Vec3> = (0..=29).map(|i| Vec3::X * (0.01 * i as f32)).collect();
    let back: Vec<Vec3> = line.iter().rev().copied().collect();
    let (a, b) = (along(&line, (4, 7), 0.0, Vec3::Y), along(&back, (4, 7), 0.0, Vec3::Y));
    let q = Vec3::new(0.08, 0.02, 0.0);
    assert!((evaluate(&a.0, &a.1, q).value - evaluate(&b.0, &b.1, q).value).abs() > 0.05);
}
