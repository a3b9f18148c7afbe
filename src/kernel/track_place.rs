//! How vertices see the groups around them; twin [`crate::tracking::place`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    field::evaluate::Place,
    rig::{Influence, NO_JOINT, Reach},
    schedule::KernelId,
    tracking::{self, TrackJoint, TrackParams, Way},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::TrackPlace,
    stem: "track_place",
    source: include_str!("../../shaders/kernels/track_place.wgsl"),
    parts: &[source::DISPATCH, source::MATH, source::INVERSE],
    structs: STRUCTS,
    constants: &[
        ("NO_JOINT", NO_JOINT as f64),
        ("OPEN_FROM", tracking::OPEN_FROM as f64),
        ("OPEN_RANGE", tracking::OPEN_RANGE as f64),
    ],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "tracking::place",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<TrackParams>(),
    shared::<TrackJoint>(),
    shared::<Way>(),
    shared::<Reach>(),
    shared::<Influence>(),
    shared::<Place>(),
];

const BINDINGS: &[Binding] =
    &[uniform("params"), read("joints"), read("ways"), read("reaches"), read("blends"), write("places")];
