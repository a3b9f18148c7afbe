//! Mean value coordinates of every vertex in the ring of its neighbours at rest (background 1.13; Floater 2003).

use super::{Character, SkinGraph, Targets};
use glam::{DVec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

/// Mean value coordinates at rest, one per edge of the skin's graph, in its order: those of a vertex's edges sum to 1, or are
/// all 0 where it has none.
///
/// With the ring projected on the plane through the vertex across `n` (the direction in which the tracker's field grows
/// there) and `a_j` the signed angles between neighbours that follow each other round it,
/// `w_j = (tan(a_(j-1) / 2) + tan(a_j / 2)) / |q_j - v|`, and their sum made 1. Then `sum w_j (q_j - v) = 0`. A vertex has
/// none on an open boundary, where no field holds it, where its ring has an edge of no length, and where it lies outside
/// what its projected ring surrounds, which some `w_j` below 0 tells.
pub(super) fn mean_values(character: &Character, graph: &SkinGraph, targets: &Targets) -> Vec<f32> {
    let faces = faces(character, graph);
    let of = |v: usize| -> Vec<f32> {
        let [begin, end] = graph.ranges[v];
        let edges = &graph.edges[begin as usize..end as usize];
        let target = &targets.vertices[v];
        let ring = ring(character, &faces[v], v as u32, target.normal_rest).filter(|_| target.slides != 0);
        let share = |ring: &Ring, v: u32| ring.iter().filter(|(of, _)| *of == v).map(|(_, share)| *share as f32).sum();
        match ring {
            Some(ring) => edges.iter().map(|edge| share(&ring, edge.neighbour)).collect(),
            None => vec![0.0; edges.len()],
        }
    };
    let lists: Vec<Vec<f32>> = (0..graph.ranges.len()).into_par_iter().map(of).collect();
    lists.concat()
}

/// Neighbours with their coordinates: a neighbour stands once for each of the faces that it shares with the vertex.
type Ring = Vec<(u32, f64)>;

/// Per vertex, the two other corners of the faces around it, in the faces' order.
fn faces(character: &Character, graph: &SkinGraph) -> Vec<Vec<[u32; 2]>> {
    let mut faces = vec![Vec::new(); graph.copy_of.len()];
    for triangle in &character.triangles {
        let t = triangle.map(|v| graph.copy_of[v as usize]);
        if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
            (0..3).for_each(|k| faces[t[k] as usize].push([t[(k + 1) % 3], t[(k + 2) % 3]]));
        }
    }
    faces
}

