//! Operators on given pairs of samples; twin [`crate::field::compose::operate`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    field::compose::{self, JointOperatorParams, OperatorParams},
    schedule::KernelId,
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::OperatorSample,
    stem: "operator_sample",
    source: include_str!("../../shaders/kernels/operator_sample.wgsl"),
    parts: &[source::DISPATCH, source::MATH, source::TRANSFER, source::CLEAN_UNION, source::JOINT],
    structs: STRUCTS,
    constants: &[("CLEAN_UNION", compose::CLEAN_UNION as f64)],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "field::compose::operate",
};

const STRUCTS: &[SharedStruct] = &[shared::<JointOperatorParams>(), shared::<OperatorParams>()];

const BINDINGS: &[Binding] = &[uniform("params"), read("curves"), read("left"), read("right"), write("samples")];
