//! Operators that join two limbs at a joint (background 1.9 to 1.11).
//!
//! A line of equal value C in the square of two values runs straight up to the opening line k(C) on either side, and between
//! them as a profile in the box from (k, k) to (C, C): a quarter circle, or a curve with a dent that makes folds swell. The
//! opening line k = q C + n has slope T, the opening, up to the surface's value; from there it closes the blend at
//! [`CLOSED`], where k = C. Both pieces are straight, so that in units of the box both profiles have a closed form: the
//! circle one square root, the dented one that of a quadratic spline's piece. No operator needs a table of its own.
//!
//! The derivative through the angle between the gradients is left out on both sides, as the authors' is.

use super::controller::{self, Controller, curves};
use super::{Partials, SURFACE, chained};
use crate::field::Sample;

/// Value from which an operator is the plain union.
pub(crate) const CLOSED: f32 = 0.7;
/// Pieces of the bulge's spline.
pub(crate) const PIECES: u32 = 9;
/// Bits of a [`JointOperator::code`] that are the profile; those above are the table.
pub(crate) const CODE_SHIFT: u32 = 2;
/// The plain union.
pub(crate) const PROFILE_UNION: u32 = 0;
/// A quarter circle.
const PROFILE_CIRCLE: u32 = 1;
/// A curve that dips under the box's side, with a crease on the diagonal.
pub(crate) const PROFILE_BULGE: u32 = 2;

/// What joins two limbs at a joint: a profile, and how far it opens by the angle between the two gradients.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum JointOperator {
    /// The plain union.
    Union,
    /// A blend as wide as it may be, at any angle.
    Blend,
    /// A union on the straight limb and in the fold, a blend between: the elbow's own.
    #[default]
    Contact,
    /// Folds that swell.
    Bulge,
    /// Elbows and knees; another name of the contact.
    Elbow,
    /// Elbows that blend up to sharper folds.
    Elbow2,
    /// The elbow that the authors tested with.
    TestElbow,
    /// Fingers.
    Finger,
    /// Fingers whose skins stay blended where they face each other.
    Finger2,
    /// A blend where the gradients are square to each other, a union both ways from there.
    Camel,
}

crate::gpu_struct! {
    /// A joint's operator as kernels read it.
    pub struct JointOperatorParams {
        /// Its profile: 0 the plain union, 1 a quarter circle, 2 the bulge.
        pub profile: u32,
        /// Where its openings begin among the [`curves`].
        pub table: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
    }
}

impl crate::math::WgslType for JointOperatorParams {
    const WGSL: &'static str = <JointOperatorParams as crate::math::GpuStruct>::NAME;
}

impl JointOperator {
    /// All of them.
    pub const ALL: [JointOperator; 10] = [
        JointOperator::Union,
        JointOperator::Blend,
        JointOperator::Contact,
        JointOperator::Bulge,
        JointOperator::Elbow,
        JointOperator::Elbow2,
        JointOperator::TestElbow,
        JointOperator::Finger,
        JointOperator::Finger2,
        JointOperator::Camel,
    ];

    /// Its name in a muscle file.
    pub fn name(self) -> &'static str {
        match self {
            JointOperator::Union => "union",
            JointOperator::Blend => "blend",
            JointOperator::Contact => "contact",
            JointOperator::Bulge => "bulge",
            JointOperator::Elbow => "elbow",
            JointOperator::Elbow2 => "elbow2",
            JointOperator::TestElbow => "test-elbow",
            JointOperator::Finger => "finger",
            JointOperator::Finger2 => "finger2",
            JointOperator::Camel => "camel",
        }
    }

    /// What opens it; nothing opens the plain union.
    pub fn controller(self) -> Option<Controller> {
        Some(match self {
            JointOperator::Union => return None,
            JointOperator::Blend => Controller::BLEND,
            JointOperator::Contact | JointOperator::Elbow => Controller::ELBOW,
            JointOperator::Bulge => Controller::BULGE,
            JointOperator::Elbow2 => Controller::ELBOW_2,
            JointOperator::TestElbow => Controller::TEST_ELBOW,
            JointOperator::Finger => Controller::FINGER,
            JointOperator::Finger2 => Controller::FINGER_2,
            JointOperator::Camel => Controller::CAMEL,
        })
    }

    /// [`JointOperator::params`] in one number: 0 for the plain union.
    pub fn code(self) -> u32 {
        let params = self.params();
        params.profile | params.table << CODE_SHIFT
    }

    /// What kernels read of it.
    pub fn params(self) -> JointOperatorParams {
        let profile = match self {
            JointOperator::Union => PROFILE_UNION,
            JointOperator::Bulge => PROFILE_BULGE,
            _ => PROFILE_CIRCLE,
        };
        let table = self.controller().map_or(0, |controller| controller.table());
        JointOperatorParams { profile, table, ..JointOperatorParams::default() }
    }
}

