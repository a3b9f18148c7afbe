//! Frames in motion: muscles with dynamics, on the GPU and in the reference, each with a state of its own.

use crate::support::{Gpu, Random, bent, data, gpu, join, limb, limb_muscle, limb_rig};
use glam::{Mat4, Vec4Swizzles};
use sinew::{
    dynamics::Particle,
    gpu::{Batch, Output, RigBuffers},
    parity::{self, CpuResult, GpuResult, PARTICLES, StageReport, TOUCHING_DRIFT},
    reference::{Motion, Reference, Trace},
    rig::{Around, BuildOptions, MuscleSpec, Pose, Rig, Wrap, muscle_file},
    schedule::{Contacts, DynamicsOptions, FrameOptions, Solver},
};
use std::path::Path;
use std::sync::Arc;

fn options() -> FrameOptions {
    FrameOptions { dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() }
}

fn batch(gpu: &Gpu, rig: &Arc<Rig>, count: u32, options: &FrameOptions) -> Batch {
    let buffers = Arc::new(RigBuffers::upload(&gpu.device, Arc::clone(rig)).expect("buffers"));
    let mut batch = Batch::new(&gpu.kernels, &gpu.device, &gpu.queue, &buffers, count, Output::Owned).expect("a batch");
    batch.set_options(&gpu.queue, options);
    batch
}

/// Poses every instance, plays a frame, and brings it back.
fn played(gpu: &Gpu, batch: &mut Batch, poses: &[Pose]) -> Vec<GpuResult> {
    for (instance, pose) in (0..).zip(poses) {
        batch.set_pose(&gpu.queue, instance, pose).expect("a pose");
    }
    gpu.submit(|encoder| batch.encode(encoder));
    (0..poses.len() as u32).map(|i| parity::capture(gpu, batch, i).expect("capture")).collect()
}

/// The limb's elbow swinging fast, from straight to over a right angle.
fn swinging(time: f32) -> Pose {
    Pose { time, ..bent(55.0 - 50.0 * (9.0 * time).cos()) }
}

/// The arm with the fixture's muscles, and its poses.
struct Arm {
    rig: Arc<Rig>,
    scene: sinew::clip::Scene,
}

impl Arm {
    fn new() -> Option<Arm> {
        let scene = sinew::io::gltf::read(&data()?.join("humans/arm_nohand_dense_2172.glb")).expect("the arm");
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("kernels-tests/fixtures/arm_nohand_dense_2172.muscles.toml");
        let file = muscle_file::read(&path).expect("the fixture");
        let rig = Rig::build(scene.character.clone(), &file.muscles, &BuildOptions::default()).expect("a rig");
        Some(Arm { rig: Arc::new(rig), scene })
    }

    fn pose(&self, clip: &str, time: f32) -> Pose {
        self.scene.pose(self.scene.choose_clip(Some(clip)).expect("the clip"), time)
    }
}

fn stages(rig: &Rig, gpu: &GpuResult, trace: &Trace) -> Vec<StageReport> {
    parity::compare(gpu, CpuResult(trace), rig.character.height_rest())
}

#[track_caller]
fn agree(label: &str, stages: &[StageReport]) {
    let failed: Vec<_> = stages.iter().filter(|s| !s.pass).collect();
    assert!(failed.is_empty(), "{label}: {failed:#?}");
    assert!(stages.iter().any(|s| s.stage == "particles" && s.items > 0), "{label}: no particles compared");
}

#[test]
fn a_swinging_limb_agrees_at_every_frame_rate() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(40));
    let jacobi = DynamicsOptions { solver: Solver::Jacobi, ..DynamicsOptions::default() };
    let mut forks = 0;
    for options in [options(), of(jacobi)] {
        let solver = options.dynamics.map(|dynamics| dynamics.solver);
        // 50 and 24.7 frames a second end between two substeps; at 500 most frames have none.
        for fps in [30.0, 50.0, 24.7, 500.0] {
            let mut batch = batch(&gpu, &rig, 1, &options);
            let mut motion = Motion::new(&rig, &options);
            let mut moved = 0.0f32;
            for frame in 0..16 {
                let pose = swinging(frame as f32 / fps);
                let result = played(&gpu, &mut batch, std::slice::from_ref(&pose)).remove(0);
                let before = motion.clone();
                let trace = Reference::new(&rig).next(&mut motion, &pose, &options).expect("a pose");
                let label = format!("{solver:?}, {fps} fps, frame {frame}");
                assert_eq!(batch.steps(), trace.steps, "{label}");
                let found = stages(&rig, &result, &trace);
                if found.iter().all(|stage| stage.pass) || !is_fork(&rig, &before, &pose, &options, &result) {
                    agree(&label, &found);
                } else {
                    forks += 1;
                }
                join(&mut motion, &result);
                let fastest = trace.particles.iter().map(|p| p.velocity.xyz().length()).fold(0.0, f32::max);
                moved = moved.max(fastest);
            }
            assert!(moved > 0.05, "{solver:?}, {fps} fps: the muscle moves at {moved} m/s");
        }
    }
    println!("{forks} of 128 frames went another way of two");
    assert!(forks <= 6, "{forks} of 128 frames");
}

