//! The clean union: the surface of the plain union, with a smooth field on both sides of it (background 3.3).
//!
//! A line of equal value C in the square of two values is a quarter circle of centre (k, k) and radius C - k between two
//! straight ends, with k = 2 C^2 below the surface's value and k = sqrt(C / 2) above. At 1/2 the circle has shrunk to the
//! corner of the plain union, so that the crease between two surfaces stays where and as it is, and nowhere else the
//! gradient jumps.
//!
//! C is the root of a quartic. It is found in units that vanish where its circle does: offsets from 1/2 near the corner,
//! shares of the larger value far below it. There the first guess is the root of the limit's quadratic, and four of
//! Newton's steps take it to the last bits of f32 whatever the values.

use super::{Partials, SURFACE, chained};
use crate::field::Sample;

/// Below this larger value C is looked for as a share of it.
pub(crate) const SMALL: f32 = 0.25;
/// Newton's steps: three leave an error of 3e-7, four 1e-8 beside the rounding.
pub(crate) const ITERATIONS: u32 = 4;

/// Value and derivatives by `big` and by `small`, of which `big` is the larger.
#[inline]
pub fn clean_union_values(big: f32, small: f32) -> Partials {
    let below = big < SURFACE;
    if if below { small <= 2.0 * big * big } else { small * small <= SURFACE * big } {
        return (big, 1.0, 0.0);
    }
    // With x the root in its unit, |f1 - k| = |U - 1|, |f2 - k| = |U - ratio| and C - k = W of that unit.
    let (unit, ratio, u1, u2, w2, mut x);
    if big < SMALL {
        (unit, ratio) = (big, small / big);
        (u1, u2, w2) = (0.0, 2.0 * unit, -2.0 * unit);
        x = (1.0 + ratio * ratio).sqrt() / (1.0 + unit * ratio);
    } else if below {
        unit = SURFACE - big;
        ratio = (SURFACE - small) / unit;
        (u1, u2, w2) = (2.0, -2.0 * unit, -2.0 * unit);
        x = (2.0 * (1.0 + ratio) + (8.0 * ratio - 3.0 - 3.0 * ratio * ratio).max(0.0).sqrt()) / 7.0;
        x = x.min(1.0);
    } else {
        unit = big - SURFACE;
        ratio = (small - SURFACE) / unit;
        (u1, u2, w2) = (1.0, 0.0, 2.0 * unit);
        x = 1.0 + ratio - (2.0 * ratio).sqrt();
    }
    for _ in 0..ITERATIONS {
        let u = x * (u1 + u2 * x);
        let w = x + w2 * x * x;
        let (p, r) = (u - 1.0, u - ratio);
        let slope = (p + r) * (u1 + 2.0 * u2 * x) - w * (1.0 + 2.0 * w2 * x);
        x -= (p * p + r * r - w * w) / (2.0 * slope);
    }
    let u = x * (u1 + u2 * x);
    let w = x + w2 * x * x;
    let (p, r) = ((u - 1.0).abs(), (u - ratio).abs());
    let offset = unit * x;
    let (value, k_slope);
    if below {
        value = if big < SMALL { offset } else { SURFACE - offset };
        k_slope = 4.0 * value;
    } else {
        value = SURFACE + 2.0 * offset * (1.0 + offset);
        if value >= 1.0 {
            return (1.0, 0.0, 0.0);
        }
        // k = 1/2 + offset, and C = 2 k^2.
        k_slope = 0.25 / (SURFACE + offset);
    }
    let scale = 1.0 / (k_slope * (p + r) + (1.0 - k_slope) * w);
    (value.max(big), p * scale, r * scale)
}

/// The clean union of two fields. What is 0 leaves the other one as it is.
#[inline]
pub fn clean_union(a: Sample, b: Sample) -> Sample {
    let (big, small) = if b.value > a.value { (b, a) } else { (a, b) };
    chained(big, small, clean_union_values(big.value, small.value))
}

/// The clean union of any number of fields, one after the other; 0 of none.
pub fn clean_union_all(samples: impl IntoIterator<Item = Sample>) -> Sample {
    samples.into_iter().fold(Sample::default(), clean_union)
}

#[cfg(test)]
mod tests {
    use super::super::tests::worst_slope;
    use super::*;
    use glam::Vec3;

    /// Derivatives by the first and the second of two values in any order.
    fn ordered(a: f32, b: f32) -> Partials {
        if b > a {
            let (value, by_b, by_a) = clean_union_values(b, a);
            (value, by_a, by_b)
        } else {
            clean_union_values(a, b)
        }
    }

    /// The value by bisection in f64.
    fn exact(a: f32, b: f32) -> f64 {
        let (big, small) = (f64::from(a.max(b)), f64::from(a.min(b)));
        let k = |c: f64| if big < 0.5 { 2.0 * c * c } else { (c / 2.0).sqrt() };
        if small <= k(big) {
            return big;
        }
        let mut ends = [big, if big < 0.5 { (small / 2.0).sqrt() } else { 2.0 * small * small }];
        for _ in 0..100 {
            let c = 0.5 * (ends[0] + ends[1]);
            let outside = (big - k(c)).hypot(small - k(c)) > c - k(c);
            ends[usize::from(!outside)] = c;
        }
        ends[0].min(1.0)
    }

