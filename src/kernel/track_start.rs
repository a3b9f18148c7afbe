//! A pose's skin where geometric skinning has it; twin [`crate::tracking::start`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    schedule::KernelId,
    tracking::{self, Track, TrackParams, Way},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::TrackStart,
    stem: "track_start",
    source: include_str!("../../shaders/kernels/track_start.wgsl"),
    parts: &[source::DISPATCH],
    structs: STRUCTS,
    constants: &[("TRACK_RUNS", tracking::RUNS as f64)],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::start",
};

const STRUCTS: &[SharedStruct] = &[shared::<TrackParams>(), shared::<Way>(), shared::<Track>()];

const BINDINGS: &[Binding] = &[uniform("params"), read("ways"), read("skinned"), write("positions"), write("tracks")];
