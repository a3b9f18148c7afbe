//! Muscles as joints; twin [`crate::skinning::muscle_joints`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    field::muscle::{AxisPoint, MuscleFrame, MuscleRest, axis},
    rig::{JointFrame, MuscleJoint},
    schedule::KernelId,
    skinning::{LEAST_TURN, LONG, SHORT, SWELLS},
    wrap::MuscleParams,
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::MuscleJoint,
    stem: "muscle_joint",
    source: include_str!("../../shaders/kernels/muscle_joint.wgsl"),
    parts: &[source::DISPATCH, source::MATH, source::NEAREST, source::PROFILE, source::MUSCLE],
    structs: STRUCTS,
    constants: &[
        ("LEAST_SWELL", SWELLS[0] as f64),
        ("MOST_SWELL", SWELLS[1] as f64),
        ("LEAST_TURN", LEAST_TURN as f64),
        ("SHORT_NONE", SHORT[0] as f64),
        ("SHORT_WHOLE", SHORT[1] as f64),
        ("LONG_NONE", LONG[0] as f64),
        ("LONG_WHOLE", LONG[1] as f64),
        ("NO_DIRECTION", axis::NO_DIRECTION as f64),
    ],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "skinning::muscle_joints",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<MuscleParams>(),
    shared::<MuscleRest>(),
    shared::<MuscleJoint>(),
    shared::<JointFrame>(),
    shared::<MuscleFrame>(),
    shared::<AxisPoint>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("muscles_rest"),
    read("joints_rest"),
    read("joints"),
    read("muscles"),
    read("axes"),
    write("muscle_joints"),
];
