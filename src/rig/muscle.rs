//! Muscles as an author gives them, and as the stages read them.

use super::{Character, FieldGroups};
use crate::{
    error::MuscleError,
    field::muscle::{MAX_ECCENTRICITY, MuscleRest, ellipse_squared, profile_max, profile_scale},
    math::{transform_point, transform_vector},
};
use glam::Vec3;

/// One end of a muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct Attachment {
    /// Name of the bone that carries it.
    pub bone: String,
    /// Metres, in the bone's own space.
    pub offset: Vec3,
    /// Direction of the section's long axis, in the bone's own space.
    pub normal: Vec3,
}

/// How large a muscle is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MuscleSize {
    /// Cubic metres.
    Volume(f32),
    /// Largest radius at rest with eccentricity 0, metres.
    Width(f32),
}

/// A muscle as its author gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct MuscleSpec {
    /// Its name, unique in the file.
    pub name: String,
    /// The bone whose field it joins.
    pub bone: String,
    /// End on the body's side.
    pub origin: Attachment,
    /// End that moves.
    pub insertion: Attachment,
    /// Profile exponent at the origin, 2..=9.
    pub alpha: u32,
    /// Profile exponent at the insertion, 2..=9.
    pub beta: u32,
    /// Eccentricity of the section, 0..=.99.
    pub eccentricity: f32,
    /// Volume, or width at rest.
    pub size: MuscleSize,
}

/// Support of the muscle's field outside its surface, in largest rest radii (background 3.2: .5 to 1).
const SUPPORT_RADII: f32 = 0.75;

/// Checks a muscle against its character and derives what the stages read.
///
/// # Errors
/// A bone that the character lacks or that has no field, coincident ends, or a number out of its range.
pub fn resolve(spec: &MuscleSpec, character: &Character, groups: &FieldGroups) -> Result<MuscleRest, MuscleError> {
    let joint = |role, bone: &str| find_bone(spec, character, role, bone);
    let value = |what: String| MuscleError::Value { muscle: spec.name.clone(), what };
    let (from, to) = (joint("origin", &spec.origin.bone)?, joint("insertion", &spec.insertion.bone)?);
    let group = groups.group_of_joint[joint("field", &spec.bone)?];
    if group == u32::MAX {
        return Err(MuscleError::NoField { muscle: spec.name.clone(), bone: spec.bone.clone() });
    }
    for (name, exponent) in [("alpha", spec.alpha), ("beta", spec.beta)] {
        if !(2..=9).contains(&exponent) {
            return Err(value(format!("{name} is {exponent}, and must be a whole number from 2 to 9")));
        }
    }
    if !(0.0..=MAX_ECCENTRICITY).contains(&spec.eccentricity) {
        return Err(value(format!("eccentricity is {}, and must be in 0 to {MAX_ECCENTRICITY}", spec.eccentricity)));
    }
    let (origin, origin_normal) = placed(character, from, &spec.origin);
    let (insertion, insertion_normal) = placed(character, to, &spec.insertion);
    if ![origin, insertion, origin_normal, insertion_normal].iter().all(|v| v.is_finite()) {
        return Err(value("an offset or normal is not finite".into()));
    }
    let length = origin.distance(insertion);
    if length < 1e-4 {
        return Err(value(format!("origin and insertion are {length} m apart at rest; move one of them")));
    }
    let highest = profile_max(spec.alpha, spec.beta);
    let width = match spec.size {
        MuscleSize::Width(w) => w / highest,
        MuscleSize::Volume(v) => (v / (std::f32::consts::PI * length)).sqrt(),
    };
    if !(width > 0.0 && width.is_finite()) {
        return Err(value("its width or volume must be a positive number".into()));
    }
    let (short_squared, long_squared) = ellipse_squared(spec.eccentricity);
    Ok(MuscleRest {
        origin: origin.extend(std::f32::consts::PI * width * width * length),
        insertion: insertion.extend(SUPPORT_RADII * width * highest),
        origin_normal: origin_normal.extend(length),
        insertion_normal: insertion_normal.extend(0.0),
        origin_joint: from as u32,
        insertion_joint: to as u32,
        group,
        alpha: spec.alpha,
        beta: spec.beta,
        profile_scale: profile_scale(spec.alpha, spec.beta),
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
    use super::distance;

    #[test]
    fn distance_counts_edits() {
        assert_eq!(distance("upperarm_l", "upperarm_l"), 0);
        assert_eq!(distance("UpperArm_l", "upperarm_r"), 1);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("kitten", "sitting"), 3);
    }
}
