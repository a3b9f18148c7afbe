//! Jiggle along a muscle, which constraints on its axis cannot give: a damped oscillator, driven by the acceleration of
//! the bones along the axis, shifts the profile at constant volume ([`Profile`](crate::field::muscle::Profile)).
//!
//! The belly's mass lags behind the bones by `x`, of which the profile's shift is the share `d = x / l`:
//! `d'' + 2 zeta omega d' + omega^2 d = -jiggle a / l`, with `a` the mean acceleration of the two ends, from origin to
//! insertion: that of the middle between them.
//!
//! As much of the acceleration is let in as of a velocity outlives the substep: nothing while muscles settle and in the
//! motion's first substep, in which all of its velocity would be one jerk.
//!
//! State is `d` and its velocity in `traits.zw` of a muscle's first particle.

use super::{DynamicsParams, MovedJoint, MuscleBody, Particle};
use crate::math::transform_point;
use glam::Vec4Swizzles;

/// Angular frequency, 1/s: 6 Hz, of the 5 to 8 at which it shows (prototypes 1).
pub(crate) const RATE: f32 = std::f32::consts::TAU * 6.0;
/// Damping ratio: it rings four times.
pub(crate) const DAMPING: f32 = 0.25;
/// Shift that is never reached; from .25 on the profile would fold.
pub(crate) const MOST_SHIFT: f32 = 0.24;
/// Most acceleration over length, 1/s^2, and a thousand times what moves a belly by a tenth of its length.
pub(crate) const MOST_DRIVE: f32 = 1e5;

