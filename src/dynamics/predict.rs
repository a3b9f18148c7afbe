//! Where a muscle's particles would be at the end of a substep if nothing held them. Twin of the kernel `muscle_predict`.

use super::{DynamicsParams, MovedJoint, MuscleBody, Particle, course::Courses, jiggle};
use crate::{
    field::muscle::{AxisPoint, MuscleInput, Profile, profile, wrap::MuscleWrap},
    math::{transform_point, transform_vector},
};
use glam::{Vec3, Vec4, Vec4Swizzles};
use std::f32::consts::{PI, TAU};

/// Share of a segment's rest length by which the axis is stretched at rest: that of its tension in the formula of a
/// string's frequency (prototypes 1).
pub(crate) const STRETCH: f32 = 0.98;
/// Stiffness k at which the frequency is the nominal one, and the step of k that doubles it: .1 is loose, .7 very tense
/// (paper A, section 6.2), so they are a half and twice the nominal one.
pub(crate) const NOMINAL_STIFFNESS: f32 = 0.4;
/// See [`NOMINAL_STIFFNESS`]; the exponential is squared twice.
pub(crate) const RATE: f32 = std::f32::consts::LN_2 / (4.0 * 0.3);
/// Square of the phase, radians, that a swing makes in a substep, up to which the substep's lag is made up in full: 38 Hz
/// at 240 substeps a second.
pub(crate) const MOST_PHASE_SQUARED: f32 = 1.0;
/// Most of a muscle's width that a particle moves on, relative to the bones, in a substep: a third of a metre to two metres
/// and a half a second for widths of 3 to 20 mm at 240 substeps a second.
pub(crate) const MOST_WAY: f32 = 0.5;
/// Stiffness of a tendon per iteration, at most: the paper's k is a share.
pub(crate) const MOST_STIFFNESS: f32 = 1.0;

/// Frequency of a muscle of stiffness `k`, where one of .4 has `nominal`, hertz: `nominal 2^((k - .4) / .3)`, from the
/// series of the exponential, so that kernels have the same.
pub fn frequency(k: f32, nominal: f32) -> f32 {
    // Squared twice, so that the argument is within .35 of 0.
    let x = (k - NOMINAL_STIFFNESS) * RATE;
    let e = 1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0)))));
    let squared = e * e;
    nominal * squared * squared
}

/// Compliance of a segment over the substep squared, 1/kg, of a muscle of `mass` kg and as many `segments` that is to swing
/// sideways `cycles` times a substep, if it were a string of even thickness: at `sqrt(T / (L M)) / 2` under the tension `T`
/// of segments that are stretched by [`STRETCH`] of their length at rest.
///
/// An implicit step of a swing of phase `x` makes only `atan x` of it; so the springs are as stiff as for a phase of `tan
/// x`, here `x (15 - x^2) / (15 - 6 x^2)`, which is within 1.2e-3 of it up to 1.
pub(super) fn compliance(mass: f32, segments: f32, cycles: f32) -> f32 {
    let squared = (TAU * TAU * cycles * cycles).min(MOST_PHASE_SQUARED);
    let quick = cycles * (15.0 - squared) / (15.0 - 6.0 * squared);
    STRETCH / (4.0 * mass * quick * quick * segments)
}

/// One muscle as [`predict`] reads it.
#[derive(Clone, Copy)]
pub struct Predicted<'a> {
    /// Its body.
    pub muscle: &'a MuscleBody,
    /// Its parameters in the frame.
    pub input: &'a MuscleInput,
    /// Its axis as last shaped, or at rest.
    pub axis: &'a [AxisPoint],
    /// What it lies round.
    pub wrap: Option<&'a MuscleWrap>,
}

