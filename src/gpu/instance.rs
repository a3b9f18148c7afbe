//! Characters in motion: the state and per-frame buffers of one or many instances of a rig.

use super::{
    Kernels, RigBuffers,
    output::{Output, OutputLayout},
    rig_buffers::{MIN_BYTES, fits},
};
use crate::{
    error::{PoseError, SetupError},
    field::{
        evaluate::GroupFrame,
        muscle::{AxisPoint, MuscleFrame, MuscleInput},
    },
    kernel::{WORKGROUP, dispatch},
    normals::NormalParams,
    rig::{FrameInputs, JointFrame, Pose},
    schedule::{self, Counts, FrameOptions, KernelId, Positions, Step},
    skinning::VertexParams,
    tracking::{MarchParams, MarchReport},
    wrap::MuscleParams,
};
use std::sync::Arc;

/// Several instances of one character, deformed in the same dispatches.
///
/// Poses and options go through the queue; [`Batch::encode`] only records. A `write_buffer` lands before the next
/// submit, so a batch takes one pose per instance and submit.
#[derive(Debug)]
pub struct Batch {
    rig: Arc<RigBuffers>,
    count: u32,
    steps: Vec<Step>,
    buffers: Buffers,
    layout: OutputLayout,
    pipelines: Vec<Prepared>,
}

/// A kernel with what it binds for one choice of source positions.
#[derive(Debug)]
struct Prepared {
    kernel: KernelId,
    reads: Option<Positions>,
    pipeline: wgpu::ComputePipeline,
    bindings: wgpu::BindGroup,
}

#[derive(Debug)]
struct Buffers {
    joints: wgpu::Buffer,
    groups: wgpu::Buffer,
    muscle_inputs: wgpu::Buffer,
    muscles: wgpu::Buffer,
    axes: wgpu::Buffer,
    skinned: wgpu::Buffer,
    tracked: wgpu::Buffer,
    reports: wgpu::Buffer,
    output: wgpu::Buffer,
    vertex_params: wgpu::Buffer,
    muscle_params: wgpu::Buffer,
    march_params: wgpu::Buffer,
    normal_params: wgpu::Buffer,
}

impl Batch {
    /// Makes `count` instances of a rig, in the rest pose.
    ///
    /// # Errors
    /// A buffer would pass the device's limits, or the caller's output cannot take the vertices; nothing has been
    /// allocated then.
    pub fn new(
        kernels: &Kernels,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        rig: &Arc<RigBuffers>,
        count: u32,
        output: Output,
    ) -> Result<Batch, SetupError> {
        let counts = counts(rig);
        let (buffers, layout) = Buffers::new(device, rig, &counts, count, output)?;
        let pipelines = prepare(kernels, device, rig, &buffers)?;
        let mut batch = Batch { rig: Arc::clone(rig), count, steps: Vec::new(), buffers, layout, pipelines };
        let joint_count = rig.rig.character.joints.len() as u32;
        let vertex = VertexParams { vertex_count: counts.vertices, instance_count: count, joint_count, pad_0: 0 };
        let muscle = MuscleParams {
            muscle_count: counts.muscles,
            instance_count: count,
            joint_count,
            group_count: counts.groups,
            point_count: counts.points,
            ..MuscleParams::default()
        };
        queue.write_buffer(&batch.buffers.vertex_params, 0, bytemuck::bytes_of(&vertex));
        queue.write_buffer(&batch.buffers.muscle_params, 0, bytemuck::bytes_of(&muscle));
        batch.set_options(queue, &FrameOptions::default());
        let rest = FrameInputs::new(&rig.rig, &Pose::rest(&rig.rig.character)).unwrap_or_default();
        for instance in 0..count {
            batch.write(queue, instance, &rest);
        }
        Ok(batch)
    }

