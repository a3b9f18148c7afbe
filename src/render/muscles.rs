//! A rig's muscles as coloured meshes, in the shape that the field gives them, and their axes as beads on strings.

use super::color_mesh::{ColorMesh, activation_color};
use crate::dynamics::Particle;
use crate::field::muscle::{AxisPoint, MuscleFrame, MuscleRest, mesh::Detail};
use crate::rig::{Pose, Rig};
use crate::wrap;
use glam::{Mat4, Vec3, Vec4Swizzles};

/// Radius of a bead over the distance of two, and of the string over the bead's.
const BEAD: f32 = 0.28;
const STRING: f32 = 0.35;
/// Linear RGB of beads: free; fixed to a bone; held by another muscle, by a bone, by the skin. Of the palette of Okabe and
/// Ito, which everybody can tell apart.
const FREE: [f32; 3] = [0.80, 0.80, 0.76];
const FIXED: [f32; 3] = [0.02, 0.02, 0.02];
const BY_MUSCLE: [f32; 3] = [0.09, 0.46, 0.81];
const BY_BONE: [f32; 3] = [0.86, 0.60, 0.0];
const BY_SKIN: [f32; 3] = [0.0, 0.34, 0.17];

/// The surface of one muscle, coloured by its activation; `points` are its own. `to_posed` takes the space of its field
/// group at rest to scene space; a muscle without a field has all its vertices at one point.
pub fn muscle_mesh(muscle: &MuscleFrame, points: &[AxisPoint], to_posed: &Mat4) -> ColorMesh {
    let surface = wrap::posed_surface(muscle, points, to_posed, Detail::DISPLAY);
    ColorMesh {
        colors: vec![activation_color(muscle.activation); surface.positions.len()],
        positions: surface.positions,
        normals: surface.normals,
        triangles: surface.triangles,
    }
}

/// All muscles of a rig as they were shaped for a pose; `axes` are the points of all of them. A muscle that pose or frame
/// lacks is left out.
pub fn muscle_meshes(rig: &Rig, pose: &Pose, shaped: &[MuscleFrame], axes: &[AxisPoint]) -> Vec<ColorMesh> {
    let meshes = rig.muscles.iter().zip(shaped).filter_map(|(rest, muscle)| {
        let (points, to_posed) = posed(rig, pose, rest, axes)?;
        Some(muscle_mesh(muscle, points, to_posed))
    });
    meshes.collect()
}

/// The axes of all muscles of a rig, as [`muscle_meshes`] takes them, with a bead on each point: light where it is free,
/// black at the ends; blue, amber or green where mostly another muscle, a bone or the skin held it in the last substep.
/// Without particles there are no axes to see.
pub fn axis_meshes(rig: &Rig, pose: &Pose, axes: &[AxisPoint], particles: &[Particle]) -> Vec<ColorMesh> {
    let meshes = rig.muscles.iter().filter_map(|rest| {
        let (points, to_posed) = posed(rig, pose, rest, axes)?;
        let own = particles.get(rest.first_point as usize..)?.get(..points.len())?;
        let places: Vec<Vec3> = points.iter().map(|p| to_posed.transform_point3(p.position.xyz())).collect();
        let length: f32 = places.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        let radius = BEAD * length / (places.len() - 1).max(1) as f32;
        let mut mesh = ColorMesh::default();
        for pair in places.windows(2) {
            add_string(&mut mesh, pair[0], pair[1], STRING * radius);
        }
        for (&place, particle) in places.iter().zip(own) {
            add_bead(&mut mesh, place, radius, bead_color(particle));
        }
        Some(mesh)
    });
    meshes.collect()
}

/// A muscle's own points, and the matrix that takes them to scene space.
fn posed<'a>(
    rig: &Rig,
    pose: &'a Pose,
    rest: &MuscleRest,
    axes: &'a [AxisPoint],
) -> Option<(&'a [AxisPoint], &'a Mat4)> {
    let first = rest.first_point as usize;
    let points = axes.get(first..=first + rest.segments as usize)?;
    let to_posed = pose.palette.get(rig.grids.get(rest.group as usize)?.joint as usize)?;
    Some((points, to_posed))
}

