//! A rig's bones as solids, in the shape that muscles collide with.

use super::color_mesh::ColorMesh;
use crate::rig::{ColliderShape, Pose, Rig};
use glam::{Mat3, Mat4, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Light grey, linear RGB.
const COLOR: [f32; 3] = [0.62, 0.61, 0.58];
/// Corners around a capsule, and rings from the equator of an end to its pole.
const AROUND: u32 = 20;
const END_RINGS: u32 = 6;

/// All bones of a rig in one pose, scene space. A joint that the pose lacks has no bone.
pub fn bone_meshes(rig: &Rig, pose: &Pose) -> Vec<ColorMesh> {
    let posed = rig.bones.iter().filter_map(|bone| {
        let to_posed = *pose.palette.get(bone.joint as usize)? * rig.character.joints[bone.joint as usize].bind();
        let mesh = match &bone.shape {
            ColliderShape::Capsule { from, to, radius } => capsule_mesh(*from, *to, *radius),
            ColliderShape::Mesh { positions, triangles } => of_mesh(positions, triangles),
        };
        Some(moved(mesh, &to_posed))
    });
    posed.collect()
}

/// The points within `radius` of a segment, as a closed mesh; metres.
pub fn capsule_mesh(from: Vec3, to: Vec3, radius: f32) -> ColorMesh {
    let along = (to - from).normalize_or(Vec3::Y);
    let across = along.any_orthonormal_vector();
    let third = along.cross(across);
    let mut mesh = ColorMesh::default();
    let mut add = |center: Vec3, normal: Vec3| {
        mesh.positions.push(center + normal * radius);
        mesh.normals.push(normal);
        mesh.colors.push(COLOR);
    };
    // Rings from one pole to the other, the equator of each end once.
    let rings = 2 * END_RINGS;
    for ring in 0..rings {
        let (center, step) = if ring < END_RINGS { (from, ring + 1) } else { (to, ring) };
        let tilt = FRAC_PI_2 * (step as f32 / END_RINGS as f32 - 1.0);
        for k in 0..AROUND {
            let angle = TAU * k as f32 / AROUND as f32;
            add(center, (across * angle.cos() + third * angle.sin()) * tilt.cos() + along * tilt.sin());
        }
    }
    add(from, -along);
    add(to, along);
    let pole = rings * AROUND;
    for k in 0..AROUND {
        let next = (k + 1) % AROUND;
        for ring in 0..rings - 1 {
            let [a, b] = [k, next].map(|k| ring * AROUND + k);
            mesh.triangles.extend([[a, b, b + AROUND], [a, b + AROUND, a + AROUND]]);
        }
        let end = (rings - 1) * AROUND;
        mesh.triangles.extend([[pole, next, k], [pole + 1, end + k, end + next]]);
    }
    mesh
}

/// A mesh with smooth normals.
fn of_mesh(positions: &[Vec3], triangles: &[[u32; 3]]) -> ColorMesh {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        t.iter().for_each(|&i| normals[i as usize] += (b - a).cross(c - a));
    }
    normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
    ColorMesh {
        positions: positions.to_vec(),
        normals,
        colors: vec![COLOR; positions.len()],
        triangles: triangles.to_vec(),
    }
}

fn moved(mut mesh: ColorMesh, to_posed: &Mat4) -> ColorMesh {
    let turn = Mat3::from_mat4(*to_posed).inverse().transpose();
    mesh.positions.iter_mut().for_each(|p| *p = to_posed.transform_point3(*p));
    mesh.normals.iter_mut().for_each(|n| *n = (turn * *n).normalize_or_zero());
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn a_capsule_has_its_own_volume_and_faces_outward() {
        let volume = |mesh: &ColorMesh| {
            let corners = mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize]));
            corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum::<f32>()
        };
        let (from, to, radius) = (Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.1, 0.5, 0.7), 0.1);
        let exact = PI * radius * radius * 0.5 + 4.0 / 3.0 * PI * radius.powi(3);
        let found = volume(&capsule_mesh(from, to, radius)) / exact;
        assert!((0.95..1.0).contains(&found), "{found}");
        assert!(volume(&capsule_mesh(from, to, 1.1 * radius)) / exact > 1.1, "a thicker one must be seen");
    }
}
