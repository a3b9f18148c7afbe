//! What a limb's muscle lies round: the elbow or the knee that it crosses, where bending it would draw its straight line through
//! the joint (paper B, "Bending Around a Joint").

use crate::field::muscle::{Profile, profile::ellipse_squared};
use crate::rig::{Around, Character, MuscleSize, MuscleSpec, Wrap, roles::Hinge};
use glam::{DQuat, DVec3};

/// Bends that are tried, degrees: straight to as deep as elbows and knees go.
const BENDS: [f64; 15] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 110.0, 120.0, 130.0, 140.0];
/// A line passes behind a straight joint, not beside it, by this share at least of its distance from it.
const BEHIND: f64 = 0.5;
/// A line that comes nearer to the hinge than this share of its distance at rest goes through it.
const NEARER: f64 = 0.5;
/// The obstacle's radius with half the muscle on it, in distances of the line at rest: it just touches there, and rest stays as it was.
const TOUCHES: f64 = 0.98;
/// Least radius of an obstacle, in distances of the farther end from the joint: a muscle that has the joint in it at rest is moved out.
const LEAST: f64 = 0.02;
/// How far from the joint the point stands that tells the side, in the same distances.
const BESIDE: f64 = 0.2;

/// The wrap of a muscle that crosses a hinge; `ends_rest` are its ends above and below it, metres in scene space at rest, and
/// `normal_rest` is the direction of its section's long axis.
///
/// `None` where its line keeps to its side of the hinge however far this bends: flexors, which bending takes away from the joint.
pub(super) fn round_joint(
    character: &Character,
    hinge: &Hinge,
    ends_rest: [DVec3; 2],
    normal_rest: DVec3,
    spec: &MuscleSpec,
) -> Option<Wrap> {
    let [upper, lower] = ends_rest.map(|p| p - hinge.origin.as_dvec3());
    let axis = hinge.axis.as_dvec3();
    // How far behind the hinge's axis a line passes, metres: over 0 where straightening the joint shortens it.
    let behind = |lower: DVec3| upper.cross(lower).dot(axis) / (lower - upper).reject_from(axis).length().max(1e-9);
    let straight = hinge.straight.as_dquat() * lower;
    let bent = BENDS.iter().map(|degrees| behind(DQuat::from_axis_angle(axis, degrees.to_radians()) * straight));
    let at_rest = behind(lower);
    if behind(straight) <= BEHIND * self::nearest(upper, straight).1.length()
        || bent.fold(f64::MAX, f64::min) > NEARER * at_rest.max(0.0)
    {
        return None;
    }
    let least = LEAST * upper.length().max(lower.length());
    let (share, nearest) = nearest(upper, lower);
    let touching = TOUCHES * nearest.length() - thickness(spec, normal_rest, share, nearest);
    let radius = if at_rest > 0.0 { touching.max(least) } else { least };
    let joint = &character.joints[hinge.joint as usize];
    let scale = f64::from(joint.bind().determinant().abs().cbrt());
    let beside = (lower - upper).cross(axis).try_normalize()? * (BESIDE * upper.length());
    let side = joint.inverse_bind.transform_point3(hinge.origin + beside.as_vec3());
    Some(Wrap { around: Around::Joint(joint.name.clone()), radius: (radius / scale) as f32, side: Some(side) })
}

/// The point of a segment that is nearest to the origin, and its share of the way.
fn nearest(from: DVec3, to: DVec3) -> (f64, DVec3) {
    let way = to - from;
    let share = (-from.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (share, from + way * share)
}

/// Half a muscle's thickness at a share of its length towards what it lies round, metres.
fn thickness(spec: &MuscleSpec, normal_rest: DVec3, share: f64, towards: DVec3) -> f64 {
    let MuscleSize::Width(width) = spec.size else { return 0.0 };
    let profile = Profile::of(spec.rest.alpha, spec.rest.beta);
    let (short_squared, long_squared) = ellipse_squared(spec.rest.eccentricity);
    let squared = towards.normalize_or_zero().dot(normal_rest).powi(2);
    let polar = f64::from(short_squared) * squared + f64::from(long_squared) * (1.0 - squared);
    f64::from(width * profile.at(share as f32).0 / profile.max()) / polar.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::{Attachment, Joint};
    use glam::{Mat4, Quat, Vec3};

    /// A knee half a metre under a hip, straight, which closes about X: the shin goes to -Z, behind.
    fn knee() -> (Character, Hinge) {
        let joint =
            Joint { name: "shin".into(), parent: None, node: 0, inverse_bind: Mat4::from_translation(Vec3::Y * 0.5) };
        let character = Character { joints: vec![joint], ..Character::default() };
        let (origin, axis) = (Vec3::Y * -0.5, Vec3::X);
        (character, Hinge { joint: 0, origin, axis, straight: Quat::IDENTITY })
    }

    /// The wrap of a muscle as thick as `width` that runs `ahead` of the bones.
    fn proposed(ahead: f64, width: f32, straight: Quat) -> Option<(f32, Vec3)> {
        let (character, hinge) = knee();
        let end = Attachment { bone: "shin".into(), offset: Vec3::ZERO, normal: Vec3::X };
        let spec = MuscleSpec::new("m", "shin", end.clone(), end, MuscleSize::Width(width));
        let ends = [DVec3::new(0.0, -0.1, ahead), DVec3::new(0.0, -0.6, ahead)];
        let wrap = round_joint(&character, &Hinge { straight, ..hinge }, ends, DVec3::X, &spec)?;
        assert_eq!(wrap.around, Around::Joint("shin".into()));
        Some((wrap.radius, wrap.side.expect("a side")))
    }

    #[test]
    fn extensors_lie_round_the_joint_and_touch_it_at_rest() {
        let (radius, side) = proposed(0.05, 0.02, Quat::IDENTITY).expect("a wrap");
        // The joint is at .8 of the length.
        let profile = Profile::of(3, 3);
        let thick = 0.02 * profile.at(0.8).0 / profile.max();
        assert!((radius + thick - 0.98 * 0.05).abs() < 1e-6, "{radius} {thick}");
        assert!(side.z > 0.05 && side.x.abs() < 1e-6, "{side} is in front");
        assert!(proposed(0.0, 0.02, Quat::IDENTITY).is_none(), "what passes through the axis is on no side");
        assert!(proposed(-0.05, 0.02, Quat::IDENTITY).is_none(), "flexors go away from the joint");
    }

    #[test]
    fn a_muscle_that_has_the_joint_in_it_is_moved_out() {
        let (radius, _) = proposed(0.05, 0.2, Quat::IDENTITY).expect("a wrap");
        assert!((radius - 0.02 * 0.4).abs() < 1e-3, "{radius}");
        // Bent at rest so far that the line passes behind the joint, where straight it passes in front.
        let bent = Quat::from_rotation_x(-1.2);
        let (radius, side) = proposed(-0.01, 0.02, bent).expect("a wrap");
        assert!(radius < 0.01 && side.z > 0.05, "{radius} {side}");
    }
}
