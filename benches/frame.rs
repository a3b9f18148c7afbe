//! Skinning, field evaluation and the tracker's stages, on the GPU and on the CPU, at the paper's sizes and above.
//!
//! For every size it prints what a pass looks at, a table of a frame's stages, and the bytes on the device; then criterion's
//! own measurements. Sizes are a tube's, all of it tracked; with SINEW_DATA a whole human runs too, and with SINEW_BENCH_MOST
//! the largest size, which takes minutes. `cargo bench` prints the adapter first. A time from a software adapter is a CPU time. Throughput is vertices per
//! second; `one core` runs on a pool of one thread. A whole frame goes to and fro between two poses two degrees apart.

mod tube;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sinew::{
    field::bound::bound,
    gpu::{Batch, DeviceChoice, Headless, Kernels, Output, RigBuffers},
    reference::{Motion, Reference, Trace},
    rig::{BuildOptions, FrameInputs, Pose, Rig, Role},
    schedule::{Counts, FrameOptions, KernelId, Skinning, Step},
    skinning::{self, SkinInput},
    tracking::{self, FieldInput, RelaxInput, TrackParams},
};
use std::{
    cell::Cell,
    path::Path,
    sync::Arc,
    time::{Duration, Instant},
};

const SIZES: [usize; 3] = [2_172, 19_296, 200_000];
/// A size at which a frame is only timed a few times.
const MOST: usize = 2_000_000;
/// Frames of which a table shows the means.
const FRAMES: u32 = 3;

/// Time spent in every stage.
#[derive(Default)]
struct Stages(Vec<(KernelId, Duration)>);

impl Stages {
    fn add(&mut self, kernel: KernelId, time: Duration) {
        match self.0.iter_mut().find(|(own, _)| *own == kernel) {
            Some((_, sum)) => *sum += time,
            None => self.0.push((kernel, time)),
        }
    }

    fn means(&self) -> Vec<(KernelId, f64)> {
        self.0.iter().map(|(kernel, sum)| (*kernel, 1e3 * sum.as_secs_f64() / f64::from(FRAMES))).collect()
    }
}

fn table(name: &str, stages: &[(KernelId, f64)]) {
    let sum: f64 = stages.iter().map(|(_, ms)| ms).sum();
    println!("{name}: {sum:.2} ms in stages");
    for (kernel, ms) in stages {
        println!("  {:<12} {ms:9.2} ms {:5.1} %", format!("{kernel:?}"), 100.0 * ms / sum);
    }
}

struct Case {
    rig: Arc<Rig>,
    poses: [Pose; 2],
    inputs: FrameInputs,
    motion: Motion,
    trace: Trace,
}

impl Case {
    fn new(vertices: usize) -> Case {
        // So many vertices are not worth the sub-poses of a bend.
        let degrees = if vertices == MOST { 0.0 } else { 70.0 };
        let rig = Arc::new(tube::rig(vertices));
        let poses = [degrees, degrees + 2.0].map(|degrees| tube::bent(&rig, degrees));
        Case::of(rig, poses)
    }

    /// The athletic human of the data folder without muscles, in two frames of its run.
    fn body() -> Option<Case> {
        let folder = std::env::var_os("SINEW_DATA")?;
        let scene = sinew::io::gltf::read(&Path::new(&folder).join("humans/mh_male_athletic.glb")).expect("the human");
        let clip = scene.choose_clip(Some("run_on_spot")).expect("its run");
        let rig = Rig::build(scene.character.clone(), &[], &BuildOptions::default()).expect("its rig");
        let poses = [50.0, 51.0].map(|frame| scene.pose(clip, frame / 30.0));
        Some(Case::of(Arc::new(rig), poses))
    }

    fn of(rig: Arc<Rig>, poses: [Pose; 2]) -> Case {
        let mut inputs = FrameInputs::new(&rig, &poses[0]).expect("a pose of the rig's own");
        let options = FrameOptions::default();
        let mut motion = Motion::new(&rig, &options);
        let reference = Reference::new(&rig);
        let mut trace = reference.next(&mut motion, &poses[0], &options).expect("a pose of the rig's own");
        bound(&mut inputs.groups, &trace.muscles);
        let linear = FrameOptions { skinning: Skinning::Linear, ..options };
        trace.skinned = reference.frame(&poses[0], &linear).expect("a pose of the rig's own").skinned;
        Case { rig, poses, inputs, motion, trace }
    }

