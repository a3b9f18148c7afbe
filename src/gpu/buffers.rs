//! The buffers of a batch, and what each kernel binds of them.

use super::{
    Kernels, RigBuffers,
    kernels::Pipelines,
    output::{Output, OutputLayout},
    rig_buffers::{MIN_BYTES, fits},
};
use crate::{
    dynamics::{DynamicsParams, MovedJoint, Particle, StepClock},
    error::SetupError,
    field::{
        evaluate::GroupFrame,
        muscle::{AxisPoint, MuscleFrame, MuscleInput, axis},
    },
    normals::NormalParams,
    rig::JointFrame,
    schedule::{Counts, DynamicsOptions, KernelId, Positions},
    skinning::VertexParams,
    tracking::{MarchParams, MarchReport},
    wrap::MuscleParams,
};
use std::sync::Arc;

/// A kernel with what it binds for one choice of source positions.
#[derive(Debug)]
pub(super) struct Prepared {
    pub kernel: KernelId,
    pub reads: Option<Positions>,
    pub pipelines: Arc<Pipelines>,
    pub bindings: wgpu::BindGroup,
    /// Outer iteration and whether it carries, where that matters.
    pub part: Option<(u32, bool)>,
}

#[derive(Debug)]
pub(super) struct Buffers {
    pub joints: wgpu::Buffer,
    pub groups: wgpu::Buffer,
    pub muscle_inputs: wgpu::Buffer,
    pub muscles: wgpu::Buffer,
    pub axes: wgpu::Buffer,
    pub skinned: wgpu::Buffer,
    pub tracked: wgpu::Buffer,
    pub reports: wgpu::Buffer,
    pub output: wgpu::Buffer,
    pub vertex_params: wgpu::Buffer,
    pub muscle_params: wgpu::Buffer,
    pub march_params: wgpu::Buffer,
    pub normal_params: wgpu::Buffer,
    pub clocks: wgpu::Buffer,
    pub joints_before: wgpu::Buffer,
    pub moved: wgpu::Buffer,
    pub particles: wgpu::Buffer,
    pub iterates: wgpu::Buffer,
    /// One per outer iteration.
    pub outer_params: Vec<wgpu::Buffer>,
    pub carry_params: wgpu::Buffer,
}

impl Buffers {
    pub fn new(
        device: &wgpu::Device,
        rig: &RigBuffers,
        counts: &Counts,
        count: u32,
        output: Output,
    ) -> Result<(Buffers, OutputLayout), SetupError> {
        let times = |items: u32, size: usize| u64::from(items) * u64::from(count) * size as u64;
        let joint_count = rig.rig.character.joints.len() as u32;
        let layout = output.layout();
        let sizes = [
            ("joints", times(joint_count, size_of::<JointFrame>())),
            ("groups", times(counts.groups, size_of::<GroupFrame>())),
            ("muscle inputs", times(counts.muscles, size_of::<MuscleInput>())),
            ("shaped muscles", times(counts.muscles, size_of::<MuscleFrame>())),
            ("muscle axes", times(counts.points, size_of::<AxisPoint>())),
            ("skinned positions", times(counts.vertices, 16)),
            ("tracked positions", times(counts.vertices, 16)),
            ("march reports", times(counts.vertices, size_of::<MarchReport>())),
            ("muscle clocks", times(1, size_of::<StepClock>())),
            ("joints before", times(joint_count, size_of::<JointFrame>())),
            ("moved joints", times(joint_count, size_of::<MovedJoint>())),
            ("muscle particles", times(counts.points, size_of::<Particle>())),
            ("muscle iterates", times(2, 16 * axis::half(counts.muscles, counts.points))),
            ("output vertices", layout.end(u64::from(counts.vertices) * u64::from(count))),
        ];
        let limits = device.limits();
        for (name, bytes) in &sizes {
            fits(&limits, &format!("`{}`, {count} instances: {name}", rig.rig.character.name), *bytes)?;
        }
        output.check(sizes[13].1, &limits)?;
        let storage = |(name, bytes): (&str, u64)| buffer(device, name, bytes, wgpu::BufferUsages::STORAGE);
        let uniform = |name, bytes: usize| buffer(device, name, bytes as u64, wgpu::BufferUsages::UNIFORM);
        let buffers = Buffers {
            joints: storage(sizes[0]),
            groups: storage(sizes[1]),
            muscle_inputs: storage(sizes[2]),
            muscles: storage(sizes[3]),
            axes: storage(sizes[4]),
            skinned: storage(sizes[5]),
            tracked: storage(sizes[6]),
            reports: storage(sizes[7]),
            output: match output {
                Output::Caller { buffer, .. } => buffer,
                Output::Owned => {
                    buffer(device, sizes[13].0, sizes[13].1, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX)
                }
            },
            vertex_params: uniform("vertex params", size_of::<VertexParams>()),
            muscle_params: uniform("muscle params", size_of::<MuscleParams>()),
            march_params: uniform("march params", size_of::<MarchParams>()),
            normal_params: uniform("normal params", size_of::<NormalParams>()),
            clocks: storage(sizes[8]),
            joints_before: storage(sizes[9]),
            moved: storage(sizes[10]),
            particles: storage(sizes[11]),
            iterates: storage(sizes[12]),
            outer_params: (0..DynamicsOptions::MOST_OUTER)
                .map(|_| uniform("dynamics params", size_of::<DynamicsParams>()))
                .collect(),
            carry_params: uniform("carry params", size_of::<DynamicsParams>()),
        };
        Ok((buffers, layout))
    }
}

