//! How skin is creased: the angles between faces, against those at rest.

use glam::{Vec3, Vec4, Vec4Swizzles};
use std::collections::HashMap;

/// Squared length of a face's normal, twice its area, under which it has no direction: a face of less than 1e-12 square metres.
const LEAST_NORMAL_SQUARED: f32 = 4e-24;

/// The edges between two faces of a skin, and how they are folded at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Creases {
    /// First and second end of an edge, and the corners opposite it of the face that runs along it and of the other one.
    edges: Vec<[u32; 4]>,
    /// Angle of each at rest, radians.
    rest: Vec<f32>,
    /// Vertices of the skin.
    copy_of: Vec<u32>,
}

impl Creases {
    /// The edges of a skin that have two faces which run along them in opposite directions. `copy_of` names the first of every
    /// vertex's copies, so that seams are edges like others.
    pub fn new(triangles: &[[u32; 3]], copy_of: &[u32], positions_rest: &[Vec4]) -> Creases {
        let mut faces: HashMap<[u32; 2], Vec<(bool, u32)>> = HashMap::new();
        for triangle in triangles {
            let t = triangle.map(|v| copy_of[v as usize]);
            if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
                continue;
            }
            for k in 0..3 {
                let (a, b, opposite) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                faces.entry([a.min(b), a.max(b)]).or_default().push((a < b, opposite));
            }
        }
        let two = |(edge, faces): (&[u32; 2], &Vec<(bool, u32)>)| match faces[..] {
            [(true, along), (false, other)] | [(false, other), (true, along)] => Some([edge[0], edge[1], along, other]),
            _ => None,
        };
        let mut edges: Vec<[u32; 4]> = faces.iter().filter_map(two).collect();
        edges.sort_unstable();
        let angle = |edge: &[u32; 4]| angle(edge.map(|v| positions_rest[v as usize].xyz()));
        let folded = edges.into_iter().filter_map(|edge| Some((edge, angle(&edge)?)));
        let (edges, rest) = folded.unzip();
        Creases { edges, rest, copy_of: copy_of.to_vec() }
    }

    /// By how much each edge is folded more than at rest, degrees: above 0 as a valley, below as a ridge. Edges of faces that
    /// have collapsed count as folded through, 180.
    pub fn changes(&self, positions: &[Vec4]) -> Vec<f32> {
        let change = |(edge, rest): (&[u32; 4], &f32)| {
            let Some(angle) = angle(edge.map(|v| positions[self.copy_of[v as usize] as usize].xyz())) else {
                return 180.0;
            };
            let turn = (angle - rest).to_degrees();
            // The shorter way round.
            if turn > 180.0 {
                turn - 360.0
            } else if turn < -180.0 {
                turn + 360.0
            } else {
                turn
            }
        };
        self.edges.iter().zip(&self.rest).map(change).collect()
    }

    /// Per vertex, of its edges' changes the one that is largest in size, degrees; 0 where it has none.
    pub fn of_vertices(&self, changes: &[f32]) -> Vec<f32> {
        let mut most = vec![0.0f32; self.copy_of.len()];
        for (edge, &change) in self.edges.iter().zip(changes) {
            for &v in &edge[..2] {
                if change.abs() > most[v as usize].abs() {
                    most[v as usize] = change;
                }
            }
        }
        self.copy_of.iter().map(|&first| most[first as usize]).collect()
    }
}

/// Angle by which the skin turns at an edge, radians: 0 where it is flat, above 0 in a valley.
fn angle([a, b, along, other]: [Vec3; 4]) -> Option<f32> {
    let normals = [(b - a).cross(along - a), (a - b).cross(other - b)];
    if normals.iter().any(|n| n.length_squared() < LEAST_NORMAL_SQUARED) {
        return None;
    }
    let [n, m] = normals.map(Vec3::normalize_or_zero);
    let turn = n.cross(m).dot((b - a).normalize_or_zero()).atan2(n.dot(m));
    Some(-turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares that meet at the Y axis, each of two triangles, the second with vertices of its own; the second is turned
    /// about the axis by `degrees`, towards the outside of the first.
    fn book(degrees: f32) -> (Vec<[u32; 3]>, Vec<Vec4>) {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let page = |x: f32, y: f32| Vec3::new(-x * cos, y, x * sin);
        let positions = [
            Vec3::ZERO,
            Vec3::X,
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::Y,
            page(0.0, 0.0),
            page(0.0, 1.0),
            page(1.0, 1.0),
            page(1.0, 0.0),
        ];
        let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        (triangles, positions.map(|p| p.extend(1.0)).to_vec())
    }

    const COPY_OF: [u32; 8] = [0, 1, 2, 3, 0, 3, 6, 7];

    #[test]
    fn a_fold_is_measured_across_its_seam() {
        let (triangles, rest) = book(20.0);
        let creases = Creases::new(&triangles, &COPY_OF, &rest);
        assert_eq!(creases.edges.len(), 3);
        for turned in [0.0, 20.0, 75.0, -60.0, 150.0] {
            let changes = creases.changes(&book(turned).1);
            let most = changes.iter().copied().fold(0.0f32, |m, c| if c.abs() > m.abs() { c } else { m });
            assert!((most - (turned - 20.0)).abs() < 1e-3, "{turned}: {changes:?}");
            let of_vertices = creases.of_vertices(&changes);
            for v in [0, 3, 4, 5] {
                assert_eq!(of_vertices[v], most, "{turned}: vertex {v}");
            }
            assert!(of_vertices[1].abs() < 1e-3 && of_vertices[7].abs() < 1e-3);
        }
        let apart: Vec<u32> = (0..8).collect();
        let torn = Creases::new(&triangles, &apart, &rest);
        let most = torn.changes(&book(150.0).1).into_iter().fold(0.0, f32::max);
        assert!(most < 1e-3, "without its copies a seam is no edge: {most}");
    }

    #[test]
    fn moving_as_a_whole_creases_nothing_and_collapse_is_seen() {
        let (triangles, rest) = book(40.0);
        let creases = Creases::new(&triangles, &COPY_OF, &rest);
        let turn = glam::Mat4::from_rotation_x(1.1) * glam::Mat4::from_translation(Vec3::new(0.2, 3.0, -1.0));
        let moved: Vec<Vec4> = rest.iter().map(|&p| turn * p).collect();
        assert!(creases.changes(&moved).iter().all(|c| c.abs() < 1e-2));
        let mut collapsed = rest;
        collapsed[6] = collapsed[0];
        assert!(creases.changes(&collapsed).contains(&180.0));
    }
}
