//! Paper A's profile for a chain of bumps (prototypes 2): `R_tip(z) = c0 + c1 z + w Phi(s; alpha, beta)`, by trying the
//! exponents and solving for the rest.

use crate::field::muscle::profile::Profile;
use nalgebra::{Matrix3, Vector3};

/// Exponents that are tried: tips tell sharper ones from a wider belly on a cone no more.
const EXPONENTS: std::ops::RangeInclusive<u32> = 2..=6;

/// What of the limb's outline is the muscle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileFit {
    /// Profile exponent at the origin.
    pub alpha: u32,
    /// Profile exponent at the insertion.
    pub beta: u32,
    /// How far the profile, whose square has the mean 1, carries the tips out, metres.
    pub width: f64,
    /// Where the muscle is thickest, 0..=1.
    pub peak: f64,
    /// Root mean square distance of the tips from the profile, metres.
    pub rms: f64,
}

/// Fits the profile to tips at shares `s` of the muscle's length, `out` metres from the bone. `None` where three unknowns
/// are more than the tips tell, or no profile stands out.
pub fn profile(s: &[f64], out: &[f64]) -> Option<ProfileFit> {
    let mut best: Option<ProfileFit> = None;
    for alpha in EXPONENTS {
        for beta in EXPONENTS {
            let phi: Vec<f64> = s.iter().map(|&s| f64::from(Profile::of(alpha, beta).at(s as f32).0)).collect();
            let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
            for ((&s, &phi), &out) in s.iter().zip(&phi).zip(out) {
                let row = Vector3::new(1.0, s, phi);
                normal += row * row.transpose();
                right += row * out;
            }
            let Some(found) = normal.lu().solve(&right) else { continue };
            let off = |k: usize| found[0] + found[1] * s[k] + found[2] * phi[k] - out[k];
            let rms = ((0..s.len()).map(|k| off(k).powi(2)).sum::<f64>() / s.len() as f64).sqrt();
            if found[2] > 0.0 && best.is_none_or(|b| rms < b.rms) {
                let peak = f64::from(alpha - 1) / f64::from(alpha + beta - 2);
                best = Some(ProfileFit { alpha, beta, width: found[2], peak, rms });
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_on_a_cone_is_found_again() {
        for (alpha, beta) in [(3, 3), (4, 6), (2, 5)] {
            let s: Vec<f64> = (0..15).map(|k| f64::from(k) / 14.0).collect();
            let out: Vec<f64> = s
                .iter()
                .map(|&s| 0.04 - 0.01 * s + 0.012 * f64::from(Profile::of(alpha, beta).at(s as f32).0))
                .collect();
            let found = profile(&s, &out).expect("a profile");
            assert_eq!((found.alpha, found.beta), (alpha, beta));
            assert!((found.width - 0.012).abs() < 1e-5 && found.rms < 1e-6, "{found:?}");
        }
        assert!(profile(&[0.0, 0.25, 0.5, 0.75, 1.0], &[0.03, 0.02, 0.01, 0.02, 0.03]).is_none(), "a hollow");
    }
}
