//! Muscles against their springs and contacts; twin [`crate::dynamics::project::project`].

use super::{Binding, Kernel, SharedStruct, read, shared, source, uniform, write};
use crate::{
    dynamics::{BoneRest, DynamicsParams, Link, MovedJoint, MuscleBody, Particle, predict},
    field::{GroupGrid, evaluate::GroupFrame},
    schedule::KernelId,
};

/// A thread has one pair of the usual 30 particles, and two of the most, 64.
const THREADS: u32 = 16;

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::MuscleProject,
    stem: "muscle_project",
    source: include_str!("../../shaders/kernels/muscle_project.wgsl"),
    parts: &[source::MATH, source::RUN, source::GRID, source::TOUCH, source::CHAIN, source::HOLD],
    structs: STRUCTS,
    constants: &[("MOST_STIFFNESS", predict::MOST_STIFFNESS as f64), ("STRIDE", 2.0 * THREADS as f64)],
    bindings: BINDINGS,
    workgroup: THREADS,
    items_per_workgroup: 1,
    twin: "dynamics::project::project",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<DynamicsParams>(),
    shared::<MuscleBody>(),
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
