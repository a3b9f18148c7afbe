//! Which triangles shade a vertex.

use super::Character;
use std::collections::HashMap;

/// Triangles around every vertex; vertices that share position and normal at rest share their triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    /// Corner indices, three per triangle.
    pub corners: Vec<u32>,
    /// Where each vertex's triangles begin in `members`; one longer than the vertices.
    pub offsets: Vec<u32>,
    /// Triangle indices, ascending within a vertex.
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
        let mut offsets = Vec::with_capacity(class.len() + 1);
        let mut members = Vec::with_capacity(character.triangles.len() * 3);
        offsets.push(0);
        for &c in &class {
            members.extend_from_slice(&around[c as usize]);
            offsets.push(members.len() as u32);
        }
        Topology { corners: character.triangles.iter().flatten().copied().collect(), offsets, members }
    }
}

/// Per vertex, the first vertex with the same position and normal, to the bit.
fn shading_classes(character: &Character) -> Vec<u32> {
    let mut first = HashMap::with_capacity(character.vertex_count());
    character
        .positions_rest
        .iter()
        .zip(&character.normals_rest)
        .enumerate()
        .map(|(vertex, (p, n))| {
            // Seam copies may differ in the last bits of a recomputed normal: a thousandth is the same direction.
            let key = (p.to_array().map(f32::to_bits), n.to_array().map(|x| (x * 1000.0).round() as i32));
            *first.entry(key).or_insert(vertex as u32)
        })
        .collect()
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
        let smooth = Topology::new(&quad(Vec3::Z));
        assert_eq!(smooth.members[smooth.offsets[1] as usize..smooth.offsets[2] as usize], [0, 1]);
        assert_eq!(smooth.members[smooth.offsets[3] as usize..smooth.offsets[4] as usize], [0, 1]);
        let hard = Topology::new(&quad(Vec3::X));
        assert_eq!(hard.members[hard.offsets[1] as usize..hard.offsets[2] as usize], [0]);
        assert_eq!(hard.members[hard.offsets[3] as usize..hard.offsets[4] as usize], [1]);
    }
}
