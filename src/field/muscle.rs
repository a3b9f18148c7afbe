//! The muscle primitive: a profile swept along an axis (paper A, section 5.1 and 5.2, equations 1 to 5), and its field.

use super::{Sample, transfer::transfer};
use crate::math::power;
use glam::{Vec3, Vec4, Vec4Swizzles};

crate::gpu_struct! {
    /// One muscle at one moment, in scene space at rest of the field group that it joins.
    pub struct MuscleFrame {
        /// Origin, and in `w` the axis length in metres.
        pub origin: Vec4,
        /// Unit axis from origin to insertion, and in `w` one over the length.
        pub axis: Vec4,
        /// Unit normal across the axis, the section's long axis, and in `w` the width w of equation 2, metres.
        pub normal: Vec4,
        /// Exponent alpha of the profile, 2..=9.
        pub alpha: u32,
        /// Exponent beta of the profile, 2..=9.
        pub beta: u32,
        /// One over the L2 norm of `s^(alpha-1) (1-s)^(beta-1)` on 0..=1 (equation 4).
        pub profile_scale: f32,
        /// Support radius of the muscle's field outside its surface, metres.
        pub support_radius: f32,
        /// Square of the ellipse's short semi-axis u, of an ellipse of area pi (equation 5).
        pub short_squared: f32,
        /// Square of the ellipse's long semi-axis v.
        pub long_squared: f32,
        /// 0 at rest to 1 fully active.
        pub activation: f32,
        /// 1 where the muscle has a field, 0 where its axis has collapsed to a point.
        pub present: u32,
    }
}

crate::gpu_struct! {
    /// A muscle as its rig holds it; points and directions in scene space at rest.
    pub struct MuscleRest {
        /// Origin, and in `w` the volume in cubic metres.
        pub origin: Vec4,
        /// Insertion, and in `w` the least support radius of the field, metres.
        pub insertion: Vec4,
        /// Section normal at the origin, and in `w` the rest length in metres.
        pub origin_normal: Vec4,
        /// Section normal at the insertion; `w` unused.
        pub insertion_normal: Vec4,
        /// Joint that carries the origin.
        pub origin_joint: u32,
        /// Joint that carries the insertion.
        pub insertion_joint: u32,
        /// Field group that the muscle joins.
        pub group: u32,
        /// Profile exponent alpha.
        pub alpha: u32,
        /// Profile exponent beta.
        pub beta: u32,
        /// One over the L2 norm of the unnormalised profile.
        pub profile_scale: f32,
        /// Largest value of the normalised profile.
        pub profile_max: f32,
        /// Square of the section's short semi-axis.
        pub short_squared: f32,
        /// Square of the section's long semi-axis.
        pub long_squared: f32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
        /// Unused.
        pub pad_2: u32,
    }
}

/// The largest eccentricity: at 1 the ellipse of equation 5 is infinitely long.
pub const MAX_ECCENTRICITY: f32 = 0.99;

/// One over the L2 norm of the profile, from the Euler beta function of whole arguments (equation 4).
pub fn profile_scale(alpha: u32, beta: u32) -> f32 {
    // B(2a - 1, 2b - 1) = (2a - 2)! (2b - 2)! / (2a + 2b - 3)!
    let (p, q) = (2 * alpha - 2, 2 * beta - 2);
    let mut beta_function = 1.0 / f64::from(p + q + 1);
    for i in 1..=q {
        beta_function *= f64::from(i) / f64::from(p + i);
    }
    (1.0 / beta_function.sqrt()) as f32
}

/// Largest value of the normalised profile, at `s = (alpha - 1) / (alpha + beta - 2)`.
pub fn profile_max(alpha: u32, beta: u32) -> f32 {
    let s = (alpha - 1) as f32 / (alpha + beta - 2) as f32;
    profile(alpha, beta, profile_scale(alpha, beta), s).0
}

/// Squares of the short and long semi-axes u and v for an eccentricity in 0..=[`MAX_ECCENTRICITY`], with `u v = 1`.
pub fn ellipse_squared(eccentricity: f32) -> (f32, f32) {
    let short_squared = (1.0 - eccentricity * eccentricity).sqrt();
    (short_squared, 1.0 / short_squared)
}

