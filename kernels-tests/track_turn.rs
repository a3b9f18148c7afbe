//! `track_turn` against its twin.

use crate::support::SIZES;
use crate::track_fixtures::{Crowd, WAYS, apart, degenerate, rotations};
use sinew::{
    schedule::KernelId,
    tracking::{self, Track},
};

/// Three steps, each divided by how far edges agree, a tenth and more of what they could: 2^-24 x 16 x 3 x 10.
const TURNED: f32 = 3e-5;

/// A crowd whose second instance stands still.
fn crowd(count: usize, seed: u64) -> Crowd {
    let mut crowd = Crowd::random(count, seed);
    let still = crowd.of(1);
    crowd.tracks[still].iter_mut().for_each(|t| t.runs = 2);
    crowd
}

fn cpu(crowd: &Crowd) -> Vec<Track> {
    let mut tracks = crowd.tracks.clone();
    for instance in [0, 2, 3] {
        let own = crowd.of(instance);
        tracking::turn(&crowd.params(0), &crowd.relax_input(), &crowd.positions[own.clone()], &mut tracks[own]);
    }
    tracks
}

fn gpu(crowd: &Crowd) -> Option<Vec<Track>> {
    let items = crowd.count * WAYS.len();
    let out = crowd.gpu(KernelId::TrackTurn, 0, items, &[("tracks", size_of::<Track>())])?;
    Some(bytemuck::pod_collect_to_vec(&out[0]))
}

#[test]
fn matches_its_twin_at_every_size() {
    let mut worst = 0.0f32;
    for size in SIZES.into_iter().chain([3000]) {
        let crowd = crowd(size, 121);
        let Some(tracks) = gpu(&crowd) else { return };
        let expected = cpu(&crowd);
        worst = worst.max(apart(&rotations(&tracks), &rotations(&expected)));
        assert!(worst <= TURNED, "size {size}: {worst}");
        let still = crowd.of(1);
        assert_eq!(tracks[still.clone()], crowd.tracks[still], "an instance that only ends turns nothing");
    }
    println!("track_turn: at most {worst:.1e} apart");
}

#[test]
fn another_edge_is_found() {
    let crowd = crowd(300, 122);
    let Some(tracks) = gpu(&crowd) else { return };
    let mut other = crowd.clone();
    other.edges[crowd.targets[40].edge_begin as usize].weight += 0.1;
    let (found, expected) = (rotations(&tracks), rotations(&cpu(&other)));
    let over = |i: &usize| apart(&found[*i..=*i], &expected[*i..=*i]) > TURNED;
    assert_eq!((0..found.len()).filter(over).collect::<Vec<_>>(), [40, 640, 940]);
}

#[test]
fn nothing_that_is_not_finite_leaves() {
    let mut crowd = degenerate(300, 123);
    crowd.tracks.iter_mut().step_by(9).for_each(|t| t.normal *= 1e30);
    crowd.positions[17].x = f32::NAN;
    let sound = |tracks: &[Track]| tracks.iter().all(|t| t.rotation.is_finite() && t.rotation.length() > 0.99);
    assert!(sound(&cpu(&crowd)));
    let Some(tracks) = gpu(&crowd) else { return };
    assert!(sound(&tracks));
}
