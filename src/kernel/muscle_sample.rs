//! Muscles alone at given points; twin [`crate::field::muscle::union`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    field::muscle::{AxisPoint, MuscleFrame, UnionParams},
    schedule::KernelId,
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::MuscleSample,
    stem: "muscle_sample",
    source: include_str!("../../shaders/kernels/muscle_sample.wgsl"),
    parts: &[
        source::DISPATCH,
        source::MATH,
        source::NEAREST,
        source::PROFILE,
        source::MUSCLE,
        source::TRANSFER,
        source::MUSCLE_FIELD,
    ],
    structs: STRUCTS,
    constants: &[],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "field::muscle::union",
};

const STRUCTS: &[SharedStruct] = &[shared::<UnionParams>(), shared::<AxisPoint>(), shared::<MuscleFrame>()];

const BINDINGS: &[Binding] = &[uniform("params"), read("muscles"), read("axes"), read("points"), write("samples")];
