//! How the skin around every vertex has turned; twin [`crate::tracking::turn`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    rig::{SkinEdge, VertexTarget},
    schedule::KernelId,
    tracking::{self, Track, TrackParams},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::TrackTurn,
    stem: "track_turn",
    source: include_str!("../../shaders/kernels/track_turn.wgsl"),
    parts: &[source::DISPATCH, source::MATH, source::QUATERNION],
    structs: STRUCTS,
    constants: &[
        ("TRACK_RUNS", tracking::RUNS as f64),
        ("TURNS", tracking::TURNS as f64),
        ("WEAKEST_TURN", tracking::WEAKEST_TURN as f64),
    ],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::turn",
};

const STRUCTS: &[SharedStruct] =
    &[shared::<TrackParams>(), shared::<VertexTarget>(), shared::<SkinEdge>(), shared::<Track>()];

const BINDINGS: &[Binding] =
    &[uniform("params"), read("targets"), read("edges"), read("positions_rest"), read("positions"), write("tracks")];
