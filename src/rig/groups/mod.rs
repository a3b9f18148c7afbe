//! Field groups: the joints that share one field, the vertices each group owns, and the fields themselves.
//!
//! Names come first (sixteen groups on a human body: pelvis with the lower spine, chest with clavicles, neck, head, and
//! per side upper arm, forearm, hand, thigh, calf, foot); a joint of unknown name stands for itself. Groups with too
//! little skin, and unknown bones too short to bend visibly, then merge into their parents.

mod fields;
mod names;
mod parts;
mod shape;
mod structure;

pub use fields::{FieldOptions, Fields, FitReport, build_fields};
pub use names::{BodyPart, Side};

use crate::rig::Character;
use structure::{Merging, NONE};

/// Joints that share one field.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Readable and unique: `upperarm_l`, `chest`, or the joint's own name.
    pub name: String,
    /// The joint that drives the field: the one with most of the group's vertices.
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
        let keys = parts::keys(character);
        let mut merging = Merging::new(character, &keys);
        merging.settle();

        let first_joint = |g: u32| merging.group_of_joint.iter().position(|&o| o == g);
        let mut live: Vec<u32> = (0..merging.keys.len() as u32).filter(|&g| merging.is_live(g)).collect();
        live.sort_by_key(|&g| first_joint(g));
        let renumber = |g: u32| live.iter().position(|&l| l == g).map_or(NONE, |k| k as u32);
        let owner: Vec<u32> = merging.owner.iter().map(|&o| renumber(o)).collect();
        let group_of_joint: Vec<u32> = merging.group_of_joint.iter().map(|&g| renumber(g)).collect();
        let mut groups: Vec<Group> = live
            .iter()
            .enumerate()
            .map(|(k, &g)| Group {
                name: unique_name(&merging, &live, g),
                joint: driver(character, &owner, &group_of_joint, k as u32),
                joints: (0..group_of_joint.len() as u32).filter(|&j| group_of_joint[j as usize] == k as u32).collect(),
                parent: merging.parent(g).map(renumber),
                passive: merging.part(g).is_some_and(BodyPart::is_end),
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
        FieldGroups { groups, group_of_joint, owner }
    }

    /// The groups that hang on group `g`.
    pub fn children(&self, g: u32) -> impl Iterator<Item = u32> {
        (0..self.groups.len() as u32).filter(move |&c| self.groups[c as usize].parent == Some(g))
    }
}

/// The group's name, with its number where another group has the same.
fn unique_name(merging: &Merging, live: &[u32], group: u32) -> String {
    let name = merging.name(group);
    if live.iter().any(|&g| g != group && merging.name(g) == name) { format!("{name}_{group}") } else { name }
}

/// The joint of group `g` that is the strongest of the group's in most of its vertices, the first of equals.
fn driver(character: &Character, owner: &[u32], group_of_joint: &[u32], g: u32) -> u32 {
    let mut votes = vec![0_u32; group_of_joint.len()];
    for v in (0..owner.len()).filter(|&v| owner[v] == g) {
        let of_group = |i: &&crate::rig::Influence| group_of_joint[i.joint as usize] == g;
        if let Some(strongest) = character.influences_of(v).iter().find(of_group) {
            votes[strongest.joint as usize] += 1;
        }
    }
    let joints = (0..votes.len()).filter(|&j| group_of_joint[j] == g);
    joints.rev().max_by_key(|&j| votes[j]).map_or(0, |j| j as u32)
}
