//! The embedder's door: a device, an encoder and a buffer that the test made, and nothing read back but its own copy.

use crate::support::{bent, gpu, limb_rig};
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::{
    gpu::{Batch, Instance, Kernels, Output, OutputLayout, RigBuffers, readback},
    parity,
    reference::Reference,
    schedule::FrameOptions,
};
use std::sync::Arc;

/// A device as an engine would make it: WebGPU's default limits, or smaller ones.
fn engine(limits: wgpu::Limits) -> Option<(wgpu::Device, wgpu::Queue)> {
    drop(gpu()?);
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).expect("adapter");
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
    Some(pollster::block_on(adapter.request_device(&descriptor)).expect("device"))
}

const LAYOUT: OutputLayout = OutputLayout { offset: 64, stride: 32, position_at: 4, normal_at: 16 };

#[test]
fn an_engine_gets_vertices_into_its_own_buffer() {
    let Some((device, queue)) = engine(wgpu::Limits::default()) else { return };
    let rig = Arc::new(limb_rig(40));
    let vertices = rig.character.vertex_count() as u64;
    let buffer = |usage| {
        let size = LAYOUT.end(vertices);
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    };
    let mine = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_SRC);
    let copy = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);

    let kernels = Kernels::new(&device).expect("pipelines");
    let buffers = Arc::new(RigBuffers::upload(&device, Arc::clone(&rig)).expect("buffers"));
    let output = Output::Caller { buffer: mine.clone(), layout: LAYOUT };
    let mut instance = Instance::new(&kernels, &device, &queue, &buffers, output).expect("instance");
    instance.set_pose(&queue, &bent(35.0)).expect("pose");
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    instance.encode(&mut encoder);
    encoder.copy_buffer_to_buffer(&mine, 0, &copy, 0, copy.size());
    queue.submit([encoder.finish()]);
    copy.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("done");
    let words: Vec<f32> = bytemuck::pod_collect_to_vec(&copy.get_mapped_range(..).expect("range"));

    let trace = Reference::new(&rig).frame(&bent(35.0), &FrameOptions::default()).expect("pose");
    let at = |v: usize, byte: u32| {
        let word = (LAYOUT.offset + v as u32 * LAYOUT.stride + byte) as usize / 4;
        Vec3::new(words[word], words[word + 1], words[word + 2]).extend(0.0)
    };
    let positions: Vec<Vec4> = (0..trace.normals.len()).map(|v| at(v, LAYOUT.position_at)).collect();
    let normals: Vec<Vec4> = (0..trace.normals.len()).map(|v| at(v, LAYOUT.normal_at)).collect();
    let report = parity::vectors("positions", &positions, trace.positions(), 1.0 / 0.64, parity::TRACKED);
    assert!(report.pass, "{report:?}");
    assert!(parity::vectors("normals", &normals, &trace.normals, 1.0, parity::NORMALS).pass);
    let swapped = parity::vectors("positions", &normals, trace.positions(), 1.0 / 0.64, parity::TRACKED);
    assert!(!swapped.pass, "normals are no positions");
    assert_eq!(words[..16], [0.0; 16], "bytes before the first vertex are the caller's");
}

#[test]
fn many_instances_in_the_same_dispatches_equal_each_alone() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(31));
    let vertices = rig.character.vertex_count();
    let buffers = Arc::new(RigBuffers::upload(&gpu.device, Arc::clone(&rig)).expect("buffers"));
    let mut batch = Batch::new(&gpu.kernels, &gpu.device, &gpu.queue, &buffers, 5, Output::Owned).expect("batch");
    let angles = [0.0, 20.0, 45.0, 45.0, 100.0];
    for (i, angle) in angles.iter().enumerate() {
        batch.set_pose(&gpu.queue, i as u32, &bent(*angle)).expect("pose");
    }
    gpu.submit(|encoder| batch.encode(encoder));
    let together: Vec<[f32; 6]> = readback::read(&gpu, batch.output(), ..5 * vertices).expect("readback");
    let mut alone = Vec::new();
    for angle in angles {
        let mut one = Instance::new(&gpu.kernels, &gpu.device, &gpu.queue, &buffers, Output::Owned).expect("instance");
        one.set_pose(&gpu.queue, &bent(angle)).expect("pose");
        gpu.submit(|encoder| one.encode(encoder));
        alone.extend(readback::read::<[f32; 6]>(&gpu, one.output(), ..vertices).expect("readback"));
    }
    assert_eq!(together, alone);
    let part = |i: usize| &together[i * vertices..(i + 1) * vertices];
    assert_eq!(part(2), part(3), "equal poses");
    assert_ne!(part(1), part(2), "other poses");
}