/// Value and derivatives by `big` and by `small`, of which `big` is the larger, at opening `t` in 0..=1.
#[inline]
pub fn joint_values(profile: u32, big: f32, small: f32, t: f32) -> Partials {
    if profile == PROFILE_UNION || big >= CLOSED || small <= 0.0 {
        return (big, 1.0, 0.0);
    }
    if big <= SURFACE {
        let open = boxed(profile, [big, t, big * (1.0 - t), small - t * big]);
        if open.0 <= SURFACE {
            return open;
        }
    }
    // Beyond the surface's own line the opening line closes.
    let q = (CLOSED - SURFACE * t) / (CLOSED - SURFACE);
    boxed(profile, [big, q, (CLOSED - big) * (q - 1.0), q * (CLOSED - big) - (CLOSED - small)])
}

/// The profile in its box, along an opening line of slope `q`. At C = `big` the box's side is `unit`, and the smaller value
/// is `over` beyond the box's corner.
fn boxed(profile: u32, [big, q, unit, over]: [f32; 4]) -> Partials {
    if over <= 0.0 || unit <= 0.0 {
        return (big, 1.0, 0.0);
    }
    let share = (over / unit).min(1.0);
    if profile == PROFILE_BULGE { bulge(big, q, unit, share) } else { circle(big, q, unit, share) }
}

/// In units of `unit` the arc's centre lies at 1 - q y and its other leg at share - q y, and its radius is 1 + (1 - q) y,
/// where the value is `big` + `unit` y: a quadratic in y. The root of its discriminant is what derivatives are divided by.
fn circle(big: f32, q: f32, unit: f32, share: f32) -> Partials {
    let root = (1.0 + share * share + 2.0 * q * share * (1.0 - share)).sqrt();
    let y = share * share / (1.0 + q * share + root);
    (big + unit * y, (1.0 - q * y) / root, (share - q * y) / root)
}

/// The larger leg over the box's side is 1 - s(t), t being the smaller leg's, with s a quadratic spline: t + a s(t) =
/// share is one too, and it rises throughout.
fn bulge(big: f32, q: f32, unit: f32, share: f32) -> Partials {
    let curves = curves();
    let control = |i: u32| curves[i as usize];
    let step = 1.0 / PIECES as f32;
    let d = 1.0 - q;
    let a = q + d * share;
    let knot = |i: u32| 0.5 * (control(i) + control(i + 1));
    let mut piece = 0;
    for i in 1..PIECES {
        if i as f32 * step + a * knot(i) <= share {
            piece = i;
        }
    }
    let rise = control(piece + 1) - control(piece);
    let bend = 0.5 * (control(piece) - 2.0 * control(piece + 1) + control(piece + 2));
    let left = (share - piece as f32 * step - a * knot(piece)).max(0.0);
    let slope = step + a * rise;
    let f = 2.0 * left / (slope + (slope * slope + 4.0 * a * bend * left).max(0.0).sqrt());
    let s = knot(piece) + f * (rise + f * bend);
    let s_slope = (rise + 2.0 * f * bend) * PIECES as f32;
    let t = (piece as f32 + f) * step;
    let scale = 1.0 / (1.0 - d * s + s_slope * (q + d * t));
    (big + unit * (s / (1.0 - d * s)), scale, s_slope * scale)
}

