//! Operators at many pairs of samples; the twin of the kernel `operator_sample`.

use super::{JointOperatorParams, clean_union, joint};
use crate::field::Sample;
use glam::{Vec4, Vec4Swizzles};

/// In place of a joint's profile: the clean union.
pub(crate) const CLEAN_UNION: u32 = 3;

crate::gpu_struct! {
    /// Parameters of the kernel `operator_sample`.
    pub struct OperatorParams {
        /// What joins the samples: the joint's operator, or the clean union where its profile is 3.
        pub joint: JointOperatorParams,
        /// Pairs of samples.
        pub count: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
        /// Unused.
        pub pad_2: u32,
    }
}

/// What [`operate`] reads: gradients in `xyz`, values in `w`.
#[derive(Clone, Copy, Debug)]
pub struct OperatorInput<'a> {
    /// The joint's operator; none is the clean union.
    pub operator: Option<JointOperatorParams>,
    /// One of every pair.
    pub left: &'a [Vec4],
    /// The other.
    pub right: &'a [Vec4],
}

impl OperatorInput<'_> {
    /// What the kernel reads besides.
    pub fn params(&self) -> OperatorParams {
        let clean = JointOperatorParams { profile: CLEAN_UNION, ..JointOperatorParams::default() };
        OperatorParams {
            joint: self.operator.unwrap_or(clean),
            count: self.left.len() as u32,
            ..OperatorParams::default()
        }
    }
}

/// Composes pairs of samples: `xyz` is the gradient, `w` the value.
pub fn operate(input: &OperatorInput<'_>, samples: &mut [Vec4]) {
    let sample = |v: &Vec4| Sample { value: v.w, gradient: v.xyz() };
    for ((a, b), out) in input.left.iter().zip(input.right).zip(samples) {
        let (a, b) = (sample(a), sample(b));
        let found = input.operator.map_or_else(|| clean_union(a, b), |operator| joint(a, b, &operator));
        *out = found.gradient.extend(found.value);
    }
}