#[test]
fn an_instance_starts_in_the_rest_pose() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(31));
    let buffers = Arc::new(RigBuffers::upload(&gpu.device, Arc::clone(&rig)).expect("buffers"));
    let one = Instance::new(&gpu.kernels, &gpu.device, &gpu.queue, &buffers, Output::Owned).expect("instance");
    gpu.submit(|encoder| one.encode(encoder));
    let vertices: Vec<[f32; 6]> = readback::read(&gpu, one.output(), ..rig.positions_rest.len()).expect("readback");
    for (vertex, rest) in vertices.iter().zip(&rig.positions_rest) {
        assert!((Vec3::new(vertex[0], vertex[1], vertex[2]) - rest.xyz()).length() < 1e-6);
    }
}

#[test]
fn what_passes_a_limit_is_refused_before_anything_is_made() {
    let small = wgpu::Limits { max_storage_buffer_binding_size: 1 << 18, ..wgpu::Limits::default() };
    let Some((device, queue)) = engine(small) else { return };
    let rig = Arc::new(limb_rig(40));
    let error = RigBuffers::upload(&device, Arc::clone(&rig)).map(drop).expect_err("grids of half a MiB").to_string();
    assert!(
        error.contains("field grids") && error.contains("= 262144") && error.contains("maxStorageBuffer"),
        "{error}"
    );
    assert!(error.contains(&(rig.nodes.len() * 16).to_string()), "{error}");

    let geometric = sinew::rig::BuildOptions { fields: false, ..Default::default() };
    let rig = Arc::new(sinew::rig::Rig::build(rig.character.clone(), &[], &geometric).expect("rig"));
    let kernels = Kernels::new(&device).expect("pipelines");
    let buffers = Arc::new(RigBuffers::upload(&device, rig).expect("no grids, no trouble"));
    assert!(Batch::new(&kernels, &device, &queue, &buffers, 10, Output::Owned).is_ok());
    let error =
        Batch::new(&kernels, &device, &queue, &buffers, 5000, Output::Owned).map(drop).expect_err("5000").to_string();
    assert!(error.contains("5000 instances") && error.contains("262144"), "{error}");
}

#[test]
fn callers_buffers_that_do_not_fit_are_refused() {
    let Some(gpu) = gpu() else { return };
    let rig = Arc::new(limb_rig(31));
    let buffers = Arc::new(RigBuffers::upload(&gpu.device, Arc::clone(&rig)).expect("buffers"));
    let end = LAYOUT.end(rig.positions_rest.len() as u64);
    let attempt = |size, usage, layout| {
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        let buffer = gpu.device.create_buffer(&descriptor);
        let output = Output::Caller { buffer, layout };
        Instance::new(&gpu.kernels, &gpu.device, &gpu.queue, &buffers, output).map(drop).map_err(|e| e.to_string())
    };
    assert!(attempt(end, wgpu::BufferUsages::STORAGE, LAYOUT).is_ok());
    let short = attempt(end - 4, wgpu::BufferUsages::STORAGE, LAYOUT).expect_err("short");
    assert!(short.contains(&end.to_string()) && short.contains(&(end - 4).to_string()), "{short}");
    assert!(attempt(end, wgpu::BufferUsages::VERTEX, LAYOUT).expect_err("usage").contains("STORAGE"));
    for layout in [
        OutputLayout { stride: 30, ..LAYOUT },
        OutputLayout { normal_at: 24, ..LAYOUT },
        OutputLayout { normal_at: 8, ..LAYOUT },
    ] {
        assert!(attempt(end * 2, wgpu::BufferUsages::STORAGE, layout).is_err(), "{layout:?}");
    }
}
