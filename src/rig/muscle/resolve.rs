//! Muscles checked against their character, and brought into the form that the stages read.

use super::check::{self, Wrong};
use super::lie::{Fibre, Obstacle};
use super::{Attachment, MuscleShape, MuscleSize, MuscleSpec};
use crate::{
    error::MuscleError,
    field::muscle::{MuscleInput, MuscleRest, Profile, wrap::MuscleWrap},
    math::{transform_point, transform_vector},
    rig::{Character, FieldGroups, groups::BodyPart, nearest::nearest},
};
use glam::{Mat4, Vec3};

/// Support of the muscle's field outside its surface, in largest rest radii (background 3.2: .5 to 1).
const SUPPORT_RADII: f32 = 0.75;
/// Fibres whose ends are both nearer than this are the same one, metres.
const SAME_FIBRE: f32 = 1e-5;

/// Checks a muscle against its character and derives what the stages read: one entry per fibre, one for a muscle that
/// is not a set, each with what it lies round. `first_point` and `wrap` are left 0.
///
/// # Errors
/// A bone that the character lacks or that has no field, coincident ends, a wrap with an end inside or on no side, or a number
/// out of its range.
pub fn resolve(
    spec: &MuscleSpec,
    character: &Character,
    groups: &FieldGroups,
) -> Result<Vec<(MuscleRest, Option<MuscleWrap>)>, MuscleError> {
    let joint = |role, bone: &str| find_bone(spec, character, role, bone);
    let (from, to) = (joint("origin", &spec.origin.bone)?, joint("insertion", &spec.insertion.bone)?);
    let bone = joint("field", &spec.bone)?;
    let group = groups.group_of_joint[bone];
    if group == u32::MAX {
        return Err(MuscleError::NoField { muscle: spec.name.clone(), bone: spec.bone.clone() });
    }
    check::muscle(spec).map_err(|wrong| wrong.of(spec))?;
    let (origins, origin_normal) =
        ends(character, from, &spec.origin, spec.fibres.as_ref().map(|f| &f.origin_line), spec);
    let (insertions, insertion_normal) =
        ends(character, to, &spec.insertion, spec.fibres.as_ref().map(|f| &f.insertion_line), spec);
    check_apart(spec, &origins, &insertions).map_err(|wrong| wrong.of(spec))?;
    let ends: Vec<(Vec3, Vec3)> = origins.into_iter().zip(insertions).collect();
    let distances: Vec<f32> = ends.iter().map(|(o, i)| o.distance(*i)).collect();
    let obstacle = Obstacle::of(spec, character, &ends)?;
    let wraps: Vec<Option<MuscleWrap>> = (ends.iter().zip(&distances))
        .map(|(&(origin, insertion), &distance)| {
            let Some(obstacle) = &obstacle else { return Ok(None) };
            let width = width(spec, character, distance, distances.iter().sum())?;
            let fibre = Fibre { origin, insertion, normals: [origin_normal, insertion_normal], width };
            obstacle.wrap(spec, &fibre, tendon_segments(spec)).map(Some)
        })
        .collect::<Result<_, MuscleError>>()?;
    let length = |i: usize| wraps[i].map_or(distances[i], |wrap| wrap.rest_length);
    let total: f32 = (0..ends.len()).map(length).sum();
    let fibre = |i: usize| {
        let ((origin, insertion), length) = (ends[i], length(i));
        let width = width(spec, character, length, total)?;
        let rest = MuscleRest {
            origin: origin.extend(std::f32::consts::PI * width * width * length),
            insertion: insertion.extend(SUPPORT_RADII * width * profile(&spec.rest).max()),
            origin_normal: origin_normal.extend(length),
            insertion_normal: insertion_normal.extend(0.0),
            origin_joint: from as u32,
            insertion_joint: to as u32,
            group,
            segments: spec.segments,
            joint: frame_joint(groups, group, bone as u32),
            ..MuscleRest::default()
        };
        Ok((rest, wraps[i]))
    };
    (0..ends.len()).map(fibre).collect()
}

