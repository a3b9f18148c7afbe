//! Muscles against their springs and contacts; twin [`crate::dynamics::project::project`].

use super::{Binding, Kernel, SharedStruct, read, shared, source, uniform, write};
use crate::{
    dynamics::{BoneRest, DynamicsParams, Link, MovedJoint, MuscleBody, Particle, predict},
    field::{GroupGrid, evaluate::GroupFrame, muscle::axis::MAX_SEGMENTS},
    schedule::KernelId,
};

/// A thread has two particles of at most 64.
pub(super) const THREADS: u32 = MAX_SEGMENTS.div_ceil(2);

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::MuscleProject,
    stem: "muscle_project",
    source: include_str!("../../shaders/kernels/muscle_project.wgsl"),
    parts: &[
        source::MATH,
        source::RUN,
        source::GRID,
        source::TOUCH,
        source::CHAIN,
        source::PEER_AXIS,
        source::PEERS,
        source::HOLD,
        source::SETTLE,
    ],
    structs: STRUCTS,
    constants: &[("MOST_STIFFNESS", predict::MOST_STIFFNESS as f64)],
    switches: &[ENDS, PEERS, GRIDS],
    bindings: BINDINGS,
    workgroup: THREADS,
    items_per_workgroup: THREADS,
    twin: "dynamics::project::project",
};

/// Substeps end: contacts are made exact, and particles get their new places and velocities.
const ENDS: &str = "ENDS";
/// Muscles meet muscles.
const PEERS: &str = "HOLD_PEERS";
/// Bones are meshes.
const GRIDS: &str = "TOUCH_GRIDS";

/// The variant that can do this and no more; see the switches.
pub(crate) fn variant(ends: bool, peers: bool, grids: bool) -> usize {
    usize::from(!ends) + 2 * usize::from(!peers) + 4 * usize::from(!grids)
}

const STRUCTS: &[SharedStruct] = &[
    shared::<DynamicsParams>(),
    shared::<MuscleBody>(),
    shared::<crate::field::Fold>(),
    shared::<GroupGrid>(),
    shared::<GroupFrame>(),
    shared::<BoneRest>(),
    shared::<Link>(),
    shared::<MovedJoint>(),
    shared::<Particle>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("bodies"),
    read("bones"),
    read("links"),
    read("moved"),
    read("groups"),
    read("nodes"),
    write("particles"),
    write("iterates"),
];
