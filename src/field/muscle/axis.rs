//! A muscle's central polyline with a section normal at every point (paper A, section 5.1; background 7.7).

use crate::math::{arc_sine, sine_cosine, smoothstep};
use glam::{Vec3, Vec4, Vec4Swizzles};

crate::gpu_struct! {
    /// One point of an axis, with the segment to the next one. The last point's segment is empty.
    pub struct AxisPoint {
        /// Position, and in `w` one over the squared length of the segment that ends here; 0 for an empty one.
        pub position: Vec4,
        /// Unit tangent of the segment, and in `w` its length, metres.
        pub tangent: Vec4,
        /// Unit normal of the section, its long axis, and in `w` the angle to the next point's normal, 0..=pi/2.
        pub normal: Vec4,
        /// Unit vector across the normal towards the next one, and in `w` the arc length from the origin, metres.
        pub turn: Vec4,
    }
}

impl AxisPoint {
    /// Arc length from the origin, metres.
    #[inline]
    pub fn arc(&self) -> f32 {
        self.turn.w
    }
}

/// Fewest segments of an axis.
pub const MIN_SEGMENTS: u32 = 3;
/// Most segments of an axis.
pub const MAX_SEGMENTS: u32 = 63;

/// Sine of the turn between segments from which their plane alone gives the normal (background 7.7).
pub(crate) const CLEAR_TURN: f32 = 0.05;
/// Share of the interpolated normal that must lie in the segments' plane to be turned into it in full: a normal square
/// to the plane has no nearest direction in it, and would flip with the last bit.
pub(crate) const CLEAR_SHARE: f32 = 0.25;
/// Lengths, in metres or of unit vectors, under which there is no direction.
pub(crate) const NO_DIRECTION: f32 = 1e-6;

/// Entries of one half of one instance's iterates: what muscles in motion see of one another, and what their axes are
/// shaped from.
///
/// Per muscle two for its box, then two for each point: posed position with the mean radius in `w`, and the section's unit
/// normal with the square of the ellipse's short semi-axis in `w` (0: round). The box is lowest and highest corner of the
/// points grown by their radii; `w` are the compliance over the substep squared and the square of
/// the spectral radius of Jacobi's sweeps. The last point begins no segment, so that nothing looks at its section's
/// shape: there the profile's shift stands in `w`.
pub fn half(muscle_count: u32, point_count: u32) -> usize {
    2 * (muscle_count as usize + point_count as usize)
}

/// Where a muscle's box stands in a half of the iterates, its points behind it.
pub fn run(muscle: usize, first_point: u32) -> usize {
    2 * (muscle + first_point as usize)
}

/// Fills in everything but the positions of an axis, and returns its length in metres.
///
/// The end normals, of any length and direction, are interpolated spherically by arc length and turned towards the
/// local plane of the polyline in so far as it bends. The profile is symmetric in the normal's sign, so neighbours
/// are given the same one. The inner ones are then smoothed by `smoothing` binomial passes: where an axis is bowed to and
/// fro its plane turns over within a segment, and the section would with it.
pub fn frame(points: &mut [AxisPoint], origin_normal: Vec3, insertion_normal: Vec3, smoothing: u32) -> f32 {
    let last = points.len() - 1;
    let mut length = 0.0;
    let mut tangent = Vec3::X;
    points[0].position.w = 0.0;
    for i in 0..=last {
        points[i].turn.w = length;
        let span = if i < last { points[i + 1].position.xyz() - points[i].position.xyz() } else { Vec3::ZERO };
        let l = span.length();
        let empty = l <= NO_DIRECTION;
        if !empty {
            tangent = span / l;
            length += l;
        }
        points[i].tangent = tangent.extend(if empty { 0.0 } else { l });
        if i < last {
            points[i + 1].position.w = if empty { 0.0 } else { 1.0 / (l * l) };
        }
    }
    let ends = Ends::new(origin_normal, insertion_normal, points[0].tangent.xyz(), points[last].tangent.xyz());
    let inverse_length = if length > NO_DIRECTION { 1.0 / length } else { 0.0 };
    let mut previous = Vec3::ZERO;
    for i in 0..=last {
        let after = points[i].tangent.xyz();
        let before = if i > 0 { points[i - 1].tangent.xyz() } else { after };
        let wanted = ends.at(points[i].arc() * inverse_length);
        let normal = across(in_plane(wanted, before, after), before + after);
        previous = if normal.dot(previous) < 0.0 { -normal } else { normal };
        points[i].normal = previous.extend(0.0);
    }
    for _ in 0..smoothing {
        let mut before = points[0].normal.xyz();
        for i in 1..last {
            let own = points[i].normal.xyz();
            let wanted = (before + points[i + 1].normal.xyz()) * 0.25 + own * 0.5;
            points[i].normal = across(wanted, points[i - 1].tangent.xyz() + points[i].tangent.xyz()).extend(0.0);
            before = own;
        }
    }
    for i in 0..last {
        let (from, to) = (points[i].normal.xyz(), points[i + 1].normal.xyz());
        let (turn, angle) = between(from, to);
        points[i].normal.w = angle;
        points[i].turn = turn.extend(points[i].turn.w);
    }
    points[last].turn = Vec4::new(0.0, 0.0, 0.0, length);
    length
}