    /// What an active vertex looks at in one pass, where the frame has left it: groups that may reach it, and muscles in
    /// whose boxes it lies.
    fn candidates(&self) {
        let skin = self.motion.skin.as_ref().expect("a tracked skin");
        let (mut active, mut groups, mut muscles) = (0u64, 0u64, 0u64);
        for (v, target) in self.rig.targets.vertices.iter().enumerate().filter(|(_, t)| t.role == Role::Active as u32) {
            let p = skin.positions[v].truncate();
            let places = &skin.places[target.reach_begin as usize..target.reach_end as usize];
            active += 1;
            for (g, frame) in (0..).zip(&self.inputs.groups) {
                let place = places.iter().find(|place| place.group == g);
                if frame.present == 0 || (place.is_none() && frame.is_beyond(p)) {
                    continue;
                }
                groups += 1;
                let p_rest = place.map_or(frame.to_rest, |place| place.to_rest).transform_point3(p);
                let own = frame.grid.muscle_begin as usize..frame.grid.muscle_end as usize;
                muscles += self.trace.muscles[own].iter().filter(|m| m.reaches(p_rest)).count() as u64;
            }
        }
        // Vertices that have arrived sit out the last passes.
        let passes = self.trace.tracks.iter().map(|track| u64::from(track.passes)).sum::<u64>() as f64 / active as f64;
        let each = |count: u64| count as f64 / active as f64;
        println!(
            "{} vertices, {active} active, {} reaches: a pass looks at {:.2} groups and {:.2} muscles a vertex, a frame of \
             one sub-pose, {passes:.1} passes, at {:.1} and {:.1}",
            self.rig.character.vertex_count(),
            self.rig.targets.reaches.len(),
            each(groups),
            each(muscles),
            each(groups) * passes,
            each(muscles) * passes
        );
    }

    /// Mean milliseconds of every stage of a frame on the reference, in the frame's order.
    fn stages(&self) -> Vec<(KernelId, f64)> {
        let mut spent = Stages::default();
        let (options, mut motion) = (FrameOptions::default(), self.motion.clone());
        for k in 0..FRAMES {
            let pose = &self.poses[(k as usize + 1) % 2];
            let mut before: Option<(KernelId, Instant)> = None;
            let mut note = |now: Option<KernelId>| {
                if let Some((kernel, start)) = before {
                    spent.add(kernel, start.elapsed());
                }
                before = now.map(|kernel| (kernel, Instant::now()));
            };
            let reference = Reference::new(&self.rig);
            reference.watched(&mut motion, pose, &options, |step| note(Some(step.kernel))).expect("a pose of its own");
            note(None);
        }
        spent.means()
    }

    fn field(&self) -> FieldInput<'_> {
        FieldInput {
            groups: &self.inputs.groups,
            nodes: &self.rig.nodes,
            muscles: &self.trace.muscles,
            axes: &self.trace.axes,
        }
    }
}

