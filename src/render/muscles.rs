//! A rig's muscles as coloured meshes, in the shape that the field gives them.

use super::color_mesh::{ColorMesh, activation_color};
use crate::error::PoseError;
use crate::field::muscle::{AxisPoint, MuscleFrame, mesh::Detail};
use crate::rig::{FrameInputs, Pose, Rig};
use crate::wrap::{self, ShapeInput};
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

/// All muscles of a rig in one pose.
///
/// # Errors
/// The pose is another character's or not finite.
pub fn muscle_meshes(rig: &Rig, pose: &Pose) -> Result<Vec<ColorMesh>, PoseError> {
    let inputs = FrameInputs::new(rig, pose)?;
    let mut shaped = vec![MuscleFrame::default(); rig.muscles.len()];
    let mut axes = vec![AxisPoint::default(); rig.point_count as usize];
    let input = ShapeInput { joints: &inputs.joints, groups: &inputs.groups, inputs: &inputs.muscles, iterates: &[] };
    wrap::shape(&rig.muscles, &input, &mut shaped, &mut axes);
    let to_posed = |group: u32| pose.palette[rig.grids[group as usize].joint as usize];
    let meshes = rig.muscles.iter().zip(&shaped);
    Ok(meshes.map(|(rest, muscle)| muscle_mesh(muscle, muscle.points(&axes), &to_posed(rest.group))).collect())
}
