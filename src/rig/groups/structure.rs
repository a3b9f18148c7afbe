//! Owners of vertices, and merging of groups too small to have a field.

use super::names::BodyPart;
use super::parts::{Key, ancestors};
use crate::rig::Character;

/// Fewest vertices a group owns.
const LEAST_VERTICES: usize = 12;
/// Fewest triangles between vertices of one group.
const LEAST_TRIANGLES: usize = 8;
/// Shortest bone, as a share of the character's height, of a group that only the structure suggests.
const SHORT_BONE: f32 = 0.04;
/// A leaf of such a bone or shorter is merged where it has two leaf siblings or more: fingers, petals, strands.
const CLUSTER_BONE: f32 = 0.1;
/// Smallest patch area as a share of the square of the character's height.
const LEAST_AREA: f32 = 1e-6;

/// No group.
pub(super) const NONE: u32 = u32::MAX;

/// Groups while they are being merged: a group is known by a number that does not change.
pub(super) struct Merging<'a> {
    character: &'a Character,
    /// What each group is; several keys never share a number.
    pub keys: Vec<Key>,
    /// Number of the group of every joint, or [`NONE`].
    pub group_of_joint: Vec<u32>,
    /// Number of the group of every vertex, or [`NONE`].
    pub owner: Vec<u32>,
}

/// What a group has to fit a field to.
#[derive(Clone, Copy, Default)]
struct Patch {
    vertices: usize,
    triangles: usize,
    area: f32,
}

