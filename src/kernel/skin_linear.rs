//! Linear blend skinning; twin [`crate::skinning::linear`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    rig::{Influence, JointFrame},
    schedule::KernelId,
    skinning::VertexParams,
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::SkinLinear,
    stem: "skin_linear",
    source: include_str!("../../shaders/kernels/skin_linear.wgsl"),
    parts: &[source::DISPATCH],
    structs: STRUCTS,
    constants: &[],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "skinning::linear",
};

const STRUCTS: &[SharedStruct] = &[shared::<VertexParams>(), shared::<JointFrame>(), shared::<Influence>()];

const BINDINGS: &[Binding] =
    &[uniform("params"), read("joints"), read("positions_rest"), read("offsets"), read("influences"), write("skinned")];
