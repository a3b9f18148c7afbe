//! `track_slide` against its twin.

use crate::support::SIZES;
use crate::track_fixtures::{Crowd, WAYS, apart, degenerate};
use glam::Vec4;
use sinew::{schedule::KernelId, tracking};

/// Five edges and a product: a few ulp of coordinates up to 1.
const SLID: f32 = 1e-6;

fn cpu(crowd: &Crowd) -> Vec<Vec4> {
    let mut slid = vec![Vec4::ZERO; crowd.positions.len()];
    for instance in 0..WAYS.len() {
        let own = crowd.of(instance);
        let (tracks, positions) = (&crowd.tracks[own.clone()], &crowd.positions[own.clone()]);
        let spans = &crowd.spans()[own.clone()];
        tracking::slide(&crowd.params(0), &crowd.relax_input(), tracks, spans, positions, &mut slid[own]);
    }
    slid
}

fn gpu(crowd: &Crowd) -> Option<Vec<Vec4>> {
    let out = crowd.gpu(KernelId::TrackSlide, 0, crowd.count * WAYS.len(), &[("slid", 16)])?;
    Some(bytemuck::pod_collect_to_vec(&out[0]))
}

#[test]
fn matches_its_twin_at_every_size() {
    let mut worst = 0.0f32;
    for size in SIZES.into_iter().chain([3000]) {
        let crowd = Crowd::random(size, 131);
        let Some(slid) = gpu(&crowd) else { return };
        worst = worst.max(apart(&slid, &cpu(&crowd)));
        assert!(worst <= SLID, "size {size}: {worst}");
    }
    println!("track_slide: at most {worst:.1e} m apart");
}

#[test]
fn an_instance_that_only_ends_is_not_written() {
    let mut crowd = Crowd::random(65, 132);
    let still = crowd.of(2);
    crowd.tracks[still.clone()].iter_mut().for_each(|t| t.runs = 2);
    let Some(slid) = gpu(&crowd) else { return };
    let expected = cpu(&crowd);
    assert!(apart(&slid[..still.start], &expected[..still.start]) <= SLID);
    assert!(slid[still].iter().all(|p| p.x.to_bits() == crate::support::JUNK));
}

#[test]
fn another_neighbour_is_found() {
    let crowd = Crowd::random(300, 133);
    let Some(slid) = gpu(&crowd) else { return };
    let mut other = crowd.clone();
    // Vertex 41 is a neighbour of 40, 34, 29, 21 and 8; 34 is a copy.
    other.positions[41].y += 1e-3;
    let expected = cpu(&other);
    let over = |i: &usize| apart(&slid[*i..=*i], &expected[*i..=*i]) > SLID;
    let over: Vec<usize> = (0..slid.len()).filter(over).collect();
    assert!(!over.is_empty() && over.iter().all(|i| [8, 21, 29, 34, 40, 41].contains(i)), "{over:?}");
}

#[test]
fn nothing_that_is_not_finite_leaves() {
    let mut crowd = degenerate(300, 134);
    crowd.tracks.iter_mut().step_by(9).for_each(|t| t.normal = Vec4::ZERO);
    assert!(cpu(&crowd).iter().all(|p| p.is_finite()));
    let Some(slid) = gpu(&crowd) else { return };
    assert!(slid.iter().all(|p| p.is_finite()));
}
