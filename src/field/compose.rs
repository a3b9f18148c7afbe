//! How fields are put together: the detail operator that sets muscles into a limb (background 3.4).

use super::Sample;

/// Muscle value from which the operator saturates.
pub(crate) const SATURATION: f32 = 0.55;
/// Slope `(1 - SATURATION) / 8` that the saturation adds at most: the eighth power levels it off.
pub(crate) const HEADROOM: f32 = 0.056_25;
/// Fillet control: the 0.5-surface leaves the plain union where both fields are .4454.
pub(crate) const FILLET: f32 = 0.8;

/// Value and both partial derivatives of the detail operator `D(limb, muscle)`.
///
/// Outside it is an elliptical fillet between the limb's surface and the muscle's; inside the muscle the muscle's
/// value saturates just above 1/2, so that the limb's gradient leads through it to the bone.
#[inline]
pub fn detail(limb: f32, muscle: f32) -> (f32, f32, f32) {
    let (mut q, mut slope) = (muscle, 1.0);
    if muscle > SATURATION {
        let y = 1.0 - (muscle - SATURATION).min(1.0 - SATURATION) / (1.0 - SATURATION);
        let y2 = y * y;
        let y4 = y2 * y2;
        q = SATURATION + HEADROOM * (1.0 - y4 * y4);
        slope = y4 * y2 * y;
    }
    if q <= FILLET * limb {
        return (limb, 1.0, 0.0);
    }
    let s = (q * q + (1.0 - 2.0 * FILLET) * limb * limb).sqrt();
    let scale = 1.0 / (1.0 - 2.0 * FILLET);
    let value = ((1.0 - FILLET) * s - FILLET * q) * scale;
    (value, (1.0 - FILLET) * limb / s, ((1.0 - FILLET) * q / s - FILLET) * scale * slope)
}

/// [`detail`] on samples: value, and gradient by the chain rule.
#[inline]
pub fn detail_samples(limb: Sample, muscle: Sample) -> Sample {
    let (value, by_limb, by_muscle) = detail(limb.value, muscle.value);
    Sample { value, gradient: limb.gradient * by_limb + muscle.gradient * by_muscle }
}

#[cfg(test)]
mod tests {
    use super::detail;

    #[test]
    fn check_values_of_the_background() {
        for (limb, muscle, expected) in [
            (0.3, 0.3, 0.336754),
            (0.5, 0.5, 0.561257),
            (0.2, 0.8, 0.612875),
            (0.55, 0.7, 0.662663),
            (0.6, 0.55, 0.635297),
            (0.05, 1.0, 0.606663),
            (0.9, 0.9, 0.9),
        ] {
            assert!(
                (detail(limb, muscle).0 - expected).abs() < 2e-6,
                "D({limb}, {muscle}) = {}",
                detail(limb, muscle).0
            );
        }
        let (_, by_limb, by_muscle) = detail(0.2, 0.8);
        assert!((by_limb - 0.068255).abs() < 1e-5 && (by_muscle - 0.003386).abs() < 1e-5);
        let (_, by_limb, by_muscle) = detail(0.55, 0.7);
        assert!((by_limb - 0.256870).abs() < 1e-5 && (by_muscle - 0.050518).abs() < 1e-5);
    }

    #[test]
    fn properties_on_a_grid() {
        for i in 0..=128 {
            for j in 0..=128 {
                let (limb, muscle) = (i as f32 / 128.0, j as f32 / 128.0);
                let (value, by_limb, by_muscle) = detail(limb, muscle);
                assert!((0.0..=1.0).contains(&value));
                assert!(value >= limb - 1e-6, "D({limb}, {muscle}) = {value}");
                assert!((-1e-6..=1.0 + 1e-6).contains(&by_limb) && (-1e-6..=1.0 + 1e-6).contains(&by_muscle));
                if muscle == 0.0 {
                    assert_eq!(value, limb);
                }
                if limb == 0.0 && muscle <= 0.55 {
                    assert!((value - muscle).abs() < 1e-6);
                }
                if limb >= 0.758 {
                    assert_eq!(value, limb);
                }
            }
        }
    }

    #[test]
    fn derivatives_match_central_differences() {
        let h = 1e-3;
        for i in 1..40 {
            for j in 1..40 {
                let (limb, muscle) = (i as f32 / 40.0 + 0.003, j as f32 / 40.0 + 0.007);
                let near_seam = (muscle - 0.55).abs() < 2.0 * h || (muscle.min(0.60625) - 0.8 * limb).abs() < 0.03;
                if near_seam || muscle > 0.995 || limb > 0.995 {
                    continue;
                }
                let (_, by_limb, by_muscle) = detail(limb, muscle);
                let measured_limb = (detail(limb + h, muscle).0 - detail(limb - h, muscle).0) / (2.0 * h);
                let measured_muscle = (detail(limb, muscle + h).0 - detail(limb, muscle - h).0) / (2.0 * h);
                assert!(
                    (by_limb - measured_limb).abs() < 2e-3,
                    "d/dlimb at ({limb}, {muscle}): {by_limb} {measured_limb}"
                );
                assert!((by_muscle - measured_muscle).abs() < 2e-3, "d/dmuscle at ({limb}, {muscle})");
            }
        }
    }
}