fn ring(character: &Character, faces: &[[u32; 2]], v: u32, normal_rest: Vec4) -> Option<Ring> {
    let at = |v: u32| character.positions_rest[v as usize].as_dvec3();
    let normal: DVec3 = normal_rest.xyz().as_dvec3().normalize_or_zero();
    let flat = |of: u32| {
        let e = at(of) - at(v);
        e - normal * e.dot(normal)
    };
    let mut ring = Ring::with_capacity(2 * faces.len());
    for &[a, b] in faces {
        let (p, q) = (flat(a), flat(b));
        let (far, near) = (p.length(), q.length());
        // tan(a / 2) = sin a / (1 + cos a).
        let half = normal.dot(p.cross(q)) / (far * near + p.dot(q));
        ring.extend([(a, half / far), (b, half / near)]);
    }
    let sum: f64 = ring.iter().map(|(_, weight)| weight).sum();
    ring.iter_mut().for_each(|(_, weight)| *weight /= sum);
    let weight = |v: u32| ring.iter().filter(|(of, _)| *of == v).map(|(_, weight)| weight).sum::<f64>();
    // What is not a number is none either.
    faces.iter().flatten().all(|&v| weight(v) >= 0.0 && weight(v).is_finite()).then_some(ring)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::{Role, VertexTarget};
    use glam::Vec3;

    /// A vertex at `centre` in a closed ring of others, with as many targets; all see the field grow along `normal`.
    fn fan(centre: Vec3, ring: &[Vec3], normal: Vec3) -> (Character, SkinGraph, Targets) {
        let n = ring.len() as u32;
        let character = Character {
            positions_rest: [&[centre], ring].concat(),
            triangles: (0..n).map(|k| [0, 1 + k, 1 + (k + 1) % n]).collect(),
            ..Character::default()
        };
        let graph = SkinGraph::new(&character);
        let target = |v: usize| VertexTarget {
            normal_rest: normal.extend(0.0),
            role: Role::Active as u32,
            slides: u32::from(!graph.boundary[v]),
            ..VertexTarget::default()
        };
        let targets = Targets { vertices: (0..=ring.len()).map(target).collect(), ..Targets::default() };
        (character, graph, targets)
    }

    fn coordinates(centre: Vec3, ring: &[Vec3], normal: Vec3) -> Vec<f32> {
        let (character, graph, targets) = fan(centre, ring, normal);
        mean_values(&character, &graph, &targets)[graph.ranges[0][0] as usize..graph.ranges[0][1] as usize].to_vec()
    }

    fn polygon(corners: usize) -> Vec<Vec3> {
        let angle = |k: usize| std::f32::consts::TAU * k as f32 / corners as f32;
        (0..corners).map(|k| Vec3::new(angle(k).cos(), angle(k).sin(), 0.0)).collect()
    }

    #[test]
    fn a_regular_ring_has_equal_shares() {
        for corners in [3, 4, 7] {
            for normal in [Vec3::Z, -Vec3::Z] {
                let found = coordinates(Vec3::ZERO, &polygon(corners), normal);
                assert!(found.iter().all(|w| (w * corners as f32 - 1.0).abs() < 1e-6), "{corners}: {found:?}");
            }
        }
    }

    /// Floater's coordinates of a point within a square of side 2, by his formula with angles and tangents.
    #[test]
    fn a_point_in_a_square_has_floaters_coordinates() {
        let square = [
            Vec3::new(-1.0, -1.0, 0.0),
            Vec3::new(1.0, -1.0, 0.3),
            Vec3::new(1.0, 1.0, -0.2),
            Vec3::new(-1.0, 1.0, 0.1),
        ];
        let centre = Vec3::new(0.3, -0.45, 0.7);
        let to = |k: usize| (square[k % 4] - centre).truncate().as_dvec2();
        let tangent = |k: usize| (to(k).angle_to(to(k + 1)) / 2.0).tan();
        let weights: Vec<f64> = (0..4).map(|k| (tangent(k + 3) + tangent(k)) / to(k).length()).collect();
        let sum: f64 = weights.iter().sum();
        let found = coordinates(centre, &square, Vec3::Z);
        for (found, expected) in found.iter().zip(&weights) {
            assert!((f64::from(*found) - expected / sum).abs() < 1e-7, "{found} {}", expected / sum);
        }
        let moved = coordinates(centre + Vec3::X * 1e-4, &square, Vec3::Z);
        assert!(found.iter().zip(&moved).any(|(a, b)| (a - b).abs() > 1e-6), "another centre must be seen");
    }

    #[test]
    fn linear_functions_come_back() {
        let centre = Vec3::new(0.1, 0.2, 0.5);
        let ring: Vec<Vec3> = polygon(6)
            .iter()
            .enumerate()
            .map(|(k, p)| *p * (1.0 + 0.1 * k as f32) + Vec3::Z * (k as f32).sin())
            .collect();
        let normal = Vec3::new(0.2, -0.1, 1.0).normalize();
        let shares = coordinates(centre, &ring, normal);
        let off = |shares: &[f32]| {
            let sum: Vec3 = ring.iter().zip(shares).map(|(p, w)| (*p - centre) * *w).sum();
            (sum - normal * sum.dot(normal)).length()
        };
        assert!(off(&shares) < 1e-6 && (shares.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        assert!(off(&[1.0 / 6.0; 6]) > 1e-2, "plain means do not");
    }

    #[test]
    fn what_has_no_coordinates_gets_none() {
        let none = |centre, ring: &[Vec3], normal| coordinates(centre, ring, normal).iter().all(|w| *w == 0.0);
        let square = polygon(4);
        assert!(!none(Vec3::ZERO, &square, Vec3::Z));
        assert!(none(Vec3::new(1.3, 0.0, 0.0), &square, Vec3::Z), "outside");
        assert!(none(Vec3::ZERO, &square, Vec3::ZERO), "no normal");
        assert!(none(Vec3::ZERO, &square, Vec3::X), "a ring seen edge on");
        assert!(none(square[0] + Vec3::Z, &square, Vec3::Z), "over its neighbour");
        let (character, graph, targets) = fan(Vec3::ZERO, &square, Vec3::Z);
        let rim = graph.ranges[1][0] as usize..graph.ranges[1][1] as usize;
        assert!(mean_values(&character, &graph, &targets)[rim].iter().all(|w| *w == 0.0), "an open boundary");
    }
}