/// Whether the device's frame is one that the reference makes too, from a skin that is off by a micrometre at most. Where two groups'
/// fields tie, or a vertex stands in the valley between the limb and its straight muscle ([`join`]), the last bit of a position chooses
/// one of two ways, on either side.
fn is_fork(rig: &Rig, before: &Motion, pose: &Pose, options: &FrameOptions, result: &GpuResult) -> bool {
    (0..60u64).any(|seed| {
        let (mut nudged, mut random) = (before.clone(), Random(seed + 3));
        let size = [1e-7, 3e-7, 1e-6][seed as usize % 3];
        let skin = nudged.skin.as_mut().expect("a tracked skin");
        skin.positions.iter_mut().for_each(|p| *p += (random.vec3() * size).extend(0.0));
        let trace = Reference::new(rig).next(&mut nudged, pose, options).expect("a pose");
        stages(rig, result, &trace).iter().all(|stage| stage.pass)
    })
}

/// The muscle's own side is in front, and the elbow bends that way: it lies round the joint from behind.
#[test]
fn a_muscle_round_a_swinging_elbow_agrees() {
    let Some(gpu) = gpu() else { return };
    let around = Around::Joint("lowerarm".into());
    let mut muscle = limb_muscle();
    muscle.origin.offset.z = -0.022;
    muscle.insertion.offset.z = -0.022;
    muscle.wrap = Some(Wrap { around, radius: 0.015, side: None });
    let rig = Arc::new(Rig::build(limb(40), std::slice::from_ref(&muscle), &BuildOptions::default()).expect("a limb"));
    let straight =
        Rig::build(limb(40), &[MuscleSpec { wrap: None, ..muscle }], &BuildOptions::default()).expect("a limb");
    for options in [options(), FrameOptions::default()] {
        let mut batch = batch(&gpu, &rig, 1, &options);
        let mut motion = Motion::new(&rig, &options);
        for frame in 0..12 {
            let pose = swinging(frame as f32 / 30.0);
            let result = played(&gpu, &mut batch, std::slice::from_ref(&pose)).remove(0);
            let trace = Reference::new(&rig).next(&mut motion, &pose, &options).expect("a pose");
            let failed: Vec<_> = stages(&rig, &result, &trace).into_iter().filter(|s| !s.pass).collect();
            assert!(failed.is_empty(), "{:?}, frame {frame}: {failed:#?}", options.dynamics.is_some());
        }
        let pose = swinging(11.0 / 30.0);
        let [round, through] =
            [&*rig, &straight].map(|rig| Reference::new(rig).frame(&pose, &options).expect("a pose").muscles[0].length);
        assert!(round > through * 1.01, "it lies round the elbow: {round} m, and {through} m straight");
        assert!((rig.axis_ratios(&pose)[0] * rig.muscles[0].origin_normal.w / round - 1.0).abs() < 0.02);
    }
}

/// Poses that come at once, a second later, later than any motion goes on, and before the last one.
const TIMES: [f32; 8] = [0.0, 0.0, 1.0, 1.0, 1.004, 3.5, 3.5, 2.0];

#[test]
fn frames_at_once_and_a_second_apart_and_substeps_of_a_second_are_finite() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(24));
    for solver in [Solver::RedBlack, Solver::Jacobi] {
        // Substeps a second; none is taken for one.
        for rate in [240, 1, 0, 100_000] {
            let options =
                of(DynamicsOptions { solver, rate, settle: 24.0 / rate.max(1) as f32, ..DynamicsOptions::default() });
            let mut batch = batch(&gpu, &rig, 1, &options);
            let mut motion = Motion::new(&rig, &options);
            // A second of the finest substeps takes minutes.
            let times = TIMES.map(|time| if rate > 240 { time * 240.0 / rate as f32 } else { time });
            for (frame, time) in times.into_iter().enumerate() {
                let pose = Pose { time, ..swinging(0.35 * frame as f32) };
                let result = played(&gpu, &mut batch, std::slice::from_ref(&pose)).remove(0);
                let trace = Reference::new(&rig).next(&mut motion, &pose, &options).expect("a pose");
                let label = format!("{solver:?}, {rate} substeps a second, frame {frame} at {time} s");
                assert_eq!(batch.steps(), trace.steps, "{label}");
                for (side, particles) in [("CPU", &trace.particles), ("GPU", &result.particles)] {
                    let sound = |p: &Particle| p.position.is_finite() && p.velocity.is_finite() && p.spring.is_finite();
                    assert!(!particles.is_empty() && particles.iter().all(sound), "{label}, {side}");
                }
                assert!(result.vertices.iter().flatten().all(|v| v.is_finite()), "{label}");
                assert!(trace.positions().iter().all(|p| p.is_finite()), "{label}");
            }
        }
    }
}

