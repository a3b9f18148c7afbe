//! Distance fields of the bones whose shape is a mesh.

use super::{BoneCollider, Character, ColliderShape, MuscleSpec, Rig};
use crate::error::{BoneError, MeshDistanceError};
use crate::field::grid::FilledGrid;
use crate::field::muscle::{MuscleRest, Profile};
use crate::field::{GroupGrid, mesh_distance};
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// How short a muscle becomes, in its length at rest, and so how thick: shorter ones do not occur in a body.
const SHORTEST: f32 = 0.5;
/// Room beyond the thickest muscle, as a share of the mesh's longest side: for the way of a substep.
const ROOM: f64 = 0.05;
/// Most room around a mesh, in its longest side: more would leave its own shape too few nodes.
const MOST_ROOM: f64 = 1.5;

/// Fills the distance fields of all bones that are meshes; their nodes follow the rig's others.
///
/// Around a mesh there is room for the largest radius that any muscle of the rig may come to have, so that a muscle is
/// held before it touches.
///
/// # Errors
/// A mesh without a distance field, with its bone.
pub(super) fn build(rig: &mut Rig) -> Result<(), BoneError> {
    let own = |m: &MuscleRest, spec: u32| largest_radius(m, &rig.specs[spec as usize]);
    let radius = rig.muscles.iter().zip(&rig.spec_of).map(|(m, &spec)| own(m, spec)).fold(0.0, f32::max);
    // Collected before the first error is looked for, so that the same bone is named every time.
    let filled: Vec<Option<Result<FilledGrid, MeshDistanceError>>> =
        rig.bones.par_iter().map(|bone| field(&rig.character, bone, f64::from(radius))).collect();
    for (index, filled) in filled.into_iter().enumerate() {
        let Some(filled) = filled else { continue };
        let joint = rig.bones[index].joint;
        let refuse = |what: String| {
            let bone = rig.character.joints[joint as usize].name.clone();
            BoneError::Shape { bone, key: "mesh".into(), what: format!("its mesh cannot be collided with: {what}") }
        };
        let filled = filled.map_err(|error| refuse(error.to_string()))?;
        let offset =
            u32::try_from(rig.nodes.len()).ok().filter(|at| at.checked_add(filled.nodes.len() as u32).is_some());
        let offset = offset.ok_or_else(|| refuse("the grids have too many nodes; give fewer meshes".into()))?;
        rig.bones[index].grid = GroupGrid { offset, joint, ..filled.grid };
        rig.nodes.extend(filled.nodes);
    }
    Ok(())
}

/// The thickest that a fibre may come to be, metres.
fn largest_radius(rest: &MuscleRest, spec: &MuscleSpec) -> f32 {
    let shape = |alpha, beta| Profile::of(alpha, beta).max();
    let keyed = spec.keys.shape.shapes.iter().map(|&(alpha, beta)| shape(alpha, beta));
    let highest = [spec.rest, spec.active].into_iter().map(|s| shape(s.alpha, s.beta)).chain(keyed).fold(0.0, f32::max);
    let wider = spec.keys.width.values.iter().copied().fold(1.0, f32::max);
    let width = (rest.origin.w / (std::f32::consts::PI * rest.origin_normal.w * SHORTEST)).sqrt();
    width * highest * wider * spec.rest.width.max(spec.active.width)
}

/// A mesh's field in scene space at rest, and nothing of a capsule.
fn field(character: &Character, bone: &BoneCollider, radius: f64) -> Option<Result<FilledGrid, MeshDistanceError>> {
    let ColliderShape::Mesh { positions, triangles } = &bone.shape else { return None };
    let bind = character.joints[bone.joint as usize].bind();
    let placed: Vec<Vec3> = positions.iter().map(|p| bind.transform_point3(*p)).collect();
    // Along the joint or along the scene, whichever has the smaller box: bones lie along their joints as a rule.
    let sides = |axes: &DMat3| {
        let turned = placed.iter().map(|p| axes.transpose() * p.as_dvec3());
        let (lo, hi) = turned.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)));
        hi - lo
    };
    let axes = [joint_axes(&bind), DMat3::IDENTITY];
    let [own, scene] = [sides(&axes[0]), sides(&axes[1])];
    let room = |sides: DVec3| (radius + ROOM * sides.max_element()).min(MOST_ROOM * sides.max_element());
    let volume = |sides: DVec3| (sides + 2.0 * room(sides)).element_product();
    let (axes, sides) = if volume(own) < volume(scene) { (axes[0], own) } else { (axes[1], scene) };
    Some(mesh_distance::fill(&placed, triangles, axes, room(sides)))
}

