//! `track_start` against its twin.

use crate::support::SIZES;
use crate::track_fixtures::{Crowd, WAYS};
use glam::Vec4;
use sinew::{
    schedule::KernelId,
    tracking::{self, Track},
};

fn cpu(crowd: &Crowd) -> (Vec<Vec4>, Vec<Track>) {
    let (mut positions, mut tracks) = (crowd.positions.clone(), crowd.tracks.clone());
    let skinned = crowd.skinned();
    for (instance, way) in WAYS.iter().enumerate() {
        let own = crowd.of(instance);
        tracking::start(way, &skinned[own.clone()], &mut positions[own.clone()], &mut tracks[own]);
    }
    (positions, tracks)
}

fn gpu(crowd: &Crowd) -> Option<(Vec<Vec4>, Vec<Track>)> {
    let outputs = [("positions", 16), ("tracks", size_of::<Track>())];
    let out = crowd.gpu(KernelId::TrackStart, 0, crowd.count * WAYS.len(), &outputs)?;
    Some((bytemuck::pod_collect_to_vec(&out[0]), bytemuck::pod_collect_to_vec(&out[1])))
}

#[test]
fn matches_its_twin_to_the_bit_at_every_size() {
    for size in SIZES.into_iter().chain([3000]) {
        let crowd = Crowd::random(size, 151);
        let Some(found) = gpu(&crowd) else { return };
        assert!(found == cpu(&crowd), "size {size}");
    }
}

#[test]
fn who_has_a_pose_starts_anew_and_all_others_stay() {
    let crowd = Crowd::random(65, 152);
    let (positions, tracks) = cpu(&crowd);
    let skinned = crowd.skinned();
    for (v, track) in tracks.iter().enumerate() {
        let starts = WAYS[v / 65].count > 0;
        let expected = if starts { Track { runs: 1, ..Track::REST } } else { Track { runs: 0, ..crowd.tracks[v] } };
        assert!(*track == expected && positions[v] == if starts { skinned[v] } else { crowd.positions[v] }, "{v}");
    }
}

#[test]
fn another_skin_is_found() {
    let crowd = Crowd::random(65, 153);
    let Some((positions, _)) = gpu(&crowd) else { return };
    let mut other = crowd.clone();
    other.positions[12].y += 1e-3;
    let expected = cpu(&other).0;
    let over: Vec<usize> = (0..positions.len()).filter(|&i| positions[i] != expected[i]).collect();
    assert_eq!(over, [12]);
}
