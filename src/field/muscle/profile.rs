//! How thick a muscle is along its axis and round it (paper A, section 5.2, equations 4 and 5, appendix B).

use crate::math::power;
use glam::Vec4;

/// The largest eccentricity: at 1 the ellipse of equation 5 is infinitely long.
pub const MAX_ECCENTRICITY: f32 = 0.99;

/// Largest profile exponent; larger ones are sharper than any muscle (paper A, section 5.2).
pub const MAX_EXPONENT: u32 = 9;

/// Most shapes that make a profile at one moment. Two keyed rest shapes and the active one need three.
pub const MAX_TERMS: usize = 4;

/// Profile exponents `(alpha, beta)`, each 1..=[`MAX_EXPONENT`].
pub type Exponents = (u32, u32);

/// Euler's beta function of whole arguments of 1 or more: `(x - 1)! (y - 1)! / (x + y - 1)!`.
fn beta_function(x: u32, y: u32) -> f64 {
    (1..y).fold(1.0 / f64::from(x), |product, i| product * f64::from(i) / f64::from(x + i))
}

/// Inner product on 0..=1 of two profiles of unit norm: the constant K of appendix B, whose printed integral has a wrong
/// exponent (background 7.1); this is its beta-function form. 1 for a profile with itself.
pub fn overlap(a: Exponents, b: Exponents) -> f64 {
    let square = |(alpha, beta): Exponents| beta_function(2 * alpha - 1, 2 * beta - 1);
    beta_function(a.0 + b.0 - 1, a.1 + b.1 - 1) / (square(a) * square(b)).sqrt()
}

/// A blend of profiles whose square has the integral 1, so that it keeps the muscle's volume (background 7.5).
///
/// A shift `d` moves the belly along the axis, towards the insertion where it is over 0: with
/// `sigma(s) = s - 4 d s (1 - s)` the profile is `Phi(sigma(s)) sqrt(sigma'(s))`, whose square has the same integral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// Factor of each term `s^(alpha-1) (1-s)^(beta-1)`; 0 beyond the terms there are.
    pub factors: Vec4,
    /// One byte per term, from the lowest: `alpha - 1` in its low and `beta - 1` in its high half.
    pub exponents: u32,
    /// Number of terms.
    pub terms: u32,
    /// Shift d, between -1/4 and 1/4; 0 leaves the profile as it is.
    pub shift: f32,
}

impl Profile {
    /// Blends shapes by their linear weights and restores the norm with the Gram matrix of [`overlap`]s: paper A's
    /// `F(a)` for two shapes, and its generalisation for more. Shapes beyond the [`MAX_TERMS`] heaviest are left out;
    /// weights are clamped to 0 or more, and where all are 0 the first shape stands alone.
    ///
    /// # Panics
    /// Without shapes, or with an exponent outside 1..=[`MAX_EXPONENT`].
    pub fn blend(shapes: &[(Exponents, f32)]) -> Profile {
        let mut merged: Vec<(Exponents, f64)> = Vec::with_capacity(shapes.len());
        for &(exponents, weight) in shapes {
            assert!([exponents.0, exponents.1].iter().all(|e| (1..=MAX_EXPONENT).contains(e)), "{exponents:?}");
            let weight = if weight.is_nan() { 0.0 } else { f64::from(weight.max(0.0)) };
            match merged.iter_mut().find(|(known, _)| *known == exponents) {
                Some((_, sum)) => *sum += weight,
                None => merged.push((exponents, weight)),
            }
        }
        if merged.iter().all(|(_, weight)| *weight == 0.0) {
            merged[0].1 = 1.0;
        }
        merged.retain(|(_, weight)| *weight > 0.0);
        merged.sort_by(|a, b| b.1.total_cmp(&a.1));
        merged.truncate(MAX_TERMS);
        let norm = merged.iter().flat_map(|a| merged.iter().map(move |b| a.1 * b.1 * overlap(a.0, b.0))).sum::<f64>();
        let mut profile = Profile { factors: Vec4::ZERO, exponents: 0, terms: merged.len() as u32, shift: 0.0 };
        for (k, ((alpha, beta), weight)) in merged.into_iter().enumerate() {
            let own = beta_function(2 * alpha - 1, 2 * beta - 1);
            profile.factors[k] = (weight / (norm * own).sqrt()) as f32;
            profile.exponents |= ((alpha - 1) | (beta - 1) << 4) << (8 * k);
        }
        profile
    }