#[test]
fn a_pose_that_is_not_finite_is_refused_and_moves_nothing() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(24));
    let mut batch = batch(&gpu, &rig, 1, &options());
    let mut motion = Motion::new(&rig, &options());
    let reference = Reference::new(&rig);
    let mut bad = swinging(0.05);
    bad.palette[1].w_axis.y = f32::NAN;
    let late = Pose { time: f32::NAN, ..swinging(0.05) };
    let mut last = Vec::new();
    for frame in 0..3 {
        let pose = swinging(frame as f32 / 30.0);
        for refused in [&bad, &late] {
            assert!(batch.set_pose(&gpu.queue, 0, refused).is_err());
            assert!(reference.next(&mut motion, refused, &options()).is_err());
        }
        let result = played(&gpu, &mut batch, std::slice::from_ref(&pose)).remove(0);
        let trace = reference.next(&mut motion, &pose, &options()).expect("a pose");
        agree(&format!("frame {frame}"), &stages(&rig, &result, &trace));
        assert_ne!(std::mem::replace(&mut last, trace.particles.clone()), trace.particles, "frame {frame} moves");
    }
}

#[test]
fn a_limb_shaken_lengthwise_shifts_its_belly_on_either_side() {
    let Some(gpu) = gpu() else { return };
    let swings = |jiggle| {
        let spec = MuscleSpec { jiggle, ..limb_muscle() };
        let rig = Arc::new(Rig::build(limb(24), &[spec], &BuildOptions::default()).expect("a limb"));
        let mut batch = batch(&gpu, &rig, 1, &options());
        let mut motion = Motion::new(&rig, &options());
        let mut most = 0.0_f32;
        for frame in 0..20 {
            let time = frame as f32 / 30.0;
            let lift = Mat4::from_translation(glam::Vec3::Y * 0.03 * (std::f32::consts::TAU * 4.0 * time).sin());
            let palette = bent(20.0).palette.iter().map(|joint| lift * *joint).collect();
            let pose = Pose { time, palette, ..Pose::default() };
            let result = played(&gpu, &mut batch, std::slice::from_ref(&pose)).remove(0);
            let trace = Reference::new(&rig).next(&mut motion, &pose, &options()).expect("a pose");
            agree(&format!("jiggle {jiggle}, frame {frame}"), &stages(&rig, &result, &trace));
            let [ours, theirs] = [&trace.muscles[0], &result.muscles[0]].map(|muscle| muscle.shift);
            assert!((ours - theirs).abs() < 1e-5 && ours.abs() < 0.25, "frame {frame}: {ours} {theirs}");
            most = most.max(ours.abs());
        }
        most
    };
    let most = swings(1.0);
    assert!(most > 0.02, "the belly shifts by {most}");
    assert_eq!(swings(0.0), 0.0, "without jiggle nothing shifts");
}

#[test]
fn another_motion_is_found() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(24));
    let mut batch = batch(&gpu, &rig, 1, &options());
    let mut motion = Motion::new(&rig, &options());
    let mut last = Vec::new();
    for frame in 0..4 {
        // The same pose at the end, after another way to it.
        let time = frame as f32 / 30.0;
        let theirs = swinging(time);
        let ours = if frame == 2 { swinging(time + 0.002) } else { theirs.clone() };
        let ours = Pose { time, ..ours };
        let result = played(&gpu, &mut batch, std::slice::from_ref(&theirs)).remove(0);
        let trace = Reference::new(&rig).next(&mut motion, &ours, &options()).expect("a pose");
        last = stages(&rig, &result, &trace);
        if frame == 1 {
            agree("the same way", &last);
        }
    }
    let failed: Vec<_> = last.iter().filter(|s| !s.pass).map(|s| s.stage).collect();
    assert!(failed.contains(&"particles") && !failed.contains(&"skinned"), "{failed:?}");
}

