//! What of a character's skin belongs to arms, legs, neck and head, and where the trunk between them is. By roles and weights; no
//! names are read.

use super::section::{Cut, Surface};
use crate::rig::{Character, groups::Side, roles::Roles};
use glam::DVec3;

/// A part of the body that a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Part {
    /// Pelvis, spine and clavicles.
    #[default]
    Trunk,
    /// Upper arm and below.
    Arm(Side),
    /// Thigh and below.
    Leg(Side),
    /// From the neck's first joint to the head.
    Neck,
    /// The head.
    Head,
}

/// A body that has a front, two arms and two legs.
#[derive(Clone, Debug)]
pub struct Body {
    /// Unit vectors: to the body's left, up, and ahead.
    pub left: DVec3,
    /// Unit vector from hips to shoulders.
    pub up: DVec3,
    /// Unit vector to where the feet point.
    pub ahead: DVec3,
    /// Shoulders, left and right, metres in scene space at rest; and likewise the rest.
    pub shoulders_rest: [DVec3; 2],
    /// Elbows.
    pub elbows_rest: [DVec3; 2],
    /// Hips.
    pub hips_rest: [DVec3; 2],
    /// Knees.
    pub knees_rest: [DVec3; 2],
    /// The neck's first joint and the head's, where there are any.
    pub neck_rest: Option<[DVec3; 2]>,
    /// Per joint the part that it moves.
    pub parts: Vec<Part>,
    /// Per joint the nearest one above it, or itself, that muscles may end on: no face, finger or breast.
    pub holds: Vec<u32>,
}

impl Body {
    /// The body of a character; `None` where it lacks arms, legs or a front.
    pub fn of(character: &Character, roles: &Roles) -> Option<Body> {
        let axes = roles.axes?;
        let (arms, legs) = (pair(&roles.arms)?, pair(&roles.legs)?);
        let joints = &character.joints;
        let place = |j: u32| joints[j as usize].bind().w_axis.truncate().as_dvec3();
        let moves_with = |j: u32| roles.moves_with.get(j as usize).copied().flatten();
        let up_from = |j: u32| std::iter::successors(Some(j), move |&j| moves_with(j));
        let chest = up_from(arms[0].upper).find(|&j| up_from(arms[1].upper).any(|other| other == j))?;
        let below = |j: u32, root: u32| up_from(j).any(|other| other == root);
        let up = axes.up.as_dvec3();
        // The neck begins where a branch of the chest leaves that has no arm, and goes up the most.
        let first = |j: u32| up_from(j).take_while(|&other| other != chest).last().filter(|_| below(j, chest));
        let shoulders = (place(arms[0].upper) + place(arms[1].upper)) * 0.5;
        let armless = |j: &u32| *j != chest && arms.iter().all(|arm| !below(*j, arm.upper) && !below(arm.upper, *j));
        let candidates = (0..joints.len() as u32).filter(armless).filter(|&j| (place(j) - shoulders).dot(up) > 0.0);
        let top = candidates.max_by(|&a, &b| place(a).dot(up).total_cmp(&place(b).dot(up)));
        let neck = top.and_then(first);
        let head = neck.map(|neck| head(character, roles, neck));
        let part = |j: u32| {
            let arm = arms.iter().find(|limb| below(j, limb.upper)).and_then(|limb| limb.side).map(Part::Arm);
            let leg = || legs.iter().find(|limb| below(j, limb.upper)).and_then(|limb| limb.side).map(Part::Leg);
            let head = || head.filter(|&head| below(j, head)).map(|_| Part::Head);
            let neck = || neck.filter(|&neck| below(j, neck)).map(|_| Part::Neck);
            arm.or_else(leg).or_else(head).or_else(neck).unwrap_or_default()
        };
        let mut structural = vec![false; joints.len()];
        let limbs = arms.iter().chain(&legs);
        let ends = limbs.flat_map(|limb| [Some(limb.lower), limb.end]).flatten().chain(head);
        ends.for_each(|end| up_from(end).for_each(|j| structural[j as usize] = true));
        let hold = |j: u32| up_from(j).find(|&j| structural[j as usize]).unwrap_or(j);
        Some(Body {
            left: axes.left.as_dvec3(),
            up,
            ahead: axes.forward.as_dvec3(),
            shoulders_rest: arms.map(|limb| limb.places[0].as_dvec3()),
            elbows_rest: arms.map(|limb| limb.places[1].as_dvec3()),
            hips_rest: legs.map(|limb| limb.places[0].as_dvec3()),
            knees_rest: legs.map(|limb| limb.places[1].as_dvec3()),
            neck_rest: neck.zip(head).map(|(neck, head)| [place(neck), place(head)]),
            parts: (0..joints.len() as u32).map(part).collect(),
            holds: (0..joints.len() as u32).map(hold).collect(),
        })
    }

    /// From hips to shoulders, metres.
    pub fn height(&self) -> f64 {
        (self.shoulder_rest() - self.hip_rest()).dot(self.up)
    }

    /// The middle between the shoulders.
    pub fn shoulder_rest(&self) -> DVec3 {
        (self.shoulders_rest[0] + self.shoulders_rest[1]) * 0.5
    }

    /// The middle between the hips.
    pub fn hip_rest(&self) -> DVec3 {
        (self.hips_rest[0] + self.hips_rest[1]) * 0.5
    }
}

/// The left and the right one of two limbs.
fn pair(limbs: &[crate::rig::roles::LimbRoles]) -> Option<[&crate::rig::roles::LimbRoles; 2]> {
    let of = |side: Side| limbs.iter().find(|limb| limb.side == Some(side));
    Some([of(Side::Left)?, of(Side::Right)?])
}

/// The joint above the neck's first one that branches or ends the way: the head.
fn head(character: &Character, roles: &Roles, neck: u32) -> u32 {
    let children =
        |j: u32| (0..character.joints.len() as u32).filter(move |&c| roles.moves_with[c as usize] == Some(j));
    let mut at = neck;
    while let (Some(only), 1) = (children(at).next(), children(at).count()) {
        // A leaf without skin only ends the bone before it.
        if children(only).next().is_none() && !has_skin(character, only) {
            break;
        }
        at = only;
    }
    at
}

fn has_skin(character: &Character, joint: u32) -> bool {
    character.influences.iter().any(|i| i.joint == joint && i.weight > 0.0)
}

/// How much of every vertex of a surface each part moves.
#[derive(Clone, Debug)]
pub struct Shares {
    /// Per vertex: trunk, left and right arm, left and right leg, neck, head.
    of: Vec<[f32; 7]>,
}

impl Shares {
    /// Of a character's surface.
    pub fn new(character: &Character, body: &Body, surface: &Surface) -> Shares {
        let one = |&source: &u32| {
            let mut shares = [0.0; 7];
            for influence in character.influences_of(source as usize) {
                shares[place(body.parts[influence.joint as usize])] += influence.weight;
            }
            shares
        };
        Shares { of: surface.sources.iter().map(one).collect() }
    }

    /// The share of a part at a point of a cut, 0..=1: the mean of its edge's ends.
    pub fn at(&self, cut: &Cut, point: usize, part: Part) -> f32 {
        let (a, b) = cut.edges[point];
        0.5 * (self.of[a as usize][place(part)] + self.of[b as usize][place(part)])
    }
}

fn place(part: Part) -> usize {
    match part {
        Part::Trunk => 0,
        Part::Arm(Side::Left) => 1,
        Part::Arm(Side::Right) => 2,
        Part::Leg(Side::Left) => 3,
        Part::Leg(Side::Right) => 4,
        Part::Neck => 5,
        Part::Head => 6,
    }
}
