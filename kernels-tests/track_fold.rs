//! `track_fold` against its twin, and the twin against a volume that is known.

use crate::support::{Random, SIZES, gpu, run};
use crate::track_fixtures::{Crowd, SUB_POSES, WAYS};
use glam::{Mat4, Vec3, Vec4};
use sinew::{
    field::{Fold, evaluate::GroupFrame},
    kernel::kernel,
    rig::{FoldPatch, FoldTriangle},
    schedule::KernelId,
    tracking::{self, FoldInput, TrackJoint, TrackParams, Way},
};

const GROUPS: usize = 3;
const FOLDS: usize = 2;

/// Offsets, metres: sums of thousands of products whose order is the same; a driver that fuses them moves the last bits.
const OFFSET: f32 = 1e-6;

struct Folding {
    crowd: Crowd,
    groups: Vec<GroupFrame>,
    patches: Vec<FoldPatch>,
    triangles: Vec<FoldTriangle>,
    offsets: Vec<f32>,
}

impl Folding {
    /// Two folds whose patches have `count` triangles each, between random vertices.
    fn random(count: usize, seed: u64) -> Folding {
        let crowd = Crowd::random(200, seed);
        let mut random = Random(seed + 1);
        let end = |random: &mut Random| Fold {
            centre: (random.vec3() * 0.1).extend(0.3),
            axis: random.vec3().normalize().extend(0.2),
            inner: random.vec3().normalize().extend(0.75),
            most: 0.05,
            ..Fold::default()
        };
        let mut frame =
            || GroupFrame { fold_start: end(&mut random), fold_end: end(&mut random), ..GroupFrame::default() };
        let groups = (0..GROUPS * WAYS.len() * SUB_POSES).map(|_| frame()).collect();
        let corner = |k: usize| (k * 37 % crowd.count) as u32;
        let triangle = |k: usize| FoldTriangle {
            a: corner(3 * k),
            b: corner(3 * k + 1),
            c: corner(5 * k + 2),
            of_parent: k as u32 % 2,
        };
        let triangles = (0..FOLDS * count).map(triangle).collect();
        let patch = |f: usize| FoldPatch {
            joint: f as u32 + 1,
            parent: f as u32,
            child: f as u32 + 1,
            begin: (f * count) as u32,
            end: ((f + 1) * count) as u32,
            volume_rest: 1e-3,
            ..FoldPatch::default()
        };
        let offsets = (0..FOLDS * WAYS.len()).map(|k| 0.004 * k as f32).collect();
        Folding { crowd, groups, patches: (0..FOLDS).map(patch).collect(), triangles, offsets }
    }

    fn params(&self, sub_pose: usize, projects: bool) -> TrackParams {
        TrackParams {
            fold_count: FOLDS as u32,
            group_count: GROUPS as u32,
            projects: projects.into(),
            ..self.crowd.params(sub_pose)
        }
    }

    fn cpu(&self, sub_pose: usize, projects: bool) -> (Vec<f32>, Vec<GroupFrame>) {
        let (mut offsets, mut groups) = (self.offsets.clone(), self.groups.clone());
        for (instance, way) in WAYS.iter().enumerate() {
            let input = FoldInput {
                joints: self.crowd.joints_of(sub_pose, instance),
                patches: &self.patches,
                triangles: &self.triangles,
                positions_rest: &self.crowd.rest,
                positions: &self.crowd.positions[self.crowd.of(instance)],
            };
            let own = &mut groups[(sub_pose * WAYS.len() + instance) * GROUPS..][..GROUPS];
            tracking::fold(
                &self.params(sub_pose, projects),
                way,
                &input,
                own,
                &mut offsets[instance * FOLDS..][..FOLDS],
            );
        }
        (offsets, groups)
    }

    fn gpu(&self, sub_pose: usize, projects: bool) -> Option<(Vec<f32>, Vec<GroupFrame>)> {
        let gpu = gpu()?;
        let params = self.params(sub_pose, projects);
        let inputs: [(&str, &[u8]); 9] = [
            ("params", bytemuck::bytes_of(&params)),
            ("ways", bytemuck::cast_slice(&WAYS)),
            ("joints", bytemuck::cast_slice(&self.crowd.joints)),
            ("patches", bytemuck::cast_slice(&self.patches)),
            ("triangles", bytemuck::cast_slice(&self.triangles)),
            ("positions_rest", bytemuck::cast_slice(&self.crowd.rest)),
            ("positions", bytemuck::cast_slice(&self.crowd.positions)),
            ("groups", bytemuck::cast_slice(&self.groups)),
            ("offsets", bytemuck::cast_slice(&self.offsets)),
        ];
        assert!(kernel(KernelId::TrackFold).bindings.len() == inputs.len());
        let outputs = [("offsets", 4 * self.offsets.len()), ("groups", size_of::<GroupFrame>() * self.groups.len())];
        let items = (FOLDS * WAYS.len()) as u64;
        let out = run(&gpu, KernelId::TrackFold, items, &inputs, &outputs);
        Some((bytemuck::pod_collect_to_vec(&out[0]), bytemuck::pod_collect_to_vec(&out[1])))
    }
}

