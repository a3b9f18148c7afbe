//! From a belly to a muscle that paper A's primitive can be, and that a muscle file can hold.
//!
//! The axis is the line through the root curve, drawn on to the joint that the belly lies nearer to and a little past it, so that
//! the joint moves the muscle; paper B attaches extremities to the nearest bone. What an artist knows better is for the file.

use super::{
    chain::{Belly, Link, Section},
    fit::{self, ProfileFit},
    limb::{Bone, Found, PLANES, Region, Verdict, search},
    section::Surface,
};
use crate::error::ExtractError;
use crate::field::muscle::profile::MAX_ECCENTRICITY;
use crate::rig::{
    Attachment, Character, MuscleShape, MuscleSize, MuscleSpec, groups::Side, muscle::BodySide, roles::Roles,
};
use glam::{DVec3, Mat4, Vec3};

/// How far the axis goes on past the belly's ends, at least and at most, in lengths of the belly.
const EXTENSION: [f64; 2] = [0.05, 0.6];
/// An axis that ends this near to a joint, in lengths of the bone, crosses it.
const AT_JOINT: f64 = 0.1;
/// Sections from which a muscle is no surer, and the stray of its tips, perimeters, that halves its sureness.
const SURE_SECTIONS: f64 = 12.0;
const UNSURE_STRAY: f64 = 0.03;
/// How far an end goes past the joint that it crosses, in lengths of the bone.
const PAST_JOINT: f64 = 0.04;
/// Muscles less sure than this are left out.
pub const LEAST_CONFIDENCE: f64 = 0.3;
/// Two bellies side by side within this angle round the bone are one muscle, degrees.
const SAME_PLACE: f64 = 25.0;
/// A belly whose middle is farther down the bone than this share of it crosses the joint below; others cross the one above.
const NEARER_BELOW: f64 = 0.45;
/// Where a muscle ends on the bone behind a joint, in lengths of that bone, and how much of its distance from it is left there.
const TENDON_SHARE: f64 = 0.15;
const TENDON_OFF: f64 = 0.4;
/// A muscle's radius in distances of its tip from the bone's axis, at most: bone and fat have the rest.
const ROOM: f64 = 0.35;
/// Full activation has this much more on either exponent: as in paper A's default the belly is fuller and shorter; it stays in its place.
const ACTIVE_MORE: u32 = 1;

/// A muscle that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Extracted {
    /// As a muscle file holds it.
    pub spec: MuscleSpec,
    /// Which bone it was found on.
    pub bone: Bone,
    /// Where around the bone it is, degrees: 0 in front, 90 outside, 180 behind, -90 inside.
    pub degrees: f64,
    /// The sections that it was found in.
    pub sections: usize,
    /// How far its tips are from the profile, root mean square, metres.
    pub profile_rms: f64,
    /// How far its crests are from their ellipses, root mean square, metres.
    pub ellipse_rms: f64,
    /// How surely it is a muscle, 0..=1: by its prominence, its sections and how its tips keep to a line.
    pub confidence: f64,
    /// The root curve, metres in scene space at rest.
    pub roots_rest: Vec<DVec3>,
}

impl Extracted {
    /// Whether it is a piece of another one: beside it on the same side of the bone.
    fn is_part_of(&self, other: &Extracted) -> bool {
        let apart = (self.degrees - other.degrees).rem_euclid(360.0);
        let way = other.roots_rest[other.roots_rest.len() - 1] - other.roots_rest[0];
        let share = |p: &DVec3| (*p - other.roots_rest[0]).dot(way) / way.length_squared();
        let within = self.roots_rest.iter().filter(|p| (0.0..=1.0).contains(&share(p))).count();
        apart.min(360.0 - apart) < SAME_PLACE && 2 * within > self.roots_rest.len()
    }
}

/// All that was found in a character.
#[derive(Clone, Debug, Default)]
pub struct Extraction {
    /// Muscles, bone by bone, left before right.
    pub muscles: Vec<Extracted>,
    /// Per region what the planes found.
    pub regions: Vec<(Region, Found)>,
}

