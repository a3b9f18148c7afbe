//! Owners of vertices, and merging of groups too small to have a field.

use super::given::Given;
use super::names::{BodyPart, Side};
use super::parts::Key;
use crate::rig::Character;
use glam::Vec3;
use std::collections::BTreeMap;

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

/// Most groups a character has. A body has sixteen; odd rigs have thousands of joints, and each group costs a grid and
/// a share of every step's work. Beyond this the groups with fewest vertices merge into their parents.
pub(super) const MOST_GROUPS: usize = 64;

/// Groups while they are being merged: a group is known by a number that does not change.
///
/// Merging moves one group's joints, so everything derived from the joints is kept and updated for what it touches.
pub(super) struct Merging<'a> {
    character: &'a Character,
    height: f32,
    given: &'a [Given],
    /// What each group is; several keys never share a number.
    pub keys: Vec<Key>,
    /// Number of the group of every joint, or [`NONE`].
    pub group_of_joint: Vec<u32>,
    /// Number of the group of every vertex, or [`NONE`].
    pub owner: Vec<u32>,
    /// The groups that are, or stand for, parts of the body.
    body: Vec<u32>,
    /// Joints of every group, in no order.
    joints: Vec<Vec<u32>>,
    /// The first joint of every group.
    first: Vec<u32>,
    patches: Vec<Patch>,
    /// [`Self::measure_bone`] of every group, where it is known.
    bones: Vec<Option<f32>>,
    /// Where every joint is at rest.
    places: Vec<Vec3>,
    /// The nearest ancestor of every joint that had a group at the start.
    above: Vec<Option<u32>>,
    children: Vec<Vec<u32>>,
    vertices_of_joint: Vec<Vec<u32>>,
    triangles_of_vertex: Vec<Vec<u32>>,
}

/// What a group has to fit a field to.
#[derive(Clone, Copy, Default)]
struct Patch {
    vertices: usize,
    triangles: usize,
    area: f64,
}

