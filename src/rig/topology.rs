//! Which triangles shade a vertex.

use super::Character;
use std::collections::HashMap;

/// Triangles around every vertex; vertices that share position and normal at rest share one list of triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    /// Corner indices, three per triangle.
    pub corners: Vec<u32>,
    /// Per vertex, where its triangles begin and end in `members`.
    pub fans: Vec<[u32; 2]>,
    /// Triangle indices, ascending within a list: at most three per triangle in all, however many vertices coincide.
    pub members: Vec<u32>,
}

impl Topology {
    /// Gathers the triangles around every vertex of a character.
    pub fn new(character: &Character) -> Topology {
        let class = shading_classes(character);
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); character.vertex_count()];
        for (t, triangle) in character.triangles.iter().enumerate() {
            for (k, &corner) in triangle.iter().enumerate() {
                let c = class[corner as usize];
                if !triangle[..k].iter().any(|&earlier| class[earlier as usize] == c) {
                    around[c as usize].push(t as u32);
                }
            }
        }
        let mut members = Vec::with_capacity(character.triangles.len() * 3);
        let lists: Vec<[u32; 2]> = around
            .iter()
            .map(|triangles| {
                let begin = members.len() as u32;
                members.extend_from_slice(triangles);
                [begin, members.len() as u32]
            })
            .collect();
        let fans = class.iter().map(|&c| lists[c as usize]).collect();
        Topology { corners: character.triangles.iter().flatten().copied().collect(), fans, members }
    }
}

/// Copies of a vertex that share shading at most. Real seams have a handful; thousands of vertices in one place would
/// each sum all triangles of the place.
const MOST_COPIES: u32 = 64;

/// Per vertex, the first vertex with the same position and normal; itself where more than [`MOST_COPIES`] coincide.
fn shading_classes(character: &Character) -> Vec<u32> {
    let mut first = HashMap::with_capacity(character.vertex_count());
    let mut copies = vec![0u32; character.vertex_count()];
    let mut class: Vec<u32> = character
        .positions_rest
        .iter()
        .zip(&character.normals_rest)
        .enumerate()
        .map(|(vertex, (p, n))| {
            // Seam copies may differ in the last bits of a recomputed normal: a thousandth is the same direction.
            let key = (p.to_array().map(f32::to_bits), n.to_array().map(|x| (x * 1000.0).round() as i32));
            let class = *first.entry(key).or_insert(vertex as u32);
            copies[class as usize] += 1;
            class
        })
        .collect();
    for (vertex, class) in class.iter_mut().enumerate() {
        if copies[*class as usize] > MOST_COPIES {
            *class = vertex as u32;
        }
    }
    class
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn seams_share_and_hard_edges_do_not() {
        let quad = |normal_of_copy: Vec3| Character {
            positions_rest: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X, Vec3::ONE, Vec3::Y],
            normals_rest: vec![Vec3::Z, Vec3::Z, Vec3::Z, normal_of_copy, normal_of_copy, normal_of_copy],
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            ..Character::default()
        };
        let fan = |topology: &Topology, v: usize| {
            let [begin, end] = topology.fans[v];
            topology.members[begin as usize..end as usize].to_vec()
        };
        let smooth = Topology::new(&quad(Vec3::Z));
        assert_eq!((fan(&smooth, 1), fan(&smooth, 3)), (vec![0, 1], vec![0, 1]));
        let hard = Topology::new(&quad(Vec3::X));
        assert_eq!((fan(&hard, 1), fan(&hard, 3)), (vec![0], vec![1]));
    }

    #[test]
    fn coincident_vertices_take_no_more_room_than_their_triangles() {
        let n = 30_000;
        let character = Character {
            positions_rest: vec![Vec3::ONE; n],
            normals_rest: vec![Vec3::Z; n],
            triangles: (0..n as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
            ..Character::default()
        };
        let topology = Topology::new(&character);
        assert!(topology.members.len() <= n && topology.fans.iter().all(|[begin, end]| end - begin <= 1));
    }
}
