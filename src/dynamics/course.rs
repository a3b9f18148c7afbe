//! How a muscle that lies round a bone or a joint is carried along, and what holds its axis there.

use super::MovedJoint;
use crate::{
    field::muscle::wrap::{Course, MuscleWrap, Spacing},
    math::{affine_inverse, product, transform_point},
};
use glam::{Mat4, Vec3};

/// The paths of one muscle at the start and at the end of a substep.
pub(super) struct Courses {
    /// At the start, seen from where the obstacle is at the end.
    before: Course,
    /// Takes what the obstacle has carried along back to where it was.
    back: Mat4,
    now: Course,
}

impl Courses {
    /// `before` and `now` are the muscle's ends.
    pub fn new(wrap: &MuscleWrap, around: &MovedJoint, before: [Vec3; 2], now: [Vec3; 2]) -> Courses {
        let to_posed = product(&around.matrix, &wrap.to_rest);
        let carried = before.map(|p| p + transform_point(&around.carry, p));
        Courses {
            before: Course::new(wrap, &to_posed, carried[0], carried[1], Spacing::Tension),
            back: affine_inverse(&added_to_identity(&around.carry)).0,
            now: Course::new(wrap, &to_posed, now[0], now[1], Spacing::Tension),
        }
    }

    /// Where point `i` of the path was at the start.
    pub fn start(&self, i: u32) -> Vec3 {
        transform_point(&self.back, self.before.point(i))
    }

    /// Where it is at the end.
    pub fn end(&self, i: u32) -> Vec3 {
        self.now.point(i)
    }
}

/// The map that adds to a point what `m` makes of it.
fn added_to_identity(m: &Mat4) -> Mat4 {
    Mat4::from_cols(
        m.x_axis + glam::Vec4::X,
        m.y_axis + glam::Vec4::Y,
        m.z_axis + glam::Vec4::Z,
        m.w_axis.truncate().extend(1.0),
    )
}
