//! Field groups: the joints that share one field, the vertices each group owns, and the fields themselves.
//!
//! Names come first (fifteen groups on a human body: the trunk from pelvis to clavicles, neck, head, and
//! per side upper arm, forearm, hand, thigh, calf, foot); a joint of unknown name stands for itself. Groups with too
//! little skin, and unknown bones too short to bend visibly, then merge into their parents;
//! where more than 64 are left, so do the smallest. A muscle file may give groups of its own ([`GroupSpec`]).

mod fields;
mod given;
mod hinges;
mod names;
mod parts;
mod shape;
mod structure;

pub use fields::{FieldOptions, Fields, FitReport, build_fields};
pub use given::GroupSpec;
pub use hinges::{FoldRest, Swing};
pub use names::{BodyPart, Side};

use crate::error::GroupError;
use crate::rig::Character;
use given::Given;
use parts::Key;
use structure::{Merging, NONE};

/// A joint moves a group in earnest where it has this share of the group's skin.
const EARNEST_SHARE: f64 = 0.01;

/// Joints that share one field.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Readable and unique: `upperarm_l`, `trunk`, or the joint's own name.
    pub name: String,
    /// The joint that drives the field: in most groups the one with the largest share of the group's skin.
    pub joint: u32,
    /// All joints of the group, ascending.
    pub joints: Vec<u32>,
    /// Index of the group it hangs on.
    pub parent: Option<u32>,
    /// Whether vertices bound almost wholly to the group follow linear skinning: heads, hands and feet.
    pub passive: bool,
    /// The part of the body, where names say so.
    pub part: Option<BodyPart>,
}

/// All field groups of a character.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldGroups {
    /// The groups, ordered by their first joint. Empty where the skin is too small for any field.
    pub groups: Vec<Group>,
    /// Group of every joint; `u32::MAX` for joints that move no vertex and belong to none.
    pub group_of_joint: Vec<u32>,
    /// Group of every vertex: the one with the largest summed weight; `u32::MAX` where no group moves it.
    pub owner: Vec<u32>,
}

impl FieldGroups {
    /// Finds the groups of any skeleton.
    pub fn detect(character: &Character) -> FieldGroups {
        FieldGroups::merged(character, &parts::keys(character), &[]).0
    }

    /// Finds the groups of any skeleton beside those that are given.
    ///
    /// # Errors
    /// A joint that the character lacks or that two groups have; a group without joints, or with too little skin.
    pub fn detect_beside(character: &Character, given: &[GroupSpec]) -> Result<FieldGroups, GroupError> {
        let mut keys = parts::keys(character);
        let given = given::give(character, given, &mut keys)?;
        match FieldGroups::merged(character, &keys, &given) {
            (_, Some(bare)) => Err(GroupError::Bare { group: bare.entry.clone(), joints: bare.name.clone() }),
            (groups, None) => Ok(groups),
        }
    }

    /// The groups, and a given one that could not become one.
    fn merged<'a>(
        character: &'a Character,
        keys: &[Option<Key>],
        given: &'a [Given],
    ) -> (FieldGroups, Option<&'a Given>) {
        let mut merging = Merging::new(character, keys, given);
        merging.settle();
        let mut live: Vec<u32> = (0..merging.keys.len() as u32).filter(|&g| merging.is_live(g)).collect();
        live.sort_by_key(|&g| merging.first_joint(g));
        let mut numbers = vec![NONE; merging.keys.len()];
        for (k, &g) in (0..).zip(&live) {
            numbers[g as usize] = k;
        }
        let renumber = |g: u32| numbers.get(g as usize).copied().unwrap_or(NONE);
        let owner: Vec<u32> = merging.owner.iter().map(|&o| renumber(o)).collect();
        let group_of_joint: Vec<u32> = merging.group_of_joint.iter().map(|&g| renumber(g)).collect();
        let areas = vertex_areas(character);
        let mut groups: Vec<Group> = live
            .iter()
            .enumerate()
            .map(|(k, &g)| Group {
                name: unique_name(&merging, &live, g),
                joint: driver(character, &areas, &owner, &group_of_joint, k as u32, merging.part(g)),
                joints: (0..group_of_joint.len() as u32).filter(|&j| group_of_joint[j as usize] == k as u32).collect(),
                parent: merging.parent(g).map(renumber),
                passive: merging
                    .given(g)
                    .and_then(|given| given.passive)
                    .unwrap_or(merging.part(g).is_some_and(BodyPart::is_end)),
                part: merging.part(g),
            })
            .collect();
        for k in 0..groups.len() {
            let up = std::iter::successors(groups[k].parent, |&p| groups[p as usize].parent);
            // Body and skeleton can disagree in a circle; it is cut where it is first seen.
            if up.take(groups.len()).any(|p| p == k as u32) {
                groups[k].parent = None;
            }
        }
        (FieldGroups { groups, group_of_joint, owner }, merging.bare())
    }

    /// The groups that hang on group `g`.
    pub fn children(&self, g: u32) -> impl Iterator<Item = u32> {
        (0..self.groups.len() as u32).filter(move |&c| self.groups[c as usize].parent == Some(g))
    }
}

/// The group's name, with its number where another group has the same.
fn unique_name(merging: &Merging, live: &[u32], group: u32) -> String {
    let name = merging.name(group);
    // A given name stays; of two that are given alike the first does.
    let has = |&&g: &&u32| g != group && merging.name(g) == name;
    let first = live.iter().filter(has).all(|&g| merging.given(g).is_none() || g > group);
    if live.iter().any(|g| has(&g)) && !(merging.given(group).is_some() && first) {
        format!("{name}_{group}")
    } else {
        name
    }
}

/// The joint of group `g` that drives its field.
///
/// The one with the largest share of the group's skin, the first of equals. Heads, hands and feet have many joints that
/// lie close together and take the first that moves skin in earnest.
fn driver(
    character: &Character,
    areas: &[f32],
    owner: &[u32],
    group_of_joint: &[u32],
    g: u32,
    part: Option<BodyPart>,
) -> u32 {
    let mut shares = vec![0.0_f64; group_of_joint.len()];
    for v in (0..owner.len()).filter(|&v| owner[v] == g) {
        for influence in character.influences_of(v).iter().filter(|i| group_of_joint[i.joint as usize] == g) {
            shares[influence.joint as usize] += f64::from(areas[v] * influence.weight);
        }
    }
    let total: f64 = shares.iter().sum();
    let all = || (0..shares.len()).filter(|&j| group_of_joint[j] == g);
    let earnest = |j: &usize| shares[*j] > EARNEST_SHARE * total;
    let largest = |joints: &mut dyn DoubleEndedIterator<Item = usize>| {
        joints.rev().max_by(|&a, &b| shares[a].total_cmp(&shares[b]))
    };
    let preferred = match part {
        Some(part) if part.is_end() => all().find(earnest),
        _ => None,
    };
    preferred.or_else(|| largest(&mut all())).map_or(0, |j| j as u32)
}

/// A third of the area of the triangles around every vertex, square metres.
fn vertex_areas(character: &Character) -> Vec<f32> {
    let mut areas = vec![0.0; character.vertex_count()];
    for corners in &character.triangles {
        let [a, b, c] = corners.map(|v| character.positions_rest[v as usize]);
        let area = (b - a).cross(c - a).length() / 6.0;
        for &v in corners {
            areas[v as usize] += if area.is_finite() { area } else { 0.0 };
        }
    }
    areas
}

#[cfg(test)]
mod tests;
