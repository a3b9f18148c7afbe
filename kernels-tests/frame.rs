//! Whole frames: every stage of the GPU's schedule against the reference's, on people's characters and on ours.

use crate::support::{Gpu, bent, data, gpu, join, limb_rig};
use sinew::{
    clip::{ClipChoice, Scene},
    gpu::{Instance, Output, RigBuffers},
    parity::{self, CpuResult, GpuResult, StageReport},
    reference::{Motion, Reference},
    rig::{BuildOptions, Pose, Rig},
    schedule::{FrameOptions, Skinning},
    tracking::StopReason,
};
use std::sync::Arc;

const MODES: [Skinning; 5] =
    [Skinning::Implicit, Skinning::Linear, Skinning::DualQuaternion, Skinning::Weighted, Skinning::Hybrid];

fn instance(gpu: &Gpu, rig: &Arc<Rig>) -> Instance {
    let buffers = Arc::new(RigBuffers::upload(&gpu.device, Arc::clone(rig)).expect("buffers"));
    Instance::new(&gpu.kernels, &gpu.device, &gpu.queue, &buffers, Output::Owned).expect("instance")
}

fn played(gpu: &Gpu, instance: &mut Instance, pose: &Pose, options: &FrameOptions) -> GpuResult {
    instance.set_options(&gpu.queue, options);
    instance.set_pose(&gpu.queue, pose).expect("pose");
    gpu.submit(|encoder| instance.encode(encoder));
    parity::capture(gpu, instance.batch(), 0).expect("capture")
}

fn human(name: &str) -> Option<(Scene, Arc<Rig>)> {
    let scene = sinew::io::gltf::read(&data()?.join("humans").join(name)).expect("a human");
    let rig = Rig::build(scene.character.clone(), &[], &BuildOptions::default()).expect("a rig");
    Some((scene, Arc::new(rig)))
}

fn failed(stages: &[StageReport]) -> Vec<&StageReport> {
    stages.iter().filter(|s| !s.pass).collect()
}

#[test]
fn every_stage_of_the_limb_agrees_in_every_mode() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(40));
    let mut instance = instance(&gpu, &rig);
    for skinning in MODES {
        let options = FrameOptions { skinning, ..FrameOptions::default() };
        instance.reset(&gpu.queue);
        let mut motion = Motion::new(&rig, &options);
        for degrees in [0.0, 18.0, 36.0, 54.0, 72.0, 90.0, 108.0] {
            let result = played(&gpu, &mut instance, &bent(degrees), &options);
            let trace = Reference::new(&rig).next(&mut motion, &bent(degrees), &options).expect("pose");
            join(&mut motion, &result);
            let stages = parity::compare(&result, CpuResult(&trace), rig.character.height_rest());
            assert!(failed(&stages).is_empty(), "{skinning:?} at {degrees}: {:#?}", failed(&stages));
            let names: Vec<_> = stages.iter().map(|s| s.stage).collect();
            let marches = skinning == Skinning::Implicit;
            assert_eq!(names.contains(&"tracked"), marches, "{names:?}");
            assert_eq!(names.contains(&"muscles"), skinning.follows_muscles(), "{names:?}");
            assert_eq!(names.contains(&"displaced"), skinning == Skinning::Weighted, "{names:?}");
            assert_eq!(stages[0].items == 0, marches, "a tracked skin is not skinned");
        }
    }
}

#[test]
fn leaps_of_many_sub_poses_agree() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(Rig::build(crate::support::limb(40), &[], &BuildOptions::default()).expect("a limb"));
    let options = FrameOptions::default();
    for degrees in [36.0, 60.0, 80.0, 100.0, 120.0] {
        let mut instance = instance(&gpu, &rig);
        let result = played(&gpu, &mut instance, &bent(degrees), &options);
        let stages = |degrees: f32| {
            let trace = Reference::new(&rig).frame(&bent(degrees), &options).expect("pose");
            parity::compare(&result, CpuResult(&trace), rig.character.height_rest())
        };
        assert!(instance.batch().steps().iter().any(|step| step.sub_pose > 2), "{degrees} in many sub-poses");
        assert!(failed(&stages(degrees)).is_empty(), "{degrees}: {:#?}", failed(&stages(degrees)));
        assert!(failed(&stages(degrees + 0.1)).iter().any(|s| s.stage == "tracked"), "another leap from {degrees}");
    }
}

#[test]
fn another_pose_fails_every_stage() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(40));
    let mut instance = instance(&gpu, &rig);
    let options = FrameOptions::default();
    let result = played(&gpu, &mut instance, &bent(50.0), &options);
    let trace = Reference::new(&rig).frame(&bent(51.0), &options).expect("pose");
    let stages = parity::compare(&result, CpuResult(&trace), rig.character.height_rest());
    let skinned = |s: &&StageReport| s.stage == "skinned" && s.items == 0;
    assert!(stages.iter().all(|s| !s.pass || skinned(&s)), "{stages:#?}");
}

