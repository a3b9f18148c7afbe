//! From a belly to a muscle that paper A's primitive can be, and that a muscle file can hold.
//!
//! The axis is the line through the root curve, drawn on to the joint that the belly lies nearer to and a little past it, so that
//! the joint moves the muscle; paper B attaches extremities to the nearest bone. What an artist knows better is for the file.

use super::{
    chain::{Belly, Link, Section},
    fit::{self, Bounds, Primitive},
    limb::{Bone, Region, Verdict},
    loft::Loft,
    name,
    trunk::Sweep,
    trunk_muscle::{self, outward},
    wrap,
};
use crate::field::muscle::profile::MAX_ECCENTRICITY;
use crate::rig::{
    Attachment, Character, MuscleShape, MuscleSize, MuscleSpec, groups::Side, muscle::BodySide, roles::Roles,
};
use glam::{DVec3, Mat4, Vec3};

/// How far the axis goes on past the belly's ends, at least and at most, in lengths of the belly.
const EXTENSION: [f64; 2] = [0.05, 0.6];
/// And where it ends beyond a joint: tendons are long.
const ACROSS: f64 = 2.0;
/// An axis that ends this near to a joint, in lengths of the bone, crosses it.
const AT_JOINT: f64 = 0.1;
/// Sections from which a muscle is no surer, and the stray of its tips, perimeters, that halves its sureness.
const SURE_SECTIONS: f64 = 12.0;
const UNSURE_STRAY: f64 = 0.03;
/// How far an end goes past the joint that it crosses, in lengths of the bone.
const PAST_JOINT: f64 = 0.04;
/// A crest's half, in spans of its bump.
const CREST: f64 = 0.25;
/// How far the skin may draw an end, in the ellipses' size: on its own bone, and where it crosses a joint.
const PLAY: f64 = 2.5;
const CROSSING_PLAY: f64 = 2.0;
/// An end on its own bone is beside it by this share at least of how far the skin is.
const BESIDE_BONE: f64 = 0.35;
/// And so it is beside a joint that it crosses.
const BESIDE_JOINT: f64 = 0.5;
/// What lies outside of a joint that is bent at rest by this sine or more ends on the bone's own end, as on the elbow's.
const BENT: f64 = 0.4;
/// An end is no farther from the bone than this share of what the skin is.
const UNDER_SKIN: f64 = 0.95;
/// Two bellies side by side within this angle round the bone are one muscle, degrees.
const SAME_PLACE: f64 = 25.0;
/// Two muscles of different groups of planes are one where they are nearer to each other than this share of their half breadths.
const SAME_BREADTH: f64 = 0.3;
/// A belly whose middle is farther down the bone than this share of it crosses the joint below; others cross the one above.
const NEARER_BELOW: f64 = 0.45;
/// Where a muscle ends on the bone behind the joint above it and the one below, in lengths of that bone, and how much of its
/// distance from it is left there.
const TENDON_SHARE: [f64; 2] = [0.02, 0.15];
const TENDON_OFF: f64 = 0.8;
/// A muscle's radius in distances of its tip from the bone's axis, at most: bone and fat have the rest.
const ROOM: f64 = 0.35;
/// Half its depth in the same distances, at most: it lies between bone and skin.
const HALF_ROOM: f64 = 0.45;
/// Full activation has this much more on either exponent: as in paper A's default the belly is fuller and shorter; it stays in its place.
const ACTIVE_MORE: u32 = 1;

/// Where a muscle was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Where {
    /// Along a long bone.
    Limb(Bone),
    /// By a group of planes over the trunk.
    Trunk(Sweep),
}

/// What the planes across a region found.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Sections whose outline is the region's.
    pub sections: Vec<Section>,
    /// Their bellies, muscles or not.
    pub bellies: Vec<(Belly, Verdict)>,
    /// Planes without such an outline: the skin is open there, or another part of the body is in the way.
    pub rejected: usize,
}

/// A muscle that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Extracted {
    /// As a muscle file holds it.
    pub spec: MuscleSpec,
    /// Where it was found.
    pub place: Where,
    /// Where around the bone or the trunk it is, degrees: 0 in front, 90 outside, 180 behind, -90 inside.
    pub degrees: f64,
    /// The sections that it was found in.
    pub sections: usize,
    /// How far its tips are from the profile, root mean square, metres.
    pub profile_rms: f64,
    /// How far its crests are from their ellipses, root mean square, metres.
    pub ellipse_rms: f64,
    /// How far the skin's crest is from paper A's primitive, root mean square with the tips' weights, metres.
    pub skin_rms: f64,
    /// How surely it is a muscle, 0..=1: by its prominence, its sections and how its tips keep to a line.
    pub confidence: f64,
    /// The root curve, metres in scene space at rest.
    pub roots_rest: Vec<DVec3>,
    /// The tips on the skin, metres in scene space at rest.
    pub tips_rest: Vec<DVec3>,
    /// Half its breadth, metres.
    pub half_width: f64,
    /// How square the planes that found it are to its way, 0..=1.
    pub across: f64,
    /// Its surface as the sections tell it.
    pub loft: Option<Loft>,
}