fn cpu(criterion: &mut Criterion, cases: &[Case]) {
    let mut group = criterion.benchmark_group("cpu");
    group.measurement_time(Duration::from_secs(3)).sample_size(20);
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    for case in cases {
        let vertices = case.rig.character.vertex_count();
        group.throughput(Throughput::Elements(vertices as u64));
        let mut skinned = case.trace.skinned.clone();
        let input = SkinInput {
            joints: &case.inputs.joints,
            positions_rest: &case.rig.positions_rest,
            offsets: &case.rig.character.influence_offsets,
            influences: &case.rig.character.influences,
        };
        group.bench_function(BenchmarkId::new("skin linear, one core", vertices), |b| {
            one_core.install(|| b.iter(|| skinning::linear(&input, &mut skinned)));
        });
        group.bench_function(BenchmarkId::new("skin linear", vertices), |b| {
            b.iter(|| skinning::linear(&input, &mut skinned));
        });
        let mut samples = skinned.clone();
        group.bench_function(BenchmarkId::new("field", vertices), |b| {
            b.iter(|| tracking::sample(&case.field(), &case.trace.skinned, &mut samples));
        });
        let reference = Reference::new(&case.rig);
        let options = FrameOptions::default();
        let mut skin = case.motion.skin.clone().expect("a tracked skin");
        let params = TrackParams::new(&Counts::default(), 1, &options.track, 0, false);
        let targets = &case.rig.targets.vertices;
        group.bench_function(BenchmarkId::new("march, one pass", vertices), |b| {
            let (positions, tracks) = (&mut skin.positions, &mut skin.tracks);
            b.iter(|| tracking::march(&params, &case.field(), targets, &skin.places, positions, tracks));
        });
        let relax = RelaxInput { targets, edges: &case.rig.graph.edges, positions_rest: &case.rig.positions_rest };
        group.bench_function(BenchmarkId::new("turn, one pass", vertices), |b| {
            b.iter(|| tracking::turn(&params, &relax, &skin.positions, &mut skin.tracks));
        });
        let mut spans = samples.clone();
        group.bench_function(BenchmarkId::new("span, one pass", vertices), |b| {
            b.iter(|| tracking::span(&relax, &skin.tracks, &mut spans));
        });
        group.bench_function(BenchmarkId::new("slide, one sweep", vertices), |b| {
            b.iter(|| tracking::slide(&params, &relax, &skin.tracks, &spans, &skin.positions, &mut samples));
        });
        let mut motion = case.motion.clone();
        let mut poses = case.poses.iter().rev().cycle();
        group.bench_function(BenchmarkId::new("whole frame", vertices), |b| {
            b.iter(|| poses.next().map(|pose| reference.next(&mut motion, pose, &options)));
        });
    }
    group.finish();
}

fn gpu(criterion: &mut Criterion, cases: &[Case], headless: &Headless, kernels: &Kernels) {
    let mut group = criterion.benchmark_group(format!("{} ({:?})", headless.info.name, headless.info.device_type));
    group.measurement_time(Duration::from_secs(3)).sample_size(20);
    for case in cases {
        let vertices = case.rig.character.vertex_count();
        group.throughput(Throughput::Elements(vertices as u64));
        let buffers = Arc::new(RigBuffers::upload(&headless.device, Arc::clone(&case.rig)).expect("buffers"));
        let mut batch =
            Batch::new(kernels, &headless.device, &headless.queue, &buffers, 1, Output::Owned).expect("batch");
        let mut play = |name: &str, moves: bool, chosen: &dyn Fn(&Step) -> bool| {
            let mut poses = case.poses.iter().cycle();
            let mut pose = |batch: &mut Batch| {
                let pose = poses.next().expect("poses without end");
                batch.set_pose(&headless.queue, 0, pose).expect("a pose of the rig's own");
            };
            pose(&mut batch);
            headless.submit(|encoder| batch.encode(encoder));
            pose(&mut batch);
            group.bench_function(BenchmarkId::new(name, vertices), |b| {
                b.iter(|| {
                    headless.submit(|encoder| batch.encode_where(encoder, None, chosen));
                    headless.wait().expect("the device keeps up");
                    if moves {
                        pose(&mut batch);
                    }
                });
            });
        };
        play("whole frame", true, &|_| true);
        play("march, all passes of a sub-pose", false, &|s| s.kernel == KernelId::TrackMarch);
        play("turn, all passes", false, &|s| s.kernel == KernelId::TrackTurn);
        play("slide, all sweeps", false, &|s| s.kernel == KernelId::TrackSlide);
        play("nothing: submit and wait", false, &|_| false);
        field_sample(&mut group, case, headless, kernels);
    }
    group.finish();
}