/// The arm's tests with bones and skin: the default, the other solver, the paper's mode. Contacts between muscles are left
/// out, since they magnify rounding errors; see [`PARTICLES`].
fn solvers() -> [(&'static str, DynamicsOptions); 3] {
    let held = |dynamics| DynamicsOptions { contacts: Contacts { muscles: false, ..Contacts::ALL }, ..dynamics };
    let usual = held(DynamicsOptions::default());
    [
        ("default", usual),
        ("jacobi", DynamicsOptions { solver: Solver::Jacobi, ..usual }),
        ("pbd", held(DynamicsOptions::pbd())),
    ]
}

fn of(dynamics: DynamicsOptions) -> FrameOptions {
    FrameOptions { dynamics: Some(dynamics), ..FrameOptions::default() }
}

/// The worst of every stage over frames of the curl at 50 a second, each side by itself or from the GPU's last state.
fn curled(gpu: &Gpu, arm: &Arm, options: &FrameOptions, frames: usize, resumes: bool) -> Vec<StageReport> {
    let mut batch = batch(gpu, &arm.rig, 1, options);
    let mut motion = Motion::new(&arm.rig, options);
    let mut worst: Vec<StageReport> = Vec::new();
    for frame in 0..frames {
        let pose = arm.pose("biceps_curl", frame as f32 / 50.0);
        let result = played(gpu, &mut batch, std::slice::from_ref(&pose)).remove(0);
        let trace = Reference::new(&arm.rig).next(&mut motion, &pose, options).expect("a pose");
        for (k, stage) in stages(&arm.rig, &result, &trace).into_iter().enumerate() {
            match worst.get_mut(k) {
                Some(all) => all.merge(&stage),
                None => worst.push(stage),
            }
        }
        join(&mut motion, &result);
        if resumes {
            motion.simulation.as_mut().expect("dynamics").resume(&result.particles, &result.axes);
        }
    }
    worst
}

fn figures(stages: &[StageReport]) -> String {
    let each = stages.iter().map(|s| format!("{} {:.1e}", s.stage, s.max_absolute));
    each.collect::<Vec<_>>().join(", ")
}

#[test]
fn the_arm_stays_with_its_reference_for_120_frames() {
    let Some(gpu) = gpu() else { return };
    let Some(arm) = Arm::new() else { return };
    for ((name, dynamics), frames) in solvers().into_iter().zip([120, 120, 30]) {
        let mut worst = curled(&gpu, &arm, &of(dynamics), frames, false);
        println!("arm, {name}, {frames} frames by themselves: {}", figures(&worst));
        // Where a ridge of the field's maximum moves by the drift, the vertices on it go over together: the share that may
        // is meant over all frames here.
        for stage in &mut worst {
            let few = stage.over as f32 <= stage.tolerance.share_over * stage.items as f32;
            stage.pass |= few && stage.stop_agreement.is_none_or(|a| a >= parity::STOP_AGREEMENT);
        }
        agree(name, &worst);
    }
}

#[test]
fn muscles_against_each_other_drift_within_bounds() {
    let Some(gpu) = gpu() else { return };
    let Some(arm) = Arm::new() else { return };
    for solver in [Solver::RedBlack, Solver::Jacobi] {
        let options = of(DynamicsOptions { solver, ..DynamicsOptions::default() });
        let first = curled(&gpu, &arm, &options, 1, false);
        agree(&format!("{solver:?}, the first frame"), &first);
        let worst = curled(&gpu, &arm, &options, 20, true);
        println!("arm with muscle contacts, {solver:?}, 20 frames each from one state: {}", figures(&worst));
        agree(&format!("{solver:?}, frames from one state"), &worst);
        let worst = curled(&gpu, &arm, &options, 120, false);
        println!("arm with muscle contacts, {solver:?}, 120 frames by themselves: {}", figures(&worst));
        let particles = worst.iter().find(|s| s.stage == "particles").expect("particles");
        assert!(particles.max_absolute < TOUCHING_DRIFT.absolute, "{solver:?}: {particles:?}");
    }
}

#[test]
fn a_nudge_of_a_rounding_error_stays_one() {
    let Some(arm) = Arm::new() else { return };
    for ((name, dynamics), frames) in solvers().into_iter().zip([120, 120, 30]) {
        let options = of(dynamics);
        let reference = Reference::new(&arm.rig);
        let mut motion = Motion::new(&arm.rig, &options);
        reference.next(&mut motion, &arm.pose("biceps_curl", 0.0), &options).expect("a pose");
        let nudged = |by: f32| {
            let mut nudged = motion.clone();
            let mut random = Random(91);
            let simulation = nudged.simulation.as_mut().expect("dynamics");
            for p in simulation.particles.iter_mut().filter(|p| p.velocity.w > 0.0) {
                p.position += (random.vec3() * by).extend(0.0);
            }
            nudged
        };
        let (mut slightly, mut far) = (nudged(1e-7), nudged(1e-4));
        let (mut most, mut found) = (0.0f32, 0.0f32);
        for frame in 1..frames {
            let pose = arm.pose("biceps_curl", frame as f32 / 50.0);
            let trace = reference.next(&mut motion, &pose, &options).expect("a pose");
            let apart = |nudged: &mut Motion| {
                let trace_of_it = reference.next(nudged, &pose, &options).expect("a pose");
                let other = GpuResult { particles: trace_of_it.particles, ..GpuResult::default() };
                parity::particles(&other, &trace, PARTICLES).max_absolute
            };
            most = most.max(apart(&mut slightly));
            if frame < 3 {
                found = found.max(apart(&mut far));
            }
        }
        println!("nudged by 1e-7 m, {name}: at most {most:.1e} of a muscle's length; by 1e-4 m: {found:.1e}");
        assert!(most > 0.0 && most < PARTICLES.absolute, "{name}: {most}");
        assert!(found > PARTICLES.absolute, "{name}: a nudge of a tenth of a millimetre must be seen: {found}");
    }
}

#[test]
fn two_instances_have_times_of_their_own_and_a_reset_starts_anew() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(40));
    let mut batch = batch(&gpu, &rig, 2, &options());
    let mut motions = [Motion::new(&rig, &options()), Motion::new(&rig, &options())];
    let reference = Reference::new(&rig);
    for frame in 0..12 {
        // One at 30 frames a second from the beginning, one at 50 from 2 s on.
        let poses = [swinging(frame as f32 / 30.0), swinging(2.0 + frame as f32 / 50.0)];
        if frame == 7 {
            batch.reset(&gpu.queue, 1);
            motions[1].reset(&rig);
        }
        let results = played(&gpu, &mut batch, &poses);
        for (instance, (motion, pose)) in motions.iter_mut().zip(&poses).enumerate() {
            let trace = reference.next(motion, pose, &options()).expect("a pose");
            agree(&format!("frame {frame}, instance {instance}"), &stages(&rig, &results[instance], &trace));
            if frame == 7 && instance == 1 {
                let alone = reference.frame(pose, &options()).expect("a pose");
                assert_eq!(trace.particles, alone.particles, "as if nothing had been before");
            }
            let other = stages(&rig, &results[1 - instance], &trace);
            assert!(other.iter().any(|s| s.stage == "particles" && !s.pass), "the other instance is another one");
        }
    }
}

