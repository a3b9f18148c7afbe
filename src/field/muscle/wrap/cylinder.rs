//! Muscles that lie round a bone: a cylinder about z of its own frame (background 6.5; paper B, equations 1 and 2).

use super::circle::{self, Contact};
use super::{CLEARANCE, WrapPath};
use glam::{Vec2, Vec3, Vec3Swizzles};
use std::f32::consts::{PI, TAU};

/// Ends nearer than this to opposite sides of the axis, radians, do not say on which side the muscle lies.
const THROUGH: f32 = 1e-3;

/// A bone's cylinder about z, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Radius of the bone and half the muscle's thickness.
    pub radius: f32,
    /// Height of its lower end.
    pub low: f32,
    /// Height of its upper end.
    pub high: f32,
}

impl Cylinder {
    /// A cylinder that goes on beyond every muscle.
    pub fn endless(radius: f32) -> Cylinder {
        Cylinder { radius, low: f32::MIN, high: f32::MAX }
    }

    /// How far beyond the ends a height is; 0 between them.
    #[inline]
    fn beyond(&self, height: f32) -> f32 {
        (height - self.high).max(self.low - height).max(0.0)
    }

    /// A point moved straight away from the axis out of the cylinder and the half spheres on its ends.
    #[inline]
    pub fn pushed_out(&self, point: Vec3) -> Vec3 {
        let out = self.radius * CLEARANCE;
        let beyond = self.beyond(point.z).min(out);
        let least = ((out - beyond) * (out + beyond)).sqrt();
        let away = point.xy().length();
        if away >= least {
            return point;
        }
        // On the axis every direction is as good as another.
        let side = if away > 0.0 { point.xy() * (least / away) } else { Vec2::X * least };
        side.extend(point.z)
    }
}

/// The side of a muscle round a cylinder, chosen at rest: the angle that it sweeps about the axis from its origin to its
/// insertion, radians, positive counter-clockwise seen from +z, and half a turn where it is more: later ones may differ from
/// it by half a turn.
///
/// Without a locator it is the shorter way. With one it is the way whose middle is nearer to the locator's direction from the
/// axis. `None` where nothing decides: the ends are on opposite sides of the axis, or the locator is on it.
pub fn side_at_rest(origin: Vec3, insertion: Vec3, cylinder: &Cylinder, locator: Option<Vec3>) -> Option<f32> {
    let (origin, insertion) = (cylinder.pushed_out(origin).xy(), cylinder.pushed_out(insertion).xy());
    let short = circle::swept(origin, insertion, 0.0);
    let Some(locator) = locator else {
        return (short.abs() < PI - THROUGH).then_some(short);
    };
    let long = if short < 0.0 { short + TAU } else { short - TAU };
    let towards = |swept: f32| middle(origin, insertion, cylinder.radius, swept).dot(locator.xy());
    let (near, far) = (towards(short), towards(long));
    (near != far).then_some(if near > far { short } else { long.clamp(-PI, PI) })
}

/// Unit vector from the axis to the middle of the wound part of a way; of a straight one, to where it would be wound.
fn middle(origin: Vec2, insertion: Vec2, radius: f32, swept: f32) -> Vec2 {
    let lead = |end: Vec2| (radius / end.length()).min(1.0).acos();
    Vec2::from_angle(0.5 * (swept + swept.signum() * (lead(origin) - lead(insertion))))
        .rotate(origin.normalize_or_zero())
}

/// The shortest path from `origin` to `insertion` round a cylinder, both in its frame, metres.
///
/// `side` is [`side_at_rest`]'s. Ends inside are moved out. A path whose contact comes to lie beyond an end of the bone
/// slides off over it: the circle that it lies on sinks away from it, by what a ball on the bone's end falls back there, and
/// at last lets it go.
pub fn path(origin: Vec3, insertion: Vec3, cylinder: &Cylinder, side: f32) -> WrapPath {
    let (origin, insertion) = (cylinder.pushed_out(origin), cylinder.pushed_out(insertion));
    let (from, to) = (origin.xy(), insertion.xy());
    let Some(contact) = circle::around(from, to, cylinder.radius, side) else {
        return WrapPath::straight(origin, insertion);
    };
    let beyond = cylinder.beyond(height(origin.z, insertion.z, &contact));
    if beyond == 0.0 {
        return WrapPath::wound(origin, insertion, &contact, Vec3::ZERO, [Vec3::X, Vec3::Y, Vec3::Z]);
    }
    let along = to - from;
    let sunk = along.perp().normalize_or_zero() * (contact.sense * sink(beyond, cylinder.radius));
    // As the circle sinks the angle about it falls towards 0 and keeps its sign.
    match circle::around(from - sunk, to - sunk, cylinder.radius, PI * contact.sense) {
        Some(contact) => WrapPath::wound(origin, insertion, &contact, sunk.extend(0.0), [Vec3::X, Vec3::Y, Vec3::Z]),
        None => WrapPath::straight(origin, insertion),
    }
}

/// Height of the middle of the wound part.
#[inline]
fn height(from: f32, to: f32, contact: &Contact) -> f32 {
    from + (to - from) * ((contact.legs[0] + 0.5 * contact.radius * contact.angle) / contact.length())
}

/// How far a bone's end has fallen back from the bone at a height over it: at first as a ball does, to the second order, and
/// then no steeper than at half a right angle, for a ball's own side gets steeper without end, and a muscle would slip off in
/// one frame.
#[inline]
fn sink(height: f32, radius: f32) -> f32 {
    let round = height.min(radius);
    round * round / (2.0 * radius) + (height - round)
}