impl Extracted {
    /// Its width, metres.
    pub fn width(&self) -> f32 {
        match self.spec.size {
            MuscleSize::Width(width) => width,
            MuscleSize::Volume(_) => 0.0,
        }
    }

    /// Whether it is a piece of another one: beside it on the same side of the bone.
    pub(super) fn is_part_of(&self, other: &Extracted) -> bool {
        let apart = (self.degrees - other.degrees).rem_euclid(360.0);
        let way = other.roots_rest[other.roots_rest.len() - 1] - other.roots_rest[0];
        let share = |p: &DVec3| (*p - other.roots_rest[0]).dot(way) / way.length_squared();
        let within = self.roots_rest.iter().filter(|p| (0.0..=1.0).contains(&share(p))).count();
        apart.min(360.0 - apart) < SAME_PLACE && 2 * within > self.roots_rest.len()
    }

    /// How much the group of planes that found it dominates: surer, longer and squarer to it (paper B).
    pub(super) fn dominance(&self) -> f64 {
        let length = self.tips_rest[0].distance(self.tips_rest[self.tips_rest.len() - 1]);
        self.confidence * self.across * length
    }

    /// Whether most of its tips are within the breadth of another one.
    pub(super) fn is_under(&self, other: &Extracted) -> bool {
        let reach = SAME_BREADTH * (self.half_width + other.half_width);
        let near = |p: &&DVec3| {
            let ways = other.tips_rest.windows(2);
            let away = ways.map(|w| trunk_muscle::near(**p, w[0], w[1])).fold(f64::MAX, f64::min);
            away < reach
        };
        let way = other.tips_rest[other.tips_rest.len() - 1] - other.tips_rest[0];
        let beside = |p: &&DVec3| (0.0..=1.0).contains(&((**p - other.tips_rest[0]).dot(way) / way.length_squared()));
        2 * self.tips_rest.iter().filter(beside).filter(near).count() > self.tips_rest.len()
    }
}

