//! Obstacles for muscles made by code.

use crate::support::Random;
use glam::{Mat4, Vec3};
use sinew::field::muscle::wrap::{
    MuscleWrap,
    cylinder::{self, Cylinder},
    sphere::Side,
};

/// What a muscle lies round that crosses it between its ends: a sphere, or the cylinder of a short bone. `None` where the ends are
/// one point.
pub fn across(
    origin: Vec3,
    insertion: Vec3,
    joint: usize,
    segments: u32,
    sphere: bool,
    random: &mut Random,
) -> Option<MuscleWrap> {
    let span = origin.distance(insertion);
    if span < 1e-3 {
        return None;
    }
    let radius = 0.15 * span;
    let centre =
        origin.lerp(insertion, 0.5 + 0.1 * random.next()) + random.vec3().normalize_or(Vec3::X) * (0.5 * radius);
    let to_rest = Mat4::from_rotation_translation(random.rotation(), centre);
    let local = [origin, insertion].map(|p| to_rest.inverse().transform_point3(p));
    let (low, high) = (-radius, 2.0 * radius);
    let side = if sphere {
        let side = Side::at_rest(local[0], local[1], radius, None)?;
        side.axis.extend(side.swept)
    } else {
        Vec3::Z.extend(cylinder::side_at_rest(local[0], local[1], &Cylinder { radius, low, high }, None)?)
    };
    Some(MuscleWrap {
        to_rest,
        side,
        radius,
        low,
        high,
        rest_length: span,
        joint: joint as u32,
        sphere: sphere.into(),
        tendon: segments / 10,
        segments,
    })
}
