//! `track_average` against its twin.

use crate::support::SIZES;
use crate::track_fixtures::{Crowd, WAYS, apart, degenerate};
use glam::Vec4;
use sinew::{rig::Role, schedule::KernelId, tracking};

/// Five edges, a square of a square and a product: a few ulp of coordinates up to 1.
const AVERAGED: f32 = 1e-6;

fn cpu(crowd: &Crowd, smooths: bool) -> Vec<Vec4> {
    let mut averaged = vec![Vec4::ZERO; crowd.positions.len()];
    for instance in 0..WAYS.len() {
        let own = crowd.of(instance);
        let (tracks, positions) = (&crowd.tracks[own.clone()], &crowd.positions[own.clone()]);
        let params = crowd.params_of(0, smooths);
        tracking::average(&params, &crowd.average_input(), tracks, positions, &mut averaged[own]);
    }
    averaged
}

fn gpu(crowd: &Crowd, smooths: bool) -> Option<Vec<Vec4>> {
    let items = crowd.count * WAYS.len();
    let out = crowd.gpu_with(&crowd.params_of(0, smooths), KernelId::TrackAverage, items, &[("averaged", 16)])?;
    Some(bytemuck::pod_collect_to_vec(&out[0]))
}

/// With residuals of all sizes.
fn crowd(count: usize, seed: u64) -> Crowd {
    let mut crowd = Crowd::random(count, seed);
    crowd.tracks.iter_mut().enumerate().for_each(|(v, t)| t.normal.w *= [0.0, 1.0, 30.0, 120.0][v % 4]);
    crowd
}

#[test]
fn matches_its_twin_at_every_size() {
    let mut worst = 0.0f32;
    for size in SIZES.into_iter().chain([3000]) {
        let crowd = crowd(size, 161);
        for smooths in [false, true] {
            let Some(averaged) = gpu(&crowd, smooths) else { return };
            worst = worst.max(apart(&averaged, &cpu(&crowd, smooths)));
            assert!(worst <= AVERAGED, "size {size}: {worst}");
        }
    }
    println!("track_average: at most {worst:.1e} m apart");
}

#[test]
fn an_instance_that_only_ends_is_not_written() {
    let mut crowd = crowd(65, 162);
    let still = crowd.of(2);
    crowd.tracks[still.clone()].iter_mut().for_each(|t| t.runs = 2);
    let Some(averaged) = gpu(&crowd, false) else { return };
    let expected = cpu(&crowd, false);
    assert!(apart(&averaged[..still.start], &expected[..still.start]) <= AVERAGED);
    assert!(averaged[still].iter().all(|p| p.x.to_bits() == crate::support::JUNK));
}

#[test]
fn another_coordinate_and_another_contact_are_found() {
    let crowd = crowd(300, 163);
    for smooths in [false, true] {
        let Some(averaged) = gpu(&crowd, smooths) else { return };
        let mut other = crowd.clone();
        let at = other.targets[42].edge_begin as usize;
        other.mean_values[at] += 0.1;
        // Vertex 41 is a neighbour of 40, 34, 29, 21 and 8; 34 is a copy, 29 and others do not slide.
        other.tracks[41].contact = 1.0 - other.tracks[41].contact;
        let expected = cpu(&other, smooths);
        let over = |i: &usize| apart(&averaged[*i..=*i], &expected[*i..=*i]) > AVERAGED;
        let over: Vec<usize> = (0..averaged.len()).filter(over).collect();
        // Coordinates are the character's, contacts an instance's own.
        let those: &[usize] = if smooths { &[8, 21, 29, 40, 41] } else { &[42, 342, 642, 942] };
        assert!(!over.is_empty() && over.iter().all(|i| those.contains(i)), "{smooths}: {over:?}");
    }
}

#[test]
fn who_has_arrived_stays_and_nobody_leaves_the_tangent_plane() {
    let crowd = crowd(300, 164);
    let averaged = cpu(&crowd, false);
    let mut moved = 0;
    for (v, track) in crowd.tracks.iter().enumerate() {
        let way = averaged[v] - crowd.positions[v];
        if track.normal.w == 0.0 || crowd.targets[v % 300].role != Role::Active as u32 {
            assert_eq!(way, Vec4::ZERO, "vertex {v}");
        }
        assert!(way.truncate().dot(track.normal.truncate()).abs() < 1e-6, "vertex {v}");
        moved += usize::from(way.length() > 1e-3);
    }
    assert!(moved > 100, "{moved}");
    let smoothed = cpu(&crowd, true);
    assert!(
        (0..300)
            .any(|v| (smoothed[v] - crowd.positions[v]).truncate().dot(crowd.tracks[v].normal.truncate()).abs() > 1e-3)
    );
}

#[test]
fn nothing_that_is_not_finite_leaves() {
    let mut crowd = degenerate(300, 165);
    crowd.tracks.iter_mut().step_by(9).for_each(|t| t.normal = Vec4::ZERO);
    for smooths in [false, true] {
        assert!(cpu(&crowd, smooths).iter().all(|p| p.is_finite()));
        let Some(averaged) = gpu(&crowd, smooths) else { return };
        assert!(averaged.iter().all(|p| p.is_finite()));
    }
}
