//! What one pose makes of a rig: the plain data that both the kernels and their twins read.

use super::{Pose, Rig};
use crate::{
    error::PoseError,
    field::{GroupGrid, bound::ROUNDING, evaluate::GroupFrame, muscle::MuscleInput},
    math::polar,
};
use glam::{Mat4, Quat, UVec3, Vec4};

crate::gpu_struct! {
    /// One joint at one moment.
    pub struct JointFrame {
        /// Palette entry: scene space at rest to scene space posed.
        pub matrix: Mat4,
        /// Rotation of the rigid part, `xyzw`.
        pub real: Vec4,
        /// Dual part `1/2 (t, 0) q` of the rigid part.
        pub dual: Vec4,
        /// Stretch that comes before the rigid part: upper 3x3, no translation.
        pub stretch: Mat4,
    }
}

/// One instance's inputs of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameInputs {
    /// One per joint.
    pub joints: Vec<JointFrame>,
    /// One per field group; empty where the rig has no fields.
    pub groups: Vec<GroupFrame>,
    /// One per muscle.
    pub muscles: Vec<MuscleInput>,
}

impl FrameInputs {
    /// Validates a pose against its rig and derives what the stages read.
    ///
    /// # Errors
    /// The pose has another number of joints, a time that is not finite, or such a matrix; the joint is named.
    pub fn new(rig: &Rig, pose: &Pose) -> Result<FrameInputs, PoseError> {
        let joints = &rig.character.joints;
        if pose.palette.len() != joints.len() {
            return Err(PoseError::JointCount { given: pose.palette.len(), needed: joints.len() });
        }
        if !pose.time.is_finite() {
            return Err(PoseError::Time { time: pose.time });
        }
        if let Some(bad) = pose.palette.iter().position(|m| !m.is_finite()) {
            return Err(PoseError::NonFinite { joint: joints[bad].name.clone(), time: pose.time });
        }
        Ok(FrameInputs {
            joints: pose.palette.iter().map(joint_frame).collect(),
            groups: group_frames(rig, &pose.palette),
            muscles: muscle_inputs(rig, pose)?,
        })
    }
}

/// A sphere around a grid's box as a joint poses it: its centre, and the square of its radius, negative where muscles may
/// reach beyond it.
fn sphere(grid: &GroupGrid, matrix: &Mat4) -> Vec4 {
    let last = UVec3::new(grid.size_x, grid.size_y, grid.size_z).as_vec3() - 1.0;
    let to_posed = *matrix * grid.rest_to_grid.inverse();
    let centre = to_posed.transform_point3(last * 0.5);
    let corner = |k: u32| last * UVec3::new(k & 1, k >> 1 & 1, k >> 2).as_vec3();
    let squared = (0..8).map(|k| to_posed.transform_point3(corner(k)).distance_squared(centre)).fold(0.0, f32::max);
    let held = squared * ROUNDING;
    centre.extend(if grid.muscle_begin < grid.muscle_end { -held } else { held })
}

/// The field groups of a rig whose joints take scene space at rest to scene space posed by `palette`.
pub fn group_frames(rig: &Rig, palette: &[Mat4]) -> Vec<GroupFrame> {
    let of = |grid: &GroupGrid| {
        let matrix = palette[grid.joint as usize];
        let volume = matrix.determinant().abs();
        let to_rest = matrix.inverse();
        let present = volume > 1e-12 && to_rest.is_finite();
        GroupFrame {
            bounds: sphere(grid, &matrix),
            to_rest: if present { to_rest } else { Mat4::IDENTITY },
            grid: *grid,
            scale: volume.cbrt(),
            present: present.into(),
            ..GroupFrame::default()
        }
    };
    let mut groups: Vec<GroupFrame> = rig.grids.iter().map(of).collect();
    for fold in &rig.folds {
        let [parent, child] = fold.posed(&groups);
        groups[fold.parent as usize].fold_end = parent;
        groups[fold.child as usize].fold_start = child;
    }
    groups
}

/// What keys and drivers make of every muscle; fibres of a set share theirs.
fn muscle_inputs(rig: &Rig, pose: &Pose) -> Result<Vec<MuscleInput>, PoseError> {
    if rig.muscles.is_empty() {
        return Ok(Vec::new());
    }
    let parameters = rig.drives.parameters(pose, &rig.axis_ratios(pose))?;
    let inputs: Vec<MuscleInput> = parameters.iter().map(MuscleInput::from).collect();
    Ok(rig.spec_of.iter().map(|&spec| inputs[spec as usize]).collect())
}

fn joint_frame(matrix: &Mat4) -> JointFrame {
    let (rotation, translation, stretch) = polar(matrix);
    let half = Quat::from_xyzw(translation.x * 0.5, translation.y * 0.5, translation.z * 0.5, 0.0) * rotation;
    JointFrame { matrix: *matrix, real: rotation.into(), dual: half.into(), stretch }
}
