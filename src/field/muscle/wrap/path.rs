//! A path in space: straight, wound, straight.

use super::circle::Contact;
use crate::math::sine_cosine;
use glam::Vec3;
use std::f32::consts::PI;

/// The path of a muscle past one obstacle, in the obstacle's frame, metres.
///
/// Its three parts have a common tangent where they meet: from `origin` straight to the first tangent point, a helix (of no
/// rise round a sphere: an arc), and straight to `insertion`. Where it touches nothing it is one straight part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrapPath {
    /// Where it starts: the muscle's origin, moved out of the obstacle.
    pub origin: Vec3,
    /// Where it ends: the muscle's insertion, moved out of the obstacle.
    pub insertion: Vec3,
    /// Lengths of the three parts; only the first is over 0 where the path touches nothing.
    pub parts: [f32; 3],
    /// Angle of the wound part, radians; 0 where the path touches nothing.
    pub angle: f32,
    /// A point on the helix's axis, beside its start.
    pub centre: Vec3,
    /// From the centre to the start of the helix.
    pub outward: Vec3,
    /// As long as `outward`, a quarter of a turn on.
    pub onward: Vec3,
    /// Along the axis, from the helix's start to its end.
    pub rise: Vec3,
}

impl WrapPath {
    /// The straight path.
    #[inline]
    pub fn straight(origin: Vec3, insertion: Vec3) -> WrapPath {
        WrapPath {
            origin,
            insertion,
            parts: [(insertion - origin).length(), 0.0, 0.0],
            angle: 0.0,
            centre: insertion,
            outward: Vec3::ZERO,
            onward: Vec3::ZERO,
            rise: Vec3::ZERO,
        }
    }

    /// The path whose projection along `axes[2]` is `contact`, a string in the plane of `axes[0]` and `axes[1]` round
    /// `centre`. `axes` are unit vectors at right angles, right-handed. On the obstacle unrolled the path is one straight
    /// line, so it climbs evenly along its projection.
    #[inline]
    pub fn wound(origin: Vec3, insertion: Vec3, contact: &Contact, centre: Vec3, axes: [Vec3; 3]) -> WrapPath {
        let (from, to) = ((origin - centre).dot(axes[2]), (insertion - centre).dot(axes[2]));
        let climb = to - from;
        let arc = contact.radius * contact.angle;
        let flat = contact.length();
        let length = (flat * flat + climb * climb).sqrt();
        let steep = length / flat;
        let outward = (axes[0] * contact.first.x + axes[1] * contact.first.y) * contact.radius;
        let quarter = contact.first.perp() * contact.sense;
        WrapPath {
            origin,
            insertion,
            parts: [contact.legs[0] * steep, arc * steep, contact.legs[1] * steep],
            angle: contact.angle,
            centre: centre + axes[2] * (from + climb * (contact.legs[0] / flat)),
            outward,
            onward: (axes[0] * quarter.x + axes[1] * quarter.y) * contact.radius,
            rise: axes[2] * (climb * (arc / flat)),
        }
    }

    /// Whether it lies against the obstacle.
    pub fn touches(&self) -> bool {
        self.angle > 0.0
    }

    /// Length, metres.
    #[inline]
    pub fn length(&self) -> f32 {
        self.parts[0] + self.parts[1] + self.parts[2]
    }

    /// The two tangent points; the insertion twice where it touches nothing.
    pub fn tangent_points(&self) -> [Vec3; 2] {
        [self.on_helix(0.0), self.on_helix(1.0)]
    }

    /// The point at a distance from the origin along the path, metres; beyond the ends, the end.
    #[inline]
    pub fn point(&self, distance: f32) -> Vec3 {
        let wound = distance - self.parts[0];
        let last = wound - self.parts[1];
        if wound <= 0.0 {
            let to = self.centre + self.outward;
            return self.origin + (to - self.origin) * share(distance, self.parts[0]);
        }
        if last <= 0.0 {
            return self.on_helix(share(wound, self.parts[1]));
        }
        let from = self.on_helix(1.0);
        from + (self.insertion - from) * share(last, self.parts[2])
    }

    /// Unit vector along the path at a distance from its origin, metres; zero where the path has no length.
    #[inline]
    pub fn direction(&self, distance: f32) -> Vec3 {
        let wound = distance - self.parts[0];
        // Parts may have no length, and then their neighbour's direction is theirs.
        let along = if self.touches() && wound > 0.0 && wound < self.parts[1] {
            let (sine, cosine) = turned(self.angle * (wound / self.parts[1]));
            (self.onward * cosine - self.outward * sine) * self.angle + self.rise
        } else if wound <= 0.0 || !self.touches() {
            self.centre + self.outward - self.origin
        } else {
            self.insertion - self.on_helix(1.0)
        };
        let length = along.length();
        if length > 0.0 { along * (1.0 / length) } else { Vec3::ZERO }
    }

    /// Points at even distances along the path, both ends among them.
    pub fn sample(&self, points: &mut [Vec3]) {
        let last = points.len().max(2) - 1;
        let step = self.length() / last as f32;
        for (i, point) in points.iter_mut().enumerate() {
            *point = self.point(step * i as f32);
        }
        if let Some(end) = points.get_mut(last) {
            *end = self.insertion;
        }
    }

    #[inline]
    fn on_helix(&self, share: f32) -> Vec3 {
        let (sine, cosine) = turned(self.angle * share);
        self.centre + self.outward * cosine + self.onward * sine + self.rise * share
    }
}

/// `distance / length` in 0..=1; 0 where there is no length.
#[inline]
fn share(distance: f32, length: f32) -> f32 {
    if length > 0.0 { (distance / length).clamp(0.0, 1.0) } else { 0.0 }
}

/// Sine and cosine of an angle in 0 to a whole turn.
#[inline]
fn turned(angle: f32) -> (f32, f32) {
    if angle <= PI {
        return sine_cosine(angle);
    }
    let (sine, cosine) = sine_cosine(angle - PI);
    (-sine, -cosine)
}