/// Segments of the axis at each end that are tendon: those whose middle is.
fn tendon_segments(spec: &MuscleSpec) -> u32 {
    let is_tendon = |i: &u32| (*i as f32 + 0.5) / (spec.segments as f32) < spec.tendon;
    (0..spec.segments).filter(is_tendon).count() as u32
}

/// The joint in whose space at rest a muscle of a group is shaped: the group's own, and in a trunk, whose joints bend it,
/// the muscle's.
fn frame_joint(groups: &FieldGroups, group: u32, bone: u32) -> u32 {
    let own = &groups.groups[group as usize];
    if own.part == Some(BodyPart::Trunk) { bone } else { own.joint }
}

/// A muscle's input in its rest shape, activation 0.
pub(in crate::rig) fn rest_input(spec: &MuscleSpec) -> MuscleInput {
    let input = MuscleInput::new(&profile(&spec.rest), spec.rest.eccentricity);
    MuscleInput { width: spec.rest.width, stiffness: spec.stiffness, ..input }
}

fn profile(shape: &MuscleShape) -> Profile {
    Profile::of(shape.alpha, shape.beta)
}

/// Fibres that lie on one another are one fibre with a multiple of its volume, and nobody means that.
fn check_apart(spec: &MuscleSpec, origins: &[Vec3], insertions: &[Vec3]) -> Result<(), Wrong> {
    let same = |line: &[Vec3], i: usize, j: usize| line[i].distance(line[j]) < SAME_FIBRE;
    let pairs = (0..origins.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
    match pairs.into_iter().find(|&(j, i)| same(origins, i, j) && same(insertions, i, j)) {
        Some((j, i)) => {
            let line = spec.fibres.as_ref().is_some_and(|set| !set.origin_line.is_empty());
            let key = if line { "fibres.origin_line" } else { "fibres.insertion_line" };
            let what = format!("fibres {} and {} lie on one another; spread the points of the lines", j + 1, i + 1);
            Err(Wrong::new(key, what))
        }
        None => Ok(()),
    }
}

/// The width w of one fibre at rest, of a muscle whose fibres are `total` long together.
fn width(spec: &MuscleSpec, character: &Character, length: f32, total: f32) -> Result<f32, MuscleError> {
    let refuse = |key: &str, what| Err(MuscleError::Value { muscle: spec.name.clone(), key: key.into(), what });
    if length < 1e-4 {
        return refuse(
            "insertion.offset",
            format!("origin and insertion are {length} m apart at rest; move one of them"),
        );
    }
    let highest = profile(&spec.rest).max();
    let (key, width) = match spec.size {
        MuscleSize::Width(w) => ("width", w / highest),
        MuscleSize::Volume(v) => ("volume", (v / (std::f32::consts::PI * total)).sqrt()),
    };
    // As thick as its character is tall is a slip of units, and larger numbers overflow further on.
    let tallest = character.height_rest().max(1e-6);
    if !(width > 0.0 && width * highest <= tallest && length <= 100.0 * tallest) {
        let what = format!(
            "it is {length} m long and {} m thick at rest, beside a character of {tallest} m; width (m) or volume (m^3) must \
             be positive, and both ends near the character",
            width * highest
        );
        return refuse(key, what);
    }
    Ok(width)
}

/// The end points of all fibres at one end in scene space at rest, and the section normal there.
fn ends(
    character: &Character,
    joint: usize,
    at: &Attachment,
    line: Option<&Vec<Vec3>>,
    spec: &MuscleSpec,
) -> (Vec<Vec3>, Vec3) {
    let bind = character.joints[joint].bind();
    let normal = transform_vector(&bind, at.normal).normalize_or_zero();
    (end_points(&bind, at.offset, line.map_or(&[], Vec::as_slice), spec.fibres.as_ref().map_or(1, |f| f.count)), normal)
}

/// `count` points evenly along the line from `offset` through `further`.
fn end_points(bind: &Mat4, offset: Vec3, further: &[Vec3], count: u32) -> Vec<Vec3> {
    let corners: Vec<Vec3> = std::iter::once(&offset).chain(further).map(|p| transform_point(bind, *p)).collect();
    let lengths: Vec<f32> = corners.windows(2).map(|w| w[0].distance(w[1])).collect();
    let total: f32 = lengths.iter().sum();
    (0..count)
        .map(|i| {
            let mut left = total * i as f32 / (count.max(2) - 1) as f32;
            for (pair, &length) in corners.windows(2).zip(&lengths) {
                if left <= length && length > 0.0 {
                    return pair[0].lerp(pair[1], left / length);
                }
                left -= length;
            }
            corners[corners.len() - 1]
        })
        .collect()
}

/// Index of the joint of a muscle's bone; `role` is `field`, `origin` or `insertion`.
pub(in crate::rig) fn find_bone(
    spec: &MuscleSpec,
    character: &Character,
    role: &'static str,
    bone: &str,
) -> Result<usize, MuscleError> {
    let unknown = |nearest| MuscleError::UnknownBone { muscle: spec.name.clone(), role, bone: bone.into(), nearest };
    find_joint(bone, character).map_err(unknown)
}

/// Index of the joint that a muscle's driver number `number` reads.
pub(in crate::rig) fn find_driver_joint(
    spec: &MuscleSpec,
    number: usize,
    character: &Character,
    joint: &str,
) -> Result<usize, MuscleError> {
    find_joint(joint, character).map_err(|nearest| MuscleError::Value {
        muscle: spec.name.clone(),
        key: format!("drivers[{number}].angle.joint"),
        what: format!("the driver's joint `{joint}` is not a joint of the character; nearest names: {nearest}"),
    })
}

/// Index of the joint that a muscle lies round, or whose bone it does; nothing where it runs straight.
pub(in crate::rig) fn find_wrap_joint(spec: &MuscleSpec, character: &Character) -> Result<Option<usize>, MuscleError> {
    let Some(wrap) = &spec.wrap else { return Ok(None) };
    let (key, name) = (wrap.around.key(), wrap.around.name());
    find_joint(name, character).map(Some).map_err(|nearest| MuscleError::Value {
        muscle: spec.name.clone(),
        key: format!("wrap.{key}"),
        what: format!("the wrap's {key} `{name}` is not a joint of the character; nearest names: {nearest}"),
    })
}

/// Index of the joint of a name, else the nearest names.
pub(in crate::rig) fn find_joint(name: &str, character: &Character) -> Result<usize, String> {
    let found = character.joints.iter().position(|j| j.name == name);
    found.ok_or_else(|| nearest(name, character.joints.iter().map(|j| j.name.as_str()), 3).join(", "))
}

#[cfg(test)]
mod tests {
    use super::super::FibreSet;
    use super::*;
    use crate::rig::{Influence, Joint, groups::Group};
    use glam::{Mat4, Vec2};

    /// A spec on a character of one bone, 1 m tall.
    fn fibres(change: impl Fn(&mut MuscleSpec)) -> Result<Vec<MuscleRest>, String> {
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
        let found = resolve(&spec, &character, &groups).map_err(|e| e.to_string())?;
        Ok(found.into_iter().map(|(rest, _)| rest).collect())
    }

    fn resolved(change: impl Fn(&mut MuscleSpec)) -> Result<MuscleRest, String> {
        fibres(change).map(|all| all[0])
    }

    #[test]
    fn fibres_spread_along_their_lines_and_share_the_volume() {
        let spread = |size| {
            fibres(|s| {
                let further = vec![Vec3::new(0.1, 0.1, 0.0), Vec3::new(0.1, 0.1, 0.1)];
                s.fibres = Some(FibreSet { count: 5, origin_line: further, insertion_line: Vec::new(), overlap: true });
                s.size = size;
            })
            .expect("good")
        };
        let all = spread(MuscleSize::Volume(2e-4));
        let places: Vec<Vec3> = all.iter().map(|f| f.origin.truncate()).collect();
        let expected = [(0.0, 0.0), (0.05, 0.0), (0.1, 0.0), (0.1, 0.05), (0.1, 0.1)];
        for (place, (x, z)) in places.iter().zip(expected) {
            assert!(place.distance(Vec3::new(x, 0.1, z)) < 1e-6, "{place}");
        }
        assert!(all.iter().all(|f| f.insertion.truncate() == Vec3::new(0.0, 0.5, 0.0)));
        let sum: f32 = all.iter().map(|f| f.origin.w).sum();
        assert!((sum / 2e-4 - 1.0).abs() < 1e-5, "{sum}");
        let wide = spread(MuscleSize::Width(0.02));
        assert!(wide.iter().all(|f| f.insertion.w == wide[0].insertion.w), "each fibre has the width");
        assert!(
            fibres(
                |s| s.fibres = Some(FibreSet { count: 1, origin_line: vec![], insertion_line: vec![], overlap: true })
            )
            .expect_err("one")
            .contains("2 to 32")
        );
    }

    #[test]
    fn fibres_that_lie_on_one_another_are_refused() {
        let back = |line: Vec<Vec3>, insertion_line: Vec<Vec3>| {
            fibres(|s| {
                let (origin_line, insertion_line) = (line.clone(), insertion_line.clone());
                s.fibres = Some(FibreSet { count: 5, origin_line, insertion_line, overlap: true });
            })
        };
        let there = Vec3::new(0.1, 0.1, 0.0);
        assert_eq!(back(vec![there], vec![]).expect("spread").len(), 5);
        let refused = back(vec![there, Vec3::Y * 0.1], vec![]).expect_err("there and back");
        assert!(refused.contains("fibres 2 and 4 lie on one another"), "{refused}");
        assert!(back(vec![Vec3::Y * 0.1], vec![]).expect_err("a line without length").contains("fibres 1 and 2"));
        back(vec![there, Vec3::Y * 0.1], vec![Vec3::new(0.0, 0.5, 0.1)]).expect("the other ends are apart");
    }

    #[test]
    fn width_and_volume_name_the_same_muscle() {
        let by_width = resolved(|_| ()).expect("good");
        let volume = by_width.origin.w;
        let by_volume = resolved(|s| s.size = MuscleSize::Volume(volume)).expect("good");
        assert!((by_volume.origin.w / volume - 1.0).abs() < 1e-6);
        let radius = (volume / (std::f32::consts::PI * 0.4)).sqrt() * Profile::of(3, 3).max();
        assert!((radius - 0.03).abs() < 1e-6, "{radius}");
    }

    #[test]
    fn numbers_out_of_their_range_are_refused() {
        let refused = |change: fn(&mut MuscleSpec)| resolved(change).map(drop).expect_err("must be refused");
        assert!(refused(|s| s.size = MuscleSize::Width(-0.1)).contains("width is -0.1, and must be a positive"));
        assert!(refused(|s| s.size = MuscleSize::Width(f32::NAN)).contains("must be a positive"));
        assert!(refused(|s| s.size = MuscleSize::Width(1e10)).contains("beside a character of 1 m"));
        assert!(refused(|s| s.size = MuscleSize::Volume(f32::INFINITY)).contains("volume is inf"));
        assert!(refused(|s| s.insertion.offset = Vec3::splat(1e30)).contains("near the character"));
        assert!(refused(|s| s.insertion.offset = s.origin.offset).contains("apart at rest"));
        assert!(refused(|s| s.origin.offset.x = f32::NAN).contains("not finite"));
        assert!(refused(|s| s.rest.alpha = 0).contains("alpha is 0, and must be a whole number from 1 to 9"));
        assert!(refused(|s| s.rest.eccentricity = 1.0).contains("eccentricity"));
        assert!(refused(|s| s.active.beta = 10).contains("active.beta is 10"));
        assert!(refused(|s| s.segments = 64).contains("3 to 63"));
        assert!(refused(|s| s.active.width = 0.0).contains("active.width is 0, and must be over 0 and at most 10"));
        assert!(refused(|s| s.origin.normal = Vec3::ZERO).contains("normal has no direction"));
        assert!(refused(|s| s.keys.width.times = vec![0.0]).contains("width has 1 times and 0 values"));
        assert!(refused(|s| s.insertion.bone = "thihg".into()).contains("nearest names: thigh"));
    }
}