#[test]
fn an_instance_that_gets_no_pose_stays_as_it_is() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(24));
    let mut batch = batch(&gpu, &rig, 2, &options());
    played(&gpu, &mut batch, &[swinging(0.0), swinging(0.1)]);
    let before = played(&gpu, &mut batch, &[swinging(0.04), swinging(0.14)]);
    batch.set_pose(&gpu.queue, 0, &swinging(0.07)).expect("a pose");
    gpu.submit(|encoder| batch.encode(encoder));
    let after = [0, 1].map(|i| parity::capture(&gpu, &batch, i).expect("capture"));
    assert!(before[1].particles == after[1].particles && before[1].vertices == after[1].vertices);
    assert!(before[0].particles != after[0].particles);
}

#[test]
fn the_same_motion_twice_is_the_same_to_the_bit() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(24));
    let bits = |result: &GpuResult| bytemuck::cast_slice::<_, u32>(&result.particles).to_vec();
    let run = |fps: f32| {
        let mut batch = batch(&gpu, &rig, 1, &options());
        let all = (0..10).map(|k| played(&gpu, &mut batch, &[swinging(k as f32 / fps)]).remove(0));
        let last = all.last().expect("frames");
        (bits(&last), last.vertices)
    };
    let (first, second, other) = (run(50.0), run(50.0), run(51.0));
    assert!(first == second);
    assert!(first.0 != other.0);
    let cpu = || {
        let mut motion = Motion::new(&rig, &options());
        let next = |k| Reference::new(&rig).next(&mut motion, &swinging(k as f32 / 50.0), &options()).expect("a pose");
        (0..10).map(next).last()
    };
    assert_eq!(cpu(), cpu());
}