    #[test]
    fn check_values_of_the_background() {
        for (a, b, expected) in [
            (0.3, 0.3, 0.332614),
            (0.4, 0.4, 0.419735),
            (0.2, 0.2, 0.236505),
            (0.7, 0.7, 0.738285),
            (0.2, 0.1, 0.201480),
            (0.45, 0.4, 0.45),
        ] {
            let value = ordered(a, b).0;
            assert!((value - expected).abs() < 2e-6, "G({a}, {b}) = {value}");
            assert!((a.max(b) + 0.01 - expected).abs() > 2e-6, "the plain union, nudged, must be seen");
        }
        let (_, by_a, by_b) = ordered(0.3, 0.3);
        assert!((by_a - 0.455877).abs() < 2e-6 && (by_b - 0.455877).abs() < 2e-6);
        let (_, by_a, by_b) = ordered(0.2, 0.1);
        assert!((by_a - 0.88494).abs() < 1e-5 && (by_b - 0.14011).abs() < 1e-5);
    }

    /// Values on a grid, near the corner, and far below it.
    fn pairs() -> impl Iterator<Item = (f32, f32)> {
        let grid = (0..=200).flat_map(|i| (0..=200).map(move |j| (i as f32 / 200.0, j as f32 / 200.0)));
        let scales = (1..60).map(|e| 0.5 * 0.7f32.powi(e));
        let near = scales.flat_map(|s| {
            (0..24).flat_map(move |k| {
                let (sine, cosine) = (k as f32 * 0.261).sin_cos();
                [(0.5 + s * cosine, 0.5 + s * sine), (s * cosine.abs(), s * sine.abs())]
            })
        });
        grid.chain(near)
    }

    #[test]
    fn four_steps_reach_the_last_bits_everywhere() {
        let (mut worst, mut blended, mut largest) = (0.0f64, 0, 0.0f64);
        for (a, b) in pairs() {
            let found = f64::from(ordered(a, b).0);
            worst = worst.max((found - exact(a, b)).abs());
            largest = largest.max(found - f64::from(a.max(b)));
            blended += usize::from(found > f64::from(a.max(b)) + 1e-6);
        }
        assert!(worst < 2.5e-7, "{worst}");
        // Background 3.3: the most that the clean union adds to the plain one.
        assert!((largest - 0.0852).abs() < 5e-4 && blended > 5000, "{largest} {blended}");
    }

    #[test]
    fn it_stays_in_range_keeps_what_is_alone_and_has_no_order() {
        for (a, b) in pairs() {
            let (value, by_a, by_b) = ordered(a, b);
            assert!((0.0..=1.0).contains(&value) && value >= a.max(b), "G({a}, {b}) = {value}");
            let slopes = [by_a, by_b];
            assert!(slopes.iter().all(|s| (0.0..=1.0 + 1e-5).contains(s)), "at ({a}, {b}): {slopes:?}");
            assert_eq!(ordered(a, 0.0).0, a);
            let (turned, by_b_turned, by_a_turned) = ordered(b, a);
            assert_eq!(turned, value);
            assert!(a == b || (by_a, by_b) == (by_a_turned, by_b_turned));
        }
        assert_ne!(ordered(0.3, 0.2).0, 0.3, "what is not alone is changed");
    }

    #[test]
    fn its_surface_is_that_of_the_plain_union() {
        for i in 0..1000 {
            let small = i as f32 / 2000.0;
            assert_eq!(ordered(0.5, small).0, 0.5);
            assert!(ordered(0.499, small).0 < 0.5 && ordered(0.501, small).0 > 0.5);
        }
    }

    #[test]
    fn derivatives_are_those_of_the_value() {
        // At the ends of a circle the slope bends by one over its radius, .05 and more here: central differences over 2e-3
        // that reach across an end see up to half of 1e-3 / .05 of it.
        let smooth = |a: f32, b: f32| (a - 0.5).hypot(b - 0.5) > 0.1 && ordered(a, b).0 < 0.99;
        let worst = worst_slope(&ordered, &smooth);
        assert!(worst < 1e-2, "{worst}");
        let swapped = |a: f32, b: f32| {
            let (value, by_a, by_b) = ordered(a, b);
            (value, by_b, by_a)
        };
        assert!(worst_slope(&swapped, &smooth) > 0.5, "derivatives the wrong way round must be seen");
    }

    #[test]
    fn the_gradient_turns_smoothly_over_the_ridge_of_the_plain_union() {
        // Two fields that fall off in different directions, along a line that crosses their ridge at .4.
        let turn = |union: &dyn Fn(Sample, Sample) -> Sample| {
            let at = |i: i32| {
                let x = i as f32 * 1e-3;
                let field = |value, x, y| Sample { value, gradient: Vec3::new(x, y, 0.0) };
                union(field(0.4 + x, 1.0, 0.3), field(0.4 - x, -1.0, 0.3)).gradient
            };
            (-200..200).map(|i| at(i).angle_between(at(i + 1)).to_degrees()).fold(0.0, f32::max)
        };
        let (clean, plain) = (turn(&clean_union), turn(&super::super::larger));
        assert!(clean < 5.0 && plain > 140.0, "{clean} {plain}");
    }

    #[test]
    fn the_order_of_many_matters_little() {
        let sample = |value| Sample { value, gradient: Vec3::X };
        let values = [0.31, 0.38, 0.28, 0.36];
        let forth = clean_union_all(values.map(sample));
        let back = clean_union_all(values.iter().rev().map(|v| sample(*v)));
        assert!((forth.value - back.value).abs() < 1e-2 && forth.value > 0.39, "{forth:?} {back:?}");
        assert_eq!(clean_union_all([0.0, 0.3, 0.0].map(sample)), sample(0.3));
        assert_eq!(clean_union_all([]), Sample::default());
    }
}
