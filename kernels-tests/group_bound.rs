//! `group_bound` against its twin.

use crate::support::{Random, bent, gpu, limb_rig, run};
use sinew::{
    field::{bound::bound, evaluate::GroupFrame, muscle::MuscleFrame},
    rig::FrameInputs,
    schedule::KernelId,
    wrap::MuscleParams,
};

const INSTANCES: u32 = 3;
const SUB_POSES: u32 = 2;
/// Squared metres: the inverse of a rotation, and a metre squared: 2^-24 x 16.
const SQUARED: f32 = 1e-6;

/// The limb's groups in several poses, and made muscles of every instance.
struct Bounds {
    groups: Vec<GroupFrame>,
    muscles: Vec<MuscleFrame>,
    params: MuscleParams,
}

impl Bounds {
    fn new() -> Bounds {
        let rig = limb_rig(20);
        let mut random = Random(77);
        let mut groups = Vec::new();
        for k in 0..INSTANCES * SUB_POSES {
            groups.extend(FrameInputs::new(&rig, &bent(17.0 * k as f32)).expect("a pose").groups);
        }
        let count = rig.muscles.len() as u32;
        let muscle = |_| {
            let lowest = random.vec3() * 0.2;
            let highest = lowest + (random.vec3() + 1.0) * 0.2;
            MuscleFrame { lowest: lowest.extend(0.0), highest: highest.extend(0.0), ..MuscleFrame::default() }
        };
        let muscles = (0..INSTANCES * count).map(muscle).collect();
        let group_count = rig.grids.len() as u32;
        let params =
            MuscleParams { muscle_count: count, instance_count: INSTANCES, group_count, ..MuscleParams::default() };
        Bounds { groups, muscles, params }
    }

    fn cpu(&self) -> Vec<GroupFrame> {
        let mut groups = self.groups.clone();
        let MuscleParams { muscle_count, group_count, .. } = self.params;
        for (slot, groups) in (0..).zip(groups.chunks_mut(group_count as usize)) {
            let first = (slot % INSTANCES * muscle_count) as usize;
            bound(groups, &self.muscles[first..first + muscle_count as usize]);
        }
        groups
    }

    fn gpu(&self) -> Option<Vec<GroupFrame>> {
        let gpu = gpu()?;
        let inputs: [(&str, &[u8]); 3] = [
            ("params", bytemuck::bytes_of(&self.params)),
            ("muscles", bytemuck::cast_slice(&self.muscles)),
            ("groups", bytemuck::cast_slice(&self.groups)),
        ];
        let outputs = [("groups", size_of_val(&self.groups[..]))];
        let out = run(&gpu, KernelId::GroupBound, self.groups.len() as u64, &inputs, &outputs);
        Some(bytemuck::pod_collect_to_vec(&out[0]))
    }
}

/// How far apart the spheres are, squared metres; infinite where one of two is missing.
fn apart(a: &[GroupFrame], b: &[GroupFrame]) -> f32 {
    let one = |(a, b): (&GroupFrame, &GroupFrame)| {
        assert_eq!(a.bounds.truncate(), b.bounds.truncate());
        if (a.bounds.w < 0.0) == (b.bounds.w < 0.0) { (a.bounds.w - b.bounds.w).abs() } else { f32::INFINITY }
    };
    a.iter().zip(b).map(one).fold(0.0, f32::max)
}

#[test]
fn matches_its_twin_in_every_instance_and_sub_pose() {
    let mut bounds = Bounds::new();
    let Some(found) = bounds.gpu() else { return };
    let expected = bounds.cpu();
    let grown = expected.iter().zip(&bounds.groups).filter(|(after, before)| after.bounds.w > -before.bounds.w).count();
    assert!(grown > 3, "{grown} spheres grow");
    println!("group_bound: at most {:.1e} m² apart, {grown} of {} grow", apart(&found, &expected), found.len());
    assert!(apart(&found, &expected) <= SQUARED);
    // Another instance's muscles are found.
    bounds.muscles[0].highest.x += 0.3;
    assert!(apart(&found, &bounds.cpu()) > 1e-3);
}

#[test]
fn a_box_that_is_not_finite_bounds_nothing() {
    let mut bounds = Bounds::new();
    bounds.muscles.iter_mut().for_each(|m| m.highest.y = f32::INFINITY);
    let Some(found) = bounds.gpu() else { return };
    let muscled = |g: &GroupFrame| g.grid.muscle_begin < g.grid.muscle_end;
    for groups in [found, bounds.cpu()] {
        assert!(groups.iter().filter(|g| muscled(g)).count() > 0);
        assert!(groups.iter().all(|g| muscled(g) == (g.bounds.w < 0.0)));
    }
}
