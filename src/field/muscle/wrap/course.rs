//! An obstacle as a rig holds it, and one muscle's path round it in one pose.

use super::WrapPath;
use super::cylinder::{self, Cylinder};
use super::sphere::{self, Side};
use crate::field::muscle::{AxisPoint, MuscleRest};
use crate::math::{affine_inverse, transform_point};
use glam::{Mat4, Vec3, Vec4Swizzles};

crate::gpu_struct! {
    /// What one muscle lies round, with the side on which it does.
    pub struct MuscleWrap {
        /// From the obstacle's own frame to scene space at rest. The frame's axes are unit vectors at right angles: about the
        /// joint's centre, or with z along the bone.
        pub to_rest: Mat4,
        /// Of a sphere, the axis about which the muscle turns ([`Side`]), in the obstacle's frame; in `w` the angle, radians,
        /// that it sweeps at rest.
        pub side: glam::Vec4,
        /// Radius of the obstacle and half the muscle's thickness, metres.
        pub radius: f32,
        /// Height of a bone's lower end in its frame, metres.
        pub low: f32,
        /// Height of its upper end.
        pub high: f32,
        /// Length of the path at rest, metres.
        pub rest_length: f32,
        /// Joint that carries the obstacle.
        pub joint: u32,
        /// 1 where it is a sphere on a joint, 0 where it is a cylinder on a bone.
        pub sphere: u32,
        /// Segments of the muscle's axis at each end that are tendon.
        pub tendon: u32,
        /// Segments of the muscle's axis.
        pub segments: u32,
    }
}

/// Rest length of a segment in motion as a share of its length at rest (paper A, section 6.2), to put the axis under tension.
pub(crate) const REST_SHARE: f32 = 0.02;
/// How many times stiffer than the muscle its tendons are (prototypes 1).
pub(crate) const TENDON_STIFFNESS: f32 = 10.0;

/// How the points of an axis stand along its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// At even distances.
    Even,
    /// As springs under one tension have them: muscle that pulls, and tendon that gives a tenth as much.
    Tension,
}

/// The path of one muscle round its obstacle in one pose, metres.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    path: WrapPath,
    /// From the obstacle's frame to the space of the ends.
    to_posed: Mat4,
    ends: [Vec3; 2],
    segments: u32,
    /// Shares of the path that one segment of tendon and one of muscle have.
    steps: [f32; 2],
    tendon: u32,
}

impl MuscleWrap {
    /// The path between two points of the obstacle's frame.
    #[inline]
    pub fn path(&self, origin: Vec3, insertion: Vec3) -> WrapPath {
        if self.sphere != 0 {
            let side = Side { axis: self.side.xyz(), swept: self.side.w };
            return sphere::path(origin, insertion, self.radius, &side);
        }
        let cylinder = Cylinder { radius: self.radius, low: self.low, high: self.high };
        cylinder::path(origin, insertion, &cylinder, self.side.w)
    }

    /// Shares of a path of `length`, metres at rest, that one segment of tendon and one of muscle have.
    #[inline]
    fn steps(&self, length: f32, spacing: Spacing) -> [f32; 2] {
        let segments = self.segments as f32;
        if spacing == Spacing::Even {
            return [1.0 / segments; 2];
        }
        let (tendon, muscle) = ((2 * self.tendon) as f32, (self.segments - 2 * self.tendon) as f32);
        let rest = self.rest_length / segments;
        let slack = rest * (tendon + REST_SHARE * muscle);
        let stretch = (length - slack).max(0.0) / (tendon / TENDON_STIFFNESS + muscle);
        let (long, short) = (rest + stretch / TENDON_STIFFNESS, REST_SHARE * rest + stretch);
        let whole = tendon * long + muscle * short;
        [long / whole, short / whole]
    }
}

impl Course {
    /// The path from `origin` to `insertion`, two points of any one space, into which `to_posed` takes the obstacle's frame.
    pub fn new(wrap: &MuscleWrap, to_posed: &Mat4, origin: Vec3, insertion: Vec3, spacing: Spacing) -> Course {
        let (inverse, _) = affine_inverse(to_posed);
        let path = wrap.path(transform_point(&inverse, origin), transform_point(&inverse, insertion));
        Course {
            steps: wrap.steps(path.length(), spacing),
            path,
            to_posed: *to_posed,
            ends: [origin, insertion],
            segments: wrap.segments,
            tendon: wrap.tendon,
        }
    }

    /// The path in the obstacle's frame.
    pub fn path(&self) -> &WrapPath {
        &self.path
    }

    /// Place of point `i` of the axis. The first and the last are the muscle's ends, whether or not the path's were moved out of
    /// the obstacle.
    #[inline]
    pub fn point(&self, i: u32) -> Vec3 {
        if i == 0 {
            return self.ends[0];
        }
        if i >= self.segments {
            return self.ends[1];
        }
        let muscle = i.max(self.tendon).min(self.segments - self.tendon) - self.tendon;
        let share = self.steps[0] * (i - muscle) as f32 + self.steps[1] * muscle as f32;
        transform_point(&self.to_posed, self.path.point(self.path.length() * share))
    }

    /// Puts an axis' points on the path.
    pub fn put(&self, points: &mut [AxisPoint]) {
        for (i, point) in (0..).zip(points) {
            point.position = self.point(i).extend(0.0);
        }
    }

    /// [`smooth`](crate::field::muscle::smooth) for an axis round an obstacle: what is smoothed is how far it is from the path,
    /// whose own bend is no kink.
    pub fn smooth(&self, points: &mut [AxisPoint]) {
        for (i, point) in (0..).zip(points.iter_mut()) {
            point.position -= self.point(i).extend(0.0);
        }
        crate::field::muscle::smooth(points);
        for (i, point) in (0..).zip(points) {
            point.position += self.point(i).extend(0.0);
        }
    }
}

/// Puts an axis' points evenly on a muscle's path at rest: round what it lies round, else straight from end to end. `wraps` are
/// the rig's.
pub fn points_at_rest(rest: &MuscleRest, wraps: &[MuscleWrap], points: &mut [AxisPoint]) {
    let (origin, insertion) = (rest.origin.xyz(), rest.insertion.xyz());
    let Some(wrap) = rest.wrap(wraps) else {
        return crate::field::muscle::straighten(points, origin, insertion);
    };
    Course::new(wrap, &wrap.to_rest, origin, insertion, Spacing::Even).put(points);
}
