//! How far an operator opens: from the union, where two skins run on as one, to the blend, by the angle between the
//! fields' gradients (background 1.9).
//!
//! The opening T, tangent of the opening angle, is 1 for the union and 0 for the widest blend. Kernels have no
//! exponentials that agree with the host's, so that both read T over the angle's cosine from tables made here.

use std::f64::consts::FRAC_PI_4;
use std::sync::LazyLock;

/// Intervals of a table of openings over the cosine, -1..=1.
pub(crate) const STEPS: u32 = 256;
/// Numbers of one table, up to the next multiple of four.
const STRIDE: u32 = STEPS + 4;
/// Control values of the bulge's profile at the head of the curves, up to the next multiple of four.
const HEAD: u32 = 12;

/// Control values of a uniform quadratic B-spline over 0..=1: how far the bulge's profile dips under the unit square's side
/// (background 1.10).
const BULGE: [f32; HEAD as usize] = [0.0, 0.0, 0.0, 0.025, 0.05, 0.075, 0.1, 0.125, 0.1, 0.1, 0.1, 0.0];

/// An opening over the angle between two gradients: flat ends, and two steps without kinks between three points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Controller {
    /// Opening angles over the angle, both in radians, and the steps' exponents (the paper's form).
    Angle {
        /// Angles between the gradients, ascending.
        at: [f64; 3],
        /// Opening angles there, 0 to a quarter of pi.
        opening: [f64; 3],
        /// Exponents of the first and the second step.
        exponents: [f64; 2],
    },
    /// Shares of the union, 0 to 1, over the cosine, and the steps' exponents (the authors' program's form).
    Cosine {
        /// Cosines of the angle, ascending; they may lie beyond -1 and 1.
        at: [f64; 3],
        /// Shares of the union there.
        share: [f64; 3],
        /// Exponents of the first and the second step.
        exponents: [f64; 2],
    },
}

impl Controller {
    /// Elbows and knees.
    pub const ELBOW: Controller = Controller::cosine([0.2, 0.7, 1.2], [1.0, 0.43, 1.0], [1.0, 1.0]);
    /// Elbows that blend up to sharper folds.
    pub const ELBOW_2: Controller = Controller::cosine([0.0, 0.6, 0.95], [1.0, 0.55, 1.0], [1.0, 1.0]);
    /// The elbow that the authors tested with.
    pub const TEST_ELBOW: Controller = Controller::cosine([0.1, 0.3, 0.9], [1.0, 0.63, 1.0], [1.0, 1.0]);
    /// Fingers.
    pub const FINGER: Controller = Controller::cosine([-1.0, 0.2, 0.75], [1.0, 0.3, 1.0], [1.0, 1.0]);
    /// Fingers in the paper's form: the blend stays open where the skins face each other.
    pub const FINGER_2: Controller = Controller::Angle {
        at: [0.5 * FRAC_PI_4, 2.0 * FRAC_PI_4, 2.0 * FRAC_PI_4],
        opening: [FRAC_PI_4, 0.4 * FRAC_PI_4, 0.4 * FRAC_PI_4],
        exponents: [0.5, 1.0],
    };
    /// Folds that swell.
    pub const BULGE: Controller = Controller::cosine([-1.05, 0.1, 0.7], [0.0, 0.0, 1.0], [2.9, 0.05]);
    /// Blends where gradients are square to each other, unions both ways from there.
    pub const CAMEL: Controller = Controller::cosine([-3.0, 0.0, 3.0], [1.0, 0.0, 1.0], [-4.0, -4.0]);
    /// The widest blend at any angle.
    pub const BLEND: Controller = Controller::cosine([-1.0, 0.0, 1.0], [0.0; 3], [1.0, 1.0]);

    /// The controllers with a table, in the tables' order.
    const TABLES: [Controller; 8] = [
        Controller::BLEND,
        Controller::ELBOW,
        Controller::ELBOW_2,
        Controller::TEST_ELBOW,
        Controller::FINGER,
        Controller::FINGER_2,
        Controller::BULGE,
        Controller::CAMEL,
    ];

    const fn cosine(at: [f64; 3], share: [f64; 3], exponents: [f64; 2]) -> Controller {
        Controller::Cosine { at, share, exponents }
    }

    /// The opening T at a cosine of the angle between the gradients.
    ///
    /// Openings reach 1 and 0. The authors' own end at tan(.2499 pi) and 1e-5, since their tabulated operators fail at
    /// the ends; closed forms do not.
    pub fn opening(&self, cosine: f64) -> f64 {
        match *self {
            Controller::Angle { at, opening, exponents } => {
                let x = cosine.clamp(-1.0, 1.0).acos();
                between(x, at, opening, |share, i| kappa(share).powf(exponents[i]), [f64::MIN, f64::MAX]).tan()
            }
            Controller::Cosine { at, share, exponents } => {
                let rise = |x: f64, i: usize| {
                    let (k, s) = (kappa(0.8 * x + 0.1), exponents[i]);
                    if s >= 1.0 { k.powf(s) } else { 1.0 - (1.0 - k).powf(2.0 - s) }
                };
                (FRAC_PI_4 * between(cosine.clamp(-1.0, 1.0), at, share, rise, [-1.0, 1.0])).tan()
            }
        }
    }

    /// Where the controller's table begins among the [`curves`].
    pub(super) fn table(&self) -> u32 {
        let index = Controller::TABLES.iter().position(|own| own == self).unwrap_or_default();
        HEAD + STRIDE * index as u32
    }
}

