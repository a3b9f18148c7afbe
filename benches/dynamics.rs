//! Fifty muscles of thirty particles against bones and skin: one frame of eight substeps, two outer iterations and eight
//! inner ones, on the CPU and on the GPU.
//!
//! Paper A's table 3 has 4,250 constraints for them: 29 elastic ones, 28 with bones and 28 with the skin each, so that a
//! frame has 544,000 projections; throughput is projections per second, without the final contact passes. Then the times
//! for 500 muscles and for 5 to 60 particles, with either solver. A time from a software adapter is a CPU time.

mod tube;

use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use glam::Vec3;
use sinew::{
    dynamics::{Bodies, Simulation, Skins},
    gpu::{Batch, DeviceChoice, Headless, Kernels, Output, RigBuffers},
    rig::{Attachment, BuildOptions, FrameInputs, MuscleSize, MuscleSpec, Pose, Rig},
    schedule::{Contacts, DynamicsOptions, FrameOptions, KernelId, Solver, Step},
};
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// Frames a second: eight substeps of 1/240 s each.
const FPS: f64 = 30.0;

struct Case {
    rig: Arc<Rig>,
    poses: [Pose; 2],
    muscles: u32,
    particles: u32,
}

impl Case {
    /// Muscles side by side round the upper bone of a limb, in rings of ten.
    fn new(muscles: u32, particles: u32) -> Case {
        let rings = muscles.div_ceil(10);
        let specs: Vec<MuscleSpec> = (0..muscles)
            .map(|i| {
                let (ring, place) = (i / 10, i % 10);
                let angle = (place as f32 + 0.5 * (ring % 2) as f32) / 10.0 * std::f32::consts::TAU;
                let outward = Vec3::new(angle.cos(), 0.0, angle.sin());
                let low = 0.02 + 0.18 * ring as f32 / rings.max(2) as f32;
                let end = |y: f32| Attachment {
                    bone: "upperarm".into(),
                    offset: outward * 0.02 + Vec3::Y * y,
                    normal: outward,
                };
                let size = MuscleSize::Width(0.012);
                let spec = MuscleSpec::new(&format!("muscle {i}"), "upperarm", end(low), end(low + 0.1), size);
                MuscleSpec { segments: particles - 1, ..spec }
            })
            .collect();
        let base = tube::rig(2_172);
        let rig = Rig::build(base.character.clone(), &specs, &BuildOptions::default()).expect("a limb with muscles");
        let poses = [30.0, 34.0].map(|degrees| {
            let mut pose = tube::bent(&rig, degrees);
            pose.palette[0] = glam::Mat4::from_rotation_z((degrees - 30.0_f32).to_radians());
            pose
        });
        Case { rig: Arc::new(rig), poses, muscles, particles }
    }

    /// Constraints with the given contacts; of the bones and of the skin a particle has one at a time.
    fn constraints(&self, contacts: Contacts) -> u32 {
        let kinds = u32::from(contacts.bones) + u32::from(contacts.skin);
        self.muscles * (self.particles - 1 + kinds * (self.particles - 2))
    }

    fn projections(&self, options: &DynamicsOptions) -> u64 {
        let substeps = (f64::from(options.rate) / FPS) as u64;
        u64::from(self.constraints(options.contacts)) * substeps * u64::from(options.outer * options.inner)
    }
}

fn contacts(on: bool) -> DynamicsOptions {
    let contacts = Contacts { bones: on, muscles: false, skin: on };
    DynamicsOptions { contacts, ..DynamicsOptions::default() }
}

fn jacobi(options: DynamicsOptions) -> DynamicsOptions {
    DynamicsOptions { solver: Solver::Jacobi, ..options }
}

