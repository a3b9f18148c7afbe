//! Vertices to their rest iso-value; twin [`crate::tracking::march`].

use super::{Binding, Kernel, SharedStruct, read, shared, source, uniform, write};
use crate::{
    field::{GroupGrid, evaluate::GroupFrame, muscle::MuscleFrame},
    rig::VertexTarget,
    schedule::KernelId,
    tracking::{MarchParams, MarchReport},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::March,
    stem: "march",
    source: include_str!("../../shaders/kernels/march.wgsl"),
    parts: &[source::DISPATCH, source::MATH, source::MUSCLE, source::FIELD, source::CONTACT],
    structs: STRUCTS,
    bindings: BINDINGS,
    twin: "tracking::march",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<MarchParams>(),
    shared::<GroupGrid>(),
    shared::<GroupFrame>(),
    shared::<MuscleFrame>(),
    shared::<VertexTarget>(),
    shared::<MarchReport>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("groups"),
    read("nodes"),
    read("muscles"),
    read("targets"),
    read("skinned"),
    write("tracked"),
    write("reports"),
];
