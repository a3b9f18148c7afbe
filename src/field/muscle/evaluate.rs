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

/// The segment nearest to a point, of equals the first, and the squared distance to it, as exact as a key holds it.
#[inline]
fn nearest(points: &[AxisPoint], q: Vec3) -> (usize, f32) {
    let mut best = FARTHEST;
    for (i, ends) in (0..).zip(points.windows(2)) {
        let key = Segment::new(&ends[0], &ends[1]).key(q.x, q.y, q.z, i);
        best = if key < best { key } else { best };
    }
    unkeyed(best)
}

/// Bits of a squared distance that hold the segment's number instead: 63 segments are the most.
pub const KEY_BITS: u32 = 63;

/// A key that every other one is nearer than, of the first segment.
pub(super) const FARTHEST: f32 = f32::from_bits(f32::MAX.to_bits() & !KEY_BITS);

/// What the search for the nearest segment needs of one.
#[derive(Clone, Copy)]
pub(super) struct Segment {
    start: Vec3,
    /// The span over its squared length: the scalar product with it is a share of the segment.
    slope: Vec3,
    squared_length: f32,
}

impl Segment {
    #[inline(always)]
    pub(super) fn new(start: &AxisPoint, end: &AxisPoint) -> Segment {
        let span = end.position.xyz() - start.position.xyz();
        Segment { start: start.position.xyz(), slope: span * end.position.w, squared_length: span.dot(span) }
    }

    /// The squared distance of a point with the segment's number in its lowest bits, so that the least key names its
    /// segment.
    ///
    /// With h from the start, t the place of the foot on the line and f on the segment, both as shares of it, the squared
    /// distance is h^2 + f (f - 2t) l^2. It orders distances that differ by more than 1e-5 of themselves, or near the axis
    /// by more than 1e-3 of the segment's length, which moves a foot by less than a distance can be told. Rounding may leave
    /// less than zero on the axis: the sign goes with the lowest bits.
    #[inline(always)]
    pub(super) fn key(&self, x: f32, y: f32, z: f32, number: u32) -> f32 {
        let (hx, hy, hz) = (x - self.start.x, y - self.start.y, z - self.start.z);
        let line = hx * self.slope.x + hy * self.slope.y + hz * self.slope.z;
        // Not `clamp`: which looks for NaN, at three instructions a bound.
        let foot = if line > 0.0 { line } else { 0.0 };
        let foot = if foot < 1.0 { foot } else { 1.0 };
        let squared = hx * hx + hy * hy + hz * hz + foot * (foot - (line + line)) * self.squared_length;
        f32::from_bits(squared.to_bits() & (i32::MAX as u32 & !KEY_BITS) | number)
    }
}

/// The segment and the squared distance of a key.
#[inline(always)]
pub(super) fn unkeyed(key: f32) -> (usize, f32) {
    ((key.to_bits() & KEY_BITS) as usize, f32::from_bits(key.to_bits() & !KEY_BITS))
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
mod tests;
