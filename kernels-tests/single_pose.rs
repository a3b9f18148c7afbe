//! Frames that depend on no other: the tracker from dual quaternion skinning.

use crate::support::{Gpu, bent, data, gpu, limb_rig};
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::{
    clip::{ClipChoice, Scene},
    gpu::{Batch, Output, RigBuffers},
    parity::{self, CpuResult, GpuResult, StageReport},
    reference::{Motion, Reference, Trace},
    rig::{BuildOptions, Pose, Rig, Role, muscle_file},
    schedule::{FoldVolume, FrameOptions, KernelId, TrackOptions},
};
use std::{path::Path, sync::Arc};

fn options() -> FrameOptions {
    FrameOptions { track: TrackOptions::single_pose(), ..FrameOptions::default() }
}

fn character(name: &str, muscles: bool) -> Option<(Scene, Arc<Rig>)> {
    let scene = sinew::io::gltf::read(&data()?.join(format!("humans/{name}.glb"))).expect("the character");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("kernels-tests/fixtures/{name}.muscles.toml"));
    let specs = if muscles { muscle_file::read(&path).expect("the fixture").muscles } else { Vec::new() };
    let rig = Rig::build(scene.character.clone(), &specs, &BuildOptions::default()).expect("a rig");
    Some((scene, Arc::new(rig)))
}

fn pose(scene: &Scene, clip: &str, time: f32) -> Pose {
    scene.pose(scene.choose_clip(Some(clip)).expect("the clip"), time)
}

fn batch(gpu: &Gpu, rig: &Arc<Rig>, count: u32) -> Batch {
    let buffers = Arc::new(RigBuffers::upload(&gpu.device, Arc::clone(rig)).expect("buffers"));
    let mut batch = Batch::new(&gpu.kernels, &gpu.device, &gpu.queue, &buffers, count, Output::Owned).expect("a batch");
    batch.set_options(&gpu.queue, &options());
    batch
}

fn played(gpu: &Gpu, batch: &mut Batch, pose: &Pose) -> GpuResult {
    batch.set_pose(&gpu.queue, 0, pose).expect("a pose");
    gpu.submit(|encoder| batch.encode(encoder));
    parity::capture(gpu, batch, 0).expect("capture")
}

fn bits(result: &GpuResult) -> Vec<u32> {
    result.vertices.iter().flatten().map(|x| x.to_bits()).collect()
}

fn failed(stages: &[StageReport]) -> Vec<&StageReport> {
    stages.iter().filter(|s| !s.pass).collect()
}

#[test]
fn a_frame_alone_is_the_same_frame_of_any_sequence_to_the_bit() {
    let Some((scene, rig)) = character("arm_nohand_dense_2172", true) else { return };
    let poses: Vec<Pose> = [0.2, 1.1, 8.3, 5.0].map(|time| pose(&scene, "test:elbow", time)).into();
    let reference = Reference::new(&rig);
    let alone: Vec<Trace> = poses.iter().map(|pose| reference.frame(pose, &options()).expect("a frame")).collect();
    assert!(alone.windows(2).all(|pair| pair[0].tracked != pair[1].tracked), "the poses differ");
    let gpu = gpu();
    let orders: [&[usize]; 3] = [&[0, 1, 2, 3], &[2, 0, 3, 3, 1], &[3, 2, 1, 0]];
    for order in orders {
        let mut motion = Motion::new(&rig, &options());
        for &k in order {
            let trace = reference.next(&mut motion, &poses[k], &options()).expect("a frame");
            assert!(trace == alone[k], "frame {k} in {order:?}");
        }
    }
    let with_history = FrameOptions::default();
    let mut motion = Motion::new(&rig, &with_history);
    let mut next = |k: usize| reference.next(&mut motion, &poses[k], &with_history).expect("a frame").tracked;
    next(2);
    let after = next(0);
    assert!(reference.frame(&poses[0], &with_history).expect("a frame").tracked != after, "a history is seen");
    let Some(gpu) = gpu else { return };
    let alone: Vec<_> = poses.iter().map(|pose| bits(&played(&gpu, &mut batch(&gpu, &rig, 1), pose))).collect();
    for order in orders {
        let mut one = batch(&gpu, &rig, 1);
        for &k in order {
            assert!(bits(&played(&gpu, &mut one, &poses[k])) == alone[k], "frame {k} in {order:?} on the device");
        }
    }
}

#[test]
fn who_gets_no_pose_stays_and_frames_played_twice_move_nothing() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(40));
    let mut three = batch(&gpu, &rig, 3);
    let mut play = |poses: [Option<f32>; 3]| {
        for (i, degrees) in (0..).zip(poses) {
            if let Some(degrees) = degrees {
                three.set_pose(&gpu.queue, i, &bent(degrees)).expect("a pose");
            }
        }
        gpu.submit(|encoder| three.encode(encoder));
        [0, 1, 2].map(|i| bits(&parity::capture(&gpu, &three, i).expect("capture")))
    };
    let first = play([Some(30.0), Some(95.0), Some(120.0)]);
    assert!(play([None; 3]) == first, "the same frame again");
    let second = play([Some(80.0), None, Some(0.0)]);
    assert!(second[1] == first[1] && second[0] != first[0] && second[2] != first[2], "one stays");
    let alone = |degrees: f32| bits(&played(&gpu, &mut batch(&gpu, &rig, 1), &bent(degrees)));
    assert!(second == [80.0, 95.0, 0.0].map(alone), "three together are three alone");
}

