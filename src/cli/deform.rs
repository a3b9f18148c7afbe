//! The CPU reference or the GPU behind one call per frame.

use crate::args::Device;
use crate::failure::Failure;
use crate::playback::Moves;
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::dynamics::Particle;
use sinew::field::muscle::axis::half;
use sinew::field::muscle::{AxisPoint, MuscleFrame};
use sinew::reference::{Motion, Reference, Trace};
use sinew::rig::{Pose, Rig};
use sinew::schedule::FrameOptions;
use std::sync::Arc;

/// One frame's skin on the host, in cache order.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Positions, scene space, metres.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
}

/// One frame's muscles on the host, each in the space of its field group at rest.
#[derive(Clone, Debug, Default)]
pub struct Shaped {
    /// The muscles, in the rig's order.
    pub muscles: Vec<MuscleFrame>,
    /// Points of their axes.
    pub axes: Vec<AxisPoint>,
    /// The same points in motion, posed scene space; empty without dynamics.
    pub particles: Vec<Particle>,
    /// First half of the iterates of the dynamics; empty without.
    pub iterates: Vec<Vec4>,
}

/// Where the work will be done, opened before anything that takes long.
pub enum Machine {
    /// The CPU reference.
    Cpu,
    /// An adapter.
    #[cfg(feature = "gpu")]
    Gpu(Box<sinew::gpu::Headless>),
}

impl Machine {
    /// Opens what the command line asks for. A build without GPU support has only the reference.
    pub fn open(device: &Device) -> Result<Machine, Failure> {
        match device {
            Device::Cpu => Ok(Machine::Cpu),
            #[cfg(feature = "gpu")]
            other => Ok(Machine::Gpu(Box::new(crate::device::open(other)?))),
            #[cfg(not(feature = "gpu"))]
            Device::Auto => Ok(Machine::Cpu),
            #[cfg(not(feature = "gpu"))]
            Device::Named(name) => Err(Failure::Device(format!(
                "--device {name}: this sinew was built without GPU support; build it with feature `gpu`, or give --device cpu"
            ))),
        }
    }
}

/// A rig on the CPU, with the muscles of the last frame.
pub struct OnCpu {
    rig: Arc<Rig>,
    options: FrameOptions,
    motion: Motion,
    shaped: Shaped,
}

impl OnCpu {
    /// Nothing has moved yet.
    pub fn new(rig: &Arc<Rig>, options: &FrameOptions) -> OnCpu {
        let motion = Motion::new(rig, options);
        OnCpu { rig: Arc::clone(rig), options: *options, motion, shaped: Shaped::default() }
    }

    /// Deforms the skin to one pose.
    pub fn skin(&mut self, pose: &Pose) -> Result<Skin, Failure> {
        let trace = Reference::new(&self.rig).next(&mut self.motion, pose, &self.options).map_err(Failure::input)?;
        let points = |list: &[glam::Vec4]| list.iter().map(|p| p.xyz()).collect();
        let skin = Skin { positions: points(trace.positions()), normals: points(&trace.normals) };
        self.keep(trace);
        Ok(skin)
    }

    /// The muscles of the last frame.
    pub fn shaped(&self) -> &Shaped {
        &self.shaped
    }

    /// What deforms, in words.
    pub fn describe() -> String {
        format!("CPU reference, {} threads", rayon::current_num_threads())
    }

    fn keep(&mut self, trace: Trace) {
        let half = half(trace.muscles.len() as u32, trace.particles.len() as u32);
        let iterates = self.motion.simulation.as_ref().map_or(Vec::new(), |s| s.iterates[..half].to_vec());
        self.shaped = Shaped { muscles: trace.muscles, axes: trace.axes, particles: trace.particles, iterates };
    }
}

impl Moves for OnCpu {
    fn reset(&mut self) {
        self.motion.reset(&self.rig);
    }

    fn pass(&mut self, pose: &Pose) -> Result<(), Failure> {
        let reference = Reference::new(&self.rig);
        let trace = reference.advance(&mut self.motion, pose, &self.options).map_err(Failure::input)?;
        self.keep(trace);
        Ok(())
    }
}

/// What deforms.
pub enum Deformer {
    /// The reference.
    Cpu(Box<OnCpu>),
    /// A device.
    #[cfg(feature = "gpu")]
    Gpu(Box<crate::device::OnDevice>),
}

impl Deformer {
    /// Brings a rig to its machine.
    pub fn new(machine: Machine, rig: &Arc<Rig>, options: &FrameOptions) -> Result<Deformer, Failure> {
        match machine {
            Machine::Cpu => Ok(Deformer::Cpu(Box::new(OnCpu::new(rig, options)))),
            #[cfg(feature = "gpu")]
            Machine::Gpu(headless) => {
                Ok(Deformer::Gpu(Box::new(crate::device::OnDevice::new(*headless, rig, options)?)))
            }
        }
    }

    /// Deforms the skin to one pose.
    pub fn frame(&mut self, pose: &Pose) -> Result<Skin, Failure> {
        match self {
            Deformer::Cpu(cpu) => cpu.skin(pose),
            #[cfg(feature = "gpu")]
            Deformer::Gpu(device) => device.skin(pose),
        }
    }

    /// The muscles of the last frame, from the machine that deformed its skin.
    pub fn shaped(&self) -> Result<Shaped, Failure> {
        match self {
            Deformer::Cpu(cpu) => Ok(cpu.shaped().clone()),
            #[cfg(feature = "gpu")]
            Deformer::Gpu(device) => device.shaped(),
        }
    }

    /// What deforms, in words.
    pub fn describe(&self) -> String {
        match self {
            Deformer::Cpu(_) => OnCpu::describe(),
            #[cfg(feature = "gpu")]
            Deformer::Gpu(device) => device.headless.info.name.clone(),
        }
    }
}

impl Moves for Deformer {
    fn reset(&mut self) {
        match self {
            Deformer::Cpu(cpu) => cpu.reset(),
            #[cfg(feature = "gpu")]
            Deformer::Gpu(device) => device.reset(),
        }
    }

    fn pass(&mut self, pose: &Pose) -> Result<(), Failure> {
        match self {
            Deformer::Cpu(cpu) => cpu.pass(pose),
            #[cfg(feature = "gpu")]
            Deformer::Gpu(device) => device.pass(pose),
        }
    }
}
