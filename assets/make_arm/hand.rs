//! The hand: a palm of pads and metacarpals, four relaxed fingers and a thumb.

use crate::{
    field::Bar,
    mesh::JOINT_ROWS,
    skeleton::{Chain, Frame},
};
use glam::{DQuat, DVec3, EulerRot};

/// One finger or the thumb.
pub struct Digit {
    /// The line through its phalanges.
    pub chain: Chain,
    lengths: [f64; 3],
    /// Its flesh.
    pub bars: Vec<Bar>,
    /// Where its first own ring lies on the chain, metres.
    pub first_ring: f64,
}

/// Pieces of the hand, scene space.
pub struct Hand {
    /// Palm, metacarpals and pads.
    pub palm: Vec<Bar>,
    /// Thumb, index, middle, ring and little finger.
    pub digits: [Digit; 5],
}

/// Measures of a digit in the hand's space; angles in degrees.
struct Measure {
    base: [f64; 3],
    /// Turn of the first phalanx about the hand's X (flexion), Y (roll) and Z (spread).
    turn: [f64; 3],
    lengths: [f64; 3],
    /// Flexion of the two outer joints.
    flexion: [f64; 2],
    /// Radii at the base, the two joints and the tip.
    radii: [f64; 4],
    first_ring: f64,
}

const MEASURES: [Measure; 5] = [
    Measure {
        base: [-0.0230, 0.0300, 0.0120],
        turn: [28.0, 62.0, 30.0],
        lengths: [0.032, 0.032, 0.021],
        flexion: [10.0, 18.0],
        radii: [0.0150, 0.0112, 0.0102, 0.0080],
        first_ring: 0.022,
    },
    Measure {
        base: [-0.0270, 0.0870, 0.0000],
        turn: [20.0, 0.0, 3.0],
        lengths: [0.043, 0.026, 0.018],
        flexion: [30.0, 18.0],
        radii: [0.0105, 0.0090, 0.0080, 0.0068],
        first_ring: 0.027,
    },
    Measure {
        base: [-0.0055, 0.0905, -0.0015],
        turn: [25.0, 0.0, 0.5],
        lengths: [0.047, 0.029, 0.019],
        flexion: [34.0, 20.0],
        radii: [0.0107, 0.0092, 0.0081, 0.0069],
        first_ring: 0.027,
    },
    Measure {
        base: [0.0150, 0.0855, -0.0005],
        turn: [30.0, 0.0, -3.0],
        lengths: [0.043, 0.027, 0.019],
        flexion: [36.0, 20.0],
        radii: [0.0102, 0.0087, 0.0077, 0.0065],
        first_ring: 0.026,
    },
    Measure {
        base: [0.0330, 0.0770, 0.0015],
        turn: [34.0, 0.0, -8.0],
        lengths: [0.034, 0.021, 0.017],
        flexion: [36.0, 20.0],
        radii: [0.0092, 0.0077, 0.0068, 0.0058],
        first_ring: 0.024,
    },
];

impl Digit {
    /// How far along the digit a point lies, 0..=1 with the joints at [`JOINT_ROWS`], and the point in the chain's
    /// space there.
    pub fn over(&self, point: DVec3) -> (f64, DVec3) {
        let steps = 400;
        let at = |i: i32| self.chain.length() * f64::from(i) / f64::from(steps);
        let distance = |i: i32| self.chain.frame_at(at(i)).origin.distance_squared(point);
        let nearest = (0..=steps).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
        let local = self.chain.frame_at(at(nearest)).local(point);
        let along = at(nearest) + local.y;
        let rows = [0.0, JOINT_ROWS[0], JOINT_ROWS[1], 1.0];
        // The tip lies a fingertip's radius beyond the end of the chain.
        let [a, b, c] = self.lengths;
        let joints = [0.0, a, a + b, a + b + c + 0.0075];
        let i = if along < joints[1] {
            0
        } else if along < joints[2] {
            1
        } else {
            2
        };
        let share = (along - joints[i]) / (joints[i + 1] - joints[i]);
        ((rows[i] + (rows[i + 1] - rows[i]) * share).clamp(0.0, 1.0), local)
    }

    fn new(hand: &Frame, measure: &Measure) -> Digit {
        let [x, y, z] = measure.turn.map(f64::to_radians);
        let turn = DQuat::from_euler(EulerRot::ZXY, z, x, y);
        let mut frames = vec![hand.child(DVec3::from(measure.base), turn)];
        for i in 0..2 {
            let bend = DQuat::from_rotation_x(measure.flexion[i].to_radians());
            frames.push(frames[i].child(DVec3::Y * measure.lengths[i], bend));
        }
        let mut bars = Vec::new();
        for (i, frame) in frames.iter().enumerate() {
            let (from, to) = (measure.radii[i], measure.radii[i + 1]);
            let length = measure.lengths[i];
            bars.push(Bar::new(frame.origin, frame.point(DVec3::Y * length), (from, to)));
            // The soft pad on the palm's side of every phalanx.
            let pad = frame.point(DVec3::new(0.0, length * 0.50, 0.0022));
            bars.push(Bar::ball(pad, 0.45 * (from + to)));
        }
        let chain = Chain::new(frames, measure.lengths.to_vec(), 0.0075);
        Digit { chain, lengths: measure.lengths, bars, first_ring: measure.first_ring }
    }
}

impl Hand {
    /// The hand of a wrist frame: Y towards the fingers, X to the little finger's side, Z out of the palm.
    pub fn new(hand: &Frame) -> Hand {
        let digits = MEASURES.map(|m| Digit::new(hand, &m));
        let at = |x: f64, y: f64, z: f64| hand.point(DVec3::new(x, y, z));
        let knuckle = |i: usize| DVec3::from(MEASURES[i].base);
        let mut palm = vec![
            // The carpus, in line with ulna and radius.
            Bar::new(at(0.0125, -0.02, -0.001), at(0.0160, 0.03, 0.001), (0.0135, 0.0130)),
            Bar::new(at(-0.0125, -0.02, 0.000), at(-0.0140, 0.03, 0.001), (0.0150, 0.0135)),
            // The ball of the thumb and the heel of the hand.
            Bar::new(
                at(-0.0110, 0.018, 0.008),
                hand.point(knuckle(0) + DVec3::new(-0.004, 0.012, 0.003)),
                (0.0130, 0.0150),
            ),
            Bar::new(at(0.0180, 0.016, 0.007), at(0.0285, 0.055, 0.006), (0.0110, 0.0110)),
            // The fold of skin between thumb and index finger.
            Bar::new(at(-0.0330, 0.046, 0.009), at(-0.0280, 0.070, 0.002), (0.0085, 0.0080)),
            // Padding under the knuckles.
            Bar::new(at(-0.0240, 0.078, 0.006), at(0.0270, 0.070, 0.007), (0.0090, 0.0085)),
        ];
        for i in 1..5 {
            let base = knuckle(i);
            let root = DVec3::new(base.x * 0.55, 0.015, -0.002);
            palm.push(Bar::new(hand.point(root), hand.point(base), (0.0105, MEASURES[i].radii[0] * 0.95)));
        }
        // Webs: the skin between neighbouring fingers reaches almost half along their first phalanges.
        for i in 1..4 {
            let ends = [i, i + 1].map(|j| digits[j].chain.frame_at(0.017).point(DVec3::new(0.0, 0.0, 0.001)));
            palm.push(Bar::new(ends[0], ends[1], (0.0060, 0.0060)));
        }
        Hand { palm, digits }
    }
}
