//! A string in a plane, drawn tight round a circle at the origin (background 6.5 without its third coordinate).
//!
//! What decides on which side the string lies is the angle that it sweeps about the centre, counted on beyond half a turn:
//! one number chosen at rest, and from then on the string goes over from straight to wound and back without a jump. Only
//! where the ends have turned by half a turn about one another since then does it change sides.

use crate::math::polar_angle;
use glam::Vec2;
use std::f32::consts::TAU;

use super::CLEARANCE;

/// Circles below this radius, metres, hold no string.
pub(crate) const POINT: f32 = 1e-7;

/// Where a string lies on a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Radius, metres: that of the circle, or less where an end is nearer to the centre.
    pub radius: f32,
    /// Unit vector from the centre to where the string comes on.
    pub first: Vec2,
    /// Unit vector from the centre to where it goes off.
    pub second: Vec2,
    /// Lengths of the straight parts before and after, metres.
    pub legs: [f32; 2],
    /// Angle from `first` to `second`, radians, over 0; counter-clockwise where `sense` is 1.
    pub angle: f32,
    /// 1 where the string runs counter-clockwise from origin to insertion, -1 where it runs clockwise.
    pub sense: f32,
}

impl Contact {
    /// Length of the string, metres.
    pub fn length(&self) -> f32 {
        self.legs[0] + self.radius * self.angle + self.legs[1]
    }
}

/// The angle from `origin` to `insertion` about the centre, radians: of the angles that differ by whole turns the one nearest
/// to `rest`.
#[inline]
pub fn swept(origin: Vec2, insertion: Vec2, rest: f32) -> f32 {
    let turn = polar_angle(origin.dot(insertion), origin.perp_dot(insertion)) - rest;
    rest + (turn - TAU * (turn / TAU + 0.5).floor())
}

/// The string from `origin` to `insertion` round a circle of `radius` about the origin; `None` where it is straight.
///
/// `rest` is the angle that it sweeps at rest ([`swept`]), at most half a turn: no muscle winds round more than once.
#[inline]
pub fn around(origin: Vec2, insertion: Vec2, radius: f32, rest: f32) -> Option<Contact> {
    let (far_1, far_2) = (origin.length(), insertion.length());
    let radius = radius.min(far_1.min(far_2) / CLEARANCE);
    if radius < POINT {
        return None;
    }
    let swept = swept(origin, insertion, rest);
    let sense = if swept < 0.0 { -1.0 } else { 1.0 };
    let leg_1 = ((far_1 - radius) * (far_1 + radius)).max(0.0).sqrt();
    let leg_2 = ((far_2 - radius) * (far_2 + radius)).max(0.0).sqrt();
    let angle = swept * sense - polar_angle(radius, leg_1) - polar_angle(radius, leg_2);
    if angle <= 0.0 {
        return None;
    }
    Some(Contact {
        radius,
        first: (origin * radius + origin.perp() * (leg_1 * sense)) * (1.0 / (far_1 * far_1)),
        second: (insertion * radius - insertion.perp() * (leg_2 * sense)) * (1.0 / (far_2 * far_2)),
        legs: [leg_1, leg_2],
        angle,
        sense,
    })
}