/// The muscle of a belly along a limb's bone; `None` where no profile stands out.
pub(super) fn muscle(
    character: &Character,
    roles: &Roles,
    region: &Region,
    sections: &[Section],
    belly: &Belly,
) -> Option<Extracted> {
    let roots_rest = beside_bone(region, sections, belly);
    let tips_rest: Vec<DVec3> = belly.links.iter().map(|l| sections[l.section].tip_rest(l.bump)).collect();
    let line = Line::of(character, roles, region, sections, belly, &roots_rest);
    let ends = line.ends_rest;
    let outward = outward(sections, belly);
    let (s, out) = belly.reach(sections);
    let s: Vec<f64> = s.iter().map(|s| (s - line.reach[0]) / (line.reach[1] - line.reach[0])).collect();
    let fit = fit::profile(&s, &out)?;
    let (long, short) = thickest(sections, belly);
    let eccentricity = eccentricity(long, short);
    let normal_rest = long_axis(sections, belly);
    let (side, suffix) = side_of(region.side);
    let deepest = belly.links.iter().zip(&roots_rest).map(|(l, p)| sections[l.section].tip_rest(l.bump).distance(*p));
    let size = (long * short).sqrt().min(deepest.fold(0.0, f64::max));
    let crest: Vec<(DVec3, f64)> =
        belly.links.iter().flat_map(|l| sections[l.section].crest_rest(l.bump, CREST)).collect();
    let mut primitive =
        Primitive { ends_rest: ends, normal_rest, exponents: (fit.alpha, fit.beta), eccentricity, width: size };
    let off_bone = |p: DVec3| (p - region.ends_rest[0]).reject_from(region.direction()).length();
    let play = [0, 1].map(|k| {
        let most = if line.crossed[k] { CROSSING_PLAY } else { PLAY } * size;
        let room = UNDER_SKIN * off_bone(tips_rest[k * (tips_rest.len() - 1)]) - off_bone(ends[k]);
        [most, room.clamp(0.0, most)]
    });
    let deep = tips_rest.iter().map(|p| off_bone(*p)).sum::<f64>() / tips_rest.len() as f64;
    let bounds = Bounds { width: [0.5 * size, 2.0 * size], depth: HALF_ROOM * deep, play, flatter: true };
    primitive.fit(&crest, outward, &bounds);
    let (alpha, beta) = primitive.exponents;
    let ends = primitive.ends_rest;
    let attach = |k: usize| attachment(&character.joints[line.carried[k] as usize], ends[k], normal_rest);
    let name = format!("{}{suffix}", line.name);
    let bone = &character.joints[region.joint as usize].name;
    let mut spec = MuscleSpec {
        side,
        rest: shape(alpha, beta, primitive.eccentricity, 0),
        active: shape(alpha, beta, primitive.eccentricity, ACTIVE_MORE),
        collision_group: collision_group(bone_name(region.bone), suffix),
        ..MuscleSpec::new(&name, bone, attach(0), attach(1), MuscleSize::Width(primitive.width as f32))
    };
    let hinge = region.hinge(roles).filter(|_| line.crossed[region.hinge_end()]);
    spec.wrap = hinge.and_then(|hinge| wrap::round_joint(character, &hinge, ends, normal_rest, &spec));
    let ellipses = belly.links.iter().map(|l| sections[l.section].ellipses[l.bump].rms.powi(2)).sum::<f64>();
    let sections_sure = (belly.links.len() as f64 / SURE_SECTIONS).min(1.0);
    let line_sure = 1.0 - 0.5 * (belly.stray / UNSURE_STRAY).min(1.0);
    let sure = region.settings().variation.map_or(1.0, |_| trunk_muscle::SURE_VARIATION);
    let confidence = (belly.prominence / sure).min(1.0) * sections_sure * line_sure;
    Some(Extracted {
        spec,
        place: Where::Limb(region.bone),
        degrees: line.degrees,
        sections: belly.links.len(),
        profile_rms: fit.rms,
        ellipse_rms: (ellipses / belly.links.len() as f64).sqrt(),
        skin_rms: primitive.off(&crest),
        confidence,
        loft: Loft::new(sections, &belly.links, &roots_rest, ends),
        roots_rest,
        tips_rest,
        half_width: long,
        across: trunk_muscle::alignment(sections, &belly.links),
    })
}

/// The straight line of a limb's muscle, before the skin draws it.
struct Line {
    /// Its name, without a side.
    name: &'static str,
    /// Where around the bone it is.
    degrees: f64,
    /// Origin and insertion, metres in scene space at rest.
    ends_rest: [DVec3; 2],
    /// Where those are along the belly, which is from 0 to 1.
    reach: [f64; 2],
    /// Whether they are beyond the joint above and the one below.
    crossed: [bool; 2],
    /// The joints that carry them.
    carried: [u32; 2],
}

