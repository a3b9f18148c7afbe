//! Muscles as an author gives them, and as the stages read them.

use super::{Attachment, MuscleSize, MuscleSpec};
use crate::rig::{Character, FieldGroups};
use crate::{
    error::MuscleError,
    field::muscle::{MAX_ECCENTRICITY, MuscleRest, ellipse_squared, profile_max, profile_scale},
    math::{transform_point, transform_vector},
};
use glam::Vec3;

/// Support of the muscle's field outside its surface, in largest rest radii (background 3.2: .5 to 1).
const SUPPORT_RADII: f32 = 0.75;

/// Checks a muscle against its character and derives what the stages read.
///
/// # Errors
/// A bone that the character lacks or that has no field, coincident ends, or a number out of its range.
pub fn resolve(spec: &MuscleSpec, character: &Character, groups: &FieldGroups) -> Result<MuscleRest, MuscleError> {
    let joint = |role, bone: &str| find_bone(spec, character, role, bone);
    let value = |key: &str, what: String| MuscleError::Value { muscle: spec.name.clone(), key: key.into(), what };
    let (from, to) = (joint("origin", &spec.origin.bone)?, joint("insertion", &spec.insertion.bone)?);
    let group = groups.group_of_joint[joint("field", &spec.bone)?];
    if group == u32::MAX {
        return Err(MuscleError::NoField { muscle: spec.name.clone(), bone: spec.bone.clone() });
    }
    for (name, exponent) in [("alpha", spec.rest.alpha), ("beta", spec.rest.beta)] {
        if !(2..=9).contains(&exponent) {
            return Err(value(name, format!("{name} is {exponent}, and must be a whole number from 2 to 9")));
        }
    }
    if !(0.0..=MAX_ECCENTRICITY).contains(&spec.rest.eccentricity) {
        let what = format!("eccentricity is {}, and must be in 0 to {MAX_ECCENTRICITY}", spec.rest.eccentricity);
        return Err(value("eccentricity", what));
    }
    let (origin, origin_normal) = placed(character, from, &spec.origin);
    let (insertion, insertion_normal) = placed(character, to, &spec.insertion);
    if ![origin, insertion, origin_normal, insertion_normal].iter().all(|v| v.is_finite()) {
        return Err(value("origin", "an offset or normal is not finite".into()));
    }
    let length = origin.distance(insertion);
    if length < 1e-4 {
        let what = format!("origin and insertion are {length} m apart at rest; move one of them");
        return Err(value("insertion.offset", what));
    }
    let highest = profile_max(spec.rest.alpha, spec.rest.beta);
    let width = match spec.size {
        MuscleSize::Width(w) => w / highest,
        MuscleSize::Volume(v) => (v / (std::f32::consts::PI * length)).sqrt(),
    };
    // As thick as its character is tall is a slip of units, and larger numbers overflow further on.
    let tallest = character.height_rest().max(1e-6);
    if !(width > 0.0 && width * highest <= tallest && length <= 100.0 * tallest) {
        let key = match spec.size {
            MuscleSize::Width(_) => "width",
            MuscleSize::Volume(_) => "volume",
        };
        let what = format!(
            "it is {length} m long and {} m thick at rest, beside a character of {tallest} m; width (m) or volume (m^3) must \
             be positive, and both ends near the character",
            width * highest
        );
        return Err(value(key, what));
    }
    let (short_squared, long_squared) = ellipse_squared(spec.rest.eccentricity);
    Ok(MuscleRest {
        origin: origin.extend(std::f32::consts::PI * width * width * length),
        insertion: insertion.extend(SUPPORT_RADII * width * highest),
        origin_normal: origin_normal.extend(length),
        insertion_normal: insertion_normal.extend(0.0),
        origin_joint: from as u32,
        insertion_joint: to as u32,
        group,
        alpha: spec.rest.alpha,
        beta: spec.rest.beta,
        profile_scale: profile_scale(spec.rest.alpha, spec.rest.beta),
        profile_max: highest,
        short_squared,
        long_squared,
        ..MuscleRest::default()
    })
}

fn placed(character: &Character, joint: usize, at: &Attachment) -> (Vec3, Vec3) {
    let bind = character.joints[joint].bind();
    (transform_point(&bind, at.offset), transform_vector(&bind, at.normal).normalize_or_zero())
}

