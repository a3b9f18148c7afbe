//! Keeping the motion of an instance and going back to it, on the device.

use super::{Batch, Instance};
use crate::{dynamics::Clock, dynamics::Particle, field::muscle::AxisPoint};

/// What one instance's muscles hand on to its next frame: particles and axes on the device, and its clock.
///
/// All else is made anew in every frame. It fits any instance of the same character on the same device whose dynamics
/// have the same options.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    clock: Clock,
    particles: wgpu::Buffer,
    axes: wgpu::Buffer,
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
        let [particles, axes] = self.sizes();
        Checkpoint {
            clock: self.clocks[instance as usize].clone(),
            particles: copy(self.particles(), particles),
            axes: copy(self.axes(), axes),
        }
    }

    /// Records the way back to a checkpoint: the instance's next pose goes on from there, to the bit. Submit `encoder`
    /// before that pose.
    ///
    /// # Panics
    /// `instance` is not below the batch's count, or the checkpoint is of a character with other muscles.
    pub fn restore(&mut self, encoder: &mut wgpu::CommandEncoder, instance: u32, checkpoint: &Checkpoint) {
        assert!(instance < self.count, "instance {instance} of a batch of {}", self.count);
        let [particles, axes] = self.sizes();
        assert!(checkpoint.particles.size() == particles.max(4), "a checkpoint of another character");
        for (from, to, size) in
            [(&checkpoint.particles, self.particles(), particles), (&checkpoint.axes, self.axes(), axes)]
        {
            encoder.copy_buffer_to_buffer(from, 0, to, u64::from(instance) * size, size);
        }
        self.clocks[instance as usize] = checkpoint.clock.clone();
    }

    /// Bytes of one instance's particles and axes.
    fn sizes(&self) -> [u64; 2] {
        let points = u64::from(self.rig().point_count);
        [size_of::<Particle>(), size_of::<AxisPoint>()].map(|size| points * size as u64)
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