impl Line {
    fn of(
        character: &Character,
        roles: &Roles,
        region: &Region,
        sections: &[Section],
        belly: &Belly,
        roots_rest: &[DVec3],
    ) -> Line {
        let tips: Vec<DVec3> = belly.links.iter().map(|l| sections[l.section].tip_rest(l.bump)).collect();
        let along = |p: DVec3| (p - region.ends_rest[0]).dot(region.direction()) / region.length();
        let (first, way) = axis(roots_rest);
        let shares = [along(first), along(first + way)];
        let middle = 0.5 * (shares[0] + shares[1]);
        let per_share = 1.0 / (shares[1] - shares[0]).max(1e-6);
        let degrees = region.degrees(roles, tips[tips.len() / 2]);
        let arm = roles.arms.iter().find(|arm| region.bone == Bone::Forearm && arm.lower == region.joint);
        let flexor = arm.and_then(|arm| name::is_flexor(character, roles, arm, out_of_bone(sections, belly), middle));
        let name = name::of_limb(region.bone, degrees, middle, flexor);
        let ends_below = middle > NEARER_BELOW || name::ends_below(region.bone, name);
        let crosses_below = ends_below && region.beside[1].is_some();
        let crosses_above = !crosses_below && region.beside[0].is_some();
        let lowest = if crosses_below { 1.0 + PAST_JOINT } else { 1.0 };
        let highest = if crosses_above { -PAST_JOINT } else { 0.0 };
        let most = |crosses: bool| if crosses { ACROSS } else { EXTENSION[1] };
        let from = -((shares[0] - highest) * per_share).clamp(EXTENSION[0], most(crosses_above));
        let to = 1.0 + ((lowest - shares[1]) * per_share).clamp(EXTENSION[0], most(crosses_below));
        let ends = [first + way * from, first + way * to];
        let crossed = [crosses_above && along(ends[0]) < AT_JOINT, crosses_below && along(ends[1]) > 1.0 - AT_JOINT];
        let carried = [0, 1].map(|k| region.beside[k].filter(|_| crossed[k]).unwrap_or(region.joint));
        let outward = outward(sections, belly);
        let ends_rest = [0, 1].map(|k| {
            if crossed[k] {
                across_joint(region, k, on_bone(region, outward, &tips, (k, BESIDE_JOINT), ends[k]))
            } else {
                on_bone(region, outward, &tips, (k, BESIDE_BONE), ends[k])
            }
        });
        Line { name, degrees, ends_rest, reach: [from, to], crossed, carried }
    }
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
pub(super) fn axis(roots: &[DVec3]) -> (DVec3, DVec3) {
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
    let bend = bone.normalize_or_zero().reject_from(region.direction());
    let outside = (-beside.normalize_or_zero().dot(bend) / BENT).clamp(0.0, 1.0);
    joint + bone * (TENDON_SHARE[k] * (1.0 - outside)) + beside * TENDON_OFF
}

/// Half axes where the belly is thickest: medians of its thickest third.
pub(super) fn thickest(sections: &[Section], belly: &Belly) -> (f64, f64) {
    let mut axes: Vec<(f64, f64)> = belly
        .links
        .iter()
        .map(|l| &sections[l.section].ellipses[l.bump])
        .map(|ellipse| (ellipse.long, ellipse.short))
        .collect();
    axes.sort_by(|a, b| (b.0 * b.1).total_cmp(&(a.0 * a.1)));
    axes[axes.len() / 6]
}

/// Where a muscle ends beside its own bone: on the side that it is on, by a share at least of how far the skin is, for the line of
/// a root curve drawn on may pass through the bone.
fn on_bone(region: &Region, outward: DVec3, tips: &[DVec3], (k, share): (usize, f64), end: DVec3) -> DVec3 {
    let out = |p: DVec3| (p - region.ends_rest[0]).reject_from(region.direction()).dot(outward);
    let least = share * out(tips[k * (tips.len() - 1)]);
    end + outward * (least - out(end)).max(0.0)
}

/// Direction of the ellipses' long axis in the belly's middle, scene space at rest.
fn long_axis(sections: &[Section], belly: &Belly) -> DVec3 {
    let middle = belly.links[belly.links.len() / 2];
    let section = &sections[middle.section];
    let (sin, cos) = section.ellipses[middle.bump].angle.sin_cos();
    section.plane.axes[0] * cos + section.plane.axes[1] * sin
}

pub(super) fn attachment(joint: &crate::rig::Joint, place_rest: DVec3, normal_rest: DVec3) -> Attachment {
    let to_local: Mat4 = joint.inverse_bind;
    let normal: Vec3 = to_local.transform_vector3(normal_rest.as_vec3()).normalize_or(Vec3::X);
    Attachment { bone: joint.name.clone(), offset: to_local.transform_point3(place_rest.as_vec3()), normal }
}

/// From the bone to a belly's middle.
fn out_of_bone(sections: &[Section], belly: &Belly) -> DVec3 {
    let middle = belly.links[belly.links.len() / 2];
    let section = &sections[middle.section];
    section.tip_rest(middle.bump) - section.plane.origin_rest
}

/// A side, and what names end with on it.
pub(super) fn side_of(side: Option<Side>) -> (BodySide, &'static str) {
    match side {
        Some(Side::Left) => (BodySide::Left, "_l"),
        Some(Side::Right) => (BodySide::Right, "_r"),
        None => (BodySide::Centre, ""),
    }
}

/// Eccentricity of an ellipse of these half axes.
pub(super) fn eccentricity(long: f64, short: f64) -> f32 {
    let ratio = (short / long).clamp(0.2, 1.0);
    ((1.0 - ratio * ratio).sqrt() as f32).min(MAX_ECCENTRICITY)
}

/// A shape whose exponents are higher by `more`.
pub(super) fn shape(alpha: u32, beta: u32, eccentricity: f32, more: u32) -> MuscleShape {
    MuscleShape { alpha: alpha + more, beta: beta + more, eccentricity, width: 1.0 }
}

/// What muscles of a part and a side collide in.
pub(super) fn collision_group(part: &str, suffix: &str) -> String {
    format!("{part}{suffix}")
}

fn bone_name(bone: Bone) -> &'static str {
    match bone {
        Bone::UpperArm => "upper_arm",
        Bone::Forearm => "forearm",
        Bone::Thigh => "thigh",
        Bone::Shin => "shin",
    }
}
