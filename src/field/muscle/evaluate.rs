//! A muscle's field at a point: projection on the axis, raw field, compact field.

use super::{
    AxisPoint, MuscleFrame,
    axis::{NO_DIRECTION, normal_at},
};
use crate::field::{Sample, transfer::transfer};
use glam::{Vec3, Vec4Swizzles};

/// A point's place on a muscle's axis (paper A, algorithm 1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Projection {
    /// From the axis to the point, metres.
    pub offset: Vec3,
    /// Arc length from the origin, metres.
    pub arc: f32,
    /// Gradient of the arc length by the point; zero at the ends and round the outer side of a bend, where the whole
    /// neighbourhood projects on one point.
    pub arc_gradient: Vec3,
    /// Unit tangent of the axis there.
    pub tangent: Vec3,
    /// Unit normal of the section there.
    pub normal: Vec3,
    /// Derivative of the normal by the arc length, per metre.
    pub normal_slope: Vec3,
}

/// A point's foot on one segment.
#[derive(Clone, Copy)]
struct Foot {
    /// Place on the segment's line, metres from its start.
    line: f32,
    /// Place on the segment itself.
    at: f32,
    /// From the foot to the point.
    offset: Vec3,
}

impl Foot {
    #[inline]
    fn new(point: &AxisPoint, q: Vec3) -> Foot {
        let h = q - point.position.xyz();
        let line = h.dot(point.tangent.xyz());
        let at = line.clamp(0.0, point.tangent.w);
        Foot { line, at, offset: h - point.tangent.xyz() * at }
    }

    /// Whether the foot is strictly inside the segment.
    #[inline]
    fn inside(&self, point: &AxisPoint) -> bool {
        self.line > 0.0 && self.line < point.tangent.w
    }
}

/// The segment nearest to a point, of equals the first, and the squared distance to it, rounded down by up to 1e-5 of it.
#[inline]
fn nearest(points: &[AxisPoint], q: Vec3) -> (usize, f32) {
    let mut best = f32::MAX;
    for (i, ends) in (0..).zip(points.windows(2)) {
        let [start, span, scale] = segment(&ends[0], &ends[1]);
        let h = q - start;
        let offset = h - span * (h.dot(span) * scale.x).clamp(0.0, 1.0);
        let key = keyed(offset.dot(offset), i);
        best = if key < best { key } else { best };
    }
    unkeyed(best)
}

/// Bits of a squared distance that hold the segment's number instead: 63 segments are the most.
pub(crate) const KEY_BITS: u32 = 63;

/// A squared distance with a segment's number in its lowest bits, so that the least of them names its segment. It orders
/// distances that differ by more than 1e-5 of themselves, which moves a foot by less than a distance can be told.
#[inline(always)]
pub(super) fn keyed(squared: f32, segment: u32) -> f32 {
    f32::from_bits(squared.to_bits() & !KEY_BITS | segment)
}

/// The segment and the squared distance of a key.
#[inline(always)]
pub(super) fn unkeyed(key: f32) -> (usize, f32) {
    ((key.to_bits() & KEY_BITS) as usize, f32::from_bits(key.to_bits() & !KEY_BITS))
}

/// What the search for the nearest segment reads of it: its start, its span, and one over its squared length.
#[inline(always)]
pub(super) fn segment(start: &AxisPoint, end: &AxisPoint) -> [Vec3; 3] {
    [start.position.xyz(), end.position.xyz() - start.position.xyz(), Vec3::splat(end.position.w)]
}

/// Projects a point on an axis. In the inner angle between two segments, where the point has a foot inside both, the
/// feet are weighted by the cotangents of the angles at the shared point, so that the projection has no jump there
/// (paper A, algorithm 1; background 7.6 has the form without divisions by zero).
///
/// `points` are one muscle's own, at least two.
pub fn project(points: &[AxisPoint], q: Vec3) -> Projection {
    project_near(points, q, nearest(points, q).0)
}

/// [`project`] where the nearest segment is known.
#[inline]
fn project_near(points: &[AxisPoint], q: Vec3, k: usize) -> Projection {
    let (mut k, mut foot) = (k, Foot::new(&points[k], q));
    if !foot.inside(&points[k]) {
        // Where the neighbour behind that end has a foot inside, it is the nearer one by less than keys tell.
        let behind = if foot.line > 0.0 { k + 1 } else { k.wrapping_sub(1) };
        let nearer = (behind < points.len() - 1).then(|| Foot::new(&points[behind], q));
        match nearer.filter(|nearer| nearer.inside(&points[behind])) {
            Some(nearer) => (k, foot) = (behind, nearer),
            None => return on_segment(&points[k], &foot, Vec3::ZERO),
        }
    }
    let mut shared = usize::MAX;
    let mut reach = f32::INFINITY;
    let mut other = foot;
    for (neighbour, joint) in [(k.wrapping_sub(1), k), (k + 1, k + 1)] {
        if neighbour >= points.len() - 1 {
            continue;
        }
        let candidate = Foot::new(&points[neighbour], q);
        let away = q - points[joint].position.xyz();
        let squared = away.dot(away);
        if candidate.inside(&points[neighbour]) && squared < reach {
            (reach, shared, other) = (squared, joint, candidate);
        }
    }
    if shared == usize::MAX {
        return on_segment(&points[k], &foot, points[k].tangent.xyz());
    }
    if shared == k { in_wedge(points, shared, &other, &foot, q) } else { in_wedge(points, shared, &foot, &other, q) }
}