/// Profile Phi and its derivative by `s` (equation 4), for whole exponents of 2 or more.
#[inline]
pub fn profile(alpha: u32, beta: u32, scale: f32, s: f32) -> (f32, f32) {
    let t = 1.0 - s;
    let flank = scale * power(s, alpha - 2) * power(t, beta - 2);
    (flank * s * t, flank * ((alpha - 1) as f32 * t - (beta - 1) as f32 * s))
}

/// The muscle's raw field `f_M = d - R` at `q` (equation 1): distance to the axis less the local radius, metres.
/// Returns the distance, its gradient, the radius and the radius' gradient; `None` on the axis itself.
#[inline]
fn raw(muscle: &MuscleFrame, q: Vec3) -> Option<(f32, Vec3, f32, Vec3)> {
    let axis = muscle.axis.xyz();
    let from_origin = q - muscle.origin.xyz();
    let along = from_origin.dot(axis) * muscle.axis.w;
    let s = along.clamp(0.0, 1.0);
    let across = from_origin - axis * (s * muscle.origin.w);
    let d = across.length();
    if d < 1e-9 {
        return None;
    }
    let outward = across / d;
    let (phi, phi_slope) = profile(muscle.alpha, muscle.beta, muscle.profile_scale, s);
    let normal = muscle.normal.xyz();
    let cosine = outward.dot(normal);
    let squared = cosine * cosine;
    let polar = muscle.polar(squared);
    let width = muscle.normal.w;
    let radius = width * phi * polar;
    let inside_span = if along > 0.0 && along < 1.0 { muscle.axis.w } else { 0.0 };
    let polar_slope = cosine * (muscle.long_squared - muscle.short_squared) * polar * polar * polar;
    let radius_gradient = axis * (width * phi_slope * polar * inside_span)
        + (normal - outward * cosine) * (width * phi * polar_slope / d);
    Some((d, outward, radius, radius_gradient))
}

/// The muscle's compact field at `q`: 1 with zero slope on the axis, 1/2 on the surface, 0 from `support_radius`
/// outside it (background 3.2).
#[inline]
pub fn evaluate(muscle: &MuscleFrame, q: Vec3) -> Sample {
    if muscle.present == 0 {
        return Sample::default();
    }
    let Some((d, outward, radius, radius_gradient)) = raw(muscle, q) else {
        return Sample { value: 1.0, gradient: Vec3::ZERO };
    };
    let x = d - radius;
    if x >= 0.0 {
        let (value, slope) = transfer(x, muscle.support_radius);
        return Sample { value, gradient: (outward - radius_gradient) * slope };
    }
    // x < 0 means radius > d > 0: the divisions are safe.
    let u = -x / radius;
    let u2 = u * u;
    let steepness = 0.9375 / muscle.support_radius;
    let start = steepness * radius;
    let hump = u - 2.0 * u2 + u2 * u;
    let value = (0.5 + start * hump + 0.5 * (3.0 * u2 - 2.0 * u2 * u)).min(1.0);
    let by_u = start * (1.0 - 4.0 * u + 3.0 * u2) + 3.0 * (u - u2);
    let u_gradient = (radius_gradient * (d / radius) - outward) / radius;
    Sample { value, gradient: u_gradient * by_u + radius_gradient * (steepness * hump) }
}

/// Share of its rest length that a muscle loses from rest to full activation, as the axis-length driver reads it.
pub(crate) const ACTIVE_SHORTENING: f32 = 0.3;

/// Axes shorter than this, in metres, have no direction: the muscle drops out of the field.
pub(crate) const MIN_LENGTH: f32 = 1e-5;

/// Least support radius in largest radii: below it the inner field could not be monotone (background 3.2).
pub(crate) const LEAST_SUPPORT_RADII: f32 = 0.625;