impl<'a> Merging<'a> {
    /// Starts with one group per key, in the order of their first joints.
    pub fn new(character: &'a Character, joint_keys: &[Option<Key>]) -> Merging<'a> {
        let mut keys: Vec<Key> = Vec::new();
        let mut group_of_joint = Vec::with_capacity(joint_keys.len());
        for key in joint_keys {
            group_of_joint.push(match key {
                None => NONE,
                Some(key) => keys.iter().position(|k| k == key).unwrap_or_else(|| {
                    keys.push(*key);
                    keys.len() - 1
                }) as u32,
            });
        }
        let mut merging = Merging { character, keys, group_of_joint, owner: Vec::new() };
        merging.own();
        merging
    }

    /// Gives every vertex to the group with the largest summed weight, the first of equals.
    fn own(&mut self) {
        let mut sums: Vec<(u32, f32)> = Vec::new();
        let character = self.character;
        self.owner = (0..character.vertex_count())
            .map(|v| {
                sums.clear();
                for influence in character.influences_of(v) {
                    let group = self.group_of_joint[influence.joint as usize];
                    match sums.iter_mut().find(|(g, _)| *g == group) {
                        Some((_, sum)) => *sum += influence.weight,
                        None => sums.push((group, influence.weight)),
                    }
                }
                let better = |best: (u32, f32), &(group, sum): &(u32, f32)| {
                    let wins = group != NONE && (sum > best.1 || (sum == best.1 && group < best.0));
                    if wins { (group, sum) } else { best }
                };
                sums.iter().fold((NONE, 0.0), better).0
            })
            .collect();
    }

    /// Whether a group still has joints.
    pub fn is_live(&self, group: u32) -> bool {
        self.group_of_joint.contains(&group)
    }

    /// The group above in the body, else the nearest group above in the skeleton.
    pub fn parent(&self, group: u32) -> Option<u32> {
        self.parent_in_body(group).or_else(|| self.parent_in_skeleton(group))
    }

    /// The nearest group up the body that exists and does not hang on this one in the skeleton.
    fn parent_in_body(&self, group: u32) -> Option<u32> {
        let Key::Body(part, side) = self.keys[group as usize] else { return None };
        let mut above = part.above();
        while let Some(part) = above {
            let key = Key::Body(part, if part.is_middle() { None } else { side });
            let found = self.keys.iter().position(|k| *k == key).map(|g| g as u32).filter(|&g| self.is_live(g));
            if let Some(found) = found {
                let mut up = Some(found);
                while let Some(g) = up {
                    if g == group {
                        return None;
                    }
                    up = self.parent_in_skeleton(g);
                }
                return Some(found);
            }
            above = part.above();
        }
        None
    }

    /// The group of the nearest ancestor of the group's first joint that belongs to another group.
    fn parent_in_skeleton(&self, group: u32) -> Option<u32> {
        let first = self.group_of_joint.iter().position(|&g| g == group)?;
        ancestors(self.character, first).map(|a| self.group_of_joint[a]).find(|&g| g != NONE && g != group)
    }

    /// Merges groups that cannot carry a field into their parents until every group can.
    pub fn settle(&mut self) {
        loop {
            let patches = self.patches();
            let live = (0..self.keys.len() as u32).filter(|&g| self.is_live(g));
            let weakest = live
                .filter(|&g| self.lacks_skin(patches[g as usize]) || self.is_short(g))
                .min_by_key(|&g| (patches[g as usize].vertices, u32::MAX - g));
            match weakest {
                Some(weakest) => self.merge(weakest, &patches),
                None => {
                    let bunch = self.bunched();
                    if bunch.is_empty() {
                        break;
                    }
                    bunch.iter().for_each(|&g| self.merge(g, &patches));
                }
            }
            self.own();
        }
    }

    /// Gives a group's joints to its parent, else to the child with most vertices, else to none.
    fn merge(&mut self, group: u32, patches: &[Patch]) {
        let children = (0..self.keys.len() as u32).filter(|&g| self.is_live(g) && self.parent(g) == Some(group));
        let heir = self.parent(group).or_else(|| children.max_by_key(|&g| patches[g as usize].vertices));
        for of_joint in self.group_of_joint.iter_mut().filter(|g| **g == group) {
            *of_joint = heir.unwrap_or(NONE);
        }
    }

    /// What every group has of the skin.
    fn patches(&self) -> Vec<Patch> {
        let mut patches = vec![Patch::default(); self.keys.len()];
        for &owner in self.owner.iter().filter(|&&o| o != NONE) {
            patches[owner as usize].vertices += 1;
        }
        for corners in &self.character.triangles {
            let [a, b, c] = corners.map(|v| v as usize);
            let owner = self.owner[a];
            if owner != NONE && owner == self.owner[b] && owner == self.owner[c] {
                let p = &self.character.positions_rest;
                let area = (p[b] - p[a]).cross(p[c] - p[a]).length() * 0.5;
                patches[owner as usize].triangles += 1;
                patches[owner as usize].area += if area.is_finite() { area } else { 0.0 };
            }
        }
        patches
    }

    /// Whether a patch has too little skin to fit a field to.
    fn lacks_skin(&self, patch: Patch) -> bool {
        let height = self.character.height_rest();
        patch.vertices < LEAST_VERTICES
            || patch.triangles < LEAST_TRIANGLES
            || patch.area <= LEAST_AREA * height * height
    }

    /// Whether only the structure suggests this group, and it hangs on another.
    fn is_structural(&self, group: u32) -> bool {
        matches!(self.keys[group as usize], Key::Own(_)) && self.parent(group).is_some()
    }

    /// Whether the bone of a structural group is too short to bend visibly.
    fn is_short(&self, group: u32) -> bool {
        self.is_structural(group) && self.bone_length(group) < SHORT_BONE * self.character.height_rest()
    }

    /// Structural leaves with small bones, three or more on one parent.
    fn bunched(&self) -> Vec<u32> {
        let live = || (0..self.keys.len() as u32).filter(|&g| self.is_live(g));
        let parents: Vec<Option<u32>> = live().map(|g| self.parent(g)).collect();
        let small: Vec<u32> = live()
            .filter(|&g| self.is_structural(g) && !parents.contains(&Some(g)))
            .filter(|&g| self.bone_length(g) < CLUSTER_BONE * self.character.height_rest())
            .collect();
        let siblings = |g: u32| small.iter().filter(|&&s| self.parent(s) == self.parent(g)).count();
        small.iter().copied().filter(|&g| siblings(g) > 2).collect()
    }

    /// Distance from the group's first joint to its farthest other joint or child group, or to its farthest vertex
    /// where it has neither, metres.
    fn bone_length(&self, group: u32) -> f32 {
        let joints = &self.character.joints;
        let position = |j: usize| joints[j].bind().w_axis.truncate();
        let Some(first) = self.group_of_joint.iter().position(|&g| g == group) else { return 0.0 };
        let below = (first + 1..joints.len())
            .filter(|&j| joints[j].parent.is_some_and(|p| self.group_of_joint[p as usize] == group))
            .map(|j| position(j).distance(position(first)))
            .fold(0.0, f32::max);
        if below > 0.0 {
            return below;
        }
        (0..self.owner.len())
            .filter(|&v| self.owner[v] == group)
            .map(|v| self.character.positions_rest[v].distance(position(first)))
            .fold(0.0, f32::max)
    }

    /// The readable name of a group.
    pub fn name(&self, group: u32) -> String {
        match self.keys[group as usize] {
            Key::Own(joint) => self.character.joints[joint as usize].name.clone(),
            Key::Body(part, side) => match side {
                None => part.name().to_owned(),
                Some(super::Side::Left) => format!("{}_l", part.name()),
                Some(super::Side::Right) => format!("{}_r", part.name()),
            },
        }
    }

    /// The part of the body a group is.
    pub fn part(&self, group: u32) -> Option<BodyPart> {
        match self.keys[group as usize] {
            Key::Body(part, _) => Some(part),
            Key::Own(_) => None,
        }
    }
}
