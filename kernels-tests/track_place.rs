//! `track_place` against its twin.

use crate::support::SIZES;
use crate::track_fixtures::{Crowd, SUB_POSES, WAYS, apart, columns};
use sinew::{field::evaluate::Place, schedule::KernelId, tracking};

/// The inverse of a blend of matrices, whose volume is .5 and more here: 2^-24 x 16 x 2.
const PLACED: f32 = 2e-6;

fn cpu(crowd: &Crowd, sub_pose: usize, instance: usize) -> Vec<Place> {
    let mut places = vec![Place::default(); crowd.reaches.len()];
    tracking::place(crowd.joints_of(sub_pose, instance), &crowd.reaches, &crowd.blends, &mut places);
    places
}

fn gpu(crowd: &Crowd, sub_pose: usize) -> Option<Vec<Place>> {
    let items = crowd.reaches.len() * WAYS.len();
    let out = crowd.gpu(KernelId::TrackPlace, sub_pose, items, &[("places", size_of::<Place>())])?;
    Some(bytemuck::pod_collect_to_vec(&out[0]))
}

#[test]
fn matches_its_twin_at_every_size_and_sub_pose() {
    let mut worst = 0.0f32;
    for size in SIZES.into_iter().chain([3000]) {
        let crowd = Crowd::random(size, 111);
        let reaches = crowd.reaches.len();
        for sub_pose in 0..SUB_POSES {
            let Some(places) = gpu(&crowd, sub_pose) else { return };
            for (instance, way) in WAYS.iter().enumerate() {
                let found = &places[instance * reaches..][..reaches];
                if sub_pose >= way.count as usize {
                    assert!(found.iter().all(|p| p.group > 3), "an instance without this sub-pose keeps its places");
                    continue;
                }
                let expected = cpu(&crowd, sub_pose, instance);
                worst = worst.max(apart(&columns(found), &columns(&expected)));
                assert!(worst <= PLACED, "size {size}, sub-pose {sub_pose}, instance {instance}: {worst}");
                let kinds = |places: &[Place]| places.iter().map(|p| (p.group, p.limit)).collect::<Vec<_>>();
                assert_eq!(kinds(found), kinds(&expected));
            }
        }
    }
    println!("track_place: at most {worst:.1e} apart");
}

#[test]
fn another_swing_is_found() {
    let crowd = Crowd::random(300, 112);
    let Some(places) = gpu(&crowd, 0) else { return };
    let reaches = crowd.reaches.len();
    let mut other = crowd.clone();
    other.joints[..4].iter_mut().for_each(|j| j.swing.w = 1.0 - j.swing.w);
    let expected = cpu(&other, 0, 0);
    let over = |i: &usize| apart(&columns(&places[*i..=*i]), &columns(&expected[*i..=*i])) > PLACED;
    let over: Vec<usize> = (0..reaches).filter(over).collect();
    let gated = |i: &usize| crowd.reaches[*i].gate < 4 && crowd.reaches[*i].other < 4;
    assert!(over.len() > 10 && over.iter().all(gated), "{over:?}");
}

#[test]
fn blends_without_volume_give_a_finite_frame() {
    let mut crowd = Crowd::random(300, 113);
    crowd.joints.iter_mut().step_by(3).for_each(|j| j.matrix = glam::Mat4::ZERO);
    crowd.joints.iter_mut().step_by(4).for_each(|j| j.matrix.x_axis *= 1e-30);
    crowd.reaches.iter_mut().step_by(5).for_each(|r| r.blend_end = r.blend_begin);
    let finite = |places: &[Place]| columns(places).iter().all(|c| c.is_finite());
    assert!((0..WAYS.len()).all(|instance| finite(&cpu(&crowd, 0, instance))));
    let Some(places) = gpu(&crowd, 0) else { return };
    assert!(finite(&places[..2 * crowd.reaches.len()]));
}
