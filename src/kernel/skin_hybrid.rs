//! Linear skinning by bones and muscles; twin [`crate::skinning::hybrid`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    rig::{Influence, JointFrame},
    schedule::KernelId,
    skinning::WeightedParams,
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::SkinHybrid,
    stem: "skin_hybrid",
    source: include_str!("../../shaders/kernels/skin_hybrid.wgsl"),
    parts: &[source::DISPATCH],
    structs: STRUCTS,
    constants: &[],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "skinning::hybrid",
};

const STRUCTS: &[SharedStruct] = &[shared::<WeightedParams>(), shared::<JointFrame>(), shared::<Influence>()];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("joints"),
    read("muscle_joints"),
    read("positions_rest"),
    read("offsets"),
    read("influences"),
    write("skinned"),
];
