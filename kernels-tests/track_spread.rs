//! `track_spread` against its twin.

use crate::support::SIZES;
use crate::track_fixtures::{Crowd, WAYS};
use glam::Vec4;
use sinew::{rig::Role, schedule::KernelId, tracking};

fn cpu(crowd: &Crowd) -> Vec<Vec4> {
    let mut tracked = vec![Vec4::ZERO; crowd.positions.len()];
    for instance in 0..WAYS.len() {
        let own = crowd.of(instance);
        tracking::spread(&crowd.targets, &crowd.positions[own.clone()], &mut tracked[own]);
    }
    tracked
}

fn gpu(crowd: &Crowd) -> Option<Vec<Vec4>> {
    let out = crowd.gpu(KernelId::TrackSpread, 0, crowd.count * WAYS.len(), &[("tracked", 16)])?;
    Some(bytemuck::pod_collect_to_vec(&out[0]))
}

#[test]
fn matches_its_twin_to_the_bit_at_every_size() {
    for size in SIZES.into_iter().chain([3000]) {
        let crowd = Crowd::random(size, 141);
        let Some(tracked) = gpu(&crowd) else { return };
        assert_eq!(tracked, cpu(&crowd), "size {size}");
    }
}

#[test]
fn another_copy_is_found_and_copies_are_where_their_firsts_are() {
    let crowd = Crowd::random(65, 142);
    let expected = cpu(&crowd);
    for (v, target) in crowd.targets.iter().enumerate() {
        let from = if target.role == Role::Copy as u32 { v - 2 } else { v };
        assert_eq!(expected[65 + v], crowd.positions[65 + from]);
    }
    let Some(tracked) = gpu(&crowd) else { return };
    let mut other = crowd.clone();
    other.targets[20].copy_of = 3;
    let other = cpu(&other);
    let over: Vec<usize> = (0..tracked.len()).filter(|&i| tracked[i] != other[i]).collect();
    assert_eq!(over, [20, 85, 150, 215]);
}

#[test]
fn what_is_not_finite_goes_to_its_own_copies_alone() {
    let mut crowd = Crowd::random(65, 143);
    crowd.positions[18] = Vec4::NAN;
    let bad = |tracked: &[Vec4]| (0..tracked.len()).filter(|&i| tracked[i].is_nan()).collect::<Vec<_>>();
    assert_eq!(bad(&cpu(&crowd)), [18, 20]);
    let Some(tracked) = gpu(&crowd) else { return };
    assert_eq!(bad(&tracked), [18, 20]);
}