/// Steps a muscle's oscillator by a substep, unless the joints carry, and gives the profile's shift, at most
/// [`MOST_SHIFT`]; 0 without jiggle. `driver` is the joint of its field group, `ends` are those of origin and insertion;
/// `length` is the axis', metres.
pub(super) fn shift(
    params: &DynamicsParams,
    muscle: &MuscleBody,
    driver: &MovedJoint,
    ends: [&MovedJoint; 2],
    length: f32,
    own: &mut [Particle],
) -> f32 {
    if muscle.jiggle == 0.0 {
        return 0.0;
    }
    let (mut away, mut speed) = (own[0].traits.z, own[0].traits.w);
    if driver.carries == 0 {
        let last = muscle.segments as usize;
        let (start, end) = (own[0].position.xyz(), own[last].position.xyz());
        let displaced = transform_point(&ends[0].carry, start) + transform_point(&ends[1].carry, end);
        let before = own[0].velocity.xyz() + own[last].velocity.xyz();
        let span = end - start;
        let change = (displaced / params.seconds - before) * (0.5 * driver.retention);
        let drive = change.dot(span) / (span.length() * length * params.seconds).max(1e-9);
        let drive = drive.clamp(-MOST_DRIVE, MOST_DRIVE) * muscle.jiggle;
        // Long substeps slow it down rather than throw it.
        let rate = RATE.min(1.0 / params.seconds);
        let slowed = 1.0 + 2.0 * DAMPING * rate * params.seconds;
        speed = (speed - (rate * rate * away + drive) * params.seconds) / slowed;
        away += speed * params.seconds;
        if !(away.is_finite() && speed.is_finite()) {
            (away, speed) = (0.0, 0.0);
        }
        (own[0].traits.z, own[0].traits.w) = (away, speed);
    }
    let size = away / MOST_SHIFT;
    away / (1.0 + size * size).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat4, Vec3, Vec4};

    const H: f32 = 1.0 / 240.0;
    const LENGTH: f32 = 0.3;

    /// Shifts of a muscle along Y, whose ends move along `direction` at given velocities, substep by substep.
    fn shifts(jiggle: f32, direction: Vec3, seconds: f32, velocities: impl Iterator<Item = f32>) -> Vec<f32> {
        let params = DynamicsParams { seconds, ..DynamicsParams::default() };
        let muscle = MuscleBody { segments: 29, jiggle, ..MuscleBody::default() };
        let at = |i: i32| (Vec3::Y * (LENGTH * i as f32 / 29.0)).extend(0.0);
        let mut own: Vec<Particle> = (0..30).map(|i| Particle { position: at(i), ..Particle::default() }).collect();
        let mut retention = 0.0;
        velocities
            .map(|v| {
                let displaced = (direction * (v * seconds)).extend(0.0);
                let joint = MovedJoint {
                    carry: Mat4::from_cols(Vec4::ZERO, Vec4::ZERO, Vec4::ZERO, displaced),
                    retention,
                    ..MovedJoint::default()
                };
                let shift = shift(&params, &muscle, &joint, [&joint, &joint], LENGTH, &mut own);
                retention = 1.0;
                own.iter_mut().for_each(|p| {
                    p.position += displaced;
                    p.velocity = displaced / seconds;
                });
                shift
            })
            .collect()
    }

    /// At rest for ten substeps, then at `v` m/s.
    fn jerk(v: f32) -> impl Iterator<Item = f32> {
        (0..480).map(move |i| if i < 10 { 0.0 } else { v })
    }

    #[test]
    fn a_jerk_rings_at_six_hertz_and_fades_as_a_quarter_damped_spring() {
        let found = shifts(1.0, Vec3::Y, H, jerk(0.5));
        // d = -(v / l) e^(-zeta omega t) sin(omega' t) / omega'.
        let damped = RATE * (1.0 - DAMPING * DAMPING).sqrt();
        let expected = |t: f32| -(0.5 / LENGTH) * (-DAMPING * RATE * t).exp() * (damped * t).sin() / damped;
        let squash = |d: f32| d / (1.0 + (d / MOST_SHIFT).powi(2)).sqrt();
        let error = |shown: f32| {
            let at = |i: usize| (found[i] - shown * squash(expected((i - 9) as f32 * H))).abs();
            (10..240).map(at).fold(0.0, f32::max)
        };
        // The first swing is 3 % of the length; steps of h are h omega / 2 = 8 % late.
        assert!(error(1.0) < 0.1 * 0.03, "{}", error(1.0));
        assert!(error(-1.0) > 0.03, "the other way must be seen");
        assert!(found[..10].iter().all(|d| *d == 0.0) && found[470].abs() < 1e-4);
    }

    #[test]
    fn it_scales_with_jiggle_and_sees_the_axis_alone() {
        let most = |found: Vec<f32>| found.into_iter().map(f32::abs).fold(0.0, f32::max);
        let full = most(shifts(1.0, Vec3::Y, H, jerk(0.1)));
        let half = most(shifts(0.5, Vec3::Y, H, jerk(0.1)));
        assert!((half / full - 0.5).abs() < 0.01 && full > 1e-3, "{half} {full}");
        assert_eq!(most(shifts(1.0, Vec3::X, H, jerk(0.1))), 0.0);
        assert_eq!(most(shifts(0.0, Vec3::Y, H, jerk(0.1))), 0.0);
        // A steady motion, however fast, is none.
        assert_eq!(most(shifts(1.0, Vec3::Y, H, (0..100).map(|_| 3.0))), 0.0);
    }

    #[test]
    fn no_motion_folds_the_profile() {
        for (v, seconds) in [(1e3, H), (1e30, H), (f32::MAX, H), (5.0, 1.0), (1e4, 1.0 / 60.0), (1e3, 1e-6)] {
            let wild = shifts(1.0, Vec3::Y, seconds, (0..480).map(|i| if i % 20 < 10 { v } else { -v }));
            assert!(wild.iter().all(|d| d.abs() <= MOST_SHIFT), "{v} {seconds}");
        }
        let strong = shifts(1.0, Vec3::Y, H, jerk(100.0));
        assert!(strong.iter().any(|d| d.abs() > 0.2), "a strong one comes near");
    }
}
