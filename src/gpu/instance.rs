//! Characters in motion: the state and per-frame buffers of one or many instances of a rig.

use super::{
    Kernels, RigBuffers,
    buffers::{Buffers, Prepared, prepare},
    output::{Output, OutputLayout},
};
use crate::{
    dynamics::{Clock, DynamicsParams},
    error::{PoseError, SetupError},
    kernel::{dispatch, kernel, muscle_project, track_march},
    normals::NormalParams,
    rig::{FrameInputs, Pose},
    schedule::{self, Counts, DynamicsOptions, FrameOptions, KernelId, Positions, Skinning, Step, Tracking},
    skinning::{VertexParams, WeightedParams},
    tracking::{Path, Track, TrackParams, Way},
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
    /// Per instance, where its skin's joints are.
    pub(super) paths: Vec<Path>,
    /// Per instance, sub-poses of its last pose.
    sub_poses: Vec<u32>,
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
            paths: vec![Path::default(); count as usize],
            sub_poses: vec![0; count as usize],
        };
        let joint_count = rig.rig.character.joints.len() as u32;
        let vertex = VertexParams { vertex_count: counts.vertices, instance_count: count, joint_count, pad_0: 0 };
        queue.write_buffer(&batch.buffers.vertex_params, 0, bytemuck::bytes_of(&vertex));
        let weighted = WeightedParams {
            vertex_count: counts.vertices,
            instance_count: count,
            joint_count,
            muscle_count: counts.muscles,
            point_count: counts.points,
            ..WeightedParams::default()
        };
        queue.write_buffer(&batch.buffers.weighted_params, 0, bytemuck::bytes_of(&weighted));
        batch.set_options(queue, &FrameOptions::default());
        let rest = FrameInputs::new(&rig.rig, &Pose::rest(&rig.rig.character)).unwrap_or_default();
        for instance in 0..count {
            batch.write(queue, instance, &rest);
            batch.put_to_rest(queue, instance);
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
        if options.skinning != self.options.skinning {
            (0..self.count).for_each(|instance| self.put_to_rest(queue, instance));
        }
        self.options = *options;
        self.plan();
        // A substep's pipelines are made now, so that no frame waits for them.
        for step in schedule::frame(&counts, options, 1, 1) {
            if let Some(prepared) = self.prepared(&step) {
                prepared.pipelines.variant(self.variant(&step));
            }
        }
        self.write_dynamics(queue);
        let track = |sub_pose, projects| TrackParams::new(&counts, self.count, &options.track, sub_pose, projects);
        for (sub_pose, buffer) in (0..).zip(&self.buffers.track_params) {
            queue.write_buffer(buffer, 0, bytemuck::bytes_of(&track(sub_pose, false)));
        }
        queue.write_buffer(&self.buffers.projection_params, 0, bytemuck::bytes_of(&track(0, true)));
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
        queue.write_buffer(&self.buffers.normal_params, 0, bytemuck::bytes_of(&normal));
    }

    /// Lists the steps of the coming frame.
    fn plan(&mut self) {
        let most = |counts: &[u32]| counts.iter().copied().max().unwrap_or(0);
        let (turns, sub_poses) = (most(&self.turns), most(&self.sub_poses));
        self.steps = schedule::frame(&counts(&self.rig), &self.options, turns, sub_poses);
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

    /// Lets an instance's next pose start its dynamics and its skin anew, as after a teleport.
    ///
    /// # Panics
    /// `instance` is not below the batch's count.
    pub fn reset(&mut self, queue: &wgpu::Queue, instance: u32) {
        assert!(instance < self.count, "instance {instance} of a batch of {}", self.count);
        self.clocks[instance as usize].reset();
        self.put_to_rest(queue, instance);
    }

    /// Puts an instance's skin where it is at rest.
    fn put_to_rest(&mut self, queue: &wgpu::Queue, instance: u32) {
        if self.rig.rig.grids.is_empty() {
            return;
        }
        let positions: &[u8] = bytemuck::cast_slice(&self.rig.rig.positions_rest);
        queue.write_buffer(&self.buffers.skin, u64::from(instance) * positions.len() as u64, positions);
        let tracks = vec![Track::REST; self.rig.rig.positions_rest.len()];
        let tracks: &[u8] = bytemuck::cast_slice(&tracks);
        queue.write_buffer(&self.buffers.tracks, u64::from(instance) * tracks.len() as u64, tracks);
        self.unfold(queue, instance);
        let way = Way::default();
        let way = bytemuck::bytes_of(&way);
        queue.write_buffer(&self.buffers.ways, u64::from(instance) * way.len() as u64, way);
        self.paths[instance as usize] = Path::default();
        self.sub_poses[instance as usize] = 0;
    }

    /// Takes back what an instance's folding joints displace.
    fn unfold(&self, queue: &wgpu::Queue, instance: u32) {
        let offsets = vec![0u8; 4 * self.rig.rig.fold_patches.len()];
        queue.write_buffer(&self.buffers.offsets, u64::from(instance) * offsets.len() as u64, &offsets);
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
        if self.options.skinning == Skinning::Implicit && !self.rig.rig.grids.is_empty() {
            self.lead(queue, instance, pose);
        }
        self.plan();
        Ok(())
    }

    /// Writes the sub-poses that lead an instance's skin to a pose.
    fn lead(&mut self, queue: &wgpu::Queue, instance: u32, pose: &Pose) {
        let (way, sub_poses) = self.paths[instance as usize].lead(&self.rig.rig, pose, &self.options.track);
        if self.options.track.mode == Tracking::SinglePose {
            self.unfold(queue, instance);
        }
        for (sub_pose, at) in (0..).zip(sub_poses.iter().rev()) {
            let place = u64::from(sub_pose * self.count + instance);
            let joints: &[u8] = bytemuck::cast_slice(&at.joints);
            queue.write_buffer(&self.buffers.track_joints, place * joints.len() as u64, joints);
            let groups: &[u8] = bytemuck::cast_slice(&at.groups);
            queue.write_buffer(&self.buffers.groups, place * groups.len() as u64, groups);
        }
        let bytes = bytemuck::bytes_of(&way);
        queue.write_buffer(&self.buffers.ways, u64::from(instance) * bytes.len() as u64, bytes);
        self.sub_poses[instance as usize] = way.count;
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

    /// Records one frame of every instance; one that has got no pose since its last frame stays as it is. Neither submits,
    /// polls nor maps.
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
        let last = self.steps.iter().rfind(|step| step.is_of_motion() || step.forgotten);
        let ends = last.is_some_and(&chosen);
        for step in self.steps.iter().filter(|step| chosen(step)) {
            let Some(prepared) = self.prepared(step) else { continue };
            let threads = u64::from(step.items) * u64::from(self.count);
            if let Some([x, y]) = dispatch::groups(threads, kernel(step.kernel).items_per_workgroup) {
                pass.set_pipeline(prepared.pipelines.variant(self.variant(step)));
                pass.set_bind_group(0, &prepared.bindings, &[]);
                pass.dispatch_workgroups(x, y, 1);
            }
        }
        drop(pass);
        if ends {
            // A way is gone once.
            encoder.clear_buffer(&self.buffers.ways, 0, None);
        }
    }

    fn prepared(&self, step: &Step) -> Option<&Prepared> {
        self.pipelines.iter().find(|p| {
            p.kernel == step.kernel
                && (p.reads.is_none() || p.reads == step.reads)
                && p.part.is_none_or(|part| part == (step.outer, step.carries))
                && p.sub_pose.is_none_or(|sub_pose| sub_pose == (step.sub_pose, step.projects))
        })
    }

    /// Which of its kernel's pipelines a step needs.
    fn variant(&self, step: &Step) -> usize {
        if step.kernel == KernelId::TrackMarch {
            return track_march::variant(!self.rig().joins.is_empty());
        }
        if matches!(step.kernel, KernelId::MusclePredict | KernelId::MuscleShape) {
            return crate::kernel::following(!self.rig().wraps.is_empty());
        }
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

    /// Bytes on the device of all instances together, besides the rig's own ([`RigBuffers::bytes`]).
    pub fn bytes(&self) -> u64 {
        self.buffers.bytes
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
            Positions::Skin => &self.buffers.skin,
            Positions::Slid => &self.buffers.slid,
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

    /// How vertices see the groups around them ([`crate::field::evaluate::Place`]), instance after instance.
    pub fn places(&self) -> &wgpu::Buffer {
        &self.buffers.places
    }

    /// What folding joints displace, metres, instance after instance.
    pub fn fold_offsets(&self) -> &wgpu::Buffer {
        &self.buffers.offsets
    }

    /// What the tracker keeps of every vertex ([`crate::tracking::Track`]), instance after instance.
    pub fn tracks(&self) -> &wgpu::Buffer {
        &self.buffers.tracks
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

    /// Lets the next pose start its dynamics and its skin anew: see [`Batch::reset`].
    pub fn reset(&mut self, queue: &wgpu::Queue) {
        self.batch.reset(queue, 0);
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
        marched: rig.rig.targets.marched.len() as u32,
        joints: rig.rig.character.joints.len() as u32,
        reaches: rig.rig.targets.reaches.len() as u32,
        folds: rig.rig.fold_patches.len() as u32,
        muscles: rig.rig.muscles.len() as u32,
        points: rig.rig.point_count,
        most_segments: rig.rig.most_segments(),
        groups: rig.rig.grids.len() as u32,
    }
}
