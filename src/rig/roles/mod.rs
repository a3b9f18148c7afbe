//! What a skeleton's joints are for: arms and legs, their hinges, fingers, and which way the body faces.
//!
//! Found from the tree of joints and their places at rest, whatever they are called and whichever axis is up. Left and
//! right are two branches off one joint that reach alike; the two pairs that reach farthest are arms and legs, and those
//! that point away from the other pair are the legs. Feet point forward. A chain without a second one passes for an arm.

mod chain;
mod hinge;
mod reach;
#[cfg(test)]
mod tests;

pub use hinge::Hinge;

use super::Character;
use super::groups::Side;
use chain::Chain;
use glam::Vec3;
use reach::{Pair, Tree};

/// The second pair reaches at least this share of the first one: eyes and breasts are pairs too.
const LIMB_REACH: f32 = 0.3;
/// Two limbs whose directions have this cosine are parallel: legs, where there is no other pair to tell.
const PARALLEL: f32 = 0.7;
/// A foot or a knee is in front where it is by this share of the leg's reach.
const IN_FRONT: f32 = 0.01;
/// A joint that hangs elsewhere belongs to a leg's end where it is as near to it as this share of the thigh.
const ADOPTED: f32 = 0.6;

/// Unit vectors of the body at rest, in scene space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyAxes {
    /// From the hips to the shoulders.
    pub up: Vec3,
    /// Where the feet point.
    pub forward: Vec3,
    /// The character's left.
    pub left: Vec3,
}

/// An arm or a leg.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbRoles {
    /// Its side; `None` where there is no body to have sides.
    pub side: Option<Side>,
    /// The joint that carries the limb beside the trunk, where there is one: a clavicle.
    pub girdle: Option<u32>,
    /// The joint of the upper arm or the thigh.
    pub upper: u32,
    /// The joint of the forearm or the shin.
    pub lower: u32,
    /// The joint of the hand or the foot, where the limb has one.
    pub end: Option<u32>,
    /// Shoulder, elbow and wrist, or hip, knee and ankle, metres at rest.
    pub places: [Vec3; 3],
    /// Fingers or toes: their joints from the knuckle on. The thumb is not among them.
    pub digits: Vec<Vec<u32>>,
    /// The thumb, or what is like it.
    pub thumb: Option<Vec<u32>>,
}

/// What the joints of a character are for. All of it may be replaced by what is known better.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Roles {
    /// Where the body's front, left and top are; `None` where nothing tells.
    pub axes: Option<BodyAxes>,
    /// Arms, left before right.
    pub arms: Vec<LimbRoles>,
    /// Legs, left before right.
    pub legs: Vec<LimbRoles>,
    /// The joint that carries both legs and the trunk.
    pub pelvis: Option<u32>,
    /// The joint that each joint moves with: its parent, but for feet that the file hangs elsewhere.
    pub moves_with: Vec<Option<u32>>,
}

impl Roles {
    /// Finds them.
    pub fn find(character: &Character) -> Roles {
        let tree = Tree::new(character);
        let mut roles = Roles { moves_with: tree.parents(), ..Roles::default() };
        let pairs = tree.pairs();
        let Some(first) = pairs.first() else {
            roles.arms.extend(tree.longest_root().and_then(|root| limb(&tree, root)));
            return roles;
        };
        let second = pairs.get(1).filter(|second| second.reach > LIMB_REACH * first.reach);
        let (legs, arms) = match second {
            Some(second) if first.away_from(second) >= second.away_from(first) => (Some(first), Some(second)),
            Some(second) => (Some(second), Some(first)),
            None if first.parallel() > PARALLEL => (Some(first), None),
            None => (None, Some(first)),
        };
        let limbs = |pair: Option<&Pair>| -> Vec<LimbRoles> {
            pair.map_or_else(Vec::new, |pair| pair.members.iter().filter_map(|&joint| limb(&tree, joint)).collect())
        };
        (roles.legs, roles.arms) = (limbs(legs), limbs(arms));
        roles.pelvis = legs.and_then(|pair| pair.parent);
        let others: Vec<u32> = pairs.iter().flat_map(|pair| pair.members).collect();
        for leg in &mut roles.legs {
            if let Some(foot) = adopted(&tree, leg, &others) {
                leg.end = Some(foot);
                leg.places[2] = tree.places[foot as usize];
                roles.moves_with[foot as usize] = Some(leg.lower);
            }
        }
        roles.axes = axes(&tree, &roles, legs, arms);
        let left = roles.axes.map(|axes| axes.left);
        for limbs in [&mut roles.arms, &mut roles.legs] {
            let middle = limbs.iter().map(|limb| limb.places[1]).sum::<Vec3>() / limbs.len().max(1) as f32;
            for limb in limbs.iter_mut() {
                let to_left = left.map(|left| (limb.places[1] - middle).dot(left));
                limb.side = to_left.map(|to_left| if to_left > 0.0 { Side::Left } else { Side::Right });
            }
            limbs.sort_by_key(|limb| limb.side);
        }
        roles
    }
}

/// The limb that begins somewhere at, or below, a joint.
fn limb(tree: &Tree, root: u32) -> Option<LimbRoles> {
    let chain = Chain::below(tree, root)?;
    let (digits, thumb) = chain.digits(tree);
    Some(LimbRoles {
        side: None,
        girdle: Some(root).filter(|&root| root != chain.upper),
        upper: chain.upper,
        lower: chain.lower,
        end: chain.end,
        places: chain.places,
        digits,
        thumb,
    })
}

/// The foot of a leg that has none: one of the joints of pairs that lies at its end.
fn adopted(tree: &Tree, leg: &LimbRoles, others: &[u32]) -> Option<u32> {
    let [hip, knee, end] = leg.places;
    let near = |joint: &u32| tree.places[*joint as usize].distance(end);
    let elsewhere = others.iter().copied().filter(|&joint| leg.end.is_none() && !tree.is_above(joint, leg.lower));
    let foot =
        elsewhere.filter(|&joint| !tree.is_above(leg.upper, joint)).min_by(|a, b| near(a).total_cmp(&near(b)))?;
    (near(&foot) < ADOPTED * hip.distance(knee)).then_some(foot)
}

/// The body's axes: up from the legs to the arms, or along parallel legs, and forward where feet or knees are.
fn axes(tree: &Tree, roles: &Roles, legs: Option<&Pair>, arms: Option<&Pair>) -> Option<BodyAxes> {
    let legs = legs?;
    let across = legs.across();
    let across = match arms.map(Pair::across) {
        Some(arms) => across + arms * arms.dot(across).signum(),
        None => across,
    };
    let across = across.try_normalize()?;
    let up = arms.map_or(legs.middle() - legs.end(), |arms| arms.middle() - legs.middle());
    let up = up.reject_from_normalized(across).try_normalize()?;
    let ahead = across.cross(up);
    let in_front = |points: &dyn Fn(&LimbRoles) -> Option<Vec3>| {
        let sum: f32 = roles.legs.iter().filter_map(points).map(|offset| offset.dot(ahead)).sum();
        Some(sum).filter(|sum| sum.abs() > IN_FRONT * legs.reach)
    };
    let foot = |leg: &LimbRoles| leg.end.and_then(|end| Some(tree.skin_below(end)? - leg.places[2]));
    let knee = |leg: &LimbRoles| Some(leg.places[1] - (leg.places[0] + leg.places[2]) * 0.5);
    let sign = in_front(&foot).or_else(|| in_front(&knee))?;
    let forward = ahead * sign.signum();
    Some(BodyAxes { up, forward, left: up.cross(forward) })
}
