//! Skinning, field evaluation and the tracker's stages, on the GPU and on the CPU, at the paper's sizes and above.
//!
//! `cargo bench` prints the adapter first. A time from a software adapter is a CPU time. Throughput is vertices per
//! second; `one core` runs on a pool of one thread. A whole frame goes to and fro between two poses two degrees apart.

mod tube;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sinew::{
    gpu::{Batch, DeviceChoice, Headless, Kernels, Output, RigBuffers},
    reference::{Motion, Reference, Trace},
    rig::{FrameInputs, Pose, Rig},
    schedule::{Counts, FrameOptions, KernelId, Skinning, Step},
    skinning::{self, SkinInput},
    tracking::{self, FieldInput, RelaxInput, TrackParams},
};
use std::{sync::Arc, time::Duration};

const SIZES: [usize; 3] = [2_172, 19_296, 200_000];

struct Case {
    rig: Arc<Rig>,
    poses: [Pose; 2],
    inputs: FrameInputs,
    motion: Motion,
    trace: Trace,
}

impl Case {
    fn new(vertices: usize) -> Case {
        let rig = Arc::new(tube::rig(vertices));
        let poses = [70.0, 72.0].map(|degrees| tube::bent(&rig, degrees));
        let inputs = FrameInputs::new(&rig, &poses[0]).expect("a pose of the rig's own");
        let options = FrameOptions::default();
        let mut motion = Motion::new(&rig, &options);
        let reference = Reference::new(&rig);
        let mut trace = reference.next(&mut motion, &poses[0], &options).expect("a pose of the rig's own");
        let linear = FrameOptions { skinning: Skinning::Linear, ..options };
        trace.skinned = reference.frame(&poses[0], &linear).expect("a pose of the rig's own").skinned;
        Case { rig, poses, inputs, motion, trace }
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
        group.bench_function(BenchmarkId::new("slide, one sweep", vertices), |b| {
            b.iter(|| tracking::slide(&params, &relax, &skin.tracks, &skin.positions, &mut samples));
        });
        let mut motion = case.motion.clone();
        let mut poses = case.poses.iter().rev().cycle();
        group.bench_function(BenchmarkId::new("whole frame", vertices), |b| {
            b.iter(|| poses.next().map(|pose| reference.next(&mut motion, pose, &options)));
        });
    }
    group.finish();
}

fn gpu(criterion: &mut Criterion, cases: &[Case], headless: &Headless) {
    let kernels = Kernels::new(&headless.device).expect("pipelines");
    let mut group = criterion.benchmark_group(format!("{} ({:?})", headless.info.name, headless.info.device_type));
    group.measurement_time(Duration::from_secs(3)).sample_size(20);
    for case in cases {
        let vertices = case.rig.character.vertex_count();
        group.throughput(Throughput::Elements(vertices as u64));
        let buffers = Arc::new(RigBuffers::upload(&headless.device, Arc::clone(&case.rig)).expect("buffers"));
        let mut batch =
            Batch::new(&kernels, &headless.device, &headless.queue, &buffers, 1, Output::Owned).expect("batch");
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
        field_sample(&mut group, case, headless, &kernels);
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

fn benches(criterion: &mut Criterion) {
    let cases = SIZES.map(Case::new);
    match Headless::new(&DeviceChoice::Auto) {
        Ok(headless) => {
            println!(
                "adapter: {} ({:?}), {}",
                headless.info.name, headless.info.device_type, headless.info.driver_info
            );
            gpu(criterion, &cases, &headless);
        }
        Err(error) => println!("GPU not measured: {error}"),
    }
    println!("CPU reference: {} threads unless it says one core", rayon::current_num_threads());
    cpu(criterion, &cases);
}

criterion_group!(frame, benches);
criterion_main!(frame);