#[inline]
fn on_segment(point: &AxisPoint, foot: &Foot, arc_gradient: Vec3) -> Projection {
    let inverse = 1.0 / point.tangent.w.max(NO_DIRECTION);
    let (normal, by_share) = normal_at(point, foot.at * inverse);
    Projection {
        offset: foot.offset,
        arc: point.arc() + foot.at,
        arc_gradient,
        tangent: point.tangent.xyz(),
        normal,
        normal_slope: by_share * inverse,
    }
}

/// Between the segments on either side of point `shared`, with feet on both.
#[inline]
fn in_wedge(points: &[AxisPoint], shared: usize, before: &Foot, after: &Foot, q: Vec3) -> Projection {
    let (first, second) = (&points[shared - 1], &points[shared]);
    let (t0, t1) = (first.tangent.xyz(), second.tangent.xyz());
    // Distances of the feet from the shared point, and of the point from its feet: cot = a / o.
    let (a0, a1) = (first.tangent.w - before.at, after.at);
    let (o0, o1) = (before.offset.length(), after.offset.length());
    let sum = a0 * o1 + a1 * o0;
    if sum <= 0.0 {
        return on_segment(second, &Foot { line: 0.0, at: 0.0, offset: q - second.position.xyz() }, Vec3::ZERO);
    }
    // Place along the axis from the shared point: the weighted mean of -a0 and a1.
    let x = (a1 * a1 * o0 - a0 * a0 * o1) / sum;
    let (e0, e1) = (before.offset / o0.max(1e-20), after.offset / o1.max(1e-20));
    let top = t1 * (2.0 * a1 * o0) + e0 * (a1 * a1) + t0 * (2.0 * a0 * o1) - e1 * (a0 * a0);
    let bottom = e1 * a0 - t0 * o1 + t1 * o0 + e0 * a1;
    let arc_gradient = (top - bottom * x) / sum;
    let (point, at) = if x < 0.0 { (first, first.tangent.w + x) } else { (second, x) };
    let offset = q - point.position.xyz() - point.tangent.xyz() * at;
    on_segment(point, &Foot { line: at, at, offset }, arc_gradient)
}

/// The muscle's raw field `f_M = d - R` at a point (equation 1): distance to the axis, its gradient, local radius and
/// its gradient, metres; `None` on the axis itself.
#[inline]
fn raw(muscle: &MuscleFrame, points: &[AxisPoint], q: Vec3, k: usize) -> Option<(f32, Vec3, f32, Vec3)> {
    let on = project_near(points, q, k);
    let d = on.offset.length();
    if d < 1e-9 {
        return None;
    }
    let outward = on.offset / d;
    // The foot moves along the axis with the point: e - (e.t) grad(arc).
    let distance_gradient = outward - on.arc_gradient * outward.dot(on.tangent);
    let s = (on.arc * muscle.inverse_length).clamp(0.0, 1.0);
    let (phi, phi_slope) = muscle.profile().at(s);
    let cosine = outward.dot(on.normal);
    let polar = muscle.polar(cosine * cosine);
    let radius = muscle.width * phi * polar;
    let polar_slope = cosine * (muscle.long_squared - muscle.short_squared) * polar * polar * polar;
    let cosine_gradient = (on.normal - on.arc_gradient * on.tangent.dot(on.normal) - distance_gradient * cosine) / d
        + on.arc_gradient * outward.dot(on.normal_slope);
    let radius_gradient = on.arc_gradient * (muscle.width * phi_slope * muscle.inverse_length * polar)
        + cosine_gradient * (muscle.width * phi * polar_slope);
    Some((d, distance_gradient, radius, radius_gradient))
}

/// The raw field `f_M` at a point, metres, and its gradient; `None` on the axis.
pub(super) fn raw_distance(muscle: &MuscleFrame, points: &[AxisPoint], q: Vec3) -> Option<(f32, Vec3)> {
    let (d, distance_gradient, radius, radius_gradient) = raw(muscle, points, q, nearest(points, q).0)?;
    Some((d - radius, distance_gradient - radius_gradient))
}

/// The muscle's compact field at `q`, in the muscle's own space: 1 with zero slope on the axis, 1/2 on the surface, 0
/// from `support_radius` outside it (background 3.2). `points` are the muscle's own.
///
/// The value is continuous where the distance to the axis is under half its radius of curvature. Beyond, the inner angles of
/// neighbouring bends of one sense overlap, and the foot jumps from one to the next: not at all at half the radius, by one
/// segment at the whole radius. The gradient has kinks on
/// the axis, on the surface (the slope is the same on both sides, not its derivative), on the planes through the axis'
/// points that bound the segments and the inner angles of bends, on the planes that halve those angles, where the foot
/// goes round the corner (its size is the sine of half the bend), and at both ends.
#[inline]
pub fn evaluate(muscle: &MuscleFrame, points: &[AxisPoint], q: Vec3) -> Sample {
    if muscle.present == 0 {
        return Sample::default();
    }
    let (k, squared) = nearest(points, q);
    if squared > muscle.reach_squared() { Sample::default() } else { evaluate_near(muscle, points, q, k) }
}