fn buffer(device: &wgpu::Device, name: &str, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&format!("sinew.{name}")),
        size: bytes.max(MIN_BYTES).next_multiple_of(4),
        usage: usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

pub(super) fn prepare(
    kernels: &Kernels,
    device: &wgpu::Device,
    rig: &RigBuffers,
    b: &Buffers,
) -> Result<Vec<Prepared>, SetupError> {
    let make = |kernel, reads, buffers: &[(&str, &wgpu::Buffer)]| {
        let bindings = kernels.bind(device, kernel, buffers)?;
        Ok(Prepared { kernel, reads, pipelines: kernels.pipelines(kernel), bindings, part: None })
    };
    let step = |params| {
        [
            ("params", params),
            ("clocks", &b.clocks),
            ("joints_before", &b.joints_before),
            ("joints", &b.joints),
            ("moved", &b.moved),
        ]
    };
    let predict = |params| {
        [
            ("params", params),
            ("bodies", &rig.bodies),
            ("inputs", &b.muscle_inputs),
            ("moved", &b.moved),
            ("axes", &b.axes),
            ("particles", &b.particles),
            ("iterates", &b.iterates),
            ("clocks", &b.clocks),
        ]
    };
    let project = |params| {
        [
            ("params", params),
            ("bodies", &rig.bodies),
            ("bones", &rig.bones),
            ("links", &rig.links),
            ("moved", &b.moved),
            ("groups", &b.groups),
            ("nodes", &rig.nodes),
            ("particles", &b.particles),
            ("iterates", &b.iterates),
        ]
    };
    let skin = [
        ("params", &b.vertex_params),
        ("joints", &b.joints),
        ("positions_rest", &rig.positions_rest),
        ("offsets", &rig.influence_offsets),
        ("influences", &rig.influences),
        ("skinned", &b.skinned),
    ];
    let shape = [
        ("params", &b.muscle_params),
        ("muscles_rest", &rig.muscles),
        ("inputs", &b.muscle_inputs),
        ("joints", &b.joints),
        ("groups", &b.groups),
        ("shaped", &b.muscles),
        ("axes", &b.axes),
        ("iterates", &b.iterates),
    ];
    let march = [
        ("params", &b.march_params),
        ("groups", &b.groups),
        ("nodes", &rig.nodes),
        ("muscles", &b.muscles),
        ("axes", &b.axes),
        ("targets", &rig.targets),
        ("skinned", &b.skinned),
        ("tracked", &b.tracked),
        ("reports", &b.reports),
    ];
    let normals = |positions| {
        [
            ("params", &b.normal_params),
            ("triangles", &rig.corners),
            ("fans", &rig.fans),
            ("members", &rig.fan_members),
            ("positions", positions),
            ("vertices", &b.output),
        ]
    };
    let mut prepared = vec![
        make(KernelId::SkinLinear, None, &skin)?,
        make(KernelId::SkinDualQuaternion, None, &skin)?,
        make(KernelId::MuscleShape, None, &shape)?,
        make(KernelId::March, None, &march)?,
        make(KernelId::Normals, Some(Positions::Skinned), &normals(&b.skinned))?,
        make(KernelId::Normals, Some(Positions::Tracked), &normals(&b.tracked))?,
    ];
    let in_part = |prepared: Prepared, part| Prepared { part: Some(part), ..prepared };
    for (params, carries) in [(&b.outer_params[0], false), (&b.carry_params, true)] {
        prepared.push(in_part(make(KernelId::JointStep, None, &step(params))?, (0, carries)));
        prepared.push(in_part(make(KernelId::MusclePredict, None, &predict(params))?, (0, carries)));
    }
    for (outer, params) in (0..).zip(&b.outer_params) {
        prepared.push(in_part(make(KernelId::MuscleProject, None, &project(params))?, (outer, false)));
    }
    Ok(prepared)
}
