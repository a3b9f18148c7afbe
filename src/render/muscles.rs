//! A rig's muscles as coloured meshes, in the shape that the field gives them.

use super::color_mesh::{ColorMesh, activation_color};
use crate::field::muscle::{AxisPoint, MuscleFrame, MuscleRest, mesh::Detail};
use crate::rig::{Pose, Rig};
use crate::wrap;
use glam::Mat4;

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
        let (points, to_posed) = posed(pose, rest, axes)?;
        Some(muscle_mesh(muscle, points, to_posed))
    });
    meshes.collect()
}

/// A muscle's own points, and the matrix that takes them to scene space.
pub(super) fn posed<'a>(
    pose: &'a Pose,
    rest: &MuscleRest,
    axes: &'a [AxisPoint],
) -> Option<(&'a [AxisPoint], &'a Mat4)> {
    let first = rest.first_point as usize;
    let points = axes.get(first..=first + rest.segments as usize)?;
    Some((points, to_posed(pose, rest)?))
}

/// The matrix that takes a muscle's space, its joint's at rest, to scene space.
pub(super) fn to_posed<'a>(pose: &'a Pose, rest: &MuscleRest) -> Option<&'a Mat4> {
    pose.palette.get(rest.joint as usize)
}
