//! `track_span` against its twin.

use crate::support::SIZES;
use crate::track_fixtures::{Crowd, WAYS, apart, degenerate};
use glam::{Quat, Vec4};
use sinew::schedule::KernelId;

/// Two rotations an edge, five edges, one division: a few ulp of spans up to 1 m.
const SPAN: f32 = 1e-6;

/// Spans, and apart from them the shares, which are as large as one over the least weights.
fn parts(spans: &[Vec4]) -> (Vec<Vec4>, Vec<Vec4>) {
    let span = |s: &Vec4| s.truncate().extend(0.0);
    (spans.iter().map(span).collect(), spans.iter().map(|s| Vec4::splat(s.w / (1.0 + s.w))).collect())
}

fn gpu(crowd: &Crowd) -> Option<Vec<Vec4>> {
    let out = crowd.gpu(KernelId::TrackSpan, 0, crowd.count * WAYS.len(), &[("spans", 16)])?;
    Some(bytemuck::pod_collect_to_vec(&out[0]))
}

#[test]
fn matches_its_twin_at_every_size() {
    let mut worst = 0.0f32;
    for size in SIZES.into_iter().chain([3000]) {
        let crowd = Crowd::random(size, 141);
        let Some(found) = gpu(&crowd) else { return };
        let (found, expected) = (parts(&found), parts(&crowd.spans()));
        worst = worst.max(apart(&found.0, &expected.0)).max(apart(&found.1, &expected.1));
        assert!(worst <= SPAN, "size {size}: {worst}");
    }
    println!("track_span: at most {worst:.1e} m apart");
}

#[test]
fn another_turn_is_found() {
    let crowd = Crowd::random(300, 143);
    let Some(found) = gpu(&crowd) else { return };
    let mut other = crowd.clone();
    // Vertex 41 is a neighbour of 40, 34, 29, 21 and 8; 34 is a copy.
    other.tracks[41].rotation = (Quat::from_vec4(other.tracks[41].rotation) * Quat::from_rotation_x(1e-3)).into();
    let (found, expected) = (parts(&found).0, parts(&other.spans()).0);
    let over: Vec<usize> = (0..found.len()).filter(|&i| apart(&found[i..=i], &expected[i..=i]) > SPAN).collect();
    assert!(!over.is_empty() && over.iter().all(|i| [8, 21, 29, 40, 41].contains(i)), "{over:?}");
}

#[test]
fn an_instance_that_only_ends_is_not_written() {
    let mut crowd = Crowd::random(65, 142);
    let still = crowd.of(2);
    crowd.tracks[still.clone()].iter_mut().for_each(|t| t.runs = 2);
    let Some(found) = gpu(&crowd) else { return };
    assert!(found[still].iter().all(|p| p.x.to_bits() == crate::support::JUNK));
}

#[test]
fn odd_edges_harm_their_own_vertex_alone() {
    let crowd = degenerate(300, 144);
    let Some(found) = gpu(&crowd) else { return };
    let harmed = |spans: &[Vec4]| spans.iter().filter(|s| !s.is_finite()).count();
    assert_eq!(harmed(&found), harmed(&crowd.spans()));
    assert!(harmed(&found) * 4 < found.len(), "{} of {}", harmed(&found), found.len());
}
