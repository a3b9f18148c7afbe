//! The planes across a character's limbs (prototypes 2), from where its joints are: shoulder, elbow, wrist, hip, knee, ankle.

use super::{
    chain::{Belly, Section, Settings, bellies, link},
    muscle::Found,
    section::{Cut, Plane, Surface, cut},
    stretch,
    window::Outline,
};
use crate::rig::{
    Character,
    groups::Side,
    roles::{Hinge, LimbRoles, Roles},
};
use glam::{DVec2, DVec3};

/// Planes across a bone.
pub const PLANES: usize = 33;
/// The first and the last plane, in lengths of the bone.
const FIRST: f64 = 0.02;
/// A loop longer than this many medians goes round more than the limb.
const LONGEST: f64 = 1.6;
/// A belly whose tips are bent more than this is a bone's ridge under the skin.
const RIDGE: f64 = 2.6;
/// A belly whose peak is nearer to a joint than this, in lengths of the bone, is the joint's own shape.
const JOINT_ZONE: f64 = 0.09;

/// Where bumps are found by direct variation they stand out by this at least in the mean, perimeters.
const LEAST_MEAN_VARIATION: f64 = 0.002;
/// What runs into a joint and is bent more than this in the mean is the joint's: a kneecap.
const JOINT_SHARPNESS: f64 = 1.5;
/// A muscle's belly is at least this long, in lengths of the bone: those of limbs are a quarter to nine tenths.
const LEAST_SHARE: f64 = 0.25;

/// Which long bone it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Bone {
    /// From shoulder to elbow.
    UpperArm,
    /// From elbow to wrist.
    Forearm,
    /// From hip to knee.
    Thigh,
    /// From knee to ankle.
    Shin,
}

/// A long bone with the skin around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Which bone.
    pub bone: Bone,
    /// Its side, where the body has sides.
    pub side: Option<Side>,
    /// The joint that it turns with.
    pub joint: u32,
    /// The joint above it and the one below, where there are some.
    pub beside: [Option<u32>; 2],
    /// The far ends of the long bones above and below, where those are long bones too, metres in scene space at rest.
    pub far_rest: [Option<DVec3>; 2],
    /// Its ends, metres in scene space at rest.
    pub ends_rest: [DVec3; 2],
    /// The direction from which angles around it are counted: the body's front, or any.
    pub front: DVec3,
}

impl Region {
    /// The long bones of a character's limbs, arms first.
    pub fn of(character: &Character, roles: &Roles) -> Vec<Region> {
        let front = roles.axes.map_or(DVec3::Z, |axes| axes.forward.as_dvec3());
        let bones = |limb: &LimbRoles, bones: [Bone; 2]| {
            let places = limb.places.map(|p| p.as_dvec3());
            let above = character.joints[limb.upper as usize].parent;
            [
                Region {
                    bone: bones[0],
                    side: limb.side,
                    joint: limb.upper,
                    beside: [above, Some(limb.lower)],
                    far_rest: [None, Some(places[2])],
                    ends_rest: [places[0], places[1]],
                    front,
                },
                Region {
                    bone: bones[1],
                    side: limb.side,
                    joint: limb.lower,
                    beside: [Some(limb.upper), limb.end],
                    far_rest: [Some(places[0]), None],
                    ends_rest: [places[1], places[2]],
                    front,
                },
            ]
        };
        let arms = roles.arms.iter().flat_map(|limb| bones(limb, [Bone::UpperArm, Bone::Forearm]));
        let legs = roles.legs.iter().flat_map(|limb| bones(limb, [Bone::Thigh, Bone::Shin]));
        arms.chain(legs).filter(|region| region.length() > 1e-6).collect()
    }

    /// Metres.
    pub fn length(&self) -> f64 {
        self.ends_rest[0].distance(self.ends_rest[1])
    }

    /// Unit vector from its upper end to the lower one.
    pub fn direction(&self) -> DVec3 {
        (self.ends_rest[1] - self.ends_rest[0]).normalize()
    }

    /// Where around the bone a point is, degrees: 0 in front, 90 outside, 180 behind, -90 inside.
    pub fn degrees(&self, roles: &Roles, p: DVec3) -> f64 {
        let out = (p - self.ends_rest[0]).reject_from(self.direction());
        let left = roles.axes.map_or(self.front.cross(self.direction()), |axes| axes.left.as_dvec3());
        let outside = if self.side == Some(Side::Right) { -left } else { left };
        out.dot(outside).atan2(out.dot(self.front)).to_degrees()
    }