/// A joint's own directions in the scene, made orthonormal; the scene's where it has none.
fn joint_axes(bind: &glam::Mat4) -> DMat3 {
    let y = bind.y_axis.truncate().as_dvec3().normalize_or_zero();
    let z = y.cross(bind.x_axis.truncate().as_dvec3()).normalize_or_zero();
    if y == DVec3::ZERO || z == DVec3::ZERO { DMat3::IDENTITY } else { DMat3::from_cols(y, z, y.cross(z)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::grid;
    use crate::rig::muscle::{BoneShape, BoneSpec};
    use crate::rig::{BoneMesh, BuildOptions};

    /// A box along the upper arm, `half` its sides, metres, with its centre `along` the bone.
    fn mesh(character: &Character, half: Vec3, along: f32) -> BoneMesh {
        let joint = character.joints.iter().position(|j| j.name == "upperarm").expect("the bone");
        let bind = character.joints[joint].bind();
        let corner = |i: usize| Vec3::from([i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| bit as f32 * 2.0 - 1.0));
        let positions = (0..8).map(|i| bind.transform_point3(corner(i) * half + Vec3::Y * along)).collect();
        let faces = [[0u32, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        BoneMesh { name: "humerus".into(), positions, triangles }
    }

    #[test]
    fn a_bones_mesh_has_a_field_behind_those_of_the_groups() {
        let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
        let scene = crate::io::gltf::read(&assets.join("arm.glb")).expect("the arm");
        let file = crate::rig::muscle_file::read(&assets.join("arm.muscles.toml")).expect("its muscles");
        let half = Vec3::new(0.012, 0.11, 0.015);
        let build = |meshes: Vec<BoneMesh>| {
            let spec = BoneSpec { bone: "upperarm".into(), shape: BoneShape::Mesh("humerus".into()) };
            let bones = if meshes.is_empty() { Vec::new() } else { vec![spec] };
            let options = BuildOptions { bones, bone_meshes: meshes, ..BuildOptions::default() };
            Rig::build(scene.character.clone(), &file.muscles, &options)
        };
        let plain = build(Vec::new()).expect("a rig");
        let rig = build(vec![mesh(&scene.character, half, 0.15)]).expect("a rig");
        assert!(plain.bones.iter().all(|b| b.grid.size_x == 0));
        assert_eq!(rig.nodes[..plain.nodes.len()], plain.nodes[..]);
        let bone = rig.bones.iter().find(|b| b.given).expect("the given bone");
        assert_eq!((bone.grid.offset as usize, bone.grid.joint), (plain.nodes.len(), bone.joint));
        // The box is along its joint, and so is the grid: thin across.
        let sizes = [bone.grid.size_x, bone.grid.size_y, bone.grid.size_z];
        assert!(sizes[0] >= 48 && sizes[1].max(sizes[2]) * 3 < sizes[0] * 2, "{sizes:?}");
        let bind = rig.character.joints[bone.joint as usize].bind();
        let worst = |along: f32| {
            let mut worst = 0.0f32;
            for k in 0..400 {
                let t = k as f32;
                let p = Vec3::new((t * 0.37).sin() * 0.03, 0.15 + (t * 0.61).cos() * 0.13, (t * 0.83).sin() * 0.03);
                let at = bind.transform_point3(p);
                let (distance, gradient) = grid::sample(&bone.grid, &rig.nodes, at).expect("room around it");
                let q = (p - Vec3::Y * along).abs() - half;
                worst = worst.max((distance - q.max(Vec3::ZERO).length() - q.max_element().min(0.0)).abs());
                assert!(gradient.length() < 1.0001);
            }
            worst
        };
        assert!(worst(0.15) < 2e-3, "{}", worst(0.15));
        assert!(worst(0.16) > 4e-3, "another place must be seen");
        let mut far = mesh(&scene.character, half, 0.15);
        far.positions.iter_mut().for_each(|p| *p = *p * 1e-4 + 50.0);
        let refused = build(vec![far]).expect_err("no grid there").to_string();
        assert!(refused.starts_with("bone `upperarm`: its mesh cannot be collided with: "), "{refused}");
    }
}
