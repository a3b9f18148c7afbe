//! Muscles that lie round a joint: a sphere about the origin of its own frame (background 6.4; paper B, "Bending Around a
//! Joint").

use super::{CLEARANCE, WrapPath, circle};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// How far on its own side of the centre a straight line has to pass for its path to lie in the plane through the centre, in
/// radii. Nearer than that the plane is turned towards the kept side: the plane through the centre turns without bound as the
/// line passes it.
const HOLD: f32 = 0.25;
/// Shorter than this, metres, a path has no direction.
const SHORT: f32 = 1e-6;
/// Lines that pass the centre nearer than this, in radii, do not say on which side the muscle lies.
const THROUGH: f32 = 1e-3;

/// The side of a muscle round a sphere, chosen at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Unit vector about which the muscle turns counter-clockwise from its origin to its insertion, in the sphere's frame: the
    /// axis of the joint's bending, where the joint is a hinge.
    pub axis: Vec3,
    /// Angle that it sweeps about the centre at rest, radians; half a turn where it is more.
    pub swept: f32,
}

impl Side {
    /// The side of the shorter way round a sphere of `radius`, or that on which `locator` is, a point in the sphere's frame.
    ///
    /// `None` where nothing decides: the line between the ends passes through the centre, or the locator lies on it.
    pub fn at_rest(origin: Vec3, insertion: Vec3, radius: f32, locator: Option<Vec3>) -> Option<Side> {
        let (origin, insertion) = (pushed_out(origin, radius), pushed_out(insertion, radius));
        let along = (insertion - origin).try_normalize()?;
        let across = |v: Vec3| v - along * v.dot(along);
        let towards = across(locator.unwrap_or(origin));
        if towards.length() < THROUGH * radius {
            return None;
        }
        let axis = towards.cross(along).normalize();
        let plane = Plane::of(origin, along, axis, radius);
        let swept = circle::swept(plane.flat(origin), plane.flat(insertion), 0.0);
        Some(Side { axis, swept: if swept < 0.0 { PI } else { swept } })
    }
}

/// A point moved out of the sphere, away from its centre.
#[inline]
pub fn pushed_out(point: Vec3, radius: f32) -> Vec3 {
    let (out, away) = (radius * CLEARANCE, point.length());
    if away >= out {
        return point;
    }
    // At the centre every direction is as good as another.
    if away > 0.0 { point * (out / away) } else { Vec3::X * out }
}

/// The plane of a path, through both ends.
struct Plane {
    /// Unit vectors: from the centre to the kept side, along the straight line, and the plane's normal.
    axes: [Vec3; 3],
    /// Distance of the plane from the centre, along its normal.
    off: f32,
}

impl Plane {
    /// The plane of the straight line through `origin` along the unit vector `along`: that through the centre where the line
    /// passes it on the side that turns about `axis`.
    #[inline]
    fn of(origin: Vec3, along: Vec3, axis: Vec3, radius: f32) -> Plane {
        let foot = origin - along * origin.dot(along);
        let kept = along.cross(axis);
        let size = kept.length();
        let mut side = foot;
        if size > SHORT {
            let kept = kept * (1.0 / size);
            side += kept * (HOLD * radius - foot.dot(kept)).max(0.0);
        }
        let size = side.length();
        // A line along the axis through the centre: any plane will do.
        let side = if size > SHORT * radius { side * (1.0 / size) } else { along.any_orthonormal_vector() };
        let normal = side.cross(along);
        Plane { axes: [side, along, normal], off: foot.dot(normal) }
    }

    #[inline]
    fn flat(&self, point: Vec3) -> Vec2 {
        Vec2::new(point.dot(self.axes[0]), point.dot(self.axes[1]))
    }
}

/// The path from `origin` to `insertion` round a sphere of `radius` (of the joint and half the muscle's thickness), both in
/// its frame, metres.
///
/// It is the shortest one as long as the straight line passes the centre on the kept side by a quarter of the radius, or the
/// joint turns about the side's own axis; else it goes over the kept side in a plane beside the centre, and off sideways where
/// the line passes beside the sphere. Ends inside are moved out.
pub fn path(origin: Vec3, insertion: Vec3, radius: f32, side: &Side) -> WrapPath {
    let (origin, insertion) = (pushed_out(origin, radius), pushed_out(insertion, radius));
    let along = insertion - origin;
    let length = along.length();
    if length < SHORT {
        return WrapPath::straight(origin, insertion);
    }
    let plane = Plane::of(origin, along * (1.0 / length), side.axis, radius);
    let section = ((radius - plane.off) * (radius + plane.off)).max(0.0).sqrt();
    match circle::around(plane.flat(origin), plane.flat(insertion), section, side.swept) {
        Some(contact) => WrapPath::wound(origin, insertion, &contact, plane.axes[2] * plane.off, plane.axes),
        None => WrapPath::straight(origin, insertion),
    }
}
