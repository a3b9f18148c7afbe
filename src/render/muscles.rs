//! A rig's muscles as coloured meshes, in the shape that the field gives them.

use super::tubes::{Axis, ColorMesh, activation_color, tube};
use crate::error::PoseError;
use crate::field::muscle::MuscleFrame;
use crate::rig::{FrameInputs, Pose, Rig};
use crate::wrap;
use glam::{Mat3, Mat4, Vec4Swizzles};

/// Segments along a muscle and corners round it: fine enough that its outline is smooth at a few hundred pixels.
const SEGMENTS: u32 = 32;
const AROUND: u32 = 32;

/// The surface of one muscle, coloured by its activation. `to_posed` takes the space of its field group at rest to scene
/// space; a muscle without a field gives an empty mesh.
pub fn muscle_mesh(muscle: &MuscleFrame, to_posed: &Mat4) -> ColorMesh {
    if muscle.present == 0 {
        return ColorMesh::default();
    }
    let origin = muscle.origin.xyz();
    let insertion = origin + muscle.axis.xyz() * muscle.origin.w;
    let axis = Axis::straight(origin, insertion, muscle.normal.xyz(), SEGMENTS);
    let color = activation_color(muscle.activation);
    let mut mesh = tube(&axis, AROUND, |s, theta| muscle.radius(s, theta.cos()), |_| color);
    let turn = Mat3::from_mat4(*to_posed).inverse().transpose();
    mesh.positions.iter_mut().for_each(|p| *p = to_posed.transform_point3(*p));
    mesh.normals.iter_mut().for_each(|n| *n = (turn * *n).normalize_or_zero());
    mesh
}

/// All muscles of a rig in one pose.
///
/// # Errors
/// The pose is another character's or not finite.
pub fn muscle_meshes(rig: &Rig, pose: &Pose) -> Result<Vec<ColorMesh>, PoseError> {
    let inputs = FrameInputs::new(rig, pose)?;
    let mut shaped = vec![MuscleFrame::default(); rig.muscles.len()];
    wrap::shape(&rig.muscles, &inputs.joints, &inputs.groups, &mut shaped);
    let to_posed = |group: u32| pose.palette[rig.grids[group as usize].joint as usize];
    Ok(rig.muscles.iter().zip(&shaped).map(|(rest, muscle)| muscle_mesh(muscle, &to_posed(rest.group))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::muscle::{ellipse_squared, evaluate, profile_scale};
    use glam::{Vec3, Vec4};

    fn muscle() -> MuscleFrame {
        let (short_squared, long_squared) = ellipse_squared(0.6);
        MuscleFrame {
            origin: Vec4::new(0.1, 0.2, 0.3, 0.25),
            axis: Vec4::new(0.0, 1.0, 0.0, 4.0),
            normal: Vec4::new(1.0, 0.0, 0.0, 0.02),
            alpha: 3,
            beta: 4,
            profile_scale: profile_scale(3, 4),
            support_radius: 0.03,
            short_squared,
            long_squared,
            activation: 0.5,
            present: 1,
        }
    }

    #[test]
    fn the_mesh_lies_on_the_fields_surface() {
        let mesh = muscle_mesh(&muscle(), &Mat4::IDENTITY);
        // The two poles lie on the axis, where the radius is 0.
        let skin = &mesh.positions[..mesh.positions.len() - 2];
        for p in skin {
            let off_axis = (*p - Vec3::new(0.1, p.y, 0.3)).length();
            let value = evaluate(&muscle(), *p).value;
            // Rounding of a radius by an ulp of the position, at a slope of 31 per metre.
            assert!(off_axis < 1e-4 || (value - 0.5).abs() < 1e-4, "{p} {value}");
        }
        assert!(skin.iter().any(|p| (*p - Vec3::new(0.1, p.y, 0.3)).length() > 0.03));
        assert!((evaluate(&muscle(), skin[500] + Vec3::X * 1e-3).value - 0.5).abs() > 1e-3, "a moved point is off it");
    }

    #[test]
    fn the_mesh_follows_its_bone() {
        let turn = Mat4::from_translation(Vec3::ONE) * Mat4::from_rotation_z(0.7);
        let (rest, posed) = (muscle_mesh(&muscle(), &Mat4::IDENTITY), muscle_mesh(&muscle(), &turn));
        for (a, b) in rest.positions.iter().zip(&posed.positions) {
            assert!(turn.transform_point3(*a).distance(*b) < 1e-6);
        }
        assert_eq!(muscle_mesh(&MuscleFrame::default(), &turn), ColorMesh::default());
    }
}
