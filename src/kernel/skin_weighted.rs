//! Skinned vertices displaced by muscles alone; twin [`crate::skinning::weighted`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{
    field::muscle::{self, AxisPoint, MuscleFrame, MuscleWeight},
    rig::{JointFrame, NO_JOINT, WeightTarget},
    schedule::KernelId,
    skinning::{self, WeightedParams},
};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::SkinWeighted,
    stem: "skin_weighted",
    source: include_str!("../../shaders/kernels/skin_weighted.wgsl"),
    parts: &[
        source::DISPATCH,
        source::MATH,
        source::INVERSE,
        source::TRANSFER,
        source::NEAREST,
        source::PROFILE,
        source::MUSCLE,
        source::MUSCLE_FIELD,
        source::CLEAN_UNION,
    ],
    structs: STRUCTS,
    constants: &[
        ("STEPS", skinning::STEPS as f64),
        ("TOLERANCE", skinning::TOLERANCE as f64),
        ("LONGEST", skinning::LONGEST as f64),
        ("LEAST_SLOPE", skinning::LEAST_SLOPE as f64),
        ("HELD", skinning::HELD as f64),
        ("LEFT", skinning::LEFT as f64),
        ("NO_JOINT", NO_JOINT as f64),
        ("FACING", muscle::FACING as f64),
        ("WIDENED", muscle::WIDENED as f64),
    ],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "skinning::weighted",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<WeightedParams>(),
    shared::<JointFrame>(),
    shared::<MuscleFrame>(),
    shared::<AxisPoint>(),
    shared::<WeightTarget>(),
    shared::<MuscleWeight>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("joints"),
    read("muscles"),
    read("axes"),
    read("targets"),
    read("weights"),
    read("skinned"),
    write("displaced"),
];
