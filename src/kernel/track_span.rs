//! What vertices' edges come to; twin [`crate::tracking::span`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    rig::{Role, SkinEdge, VertexTarget},
    schedule::KernelId,
    tracking::{self, Track, TrackParams},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::TrackSpan,
    stem: "track_span",
    source: include_str!("../../shaders/kernels/track_span.wgsl"),
    parts: &[source::DISPATCH, source::MATH, source::QUATERNION],
    structs: STRUCTS,
    constants: &[("ROLE_ACTIVE", Role::Active as u32 as f64), ("TRACK_RUNS", tracking::RUNS as f64)],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::span",
};

const STRUCTS: &[SharedStruct] =
    &[shared::<TrackParams>(), shared::<VertexTarget>(), shared::<SkinEdge>(), shared::<Track>()];

const BINDINGS: &[Binding] =
    &[uniform("params"), read("targets"), read("edges"), read("positions_rest"), read("tracks"), write("spans")];