#[test]
fn every_stage_agrees_on_limb_arm_and_human() {
    let Some(gpu) = gpu() else { return };
    let limb = Arc::new(limb_rig(40));
    let mut cases: Vec<(String, Arc<Rig>, Vec<Pose>)> =
        vec![("limb".into(), limb, [0.0, 18.0, 54.0, 90.0, 120.0].map(bent).into())];
    let clips: [(&str, &str, bool, &[f32]); 3] = [
        ("arm_nohand_dense_2172", "test:elbow", true, &[1.0, 3.0, 6.0, 8.6]),
        ("arm_male_athletic_2172", "test:elbow", false, &[2.0, 6.0, 8.6]),
        ("mh_male_athletic", "run_on_spot", false, &[0.3, 0.7, 1.4]),
    ];
    for (name, clip, muscles, times) in clips {
        let Some((scene, rig)) = character(name, muscles) else { break };
        cases.push((name.into(), rig, times.iter().map(|&time| pose(&scene, clip, time)).collect()));
    }
    for (name, rig, poses) in &cases {
        let mut one = batch(&gpu, rig, 1);
        let mut worst: Option<StageReport> = None;
        for (k, pose) in poses.iter().enumerate() {
            let result = played(&gpu, &mut one, pose);
            let compared = |pose: &Pose| {
                let trace = Reference::new(rig).frame(pose, &options()).expect("a pose");
                assert_eq!(one.steps(), trace.steps);
                parity::compare(&result, CpuResult(&trace), rig.character.height_rest())
            };
            let stages = compared(pose);
            assert!(failed(&stages).is_empty(), "{name}, pose {k}: {:#?}", failed(&stages));
            let tracked = stages.iter().find(|s| s.stage == "tracked").expect("a tracked skin").clone();
            match &mut worst {
                Some(worst) => worst.merge(&tracked),
                None => worst = Some(tracked),
            }
            let other = &poses[(k + 1) % poses.len()];
            let other: Vec<_> =
                compared(other).into_iter().filter(|s| s.stage != "muscles" && s.stage != "muscle axes").collect();
            assert_eq!(failed(&other).len(), other.len(), "{name}: another pose is seen at every stage");
        }
        let worst = worst.expect("a pose");
        println!(
            "{name}: at most {:.1e} of the height apart, {} of {} over, stop reasons agree to {:.3} %",
            worst.max_absolute,
            worst.over,
            worst.items,
            100.0 * worst.stop_agreement.unwrap_or(0.0)
        );
    }
}

#[test]
fn rest_leaves_every_human_where_it_is() {
    let Some(folder) = data() else { return };
    let gpu = gpu();
    let mut seen = 0;
    for file in std::fs::read_dir(folder.join("humans")).expect("the data's humans") {
        let name = file.expect("a file").file_name().to_string_lossy().replace(".glb", "");
        let fixture = format!("{}/kernels-tests/fixtures/{name}.muscles.toml", env!("CARGO_MANIFEST_DIR"));
        for muscles in [false, true].into_iter().filter(|muscles| !muscles || Path::new(&fixture).exists()) {
            let Some((scene, rig)) = character(&name, muscles) else { return };
            let rest = scene.pose(ClipChoice::Rest, 0.0);
            let height = rig.character.height_rest();
            let moved = |positions: &[Vec4]| {
                let off = positions.iter().zip(&rig.positions_rest).map(|(p, r)| (*p - *r).length());
                off.fold(0.0, f32::max) / height
            };
            let trace = Reference::new(&rig).frame(&rest, &options()).expect("a frame");
            let most = moved(trace.positions());
            println!("{name}, muscles {muscles}: {most:.1e} of the height");
            assert!(most < 1e-5, "{name}, muscles {muscles}: {most}");
            let nudged: Vec<Vec4> = trace.positions().iter().map(|p| *p + Vec4::X * 2e-5 * height).collect();
            assert!(moved(&nudged) > 1e-5, "a nudge is seen");
            if let Some(gpu) = gpu.as_ref().filter(|_| !muscles) {
                let most = moved(&played(gpu, &mut batch(gpu, &rig, 1), &rest).tracked);
                assert!(most < 1e-5, "{name} on the device: {most}");
            }
            seen += 1;
        }
    }
    assert!(seen >= 6, "{seen} characters");
}

