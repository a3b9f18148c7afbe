//! How fields are put together: the muscles of a bone by [`clean_union()`], muscles and limb by [`detail()`], the limbs that
//! meet at a joint by [`joint()`].
//!
//! Every operator is a function of two values in 0..=1 that gives a value in 0..=1 and its two partial derivatives; on
//! samples the gradients follow by the chain rule.

mod clean_union;
mod controller;
mod detail;
mod joint;
mod sample;

pub use clean_union::{clean_union, clean_union_all, clean_union_values};
pub use controller::{Controller, curves};
pub use detail::{detail, detail_samples};
pub use joint::{JointOperator, JointOperatorParams, joint, joint_values};
pub use sample::{OperatorInput, OperatorParams, operate};

// Numbers that kernels are given.
#[cfg(feature = "gpu")]
pub(crate) use self::{
    clean_union::{ITERATIONS, SMALL},
    controller::STEPS,
    detail::{FILLET, HEADROOM, SATURATION},
    joint::{CLOSED, CODE_SHIFT, PIECES, PROFILE_BULGE, PROFILE_UNION},
    sample::CLEAN_UNION,
};

use super::Sample;

/// Value of every surface.
pub(crate) const SURFACE: f32 = 0.5;

/// The larger of two fields, the first of equal ones: the plain union.
#[inline]
pub fn larger(a: Sample, b: Sample) -> Sample {
    if b.value > a.value { b } else { a }
}

/// A value with its derivatives by the larger and by the smaller of two values.
type Partials = (f32, f32, f32);

/// A composition of the larger and the smaller of two samples, by the chain rule.
#[inline]
fn chained(big: Sample, small: Sample, (value, by_big, by_small): Partials) -> Sample {
    Sample { value, gradient: big.gradient * by_big + small.gradient * by_small }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    type Operator<'a> = &'a dyn Fn(f32, f32) -> Partials;

    /// How far partial derivatives are from central differences over a grid, but for the places where either side of the
    /// difference lies on another branch: there `smooth` is false.
    pub(super) fn worst_slope(operator: Operator, smooth: &dyn Fn(f32, f32) -> bool) -> f32 {
        let h = 1e-3;
        let mut worst = 0.0f32;
        let mut seen = 0;
        for i in 1..60 {
            for j in 1..60 {
                let (a, b) = (i as f32 / 60.0 + 0.0031, j as f32 / 60.0 + 0.0071);
                if a.max(b) > 0.99 || !smooth(a, b) {
                    continue;
                }
                seen += 1;
                let (_, by_a, by_b) = operator(a, b);
                let along_a = (operator(a + h, b).0 - operator(a - h, b).0) / (2.0 * h);
                let along_b = (operator(a, b + h).0 - operator(a, b - h).0) / (2.0 * h);
                worst = worst.max((by_a - along_a).abs()).max((by_b - along_b).abs());
            }
        }
        assert!(seen > 300, "only {seen} places");
        worst
    }

    #[test]
    fn the_larger_field_is_taken_whole() {
        let sample = |value, x| Sample { value, gradient: Vec3::X * x };
        let (a, b) = (sample(0.3, 1.0), sample(0.4, 2.0));
        assert_eq!((larger(a, b), larger(b, a)), (b, b));
        let same = sample(0.3, 5.0);
        assert_eq!((larger(a, same), larger(same, a)), (a, same), "the first of equals");
    }
}
