//! Dual quaternion skinning; twin [`crate::skinning::dual_quaternion`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    rig::{Influence, JointFrame},
    schedule::KernelId,
    skinning::VertexParams,
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::SkinDualQuaternion,
    stem: "skin_dual_quaternion",
    source: include_str!("../../shaders/kernels/skin_dual_quaternion.wgsl"),
    parts: &[source::DISPATCH, source::MATH],
    structs: STRUCTS,
    constants: &[],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "skinning::dual_quaternion",
};

const STRUCTS: &[SharedStruct] = &[shared::<VertexParams>(), shared::<JointFrame>(), shared::<Influence>()];

const BINDINGS: &[Binding] =
    &[uniform("params"), read("joints"), read("positions_rest"), read("offsets"), read("influences"), write("skinned")];