/// Mean value coordinates give back what is linear along the plane across the field: the vertex itself, as a mean of its
/// neighbours (background 1.13).
#[test]
fn coordinates_of_humans_give_back_their_vertices() {
    for name in ["arm_nohand_dense_2172", "mh_male_athletic", "mh_male_average_default163"] {
        let Some((_, rig)) = character(name, false) else { return };
        let (mut with, mut worst, mut plain) = (0, 0.0f64, 0.0f64);
        for (v, target) in rig.targets.vertices.iter().enumerate() {
            let edges = target.edge_begin as usize..target.edge_end as usize;
            let shares = &rig.mean_values[edges.clone()];
            let sum: f64 = shares.iter().map(|&w| f64::from(w)).sum();
            assert!(shares.iter().all(|w| *w >= 0.0) && (sum.abs() < 1e-12 || (sum - 1.0).abs() < 1e-6), "{name}: {v}");
            if sum == 0.0 {
                continue;
            }
            assert_eq!(target.role, Role::Active as u32, "{name}: {v}");
            let at = |v: usize| rig.character.positions_rest[v].as_dvec3();
            let normal = target.normal_rest.xyz().as_dvec3().normalize();
            let ways: Vec<_> = rig.graph.edges[edges].iter().map(|e| at(e.neighbour as usize) - at(v)).collect();
            let size = ways.iter().map(|e| e.length()).fold(0.0, f64::max);
            let off = |weigh: &dyn Fn(usize) -> f64| {
                let mean: glam::DVec3 = ways.iter().enumerate().map(|(k, e)| *e * weigh(k)).sum();
                (mean - normal * mean.dot(normal)).length() / size
            };
            worst = worst.max(off(&|k| f64::from(shares[k])));
            plain = plain.max(off(&|_| 1.0 / ways.len() as f64));
            with += 1;
        }
        let active = rig.active_count();
        println!("{name}: {with} of {active} active vertices have coordinates; off by at most {worst:.1e} of an edge");
        assert!(worst < 1e-6 && plain > 0.1, "{name}: {worst} {plain}");
        assert!(with * 100 >= active * 95, "{name}: {with} of {active}");
    }
}

/// Share of active vertices within 1e-3 of their target.
fn arrived(rig: &Rig, trace: &Trace) -> f32 {
    let active = rig.targets.vertices.iter().zip(&trace.tracks).filter(|(t, _)| t.role == Role::Active as u32);
    let gaps: Vec<f32> = active.map(|(_, track)| track.residual().abs()).collect();
    gaps.iter().filter(|&&gap| gap < 1e-3).count() as f32 / gaps.len() as f32
}

fn volume(triangles: &[[u32; 3]], positions: &[Vec4]) -> f32 {
    let at = |v: u32| positions[v as usize].xyz();
    triangles.iter().map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2])))).sum::<f32>() / 6.0
}

#[test]
fn bent_arms_arrive_and_keep_their_volume() {
    for name in ["arm_nohand_dense_2172", "arm_male_athletic_2172"] {
        let Some((scene, rig)) = character(name, false) else { return };
        let change = |options: &FrameOptions, degrees: f32| {
            let trace =
                Reference::new(&rig).frame(&pose(&scene, "test:elbow", degrees / 15.0), options).expect("a frame");
            let rest = volume(&rig.character.triangles, &rig.positions_rest);
            (volume(&rig.character.triangles, trace.positions()) / rest - 1.0, arrived(&rig, &trace))
        };
        for degrees in [30.0, 60.0, 90.0, 110.0, 130.0] {
            let (lost, share) = change(&options(), degrees);
            println!("{name} at {degrees} degrees: volume {:+.2} %, arrived {:.2} %", 100.0 * lost, 100.0 * share);
            assert!(lost.abs() < 0.01 && share >= 0.99, "{name} at {degrees}: {lost} {share}");
        }
        let mut bare = options();
        bare.track.fold = FoldVolume::Open;
        bare.track.passes = 0;
        let (lost, share) = change(&bare, 130.0);
        assert!(lost < -0.01 || share < 0.99, "{name}: no passes are seen: {lost} {share}");
    }
}

#[test]
fn a_history_goes_on_from_a_single_pose() {
    let rig = limb_rig(40);
    let reference = Reference::new(&rig);
    let mut motion = Motion::new(&rig, &options());
    reference.next(&mut motion, &bent(60.0), &options()).expect("a frame");
    let trace = reference.next(&mut motion, &bent(62.0), &FrameOptions::default()).expect("a frame");
    let carried = trace.steps.iter().filter(|step| step.kernel == KernelId::TrackCarry).count();
    assert_eq!(carried, 1, "two degrees on are one sub-pose");
    let moved = trace.tracked.iter().zip(&rig.positions_rest).map(|(p, r)| (*p - *r).length()).fold(0.0, f32::max);
    assert!(moved > 0.1 && trace.tracked.iter().all(|p| p.xyz().cmple(Vec3::ONE).all()), "{moved}");
    assert!(arrived(&rig, &trace) > 0.99);
}