fn apart(a: &(Vec<f32>, Vec<GroupFrame>), b: &(Vec<f32>, Vec<GroupFrame>)) -> f32 {
    let ends = |g: &GroupFrame| [g.fold_start.offset, g.fold_end.offset];
    let all =
        |s: &(Vec<f32>, Vec<GroupFrame>)| s.0.iter().copied().chain(s.1.iter().flat_map(ends)).collect::<Vec<_>>();
    let off = |(a, b): (&f32, &f32)| if (a - b).is_nan() { f32::INFINITY } else { (a - b).abs() };
    all(a).iter().zip(&all(b)).map(off).fold(0.0, f32::max)
}

#[test]
fn matches_its_twin_at_every_size_and_sub_pose() {
    let mut worst = 0.0f32;
    for size in SIZES.into_iter().chain([3000]) {
        let folding = Folding::random(size, 131);
        for (sub_pose, projects) in [(0, false), (1, false), (2, false), (0, true)] {
            let Some(found) = folding.gpu(sub_pose, projects) else { return };
            worst = worst.max(apart(&found, &folding.cpu(sub_pose, projects)));
            assert!(worst <= OFFSET, "{size} triangles, sub-pose {sub_pose}, {projects}: {worst}");
        }
    }
    println!("track_fold: at most {worst:.1e} m apart");
}

#[test]
fn a_volume_that_is_missing_more_is_found() {
    let mut folding = Folding::random(300, 132);
    let Some(found) = folding.gpu(0, false) else { return };
    let with = |folding: &mut Folding, volume_rest: f32| {
        folding.patches[0].volume_rest = volume_rest;
        apart(&found, &folding.cpu(0, false))
    };
    // Random offsets stand at one of their ends: too much volume brings them to one, too little to the other.
    assert!(with(&mut folding, 1.0).max(with(&mut folding, -1.0)) > 0.01);
}

#[test]
fn patches_without_sense_leave_finite_offsets() {
    let mut folding = Folding::random(65, 133);
    folding.crowd.positions.iter_mut().step_by(3).for_each(|p| *p = Vec4::new(1e18, -1e18, 1e18, 1.0));
    folding.crowd.rest.iter_mut().step_by(4).for_each(|p| *p = Vec4::W);
    folding.triangles.iter_mut().step_by(2).for_each(|t| t.b = t.a);
    assert!(folding.cpu(0, false).0.iter().all(|o| (0.0..=0.05).contains(o)));
    let Some((offsets, _)) = folding.gpu(0, false) else { return };
    assert!(offsets.iter().all(|o| (0.0..=0.05).contains(o)), "{offsets:?}");
}

/// A cube of which one side is missing, about its centre: five pyramids of a sixth each.
#[test]
fn volume_is_that_of_the_pyramids_and_comes_back() {
    let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32) - 0.5;
    let rest: Vec<Vec4> = (0..8).map(|k| (corner(k) * 0.1).extend(1.0)).collect();
    let sides = [[0, 2, 3, 1], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    let split =
        |s: &[u32; 4]| [[s[0], s[1], s[2]], [s[0], s[2], s[3]]].map(|[a, b, c]| FoldTriangle { a, b, c, of_parent: 1 });
    let triangles: Vec<FoldTriangle> = sides.iter().flat_map(split).collect();
    let end = Fold {
        centre: Vec4::new(0.0, 0.0, 0.0, 1.0),
        axis: Vec3::Z.extend(1.0),
        inner: Vec3::X.extend(0.75),
        most: 0.02,
        ..Fold::default()
    };
    let frame = GroupFrame { fold_start: end, fold_end: end, ..GroupFrame::default() };
    let offset_of = |volume_rest: f32, scale: f32| {
        let positions: Vec<Vec4> = rest.iter().map(|p| (p.truncate() * scale).extend(1.0)).collect();
        let patch = FoldPatch { child: 1, end: triangles.len() as u32, volume_rest, ..FoldPatch::default() };
        let input = FoldInput {
            joints: &[TrackJoint { matrix: Mat4::IDENTITY, ..TrackJoint::default() }],
            patches: &[patch],
            triangles: &triangles,
            positions_rest: &rest,
            positions: &positions,
        };
        let (mut groups, mut offsets) = ([frame; 2], [0.0]);
        let way = Way { count: 1, turn: 1.0, posed: 1 };
        tracking::fold(&TrackParams::default(), &way, &input, &mut groups, &mut offsets);
        offsets[0]
    };
    let volume = 5.0 / 6.0 * 1e-3;
    assert!(offset_of(volume, 1.0) < 1e-6 && offset_of(volume * 1.001, 1.0) > 1e-6, "a whole cube lacks nothing");
    let (little, more) = (offset_of(volume, 0.99), offset_of(volume, 0.98));
    assert!(little > 1e-5 && more > 1.8 * little && more < 2.2 * little, "{little} {more}");
    assert_eq!(offset_of(volume, 0.5), 0.02, "and no more than the angle allows");
}