impl JointOperatorParams {
    /// The operator of a [`JointOperator::code`].
    #[inline]
    pub fn of_code(code: u32) -> JointOperatorParams {
        let (profile, table) = (code & ((1 << CODE_SHIFT) - 1), code >> CODE_SHIFT);
        JointOperatorParams { profile, table, ..JointOperatorParams::default() }
    }
}

/// Two limbs joined. Where either has no gradient there is no angle, and the larger one is taken whole.
#[inline]
pub fn joint(a: Sample, b: Sample, operator: &JointOperatorParams) -> Sample {
    let (big, small) = if b.value > a.value { (b, a) } else { (a, b) };
    if operator.profile == PROFILE_UNION || small.value <= 0.0 || big.value >= CLOSED {
        return big;
    }
    let length = big.gradient.length() * small.gradient.length();
    if length <= 0.0 {
        return big;
    }
    let t = controller::opening(curves(), operator.table, big.gradient.dot(small.gradient) / length);
    chained(big, small, joint_values(operator.profile, big.value, small.value, t))
}

#[cfg(test)]
mod tests {
    use super::super::tests::worst_slope;
    use super::*;
    use glam::Vec3;

    /// Derivatives by the first and the second of two values in any order.
    fn ordered(profile: u32, a: f32, b: f32, t: f32) -> Partials {
        if b > a {
            let (value, by_b, by_a) = joint_values(profile, b, a, t);
            (value, by_a, by_b)
        } else {
            joint_values(profile, a, b, t)
        }
    }

    /// The opening line k(C).
    fn line(c: f64, t: f64) -> f64 {
        if c <= 0.5 { t * c } else { (0.5 * t + (0.7 - 0.5 * t) * (c - 0.5) / 0.2).max(t * 0.5) }
    }

    /// How far the bulge's profile dips under the side, by the spline's basis functions.
    fn dip(t: f64) -> f64 {
        let basis = |x: f64| match x {
            x if !(0.0..3.0).contains(&x) => 0.0,
            x if x < 1.0 => 0.5 * x * x,
            x if x < 2.0 => 0.5 * (-2.0 * x * x + 6.0 * x - 3.0),
            x => 0.5 * (3.0 - x) * (3.0 - x),
        };
        (0..11).map(|i| f64::from(curves()[i]) * basis(9.0 * t + 2.0 - i as f64)).sum()
    }

    /// The value by bisection in f64, from the lines of equal value themselves.
    fn exact(profile: u32, a: f32, b: f32, t: f32) -> f64 {
        let (big, small, t) = (f64::from(a.max(b)), f64::from(a.min(b)), f64::from(t));
        if big >= 0.7 || small <= line(big, t) {
            return big;
        }
        let outside = |c: f64| {
            let (x, y) = (big - line(c, t), small - line(c, t));
            let side = c - line(c, t);
            if profile == PROFILE_BULGE { x > side * (1.0 - dip(y / side)) } else { x.hypot(y) > side }
        };
        let mut ends = [big, 0.7];
        for i in 0..100 {
            let c = 0.5 * (ends[0] + ends[1]);
            // Where the smaller leg has left the box, the value is too large.
            ends[usize::from(!(small > line(c, t) && outside(c)))] = c;
            assert!(i < 99 || ends[1] - ends[0] < 1e-12);
        }
        ends[0]
    }

    const PROFILES: [u32; 2] = [PROFILE_CIRCLE, PROFILE_BULGE];
    const OPENINGS: [f32; 7] = [0.0, 0.1, 0.3, 0.5, 0.8, 0.99, 1.0];

    fn grid() -> impl Iterator<Item = (f32, f32)> {
        (0..=160).flat_map(|i| (0..=160).map(move |j| (i as f32 / 160.0, j as f32 / 160.0)))
    }

