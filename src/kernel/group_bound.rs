//! Spheres around groups and their muscles; twin [`crate::field::bound::bound`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    field::{Fold, GroupGrid, bound, evaluate::GroupFrame, muscle::MuscleFrame},
    schedule::KernelId,
    wrap::MuscleParams,
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::GroupBound,
    stem: "group_bound",
    source: include_str!("../../shaders/kernels/group_bound.wgsl"),
    parts: &[source::DISPATCH, source::MATH, source::INVERSE],
    structs: STRUCTS,
    constants: &[("ROUNDING", bound::ROUNDING as f64), ("FARTHEST", f32::MAX as f64)],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "field::bound::bound",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<MuscleParams>(),
    shared::<Fold>(),
    shared::<GroupGrid>(),
    shared::<GroupFrame>(),
    shared::<MuscleFrame>(),
];

const BINDINGS: &[Binding] = &[uniform("params"), read("muscles"), write("groups")];
