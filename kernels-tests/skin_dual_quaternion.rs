//! `skin_dual_quaternion` against its twin, and the twin against closed forms.

use crate::{
    skin_linear::{Skin, joint},
    support::SIZES,
};
use glam::{Mat4, Quat, Vec3, Vec4, Vec4Swizzles};
use sinew::{
    parity,
    rig::Influence,
    schedule::KernelId,
    skinning::{self, SkinInput},
};

#[test]
fn matches_its_twin_at_every_size() {
    for size in SIZES {
        let skin = Skin::random(size, 2, 21);
        let Some(gpu) = skin.gpu(KernelId::SkinDualQuaternion, 2) else { return };
        for instance in 0..2 {
            let mut cpu = vec![Vec4::ZERO; size];
            skinning::dual_quaternion(&skin.input(instance), &mut cpu);
            let gpu = &gpu[instance * size..(instance + 1) * size];
            let report = parity::vectors("skinned", gpu, &cpu, 1.0, parity::SKINNED);
            assert!(report.pass, "size {size}: {report:?}");
        }
    }
}

#[test]
fn a_turned_joint_is_found() {
    let skin = Skin::random(65, 1, 22);
    let Some(gpu) = skin.gpu(KernelId::SkinDualQuaternion, 1) else { return };
    let mut changed = Skin::random(65, 1, 22);
    changed.joints[4] = joint(&(changed.joints[4].matrix * Mat4::from_rotation_x(1e-3)));
    let mut cpu = vec![Vec4::ZERO; 65];
    skinning::dual_quaternion(&changed.input(0), &mut cpu);
    assert!(!parity::vectors("skinned", &gpu, &cpu, 1.0, parity::SKINNED).pass);
}

fn skinned(joints: &[Mat4], weights: &[f32], p: Vec3) -> Vec3 {
    let joints: Vec<_> = joints.iter().map(joint).collect();
    let influences: Vec<_> =
        weights.iter().enumerate().map(|(j, &weight)| Influence { joint: j as u32, weight }).collect();
    let rest = [p.extend(1.0)];
    let offsets = [0, influences.len() as u32];
    let input = SkinInput { joints: &joints, positions_rest: &rest, offsets: &offsets, influences: &influences };
    let mut out = [Vec4::ZERO];
    skinning::dual_quaternion(&input, &mut out);
    out[0].xyz()
}

#[test]
fn the_hinge_of_the_background_keeps_its_radius() {
    // Background 5: hinge at (0, 0, 1), 90 degrees, halves: exactly a 45 degree turn, where linear blending collapses.
    let at = Mat4::from_translation(Vec3::Z);
    let hinge = at * Mat4::from_rotation_x(std::f32::consts::FRAC_PI_2) * at.inverse();
    let p = skinned(&[Mat4::IDENTITY, hinge], &[0.5, 0.5], Vec3::new(0.0, 0.25, 1.0));
    assert!((p - Vec3::new(0.0, 0.17678, 1.17678)).length() < 1e-5, "{p}");
}

#[test]
fn one_joint_is_that_joint_stretch_included() {
    let m = Mat4::from_scale_rotation_translation(Vec3::new(2.0, 0.5, 1.0), Quat::from_rotation_y(2.0), Vec3::ONE);
    let p = Vec3::new(0.3, -0.7, 0.2);
    assert!((skinned(&[m], &[1.0], p) - m.transform_point3(p)).length() < 1e-6);
}

#[test]
fn opposite_hemispheres_take_the_short_way() {
    let turn = |degrees: f32| Mat4::from_rotation_z(degrees.to_radians());
    let p = skinned(&[turn(170.0), turn(-170.0)], &[0.5, 0.5], Vec3::X);
    assert!((p - Vec3::NEG_X).length() < 1e-5, "{p}");
}