#[test]
fn a_human_walks_alike_on_both_sides() {
    let Some(gpu) = gpu() else { return };
    let Some((scene, rig)) = human("mh_male_athletic.glb") else { return };
    let mut instance = instance(&gpu, &rig);
    let clip = scene.choose_clip(Some("walk")).expect("the clip");
    let options = FrameOptions::default();
    let mut motion = Motion::new(&rig, &options);
    for frame in 0..10 {
        let pose = scene.pose(clip, frame as f32 * 0.1);
        let result = played(&gpu, &mut instance, &pose, &options);
        let trace = Reference::new(&rig).next(&mut motion, &pose, &options).expect("pose");
        join(&mut motion, &result);
        let stages = parity::compare(&result, CpuResult(&trace), rig.character.height_rest());
        assert!(failed(&stages).is_empty(), "frame {frame}: {:#?}", failed(&stages));
    }
}

#[test]
fn rest_leaves_every_human_where_it_is() {
    let gpu = gpu();
    let Some(folder) = data() else { return };
    let mut seen = 0;
    for file in std::fs::read_dir(folder.join("humans")).expect("the data's humans") {
        let name = file.expect("a file").file_name().to_string_lossy().into_owned();
        let Some((scene, rig)) = human(&name) else { return };
        let pose = scene.pose(ClipChoice::Rest, 0.0);
        let trace = Reference::new(&rig).frame(&pose, &FrameOptions::default()).expect("pose");
        let bound = 1e-5 * rig.character.height_rest();
        let moved = |positions: &[glam::Vec4]| {
            positions.iter().zip(&rig.positions_rest).map(|(p, r)| (*p - *r).length()).fold(0.0, f32::max)
        };
        assert!(moved(trace.positions()) < bound, "{name}: {} m on the CPU", moved(trace.positions()));
        assert!(
            rig.active_count() > rig.targets.vertices.len() / 5,
            "{name}: only {} follow the field",
            rig.active_count()
        );
        let nudged: Vec<_> = trace.positions().iter().map(|p| *p + glam::Vec4::X * bound).collect();
        assert!(moved(&nudged) >= bound * 0.9, "a nudge must be seen");
        if let Some(gpu) = &gpu {
            let result = played(gpu, &mut instance(gpu, &rig), &pose, &FrameOptions::default());
            assert!(moved(&result.tracked) < bound, "{name}: {} m on the GPU", moved(&result.tracked));
        }
        seen += 1;
    }
    assert!(seen >= 5, "{seen} humans");
}

#[test]
fn the_same_frame_twice_is_the_same_to_the_bit() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(40));
    let options = FrameOptions::default();
    let once = || played(&gpu, &mut instance(&gpu, &rig), &bent(77.0), &options).vertices;
    let (first, second) = (once(), once());
    let bits = |v: &[[f32; 6]]| v.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&first), bits(&second));
    let other = played(&gpu, &mut instance(&gpu, &rig), &bent(77.001), &options).vertices;
    assert_ne!(bits(&first), bits(&other));
    let cpu = || Reference::new(&rig).frame(&bent(77.0), &options).expect("pose");
    assert_eq!(cpu(), cpu());
}

#[test]
fn poses_that_cannot_be_played_are_refused() {
    let rig = limb_rig(12);
    let mut pose = bent(20.0);
    pose.palette[1].w_axis.y = f32::NAN;
    let error = Reference::new(&rig).frame(&pose, &FrameOptions::default()).expect_err("NaN").to_string();
    assert!(error.contains("`lowerarm`") && error.contains("not finite"), "{error}");
    pose.palette.pop();
    let error = Reference::new(&rig).frame(&pose, &FrameOptions::default()).expect_err("one joint").to_string();
    assert!(error.contains("1 joint matrices") && error.contains('2'), "{error}");
}

#[test]
fn a_group_scaled_to_nothing_drops_out_and_nothing_breaks() {
    let rig = limb_rig(40);
    let mut pose = bent(0.0);
    pose.palette[1] = glam::Mat4::from_scale(glam::Vec3::ZERO);
    let trace = Reference::new(&rig).frame(&pose, &FrameOptions::default()).expect("pose");
    assert!(trace.positions().iter().all(|p| p.is_finite()) && trace.normals.iter().all(|n| n.is_finite()));
    assert!(trace.tracks.iter().all(|r| r.stop != StopReason::NonFinite as u32));
}
