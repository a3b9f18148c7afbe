//! Muscles at one moment; twin [`crate::wrap::shape`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    field::muscle::{self, AxisPoint, MuscleFrame, MuscleInput, MuscleRest, wrap::MuscleWrap},
    rig::JointFrame,
    schedule::KernelId,
    wrap::MuscleParams,
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::MuscleShape,
    stem: "muscle_shape",
    source: include_str!("../../shaders/kernels/muscle_shape.wgsl"),
    parts: &[
        source::DISPATCH,
        source::MATH,
        source::INVERSE,
        source::AXIS,
        source::RUN,
        source::CIRCLE,
        source::PATH,
        source::WRAP,
        source::COURSE,
    ],
    structs: STRUCTS,
    constants: &[
        ("MIN_LENGTH", muscle::MIN_LENGTH as f64),
        ("LEAST_SUPPORT_RADII", muscle::LEAST_SUPPORT_RADII as f64),
        ("ROUNDING", muscle::ROUNDING as f64),
        ("PI", std::f32::consts::PI as f64),
    ],
    switches: &[super::WRAPS],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "wrap::shape",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<MuscleParams>(),
    shared::<MuscleRest>(),
    shared::<MuscleInput>(),
    shared::<AxisPoint>(),
    shared::<JointFrame>(),
    shared::<MuscleFrame>(),
    shared::<MuscleWrap>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("muscles_rest"),
    read("inputs"),
    read("joints"),
    write("shaped"),
    write("axes"),
    read("iterates"),
    read("wraps"),
];