    /// Chooses what the following frames compute.
    pub fn set_options(&mut self, queue: &wgpu::Queue, options: &FrameOptions) {
        let counts = counts(&self.rig);
        self.steps = schedule::frame(&counts, options);
        let march = MarchParams::new(&counts, self.count, &options.march);
        let normal = NormalParams {
            vertex_count: counts.vertices,
            instance_count: self.count,
            offset: self.layout.offset / 4,
            stride: self.layout.stride / 4,
            position_at: self.layout.position_at / 4,
            normal_at: self.layout.normal_at / 4,
            pad_0: 0,
            pad_1: 0,
        };
        queue.write_buffer(&self.buffers.march_params, 0, bytemuck::bytes_of(&march));
        queue.write_buffer(&self.buffers.normal_params, 0, bytemuck::bytes_of(&normal));
    }

    /// Poses one instance.
    ///
    /// # Errors
    /// The pose is another character's or not finite; nothing has been written then.
    ///
    /// # Panics
    /// `instance` is not below the batch's count.
    pub fn set_pose(&mut self, queue: &wgpu::Queue, instance: u32, pose: &Pose) -> Result<(), PoseError> {
        assert!(instance < self.count, "instance {instance} of a batch of {}", self.count);
        let inputs = FrameInputs::new(&self.rig.rig, pose)?;
        self.write(queue, instance, &inputs);
        Ok(())
    }

    fn write(&self, queue: &wgpu::Queue, instance: u32, inputs: &FrameInputs) {
        let place = |bytes: &[u8]| u64::from(instance) * bytes.len() as u64;
        let joints: &[u8] = bytemuck::cast_slice(&inputs.joints);
        let groups: &[u8] = bytemuck::cast_slice(&inputs.groups);
        queue.write_buffer(&self.buffers.joints, place(joints), joints);
        let muscles: &[u8] = bytemuck::cast_slice(&inputs.muscles);
        queue.write_buffer(&self.buffers.groups, place(groups), groups);
        queue.write_buffer(&self.buffers.muscle_inputs, place(muscles), muscles);
    }

    /// Records one frame of every instance. Neither submits, polls nor maps.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        self.encode_where(encoder, None, |_| true);
    }

    /// Records the chosen steps of a frame alone, with timestamps where the caller wants them: for measuring, and for
    /// finding the first step that differs. What a step reads is what an earlier encoding left.
    pub fn encode_where(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
        chosen: impl Fn(&Step) -> bool,
    ) {
        let descriptor = wgpu::ComputePassDescriptor { label: Some("sinew.frame"), timestamp_writes };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        for step in self.steps.iter().filter(|step| chosen(step)) {
            let matches = |p: &&Prepared| p.kernel == step.kernel && (p.reads.is_none() || p.reads == step.reads);
            let Some(prepared) = self.pipelines.iter().find(matches) else { continue };
            let threads = u64::from(step.items) * u64::from(self.count);
            if let Some([x, y]) = dispatch::groups(threads, WORKGROUP) {
                pass.set_pipeline(&prepared.pipeline);
                pass.set_bind_group(0, &prepared.bindings, &[]);
                pass.dispatch_workgroups(x, y, 1);
            }
        }
    }

    /// The steps that [`Batch::encode`] records.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The rig that it plays.
    pub fn rig(&self) -> &crate::rig::Rig {
        &self.rig.rig
    }

    /// Number of instances.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The output vertices, instance after instance, as [`Batch::layout`] says.
    pub fn output(&self) -> &wgpu::Buffer {
        &self.buffers.output
    }

    /// Where a vertex goes in the output.
    pub fn layout(&self) -> OutputLayout {
        self.layout
    }

    /// Positions after a stage: `vec4`, `w = 1`, instance after instance.
    pub fn positions(&self, stage: Positions) -> &wgpu::Buffer {
        match stage {
            Positions::Skinned => &self.buffers.skinned,
            Positions::Tracked => &self.buffers.tracked,
        }
    }

    /// Muscles of the last frame ([`MuscleFrame`]), instance after instance.
    pub fn muscles(&self) -> &wgpu::Buffer {
        &self.buffers.muscles
    }

    /// Points of the muscles' axes in the last frame ([`AxisPoint`]), instance after instance.
    pub fn axes(&self) -> &wgpu::Buffer {
        &self.buffers.axes
    }

    /// How the march of every vertex ended ([`MarchReport`]), instance after instance.
    pub fn reports(&self) -> &wgpu::Buffer {
        &self.buffers.reports
    }
}

