//! Muscles that lie round a joint: a sphere about the origin of its own frame (background 6.4; paper B, "Bending Around a
//! Joint").

use super::{CLEARANCE, WrapPath, circle};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// How far on its own side of the centre a muscle has to pass for its path to lie in the plane through the centre: least sine
/// of the angle between its ends, about the side's axis. Nearer to the line through the centre that plane turns without bound.
pub(crate) const HOLD: f32 = 0.2;
/// Ends nearer to the centre than this, metres, have no direction.
pub(crate) const SHORT: f32 = 1e-6;
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
        let [x, y, _] = axes(origin, insertion, axis);
        let flat = |point: Vec3| Vec2::new(point.dot(x), point.dot(y));
        let swept = circle::swept(flat(origin), flat(insertion), 0.0);
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

/// Unit vectors at right angles, the last one the axis about which a path turns: the normal of the plane through both ends and
/// the centre, or beyond [`HOLD`] an axis nearer to the kept one.
///
/// A cylinder about any axis through the centre has the sphere within it, so a path round it is outside; about the normal it is
/// the sphere's own shortest path.
#[inline]
fn axes(origin: Vec3, insertion: Vec3, kept: Vec3) -> [Vec3; 3] {
    let size = origin.length() * insertion.length();
    let normal = if size > SHORT * SHORT { origin.cross(insertion) * (1.0 / size) } else { Vec3::ZERO };
    let turn = normal + kept * (2.0 * (HOLD - normal.dot(kept)).max(0.0));
    let axis = turn * (1.0 / turn.length());
    let side = origin - axis * origin.dot(axis);
    let length = side.length();
    let side = if length > SHORT { side * (1.0 / length) } else { axis.any_orthonormal_vector() };
    [side, axis.cross(side), axis]
}

/// The path from `origin` to `insertion` round a sphere of `radius` (of the joint and half the muscle's thickness), both in
/// its frame, metres.
///
/// It is the shortest one as long as it turns about the side's axis by less than half a turn, or the joint turns about that
/// axis alone; past the line through the centre it is held on its side like a muscle on a hinge's cylinder, which has no
/// room for an end nearer to that axis than the radius: the cylinder gets thinner. Ends inside the sphere are moved out.
pub fn path(origin: Vec3, insertion: Vec3, radius: f32, side: &Side) -> WrapPath {
    let (origin, insertion) = (pushed_out(origin, radius), pushed_out(insertion, radius));
    let axes = axes(origin, insertion, side.axis);
    let (from, to) = (
        Vec2::new(origin.dot(axes[0]), origin.dot(axes[1])),
        Vec2::new(insertion.dot(axes[0]), insertion.dot(axes[1])),
    );
    match circle::around(from, to, radius, side.swept) {
        Some(contact) => WrapPath::wound(origin, insertion, &contact, Vec3::ZERO, axes),
        None => WrapPath::straight(origin, insertion),
    }
}
