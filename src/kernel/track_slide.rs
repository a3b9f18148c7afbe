//! One sweep of relaxation along the field; twin [`crate::tracking::slide`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    rig::{Role, SkinEdge, VertexTarget},
    schedule::KernelId,
    tracking::{self, Track, TrackParams},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::TrackSlide,
    stem: "track_slide",
    source: include_str!("../../shaders/kernels/track_slide.wgsl"),
    parts: &[source::DISPATCH, source::MATH],
    structs: STRUCTS,
    constants: &[("ROLE_ACTIVE", Role::Active as u32 as f64), ("TRACK_RUNS", tracking::RUNS as f64)],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::slide",
};

const STRUCTS: &[SharedStruct] =
    &[shared::<TrackParams>(), shared::<VertexTarget>(), shared::<SkinEdge>(), shared::<Track>()];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("targets"),
    read("edges"),
    read("tracks"),
    read("spans"),
    read("positions"),
    write("slid"),
];
