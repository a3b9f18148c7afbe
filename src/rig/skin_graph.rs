//! The skin as a graph: copies at seams taken together, and the edges between vertices with their weights.

use super::Character;
use std::collections::HashMap;

crate::gpu_struct! {
    /// An edge of the skin as one of its vertices sees it.
    pub struct SkinEdge {
        /// The vertex at its other end, the first of its copies.
        pub neighbour: u32,
        /// Cotangent weight at rest, at least `LEAST_WEIGHT`.
        pub weight: f32,
    }
}

/// Smallest weight of an edge: obtuse triangles have negative cotangents, under which relaxation would diverge.
pub const LEAST_WEIGHT: f32 = 1e-3;
/// Largest weight: needles have cotangents without bound.
const MOST_WEIGHT: f32 = 50.0;
/// Copies of one place that are taken together at most: seams have a handful, and junk may have thousands.
const MOST_COPIES: u32 = 64;

/// Edges between welded vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinGraph {
    /// Per vertex the first one at the same place at rest: itself where it has no earlier copy.
    pub copy_of: Vec<u32>,
    /// Per vertex, where its edges begin and end in `edges`; empty for later copies.
    pub ranges: Vec<[u32; 2]>,
    /// Edges, ascending by neighbour within a vertex.
    pub edges: Vec<SkinEdge>,
    /// Whether a vertex lies on an open boundary, or on an edge with more than two triangles.
    pub boundary: Vec<bool>,
}

impl SkinGraph {
    /// Welds a character's skin and weighs its edges.
    pub fn new(character: &Character) -> SkinGraph {
        let copy_of = weld(character);
        let at = |v: u32| character.positions_rest[v as usize].as_dvec3();
        // Per edge, smaller vertex first: sum of half cotangents, and triangles.
        let mut weights: HashMap<(u32, u32), (f64, u32)> = HashMap::new();
        for triangle in &character.triangles {
            let t = triangle.map(|v| copy_of[v as usize]);
            if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
                continue;
            }
            for k in 0..3 {
                let (a, b, opposite) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                let (u, w) = (at(a) - at(opposite), at(b) - at(opposite));
                let area = u.cross(w).length();
                let cotangent = if area > 0.0 { 0.5 * u.dot(w) / area } else { 0.0 };
                let edge = weights.entry((a.min(b), a.max(b))).or_default();
                *edge = (edge.0 + cotangent, edge.1 + 1);
            }
        }
        let mut sorted: Vec<((u32, u32), (f64, u32))> = weights.into_iter().collect();
        sorted.sort_unstable_by_key(|(edge, _)| *edge);
        let mut around: Vec<Vec<SkinEdge>> = vec![Vec::new(); copy_of.len()];
        let mut boundary = vec![false; copy_of.len()];
        for ((a, b), (weight, triangles)) in sorted {
            let weight = (weight as f32).clamp(LEAST_WEIGHT, MOST_WEIGHT);
            around[a as usize].push(SkinEdge { neighbour: b, weight });
            around[b as usize].push(SkinEdge { neighbour: a, weight });
            if triangles != 2 {
                (boundary[a as usize], boundary[b as usize]) = (true, true);
            }
        }
        let mut edges = Vec::new();
        let ranges = around
            .into_iter()
            .map(|mut own| {
                own.sort_unstable_by_key(|edge| edge.neighbour);
                let begin = edges.len() as u32;
                edges.extend(own);
                [begin, edges.len() as u32]
            })
            .collect();
        SkinGraph { copy_of, ranges, edges, boundary }
    }
}

/// Per vertex the first one at the same place.
fn weld(character: &Character) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], (u32, u32)> = HashMap::with_capacity(character.vertex_count());
    let of = |(v, p): (u32, &glam::Vec3)| {
        // Zero has two spellings.
        let key = p.to_array().map(|x| (x + 0.0).to_bits());
        let (class, copies) = first.entry(key).or_insert((v, 0));
        *copies += 1;
        if *copies > MOST_COPIES { v } else { *class }
    };
    (0..).zip(&character.positions_rest).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A square of two right triangles whose diagonal is a seam.
    fn square() -> Character {
        Character {
            positions_rest: vec![
                Vec3::ZERO,
                Vec3::X,
                Vec3::Y,
                Vec3::X,
                Vec3::new(1.0, 1.0, 0.0),
                Vec3::new(-0.0, 1.0, 0.0),
            ],
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            ..Character::default()
        }
    }

    #[test]
    fn copies_are_one_vertex_and_weights_are_cotangents() {
        let graph = SkinGraph::new(&square());
        assert_eq!(graph.copy_of, [0, 1, 2, 1, 4, 2]);
        let edges = |v: usize| {
            let [begin, end] = graph.ranges[v];
            graph.edges[begin as usize..end as usize].iter().map(|e| (e.neighbour, e.weight)).collect::<Vec<_>>()
        };
        assert_eq!(edges(3), []);
        // Opposite the diagonal stand two right angles, opposite every side half of one.
        assert_eq!(edges(1), [(0, 0.5), (2, LEAST_WEIGHT), (4, 0.5)]);
        assert_eq!(graph.boundary[..3], [true; 3]);
    }

    #[test]
    fn closed_skins_have_no_boundary_and_junk_does_no_harm() {
        let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32);
        let faces = [[0, 2, 1], [0, 1, 4], [0, 4, 2], [1, 2, 4]];
        let closed = Character {
            positions_rest: (0..5).map(corner).collect(),
            triangles: faces.to_vec(),
            ..Character::default()
        };
        let graph = SkinGraph::new(&closed);
        assert!(!graph.boundary.iter().any(|&b| b), "vertex 3 is alone, and has no edge to be open");
        assert_eq!(graph.ranges[3][0], graph.ranges[3][1]);
        let junk = Character {
            positions_rest: vec![Vec3::ONE; 500],
            triangles: (0..498).map(|v| [v, v + 1, v + 2]).collect(),
            ..Character::default()
        };
        let graph = SkinGraph::new(&junk);
        assert!(graph.edges.iter().all(|e| e.weight >= LEAST_WEIGHT && e.weight <= MOST_WEIGHT));
        assert_eq!(graph.copy_of[400], 400, "no more than {MOST_COPIES} are taken together");
    }
}
