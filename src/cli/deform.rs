//! The CPU reference or the GPU behind one call per frame.

use crate::args::Device;
use crate::failure::Failure;
use glam::{Vec3, Vec4Swizzles};
use sinew::field::muscle::{AxisPoint, MuscleFrame};
use sinew::reference::Reference;
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

/// What deforms.
pub enum Deformer {
    /// The reference, with the muscles of the last frame.
    Cpu(Arc<Rig>, Shaped),
    /// A device.
    #[cfg(feature = "gpu")]
    Gpu(Box<crate::device::OnDevice>),
}

impl Deformer {
    /// Brings a rig to its machine.
    pub fn new(machine: Machine, rig: &Arc<Rig>, options: &FrameOptions) -> Result<Deformer, Failure> {
        #[cfg(not(feature = "gpu"))]
        let _ = options;
        match machine {
            Machine::Cpu => Ok(Deformer::Cpu(Arc::clone(rig), Shaped::default())),
            #[cfg(feature = "gpu")]
            Machine::Gpu(headless) => {
                Ok(Deformer::Gpu(Box::new(crate::device::OnDevice::new(*headless, rig, options)?)))
            }
        }
    }

    /// Deforms the skin to one pose.
    pub fn frame(&mut self, pose: &Pose, options: &FrameOptions) -> Result<Skin, Failure> {
        match self {
            Deformer::Cpu(rig, shaped) => {
                let trace = Reference::new(rig).frame(pose, options).map_err(Failure::input)?;
                let points = |list: &[glam::Vec4]| list.iter().map(|p| p.xyz()).collect();
                let skin = Skin { positions: points(trace.positions()), normals: points(&trace.normals) };
                *shaped = Shaped { muscles: trace.muscles, axes: trace.axes };
                Ok(skin)
            }
            #[cfg(feature = "gpu")]
            Deformer::Gpu(device) => device.skin(pose),
        }
    }

    /// The muscles of the last frame, from the machine that deformed its skin.
    pub fn shaped(&self) -> Result<Shaped, Failure> {
        match self {
            Deformer::Cpu(_, shaped) => Ok(shaped.clone()),
            #[cfg(feature = "gpu")]
            Deformer::Gpu(device) => device.shaped(),
        }
    }

    /// What deforms, in words.
    pub fn describe(&self) -> String {
        match self {
            Deformer::Cpu(..) => format!("CPU reference, {} threads", rayon::current_num_threads()),
            #[cfg(feature = "gpu")]
            Deformer::Gpu(device) => device.headless.info.name.clone(),
        }
    }
}