/// The muscle on a straight axis from `origin` to `insertion`: length, width `w = sqrt(V / (pi l))` (paper A,
/// equation 3) and section frame. `wanted_normal` need be neither unit nor across the axis.
pub fn straight(rest: &MuscleRest, origin: Vec3, insertion: Vec3, wanted_normal: Vec3) -> MuscleFrame {
    let span = insertion - origin;
    let length = span.length();
    if length < MIN_LENGTH {
        return MuscleFrame::default();
    }
    let axis = span / length;
    let width = (rest.origin.w / (std::f32::consts::PI * length)).sqrt();
    let largest = width * rest.profile_max * rest.long_squared.sqrt();
    MuscleFrame {
        origin: origin.extend(length),
        axis: axis.extend(1.0 / length),
        normal: across(wanted_normal, axis).extend(width),
        alpha: rest.alpha,
        beta: rest.beta,
        profile_scale: rest.profile_scale,
        support_radius: rest.insertion.w.max(LEAST_SUPPORT_RADII * largest),
        short_squared: rest.short_squared,
        long_squared: rest.long_squared,
        activation: ((1.0 - length / rest.origin_normal.w) / ACTIVE_SHORTENING).clamp(0.0, 1.0),
        present: 1,
    }
}

/// The unit vector across `axis` nearest to `wanted`, or any unit vector across it where they are parallel.
fn across(wanted: Vec3, axis: Vec3) -> Vec3 {
    let flat = wanted - axis * wanted.dot(axis);
    let length = flat.length();
    if length > 1e-6 {
        return flat / length;
    }
    let other = if axis.x.abs() < 0.7 { Vec3::X } else { Vec3::Y };
    let flat = other - axis * other.dot(axis);
    flat / flat.length()
}

impl MuscleFrame {
    /// Distance from the axis to the surface, metres, at share `s` of the length and in a direction across the axis whose
    /// cosine to the section's long axis is `cosine` (equations 2 and 5).
    pub fn radius(&self, s: f32, cosine: f32) -> f32 {
        self.normal.w * profile(self.alpha, self.beta, self.profile_scale, s).0 * self.polar(cosine * cosine)
    }

    /// The unit-area ellipse's radius at a squared cosine to its long axis (equation 5).
    #[inline]
    fn polar(&self, squared: f32) -> f32 {
        1.0 / (self.short_squared * squared + self.long_squared * (1.0 - squared)).sqrt()
    }
}

