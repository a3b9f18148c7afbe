//! Joints at the end of a substep; twin [`crate::dynamics::joints::step`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    dynamics::{DynamicsParams, MovedJoint, StepClock},
    rig::JointFrame,
    schedule::KernelId,
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::JointStep,
    stem: "joint_step",
    source: include_str!("../../shaders/kernels/joint_step.wgsl"),
    parts: &[source::DISPATCH, source::MATH, source::INVERSE],
    structs: STRUCTS,
    constants: &[],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "dynamics::joints::step",
};

const STRUCTS: &[SharedStruct] =
    &[shared::<DynamicsParams>(), shared::<StepClock>(), shared::<JointFrame>(), shared::<MovedJoint>()];

const BINDINGS: &[Binding] =
    &[uniform("params"), read("clocks"), read("joints_before"), read("joints"), write("moved")];
