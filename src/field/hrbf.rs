//! Hermite radial basis functions with the kernel x³: a smooth raw field through points with normals.
//!
//! The interpolant takes the value 0 and the given normal as its gradient at every sample (background 1.4):
//! `d(x) = sum_j alpha_j l³ + 3 l (beta_j . e)` with `e = x - c_j`, `l = |e|`. It is negative inside and it is *not* a
//! distance: on a cylinder of radius R it behaves like `(rho² - R²) / (2 R)`.
//! Fitting is dense LU with partial pivoting in f64; the system is indefinite, so Cholesky does not apply.

use crate::error::HrbfError;
use glam::DVec3;
use nalgebra::{DMatrix, DVector};

/// Fewest samples that are fitted.
pub const LEAST_SAMPLES: usize = 4;

/// Samples closer than this share of the samples' extent count as one.
const DUPLICATE: f64 = 1e-6;
/// Below this length, in units of the samples' extent, a term and its gradient are at their limit 0.
const AT_CENTRE: f64 = 1e-12;
/// A pivot ratio below this leaves fewer than two digits of an f64.
const LEAST_PIVOT_RATIO: f64 = 1e-14;
/// Largest error at the samples, in units of their extent, that counts as solved.
const MOST_RESIDUAL: f64 = 1e-6;

/// A point of the surface and the outward direction there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HermiteSample {
    /// Where the field is 0, metres.
    pub position: DVec3,
    /// The gradient there: outward, of length one for a field that starts out like a distance.
    pub normal: DVec3,
}

/// A fitted interpolant in f64.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hrbf {
    /// Centres, metres: the distinct samples.
    pub centres: Vec<DVec3>,
    /// Value coefficient of each centre, per square metre.
    pub alpha: Vec<f64>,
    /// Gradient coefficient of each centre, per metre.
    pub beta: Vec<DVec3>,
    /// Smallest over largest pivot of the factorisation: how far the system was from singular.
    pub pivot_ratio: f64,
}

impl Hrbf {
    /// Interpolates the samples; of samples at one place the first is kept.
    ///
    /// # Errors
    /// Refuses non-finite samples, fewer than [`LEAST_SAMPLES`] distinct ones, and systems without a reliable solution.
    pub fn fit(samples: &[HermiteSample]) -> Result<Hrbf, HrbfError> {
        let bad = |s: &HermiteSample| {
            !s.position.is_finite() || !s.normal.is_finite() || s.normal.length_squared() < f64::MIN_POSITIVE
        };
        if let Some(sample) = samples.iter().position(bad) {
            return Err(HrbfError::BadSample { sample });
        }
        let (lo, hi) = samples
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), s| (lo.min(s.position), hi.max(s.position)));
        let origin = (lo + hi) * 0.5;
        let extent = if samples.is_empty() { 0.0 } else { (hi - lo).length() * 0.5 };
        let mut distinct: Vec<HermiteSample> = Vec::with_capacity(samples.len());
        for s in samples {
            if distinct.iter().all(|k| k.position.distance(s.position) > DUPLICATE * extent) {
                distinct.push(*s);
            }
        }
        if distinct.len() < LEAST_SAMPLES {
            return Err(HrbfError::TooFewSamples { found: distinct.len(), needed: LEAST_SAMPLES });
        }
        // Solved in units of the extent, where value and gradient rows are of one size.
        let unit: Vec<HermiteSample> = distinct
            .iter()
            .map(|s| HermiteSample { position: (s.position - origin) / extent, normal: s.normal })
            .collect();
        let mut hrbf = solve(&unit)?;
        hrbf.centres = distinct.iter().map(|s| s.position).collect();
        hrbf.alpha.iter_mut().for_each(|a| *a /= extent * extent);
        hrbf.beta.iter_mut().for_each(|b| *b /= extent);
        Ok(hrbf)
    }

    /// Value (metres) and gradient of the raw field at `p`, summed over the centres in order.
    pub fn sample(&self, p: DVec3) -> (f64, DVec3) {
        let mut value = 0.0;
        let mut gradient = DVec3::ZERO;
        for ((&c, &alpha), &beta) in self.centres.iter().zip(&self.alpha).zip(&self.beta) {
            let e = p - c;
            let l = e.length();
            if l < AT_CENTRE {
                continue;
            }
            let along = beta.dot(e);
            value += l * (alpha * l * l + 3.0 * along);
            gradient += (alpha * l + along / l) * e + l * beta;
        }
        (value, 3.0 * gradient)
    }
}

