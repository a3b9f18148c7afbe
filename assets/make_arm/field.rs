//! The skin as the zero set of one function: bones, muscles, fat and a hand, smoothly united.

use crate::{
    hand::Hand,
    muscles::{self, Sweep},
    skeleton::{Frame, Skeleton},
};
use glam::DVec3;

/// Skin and fat over the arm's muscles, metres.
const SKIN: f64 = 0.0022;
/// How far neighbouring muscles run into each other, metres.
const ARM_BLEND: f64 = 0.0032;
/// The same for the bones and pads of the palm.
const PALM_BLEND: f64 = 0.0034;
/// The same for the pieces of a finger.
const FINGER_BLEND: f64 = 0.0014;
/// The same between arm, palm and fingers.
const UNION_BLEND: f64 = 0.0022;

/// How far past the wrist the arm's pieces, and how far before it the hand's, can shape the skin, metres.
const REACH: f64 = 0.08;

/// Which digits a point of the skin can see, so that neighbouring fingers do not capture each other's skin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// Arm and palm alone.
    None,
    /// Arm, palm and these digits: bit 0 is the thumb, bits 1 to 4 the index to the little finger.
    Some(u8),
}

impl Digits {
    /// Every digit.
    pub const ALL: Digits = Digits::Some(0b11111);

    fn has(self, digit: usize) -> bool {
        matches!(self, Digits::Some(bits) if bits >> digit & 1 == 1)
    }
}

/// A round bar whose radius changes evenly.
#[derive(Clone, Copy, Debug)]
pub struct Bar {
    a: DVec3,
    b: DVec3,
    radii: (f64, f64),
}

impl Bar {
    /// A bar between two points.
    pub fn new(a: DVec3, b: DVec3, radii: (f64, f64)) -> Bar {
        Bar { a, b, radii }
    }

    /// A ball.
    pub fn ball(centre: DVec3, radius: f64) -> Bar {
        Bar::new(centre, centre, (radius, radius))
    }

