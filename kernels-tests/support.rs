//! What the tests share: one device, kernels run on plain bytes, small characters made by code.

use glam::{Mat4, Quat, Vec2, Vec3, Vec4};
use sinew::{
    field::compose::JointOperator,
    gpu::{DeviceChoice, Headless, Kernels, readback},
    kernel::{dispatch, kernel},
    parity::GpuResult,
    reference::Motion,
    rig::{
        Attachment, BuildOptions, Character, Influence, Joint, Material, MuscleShape, MuscleSize, MuscleSpec, Part,
        Pose, Rig, muscle::JointSpec,
    },
    schedule::KernelId,
};
use std::io::Write;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// The one device of this process, and its pipelines.
pub struct Gpu {
    pub headless: Headless,
    pub kernels: Kernels,
}

impl std::ops::Deref for Gpu {
    type Target = Headless;

    fn deref(&self) -> &Headless {
        &self.headless
    }
}

/// The shared device, for one test at a time; `None` where `SINEW_SKIP_GPU=1` excuses a machine without one.
///
/// Software adapters are preferred, so that a test means the same on every machine; `SINEW_TEST_DEVICE` names another
/// (`auto` takes the best there is).
///
/// # Panics
/// Without an adapter: a test that did not run is not a test that passed.
pub fn gpu() -> Option<MutexGuard<'static, Gpu>> {
    static GPU: OnceLock<Option<Mutex<Gpu>>> = OnceLock::new();
    let gpu = GPU.get_or_init(|| {
        if std::env::var("SINEW_SKIP_GPU").is_ok_and(|v| v == "1") {
            announce("SINEW_SKIP_GPU=1: tests on a device are skipped");
            return None;
        }
        let opened = match std::env::var("SINEW_TEST_DEVICE") {
            Ok(name) if name == "auto" => Headless::new(&DeviceChoice::Auto),
            Ok(name) => Headless::new(&DeviceChoice::Named(name)),
            Err(_) => Headless::new(&DeviceChoice::Software).or_else(|_| Headless::new(&DeviceChoice::Auto)),
        };
        let headless = opened.unwrap_or_else(|e| panic!("{e} (or set SINEW_SKIP_GPU=1)"));
        announce(&format!("tests run on {} ({})", headless.info.name, headless.info.driver_info));
        let kernels = Kernels::new(&headless.device).expect("pipelines");
        Some(Mutex::new(Gpu { headless, kernels }))
    });
    gpu.as_ref().map(|gpu| gpu.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Four bytes that no test expects: a kernel that leaves a place unwritten, or reads one, shows it.
pub const JUNK: u32 = 0xC0DE_FACE;

/// Runs one kernel on plain bytes: inputs as given, outputs of the given size filled with [`JUNK`] before. What stands
/// in both lists starts as given, with [`JUNK`] behind it. Buffers are bound by name; the outputs come back in the order
/// given.
pub fn run(gpu: &Gpu, id: KernelId, items: u64, inputs: &[(&str, &[u8])], outputs: &[(&str, usize)]) -> Vec<Vec<u8>> {
    run_variant(gpu, (id, 0), items, inputs, outputs)
}

/// [`run`] with one of a kernel's pipelines.
pub fn run_variant(
    gpu: &Gpu,
    (id, variant): (KernelId, usize),
    items: u64,
    inputs: &[(&str, &[u8])],
    outputs: &[(&str, usize)],
) -> Vec<Vec<u8>> {
    let Gpu { headless, kernels } = gpu;
    let make = |name: &str, bytes: &[u8]| {
        let out = outputs.iter().find(|(n, _)| *n == name).map_or(0, |(_, bytes)| *bytes);
        let size = (bytes.len().max(out) as u64).max(256).next_multiple_of(4);
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::UNIFORM
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::COPY_SRC;
        let label = Some("test");
        let buffer =
            headless.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false });
        headless.queue.write_buffer(&buffer, 0, &JUNK.to_le_bytes().repeat(size as usize / 4));
        headless.queue.write_buffer(&buffer, 0, bytes);
        buffer
    };
    let mut buffers: Vec<(&str, wgpu::Buffer)> =
        inputs.iter().map(|(name, bytes)| (*name, make(name, bytes))).collect();
    let fresh = outputs.iter().filter(|(name, _)| inputs.iter().all(|(n, _)| n != name));
    buffers.extend(fresh.map(|(name, _)| (*name, make(name, &[]))));
    let named: Vec<_> = buffers.iter().map(|(name, buffer)| (*name, buffer)).collect();
    let bindings = kernels.bind(&headless.device, id, &named).expect("bindings");
    headless.submit(|encoder| {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        if let Some([x, y]) = dispatch::groups(items, kernel(id).items_per_workgroup) {
            pass.set_pipeline(kernels.variant(id, variant));
            pass.set_bind_group(0, &bindings, &[]);
            pass.dispatch_workgroups(x, y, 1);
        }
    });
    assert!(outputs.iter().all(|(name, _)| kernel(id).bindings.iter().any(|b| b.name == *name)));
    outputs
        .iter()
        .map(|(name, bytes)| {
            let buffer = &buffers.iter().find(|(n, _)| n == name).expect("output").1;
            readback::read::<u8>(headless, buffer, ..bytes.next_multiple_of(4)).expect("readback")
        })
        .collect()
}