    /// The profile of one shape.
    ///
    /// # Panics
    /// As [`Profile::blend`].
    pub fn of(alpha: u32, beta: u32) -> Profile {
        Profile::blend(&[((alpha, beta), 1.0)])
    }

    /// Phi and its derivative at a share `s` of the length, 0..=1 (equation 4).
    #[inline]
    pub fn at(&self, s: f32) -> (f32, f32) {
        let (mut place, mut slope, mut root, mut lean) = (s, 1.0, 1.0, 0.0);
        if self.shift != 0.0 {
            let (t, bend) = (1.0 - s, 4.0 * self.shift);
            place = (s - bend * s * t).clamp(0.0, 1.0);
            slope = 1.0 - bend * (t - s);
            root = slope.sqrt();
            // sigma'' is 2 bend.
            lean = bend / root;
        }
        let (value, by_place) = self.unshifted(place);
        (value * root, by_place * slope * root + value * lean)
    }

    #[inline]
    fn unshifted(&self, s: f32) -> (f32, f32) {
        let t = 1.0 - s;
        let (mut value, mut slope) = (0.0, 0.0);
        for k in 0..self.terms as usize {
            let factor = self.factors[k];
            let byte = self.exponents >> (8 * k as u32);
            let (p, q) = (byte & 15, (byte >> 4) & 15);
            let (s_below, t_below) = (power(s, p.max(1) - 1), power(t, q.max(1) - 1));
            let s_power = if p == 0 { 1.0 } else { s_below * s };
            let t_power = if q == 0 { 1.0 } else { t_below * t };
            value += factor * s_power * t_power;
            slope += factor * (p as f32 * s_below * t_power - q as f32 * s_power * t_below);
        }
        (value, slope)
    }

    /// A bound on its largest value that costs little: the sum of its terms' own maxima, and the stretch of its shift.
    pub fn bound(&self) -> f32 {
        let unshifted: f32 = (0..self.terms as usize)
            .map(|k| {
                let byte = self.exponents >> (8 * k as u32);
                let (p, q) = (byte & 15, (byte >> 4) & 15);
                let s = p as f32 / (p + q).max(1) as f32;
                self.factors[k] * power(s, p) * power(1.0 - s, q)
            })
            .sum();
        unshifted * stretch(self.shift)
    }

    /// Its largest value. One shape has it at `s = (alpha - 1) / (alpha + beta - 2)`; a blend's is searched for.
    pub fn max(&self) -> f32 {
        const STEPS: u32 = 64;
        let place = |i: u32| i as f32 / STEPS as f32;
        let highest = (0..=STEPS).max_by(|&a, &b| self.at(place(a)).0.total_cmp(&self.at(place(b)).0)).unwrap_or(0);
        let (mut low, mut high) = (place(highest.saturating_sub(1)), place((highest + 1).min(STEPS)));
        for _ in 0..32 {
            let middle = 0.5 * (low + high);
            *(if self.at(middle).1 > 0.0 { &mut low } else { &mut high }) = middle;
        }
        self.at(low).0.max(self.at(high).0)
    }
}

/// How much larger a shift can make a profile's values at most.
pub(crate) fn stretch(shift: f32) -> f32 {
    (1.0 + 4.0 * shift.abs()).sqrt()
}

/// Squares of the short and long semi-axes u and v for an eccentricity, with `u v = 1` (equation 5). Eccentricities over
/// [`MAX_ECCENTRICITY`] count as that.
pub fn ellipse_squared(eccentricity: f32) -> (f32, f32) {
    let e = eccentricity.clamp(0.0, MAX_ECCENTRICITY);
    let short_squared = (1.0 - e * e).sqrt();
    (short_squared, 1.0 / short_squared)
}

