//! Muscles by themselves, on axes of a known form: what is measured and drawn without a character.

use super::{AxisPoint, MuscleFrame, MuscleInput, MuscleRest, Profile, shape};
use glam::Vec3;

/// Length of [`arc`], metres.
pub(crate) const LENGTH: f32 = 0.25;
/// Volume of all of them, cubic metres: that of a cylinder of 2 cm radius and this length.
pub(crate) const VOLUME: f32 = std::f32::consts::PI * 0.02 * 0.02 * LENGTH;
/// Support outside the surface, metres.
const SUPPORT: f32 = 0.03;

/// A muscle along given positions, at least two, with the same section normal wanted at both ends.
pub(crate) fn along(
    positions: impl IntoIterator<Item = Vec3>,
    profile: &Profile,
    eccentricity: f32,
    normal: Vec3,
) -> (MuscleFrame, Vec<AxisPoint>) {
    let point = |position: Vec3| AxisPoint { position: position.extend(0.0), ..AxisPoint::default() };
    let mut points: Vec<AxisPoint> = positions.into_iter().map(point).collect();
    let rest = MuscleRest {
        origin: Vec3::ZERO.extend(VOLUME),
        insertion: Vec3::ZERO.extend(SUPPORT),
        segments: points.len() as u32 - 1,
        ..MuscleRest::default()
    };
    let frame = shape(&rest, &MuscleInput::new(profile, eccentricity), &mut points, normal, normal);
    (frame, points)
}

/// A muscle whose axis is bent evenly by `angle` radians in the plane of X and Y.
pub(crate) fn arc(
    angle: f32,
    segments: u32,
    profile: &Profile,
    eccentricity: f32,
    normal: Vec3,
) -> (MuscleFrame, Vec<AxisPoint>) {
    let share = |i: u32| i as f32 / segments as f32;
    let point = |i: u32| {
        if angle < 1e-3 {
            return Vec3::new(0.0, LENGTH * share(i), 0.0);
        }
        let radius = LENGTH / angle;
        let turn = angle * (share(i) - 0.5);
        Vec3::new(radius * turn.cos() - radius, radius * turn.sin(), 0.0)
    };
    along((0..=segments).map(point), profile, eccentricity, normal)
}
