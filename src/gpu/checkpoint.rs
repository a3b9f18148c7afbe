//! Keeping the motion of an instance and going back to it, on the device.

use super::{Batch, Instance};
use crate::{
    dynamics::{Clock, Particle},
    field::{evaluate::Place, muscle::AxisPoint},
    schedule::Positions,
    tracking::{Path, Track},
};

/// What one instance hands on to its next frame: its muscles' particles and axes, its skin, and where both stand in time.
///
/// All else is made anew in every frame. It fits any instance of the same character on the same device whose dynamics
/// have the same options.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    clock: Clock,
    path: Path,
    /// Copies of the buffers of [`Batch::kept`].
    buffers: [wgpu::Buffer; 6],
}

impl Batch {
    /// Records the copying of an instance's motion as the frame encoded last leaves it: behind that frame in the same
    /// encoder, or after it is submitted and before the instance's next pose. Neither submits, polls nor maps.
    ///
    /// # Panics
    /// `instance` is not below the batch's count.
    pub fn save(&self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, instance: u32) -> Checkpoint {
        assert!(instance < self.count, "instance {instance} of a batch of {}", self.count);
        let mut copy = |from: &wgpu::Buffer, size: u64| {
            let to = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("sinew.checkpoint"),
                size: size.max(4),
                usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            encoder.copy_buffer_to_buffer(from, u64::from(instance) * size, &to, 0, size);
            to
        };
        Checkpoint {
            clock: self.clocks[instance as usize].clone(),
            path: self.paths[instance as usize].clone(),
            buffers: self.kept().map(|(buffer, size)| copy(buffer, size)),
        }
    }

    /// Records the way back to a checkpoint: the instance's next pose goes on from there, to the bit. Submit `encoder`
    /// before that pose.
    ///
    /// # Panics
    /// `instance` is not below the batch's count, or the checkpoint is of a character with other muscles.
    pub fn restore(&mut self, encoder: &mut wgpu::CommandEncoder, instance: u32, checkpoint: &Checkpoint) {
        assert!(instance < self.count, "instance {instance} of a batch of {}", self.count);
        for ((to, size), from) in self.kept().into_iter().zip(&checkpoint.buffers) {
            assert!(from.size() == size.max(4), "a checkpoint of another character");
            encoder.copy_buffer_to_buffer(from, 0, to, u64::from(instance) * size, size);
        }
        self.clocks[instance as usize] = checkpoint.clock.clone();
        self.paths[instance as usize] = checkpoint.path.clone();
    }

    /// The buffers that a motion lives in, with one instance's bytes in each.
    fn kept(&self) -> [(&wgpu::Buffer, u64); 6] {
        let rig = self.rig();
        let of = |count: usize, size: usize| count as u64 * size as u64;
        let vertices = if rig.grids.is_empty() { 0 } else { rig.positions_rest.len() };
        let points = rig.point_count as usize;
        [
            (self.particles(), of(points, size_of::<Particle>())),
            (self.axes(), of(points, size_of::<AxisPoint>())),
            (self.positions(Positions::Skin), of(vertices, 16)),
            (self.tracks(), of(vertices, size_of::<Track>())),
            (self.fold_offsets(), of(rig.fold_patches.len(), 4)),
            (self.places(), of(rig.targets.reaches.len(), size_of::<Place>())),
        ]
    }
}

impl Instance {
    /// Records the copying of its motion: see [`Batch::save`].
    pub fn save(&self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder) -> Checkpoint {
        self.batch().save(device, encoder, 0)
    }

    /// Records the way back to a checkpoint: see [`Batch::restore`].
    ///
    /// # Panics
    /// The checkpoint is of a character with other muscles.
    pub fn restore(&mut self, encoder: &mut wgpu::CommandEncoder, checkpoint: &Checkpoint) {
        self.batch.restore(encoder, 0, checkpoint);
    }
}