/// Finds the muscles of a character's limbs under its skin.
///
/// # Errors
/// No limbs, or no closed skin around any of their bones.
pub fn extract(character: &Character, roles: &Roles) -> Result<Extraction, ExtractError> {
    let surface = Surface::new(character);
    let mut extraction = Extraction::default();
    for region in Region::of(character, roles) {
        let found = search(&surface, &region);
        let bellies = found.bellies.iter().filter(|(_, verdict)| *verdict == Verdict::Muscle);
        let made = bellies.filter_map(|(belly, _)| muscle(character, roles, &region, &found.sections, belly));
        let mut made: Vec<Extracted> = made.filter(|m| m.confidence >= LEAST_CONFIDENCE).collect();
        made.sort_by(|a, b| b.confidence.total_cmp(&a.confidence));
        let mut kept: Vec<Extracted> = Vec::new();
        for one in made {
            if !kept.iter().any(|other| one.is_part_of(other)) {
                kept.push(one);
            }
        }
        kept.sort_by(|a, b| a.degrees.total_cmp(&b.degrees));
        extraction.muscles.extend(kept);
        extraction.regions.push((region, found));
    }
    let bones = extraction.regions.len();
    if bones == 0 {
        return Err(ExtractError::NoLimbs { character: character.name.clone() });
    }
    if extraction.regions.iter().all(|(_, found)| found.sections.is_empty()) {
        let planes = bones * PLANES;
        return Err(ExtractError::NoOutlines { character: character.name.clone(), planes, bones });
    }
    for k in 0..extraction.muscles.len() {
        let name = extraction.muscles[k].spec.name.clone();
        let same = extraction.muscles[..k].iter().filter(|m| stem(&m.spec.name) == stem(&name)).count();
        if same > 0 {
            let (stem, side) = stem(&name);
            extraction.muscles[k].spec.name = format!("{stem}_{}{side}", same + 1);
        }
    }
    Ok(extraction)
}

/// A name without its number, and its side.
fn stem(name: &str) -> (String, &str) {
    let (name, side) = match name.strip_suffix("_l").or(name.strip_suffix("_r")) {
        Some(stem) => (stem, &name[stem.len()..]),
        None => (name, ""),
    };
    (name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('_').into(), side)
}