/// A value at `x` of three points joined by steps: `rise` goes from 0 at the middle point to 1 at an end, which is 0 for the
/// first and 1 for the last. A step whose end lies beyond `bounds` is stretched to arrive at the bound.
fn between(x: f64, at: [f64; 3], values: [f64; 3], rise: impl Fn(f64, usize) -> f64, bounds: [f64; 2]) -> f64 {
    let [first, middle, last] = at;
    let (side, end) = if x < middle { (0, first) } else { (1, last) };
    let way = |x: f64| (x - middle) / (end - middle);
    if x <= first || x >= last {
        return values[2 * side];
    }
    let beyond = if side == 0 { end < bounds[0] } else { end > bounds[1] };
    let share = rise(way(x), side) / if beyond { rise(way(bounds[side]), side) } else { 1.0 };
    values[1] + (values[2 * side] - values[1]) * share
}

/// A step from 0 to 1 over 0..=1, infinitely flat at both ends.
fn kappa(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    1.0 - (1.0 - 1.0 / (1.0 - (1.0 - 1.0 / x).exp())).exp()
}

/// What operators read, on both sides: the bulge's control values, then a table of openings for every controller.
pub fn curves() -> &'static [f32] {
    static CURVES: LazyLock<Vec<f32>> = LazyLock::new(|| {
        let table = |controller: &Controller| {
            let at = |i: u32| controller.opening(2.0 * f64::from(i.min(STEPS)) / f64::from(STEPS) - 1.0) as f32;
            (0..STRIDE).map(at).collect::<Vec<f32>>()
        };
        BULGE.into_iter().chain(Controller::TABLES.iter().flat_map(table)).collect()
    });
    &CURVES
}

/// The opening at a cosine, from the table that begins at `table`.
#[inline]
pub(super) fn opening(curves: &[f32], table: u32, cosine: f32) -> f32 {
    let x = (cosine.clamp(-1.0, 1.0) + 1.0) * (0.5 * STEPS as f32);
    let i = (x as u32).min(STEPS - 1);
    let (low, high) = (curves[(table + i) as usize], curves[(table + i) as usize + 1]);
    low + (high - low) * (x - i as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_values_of_the_background() {
        for (x, expected) in [(0.0, 0.0), (0.25, 0.05105), (0.5, 0.44121), (0.75, 0.92016), (1.0, 1.0)] {
            assert!((kappa(x) - expected).abs() < 1e-5, "kappa({x}) = {}", kappa(x));
        }
        for (degrees, expected) in [
            (0.0, 45.0),
            (30.0, 44.9926),
            (45.0, 41.9364),
            (60.0, 33.5272),
            (75.0, 22.7275),
            (90.0, 18.0),
            (180.0, 18.0),
        ] {
            let angle = |controller: Controller| controller.opening(f64::to_radians(degrees).cos()).atan().to_degrees();
            let found = angle(Controller::FINGER_2);
            assert!((found - expected).abs() < 1e-3, "theta({degrees}) = {found}");
            let other = angle(Controller::FINGER);
            assert!(degrees == 0.0 || (other - expected).abs() > 1e-3, "another form must be seen: {other}");
        }
    }

    #[test]
    fn openings_pass_through_their_points() {
        for controller in Controller::TABLES {
            let Controller::Cosine { at, share, .. } = controller else { continue };
            for (at, share) in at.into_iter().zip(share) {
                let expected = (FRAC_PI_4 * share).tan();
                let found = controller.opening(at.clamp(-1.0, 1.0));
                // The compressed step arrives within 2e-4 of its ends.
                assert!((found - expected).abs() < 1e-3, "{controller:?} at {at}: {found}");
            }
        }
        assert!((Controller::ELBOW.opening(0.45) - Controller::ELBOW.opening(0.2)).abs() > 0.1);
    }

    #[test]
    fn straight_limbs_are_joined_by_the_union_and_elbows_close_on_themselves() {
        for elbow in [Controller::ELBOW, Controller::ELBOW_2, Controller::TEST_ELBOW, Controller::FINGER] {
            assert!(elbow.opening(1.0) > 0.999 && elbow.opening(-1.0) > 0.999, "{elbow:?}");
        }
        assert!(Controller::BULGE.opening(1.0) > 0.999 && Controller::BULGE.opening(-1.0) < 1e-3);
        assert!(Controller::CAMEL.opening(0.0) < 1e-3 && Controller::CAMEL.opening(-1.0) > 0.999);
    }

    #[test]
    fn tables_hold_the_openings() {
        for controller in Controller::TABLES {
            let (table, mut worst, mut jump) = (controller.table(), 0.0f64, 0.0f32);
            for i in 0..=4000 {
                let cosine = f64::from(i) / 2000.0 - 1.0;
                let found = opening(curves(), table, cosine as f32);
                assert!((0.0..=1.0).contains(&found));
                worst = worst.max((f64::from(found) - controller.opening(cosine)).abs());
                let next = opening(curves(), table, cosine as f32 + 5e-4);
                jump = jump.max((next - found).abs());
            }
            // The steepest step, of .35 of the cosine, bends by up to 40 in the cosine's square: / 8 / 128^2.
            assert!(worst < 1e-3, "{controller:?}: {worst}");
            assert!(jump < 0.02, "{controller:?} jumps by {jump}");
        }
        assert_eq!(curves().len() as u32, HEAD + STRIDE * Controller::TABLES.len() as u32);
        let elbow = |cosine| opening(curves(), Controller::ELBOW.table(), cosine);
        assert!((elbow(0.45) - elbow(0.5)).abs() > 1e-3, "a neighbour's value must be seen");
    }
}