impl MuscleRest {
    /// The muscle in the rest pose, activation 0.
    pub fn at_rest(&self) -> MuscleFrame {
        straight(self, self.origin.xyz(), self.insertion.xyz(), self.origin_normal.xyz() + self.insertion_normal.xyz())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn muscle(eccentricity: f32, alpha: u32, beta: u32) -> MuscleFrame {
        let axis = Vec3::new(0.2, 0.9, -0.3).normalize();
        let normal = axis.cross(Vec3::X).normalize();
        let (short_squared, long_squared) = ellipse_squared(eccentricity);
        MuscleFrame {
            origin: Vec3::new(0.01, -0.02, 0.03).extend(0.25),
            axis: axis.extend(4.0),
            normal: normal.extend(0.02),
            alpha,
            beta,
            profile_scale: profile_scale(alpha, beta),
            support_radius: (0.625 * 0.02 * profile_max(alpha, beta) * long_squared.sqrt()).max(0.03),
            short_squared,
            long_squared,
            activation: 0.0,
            present: 1,
        }
    }

    #[test]
    fn profile_has_unit_square_integral_and_the_known_maxima() {
        for alpha in 2..=9 {
            for beta in 2..=9 {
                let scale = profile_scale(alpha, beta);
                let n = 4000;
                let sum: f64 =
                    (0..n).map(|i| f64::from(profile(alpha, beta, scale, (i as f32 + 0.5) / n as f32).0).powi(2)).sum();
                assert!((sum / f64::from(n) - 1.0).abs() < 1e-5, "({alpha}, {beta}): {}", sum / f64::from(n));
            }
        }
        for (alpha, beta, max) in [
            (3, 3, 1.56874),
            (4, 7, 1.93108),
            (4, 8, 2.00610),
            (2, 3, 1.51807),
            (3, 9, 2.14060),
            (9, 9, 2.14903),
            (2, 2, 1.36931),
        ] {
            assert!((profile_max(alpha, beta) - max).abs() < 2e-5, "({alpha}, {beta}): {}", profile_max(alpha, beta));
        }
    }

    #[test]
    fn ellipse_keeps_its_area() {
        for e in [0.0, 0.5, 0.8, 0.95, MAX_ECCENTRICITY] {
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

    /// Deterministic points in a box around the muscle.
    fn points(n: usize) -> impl Iterator<Item = Vec3> {
        let radical = |mut i: usize, base: usize| {
            let (mut f, mut r) = (1.0, 0.0);
            while i > 0 {
                f /= base as f32;
                r += f * (i % base) as f32;
                i /= base;
            }
            r
        };
        (1..=n).map(move |i| {
            Vec3::new(radical(i, 2) * 0.2 - 0.08, radical(i, 3) * 0.35 - 0.08, radical(i, 5) * 0.2 - 0.12)
        })
    }

    /// Largest difference between `gradient` and central differences, over the gradient's own length and 30 per
    /// metre, away from the kinks: ends, surface, support, axis, and the tips where the radius is a few steps.
    fn worst_gradient(m: &MuscleFrame, gradient: impl Fn(Vec3) -> Vec3) -> f32 {
        let (mut worst, mut seen) = (0.0f32, 0);
        for q in points(20_000) {
            let sample = evaluate(m, q);
            assert!((0.0..=1.0).contains(&sample.value) && sample.gradient.is_finite());
            let s = (q - m.origin.xyz()).dot(m.axis.xyz()) * m.axis.w;
            let near_kink = s.abs() < 0.02 || (s - 1.0).abs() < 0.02 || sample.value > 0.99 || sample.value < 1e-3;
            if near_kink || raw(m, q).is_none_or(|r| (r.0 - r.2).abs() < 1e-3 || r.2 < 6e-3) {
                continue;
            }
            let h = 2e-4;
            let slope = |axis: Vec3| (evaluate(m, q + axis * h).value - evaluate(m, q - axis * h).value) / (2.0 * h);
            let measured = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z));
            worst = worst.max((measured - gradient(q)).length() / (30.0 + measured.length()));
            seen += 1;
        }
        assert!(seen > 200, "{seen} points");
        worst
    }

    #[test]
    fn gradient_is_that_of_the_value() {
        for m in [muscle(0.0, 3, 3), muscle(0.8, 4, 7), muscle(0.95, 2, 2)] {
            // What is left is the differences' own error where the ellipse is sharpest: it falls with h squared.
            let worst = worst_gradient(&m, |q| evaluate(&m, q).gradient);
            assert!(worst < 0.01, "{worst}");
            let worst = worst_gradient(&m, |q| evaluate(&m, q).gradient * 1.05);
            assert!(worst > 0.01, "a gradient 5 % too long must be seen: {worst}");
        }
    }

    #[test]
    fn surface_value_is_a_half_and_the_axis_is_one() {
        let m = muscle(0.6, 3, 4);
        for i in 1..20 {
            let s = i as f32 / 20.0;
            let on_axis = m.origin.xyz() + m.axis.xyz() * (s * m.origin.w);
            assert_eq!(evaluate(&m, on_axis).value.round(), 1.0);
            let long = m.normal.w * profile(3, 4, m.profile_scale, s).0 * m.long_squared.sqrt();
            let value = evaluate(&m, on_axis + m.normal.xyz() * long).value;
            assert!((value - 0.5).abs() < 1e-4, "s = {s}: {value}");
            assert!(
                (evaluate(&m, on_axis + m.normal.xyz() * (long + 1e-3)).value - 0.5).abs() > 1e-3,
                "off the surface"
            );
        }
    }

    #[test]
    fn volume_is_pi_w_squared_l() {
        let m = muscle(0.7, 3, 5);
        let n = 1000;
        let mut volume = 0.0f64;
        for i in 0..n {
            let phi = f64::from(profile(3, 5, m.profile_scale, (i as f32 + 0.5) / n as f32).0 * m.normal.w);
            volume += std::f64::consts::PI * phi * phi * f64::from(m.origin.w) / f64::from(n);
        }
        let expected = std::f64::consts::PI * f64::from(m.normal.w * m.normal.w * m.origin.w);
        assert!((volume / expected - 1.0).abs() < 1e-4);
    }

    #[test]
    fn an_absent_muscle_has_no_field() {
        let m = MuscleFrame { present: 0, ..muscle(0.0, 3, 3) };
        assert_eq!(evaluate(&m, m.origin.xyz()), Sample::default());
    }
}
