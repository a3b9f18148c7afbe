//! The detail operator that sets muscles into a limb (background 3.4).

use crate::field::Sample;

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
    use super::*;
    use crate::field::compose::larger;
    use crate::field::muscle::{AxisPoint, MuscleFrame, MuscleInput, MuscleRest, Profile, evaluate};
    use crate::field::transfer::transfer;
    use glam::{Vec3, Vec4};

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

    /// A limb of radius 1 along Z, its raw distance as an interpolant of Hermite samples gives it (background 1.4).
    fn limb(p: Vec3, support: f32) -> Sample {
        let across = p * Vec3::new(1.0, 1.0, 0.0);
        let (value, slope) = transfer(0.5 * (across.length_squared() - 1.0), support);
        Sample { value, gradient: across * slope }
    }

    /// The limb of a true distance.
    fn round_limb(p: Vec3) -> Sample {
        let across = p * Vec3::new(1.0, 1.0, 0.0);
        let (value, slope) = transfer(across.length() - 1.0, 1.0);
        Sample { value, gradient: across.normalize_or_zero() * slope }
    }

    struct Spindle {
        frame: MuscleFrame,
        points: Vec<AxisPoint>,
    }

    impl Spindle {
        /// A muscle of a given profile, length 3 along the limb, its axis `off` the bone's, its support as wide as it is
        /// thick (background 3.2).
        fn new(off: f32, width: f32, eccentricity: f32, profile: &Profile) -> Spindle {
            let mut points = vec![AxisPoint::default(); 30];
            let input = MuscleInput::new(profile, eccentricity);
            let rest = MuscleRest {
                origin: Vec3::new(off, 0.0, -1.5).extend(std::f32::consts::PI * width * width * 3.0),
                insertion: Vec3::new(off, 0.0, 1.5).extend(input.profile_bound * width),
                origin_normal: Vec4::Y,
                insertion_normal: Vec4::Y,
                segments: 29,
                ..MuscleRest::default()
            };
            let frame = rest.at_rest(&input, &mut points);
            Spindle { frame, points }
        }

        fn at(&self, p: Vec3) -> Sample {
            evaluate(&self.frame, &self.points, p)
        }
    }

    /// Points of a band of values, and those of them whose gradient leads away from the bone.
    fn wrong_ways(band: std::ops::Range<f32>, points: impl Iterator<Item = (Vec3, Sample)>) -> (usize, usize) {
        points.filter(|(_, s)| band.contains(&s.value)).fold((0, 0), |(seen, wrong), (p, s)| {
            let away = s.gradient.x * p.x + s.gradient.y * p.y > 0.0;
            (seen + 1, wrong + usize::from(away))
        })
    }

    type Composition = fn(Sample, Sample) -> Sample;

    /// Points of a section through the limb.
    fn section() -> impl Iterator<Item = Vec3> {
        (0..301 * 301).map(|i| Vec3::new((i % 301) as f32, (i / 301) as f32, 0.0) / 100.0 - Vec3::new(1.5, 1.5, 0.0))
    }

    #[test]
    fn in_a_section_no_gradient_leads_away_from_the_bone() {
        let mut plain_wrong = Vec::new();
        for (off, radius) in [(0.85, 0.35), (0.70, 0.40), (0.90, 0.30), (0.75, 0.20)] {
            // Of exponents (1, 1) the profile is 1 all along: a cylinder.
            let muscle = Spindle::new(off, radius, 0.0, &Profile::of(1, 1));
            assert!((muscle.frame.radius(0.5, 0.0) - radius).abs() < 1e-4);
            let count = |compose: Composition, band| {
                wrong_ways(band, section().map(|p| (p, compose(round_limb(p), muscle.at(p)))))
            };
            let (seen, wrong) = count(detail_samples, 0.15..0.6);
            assert!(seen > 3000 && wrong == 0, "band of the tracking, ({off}, {radius}): {wrong} of {seen}");
            let (seen, wrong) = count(detail_samples, 0.15..0.97);
            assert!(wrong * 1000 <= seen, "down to the bone, ({off}, {radius}): {wrong} of {seen}");
            let (seen, wrong) = count(larger, 0.15..0.97);
            plain_wrong.push(wrong as f32 / seen as f32);
        }
        assert!(plain_wrong.iter().all(|share| *share > 2e-3), "the plain union must be seen: {plain_wrong:?}");
    }

    #[test]
    fn in_a_limb_with_a_spindle_no_gradient_leads_away_from_the_bone() {
        let block = || {
            let at = |i: u32, n: u32, size: f32| size * ((i as f32 + 0.5) / n as f32 - 0.5);
            (0..48 * 48 * 24)
                .map(move |i| Vec3::new(at(i % 48, 48, 3.0), at(i / 48 % 48, 48, 3.0), at(i / 2304, 24, 3.0)))
        };
        for support in [0.5, 0.75, 1.0] {
            for (off, width, eccentricity) in [(0.85, 0.2, 0.0), (0.90, 0.2, 0.6)] {
                let muscle = Spindle::new(off, width, eccentricity, &Profile::of(3, 3));
                let share = |compose: Composition, band| {
                    let (seen, wrong) = wrong_ways(band, block().map(|p| (p, compose(limb(p, support), muscle.at(p)))));
                    assert!(seen > 1000);
                    wrong as f32 / seen as f32
                };
                let (tracked, whole) = (share(detail_samples, 0.15..0.6), share(detail_samples, 0.15..0.97));
                assert!(tracked <= 1e-4 && whole <= 1e-3, "r {support}, off {off}: {tracked} {whole}");
                let plain = share(larger, 0.15..0.97);
                assert!(plain > 2e-3, "the plain union must be seen: {plain}");
            }
        }
    }
}
