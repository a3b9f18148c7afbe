//! A rig on a device of our own.

use crate::args::Device;
use crate::deform::{Shaped, Skin};
use crate::failure::Failure;
use crate::progress::Progress;
use glam::Vec3;
use sinew::error::DeviceError;
use sinew::gpu::{DeviceChoice, Headless, Instance, Kernels, Output, RigBuffers, readback};
use sinew::parity::{self, GpuResult};
use sinew::rig::{Pose, Rig};
use sinew::schedule::FrameOptions;
use std::sync::Arc;

/// Opens the adapter that the command line asks for.
pub fn open(device: &Device) -> Result<Headless, Failure> {
    let choice = match device {
        Device::Auto | Device::Cpu => DeviceChoice::Auto,
        Device::Named(name) => DeviceChoice::Named(name.clone()),
    };
    Headless::new(&choice).map_err(|error| match error {
        DeviceError::NoAdapter => Failure::Device(format!("{error}; bake and inspect run with --device cpu")),
        other => Failure::device(other),
    })
}

/// A device with one instance of a rig.
pub struct OnDevice {
    /// The device.
    pub headless: Headless,
    instance: Instance,
    vertices: usize,
}

impl OnDevice {
    /// Builds the kernels and uploads the rig.
    pub fn new(headless: Headless, rig: &Arc<Rig>, options: &FrameOptions) -> Result<OnDevice, Failure> {
        let _progress = Progress::unknown("preparing the device");
        let (device, queue) = (&headless.device, &headless.queue);
        let kernels = Kernels::new(device).map_err(Failure::device)?;
        let buffers = Arc::new(RigBuffers::upload(device, Arc::clone(rig)).map_err(Failure::device)?);
        let mut instance = Instance::new(&kernels, device, queue, &buffers, Output::Owned).map_err(Failure::device)?;
        instance.set_options(queue, options);
        headless.check().map_err(Failure::device)?;
        Ok(OnDevice { headless, instance, vertices: rig.character.vertex_count() })
    }

    /// Deforms to one pose; the result stays in [`OnDevice::instance`].
    pub fn play(&mut self, pose: &Pose) -> Result<(), Failure> {
        self.instance.set_pose(&self.headless.queue, pose).map_err(Failure::input)?;
        self.headless.submit(|encoder| self.instance.encode(encoder));
        self.headless.check().map_err(Failure::device)
    }

    /// The instance that was played last.
    pub fn instance(&self) -> &Instance {
        &self.instance
    }

    /// Deforms to one pose and brings the skin to the host.
    pub fn skin(&mut self, pose: &Pose) -> Result<Skin, Failure> {
        self.play(pose)?;
        let vertices: Vec<[f32; 6]> =
            readback::read(&self.headless, self.instance.output(), ..self.vertices).map_err(Failure::device)?;
        Ok(Skin {
            positions: vertices.iter().map(|v| Vec3::new(v[0], v[1], v[2])).collect(),
            normals: vertices.iter().map(|v| Vec3::new(v[3], v[4], v[5])).collect(),
        })
    }

    /// Brings the muscles of the last frame to the host.
    pub fn shaped(&self) -> Result<Shaped, Failure> {
        let batch = self.instance.batch();
        let (muscles, points) = (batch.rig().muscles.len(), batch.rig().point_count as usize);
        Ok(Shaped {
            muscles: readback::read(&self.headless, batch.muscles(), ..muscles).map_err(Failure::device)?,
            axes: readback::read(&self.headless, batch.axes(), ..points).map_err(Failure::device)?,
        })
    }

    /// Deforms to one pose and brings every stage to the host.
    pub fn stages(&mut self, pose: &Pose) -> Result<GpuResult, Failure> {
        self.play(pose)?;
        parity::capture(&self.headless, self.instance.batch(), 0).map_err(Failure::device)
    }
}