/// The eccentricity for a slider from 0, round, to 1, as flat as can be, on which equal steps look equal: they
/// multiply the section's ratio of axes by the same factor (paper A, section 8.3.1 asks for such a compensation).
pub fn eccentricity_of_flatness(flatness: f32) -> f32 {
    let flattest = 1.0 - MAX_ECCENTRICITY * MAX_ECCENTRICITY;
    // The ratio of axes squared is 1 - e^2.
    (1.0 - flattest.powf(flatness.clamp(0.0, 1.0))).sqrt()
}

/// The slider's place for an eccentricity: the inverse of [`eccentricity_of_flatness`].
pub fn flatness_of_eccentricity(eccentricity: f32) -> f32 {
    let flattest = 1.0 - MAX_ECCENTRICITY * MAX_ECCENTRICITY;
    let e = eccentricity.clamp(0.0, MAX_ECCENTRICITY);
    (1.0 - e * e).ln() / flattest.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs() -> impl Iterator<Item = Exponents> {
        (1..=MAX_EXPONENT).flat_map(|alpha| (1..=MAX_EXPONENT).map(move |beta| (alpha, beta)))
    }

    /// Integral over 0..=1 by Gauss-Legendre of five points on 64 pieces, exact far beyond the profiles' degrees.
    fn integral(f: impl Fn(f64) -> f64) -> f64 {
        const NODES: [(f64, f64); 5] = [
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
            (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
            (0.906_179_845_938_664, 0.236_926_885_056_189_1),
            (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
        ];
        let h = 1.0 / 64.0;
        let piece = |i: usize| NODES.map(|(x, w)| w * f((i as f64 + 0.5 + 0.5 * x) * h)).iter().sum::<f64>();
        (0..64).map(piece).sum::<f64>() * h / 2.0
    }

    fn raw((alpha, beta): Exponents, s: f64) -> f64 {
        s.powi(alpha as i32 - 1) * (1.0 - s).powi(beta as i32 - 1)
    }

    #[test]
    fn overlap_is_the_papers_k_and_the_integral_for_every_pair() {
        for (a, b, k) in [
            ((3, 3), (4, 7), 0.827_325),
            ((3, 3), (4, 8), 0.754_078),
            ((2, 3), (4, 7), 0.945_712),
            ((1, 3), (4, 7), 0.670_706),
            ((3, 9), (4, 7), 0.814_581),
        ] {
            assert!((overlap(a, b) - k).abs() < 5e-7, "{a:?} {b:?}: {}", overlap(a, b));
            assert!((overlap(a, b) - overlap(a, (b.0, b.1 - 1))).abs() > 1e-3, "another shape must be seen");
        }
        for a in pairs() {
            let own = integral(|s| raw(a, s).powi(2));
            for b in pairs() {
                let numeric = integral(|s| raw(a, s) * raw(b, s)) / (own * integral(|s| raw(b, s).powi(2))).sqrt();
                assert!((overlap(a, b) - numeric).abs() < 1e-12, "{a:?} {b:?}");
            }
        }
    }

    /// The integral of a profile's square, of its f32 value.
    fn square_integral(profile: &Profile) -> f64 {
        integral(|s| f64::from(profile.at(s as f32).0).powi(2))
    }

    #[test]
    fn every_shape_and_every_blend_has_a_unit_square_integral() {
        for a in pairs() {
            for b in pairs() {
                for share in [0.0, 0.5, 1.0] {
                    let profile = Profile::blend(&[(a, 1.0 - share), (b, share)]);
                    let square = square_integral(&profile);
                    assert!((square - 1.0).abs() < 2e-6, "{a:?} {b:?} at {share}: {square}");
                }
            }
        }
        let four = [((3, 3), 0.2), ((2, 5), 0.3), ((4, 7), 0.4), ((9, 2), 0.1)];
        assert!((square_integral(&Profile::blend(&four)) - 1.0).abs() < 2e-6);
        let plain = Profile { factors: Profile::of(3, 3).factors * 0.5, ..Profile::of(3, 3) };
        assert!((square_integral(&plain) - 1.0).abs() > 0.1, "a blend without its norm must be seen");
    }

    #[test]
    fn half_way_between_the_default_shapes_f_is_the_papers() {
        // F(1/2) = 1/4 + 1/4 + K/2 (background 7.1).
        let profile = Profile::blend(&[((3, 3), 0.5), ((4, 7), 0.5)]);
        let norm = (0.5 / f64::from(profile.factors[0])).powi(2) / beta_function(5, 5);
        assert!((norm - 0.913_663).abs() < 1e-5, "{norm}");
    }

    #[test]
    fn maxima_are_the_known_ones() {
        for ((alpha, beta), max) in [
            ((3, 3), 1.56874),
            ((4, 7), 1.93108),
            ((4, 8), 2.00610),
            ((2, 3), 1.51807),
            ((3, 9), 2.14060),
            ((9, 9), 2.14903),
            ((2, 2), 1.36931),
            ((1, 3), 2.23607),
        ] {
            let found = Profile::of(alpha, beta).max();
            assert!((found - max).abs() < 1e-5, "({alpha}, {beta}): {found}");
            assert!(
                (Profile::of(alpha, if beta < 9 { beta + 1 } else { 8 }).max() - max).abs() > 1e-3,
                "another shape's maximum must be seen"
            );
        }
        for (alpha, beta) in pairs().filter(|&(a, b)| a + b > 2) {
            let profile = Profile::of(alpha, beta);
            let at = (alpha - 1) as f32 / (alpha + beta - 2) as f32;
            assert!((profile.max() / profile.at(at).0 - 1.0).abs() < 1e-6, "({alpha}, {beta})");
        }
    }

    #[test]
    fn the_bound_is_never_below_the_maximum_and_one_shapes_own() {
        for (a, b) in pairs().zip(pairs().skip(17)) {
            for share in [0.0, 0.3, 0.5, 1.0] {
                let profile = Profile::blend(&[(a, 1.0 - share), (b, share)]);
                let (bound, max) = (profile.bound(), profile.max());
                assert!(bound >= max * (1.0 - 1e-6), "{a:?} {b:?} at {share}: {bound} {max}");
                assert!(profile.terms > 1 || (bound / max - 1.0).abs() < 1e-6, "{a:?} {b:?}: {bound} {max}");
            }
        }
    }

    #[test]
    fn slope_is_the_values_own() {
        for shapes in
            [vec![((3, 3), 1.0)], vec![((1, 4), 0.3), ((4, 7), 0.7)], vec![((9, 1), 1.0)], vec![((1, 1), 1.0)]]
        {
            let profile = Profile::blend(&shapes);
            for i in 1..100 {
                let s = i as f32 / 100.0;
                let h = 1e-3;
                let measured = (profile.at(s + h).0 - profile.at(s - h).0) / (2.0 * h);
                let slope = profile.at(s).1;
                // The differences' own error is the third derivative's, up to some hundreds times h squared / 6.
                assert!((measured - slope).abs() < 2e-3 + 1e-3 * slope.abs(), "{shapes:?} at {s}: {measured} {slope}");
            }
        }
    }

    const SHIFTS: [f32; 7] = [-0.24, -0.15, -0.03, 0.0, 0.05, 0.12, 0.24];

    #[test]
    fn shifted_profiles_keep_their_square_integral() {
        for (a, b) in pairs().zip(pairs().skip(17)) {
            for shift in SHIFTS {
                let profile = Profile { shift, ..Profile::blend(&[(a, 0.7), (b, 0.3)]) };
                let square = square_integral(&profile);
                assert!((square - 1.0).abs() < 4e-6, "{a:?} {b:?} shifted by {shift}: {square}");
            }
        }
        // In f64 the formula itself: what is over 1e-6 above is f32's.
        for (a, d) in pairs().flat_map(|a| SHIFTS.map(|d| (a, f64::from(d)))) {
            let own = integral(|s| raw(a, s).powi(2));
            let square = integral(|s| raw(a, s - 4.0 * d * s * (1.0 - s)).powi(2) * (1.0 - 4.0 * d * (1.0 - 2.0 * s)));
            assert!((square / own - 1.0).abs() < 1e-6, "{a:?} {d}");
            let without = integral(|s| raw(a, s - 4.0 * d * s * (1.0 - s)).powi(2));
            assert!(d == 0.0 || a != (2, 5) || (without / own - 1.0).abs() > 1e-2, "without the root: {a:?} {d}");
        }
    }

    #[test]
    fn shifted_slopes_are_the_values_own_and_bounds_hold() {
        for shapes in [vec![((3, 3), 1.0)], vec![((2, 4), 0.3), ((4, 7), 0.7)], vec![((1, 1), 1.0)]] {
            let plain = Profile::blend(&shapes);
            for shift in SHIFTS {
                let profile = Profile { shift, ..plain };
                for i in 1..100 {
                    let (s, h) = (i as f32 / 100.0, 1e-3);
                    let measured = (profile.at(s + h).0 - profile.at(s - h).0) / (2.0 * h);
                    let slope = profile.at(s).1;
                    let error = (measured - slope).abs();
                    assert!(error < 4e-3 + 2e-3 * slope.abs(), "{shapes:?} at {s} by {shift}: {measured} {slope}");
                }
                assert!(profile.max() <= profile.bound() * (1.0 + 1e-6), "{shapes:?} by {shift}");
                if shift == 0.0 {
                    assert!((0..=64).all(|i| profile.at(i as f32 / 64.0) == plain.unshifted(i as f32 / 64.0)));
                }
            }
            assert!(
                shapes.len() > 1 || shapes[0].0 == (1, 1) || {
                    let unbounded = Profile { shift: 0.24, ..plain }.max();
                    unbounded > plain.bound() * 1.02
                }
            );
        }
        // The belly moves towards the insertion, by about the shift.
        let peak = |shift: f32| {
            let profile = Profile { shift, ..Profile::of(3, 3) };
            (0..1000)
                .map(|i| i as f32 / 1000.0)
                .max_by(|a, b| profile.at(*a).0.total_cmp(&profile.at(*b).0))
                .expect("one")
        };
        assert!(peak(0.1) > 0.58 && peak(-0.1) < 0.42 && peak(0.0) == 0.5, "{} {}", peak(0.1), peak(-0.1));
    }

    #[test]
    fn blends_merge_equal_shapes_and_survive_odd_weights() {
        assert_eq!(Profile::blend(&[((3, 3), 0.4), ((3, 3), 0.6)]), Profile::of(3, 3));
        assert_eq!(Profile::blend(&[((3, 3), 0.0), ((4, 7), 0.0)]), Profile::of(3, 3));
        assert_eq!(Profile::blend(&[((3, 3), 1.0), ((4, 7), f32::NAN)]), Profile::of(3, 3));
        assert_eq!(Profile::blend(&[((3, 3), -1.0), ((4, 7), 0.5)]), Profile::of(4, 7));
        let five: Vec<_> = (2..7).map(|a| ((a, 3), a as f32)).collect();
        assert_eq!(Profile::blend(&five).terms, 4);
    }

    #[test]
    fn ellipse_keeps_its_area() {
        for e in [0.0, 0.5, 0.8, 0.95, MAX_ECCENTRICITY, 2.0] {
            let (short, long) = ellipse_squared(e);
            let n = 20_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let c = (f64::from(i) / f64::from(n) * std::f64::consts::TAU).cos();
                    1.0 / (f64::from(short) * c * c + f64::from(long) * (1.0 - c * c))
                })
                .sum::<f64>()
                * std::f64::consts::TAU
                / f64::from(n);
            assert!((sum - std::f64::consts::TAU).abs() < 1e-4, "e = {e}: {sum}");
        }
    }

    #[test]
    fn flatness_is_even_in_the_ratio_of_axes() {
        let ratio = |flatness: f32| {
            let (short, long) = ellipse_squared(eccentricity_of_flatness(flatness));
            (long / short).sqrt()
        };
        let step = ratio(0.1) / ratio(0.0);
        for i in 1..10 {
            let factor = ratio((i + 1) as f32 / 10.0) / ratio(i as f32 / 10.0);
            assert!((factor / step - 1.0).abs() < 1e-3, "step {i}: {factor} {step}");
            let e = eccentricity_of_flatness(i as f32 / 10.0);
            assert!((flatness_of_eccentricity(e) - i as f32 / 10.0).abs() < 1e-4);
        }
        assert_eq!(eccentricity_of_flatness(0.0), 0.0);
        assert!((eccentricity_of_flatness(1.0) - MAX_ECCENTRICITY).abs() < 1e-5);
    }
}