/// The colour of what pushed most.
fn bead_color(particle: &Particle) -> [f32; 3] {
    if particle.velocity.w == 0.0 {
        return FIXED;
    }
    let held = particle.pushes;
    let kinds = [(held.x.max(held.y), BY_MUSCLE), (held.z, BY_BONE), (held.w, BY_SKIN)];
    let most = kinds.iter().fold((0.0, FREE), |most, &kind| if kind.0 > most.0 { kind } else { most });
    most.1
}

/// An icosahedron, round enough for a few pixels.
fn add_bead(mesh: &mut ColorMesh, center: Vec3, radius: f32, color: [f32; 3]) {
    const CORNERS: [[f32; 3]; 12] = {
        const A: f32 = 0.525_731_1;
        const B: f32 = 0.850_650_8;
        [
            [-A, B, 0.0],
            [A, B, 0.0],
            [-A, -B, 0.0],
            [A, -B, 0.0],
            [0.0, -A, B],
            [0.0, A, B],
            [0.0, -A, -B],
            [0.0, A, -B],
            [B, 0.0, -A],
            [B, 0.0, A],
            [-B, 0.0, -A],
            [-B, 0.0, A],
        ]
    };
    const FACES: [[u32; 3]; 20] = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let normals = CORNERS.map(Vec3::from);
    mesh.append(&ColorMesh {
        positions: normals.iter().map(|n| center + *n * radius).collect(),
        normals: normals.to_vec(),
        colors: vec![color; normals.len()],
        triangles: FACES.to_vec(),
    });
}

/// A prism with three sides and open ends, which the beads close.
fn add_string(mesh: &mut ColorMesh, from: Vec3, to: Vec3, radius: f32) {
    let along = (to - from).normalize_or(Vec3::Y);
    let across = along.any_orthonormal_vector();
    let third = along.cross(across);
    let side = |k: u32| {
        let (sine, cosine) = (std::f32::consts::TAU * k as f32 / 3.0).sin_cos();
        across * cosine + third * sine
    };
    let normals: Vec<Vec3> = (0..6).map(|i| side(i % 3)).collect();
    let place = |(i, n): (usize, &Vec3)| (if i < 3 { from } else { to }) + *n * radius;
    mesh.append(&ColorMesh {
        positions: normals.iter().enumerate().map(place).collect(),
        colors: vec![FREE; normals.len()],
        triangles: (0..3).flat_map(|k| [[k, (k + 1) % 3, k + 3], [(k + 1) % 3, (k + 1) % 3 + 3, k + 3]]).collect(),
        normals,
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    fn volume(mesh: &ColorMesh) -> f32 {
        let corners = mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize]));
        corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    #[test]
    fn beads_face_outward_and_are_nearly_round() {
        let mut bead = ColorMesh::default();
        add_bead(&mut bead, Vec3::new(1.0, 2.0, 3.0), 0.5, FREE);
        let share = volume(&bead) / (4.0 / 3.0 * std::f32::consts::PI * 0.125);
        assert!((0.58..0.63).contains(&share), "{share}: an icosahedron fills .605 of its sphere");
        bead.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(volume(&bead) < 0.0, "inside out must be seen");
    }

    #[test]
    fn a_bead_has_the_colour_of_what_holds_it_most() {
        let color = |pushes, mobility| {
            bead_color(&Particle { pushes, velocity: Vec3::ZERO.extend(mobility), ..Particle::default() })
        };
        assert_eq!(color(Vec4::ZERO, 1.0), FREE);
        assert_eq!(color(Vec4::ONE, 0.0), FIXED);
        assert_eq!(color(Vec4::new(0.0, 0.3, 0.1, 0.2), 1.0), BY_MUSCLE);
        assert_eq!(color(Vec4::new(0.0, 0.1, 0.3, 0.2), 1.0), BY_BONE);
        assert_eq!(color(Vec4::new(0.0, 0.1, 0.1, 0.2), 1.0), BY_SKIN);
    }
}