/// One character in motion: a batch of one.
#[derive(Debug)]
pub struct Instance {
    batch: Batch,
}

impl Instance {
    /// Makes an instance in the rest pose.
    ///
    /// # Errors
    /// As [`Batch::new`].
    pub fn new(
        kernels: &Kernels,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        rig: &Arc<RigBuffers>,
        output: Output,
    ) -> Result<Instance, SetupError> {
        Ok(Instance { batch: Batch::new(kernels, device, queue, rig, 1, output)? })
    }

    /// Poses it.
    ///
    /// # Errors
    /// As [`Batch::set_pose`].
    pub fn set_pose(&mut self, queue: &wgpu::Queue, pose: &Pose) -> Result<(), PoseError> {
        self.batch.set_pose(queue, 0, pose)
    }

    /// Chooses what the following frames compute.
    pub fn set_options(&mut self, queue: &wgpu::Queue, options: &FrameOptions) {
        self.batch.set_options(queue, options);
    }

    /// Records one frame. Neither submits, polls nor maps.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        self.batch.encode(encoder);
    }

    /// The output vertices.
    pub fn output(&self) -> &wgpu::Buffer {
        self.batch.output()
    }

    /// The batch of one behind it, with every intermediate buffer.
    pub fn batch(&self) -> &Batch {
        &self.batch
    }
}

fn counts(rig: &RigBuffers) -> Counts {
    Counts {
        vertices: rig.rig.character.vertex_count() as u32,
        muscles: rig.rig.muscles.len() as u32,
        points: rig.rig.point_count,
        groups: rig.rig.grids.len() as u32,
    }
}

impl Buffers {
    fn new(
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
            ("output vertices", layout.end(u64::from(counts.vertices) * u64::from(count))),
        ];
        let limits = device.limits();
        for (name, bytes) in &sizes {
            fits(&limits, &format!("`{}`, {count} instances: {name}", rig.rig.character.name), *bytes)?;
        }
        output.check(sizes[8].1, &limits)?;
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
                    buffer(device, sizes[8].0, sizes[8].1, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX)
                }
            },
            vertex_params: uniform("vertex params", size_of::<VertexParams>()),
            muscle_params: uniform("muscle params", size_of::<MuscleParams>()),
            march_params: uniform("march params", size_of::<MarchParams>()),
            normal_params: uniform("normal params", size_of::<NormalParams>()),
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

fn prepare(
    kernels: &Kernels,
    device: &wgpu::Device,
    rig: &RigBuffers,
    b: &Buffers,
) -> Result<Vec<Prepared>, SetupError> {
    let make = |kernel, reads, buffers: &[(&str, &wgpu::Buffer)]| {
        let bindings = kernels.bind(device, kernel, buffers)?;
        Ok(Prepared { kernel, reads, pipeline: kernels.pipeline(kernel).clone(), bindings })
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
    Ok(vec![
        make(KernelId::SkinLinear, None, &skin)?,
        make(KernelId::SkinDualQuaternion, None, &skin)?,
        make(KernelId::MuscleShape, None, &shape)?,
        make(KernelId::March, None, &march)?,
        make(KernelId::Normals, Some(Positions::Skinned), &normals(&b.skinned))?,
        make(KernelId::Normals, Some(Positions::Tracked), &normals(&b.tracked))?,
    ])
}