fn field_sample(
    group: &mut criterion::BenchmarkGroup<'_, criterion::measurement::WallTime>,
    case: &Case,
    headless: &Headless,
    kernels: &Kernels,
) {
    use wgpu::util::DeviceExt;
    let make = |contents: &[u8]| {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::UNIFORM;
        headless.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let params = tracking::SampleParams {
        point_count: case.trace.skinned.len() as u32,
        instance_count: 1,
        group_count: case.inputs.groups.len() as u32,
        muscle_count: case.trace.muscles.len() as u32,
        axis_point_count: case.trace.axes.len() as u32,
        ..Default::default()
    };
    let buffers = [
        ("params", make(bytemuck::bytes_of(&params))),
        ("groups", make(bytemuck::cast_slice(&case.inputs.groups))),
        ("nodes", make(bytemuck::cast_slice(&case.rig.nodes))),
        ("muscles", make(bytemuck::cast_slice(&case.trace.muscles))),
        ("axes", make(bytemuck::cast_slice(&case.trace.axes))),
        ("points", make(bytemuck::cast_slice(&case.trace.skinned))),
        ("samples", make(bytemuck::cast_slice(&case.trace.skinned))),
    ];
    let named = buffers.each_ref().map(|(name, buffer)| (*name, buffer));
    let bindings = kernels.bind(&headless.device, KernelId::FieldSample, &named).expect("bindings");
    let [x, y] =
        sinew::kernel::dispatch::groups(u64::from(params.point_count), sinew::kernel::WORKGROUP).expect("fits");
    group.bench_function(BenchmarkId::new("field", params.point_count), |b| {
        b.iter(|| {
            headless.submit(|encoder| {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(kernels.pipeline(KernelId::FieldSample));
                pass.set_bind_group(0, &bindings, &[]);
                pass.dispatch_workgroups(x, y, 1);
            });
            headless.wait().expect("the device keeps up");
        });
    });
}

/// Mean milliseconds of every stage of a frame on the device, each step submitted by itself, less an empty submit; and the bytes.
fn stages(case: &Case, headless: &Headless, kernels: &Kernels) -> Vec<(KernelId, f64)> {
    let buffers = Arc::new(RigBuffers::upload(&headless.device, Arc::clone(&case.rig)).expect("buffers"));
    let mut batch = Batch::new(kernels, &headless.device, &headless.queue, &buffers, 1, Output::Owned).expect("batch");
    let (all, vertices) = (buffers.bytes() + batch.bytes(), case.rig.character.vertex_count());
    println!(
        "{vertices} vertices: {:.1} MB of the character and {:.1} MB of an instance on the device, {:.2} MB per 1,000 vertices",
        buffers.bytes() as f64 / 1e6,
        batch.bytes() as f64 / 1e6,
        all as f64 / 1e3 / vertices as f64
    );
    let mut spent = Stages::default();
    for k in 0..=FRAMES {
        batch.set_pose(&headless.queue, 0, &case.poses[k as usize % 2]).expect("a pose of the rig's own");
        let time = |chosen: &dyn Fn(&Step) -> bool| {
            let start = Instant::now();
            headless.submit(|encoder| batch.encode_where(encoder, None, chosen));
            headless.wait().expect("the device keeps up");
            start.elapsed()
        };
        let nothing = time(&|_| false);
        for (place, step) in batch.steps().iter().enumerate() {
            // Asked about the step that ends a motion, then about all of them in the frame's order.
            let asked = Cell::new(0);
            let took = time(&|_| asked.replace(asked.get() + 1) == place + 1);
            // The first frame makes pipelines.
            if k > 0 {
                spent.add(step.kernel, took.saturating_sub(nothing));
            }
        }
    }
    spent.means()
}

fn benches(criterion: &mut Criterion) {
    let device = match Headless::new(&DeviceChoice::Auto) {
        Ok(headless) => {
            let info = &headless.info;
            println!("adapter: {} ({:?}), {}", info.name, info.device_type, info.driver_info);
            let kernels = Kernels::new(&headless.device).expect("pipelines");
            Some((headless, kernels))
        }
        Err(error) => {
            println!("GPU not measured: {error}");
            None
        }
    };
    let show = |case: &Case| {
        case.candidates();
        let vertices = case.rig.character.vertex_count();
        table(&format!("reference, {vertices} vertices"), &case.stages());
        if let Some((headless, kernels)) = &device {
            table(&format!("{}, {vertices} vertices", headless.info.name), &stages(case, headless, kernels));
        }
    };
    let body = Case::body();
    if body.is_none() {
        println!("the human is not measured: SINEW_DATA names no folder");
    }
    let cases: Vec<Case> = SIZES.map(Case::new).into_iter().chain(body).collect();
    cases.iter().for_each(show);
    if std::env::var_os("SINEW_BENCH_MOST").is_some() {
        show(&Case::new(MOST));
    }
    if let Some((headless, kernels)) = &device {
        gpu(criterion, &cases, headless, kernels);
    }
    println!("CPU reference: {} threads unless it says one core", rayon::current_num_threads());
    cpu(criterion, &cases);
}

criterion_group!(frame, benches);
criterion_main!(frame);