/// The sizes at which a kernel's bounds go wrong.
pub const SIZES: [usize; 5] = [0, 1, 63, 64, 65];

/// A repeatable stream of numbers in -1..1.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 40) as f32 / (1u64 << 23) as f32) - 1.0
    }

    pub fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    pub fn rotation(&mut self) -> Quat {
        Quat::from_scaled_axis(self.vec3() * 2.0)
    }

    pub fn matrix(&mut self) -> Mat4 {
        let stretch = Vec3::ONE + self.vec3() * 0.4;
        Mat4::from_rotation_translation(self.rotation(), self.vec3())
            * Mat4::from_quat(self.rotation())
            * Mat4::from_scale(stretch)
    }
}

/// A closed limb along Y of `rings` rings of 24 vertices: joints `upper` at y = 0 and `lower` at y = .3, radius 4 cm.
pub fn limb(rings: usize) -> Character {
    const AROUND: usize = 24;
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for ring in 0..rings {
        let t = ring as f32 / (rings - 1) as f32;
        let angle = std::f32::consts::PI * t;
        // A capsule's profile: flat in the middle, round at both ends.
        let y = 0.3 - 0.32 * angle.cos();
        let radius = 0.04 * (1.0 - (y / 0.32 - 0.9375).abs().powi(8)).max(0.0).sqrt().max(0.02);
        for k in 0..AROUND {
            let a = k as f32 / AROUND as f32 * std::f32::consts::TAU;
            positions.push(Vec3::new(radius * a.cos(), y, radius * a.sin()));
            normals.push(Vec3::new(a.cos(), (y - 0.3) * 0.5, a.sin()).normalize());
        }
    }
    for ring in 0..rings - 1 {
        for k in 0..AROUND {
            let at = |r: usize, k: usize| (r * AROUND + k % AROUND) as u32;
            triangles.push([at(ring, k), at(ring + 1, k), at(ring, k + 1)]);
            triangles.push([at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1)]);
        }
    }
    for (end, ring, flip) in [(-0.02, 0, false), (0.62, rings - 1, true)] {
        let tip = positions.len() as u32;
        positions.push(Vec3::new(0.0, end, 0.0));
        normals.push(if flip { Vec3::Y } else { Vec3::NEG_Y });
        for k in 0..AROUND {
            let (a, b) = ((ring * AROUND + k) as u32, (ring * AROUND + (k + 1) % AROUND) as u32);
            triangles.push(if flip { [tip, b, a] } else { [tip, a, b] });
        }
    }
    let mut influences = Vec::new();
    let mut influence_offsets = vec![0];
    for p in &positions {
        let lower = ((p.y - 0.26) / 0.08).clamp(0.0, 1.0);
        for (joint, weight) in if lower > 0.5 { [(1, lower), (0, 1.0 - lower)] } else { [(0, 1.0 - lower), (1, lower)] }
        {
            if weight > 0.0 {
                influences.push(Influence { joint, weight });
            }
        }
        influence_offsets.push(influences.len() as u32);
    }
    let joint = |name: &str, parent, y: f32| Joint {
        name: name.into(),
        parent,
        node: 0,
        inverse_bind: Mat4::from_translation(Vec3::new(0.0, -y, 0.0)),
    };
    let vertices = positions.len() as u32;
    Character {
        name: "limb".into(),
        joints: vec![joint("upperarm", None, 0.0), joint("lowerarm", Some(0), 0.3)],
        uvs: vec![Vec2::ZERO; positions.len()],
        painted: Vec::new(),
        parts: vec![Part {
            name: "limb".into(),
            node: 0,
            vertices: 0..vertices,
            triangles: 0..triangles.len() as u32,
            material: 0,
        }],
        positions_rest: positions,
        normals_rest: normals,
        triangles,
        influence_offsets,
        influences,
        materials: vec![Material::default()],
        images: Vec::new(),
    }
}

