//! Triangles in a tree of boxes.

use super::{dipole, nearest_on_triangle, turns};
use glam::DVec3;

/// Most triangles of a leaf.
const LEAF: usize = 4;
/// Distance, in radii of a box' contents, from which they are one dipole.
const FAR: f64 = 2.0;
/// Depth of a walk's stack: halves of a million triangles are leaves after 18 steps, each of which leaves one box behind.
const DEPTH: usize = 40;

/// A box and what is in it.
struct Node {
    low: DVec3,
    high: DVec3,
    /// Mean of the triangles' centres by their areas.
    centre: DVec3,
    /// Farthest corner from there, squared.
    radius_squared: f64,
    /// Sum of the triangles' areas as vectors.
    area: DVec3,
    /// First triangle of a leaf; of others the second half's node. The first half's follows its own.
    first: u32,
    /// Triangles of a leaf; 0 of others.
    count: u32,
}

/// All triangles of a mesh.
pub(super) struct Tree {
    nodes: Vec<Node>,
    triangles: Vec<[DVec3; 3]>,
}

impl Tree {
    /// Halves the triangles by their centres along the longest side until few are left; there is at least one.
    pub fn new(mut triangles: Vec<[DVec3; 3]>) -> Tree {
        let mut nodes = Vec::with_capacity(triangles.len());
        let whole = triangles.len();
        split(&mut nodes, &mut triangles, 0, whole);
        Tree { nodes, triangles }
    }

    /// The point nearest to `p`, and its triangle; `within` is known to be no less than about its distance. `seen` counts
    /// what is looked at.
    pub fn nearest(&self, p: DVec3, within: f64, seen: &mut u64) -> (DVec3, &[DVec3; 3]) {
        // A little more, so that rounding does not hide the only one.
        let mut least = (within * 1.000_001).powi(2);
        let mut best = (DVec3::NAN, &self.triangles[0]);
        let mut stack = [(0, 0.0); DEPTH];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (index, squared) = stack[depth];
            if squared >= least {
                continue;
            }
            let node = &self.nodes[index as usize];
            *seen += 1 + u64::from(node.count);
            for triangle in self.leaf(node) {
                let found = nearest_on_triangle(p, triangle);
                let squared = found.distance_squared(p);
                if squared < least || best.0.is_nan() {
                    (least, best) = (squared.min(least), (found, triangle));
                }
            }
            if node.count == 0 {
                let near = [index + 1, node.first].map(|child| (child, self.nodes[child as usize].distance_squared(p)));
                let [a, b] = near;
                let (nearer, farther) = if a.1 <= b.1 { (a, b) } else { (b, a) };
                stack[depth] = farther;
                stack[depth + 1] = nearer;
                depth += 2;
            }
        }
        best
    }

    /// How often the mesh winds round `p`.
    pub fn winding(&self, p: DVec3, seen: &mut u64) -> f64 {
        let mut sum = 0.0;
        let mut stack = [0; DEPTH];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let index = stack[depth];
            let node = &self.nodes[index as usize];
            *seen += 1 + u64::from(node.count);
            let away = node.centre - p;
            if away.length_squared() > FAR * FAR * node.radius_squared && away != DVec3::ZERO {
                sum += dipole(away, node.area);
            } else if node.count > 0 {
                sum += self.leaf(node).iter().map(|triangle| turns(p, triangle)).sum::<f64>();
            } else {
                stack[depth] = node.first;
                stack[depth + 1] = index + 1;
                depth += 2;
            }
        }
        sum
    }

    fn leaf(&self, node: &Node) -> &[[DVec3; 3]] {
        if node.count == 0 { &[] } else { &self.triangles[node.first as usize..][..node.count as usize] }
    }
}

impl Node {
    fn distance_squared(&self, p: DVec3) -> f64 {
        p.distance_squared(p.clamp(self.low, self.high))
    }
}

/// Adds the node of triangles `first..end` and all below it.
fn split(nodes: &mut Vec<Node>, triangles: &mut [[DVec3; 3]], first: usize, end: usize) {
    let own = &mut triangles[first..end];
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut centre, mut area, mut weight) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for [a, b, c] in own.iter() {
        (low, high) = (low.min(*a).min(*b).min(*c), high.max(*a).max(*b).max(*c));
        let vector = (*b - *a).cross(*c - *a) * 0.5;
        let size = vector.length();
        (centre, area, weight) = (centre + (*a + *b + *c) * (size / 3.0), area + vector, weight + size);
    }
    let centre = if weight > 0.0 { centre / weight } else { (low + high) * 0.5 };
    let radius_squared = own.iter().flatten().map(|p| p.distance_squared(centre)).fold(0.0, f64::max);
    let index = nodes.len();
    let count = if own.len() > LEAF { 0 } else { own.len() as u32 };
    nodes.push(Node { low, high, centre, radius_squared, area, first: first as u32, count });
    if count == 0 {
        let side = high - low;
        let axis = if side.x >= side.y.max(side.z) {
            0
        } else if side.y >= side.z {
            1
        } else {
            2
        };
        let key = |t: &[DVec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
        let half = own.len() / 2;
        own.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)));
        split(nodes, triangles, first, first + half);
        nodes[index].first = nodes.len() as u32;
        split(nodes, triangles, first + half, end);
    }
}
