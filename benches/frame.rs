//! Skinning, field evaluation and march, on the GPU and on the CPU, at the paper's sizes and above.
//!
//! `cargo bench` prints the adapter first, and the march's mean steps beside each size. A time from a software
//! adapter is a CPU time. Throughput is vertices per second; `one core` runs on a pool of one thread.

mod tube;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sinew::{
    gpu::{Batch, DeviceChoice, Headless, Kernels, Output, RigBuffers},
    reference::{Motion, Reference, Trace},
    rig::{FrameInputs, Pose, Rig},
    schedule::{FrameOptions, KernelId, Step},
    skinning::{self, SkinInput},
    tracking::{self, FieldInput},
};
use std::{sync::Arc, time::Duration};

const SIZES: [usize; 3] = [2_172, 19_296, 200_000];

struct Case {
    rig: Arc<Rig>,
    pose: Pose,
    inputs: FrameInputs,
    trace: Trace,
}

impl Case {
    fn new(vertices: usize) -> Case {
        let rig = Arc::new(tube::rig(vertices));
        let pose = tube::bent(&rig, 70.0);
        let inputs = FrameInputs::new(&rig, &pose).expect("a pose of the rig's own");
        let trace = Reference::new(&rig).frame(&pose, &FrameOptions::default()).expect("a pose of the rig's own");
        Case { rig, pose, inputs, trace }
    }

    fn steps(&self) -> f64 {
        let marched: Vec<u32> = self.trace.reports.iter().filter(|r| r.stop != 0).map(|r| r.steps).collect();
        f64::from(marched.iter().sum::<u32>()) / marched.len().max(1) as f64
    }

    fn field(&self) -> FieldInput<'_> {
        FieldInput {
            groups: &self.inputs.groups,
            nodes: &self.rig.nodes,
            muscles: &self.trace.muscles,
            axes: &self.trace.axes,
        }
    }

    fn step(&self, kernel: KernelId) -> Step {
        *self.trace.steps.iter().find(|s| s.kernel == kernel).expect("a step of an implicit frame")
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
        let (step, options) = (case.step(KernelId::March), FrameOptions::default());
        let (mut motion, mut trace) = (Motion::default(), case.trace.clone());
        let name = format!("march, {:.1} steps", case.steps());
        group.bench_function(BenchmarkId::new(name, vertices), |b| {
            b.iter(|| reference.play(&step, &case.inputs, &options, &mut motion, &mut trace));
        });
        group.bench_function(BenchmarkId::new("whole frame", vertices), |b| {
            b.iter(|| reference.frame(&case.pose, &options));
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
        batch.set_pose(&headless.queue, 0, &case.pose).expect("a pose of the rig's own");
        let mut play = |name: String, chosen: &dyn Fn(&Step) -> bool| {
            group.bench_function(BenchmarkId::new(name, vertices), |b| {
                b.iter(|| {
                    headless.submit(|encoder| batch.encode_where(encoder, None, chosen));
                    headless.wait().expect("the device keeps up");
                });
            });
        };
        play("whole frame".to_owned(), &|_| true);
        play("skin linear".to_owned(), &|s| s.kernel == KernelId::SkinLinear);
        play(format!("march, {:.1} steps", case.steps()), &|s| s.kernel == KernelId::March);
        play("nothing: submit and wait".to_owned(), &|_| false);
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
