//! Kernels as data: which WGSL a kernel is assembled from, what it binds by name, how it is dispatched, and where
//! its CPU twin stands. No device is needed for anything here.

pub mod dispatch;
pub mod source;

mod field_sample;
mod group_bound;
mod joint_step;
mod muscle_joint;
mod muscle_predict;
pub(crate) mod muscle_project;
mod muscle_sample;
mod muscle_shape;
mod normals;
mod operator_sample;
mod skin_dual_quaternion;
mod skin_hybrid;
mod skin_linear;
mod skin_weighted;
mod track_average;
mod track_carry;
mod track_fold;
pub(crate) mod track_march;
mod track_place;
mod track_slide;
mod track_span;
mod track_spread;
mod track_start;
mod track_turn;

use crate::schedule::KernelId;

/// Threads per workgroup of every kernel with a thread per item.
pub const WORKGROUP: u32 = 64;

/// Switch of kernels that follow paths: muscles lie round bones and joints.
const WRAPS: &str = "WRAPS";

/// The variant of such a kernel.
pub(crate) fn following(wraps: bool) -> usize {
    usize::from(!wraps)
}

/// How a kernel uses a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// A uniform buffer.
    Uniform,
    /// A storage buffer that is only read.
    Read,
    /// A storage buffer that is written.
    Write,
}

/// One binding of a kernel; its slot is its place in [`Kernel::bindings`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Name of the WGSL global.
    pub name: &'static str,
    /// How it is used.
    pub access: Access,
}

/// A struct that kernels share with the host.
#[derive(Clone, Copy)]
pub struct SharedStruct {
    /// Its name on both sides.
    pub name: &'static str,
    /// Yields its WGSL declaration.
    pub wgsl: fn() -> String,
    /// Its members on the Rust side.
    pub fields: &'static [crate::math::GpuField],
    /// Bytes of the Rust struct.
    pub size: usize,
}

/// The [`SharedStruct`] of a type.
pub const fn shared<T: crate::math::GpuStruct>() -> SharedStruct {
    SharedStruct { name: T::NAME, wgsl: T::wgsl, fields: T::FIELDS, size: size_of::<T>() }
}

/// A kernel's description.
#[derive(Clone, Copy)]
pub struct Kernel {
    /// Which kernel.
    pub id: KernelId,
    /// Name of its files and of its pipeline.
    pub stem: &'static str,
    /// Text of `shaders/kernels/STEM.wgsl`.
    pub source: &'static str,
    /// Shared WGSL that it is assembled with.
    pub parts: &'static [source::Part],
    /// Structs that it shares with the host.
    pub structs: &'static [SharedStruct],
    /// WGSL overrides of the kernel's own file, with the host's values.
    pub constants: &'static [source::Constant],
    /// Boolean overrides. There is a pipeline for every choice of them, made when it is needed: what a dispatch has no use
    /// for it need not step over, and a software adapter runs what it steps over.
    pub switches: &'static [&'static str],
    /// Bindings in slot order.
    pub bindings: &'static [Binding],
    /// Threads of one workgroup.
    pub workgroup: u32,
    /// Items that one workgroup does: as many as it has threads, or one where it shares the work on it.
    pub items_per_workgroup: u32,
    /// Path of its CPU twin.
    pub twin: &'static str,
}

impl Kernel {
    /// All overrides of the assembled kernel with the host's values, in one of its [`Kernel::variants`]: bit k is set where
    /// switch k is off. Variant 0 can do everything.
    pub fn all_constants(&self, variant: usize) -> Vec<source::Constant> {
        let switches = self.switches.iter().enumerate();
        let switches = switches.map(|(k, name)| (*name, if variant >> k & 1 == 0 { 1.0 } else { 0.0 }));
        self.parts.iter().flat_map(|part| part.constants).chain(self.constants).copied().chain(switches).collect()
    }

    /// Number of pipelines.
    pub fn variants(&self) -> usize {
        1 << self.switches.len()
    }
}

/// Every kernel.
pub const KERNELS: [Kernel; 24] = [
    skin_linear::KERNEL,
    skin_dual_quaternion::KERNEL,
    skin_weighted::KERNEL,
    skin_hybrid::KERNEL,
    joint_step::KERNEL,
    muscle_predict::KERNEL,
    muscle_project::KERNEL,
    muscle_shape::KERNEL,
    muscle_joint::KERNEL,
    track_start::KERNEL,
    group_bound::KERNEL,
    track_carry::KERNEL,
    track_place::KERNEL,
    track_fold::KERNEL,
    track_march::KERNEL,
    track_turn::KERNEL,
    track_span::KERNEL,
    track_slide::KERNEL,
    track_average::KERNEL,
    track_spread::KERNEL,
    normals::KERNEL,
    field_sample::KERNEL,
    muscle_sample::KERNEL,
    operator_sample::KERNEL,
];

/// The description of a kernel.
pub fn kernel(id: KernelId) -> &'static Kernel {
    match id {
        KernelId::SkinLinear => &skin_linear::KERNEL,
        KernelId::SkinDualQuaternion => &skin_dual_quaternion::KERNEL,
        KernelId::SkinWeighted => &skin_weighted::KERNEL,
        KernelId::SkinHybrid => &skin_hybrid::KERNEL,
        KernelId::JointStep => &joint_step::KERNEL,
        KernelId::MusclePredict => &muscle_predict::KERNEL,
        KernelId::MuscleProject => &muscle_project::KERNEL,
        KernelId::MuscleShape => &muscle_shape::KERNEL,
        KernelId::MuscleJoint => &muscle_joint::KERNEL,
        KernelId::TrackStart => &track_start::KERNEL,
        KernelId::GroupBound => &group_bound::KERNEL,
        KernelId::TrackCarry => &track_carry::KERNEL,
        KernelId::TrackPlace => &track_place::KERNEL,
        KernelId::TrackFold => &track_fold::KERNEL,
        KernelId::TrackMarch => &track_march::KERNEL,
        KernelId::TrackTurn => &track_turn::KERNEL,
        KernelId::TrackSpan => &track_span::KERNEL,
        KernelId::TrackSlide => &track_slide::KERNEL,
        KernelId::TrackAverage => &track_average::KERNEL,
        KernelId::TrackSpread => &track_spread::KERNEL,
        KernelId::Normals => &normals::KERNEL,
        KernelId::FieldSample => &field_sample::KERNEL,
        KernelId::MuscleSample => &muscle_sample::KERNEL,
        KernelId::OperatorSample => &operator_sample::KERNEL,
    }
}

const fn uniform(name: &'static str) -> Binding {
    Binding { name, access: Access::Uniform }
}

const fn read(name: &'static str) -> Binding {
    Binding { name, access: Access::Read }
}

const fn write(name: &'static str) -> Binding {
    Binding { name, access: Access::Write }
}