    #[test]
    fn check_values_of_the_background() {
        let narrow = (std::f32::consts::PI / 10.0).tan();
        for (a, b, t, expected) in [
            (0.3, 0.3, 0.5, 0.351472),
            (0.4, 0.35, 0.3, 0.473396),
            (0.5, 0.5, 0.3, 0.567774),
            (0.6, 0.58, 0.3, 0.627646),
            (0.45, 0.45, narrow, 0.532699),
        ] {
            let value = ordered(PROFILE_CIRCLE, a, b, t).0;
            assert!((value - expected).abs() < 2e-6, "g({a}, {b}; {t}) = {value}");
            let bulging = ordered(PROFILE_BULGE, a, b, t).0;
            assert!((bulging - expected).abs() > 1e-3, "another profile must be seen");
        }
        for (a, b, t, by_a, by_b) in [
            (0.3, 0.3, 0.5, 0.585786, 0.585786),
            (0.4, 0.35, 0.3, 0.69396, 0.55946),
            (0.5, 0.5, 0.3, 0.330565, 0.330565),
        ] {
            let (_, found_a, found_b) = ordered(PROFILE_CIRCLE, a, b, t);
            assert!((found_a - by_a).abs() < 1e-5 && (found_b - by_b).abs() < 1e-5, "{found_a} {found_b}");
        }
    }

    #[test]
    fn closed_forms_are_what_the_lines_of_equal_value_say() {
        for profile in PROFILES {
            for t in OPENINGS {
                let (mut worst, mut most) = (0.0f64, 0.0f64);
                for (a, b) in grid() {
                    let found = f64::from(ordered(profile, a, b, t).0);
                    worst = worst.max((found - exact(profile, a, b, t)).abs());
                    most = most.max(found - f64::from(a.max(b)));
                }
                assert!(worst < 3e-7, "profile {profile} at {t}: {worst}");
                assert!(if t < 0.9 { most > 0.01 } else { most < 2e-3 }, "profile {profile} at {t} adds {most}");
            }
        }
        let other = |a, b| (f64::from(ordered(PROFILE_CIRCLE, a, b, 0.31).0) - exact(PROFILE_CIRCLE, a, b, 0.3)).abs();
        assert!(grid().any(|(a, b)| other(a, b) > 1e-3), "another opening must be seen");
    }

    #[test]
    fn derivatives_are_those_of_the_value() {
        for profile in PROFILES {
            for t in [0.0, 0.3, 0.6] {
                let operator = |a: f32, b: f32| ordered(profile, a, b, t);
                // Off the surface's own line, where the opening line turns, the diagonal, where the bulge has its crease,
                // and the corners of small boxes.
                let smooth = |a: f32, b: f32| {
                    let value = operator(a, b).0;
                    (value - 0.5).abs() > 0.012 && (a - b).abs() > 0.005 && value < 0.66 && value > 0.05
                };
                let worst = worst_slope(&operator, &smooth);
                // The spline's slope bends by up to 4 over the box's side, .2 and more: half of that over 1e-3 on either
                // side of a knot.
                assert!(worst < 4e-2, "profile {profile} at {t}: {worst}");
                let half = |a: f32, b: f32| {
                    let (value, by_a, by_b) = operator(a, b);
                    (value, by_a, 0.9 * by_b)
                };
                assert!(worst_slope(&half, &smooth) > 5e-2, "a shorter derivative must be seen");
            }
        }
    }

    #[test]
    fn operators_stay_in_range_keep_what_is_alone_and_have_no_order() {
        for profile in PROFILES {
            for t in OPENINGS {
                for (a, b) in grid() {
                    let (value, by_a, by_b) = ordered(profile, a, b, t);
                    assert!(value >= a.max(b) && value <= a.max(b).max(0.7 + 1e-6), "g({a}, {b}; {t}) = {value}");
                    let range = if profile == PROFILE_BULGE { -0.5..1.5 } else { -1e-6..1.0 + 1e-5 };
                    assert!([by_a, by_b].iter().all(|s| range.contains(s)), "at ({a}, {b}; {t}): {by_a} {by_b}");
                    assert_eq!(ordered(profile, a, 0.0, t).0, a);
                    assert_eq!(ordered(profile, b, a, t).0, value);
                    if t == 1.0 {
                        assert_eq!(value, a.max(b));
                    }
                }
            }
        }
    }