/// What is measured of the fifty muscles, as table 3 has it.
fn columns() -> [(&'static str, DynamicsOptions); 4] {
    [
        ("contacts", contacts(true)),
        ("no contacts", contacts(false)),
        ("contacts, jacobi", jacobi(contacts(true))),
        ("contacts, no final passes", DynamicsOptions { final_passes: 0, ..contacts(true) }),
    ]
}

/// Poses the case at the time of a frame.
fn at(case: &Case, frame: u64) -> Pose {
    Pose { time: (frame as f64 / FPS) as f32, ..case.poses[(frame % 2) as usize].clone() }
}

fn cpu(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, case: &Case, options: &DynamicsOptions) {
    let mut simulation = Simulation::new(Arc::new(Bodies::new(&case.rig)));
    let inputs = case.poses.each_ref().map(|pose| FrameInputs::new(&case.rig, pose).expect("a pose of the rig's own"));
    let skins = Skins::of(&case.rig);
    let mut frame = 0u64;
    let mut next = || {
        simulation.advance(skins, &inputs[(frame % 2) as usize], frame as f64 / FPS, options);
        frame += 1;
    };
    next();
    group.throughput(Throughput::Elements(case.projections(options)));
    group.bench_function(
        BenchmarkId::new(format!("cpu, {name}"), format!("{}x{}", case.muscles, case.particles)),
        |b| {
            b.iter(&mut next);
        },
    );
    let touching = simulation.particles.iter().filter(|p| p.pushes.max_element() > 0.0).count();
    println!("{touching} of {} particles pushed", simulation.particles.len());
}

fn gpu(group: &mut BenchmarkGroup<'_, WallTime>, device: &Device, name: &str, case: &Case, options: &DynamicsOptions) {
    let Device { headless, kernels } = device;
    let buffers = Arc::new(RigBuffers::upload(&headless.device, Arc::clone(&case.rig)).expect("buffers"));
    let mut batch = Batch::new(kernels, &headless.device, &headless.queue, &buffers, 1, Output::Owned).expect("batch");
    let options_of_frame = FrameOptions { dynamics: Some(*options), ..FrameOptions::default() };
    batch.set_options(&headless.queue, &options_of_frame);
    let mut frame = 0u64;
    let mut next = |batch: &mut Batch| {
        batch.set_pose(&headless.queue, 0, &at(case, frame)).expect("a pose of the rig's own");
        frame += 1;
        let start = Instant::now();
        headless.submit(|encoder| {
            batch.encode_where(encoder, None, Step::moves);
        });
        headless.wait().expect("the device keeps up");
        start.elapsed()
    };
    next(&mut batch);
    for kernel in [KernelId::JointStep, KernelId::MusclePredict, KernelId::MuscleProject] {
        let alone = (0..10u32).map(|k| {
            batch.set_pose(&headless.queue, 0, &at(case, 100 + u64::from(k))).expect("a pose of the rig's own");
            let start = Instant::now();
            headless.submit(|encoder| batch.encode_where(encoder, None, |s| s.kernel == kernel));
            headless.wait().expect("the device keeps up");
            start.elapsed()
        });
        println!("gpu, {name}: {kernel:?} alone {:?}", alone.min().unwrap_or_default());
    }
    group.throughput(Throughput::Elements(case.projections(options)));
    group.bench_function(
        BenchmarkId::new(format!("gpu, {name}"), format!("{}x{}", case.muscles, case.particles)),
        |b| {
            b.iter_custom(|count| (0..count).map(|_| next(&mut batch)).sum::<Duration>());
        },
    );
}

struct Device {
    headless: Headless,
    kernels: Kernels,
}

fn benches(criterion: &mut Criterion) {
    let device = match Headless::new(&DeviceChoice::Auto) {
        Ok(headless) => {
            let info = &headless.info;
            println!("adapter: {} ({:?}), {}", info.name, info.device_type, info.driver_info);
            Some(Device { kernels: Kernels::new(&headless.device).expect("pipelines"), headless })
        }
        Err(error) => {
            println!("GPU not measured: {error}");
            None
        }
    };
    println!("CPU: {} threads", rayon::current_num_threads());
    let mut group = criterion.benchmark_group("dynamics");
    group.measurement_time(Duration::from_secs(3)).sample_size(20);
    let mut both = |name: &str, case: &Case, options: &DynamicsOptions| {
        cpu(&mut group, name, case, options);
        if let Some(device) = &device {
            gpu(&mut group, device, name, case, options);
        }
    };
    let table = Case::new(50, 30);
    println!("{} constraints with contacts", table.constraints(contacts(true).contacts));
    for (name, options) in columns() {
        both(name, &table, &options);
    }
    for (muscles, particles) in [(500, 30), (50, 5), (50, 10), (50, 20), (50, 40), (50, 60)] {
        let case = Case::new(muscles, particles);
        both("contacts", &case, &contacts(true));
        both("contacts, jacobi", &case, &jacobi(contacts(true)));
    }
    group.finish();
}

criterion_group!(dynamics, benches);
criterion_main!(dynamics);
