//! Positions of first copies to all vertices; twin [`crate::tracking::spread`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{rig::VertexTarget, schedule::KernelId, tracking::TrackParams};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::TrackSpread,
    stem: "track_spread",
    source: include_str!("../../shaders/kernels/track_spread.wgsl"),
    parts: &[source::DISPATCH],
    structs: STRUCTS,
    constants: &[],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::spread",
};

const STRUCTS: &[SharedStruct] = &[shared::<TrackParams>(), shared::<VertexTarget>()];

const BINDINGS: &[Binding] = &[uniform("params"), read("targets"), read("positions"), write("tracked")];