/// The unit tangent at `arc` metres along an axis, turned evenly from each point's to the next one's: midway at a point between
/// those of the segments beside it.
pub fn smooth_tangent(points: &[AxisPoint], arc: f32) -> Vec3 {
    let mut i = 0;
    while i + 2 < points.len() && points[i + 1].arc() <= arc {
        i += 1;
    }
    let at = |i: usize| {
        let after = points[i].tangent.xyz();
        unit_or(if i > 0 { after + points[i - 1].tangent.xyz() } else { after }, after)
    };
    let share = ((arc - points[i].arc()) / points[i].tangent.w.max(NO_DIRECTION)).clamp(0.0, 1.0);
    unit_or(at(i) * (1.0 - share) + at(i + 1) * share, points[i].tangent.xyz())
}

/// A vector's direction, or `other` where it has none.
fn unit_or(v: Vec3, other: Vec3) -> Vec3 {
    let length = v.dot(v).sqrt();
    if length > NO_DIRECTION { v / length } else { other }
}

/// The normal of a segment at share `f` of it, and its derivative by `f`.
#[inline]
pub(super) fn normal_at(point: &AxisPoint, f: f32) -> (Vec3, Vec3) {
    let (sine, cosine) = sine_cosine(point.normal.w * f);
    let (from, turn) = (point.normal.xyz(), point.turn.xyz());
    (from * cosine + turn * sine, (turn * cosine - from * sine) * point.normal.w)
}

/// Spherical interpolation of the end normals.
struct Ends {
    from: Vec3,
    turn: Vec3,
    angle: f32,
}

impl Ends {
    fn new(origin_normal: Vec3, insertion_normal: Vec3, first_tangent: Vec3, last_tangent: Vec3) -> Ends {
        let from = across(origin_normal, first_tangent);
        let to = across(insertion_normal, last_tangent);
        let (turn, angle) = between(from, to);
        // Opposite normals have no shortest way: they turn about the axis.
        let turn = if turn == Vec3::ZERO { across(first_tangent.cross(from), from) } else { turn };
        Ends { from, turn, angle }
    }

    fn at(&self, share: f32) -> Vec3 {
        let (sine, cosine) = sine_cosine(self.angle * share);
        self.from * cosine + self.turn * sine
    }
}

/// The unit vector across `from` towards `to`, zero where they are parallel or opposite, and the angle between them.
fn between(from: Vec3, to: Vec3) -> (Vec3, f32) {
    let flat = to - from * from.dot(to);
    let length = flat.length();
    let turn = if length > NO_DIRECTION { flat / length } else { Vec3::ZERO };
    let chord = (to - from).length() * 0.5;
    (turn, 2.0 * arc_sine(chord.min(1.0)))
}

/// `normal` turned into the plane of two segments, as far as they and it make that plane clear.
fn in_plane(normal: Vec3, before: Vec3, after: Vec3) -> Vec3 {
    let cross = before.cross(after);
    let sine = cross.length();
    if sine <= NO_DIRECTION {
        return normal;
    }
    let square = cross / sine;
    let height = square * normal.dot(square);
    let share = (normal - height).length();
    normal - height * (smoothstep(sine / CLEAR_TURN) * smoothstep(share / CLEAR_SHARE))
}

