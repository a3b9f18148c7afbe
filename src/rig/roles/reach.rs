//! The tree of joints with how far each branch reaches, and the branches that come in pairs.

use crate::rig::Character;
use glam::Vec3;

/// Two branches are alike where the shorter reaches this share of the longer.
const ALIKE: f32 = 0.7;
/// Two branches go different ways where their middles are this share of their reach apart.
const APART: f32 = 0.1;
/// Most branches off one joint that are looked at for pairs, the farthest-reaching ones.
const MOST_BRANCHES: usize = 24;

/// The joints that move skin, or end what does.
pub(super) struct Tree<'a> {
    character: &'a Character,
    /// Where every joint is at rest, metres.
    pub places: Vec<Vec3>,
    /// The joints that count below every joint.
    pub children: Vec<Vec<u32>>,
    /// How far skin and joints reach along the tree below every joint, metres.
    pub reach: Vec<f32>,
    /// The farthest vertex that every joint moves most.
    pub tips: Vec<Option<Vec3>>,
    counts: Vec<u32>,
    roots: Vec<u32>,
}

/// Two like branches.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    /// The joint that both hang on.
    pub parent: Option<u32>,
    /// Their first joints.
    pub members: [u32; 2],
    /// How far the shorter of them reaches, metres.
    pub reach: f32,
    starts: [Vec3; 2],
    ends: [Vec3; 2],
}