/// [`evaluate`] of a muscle that is present, where the nearest segment is known.
#[inline]
pub(super) fn evaluate_near(muscle: &MuscleFrame, points: &[AxisPoint], q: Vec3, k: usize) -> Sample {
    let Some((d, distance_gradient, radius, radius_gradient)) = raw(muscle, points, q, k) else {
        return Sample { value: 1.0, gradient: Vec3::ZERO };
    };
    let x = d - radius;
    if x >= 0.0 {
        let (value, slope) = transfer(x, muscle.support_radius);
        return Sample { value, gradient: (distance_gradient - radius_gradient) * slope };
    }
    // x < 0 means radius > d > 0: the divisions are safe.
    let u = -x / radius;
    let u2 = u * u;
    let steepness = 0.9375 / muscle.support_radius;
    let start = steepness * radius;
    let hump = u - 2.0 * u2 + u2 * u;
    let value = (0.5 + start * hump + 0.5 * (3.0 * u2 - 2.0 * u2 * u)).min(1.0);
    let by_u = start * (1.0 - 4.0 * u + 3.0 * u2) + 3.0 * (u - u2);
    let u_gradient = (radius_gradient * (d / radius) - distance_gradient) / radius;
    Sample { value, gradient: u_gradient * by_u + radius_gradient * (steepness * hump) }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{along, arc_muscle, muscle};
    use super::*;
    use crate::field::muscle::{MuscleInput, Profile};
    use proptest::prelude::*;

    /// Halton's points: evenly spread, and the same every time.
    fn spread(n: usize) -> impl Iterator<Item = Vec3> {
        let radical = |mut i: usize, base: usize| {
            let (mut f, mut r) = (1.0, 0.0);
            while i > 0 {
                f /= base as f64;
                r += f * (i % base) as f64;
                i /= base;
            }
            r as f32
        };
        (1..=n).map(move |i| Vec3::new(radical(i, 2), radical(i, 3), radical(i, 5)))
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
        close(d, radius)
            || d < 1e-3
            || close(d - radius, m.support_radius)
            || corners
            || planes
            || shared
            || radius < 6e-3
    }

    /// Largest difference between `gradient` and central differences over 10^5 points, over the gradient's own length and
    /// 30 per metre, away from the kinks.
    fn worst_gradient(m: &MuscleFrame, points: &[AxisPoint], gradient: impl Fn(Vec3) -> Vec3) -> (f32, usize) {
        let (low, high) = (m.lowest.xyz(), m.highest.xyz());
        let (mut worst, mut seen) = (0.0f32, 0);
        let h = 1e-4;
        for q in spread(100_000).map(|u| low + (high - low) * u) {
            let sample = evaluate(m, points, q);
            assert!((0.0..=1.0).contains(&sample.value) && sample.gradient.is_finite());
            if sample.value < 1e-3 || near_a_kink(m, points, q, h) {
                continue;
            }
            // In f64 the differences of two f32 values are still off by an ulp of 1 over 2 h: .3 per metre.
            let slope = |axis: Vec3| {
                (evaluate(m, points, q + axis * h).value - evaluate(m, points, q - axis * h).value) / (2.0 * h)
            };
            let measured = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z));
            worst = worst.max((measured - gradient(q)).length() / (30.0 + measured.length()));
            seen += 1;
        }
        (worst, seen)
    }

    #[test]
    fn gradient_is_that_of_the_value_straight_and_bent() {
        let cases = [
            muscle(0.0, (3, 3)),
            muscle(0.8, (4, 7)),
            arc_muscle(2.0, 12, (3, 4), 0.0),
            arc_muscle(1.2, 8, (3, 3), 0.7),
            arc_muscle(2.6, 29, (4, 5), 0.5),
        ];
        for (i, (m, points)) in cases.iter().enumerate() {
            let (worst, seen) = worst_gradient(m, points, |q| evaluate(m, points, q).gradient);
            assert!(seen > 1000, "case {i}: {seen} points");
            assert!(worst < 0.02, "case {i}: {worst} of {seen}");
            let (worst, _) = worst_gradient(m, points, |q| evaluate(m, points, q).gradient * 1.05);
            assert!(worst > 0.02, "case {i}: a gradient 5 % too long must be seen: {worst}");
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
    fn the_projection_has_no_jump_while_the_point_is_within_the_curvature_radius() {
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
            exponents in ((2u32..=9, 2u32..=9), (2u32..=9, 2u32..=9)),
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
        let frame = super::super::shape(&rest, &input, &mut points, normals.0, normals.1);
        (frame, points)
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
            let volume = std::f32::consts::PI * m.width * m.width * m.length;
            prop_assert!((volume / 1e-4 - 1.0).abs() < 1e-4, "{volume}");
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
}