    /// Distance to the bar's surface, negative inside.
    pub fn distance(&self, point: DVec3) -> f64 {
        let along = self.b - self.a;
        let square = along.length_squared();
        let t = if square > 0.0 { ((point - self.a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
        point.distance(self.a + along * t) - (self.radii.0 + (self.radii.1 - self.radii.0) * t)
    }
}

/// Bars end to end, with nothing added where they meet.
struct Tissue(Vec<Bar>);

impl Tissue {
    /// Bars through points that are given in bones' spaces, with their radii.
    fn new(points: &[(&Frame, [f64; 3], f64)]) -> Tissue {
        let at = |i: usize| points[i].0.point(DVec3::from(points[i].1));
        Tissue((1..points.len()).map(|i| Bar::new(at(i - 1), at(i), (points[i - 1].2, points[i].2))).collect())
    }

    fn distance(&self, point: DVec3) -> f64 {
        self.0.iter().map(|b| b.distance(point)).fold(f64::INFINITY, f64::min)
    }
}

/// Smooth minimum of any number of distances: the same whatever their order.
pub fn smooth_min(distances: impl Iterator<Item = f64> + Clone, blend: f64) -> f64 {
    let least = distances.clone().fold(f64::INFINITY, f64::min);
    let sum: f64 = distances.map(|d| ((least - d) / blend).exp()).sum();
    least - blend * sum.ln()
}

/// The skin of the arm in the bind pose.
pub struct Skin {
    core: Vec<Tissue>,
    sweeps: Vec<Sweep>,
    wrist: Frame,
    /// The hand's pieces.
    pub hand: Hand,
}

impl Skin {
    /// The skin over the bones and muscles of `skeleton`.
    pub fn new(skeleton: &Skeleton) -> Skin {
        let mut sweeps: Vec<Sweep> = muscles::all().iter().map(|m| m.sweep(skeleton)).collect();
        sweeps.extend(deltoid(&skeleton.upperarm));
        Skin { core: core(skeleton), sweeps, wrist: skeleton.hand, hand: Hand::new(&skeleton.hand) }
    }

    /// Roughly the distance to the skin, metres, negative inside.
    ///
    /// Pieces farther than [`REACH`] past the wrist are left out: they would add less than a nanometre.
    pub fn distance(&self, point: DVec3, digits: Digits) -> f64 {
        let past_wrist = self.wrist.local(point).y;
        let mut parts = [f64::INFINITY; 7];
        if past_wrist < REACH {
            let core = self.core.iter().map(|b| b.distance(point));
            let sweeps = self.sweeps.iter().map(|s| s.distance(point));
            parts[5] = smooth_min(core.chain(sweeps), ARM_BLEND) - SKIN;
        }
        if past_wrist > -REACH {
            parts[6] = smooth_min(self.hand.palm.iter().map(|b| b.distance(point)), PALM_BLEND);
            for (part, (i, digit)) in parts.iter_mut().zip(self.hand.digits.iter().enumerate()) {
                if digits.has(i) {
                    *part = smooth_min(digit.bars.iter().map(|b| b.distance(point)), FINGER_BLEND);
                }
            }
        }
        smooth_min(parts.into_iter(), UNION_BLEND)
    }

    /// Gradient of [`Skin::distance`], by central differences.
    pub fn gradient(&self, point: DVec3, digits: Digits) -> DVec3 {
        let h = 1e-5;
        let slope =
            |e: DVec3| (self.distance(point + e * h, digits) - self.distance(point - e * h, digits)) / (2.0 * h);
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
    }

    /// Where a ray from inside first leaves the skin.
    pub fn cast(&self, from: DVec3, direction: DVec3, digits: Digits) -> DVec3 {
        let inside = |t: f64| self.distance(from + direction * t, digits) < 0.0;
        let step = 0.002;
        let mut near = 0.0;
        while near < 0.15 && inside(near + step) {
            near += step;
        }
        let mut far = near + step;
        for _ in 0..40 {
            let middle = 0.5 * (near + far);
            if inside(middle) {
                near = middle;
            } else {
                far = middle;
            }
        }
        from + direction * near
    }

    /// One Newton step towards the skin along a gradient taken nearby.
    pub fn approach(&self, point: DVec3, gradient: DVec3, digits: Digits) -> DVec3 {
        let step = gradient * (self.distance(point, digits) / gradient.length_squared().max(0.05));
        point - step.clamp_length_max(0.003)
    }
}

/// Bones and the deep tissue around them.
fn core(skeleton: &Skeleton) -> Vec<Tissue> {
    let (upper, lower, hand) = (&skeleton.upperarm, &skeleton.lowerarm, &skeleton.hand);
    let ball = |frame: &Frame, centre, radius| Tissue::new(&[(frame, centre, radius), (frame, centre, radius)]);
    vec![
        // The shoulder's ball.
        ball(upper, [0.002, 0.002, 0.000], 0.0470),
        // Deep tissue round the humerus, wider than deep.
        Tissue::new(&[
            (upper, [0.014, 0.03, 0.002], 0.0385),
            (upper, [0.010, 0.15, 0.0], 0.0315),
            (upper, [0.010, 0.28, -0.001], 0.0270),
        ]),
        Tissue::new(&[
            (upper, [-0.006, 0.03, 0.0], 0.0385),
            (upper, [-0.011, 0.15, 0.0], 0.0310),
            (upper, [-0.010, 0.28, -0.001], 0.0270),
        ]),
        // The epicondyles on either side of the elbow, and the olecranon behind it.
        ball(upper, [0.0270, 0.286, -0.004], 0.0115),
        ball(upper, [-0.0260, 0.288, -0.004], 0.0110),
        Tissue::new(&[(lower, [0.002, -0.010, -0.0200], 0.0130), (lower, [0.004, 0.04, -0.0185], 0.0110)]),
        // Deep tissue of the forearm.
        Tissue::new(&[
            (lower, [0.009, 0.0, 0.0], 0.0290),
            (lower, [0.006, 0.10, 0.0], 0.0275),
            (lower, [0.0, 0.19, 0.0], 0.0190),
            (hand, [0.0, 0.01, 0.0005], 0.0150),
        ]),
        Tissue::new(&[(lower, [-0.009, 0.0, 0.0], 0.0290), (lower, [-0.006, 0.10, 0.0], 0.0270)]),
        // Ulna and radius, which cross with the hand's turn, and the ulna's styloid process.
        Tissue::new(&[(lower, [0.006, 0.02, -0.012], 0.0180), (hand, [0.0145, -0.006, -0.0015], 0.0115)]),
        Tissue::new(&[(lower, [-0.006, 0.06, 0.004], 0.0180), (hand, [-0.0130, -0.004, 0.0], 0.0140)]),
        ball(hand, [0.0170, -0.012, -0.0085], 0.0062),
    ]
}

/// The deltoid's three heads. Both ends are on the upper arm, so it never changes and is not in the muscle file.
fn deltoid(upper: &Frame) -> Vec<Sweep> {
    let v = DVec3::new;
    let heads = [
        (v(0.008, -0.034, 0.024), v(-0.022, 0.180, 0.013), v(1.0, 0.0, 0.8), 0.0300),
        (v(-0.022, -0.036, 0.000), v(-0.026, 0.185, 0.000), v(0.0, 0.0, 1.0), 0.0350),
        (v(0.006, -0.034, -0.024), v(-0.022, 0.180, -0.013), v(1.0, 0.0, -0.8), 0.0310),
    ];
    heads
        .into_iter()
        .map(|(origin, insertion, long, width)| {
            let ends = [upper.point(origin), upper.point(insertion)];
            Sweep::new(ends, upper.rotation * long, (2.0, 3.0), 0.4, width)
        })
        .collect()
}
