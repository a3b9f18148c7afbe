//! Vertices to where a sub-pose's joints take them; twin [`crate::tracking::carry`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    rig::{Influence, Role, VertexTarget},
    schedule::KernelId,
    tracking::{self, StopReason, Track, TrackJoint, TrackParams, Way},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::TrackCarry,
    stem: "track_carry",
    source: include_str!("../../shaders/kernels/track_carry.wgsl"),
    parts: &[source::DISPATCH, source::MATH],
    structs: STRUCTS,
    constants: &[
        ("ROLE_PASSIVE", Role::Passive as u32 as f64),
        ("ROLE_COPY", Role::Copy as u32 as f64),
        ("STOP_NON_FINITE", StopReason::NonFinite as u32 as f64),
        ("TRACK_RUNS", tracking::RUNS as f64),
        ("TRACK_ENDS", tracking::ENDS as f64),
        ("LOST_PULL", tracking::LOST_PULL as f64),
        ("LEAST_AWAY", tracking::LEAST_AWAY as f64),
    ],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::carry",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<TrackParams>(),
    shared::<TrackJoint>(),
    shared::<Way>(),
    shared::<Influence>(),
    shared::<VertexTarget>(),
    shared::<Track>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("joints"),
    read("ways"),
    read("positions_rest"),
    read("offsets"),
    read("influences"),
    read("targets"),
    write("positions"),
    write("tracks"),
];
