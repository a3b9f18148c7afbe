//! How much folding joints displace; twin [`crate::tracking::fold`].

use super::{Binding, Kernel, SharedStruct, read, shared, source, uniform, write};
use crate::{
    field::{Fold, GroupGrid, evaluate::GroupFrame},
    rig::{FoldPatch, FoldTriangle},
    schedule::KernelId,
    tracking::{self, TrackJoint, TrackParams, Way},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::TrackFold,
    stem: "track_fold",
    source: include_str!("../../shaders/kernels/track_fold.wgsl"),
    parts: &[source::MATH, source::FOLD],
    structs: STRUCTS,
    constants: &[
        ("LANES", tracking::FOLD_LANES as f64),
        ("GAIN", tracking::FOLD_GAIN as f64),
        ("LEAST_WEIGHT", tracking::LEAST_FOLD_WEIGHT as f64),
    ],
    switches: &[],
    bindings: BINDINGS,
    workgroup: tracking::FOLD_LANES,
    items_per_workgroup: 1,
    twin: "tracking::fold",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<TrackParams>(),
    shared::<Way>(),
    shared::<TrackJoint>(),
    shared::<Fold>(),
    shared::<GroupGrid>(),
    shared::<GroupFrame>(),
    shared::<FoldPatch>(),
    shared::<FoldTriangle>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("ways"),
    read("joints"),
    read("patches"),
    read("triangles"),
    read("positions_rest"),
    read("positions"),
    write("groups"),
    write("offsets"),
];
