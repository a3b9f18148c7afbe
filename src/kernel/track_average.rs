//! One sweep of relaxation to the mean of neighbours; twin [`crate::tracking::average`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    rig::{Role, SkinEdge, VertexTarget},
    schedule::KernelId,
    tracking::{self, Track, TrackParams},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::TrackAverage,
    stem: "track_average",
    source: include_str!("../../shaders/kernels/track_average.wgsl"),
    parts: &[source::DISPATCH, source::MATH],
    structs: STRUCTS,
    constants: &[("ROLE_ACTIVE", Role::Active as u32 as f64), ("TRACK_RUNS", tracking::RUNS as f64)],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::average",
};

const STRUCTS: &[SharedStruct] =
    &[shared::<TrackParams>(), shared::<VertexTarget>(), shared::<SkinEdge>(), shared::<Track>()];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("targets"),
    read("edges"),
    read("mean_values"),
    read("tracks"),
    read("positions"),
    write("averaged"),
];