    #[test]
    fn circles_grow_with_either_field_and_with_the_opening() {
        let value = |a: f32, b: f32, t: f32| ordered(PROFILE_CIRCLE, a, b, t).0;
        for (a, b) in grid() {
            for t in OPENINGS {
                assert!(value(a + 0.01, b, t) >= value(a, b, t) - 1e-6, "at ({a}, {b}; {t})");
            }
            assert!(OPENINGS.windows(2).all(|t| value(a, b, t[0]) >= value(a, b, t[1]) - 1e-6), "at ({a}, {b})");
        }
        let dented = |b: f32| ordered(PROFILE_BULGE, 0.4, b, 0.0).0;
        assert!(dented(0.39) < dented(0.34), "the bulge's crease lies lower than its swelling");
    }

    fn sample(value: f32, gradient: Vec3) -> Sample {
        Sample { value, gradient }
    }

    #[test]
    fn the_angle_opens_the_joint() {
        let elbow = JointOperator::Contact.params();
        let at = |degrees: f32, operator: &JointOperatorParams| {
            let turned = Vec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
            joint(sample(0.4, Vec3::X * 30.0), sample(0.38, turned * 20.0), operator).value
        };
        assert!((at(0.0, &elbow) - 0.4).abs() < 1e-5 && at(180.0, &elbow) == 0.4, "{}", at(0.0, &elbow));
        assert!(at(45.0, &elbow) > 0.42, "{}", at(45.0, &elbow));
        let bulge = JointOperator::Bulge.params();
        assert!(at(180.0, &bulge) > 0.42 && (at(0.0, &bulge) - 0.4).abs() < 1e-5, "{}", at(180.0, &bulge));
        let blend = JointOperator::Blend.params();
        let expected = joint_values(PROFILE_CIRCLE, 0.4, 0.38, 0.0).0;
        assert!((at(0.0, &blend) - expected).abs() < 1e-7 && at(77.0, &blend) == at(0.0, &blend));
        assert_eq!(at(45.0, &JointOperator::Union.params()), 0.4);
    }

    #[test]
    fn without_a_gradient_there_is_no_angle() {
        for operator in JointOperator::ALL {
            let (still, moving) = (sample(0.4, Vec3::ZERO), sample(0.45, Vec3::Y));
            assert_eq!(joint(still, moving, &operator.params()), moving);
            assert_eq!(joint(moving, still, &operator.params()), moving);
            let nothing = sample(0.0, Vec3::ZERO);
            assert_eq!(joint(moving, nothing, &operator.params()), moving);
        }
        let turned = sample(0.4, Vec3::X);
        assert_ne!(joint(turned, sample(0.45, Vec3::Y), &JointOperator::Blend.params()), sample(0.45, Vec3::Y));
    }

    #[test]
    fn operators_have_names_and_tables_of_their_own() {
        let names: std::collections::BTreeSet<_> = JointOperator::ALL.iter().map(|o| o.name()).collect();
        assert_eq!(names.len(), JointOperator::ALL.len());
        let params: std::collections::BTreeSet<_> =
            JointOperator::ALL.iter().map(|o| (o.params().profile, o.params().table)).collect();
        assert_eq!(params.len(), JointOperator::ALL.len() - 1, "only the elbow is another's twin");
        assert_eq!(JointOperator::Elbow.params(), JointOperator::Contact.params());
        assert_eq!(JointOperator::Union.code(), 0);
        assert!(JointOperator::ALL.iter().all(|o| JointOperatorParams::of_code(o.code()) == o.params()));
    }
}