/// The unit vector across `axis`, of any length, nearest to `wanted`, or any unit vector across it where they are
/// parallel.
fn across(wanted: Vec3, axis: Vec3) -> Vec3 {
    let length = axis.length();
    let axis = if length > NO_DIRECTION { axis / length } else { Vec3::X };
    let flat = wanted - axis * wanted.dot(axis);
    let length = flat.length();
    if length > NO_DIRECTION {
        return flat / length;
    }
    let other = if axis.x.abs() < 0.7 { Vec3::X } else { Vec3::Y };
    let flat = other - axis * other.dot(axis);
    flat / flat.length()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn framed(positions: &[Vec3], from: Vec3, to: Vec3) -> (Vec<AxisPoint>, f32) {
        let mut points: Vec<AxisPoint> =
            positions.iter().map(|p| AxisPoint { position: p.extend(0.0), ..AxisPoint::default() }).collect();
        let length = frame(&mut points, from, to, 0);
        (points, length)
    }

    /// An arc of a circle in the plane z = 0, through `angle` radians, of radius 1.
    fn arc(angle: f32, segments: u32) -> Vec<Vec3> {
        let point = |i: u32| Vec3::from((glam::Vec2::from_angle(angle * i as f32 / segments as f32), 0.0));
        (0..=segments).map(point).collect()
    }

    #[test]
    fn a_straight_axis_interpolates_its_end_normals_evenly() {
        let line: Vec<Vec3> = (0..=10).map(|i| Vec3::Z * (i as f32 * 0.02)).collect();
        let (points, length) = framed(&line, Vec3::X * 3.0, Vec3::new(-0.5, 0.866_025_4, 0.7));
        assert!((length - 0.2).abs() < 1e-6);
        for (i, p) in points.iter().enumerate() {
            let angle = std::f32::consts::TAU / 3.0 * i as f32 / 10.0;
            let expected = Vec3::new(angle.cos(), angle.sin(), 0.0);
            assert!(p.normal.xyz().distance(expected) < 1e-5, "{i}: {} {expected}", p.normal);
            let off = Vec3::new((angle + 0.01).cos(), (angle + 0.01).sin(), 0.0);
            assert!(p.normal.xyz().distance(off) > 1e-3, "a turned normal must be seen");
        }
        let (halfway, _) = normal_at(&points[4], 0.5);
        let angle = std::f32::consts::TAU / 3.0 * 0.45;
        assert!(halfway.distance(Vec3::new(angle.cos(), angle.sin(), 0.0)) < 1e-5);
    }

    #[test]
    fn a_bent_axis_turns_its_normals_into_its_plane() {
        let (points, _) = framed(&arc(2.6, 29), Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 1.0));
        for p in &points[1..29] {
            assert!(p.normal.z.abs() < 1e-5, "{}", p.normal);
            assert!(p.normal.xyz().dot(p.position.xyz()).abs() > 0.99, "along the circle's radius: {}", p.normal);
        }
        let (gentle, _) = framed(&arc(0.3, 29), Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 1.0));
        assert!(gentle[15].normal.z.abs() > 0.3, "hardly bent: the given normals stay: {}", gentle[15].normal);
    }

    #[test]
    fn a_normal_square_to_the_plane_stays() {
        for tilt in [0.0, 1e-6, -1e-6, 1e-3] {
            let (points, _) = framed(&arc(2.0, 29), Vec3::new(tilt, 0.0, 1.0), Vec3::new(tilt, 0.0, 1.0));
            assert!(points.iter().all(|p| p.normal.z.abs() > 0.99), "{tilt}");
        }
    }

    #[test]
    fn normals_are_unit_square_to_the_axis_and_of_one_sense() {
        let wild: Vec<Vec3> =
            (0..=20).map(|i| i as f32 * 0.3).map(|a| Vec3::new(a.cos(), (2.1 * a).sin(), 0.2 * a)).collect();
        for (from, to) in [(Vec3::X, Vec3::Z), (Vec3::Y, Vec3::NEG_Y), (Vec3::ZERO, Vec3::ZERO)] {
            let (points, _) = framed(&wild, from, to);
            for pair in points.windows(2) {
                assert!((pair[0].normal.xyz().length() - 1.0).abs() < 1e-5);
                assert!(pair[0].normal.xyz().dot(pair[1].normal.xyz()) >= 0.0);
                let (end, _) = normal_at(&pair[0], 1.0);
                assert!(end.distance(pair[1].normal.xyz()) < 2e-6, "{end} {}", pair[1].normal);
            }
        }
    }

    #[test]
    fn points_that_coincide_have_no_length_and_a_direction_all_the_same() {
        let mut line: Vec<Vec3> = (0..=6).map(|i| Vec3::X * (i as f32 * 0.1)).collect();
        line[3] = line[2];
        let (points, length) = framed(&line, Vec3::Y, Vec3::Y);
        assert!((length - 0.6).abs() < 1e-6 && points[2].tangent.w == 0.0 && points[3].position.w == 0.0);
        assert!(points.iter().all(|p| p.normal.xyz().distance(Vec3::Y) < 1e-5));
        let (nothing, length) = framed(&[Vec3::ONE; 4], Vec3::Y, Vec3::Y);
        assert!(length == 0.0 && nothing.iter().all(|p| p.normal.is_finite() && p.tangent.is_finite()));
    }
}