impl<'a> Tree<'a> {
    pub fn new(character: &'a Character) -> Tree<'a> {
        let joints = &character.joints;
        let places: Vec<Vec3> = joints.iter().map(|j| j.bind().w_axis.truncate()).collect();
        let (mut moves, mut tips) = (vec![false; joints.len()], vec![None; joints.len()]);
        for v in 0..character.vertex_count() {
            let influences = character.influences_of(v);
            influences.iter().filter(|i| i.weight > 0.0).for_each(|i| moves[i.joint as usize] = true);
            let Some(j) = influences.first().map(|i| i.joint as usize) else { continue };
            let p = character.positions_rest[v];
            if tips[j].is_none_or(|tip: Vec3| p.distance(places[j]) > tip.distance(places[j])) {
                tips[j] = Some(p);
            }
        }
        // Parents precede their children.
        let mut below = moves.clone();
        let parent = |j: usize| joints[j].parent.map(|p| p as usize);
        for j in (0..joints.len()).rev() {
            if let (true, Some(p)) = (below[j], parent(j)) {
                below[p] = true;
            }
        }
        let mut with_skin = vec![0_u32; joints.len()];
        let mut inner = vec![false; joints.len()];
        for (j, below) in below.iter().enumerate() {
            if let Some(p) = parent(j) {
                with_skin[p] += u32::from(*below);
                inner[p] = true;
            }
        }
        // A leaf without skin ends the bone of its parent, where nothing else does.
        let ends = |j: usize| parent(j).is_some_and(|p| moves[p] && with_skin[p] == 0) && !inner[j];
        let counts = |j: &usize| places[*j].is_finite() && (below[*j] || ends(*j));
        let counted: Vec<usize> = (0..joints.len()).filter(counts).collect();
        let mut tree = Tree {
            character,
            children: vec![Vec::new(); joints.len()],
            reach: vec![0.0; joints.len()],
            counts: vec![0; joints.len()],
            roots: Vec::new(),
            places,
            tips,
        };
        for j in counted.into_iter().rev() {
            let own = tree.tips[j].map_or(0.0, |tip| tip.distance(tree.places[j]));
            tree.reach[j] = tree.reach[j].max(if own.is_finite() { own } else { 0.0 });
            tree.counts[j] += 1;
            match parent(j) {
                Some(p) if tree.places[p].is_finite() => {
                    tree.reach[p] = tree.reach[p].max(tree.reach_from(p as u32, j as u32));
                    tree.counts[p] += tree.counts[j];
                    tree.children[p].push(j as u32);
                }
                _ => tree.roots.push(j as u32),
            }
        }
        tree.roots.reverse();
        tree.children.iter_mut().for_each(|children| children.reverse());
        tree
    }

    /// Parent of every joint.
    pub fn parents(&self) -> Vec<Option<u32>> {
        self.character.joints.iter().map(|j| j.parent).collect()
    }

    /// How far the branch of a child reaches from its parent.
    pub fn reach_from(&self, parent: u32, child: u32) -> f32 {
        self.places[child as usize].distance(self.places[parent as usize]) + self.reach[child as usize]
    }

    /// Whether a joint is the other, or an ancestor of it.
    pub fn is_above(&self, joint: u32, other: u32) -> bool {
        let up = std::iter::successors(Some(other), |&j| self.character.joints[j as usize].parent);
        up.into_iter().any(|j| j == joint)
    }

    /// Mean of the vertices that a joint, or one below it, moves most.
    pub fn skin_below(&self, joint: u32) -> Option<Vec3> {
        let mut inside = vec![false; self.places.len()];
        inside[joint as usize] = true;
        for j in joint as usize + 1..inside.len() {
            inside[j] = self.character.joints[j].parent.is_some_and(|p| inside[p as usize]);
        }
        let of = |v: &usize| self.character.influences_of(*v).first().is_some_and(|i| inside[i.joint as usize]);
        let vertices = (0..self.character.vertex_count()).filter(of).map(|v| self.character.positions_rest[v]);
        let (sum, count) = vertices.fold((Vec3::ZERO, 0), |(sum, count), p| (sum + p, count + 1));
        (count > 0).then(|| sum / count as f32)
    }

    /// The root whose branch reaches farthest.
    pub fn longest_root(&self) -> Option<u32> {
        self.roots.iter().copied().max_by(|&a, &b| self.reach[a as usize].total_cmp(&self.reach[b as usize]))
    }

    /// Pairs off the middle of the body, the farthest-reaching first: what is paired is not looked into.
    pub fn pairs(&self) -> Vec<Pair> {
        let mut pairs = Vec::new();
        let mut open = vec![(None, self.roots.clone())];
        while let Some((parent, mut branches)) = open.pop() {
            let from = |j: u32| parent.map_or(self.reach[j as usize], |p| self.reach_from(p, j));
            branches.sort_by(|&a, &b| from(b).total_cmp(&from(a)));
            let mut paired = Vec::new();
            let looked = &branches[..branches.len().min(MOST_BRANCHES)];
            // The longer of two alike comes first, so that pairs form from the farthest-reaching down.
            for (k, &a) in looked.iter().enumerate() {
                let free = |j: &u32| !paired.contains(j);
                let partner = looked[k + 1..].iter().copied().find(|b| free(&a) && free(b) && self.alike(a, *b));
                if let Some(b) = partner {
                    paired.extend([a, b]);
                    pairs.push(self.pair(parent, [a, b]));
                }
            }
            let rest = branches.into_iter().filter(|j| !paired.contains(j));
            open.extend(rest.map(|j| (Some(j), self.children[j as usize].clone())));
        }
        pairs.sort_by(|a, b| b.reach.total_cmp(&a.reach));
        pairs
    }

    fn alike(&self, a: u32, b: u32) -> bool {
        let [longer, shorter] = [a, b].map(|j| self.reach[j as usize]);
        let (longer, shorter) = (longer.max(shorter), longer.min(shorter));
        let [more, fewer] = [a, b].map(|j| self.counts[j as usize]);
        let (more, fewer) = (more.max(fewer), more.min(fewer));
        let apart = self.middle(a).distance(self.middle(b));
        longer > 0.0 && shorter > ALIKE * longer && more - fewer <= (more / 5).max(1) && apart > APART * longer
    }

    fn pair(&self, parent: Option<u32>, members: [u32; 2]) -> Pair {
        let reach = members.map(|j| self.reach[j as usize]);
        Pair {
            parent,
            members,
            reach: reach[0].min(reach[1]),
            starts: members.map(|j| self.places[j as usize]),
            ends: members.map(|j| self.tip(j)),
        }
    }

    /// The middle between a branch's first joint and its tip.
    fn middle(&self, joint: u32) -> Vec3 {
        (self.places[joint as usize] + self.tip(joint)) * 0.5
    }

    /// The last joint along the way that reaches farthest, or where its skin ends.
    fn tip(&self, joint: u32) -> Vec3 {
        let last = std::iter::successors(Some(joint), |&j| self.next(j)).last().unwrap_or(joint);
        self.tips[last as usize].unwrap_or(self.places[last as usize])
    }

    /// The child along which the tree reaches farthest.
    pub fn next(&self, joint: u32) -> Option<u32> {
        let from = |child: u32| self.reach_from(joint, child);
        self.children[joint as usize].iter().copied().max_by(|&a, &b| from(a).total_cmp(&from(b)))
    }
}

impl Pair {
    /// The middle between the first joints.
    pub fn middle(&self) -> Vec3 {
        (self.starts[0] + self.starts[1]) * 0.5
    }

    /// The middle between the ends.
    pub fn end(&self) -> Vec3 {
        (self.ends[0] + self.ends[1]) * 0.5
    }

    /// From one to the other.
    pub fn across(&self) -> Vec3 {
        (self.starts[0] + self.ends[0] - self.starts[1] - self.ends[1]) * 0.5
    }

    /// Share of its reach by which the pair goes away from another one.
    pub fn away_from(&self, other: &Pair) -> f32 {
        (self.end() - self.middle()).dot((self.middle() - other.middle()).normalize_or_zero()) / self.reach
    }

    /// Cosine between the directions of the two.
    pub fn parallel(&self) -> f32 {
        let [a, b] = [0, 1].map(|i| (self.ends[i] - self.starts[i]).normalize_or_zero());
        a.dot(b)
    }
}
