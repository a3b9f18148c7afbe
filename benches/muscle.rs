//! Fifty muscles of 29 segments at 20,000 points: the value alone and with its gradient, on the CPU with and without AVX2
//! and on the GPU, every segment of every muscle for every point.
//!
//! The points are those of a skin: on the surfaces of the muscles and up to a centimetre off them. A time from a software
//! adapter is a CPU time.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::{
    field::muscle::{
        self, AxisPoint, Instructions, MuscleFrame, MuscleInput, MuscleRest, Profile, UnionInput, UnionParams,
    },
    gpu::{DeviceChoice, Headless, Kernels},
    kernel::{WORKGROUP, dispatch},
    schedule::KernelId,
};
use std::time::Duration;
use wgpu::util::DeviceExt;

const MUSCLES: usize = 50;
const SEGMENTS: u32 = 29;
const POINTS: usize = 20_000;

struct Scene {
    muscles: Vec<MuscleFrame>,
    axes: Vec<AxisPoint>,
    points: Vec<Vec4>,
}

impl Scene {
    /// Muscles lying side by side round a cylinder, as on a body, in five rings; their axes curve outward.
    fn new() -> Scene {
        let mut scene = Scene { muscles: Vec::new(), axes: Vec::new(), points: Vec::new() };
        for i in 0..MUSCLES {
            let (ring, place) = (i / 10, i % 10);
            let angle = place as f32 / 10.0 * std::f32::consts::TAU;
            let outward = Vec3::new(angle.cos(), 0.0, angle.sin());
            let first = scene.axes.len();
            scene.axes.extend((0..=SEGMENTS).map(|k| {
                let s = k as f32 / SEGMENTS as f32;
                let p = outward * (0.08 + 0.06 * s * (1.0 - s)) + Vec3::Y * (0.3 * (ring as f32 + s));
                AxisPoint { position: p.extend(0.0), ..AxisPoint::default() }
            }));
            let rest = MuscleRest {
                origin: Vec3::ZERO.extend(1.5e-4),
                insertion: Vec3::ZERO.extend(0.015),
                segments: SEGMENTS,
                first_point: first as u32,
                ..MuscleRest::default()
            };
            let profile = Profile::blend(&[((3, 3), 0.5), ((4, 7), 0.5)]);
            let across = outward.cross(Vec3::Y);
            let input = MuscleInput::new(&profile, 0.5);
            scene.muscles.push(muscle::shape(&rest, &input, &mut scene.axes[first..], across, across));
        }
        // As a mesh's vertices: neighbours stand near each other, in rows round the body.
        let rows = 200;
        scene.points.extend((0..POINTS).map(|i| {
            let (row, place) = (i / (POINTS / rows), i % (POINTS / rows));
            let angle = place as f32 / (POINTS / rows) as f32 * std::f32::consts::TAU;
            let away = 0.105 + 0.01 * (5.0 * angle).sin();
            Vec4::new(away * angle.cos(), 1.5 * row as f32 / rows as f32, away * angle.sin(), 1.0)
        }));
        scene
    }

    fn input(&self, gradients: bool) -> UnionInput<'_> {
        UnionInput { muscles: &self.muscles, axes: &self.axes, gradients }
    }

    /// Share of the pairs of point and muscle where the muscle has a field.
    fn in_reach(&self) -> f64 {
        let reached = |p: &Vec4| {
            let field = |m: &&MuscleFrame| muscle::evaluate(m, m.points(&self.axes), p.xyz()).value > 0.0;
            self.muscles.iter().filter(field).count()
        };
        self.points.iter().map(reached).sum::<usize>() as f64 / (POINTS * MUSCLES) as f64
    }
}

fn cpu(criterion: &mut Criterion, scene: &Scene) {
    let mut group = criterion.benchmark_group("cpu");
    group.measurement_time(Duration::from_secs(3)).sample_size(30);
    group.throughput(Throughput::Elements((POINTS * MUSCLES) as u64));
    let mut samples = vec![Vec4::ZERO; POINTS];
    for (name, instructions) in [("as built", Instructions::Portable), ("fastest", Instructions::Fastest)] {
        for (what, gradients) in [("value", false), ("value and gradient", true)] {
            group.bench_function(format!("{what}, {name}"), |b| {
                b.iter(|| muscle::union_with(instructions, &scene.input(gradients), &scene.points, &mut samples));
            });
        }
    }
    group.finish();
}

fn gpu(criterion: &mut Criterion, scene: &Scene, headless: &Headless) {
    let kernels = Kernels::new(&headless.device).expect("pipelines");
    let mut group = criterion.benchmark_group(format!("{} ({:?})", headless.info.name, headless.info.device_type));
    group.measurement_time(Duration::from_secs(3)).sample_size(30);
    group.throughput(Throughput::Elements((POINTS * MUSCLES) as u64));
    let make = |contents: &[u8]| {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::UNIFORM;
        headless.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    for (what, gradients) in [("value", 0), ("value and gradient", 1)] {
        let params =
            UnionParams { point_count: POINTS as u32, muscle_count: MUSCLES as u32, gradients, ..Default::default() };
        let buffers = [
            ("params", make(bytemuck::bytes_of(&params))),
            ("muscles", make(bytemuck::cast_slice(&scene.muscles))),
            ("axes", make(bytemuck::cast_slice(&scene.axes))),
            ("points", make(bytemuck::cast_slice(&scene.points))),
            ("samples", make(bytemuck::cast_slice(&scene.points))),
        ];
        let named = buffers.each_ref().map(|(name, buffer)| (*name, buffer));
        let bindings = kernels.bind(&headless.device, KernelId::MuscleSample, &named).expect("bindings");
        let [x, y] = dispatch::groups(POINTS.div_ceil(muscle::POINTS_PER_THREAD) as u64, WORKGROUP).expect("fits");
        group.bench_function(what, |b| {
            b.iter(|| {
                headless.submit(|encoder| {
                    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                    pass.set_pipeline(kernels.pipeline(KernelId::MuscleSample));
                    pass.set_bind_group(0, &bindings, &[]);
                    pass.dispatch_workgroups(x, y, 1);
                });
                headless.wait().expect("the device keeps up");
            });
        });
    }
    group.finish();
}

fn benches(criterion: &mut Criterion) {
    let scene = Scene::new();
    println!("{:.1} % of the pairs of point and muscle are in reach", 100.0 * scene.in_reach());
    println!("CPU: {} threads", rayon::current_num_threads());
    cpu(criterion, &scene);
    match Headless::new(&DeviceChoice::Auto) {
        Ok(headless) => {
            println!(
                "adapter: {} ({:?}), {}",
                headless.info.name, headless.info.device_type, headless.info.driver_info
            );
            gpu(criterion, &scene, &headless);
        }
        Err(error) => println!("GPU not measured: {error}"),
    }
}

criterion_group!(muscle_benches, benches);
criterion_main!(muscle_benches);