/// A muscle in front of the limb's upper bone, crossing the joint.
pub fn limb_muscle() -> MuscleSpec {
    let end = |bone: &str, offset| Attachment { bone: bone.into(), offset, normal: Vec3::X };
    let origin = end("upperarm", Vec3::new(0.0, 0.03, 0.022));
    let insertion = end("lowerarm", Vec3::new(0.0, 0.05, 0.025));
    let shape = MuscleShape { eccentricity: 0.4, ..MuscleShape::REST };
    let spec = MuscleSpec::new("flexor", "upperarm", origin, insertion, MuscleSize::Width(0.017));
    MuscleSpec { rest: shape, active: shape, ..spec }
}

/// The limb with its muscle, ready to deform.
pub fn limb_rig(rings: usize) -> Rig {
    limb_joined(rings, JointOperator::Union)
}

/// The same with an operator at its elbow.
pub fn limb_joined(rings: usize, operator: JointOperator) -> Rig {
    let joints = vec![JointSpec { joint: "lowerarm".into(), operator }];
    Rig::build(limb(rings), &[limb_muscle()], &BuildOptions { joints, ..BuildOptions::default() }).expect("a limb")
}

/// The limb's elbow bent forward by `degrees`.
pub fn bent(degrees: f32) -> Pose {
    let elbow = Mat4::from_translation(Vec3::Y * 0.3);
    let turn = elbow * Mat4::from_rotation_x(degrees.to_radians()) * elbow.inverse();
    Pose { palette: vec![Mat4::IDENTITY, turn], ..Pose::default() }
}

/// The test data's folder, or `None` with a word about it where `SINEW_DATA` is not set.
pub fn data() -> Option<std::path::PathBuf> {
    let folder = std::env::var_os("SINEW_DATA").map(std::path::PathBuf::from);
    if folder.is_none() {
        announce("SINEW_DATA is not set: tests on other people's characters are passed over");
    }
    folder
}

/// Lets the reference's skin go on from the device's. The limb's straight muscle leaves the limb as it bends: vertices between
/// the two stand in a valley of the field, whose bottom has no direction, and rounding decides their side of it; a nudge of
/// 1e-7 m moves them by millimetres on either device. Figures are to be those of one frame.
pub fn join(motion: &mut Motion, result: &GpuResult) {
    if let Some(skin) = &mut motion.skin {
        skin.positions.clone_from(&result.tracked);
        skin.tracks.clone_from(&result.tracks);
    }
}

/// Points with `w = 1`.
pub fn points(vectors: &[Vec3]) -> Vec<Vec4> {
    vectors.iter().map(|v| v.extend(1.0)).collect()
}

/// Writes past the capture of test output: the line matters most when everything passes.
fn announce(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