/// Predicts one muscle's particles, renews their radii, and writes its run of the iterates: see
/// [`axis::half`](crate::field::muscle::axis::half).
///
/// `moved` are the instance's joints, `own` and `iterates` the muscle's.
///
/// A muscle that lies round something is carried along its path, and its springs start with the tensions that they have on it.
/// Where these have a resultant they do so to the end: it is what the obstacle holds against, so that the axis is at rest on the
/// path, and swings about it as a straight one does about its chord. In `pbd` mode, whose springs keep no tension, nothing holds
/// it there.
///
/// No particle moves on by more than `MOST_WAY` of the muscle's width: it would leap over a bone. In `pbd` mode, whose
/// steps are four times as long, it moves as far as in the paper.
///
/// Where the joints carry, particles and their velocities stay as they are. The first particle keeps the state of the
/// jiggle along the axis.
pub fn predict(
    params: &DynamicsParams,
    predicted: &Predicted,
    moved: &[MovedJoint],
    own: &mut [Particle],
    iterates: &mut [Vec4],
) {
    let Predicted { muscle, input, axis, wrap } = *predicted;
    let (from, to) = (&moved[muscle.origin_joint as usize], &moved[muscle.insertion_joint as usize]);
    if from.runs == 0 {
        return;
    }
    let driver = &moved[muscle.driver as usize];
    let last = muscle.segments as usize;
    let (mut length, mut rest, mut softness) = (0.0, 0.0, 0.0);
    for i in 0..last {
        let span = own[i + 1].position.xyz() - own[i].position.xyz();
        length += span.length();
        rest += own[i].spring.w;
        softness += 1.0 / own[i].traits.y;
    }
    // In the group's space at rest, where the volume is kept (paper A, equation 3).
    let scale = driver.scale.max(1e-6);
    let width = input.width * (muscle.origin.w / (PI * (length / scale).max(1e-5))).sqrt() * scale;
    let shift = jiggle::shift(params, muscle, driver, [from, to], length, own);
    let shape = Profile { factors: input.factors, exponents: input.exponents, terms: input.terms, shift };
    let (short_squared, _) = profile::ellipse_squared(input.eccentricity);
    let origin = transform_point(&from.matrix, muscle.origin.xyz());
    let insertion = transform_point(&to.matrix, muscle.insertion.xyz());
    let (compliance, radius_squared) = stiffness(params, muscle, input);
    // All springs start with the tension of the whole axis along its chord: that moves no particle, and is the part of the
    // solution that sweeps from one segment to the next are slowest to find.
    let excess = if params.pbd != 0 { 0.0 } else { (length - rest * scale).max(0.0) };
    let chord = insertion - origin;
    let pull = chord * (-excess / (compliance * softness * chord.length().max(1e-9)));
    // Its longest radius, so that the box holds the surface, and the play, so that a plane that lags behind has come to
    // nothing where it ends: a neighbour that appears and goes at a depth moves to and fro for ever.
    let longest = 1.0 / short_squared.sqrt();
    let (mut lowest, mut highest) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let courses = wrap.map(|wrap| {
        let before = [own[0].position.xyz(), own[last].position.xyz()];
        Courses::new(wrap, &moved[wrap.joint as usize], before, [origin, insertion])
    });
    let mut next = origin;
    for i in 0..=last {
        let share = i as f32 / last as f32;
        let x = own[i].position.xyz();
        let displacement =
            |p: Vec3| transform_point(&from.carry, p) * (1.0 - share) + transform_point(&to.carry, p) * share;
        let (mut displaced, mut pull) = (displacement(x), pull);
        if let Some(courses) = &courses {
            let (start, end) = (courses.start(i as u32), next);
            displaced += (end - start) - displacement(start);
            next = courses.end((i + 1).min(last) as u32);
            if params.pbd == 0 {
                pull = tension(next - end, own[i].spring.w * scale, own[i].traits.y / compliance);
            }
        }
        let carried = x + displaced;
        let place = if i == 0 {
            origin
        } else if i == last {
            insertion
        } else if driver.carries != 0 {
            carried
        } else {
            let relative = (own[i].velocity.xyz() * params.seconds - displaced) * driver.retention;
            let way = if params.pbd != 0 { f32::MAX } else { MOST_WAY * width };
            carried + relative * (way / relative.length().max(1e-9)).min(1.0)
        };
        let radius = width * shape.at(share).0;
        own[i].position.w = radius;
        let section = transform_vector(&driver.matrix, axis[i].normal.xyz());
        let size = section.length();
        let (section, round) = if size > 0.0 { (section / size, short_squared) } else { (Vec3::ZERO, 0.0) };
        iterates[2 + 2 * i] = place.extend(radius);
        iterates[3 + 2 * i] = section.extend(round);
        let reach = radius * longest + params.play;
        lowest = lowest.min(place - reach);
        highest = highest.max(place + reach);
        if driver.carries == 0 {
            own[i].spring = if i < last { pull } else { Vec3::ZERO }.extend(own[i].spring.w);
            own[i].pushes = Vec4::ZERO;
        }
    }
    // Nothing else reads the section's entry of the last point ([`axis::half`](crate::field::muscle::axis::half)).
    iterates[3 + 2 * last].w = shift;
    iterates[0] = lowest.extend(compliance);
    iterates[1] = highest.extend(radius_squared);
}

/// Multiplier with which a spring of rest length `rest` and `stiffness`, kg, is in balance over `span`.
fn tension(span: Vec3, rest: f32, stiffness: f32) -> Vec3 {
    let length = span.length().max(1e-9);
    span * ((rest - length).min(0.0) * stiffness / length)
}

/// Compliance over the substep squared, 1/kg, and the square of the spectral radius of Jacobi's sweeps; in `pbd` mode the
/// paper's k, and 0: its sweeps are not over-relaxed, since their number is the stiffness.
fn stiffness(params: &DynamicsParams, muscle: &MuscleBody, input: &MuscleInput) -> (f32, f32) {
    if params.pbd != 0 {
        return (input.stiffness, 0.0);
    }
    let segments = muscle.segments as f32;
    let own = muscle.frequency;
    let hertz = if own > 0.0 { own } else { frequency(input.stiffness, params.frequency) };
    let cycles = hertz * params.seconds;
    let compliance = compliance(muscle.insertion.w, segments, cycles);
    let angle = PI / segments;
    let cosine = 1.0 - angle * angle * (0.5 - angle * angle * (1.0 / 24.0));
    let radius = cosine * 2.0 * muscle.looseness / (2.0 * muscle.looseness + compliance);
    (compliance, radius * radius)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_steps_lag_is_made_up() {
        for (hertz, bound) in [(6.0f32, 1e-4), (24.0, 1e-4), (38.0, 2e-3)] {
            let cycles = hertz / 240.0;
            let phase = TAU * (STRETCH / (4.0 * 29.0 * compliance(1.0, 29.0, cycles))).sqrt();
            assert!((phase.atan() / (TAU * cycles) - 1.0).abs() < bound, "{hertz} Hz: {phase}");
            assert!((TAU * cycles).atan() / (TAU * cycles) < 0.993, "{hertz} Hz: without, it lags");
        }
    }

    #[test]
    fn stiffness_doubles_the_frequency_every_third() {
        for (k, f) in [(0.4f32, 12.0f32), (0.7, 24.0), (0.1, 6.0), (1.0, 48.0), (0.0, 12.0 / 2f32.powf(4.0 / 3.0))] {
            assert!((frequency(k, 12.0) / f - 1.0).abs() < 1e-3, "{k}: {} {f}", frequency(k, 12.0));
        }
        assert!((frequency(0.5, 12.0) / 24.0 - 1.0).abs() > 0.1, "another stiffness has another one");
    }
}
