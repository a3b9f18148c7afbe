//! One step towards the rest iso-values; twin [`crate::tracking::march`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    field::{
        Fold, GroupGrid,
        compose::JointOperatorParams,
        evaluate::{GroupFrame, Place},
        muscle::{AxisPoint, MuscleFrame},
    },
    rig::VertexTarget,
    schedule::KernelId,
    tracking::{self, StopReason, Track, TrackParams},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::TrackMarch,
    stem: "track_march",
    source: include_str!("../../shaders/kernels/track_march.wgsl"),
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
        source::JOINT,
        source::CONTACT,
    ],
    structs: STRUCTS,
    constants: &[
        ("MIN_GRADIENT_SQUARED", tracking::MIN_GRADIENT_SQUARED as f64),
        ("SETTLED", tracking::SETTLED as f64),
        ("STOP_CONVERGED", StopReason::Converged as u32 as f64),
        ("STOP_NO_GRADIENT", StopReason::NoGradient as u32 as f64),
        ("STOP_SHORT", StopReason::Short as u32 as f64),
        ("STOP_PRESSED", StopReason::Pressed as u32 as f64),
        ("STOP_NON_FINITE", StopReason::NonFinite as u32 as f64),
        ("TRACK_RUNS", tracking::RUNS as f64),
    ],
    switches: &[JOINS],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::march",
};

/// Groups are joined otherwise than by the plain union.
const JOINS: &str = "CONTACT_JOINS";

/// The variant that can do this and no more; see the switches.
pub(crate) fn variant(joins: bool) -> usize {
    usize::from(!joins)
}

const STRUCTS: &[SharedStruct] = &[
    shared::<TrackParams>(),
    shared::<Fold>(),
    shared::<GroupGrid>(),
    shared::<GroupFrame>(),
    shared::<Place>(),
    shared::<JointOperatorParams>(),
    shared::<AxisPoint>(),
    shared::<MuscleFrame>(),
    shared::<VertexTarget>(),
    shared::<Track>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("groups"),
    read("nodes"),
    read("muscles"),
    read("axes"),
    read("targets"),
    read("places"),
    write("positions"),
    write("tracks"),
    uniform("curves"),
];
