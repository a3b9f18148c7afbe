//! Vertices to their rest iso-value; twin [`crate::tracking::march`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    field::{
        GroupGrid,
        evaluate::GroupFrame,
        muscle::{AxisPoint, MuscleFrame},
    },
    rig::VertexTarget,
    schedule::KernelId,
    tracking::{self, MarchParams, MarchReport, StopReason},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::March,
    stem: "march",
    source: include_str!("../../shaders/kernels/march.wgsl"),
    parts: &[
        source::DISPATCH,
        source::MATH,
        source::TRANSFER,
        source::NEAREST,
        source::PROFILE,
        source::MUSCLE,
        source::MUSCLE_FIELD,
        source::GRID,
        source::FIELD,
        source::CONTACT,
    ],
    structs: STRUCTS,
    constants: &[
        ("MIN_GRADIENT_SQUARED", tracking::MIN_GRADIENT_SQUARED as f64),
        ("INFINITE_GAP", tracking::INFINITE_GAP as f64),
        ("STOP_PASSIVE", StopReason::Passive as u32 as f64),
        ("STOP_CONVERGED", StopReason::Converged as u32 as f64),
        ("STOP_NO_GRADIENT", StopReason::NoGradient as u32 as f64),
        ("STOP_PIT", StopReason::Pit as u32 as f64),
        ("STOP_STEP_LIMIT", StopReason::StepLimit as u32 as f64),
        ("STOP_NON_FINITE", StopReason::NonFinite as u32 as f64),
    ],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::march",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<MarchParams>(),
    shared::<GroupGrid>(),
    shared::<GroupFrame>(),
    shared::<AxisPoint>(),
    shared::<MuscleFrame>(),
    shared::<VertexTarget>(),
    shared::<MarchReport>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("groups"),
    read("nodes"),
    read("muscles"),
    read("axes"),
    read("targets"),
    read("skinned"),
    write("tracked"),
    write("reports"),
];