fn find_bone(spec: &MuscleSpec, character: &Character, role: &'static str, bone: &str) -> Result<usize, MuscleError> {
    character.joints.iter().position(|j| j.name == bone).ok_or_else(|| {
        let mut names: Vec<&str> = character.joints.iter().map(|j| j.name.as_str()).collect();
        names.sort_by_key(|name| distance(bone, name));
        names.truncate(3);
        MuscleError::UnknownBone { muscle: spec.name.clone(), role, bone: bone.into(), nearest: names.join(", ") }
    })
}

/// Edits that turn one name into another, case aside (Levenshtein's distance).
fn distance(a: &str, b: &str) -> usize {
    let (a, b) = (a.to_lowercase(), b.to_lowercase());
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::{Influence, Joint, groups::Group};
    use glam::{Mat4, Vec2};

    /// A spec on a character of one bone, 1 m tall.
    fn resolved(change: impl Fn(&mut MuscleSpec)) -> Result<MuscleRest, String> {
        let end = |y| Attachment { bone: "thigh".into(), offset: Vec3::Y * y, normal: Vec3::X };
        let mut spec = MuscleSpec::new("m", "thigh", end(0.1), end(0.5), MuscleSize::Width(0.03));
        change(&mut spec);
        let character = Character {
            joints: vec![Joint { name: "thigh".into(), parent: None, node: 0, inverse_bind: Mat4::IDENTITY }],
            positions_rest: vec![Vec3::ZERO, Vec3::Y],
            normals_rest: vec![Vec3::X; 2],
            uvs: vec![Vec2::ZERO; 2],
            influences: vec![Influence { joint: 0, weight: 1.0 }; 2],
            influence_offsets: vec![0, 1, 2],
            ..Character::default()
        };
        let group = Group { name: "thigh".into(), joint: 0, joints: vec![0], parent: None, passive: false, part: None };
        let groups = FieldGroups { groups: vec![group], group_of_joint: vec![0], owner: vec![0, 0] };
        resolve(&spec, &character, &groups).map_err(|e| e.to_string())
    }

    #[test]
    fn width_and_volume_name_the_same_muscle() {
        let by_width = resolved(|_| ()).expect("good");
        let volume = by_width.origin.w;
        let by_volume = resolved(|s| s.size = MuscleSize::Volume(volume)).expect("good");
        assert!((by_volume.origin.w / volume - 1.0).abs() < 1e-6);
        let radius = (volume / (std::f32::consts::PI * 0.4)).sqrt() * by_width.profile_max;
        assert!((radius - 0.03).abs() < 1e-6, "{radius}");
    }

    #[test]
    fn numbers_out_of_their_range_are_refused() {
        let refused = |change: fn(&mut MuscleSpec)| resolved(change).map(drop).expect_err("must be refused");
        assert!(refused(|s| s.size = MuscleSize::Width(-0.1)).contains("must be positive"));
        assert!(refused(|s| s.size = MuscleSize::Width(f32::NAN)).contains("must be positive"));
        assert!(refused(|s| s.size = MuscleSize::Width(1e10)).contains("beside a character of 1 m"));
        assert!(refused(|s| s.size = MuscleSize::Volume(f32::INFINITY)).contains("must be positive"));
        assert!(refused(|s| s.insertion.offset = Vec3::splat(1e30)).contains("near the character"));
        assert!(refused(|s| s.insertion.offset = s.origin.offset).contains("apart at rest"));
        assert!(refused(|s| s.origin.offset.x = f32::NAN).contains("not finite"));
        assert!(refused(|s| s.rest.alpha = 1).contains("from 2 to 9"));
        assert!(refused(|s| s.rest.eccentricity = 1.0).contains("eccentricity"));
        assert!(refused(|s| s.insertion.bone = "thihg".into()).contains("nearest names: thigh"));
    }

    #[test]
    fn distance_counts_edits() {
        assert_eq!(distance("upperarm_l", "upperarm_l"), 0);
        assert_eq!(distance("UpperArm_l", "upperarm_r"), 1);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("kitten", "sitting"), 3);
    }
}