    /// The elbow or the knee at one of its ends.
    pub fn hinge(&self, roles: &Roles) -> Option<Hinge> {
        let is_own = |limb: &&LimbRoles| limb.upper == self.joint || limb.lower == self.joint;
        let axes = roles.axes.as_ref();
        match self.bone {
            Bone::UpperArm | Bone::Forearm => roles.arms.iter().find(is_own).and_then(|arm| arm.elbow(axes)),
            Bone::Thigh | Bone::Shin => roles.legs.iter().find(is_own).and_then(|leg| leg.knee(axes)),
        }
    }

    /// Which of its ends that is: 0 the upper one.
    pub fn hinge_end(&self) -> usize {
        usize::from(matches!(self.bone, Bone::UpperArm | Bone::Thigh))
    }

    /// How its outlines are smoothed and its bumps linked.
    pub fn settings(&self) -> Settings {
        match self.bone {
            Bone::UpperArm | Bone::Forearm => Settings::ARM,
            Bone::Thigh => Settings::THIGH,
            Bone::Shin => Settings::SHIN,
        }
    }
}

/// What a belly is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// A muscle.
    Muscle,
    /// A bone's ridge under the skin.
    Ridge,
    /// A joint's own shape.
    Joint,
    /// A swelling too short for a muscle of the bone: fat, a tendon, or a coarse mesh's facets.
    Short,
    /// A muscle because a person marked it.
    Marked,
    /// Bone by its place on the trunk: ribs, hips, clavicles, spine.
    Bone,
}

/// Cuts the skin across a region, and finds the bellies in its outlines.
pub fn search(surface: &Surface, region: &Region) -> Found {
    let settings = region.settings();
    let plane = |k: usize| {
        let share = FIRST + (1.0 - 2.0 * FIRST) * k as f64 / (PLANES - 1) as f64;
        let origin = region.ends_rest[0].lerp(region.ends_rest[1], share);
        Plane::across(origin, region.direction(), region.front)
    };
    let cuts: Vec<(usize, Plane, Cut)> = (0..PLANES)
        .filter_map(|k| {
            let plane = plane(k);
            let round = cut(surface, &plane).into_iter().filter(|cut| cut.surrounds(DVec2::ZERO));
            round.min_by(|a, b| a.length().total_cmp(&b.length())).map(|cut| (k, plane, cut))
        })
        .collect();
    let mut lengths: Vec<f64> = cuts.iter().map(|(.., cut)| cut.length()).collect();
    lengths.sort_by(f64::total_cmp);
    let longest = lengths.get(lengths.len() / 2).map_or(0.0, |median| median * LONGEST);
    let limb = cuts.iter().filter(|(.., cut)| cut.length() <= longest);
    let sections: Vec<Section> =
        limb.filter_map(|(k, plane, cut)| Section::new(*k, *plane, &Outline::whole(cut), &settings).ok()).collect();
    let chains = link(&sections, &settings);
    let bellies = chains.iter().flat_map(|chain| match settings.variation {
        Some(_) => {
            let found = stretch::parted(&sections, chain, None);
            found.into_iter().filter(|belly| belly.prominence > LEAST_MEAN_VARIATION).collect()
        }
        None => bellies(&sections, chain),
    });
    let bellies: Vec<(Belly, Verdict)> = bellies
        .map(|belly| {
            let verdict = judge(&sections, &belly, region);
            (belly, verdict)
        })
        .collect();
    Found { rejected: PLANES - sections.len(), sections, bellies }
}

/// What a belly is: the body's bones and joints stand out more than its muscles do.
fn judge(sections: &[Section], belly: &Belly, region: &Region) -> Verdict {
    let share =
        |k: usize| FIRST + (1.0 - 2.0 * FIRST) * sections[belly.links[k].section].number as f64 / (PLANES - 1) as f64;
    let last = belly.links.len() - 1;
    let is_at_joint = match region.settings().variation {
        // What stands out across has no peak along: at a joint it is the joint's where it is sharp.
        Some(_) => share(0).min(1.0 - share(last)) < JOINT_ZONE && belly.sharpness > JOINT_SHARPNESS,
        None => {
            let (_, out) = belly.reach(sections);
            let above = |k: usize| out[k] - (out[0] + (out[last] - out[0]) * k as f64 / last as f64);
            let peak = (0..=last).max_by(|&a, &b| above(a).total_cmp(&above(b))).unwrap_or(0);
            share(peak).min(1.0 - share(peak)) < JOINT_ZONE
        }
    };
    if belly.length < LEAST_SHARE * region.length() {
        Verdict::Short
    } else if belly.sharpness > RIDGE {
        Verdict::Ridge
    } else if is_at_joint && belly.length < 0.5 * region.length() {
        Verdict::Joint
    } else {
        Verdict::Muscle
    }
}
