//! The field at given points; twin [`crate::tracking::sample`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    field::{
        Fold, GroupGrid,
        evaluate::GroupFrame,
        muscle::{AxisPoint, MuscleFrame},
    },
    schedule::KernelId,
    tracking::SampleParams,
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::FieldSample,
    stem: "field_sample",
    source: include_str!("../../shaders/kernels/field_sample.wgsl"),
    parts: &[
        source::DISPATCH,
        source::MATH,
        source::TRANSFER,
        source::FOLD,
        source::NEAREST,
        source::PROFILE,
        source::MUSCLE,
        source::MUSCLE_FIELD,
        source::GRID,
        source::CLEAN_UNION,
        source::FIELD,
    ],
    structs: STRUCTS,
    constants: &[],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::sample",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<SampleParams>(),
    shared::<Fold>(),
    shared::<GroupGrid>(),
    shared::<GroupFrame>(),
    shared::<AxisPoint>(),
    shared::<MuscleFrame>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("groups"),
    read("nodes"),
    read("muscles"),
    read("axes"),
    read("points"),
    write("samples"),
];
