//! Characters in motion: the state and per-frame buffers of one or many instances of a rig.

use super::{
    Kernels, RigBuffers,
    buffers::{Buffers, Prepared, prepare},
    output::{Output, OutputLayout},
};
use crate::{
    dynamics::{Clock, DynamicsParams},
    error::{PoseError, SetupError},
    kernel::{dispatch, kernel, muscle_project},
    normals::NormalParams,
    rig::{FrameInputs, Pose},
    schedule::{self, Counts, DynamicsOptions, FrameOptions, KernelId, Positions, Step},
    skinning::VertexParams,
    tracking::MarchParams,
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
    pub(super) count: u32,
    steps: Vec<Step>,
    buffers: Buffers,
    layout: OutputLayout,
    pipelines: Vec<Prepared>,
    options: FrameOptions,
    /// Per instance, where its dynamics stand.
    pub(super) clocks: Vec<Clock>,
    /// Per instance, substeps of its last pose.
    turns: Vec<u32>,
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
        let mut batch = Batch {
            rig: Arc::clone(rig),
            count,
            steps: Vec::new(),
            buffers,
            layout,
            pipelines,
            options: FrameOptions::default(),
            clocks: vec![Clock::default(); count as usize],
            turns: vec![0; count as usize],
        };
        let joint_count = rig.rig.character.joints.len() as u32;
        let vertex = VertexParams { vertex_count: counts.vertices, instance_count: count, joint_count, pad_0: 0 };
        queue.write_buffer(&batch.buffers.vertex_params, 0, bytemuck::bytes_of(&vertex));
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
        if counts.dynamics(options) != counts.dynamics(&self.options) {
            self.clocks.fill(Clock::default());
            self.turns.fill(0);
        }
        self.options = *options;
        self.plan();
        // A substep's pipelines are made now, so that no frame waits for them.
        let joints = self.rig.rig.character.joints.len() as u32;
        for step in schedule::frame(&counts, options, joints, 1) {
            if let Some(prepared) = self.prepared(&step) {
                prepared.pipelines.variant(self.variant(&step));
            }
        }
        self.write_dynamics(queue);
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

    /// Lists the steps of the coming frame.
    fn plan(&mut self) {
        let joints = self.rig.rig.character.joints.len() as u32;
        let turns = self.turns.iter().copied().max().unwrap_or(0);
        self.steps = schedule::frame(&counts(&self.rig), &self.options, joints, turns);
    }

    fn write_dynamics(&self, queue: &wgpu::Queue) {
        let counts = counts(&self.rig);
        let joint_count = self.rig.rig.character.joints.len() as u32;
        let dynamics = counts.dynamics(&self.options);
        let muscle = MuscleParams {
            muscle_count: counts.muscles,
            instance_count: self.count,
            joint_count,
            group_count: counts.groups,
            point_count: counts.points,
            moving: dynamics.is_some().into(),
            ..MuscleParams::default()
        };
        queue.write_buffer(&self.buffers.muscle_params, 0, bytemuck::bytes_of(&muscle));
        let Some(options) = dynamics else { return };
        let params = |outer| DynamicsParams::new(&counts, self.count, joint_count, &options, outer);
        for (outer, buffer) in (0..).zip(&self.buffers.outer_params) {
            queue.write_buffer(buffer, 0, bytemuck::bytes_of(&params(outer)));
        }
        let carry = DynamicsParams { carries: 1, ..params(0) };
        queue.write_buffer(&self.buffers.carry_params, 0, bytemuck::bytes_of(&carry));
    }

    /// Lets an instance's next pose start its dynamics anew, as after a teleport.
    ///
    /// # Panics
    /// `instance` is not below the batch's count.
    pub fn reset(&mut self, instance: u32) {
        assert!(instance < self.count, "instance {instance} of a batch of {}", self.count);
        self.clocks[instance as usize].reset();
    }

    /// Poses one instance. With dynamics, each pose moves the instance's muscles on to its time: encode and submit a frame
    /// after each.
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
        if let Some(options) = counts(&self.rig).dynamics(&self.options) {
            self.advance(queue, instance, &inputs, f64::from(pose.time), &options);
        }
        Ok(())
    }

    /// Moves an instance's clock on, and puts its muscles in place where a motion starts.
    fn advance(
        &mut self,
        queue: &wgpu::Queue,
        instance: u32,
        inputs: &FrameInputs,
        time: f64,
        options: &DynamicsOptions,
    ) {
        let turn = self.clocks[instance as usize].advance(time, &inputs.joints, options);
        let put = |buffer: &wgpu::Buffer, bytes: &[u8]| {
            queue.write_buffer(buffer, u64::from(instance) * bytes.len() as u64, bytes);
        };
        put(&self.buffers.clocks, bytemuck::bytes_of(&turn.clock));
        put(&self.buffers.joints_before, bytemuck::cast_slice(&turn.joints_before));
        if turn.starts {
            let particles = self.rig.bodies_rest.particles(&inputs.joints);
            put(&self.buffers.particles, bytemuck::cast_slice(&particles));
            put(&self.buffers.axes, bytemuck::cast_slice(&self.rig.bodies_rest.axes_rest));
        }
        self.turns[instance as usize] = turn.clock.turns;
        self.plan();
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
            let Some(prepared) = self.prepared(step) else { continue };
            let threads = u64::from(step.items) * u64::from(self.count);
            if let Some([x, y]) = dispatch::groups(threads, kernel(step.kernel).items_per_workgroup) {
                pass.set_pipeline(prepared.pipelines.variant(self.variant(step)));
                pass.set_bind_group(0, &prepared.bindings, &[]);
                pass.dispatch_workgroups(x, y, 1);
            }
        }
    }

    fn prepared(&self, step: &Step) -> Option<&Prepared> {
        self.pipelines.iter().find(|p| {
            p.kernel == step.kernel
                && (p.reads.is_none() || p.reads == step.reads)
                && p.part.is_none_or(|part| part == (step.outer, step.carries))
        })
    }

    /// Which of its kernel's pipelines a step needs.
    fn variant(&self, step: &Step) -> usize {
        let options = counts(&self.rig).dynamics(&self.options);
        let Some(options) = options.filter(|_| step.kernel == KernelId::MuscleProject) else { return 0 };
        let bodies = &self.rig.bodies_rest;
        let peers = options.contacts.muscles && bodies.muscles.iter().any(|m| m.peers_begin < m.skins_begin);
        let grids = options.contacts.bones && bodies.bones.iter().any(|bone| bone.grid.size_x > 0);
        muscle_project::variant(step.outer + 1 == options.outer, peers, grids)
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

    /// Muscles of the last frame ([`crate::field::muscle::MuscleFrame`]), instance after instance.
    pub fn muscles(&self) -> &wgpu::Buffer {
        &self.buffers.muscles
    }

    /// Points of the muscles' axes in the last frame ([`AxisPoint`](crate::field::muscle::AxisPoint)), instance after instance.
    pub fn axes(&self) -> &wgpu::Buffer {
        &self.buffers.axes
    }

    /// Points of the muscles in motion ([`crate::dynamics::Particle`]), instance after instance.
    pub fn particles(&self) -> &wgpu::Buffer {
        &self.buffers.particles
    }

    /// What muscles see of one another ([`axis::half`](crate::field::muscle::axis::half)), two halves an instance.
    pub fn iterates(&self) -> &wgpu::Buffer {
        &self.buffers.iterates
    }

    /// How the march of every vertex ended ([`crate::tracking::MarchReport`]), instance after instance.
    pub fn reports(&self) -> &wgpu::Buffer {
        &self.buffers.reports
    }
}

/// One character in motion: a batch of one.
#[derive(Debug)]
pub struct Instance {
    pub(super) batch: Batch,
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

    /// Lets the next pose start its dynamics anew: see [`Batch::reset`].
    pub fn reset(&mut self) {
        self.batch.reset(0);
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
        most_segments: rig.rig.most_segments(),
        groups: rig.rig.grids.len() as u32,
    }
}