/// Solves the 4n x 4n system of samples whose extent is about one.
fn solve(samples: &[HermiteSample]) -> Result<Hrbf, HrbfError> {
    let n = samples.len();
    let system = DMatrix::<f64>::from_fn(4 * n, 4 * n, |row, column| {
        let e = samples[row / 4].position - samples[column / 4].position;
        let l = e.length();
        if l < AT_CENTRE {
            return 0.0;
        }
        match (row % 4, column % 4) {
            (0, 0) => l * l * l,
            (0, k) => 3.0 * l * e[k - 1],
            (k, 0) => 3.0 * l * e[k - 1],
            (i, j) => 3.0 * (e[i - 1] * e[j - 1] / l + if i == j { l } else { 0.0 }),
        }
    });
    let right = DVector::<f64>::from_fn(4 * n, |row, _| match row % 4 {
        0 => 0.0,
        k => samples[row / 4].normal[k - 1],
    });
    let lu = system.lu();
    let pivots = lu.u().diagonal().abs();
    let (least, most) = (pivots.min(), pivots.max());
    let pivot_ratio = if most > 0.0 { least / most } else { 0.0 };
    let x = lu.solve(&right).ok_or(HrbfError::Singular { pivot_ratio, residual: f64::INFINITY })?;
    let hrbf = Hrbf {
        centres: samples.iter().map(|s| s.position).collect(),
        alpha: (0..n).map(|i| x[4 * i]).collect(),
        beta: (0..n).map(|i| DVec3::new(x[4 * i + 1], x[4 * i + 2], x[4 * i + 3])).collect(),
        pivot_ratio,
    };
    let residual = samples.iter().fold(0.0_f64, |worst, s| {
        let (value, gradient) = hrbf.sample(s.position);
        let error = value.abs() + (gradient - s.normal).length();
        // `f64::max` would drop a NaN.
        if error.is_nan() { f64::INFINITY } else { worst.max(error) }
    });
    if !(pivot_ratio >= LEAST_PIVOT_RATIO && residual <= MOST_RESIDUAL) {
        return Err(HrbfError::Singular { pivot_ratio, residual });
    }
    Ok(hrbf)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f64 = 0.3;

    /// Golden-angle samples of the side of the cylinder R = .3, L = 1, without its outermost tenths, and a cap a radius
    /// beyond either end.
    fn cylinder(count: usize) -> Vec<HermiteSample> {
        let mut samples: Vec<HermiteSample> = (0..count)
            .map(|k| {
                let angle = k as f64 * 2.399_963_229_728_653;
                let normal = DVec3::new(angle.cos(), angle.sin(), 0.0);
                let z = ((k as f64 + 0.5) / count as f64 - 0.5) * 0.8;
                HermiteSample { position: normal * RADIUS + DVec3::Z * z, normal }
            })
            .collect();
        for z in [-1.0, 1.0] {
            samples.push(HermiteSample { position: DVec3::Z * z * (0.5 + RADIUS), normal: DVec3::Z * z });
        }
        samples
    }

    /// Largest deviation from the table of background 1.4: the axis, and rho = .45, .6, .9 at mid-length.
    fn deviation_from_table(hrbf: &Hrbf) -> f64 {
        let table = [(0.0, -0.15), (0.45, 0.176), (0.6, 0.403), (0.9, 1.07)];
        table
            .iter()
            .fold(0.0_f64, |worst, &(rho, d)| worst.max(((hrbf.sample(DVec3::X * rho).0 - d) / (1.0 + rho)).abs()))
    }

    #[test]
    fn cylinder_has_the_figures_of_the_table() {
        // The table's sampling is random, and where the side's samples end moves its figures by up to a hundredth.
        let hrbf = Hrbf::fit(&cylinder(50)).unwrap();
        assert!(deviation_from_table(&hrbf) < 0.01, "{}", deviation_from_table(&hrbf));
        let wider: Vec<_> = cylinder(50)
            .into_iter()
            .map(|s| HermiteSample { position: s.position * DVec3::new(1.1, 1.1, 1.0), ..s })
            .collect();
        assert!(deviation_from_table(&Hrbf::fit(&wider).unwrap()) > 0.01);
    }

    #[test]
    fn surface_error_and_gradient_between_the_samples_are_those_of_the_table() {
        let hrbf = Hrbf::fit(&cylinder(100)).unwrap();
        for k in 0..200 {
            let (angle, z) = (k as f64 * 0.731, (k as f64 / 199.0 - 0.5) * 0.7);
            let (value, gradient) = hrbf.sample(DVec3::new(angle.cos() * RADIUS, angle.sin() * RADIUS, z));
            assert!(value.abs() < 1e-3, "{value}");
            assert!((gradient.length() - 1.0).abs() < 0.02, "{gradient}");
        }
    }

    #[test]
    fn interpolates_value_and_normal_at_the_samples() {
        let samples = cylinder(50);
        let hrbf = Hrbf::fit(&samples).unwrap();
        for s in &samples {
            let (value, gradient) = hrbf.sample(s.position);
            assert!(value.abs() < 1e-10 && (gradient - s.normal).length() < 1e-9, "{value} {gradient}");
        }
    }

    /// Largest difference between the gradient and central differences of the value, with coefficients disturbed by
    /// `error`.
    fn gradient_error(error: f64) -> f64 {
        let hrbf = Hrbf::fit(&cylinder(50)).unwrap();
        let mut other = hrbf.clone();
        other.beta[7].x += error;
        let step = 1e-5;
        (0..100).fold(0.0_f64, |worst, k| {
            let t = k as f64;
            let p = DVec3::new((t * 1.3).sin(), (t * 2.1).cos(), (t * 0.7).sin()) * 0.6;
            let along = |axis: DVec3| (hrbf.sample(p + axis * step).0 - hrbf.sample(p - axis * step).0) / (2.0 * step);
            let numeric = DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z));
            worst.max((other.sample(p).1 - numeric).length())
        })
    }

    #[test]
    fn gradient_is_the_derivative_of_the_value() {
        // Central differences of step 1e-5: truncation 1e-10, rounding 1e-11 over the step.
        assert!(gradient_error(0.0) < 1e-6, "{}", gradient_error(0.0));
        assert!(gradient_error(1e-4) > 1e-6);
    }

    #[test]
    fn scale_changes_nothing_but_the_unit() {
        let scale = 1e-3;
        let small: Vec<_> =
            cylinder(50).iter().map(|s| HermiteSample { position: s.position * scale, normal: s.normal }).collect();
        let (large, small) = (Hrbf::fit(&cylinder(50)).unwrap(), Hrbf::fit(&small).unwrap());
        let p = DVec3::new(0.1, 0.4, -0.2);
        let (value, gradient) = large.sample(p);
        let (value_small, gradient_small) = small.sample(p * scale);
        assert!((value * scale - value_small).abs() < 1e-9 * scale && (gradient - gradient_small).length() < 1e-9);
    }

    #[test]
    fn duplicates_are_dropped_and_bad_samples_refused() {
        let mut samples = cylinder(50);
        samples.push(samples[3]);
        assert_eq!(Hrbf::fit(&samples).unwrap(), Hrbf::fit(&cylinder(50)).unwrap());
        samples[9].normal.y = f64::NAN;
        assert_eq!(Hrbf::fit(&samples), Err(HrbfError::BadSample { sample: 9 }));
        samples[9].normal = DVec3::ZERO;
        assert_eq!(Hrbf::fit(&samples), Err(HrbfError::BadSample { sample: 9 }));
        assert_eq!(Hrbf::fit(&[]), Err(HrbfError::TooFewSamples { found: 0, needed: LEAST_SAMPLES }));
        let same = vec![samples[0]; 12];
        assert_eq!(Hrbf::fit(&same), Err(HrbfError::TooFewSamples { found: 1, needed: LEAST_SAMPLES }));
    }

    #[test]
    fn a_system_without_a_solution_is_an_error() {
        let mut samples = cylinder(20);
        assert!(solve(&samples).is_ok());
        samples.push(HermiteSample { normal: DVec3::Z, ..samples[4] });
        assert!(matches!(solve(&samples), Err(HrbfError::Singular { .. })));
    }
}