impl<'a> Merging<'a> {
    /// Starts with one group per key, in the order of their first joints.
    pub fn new(character: &'a Character, joint_keys: &[Option<Key>], given: &'a [Given]) -> Merging<'a> {
        let count = character.joints.len();
        let mut numbers: BTreeMap<Key, u32> = BTreeMap::new();
        let mut merging = Merging {
            character,
            height: character.height_rest(),
            given,
            keys: Vec::new(),
            group_of_joint: Vec::with_capacity(count),
            owner: vec![NONE; character.vertex_count()],
            body: Vec::new(),
            joints: Vec::new(),
            first: Vec::new(),
            patches: Vec::new(),
            bones: Vec::new(),
            places: character.joints.iter().map(|j| j.bind().w_axis.truncate()).collect(),
            above: Vec::with_capacity(count),
            children: vec![Vec::new(); count],
            vertices_of_joint: vec![Vec::new(); count],
            triangles_of_vertex: vec![Vec::new(); character.vertex_count()],
        };
        for (j, key) in (0..).zip(joint_keys) {
            let group = key.map_or(NONE, |key| {
                *numbers.entry(key).or_insert_with(|| {
                    merging.keys.push(key);
                    merging.joints.push(Vec::new());
                    merging.first.push(j);
                    merging.keys.len() as u32 - 1
                })
            });
            merging.group_of_joint.push(group);
            if group != NONE {
                merging.joints[group as usize].push(j);
            }
            let parent = character.joints[j as usize].parent;
            merging.above.push(parent.and_then(|p| match merging.group_of_joint[p as usize] {
                NONE => merging.above[p as usize],
                _ => Some(p),
            }));
            if let Some(parent) = parent {
                merging.children[parent as usize].push(j);
            }
        }
        let groups = merging.keys.len();
        merging.body = (0..groups as u32).filter(|&g| merging.body_of(g).is_some()).collect();
        merging.patches = vec![Patch::default(); groups];
        merging.bones = vec![None; groups];
        for v in 0..character.vertex_count() {
            for influence in character.influences_of(v) {
                merging.vertices_of_joint[influence.joint as usize].push(v as u32);
            }
        }
        for (t, corners) in (0..).zip(&character.triangles) {
            for (k, &v) in corners.iter().enumerate() {
                if !corners[..k].contains(&v) {
                    merging.triangles_of_vertex[v as usize].push(t);
                }
            }
        }
        for v in 0..character.vertex_count() as u32 {
            merging.own(v);
        }
        merging
    }

    /// Gives a vertex to the group with the largest summed weight, the first of equals.
    fn own(&mut self, v: u32) {
        let mut sums: Vec<(u32, f32)> = Vec::new();
        for influence in self.character.influences_of(v as usize) {
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
        let owner = sums.iter().fold((NONE, 0.0), better).0;
        if owner != self.owner[v as usize] {
            self.count(v, false);
            self.owner[v as usize] = owner;
            self.count(v, true);
        }
    }

    /// Adds a vertex and the triangles that it completes to its owner's patch, or takes them away.
    fn count(&mut self, v: u32, add: bool) {
        let owner = self.owner[v as usize];
        if owner == NONE {
            return;
        }
        let mut change = Patch { vertices: 1, ..Patch::default() };
        for &t in &self.triangles_of_vertex[v as usize] {
            let corners = self.character.triangles[t as usize].map(|v| v as usize);
            if corners.iter().all(|&c| self.owner[c] == owner) {
                let [a, b, c] = corners.map(|c| self.character.positions_rest[c]);
                let area = (b - a).cross(c - a).length() * 0.5;
                change.triangles += 1;
                change.area += if area.is_finite() { f64::from(area) } else { 0.0 };
            }
        }
        let patch = &mut self.patches[owner as usize];
        if add {
            patch.vertices += change.vertices;
            patch.triangles += change.triangles;
            patch.area += change.area;
        } else {
            patch.vertices -= change.vertices;
            patch.triangles -= change.triangles;
            patch.area -= change.area;
        }
        self.bones[owner as usize] = None;
    }

    /// Whether a group still has joints.
    pub fn is_live(&self, group: u32) -> bool {
        !self.joints[group as usize].is_empty()
    }

    /// Numbers of the groups that still have joints, ascending.
    fn live(&self) -> impl Iterator<Item = u32> {
        (0..self.keys.len() as u32).filter(|&g| self.is_live(g))
    }

    /// The first joint of a live group.
    pub fn first_joint(&self, group: u32) -> u32 {
        self.first[group as usize]
    }

    /// The group above in the body, else the nearest group above in the skeleton.
    pub fn parent(&self, group: u32) -> Option<u32> {
        let above = self.parent_in_skeleton(group);
        // What the file puts together stands where it hangs.
        let given = above.is_some_and(|g| matches!(self.keys[g as usize], Key::Given(_)));
        if given { above } else { self.parent_in_body(group).or(above) }
    }

    /// The part of the body that a group is, or stands for, and its side.
    fn body_of(&self, group: u32) -> Option<(BodyPart, Option<Side>)> {
        match self.keys[group as usize] {
            Key::Body(part, side) => Some((part, side)),
            Key::Given(given) => self.given[given as usize].body,
            Key::Own(_) => None,
        }
    }

    /// The nearest group up the body that exists and does not hang on this one in the skeleton.
    fn parent_in_body(&self, group: u32) -> Option<u32> {
        let (part, side) = self.body_of(group)?;
        let mut above = part.above();
        while let Some(part) = above {
            let body = Some((part, if part.is_middle() { None } else { side }));
            let found = self.body.iter().copied().find(|&g| self.body_of(g) == body && self.is_live(g));
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

    /// The group of the nearest ancestor of the group's first joint that belongs to a group. It is another one: parents
    /// precede their children.
    fn parent_in_skeleton(&self, group: u32) -> Option<u32> {
        if !self.is_live(group) {
            return None;
        }
        let above = |j: u32| self.above[j as usize];
        let mut up = std::iter::successors(above(self.first[group as usize]), |&j| above(j));
        up.find_map(|j| Some(self.group_of_joint[j as usize]).filter(|&g| g != NONE))
    }

    /// Merges groups that cannot carry a field into their parents until every group can, then the smallest of too many.
    pub fn settle(&mut self) {
        loop {
            for g in 0..self.keys.len() as u32 {
                if self.bones[g as usize].is_none() && self.is_structural(g) {
                    self.bones[g as usize] = Some(self.measure_bone(g));
                }
            }
            let smallness = |&g: &u32| (self.patches[g as usize].vertices, u32::MAX - g);
            let weak = |g: &u32| self.lacks_skin(self.patches[*g as usize]) || self.is_short(*g);
            let weakest = self.live().filter(weak).min_by_key(smallness);
            let bunch = match weakest {
                Some(weakest) => vec![weakest],
                None => self.bunched(),
            };
            if !bunch.is_empty() {
                bunch.iter().for_each(|&g| self.merge(g));
            } else if self.live().count() > MOST_GROUPS {
                let found = |g: &u32| !matches!(self.keys[*g as usize], Key::Given(_));
                let Some(smallest) = self.live().filter(found).min_by_key(smallness) else { break };
                self.merge(smallest);
            } else {
                break;
            }
        }
    }

    /// Gives a group's joints to its parent, else to the child with most vertices, else to none.
    fn merge(&mut self, group: u32) {
        let heir = self.parent(group).or_else(|| {
            let children = self.live().filter(|&g| self.parent(g) == Some(group));
            children.max_by_key(|&g| self.patches[g as usize].vertices)
        });
        let joints = std::mem::take(&mut self.joints[group as usize]);
        for &j in &joints {
            self.group_of_joint[j as usize] = heir.unwrap_or(NONE);
        }
        for &j in &joints {
            for k in 0..self.vertices_of_joint[j as usize].len() {
                self.own(self.vertices_of_joint[j as usize][k]);
            }
        }
        if let Some(heir) = heir.map(|h| h as usize) {
            self.first[heir] = self.first[heir].min(self.first[group as usize]);
            self.joints[heir].extend(joints);
            self.bones[heir] = None;
        }
    }

    /// Whether a patch has too little skin to fit a field to.
    fn lacks_skin(&self, patch: Patch) -> bool {
        patch.vertices < LEAST_VERTICES
            || patch.triangles < LEAST_TRIANGLES
            || patch.area <= f64::from(LEAST_AREA * self.height * self.height)
    }

    /// Whether only the structure suggests this group, and it hangs on another.
    fn is_structural(&self, group: u32) -> bool {
        matches!(self.keys[group as usize], Key::Own(_)) && self.parent(group).is_some()
    }

    /// Whether the bone of a structural group is too short to bend visibly.
    fn is_short(&self, group: u32) -> bool {
        self.is_structural(group) && self.bone_length(group) < SHORT_BONE * self.height
    }

    /// Structural leaves with small bones, three or more on one parent.
    fn bunched(&self) -> Vec<u32> {
        let parents: Vec<Option<u32>> =
            (0..self.keys.len() as u32).map(|g| self.parent(g).filter(|_| self.is_live(g))).collect();
        let mut has_child = vec![false; self.keys.len()];
        parents.iter().flatten().for_each(|&p| has_child[p as usize] = true);
        let mut small: Vec<u32> = self
            .live()
            .filter(|&g| self.is_structural(g) && !has_child[g as usize])
            .filter(|&g| self.bone_length(g) < CLUSTER_BONE * self.height)
            .collect();
        let mut siblings = vec![0_usize; self.keys.len()];
        small.iter().filter_map(|&g| parents[g as usize]).for_each(|p| siblings[p as usize] += 1);
        small.retain(|&g| parents[g as usize].is_some_and(|p| siblings[p as usize] > 2));
        small
    }

    /// The kept length of a bone, measured anew where it is not known.
    fn bone_length(&self, group: u32) -> f32 {
        self.bones[group as usize].unwrap_or_else(|| self.measure_bone(group))
    }

    /// Distance from the group's first joint to its farthest other joint or child group, or to its farthest vertex
    /// where it has neither, metres.
    fn measure_bone(&self, group: u32) -> f32 {
        let joints = &self.joints[group as usize];
        let start = self.places[self.first[group as usize] as usize];
        let below = joints
            .iter()
            .flat_map(|&j| &self.children[j as usize])
            .map(|&j| self.places[j as usize].distance(start))
            .fold(0.0, f32::max);
        if below > 0.0 {
            return below;
        }
        joints
            .iter()
            .flat_map(|&j| &self.vertices_of_joint[j as usize])
            .filter(|&&v| self.owner[v as usize] == group)
            .map(|&v| self.character.positions_rest[v as usize].distance(start))
            .fold(0.0, f32::max)
    }

    /// The readable name of a group.
    pub fn name(&self, group: u32) -> String {
        match self.keys[group as usize] {
            Key::Own(joint) => self.character.joints[joint as usize].name.clone(),
            Key::Given(given) => self.given[given as usize].name.clone(),
            Key::Body(part, side) => match side {
                None => part.name().to_owned(),
                Some(Side::Left) => format!("{}_l", part.name()),
                Some(Side::Right) => format!("{}_r", part.name()),
            },
        }
    }

    /// The part of the body a group is, or stands for.
    pub fn part(&self, group: u32) -> Option<BodyPart> {
        self.body_of(group).map(|(part, _)| part)
    }

    /// The given group that a group is.
    pub fn given(&self, group: u32) -> Option<&'a Given> {
        match self.keys[group as usize] {
            Key::Given(given) => Some(&self.given[given as usize]),
            _ => None,
        }
    }

    /// A given group that has not enough skin to carry a field.
    pub fn bare(&self) -> Option<&'a Given> {
        let lives = |k: u32| self.live().any(|g| self.keys[g as usize] == Key::Given(k));
        (0..).zip(self.given).find(|(k, _)| !lives(*k)).map(|(_, given)| given)
    }
}
