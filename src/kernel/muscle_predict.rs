//! Muscles before anything holds them; twin [`crate::dynamics::predict::predict`].

use super::{Binding, Kernel, SharedStruct, read, shared, source, uniform, write};
use crate::{
    dynamics::{DynamicsParams, MovedJoint, MuscleBody, Particle, StepClock, jiggle, predict},
    field::muscle::{AxisPoint, MuscleInput, wrap::MuscleWrap},
    schedule::KernelId,
};

/// A thread is a whole muscle's work: few to a workgroup, so that a character's fifty occupy more than one core.
const THREADS: u32 = 16;

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::MusclePredict,
    stem: "muscle_predict",
    source: include_str!("../../shaders/kernels/muscle_predict.wgsl"),
    parts: &[
        source::MATH,
        source::INVERSE,
        source::PROFILE,
        source::RUN,
        source::CIRCLE,
        source::PATH,
        source::WRAP,
        source::COURSE,
        source::COURSES,
    ],
    structs: STRUCTS,
    constants: &[
        ("THREADS", THREADS as f64),
        ("PI", std::f32::consts::PI as f64),
        ("TAU", std::f32::consts::TAU as f64),
        ("STRETCH", predict::STRETCH as f64),
        ("MOST_PHASE_SQUARED", predict::MOST_PHASE_SQUARED as f64),
        ("MOST_WAY", predict::MOST_WAY as f64),
        ("NOMINAL_STIFFNESS", predict::NOMINAL_STIFFNESS as f64),
        ("RATE", predict::RATE as f64),
        ("JIGGLE_RATE", jiggle::RATE as f64),
        ("JIGGLE_DAMPING", jiggle::DAMPING as f64),
        ("JIGGLE_MOST_SHIFT", jiggle::MOST_SHIFT as f64),
        ("JIGGLE_MOST_DRIVE", jiggle::MOST_DRIVE as f64),
    ],
    switches: &[super::WRAPS],
    bindings: BINDINGS,
    workgroup: THREADS,
    items_per_workgroup: THREADS,
    twin: "dynamics::predict::predict",
};

const STRUCTS: &[SharedStruct] = &[
    shared::<DynamicsParams>(),
    shared::<MuscleBody>(),
    shared::<MuscleInput>(),
    shared::<MovedJoint>(),
    shared::<AxisPoint>(),
    shared::<Particle>(),
    shared::<StepClock>(),
    shared::<MuscleWrap>(),
];

const BINDINGS: &[Binding] = &[
    uniform("params"),
    read("bodies"),
    read("inputs"),
    read("moved"),
    read("axes"),
    write("particles"),
    write("iterates"),
    write("clocks"),
    read("wraps"),
];
