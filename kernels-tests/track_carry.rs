//! `track_carry` against its twin.

use crate::support::SIZES;
use crate::track_fixtures::{Crowd, SUB_POSES, WAYS, apart, degenerate};
use glam::Vec4;
use sinew::{
    rig::Role,
    schedule::KernelId,
    tracking::{self, Track},
};

/// Two blends of up to three matrices, and three sums: a few ulp of coordinates up to 1.
const CARRIED: f32 = 1e-6;

fn cpu(crowd: &Crowd, sub_pose: usize) -> (Vec<Vec4>, Vec<Track>) {
    let (mut positions, mut tracks) = (crowd.positions.clone(), crowd.tracks.clone());
    for (instance, way) in WAYS.iter().enumerate() {
        let own = crowd.of(instance);
        let (positions, tracks) = (&mut positions[own.clone()], &mut tracks[own]);
        tracking::carry(&crowd.params(sub_pose), way, &crowd.carry_input(sub_pose, instance), positions, tracks);
    }
    (positions, tracks)
}

fn gpu(crowd: &Crowd, sub_pose: usize) -> Option<(Vec<Vec4>, Vec<Track>)> {
    let outputs = [("positions", 16), ("tracks", size_of::<Track>())];
    let out = crowd.gpu(KernelId::TrackCarry, sub_pose, crowd.count * WAYS.len(), &outputs)?;
    Some((bytemuck::pod_collect_to_vec(&out[0]), bytemuck::pod_collect_to_vec(&out[1])))
}

/// What takes part: in a sub-pose, only in the last passes, not at all.
fn part(sub_pose: usize, instance: usize) -> u32 {
    match WAYS[instance] {
        way if sub_pose < way.count as usize => 1,
        way if way.posed != 0 => 2,
        _ => 0,
    }
}

#[test]
fn matches_its_twin_at_every_size_and_sub_pose() {
    let mut worst = 0.0f32;
    for size in SIZES.into_iter().chain([3000]) {
        let crowd = Crowd::random(size, 101);
        for sub_pose in 0..SUB_POSES {
            let Some((positions, tracks)) = gpu(&crowd, sub_pose) else { return };
            let (expected, expected_tracks) = cpu(&crowd, sub_pose);
            worst = worst.max(apart(&positions, &expected));
            assert!(worst <= CARRIED, "size {size}, sub-pose {sub_pose}: {worst}");
            for (i, (found, expected)) in tracks.iter().zip(&expected_tracks).enumerate() {
                assert_eq!(found.runs, part(sub_pose, i / size), "size {size}, sub-pose {sub_pose}, vertex {i}");
                assert_eq!(Track { runs: 0, ..*found }, Track { runs: 0, ..*expected }, "vertex {i}");
            }
        }
    }
    println!("track_carry: at most {worst:.1e} m apart");
}

#[test]
fn another_joint_is_found() {
    let crowd = Crowd::random(65, 102);
    let Some((positions, _)) = gpu(&crowd, 0) else { return };
    let mut other = crowd.clone();
    other.joints[1].carry.w_axis.x += 1e-3;
    let expected = cpu(&other, 0).0;
    let over = |i: &usize| apart(&positions[*i..=*i], &expected[*i..=*i]) > CARRIED;
    let over: Vec<usize> = (0..positions.len()).filter(over).collect();
    assert!(over.len() > 10 && over.iter().all(|&i| i < 65), "{over:?}");
}

#[test]
fn copies_stay_and_whoever_has_no_sub_pose() {
    let crowd = Crowd::random(65, 103);
    let (positions, _) = cpu(&crowd, 2);
    let moved = |i: usize| positions[i] != crowd.positions[i];
    assert!((65..positions.len()).all(|i| !moved(i)), "one instance alone has a third sub-pose");
    for (v, target) in crowd.targets.iter().enumerate() {
        assert_eq!(moved(v), target.role != Role::Copy as u32, "vertex {v}");
    }
}

#[test]
fn nothing_that_is_not_finite_leaves() {
    let crowd = degenerate(300, 104);
    for sub_pose in 0..SUB_POSES {
        let (positions, tracks) = cpu(&crowd, sub_pose);
        assert!(positions.iter().all(|p| p.is_finite()) && tracks.iter().all(|t| t.rotation.is_finite()));
        let Some((positions, _)) = gpu(&crowd, sub_pose) else { return };
        assert!(positions.iter().all(|p| p.is_finite()), "sub-pose {sub_pose}");
    }
}
