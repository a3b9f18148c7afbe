//! A rig on a device of our own.

use crate::args::Device;
use crate::deform::{Shaped, Skin};
use crate::failure::Failure;
use crate::playback::Moves;
use crate::progress::Progress;
use glam::{Vec3, Vec4};
use sinew::error::DeviceError;
use sinew::field::muscle::axis::half;
use sinew::gpu::{DeviceChoice, Headless, Instance, Kernels, Output, RigBuffers, readback};
use sinew::parity::{self, GpuResult};
use sinew::rig::{Pose, Rig};
use sinew::schedule::{FrameOptions, Positions, Step};
use sinew::tracking::Track;
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
    /// Whether muscles move by themselves.
    moving: bool,
    /// Frames since the device was last waited for.
    ahead: u32,
}

/// Frames without readback that may be on their way at a time: what waits for more of them may time out.
const MOST_AHEAD: u32 = 16;

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
        let (vertices, moving) = (rig.character.vertex_count(), options.dynamics.is_some());
        Ok(OnDevice { headless, instance, vertices, moving, ahead: 0 })
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
        let (particles, iterates) = if self.moving { (points, half(muscles as u32, points as u32)) } else { (0, 0) };
        Ok(Shaped {
            muscles: readback::read(&self.headless, batch.muscles(), ..muscles).map_err(Failure::device)?,
            axes: readback::read(&self.headless, batch.axes(), ..points).map_err(Failure::device)?,
            particles: readback::read(&self.headless, batch.particles(), ..particles).map_err(Failure::device)?,
            iterates: readback::read(&self.headless, batch.iterates(), ..iterates).map_err(Failure::device)?,
        })
    }

    /// Brings the skin as the tracker holds it to the host: nothing where it is not tracked.
    pub fn tracked(&self) -> Result<(Vec<Vec4>, Vec<Track>), Failure> {
        let batch = self.instance.batch();
        let count = if batch.rig().grids.is_empty() { 0 } else { self.vertices };
        let positions = readback::read(&self.headless, batch.positions(Positions::Skin), ..count);
        let tracks = readback::read(&self.headless, batch.tracks(), ..count);
        Ok((positions.map_err(Failure::device)?, tracks.map_err(Failure::device)?))
    }

    /// Deforms to one pose and brings every stage to the host.
    pub fn stages(&mut self, pose: &Pose) -> Result<GpuResult, Failure> {
        self.play(pose)?;
        parity::capture(&self.headless, self.instance.batch(), 0).map_err(Failure::device)
    }
}

impl Moves for OnDevice {
    fn reset(&mut self) {
        self.instance.reset(&self.headless.queue);
    }

    fn pass(&mut self, pose: &Pose) -> Result<(), Failure> {
        self.instance.set_pose(&self.headless.queue, pose).map_err(Failure::input)?;
        self.headless.submit(|encoder| self.instance.batch().encode_where(encoder, None, Step::is_of_motion));
        self.ahead += 1;
        if self.ahead < MOST_AHEAD {
            return self.headless.check().map_err(Failure::device);
        }
        self.ahead = 0;
        self.headless.wait().map_err(Failure::device)
    }
}