fn muscle(
    character: &Character,
    roles: &Roles,
    region: &Region,
    sections: &[Section],
    belly: &Belly,
) -> Option<Extracted> {
    let roots_rest = beside_bone(region, sections, belly);
    let (first, way) = axis(&roots_rest);
    let along = |p: DVec3| (p - region.ends_rest[0]).dot(region.direction()) / region.length();
    let shares = [along(first), along(first + way)];
    let middle = 0.5 * (shares[0] + shares[1]);
    let per_share = 1.0 / (shares[1] - shares[0]).max(1e-6);
    // The belly's line is known between 0 and 1; ends are beyond.
    let crosses_below = middle > NEARER_BELOW && region.beside[1].is_some();
    let crosses_above = !crosses_below && region.beside[0].is_some();
    let lowest = if crosses_below { 1.0 + PAST_JOINT } else { 1.0 };
    let highest = if crosses_above { -PAST_JOINT } else { 0.0 };
    let from = -((shares[0] - highest) * per_share).clamp(EXTENSION[0], EXTENSION[1]);
    let to = 1.0 + ((lowest - shares[1]) * per_share).clamp(EXTENSION[0], EXTENSION[1]);
    let ends = [first + way * from, first + way * to];
    let crossed = [crosses_above && along(ends[0]) < AT_JOINT, crosses_below && along(ends[1]) > 1.0 - AT_JOINT];
    let carried = [0, 1].map(|k| region.beside[k].filter(|_| crossed[k]).unwrap_or(region.joint));
    let ends = [0, 1].map(|k| if crossed[k] { across_joint(region, k, ends[k]) } else { ends[k] });
    let (s, out) = belly.reach(sections);
    let s: Vec<f64> = s.iter().map(|s| (s - from) / (to - from)).collect();
    let fit = fit::profile(&s, &out)?;
    let thickest = thickest(sections, belly);
    let ratio = (thickest.1 / thickest.0).clamp(0.2, 1.0);
    let eccentricity = ((1.0 - ratio * ratio).sqrt() as f32).min(MAX_ECCENTRICITY);
    let attach = |k: usize| attachment(&character.joints[carried[k] as usize], ends[k], long_axis(sections, belly));
    let degrees = degrees(roles, region, sections, belly);
    let (side, suffix) = side(region);
    let deepest = belly.links.iter().zip(&roots_rest).map(|(l, p)| sections[l.section].tip_rest(l.bump).distance(*p));
    let width = (thickest.0 * thickest.1).sqrt().min(deepest.fold(0.0, f64::max));
    let size = MuscleSize::Width(width as f32);
    let name = format!("{}{suffix}", name(region.bone, degrees, middle));
    let bone = &character.joints[region.joint as usize].name;
    let shape = |fit: &ProfileFit, more: u32| MuscleShape {
        alpha: fit.alpha + more,
        beta: fit.beta + more,
        eccentricity,
        width: 1.0,
    };
    let spec = MuscleSpec {
        side,
        rest: shape(&fit, 0),
        active: shape(&fit, ACTIVE_MORE),
        collision_group: format!("{}{suffix}", bone_name(region.bone)),
        ..MuscleSpec::new(&name, bone, attach(0), attach(1), size)
    };
    let ellipses = belly.links.iter().map(|l| sections[l.section].ellipses[l.bump].rms.powi(2)).sum::<f64>();
    let sections_sure = (belly.links.len() as f64 / SURE_SECTIONS).min(1.0);
    let line_sure = 1.0 - 0.5 * (belly.stray / UNSURE_STRAY).min(1.0);
    let confidence = belly.prominence.min(1.0) * sections_sure * line_sure;
    Some(Extracted {
        spec,
        bone: region.bone,
        degrees,
        sections: belly.links.len(),
        profile_rms: fit.rms,
        ellipse_rms: (ellipses / belly.links.len() as f64).sqrt(),
        confidence,
        roots_rest,
    })
}

/// A belly's root curve, no deeper under the tips than leaves room for the bone: a broad bump's ellipse goes round it.
fn beside_bone(region: &Region, sections: &[Section], belly: &Belly) -> Vec<DVec3> {
    let one = |(link, root): (&Link, &DVec3)| {
        let tip = sections[link.section].tip_rest(link.bump);
        let along = (tip - region.ends_rest[0]).dot(region.direction());
        let room = ROOM * tip.distance(region.ends_rest[0] + region.direction() * along);
        let depth = tip.distance(*root);
        if depth > room { tip.lerp(*root, room / depth) } else { *root }
    };
    belly.links.iter().zip(&belly.roots_rest).map(one).collect()
}

/// The line through a root curve: where it begins, and the way to where it ends.
fn axis(roots: &[DVec3]) -> (DVec3, DVec3) {
    let count = roots.len() as f64;
    let middle = roots.iter().sum::<DVec3>() / count;
    let place = |k: usize| k as f64 / (count - 1.0) - 0.5;
    let square: f64 = (0..roots.len()).map(|k| place(k).powi(2)).sum();
    let way = roots.iter().enumerate().map(|(k, p)| (*p - middle) * place(k)).sum::<DVec3>() / square;
    (middle - way * 0.5, way)
}

/// Where a muscle that crosses a joint ends: on the long bone behind it, a little past the joint and near the bone, as tendons
/// do that would else stand off the bend like a bow's string.
fn across_joint(region: &Region, k: usize, end: DVec3) -> DVec3 {
    let joint = region.ends_rest[k];
    let Some(far) = region.far_rest[k] else { return joint.lerp(end, TENDON_OFF) };
    let (bone, off) = (far - joint, end - joint);
    let beside = off - bone * (off.dot(bone) / bone.length_squared());
    joint + bone * TENDON_SHARE + beside * TENDON_OFF
}

/// Half axes where the belly is thickest: medians of its thickest third.
fn thickest(sections: &[Section], belly: &Belly) -> (f64, f64) {
    let mut axes: Vec<(f64, f64)> = belly
        .links
        .iter()
        .map(|l| &sections[l.section].ellipses[l.bump])
        .map(|ellipse| (ellipse.long, ellipse.short))
        .collect();
    axes.sort_by(|a, b| (b.0 * b.1).total_cmp(&(a.0 * a.1)));
    axes[axes.len() / 6]
}

/// Direction of the ellipses' long axis in the belly's middle, scene space at rest.
fn long_axis(sections: &[Section], belly: &Belly) -> DVec3 {
    let middle = belly.links[belly.links.len() / 2];
    let section = &sections[middle.section];
    let (sin, cos) = section.ellipses[middle.bump].angle.sin_cos();
    section.plane.axes[0] * cos + section.plane.axes[1] * sin
}

fn attachment(joint: &crate::rig::Joint, place_rest: DVec3, normal_rest: DVec3) -> Attachment {
    let to_local: Mat4 = joint.inverse_bind;
    let normal: Vec3 = to_local.transform_vector3(normal_rest.as_vec3()).normalize_or(Vec3::X);
    Attachment { bone: joint.name.clone(), offset: to_local.transform_point3(place_rest.as_vec3()), normal }
}

/// Where around its bone a belly is: 0 in front, 90 outside, 180 behind, -90 inside.
fn degrees(roles: &Roles, region: &Region, sections: &[Section], belly: &Belly) -> f64 {
    let middle = belly.links[belly.links.len() / 2];
    let section = &sections[middle.section];
    let out = section.tip_rest(middle.bump) - section.plane.origin_rest;
    let left = roles.axes.map_or(region.front.cross(region.direction()), |axes| axes.left.as_dvec3());
    let outside = if region.side == Some(Side::Right) { -left } else { left };
    out.dot(outside).atan2(out.dot(region.front)).to_degrees()
}

/// A region's side, and what names end with on it.
fn side(region: &Region) -> (BodySide, &'static str) {
    match region.side {
        Some(Side::Left) => (BodySide::Left, "_l"),
        Some(Side::Right) => (BodySide::Right, "_r"),
        None => (BodySide::Centre, ""),
    }
}

fn bone_name(bone: Bone) -> &'static str {
    match bone {
        Bone::UpperArm => "upper_arm",
        Bone::Forearm => "forearm",
        Bone::Thigh => "thigh",
        Bone::Shin => "shin",
    }
}

/// What anatomy has at such a place: a proposal.
fn name(bone: Bone, degrees: f64, middle: f64) -> &'static str {
    let quarter = ((degrees + 45.0).rem_euclid(360.0) / 90.0) as u32;
    match (bone, quarter) {
        (Bone::UpperArm, 0) if middle < 0.65 => "biceps",
        (Bone::UpperArm, 0) => "brachialis",
        (Bone::UpperArm, 1) if middle < 0.4 => "deltoid",
        (Bone::UpperArm, 1) => "triceps_lateral",
        (Bone::UpperArm, 2) if degrees > 0.0 => "triceps_lateral",
        (Bone::UpperArm, _) => "triceps_long",
        (Bone::Forearm, 0) => "forearm_front",
        (Bone::Forearm, 1) => "forearm_outside",
        (Bone::Forearm, 2) => "forearm_back",
        (Bone::Forearm, _) => "forearm_inside",
        (Bone::Thigh, 0) => "quadriceps",
        (Bone::Thigh, 1) => "vastus_lateralis",
        (Bone::Thigh, 2) => "hamstrings",
        (Bone::Thigh, _) => "adductors",
        (Bone::Shin, 0) => "tibialis_anterior",
        (Bone::Shin, 1) => "peroneus",
        (Bone::Shin, 2) if middle < 0.4 => "gastrocnemius",
        (Bone::Shin, 2) => "soleus",
        (Bone::Shin, _) => "gastrocnemius_medial",
    }
}
