//! Numbers and shapes over time.

use crate::rig::Key;
use crate::rig::muscle::{Curve, Ease, ShapeCurve};

/// Where a time falls among keys.
enum Moment {
    /// On this key, or held there.
    At(usize),
    /// Between this key and the next: share of the way in 0..1.
    Between(usize, f64),
}

/// Of equal key times the last counts; before the first and after the last key, and for a time that is no number, the
/// nearest key is held. `keys` is at least 1 and at most the length of `times`.
fn moment(times: &[f32], keys: usize, ease: Ease, time: f32) -> Moment {
    let times = &times[..keys];
    let after = times.partition_point(|&key| key <= time);
    let Some(key) = after.checked_sub(1) else { return Moment::At(0) };
    match times.get(after) {
        Some(&next) if times[key] < time && ease != Ease::Step => {
            let (from, to) = (f64::from(times[key]), f64::from(next));
            let share = (f64::from(time) - from) / (to - from);
            // Keys at infinity have no share of the way between them, and only ascending keys one in 0..1.
            if share.is_finite() { Moment::Between(key, share.clamp(0.0, 1.0)) } else { Moment::At(key) }
        }
        _ => Moment::At(key),
    }
}

impl Curve {
    /// The value at `time`, in the curve's own seconds; `None` where there are no keys.
    ///
    /// Held before the first and after the last key; of keys at the same time the last counts. Cubic curves are
    /// Hermite's with the given slopes, and Catmull-Rom's where there is not one pair of slopes per key: the slope
    /// between the two neighbours, and towards the only one at either end and beside keys at equal times.
    pub fn at(&self, time: f32) -> Option<f32> {
        let keys = self.times.len().min(self.values.len());
        if keys == 0 {
            return None;
        }
        let value = |key: usize| f64::from(self.values[key]);
        Some(match moment(&self.times, keys, self.ease, time) {
            Moment::At(key) => self.values[key],
            Moment::Between(key, share) if self.ease == Ease::Cubic => {
                let seconds = self.seconds(key, key + 1);
                let (out, into) = (self.slope(keys, key, 1), self.slope(keys, key + 1, 0));
                hermite([value(key), out, into, value(key + 1)], share, seconds) as f32
            }
            Moment::Between(key, share) => (value(key) + (value(key + 1) - value(key)) * share) as f32,
        })
    }

    fn seconds(&self, from: usize, to: usize) -> f64 {
        f64::from(self.times[to]) - f64::from(self.times[from])
    }

    /// Slope at a key per second: into it (`side` 0) or out of it (1).
    fn slope(&self, keys: usize, key: usize, side: usize) -> f64 {
        if self.tangents.len() >= keys {
            return f64::from(self.tangents[key][side]);
        }
        let apart = |from: usize| self.times[from] < self.times[from + 1];
        let before = if key > 0 && (side == 0 || apart(key - 1)) { key - 1 } else { key };
        let after = if key + 1 < keys && (side == 1 || apart(key)) { key + 1 } else { key };
        let seconds = self.seconds(before, after);
        let rise = f64::from(self.values[after]) - f64::from(self.values[before]);
        if seconds > 0.0 { rise / seconds } else { 0.0 }
    }
}

impl ShapeCurve {
    /// The shape at `time`, in the curve's own seconds, as a [`Key::Shape`]; `None` where there are no keys.
    ///
    /// Held outside the keys as [`Curve::at`] says; cubic curves are read as linear.
    pub fn at(&self, time: f32) -> Option<Key> {
        let keys = self.times.len().min(self.shapes.len());
        if keys == 0 {
            return None;
        }
        let (from, to, share) = match moment(&self.times, keys, self.ease, time) {
            Moment::At(key) => (key, key, 0.0),
            Moment::Between(key, share) => (key, key + 1, share as f32),
        };
        Some(Key::Shape { from: self.shapes[from], to: self.shapes[to], share })
    }
}

/// A value and the slope out of it, the slope into the next value and that value; `t` of the way between them.
fn hermite([value_0, out_0, in_1, value_1]: [f64; 4], t: f64, seconds: f64) -> f64 {
    let (t2, t3) = (t * t, t * t * t);
    value_0 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + out_0 * (seconds * (t3 - 2.0 * t2 + t))
        + value_1 * (-2.0 * t3 + 3.0 * t2)
        + in_1 * (seconds * (t3 - t2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn curve(ease: Ease, keys: &[(f32, f32)]) -> Curve {
        let (times, values) = keys.iter().copied().unzip();
        Curve { ease, times, values, tangents: Vec::new() }
    }

    #[test]
    fn straight_and_held_curves_against_hand_values() {
        let keys = [(1.0, 0.2), (2.0, 0.6), (4.0, 0.0)];
        let linear = curve(Ease::Linear, &keys);
        let step = curve(Ease::Step, &keys);
        for (time, straight, held) in
            [(0.0, 0.2, 0.2), (1.0, 0.2, 0.2), (1.25, 0.3, 0.2), (2.0, 0.6, 0.6), (3.0, 0.3, 0.6), (9.0, 0.0, 0.0)]
        {
            let (a, b) = (linear.at(time).expect("keys"), step.at(time).expect("keys"));
            // Values of order 1, rounded once.
            assert!((a - straight).abs() < 1e-7 && (b - held).abs() < 1e-7, "{time}: {a} {b}");
        }
        assert_ne!(linear.at(1.25), step.at(1.25));
        assert_eq!(Curve::default().at(0.0), None);
        assert_eq!(curve(Ease::Cubic, &[(3.0, 0.7)]).at(5.0), Some(0.7));
        assert_eq!(linear.at(f32::NAN), Some(0.2));
        assert_eq!(linear.at(f32::INFINITY), Some(0.0));
        assert_eq!(curve(Ease::Linear, &[(f32::NEG_INFINITY, 0.1), (f32::INFINITY, 0.9)]).at(0.0), Some(0.1));
        // A list that is shorter than the other ends the keys.
        assert_eq!(Curve { times: vec![0.0, 1.0], values: vec![0.5], ..Curve::default() }.at(0.7), Some(0.5));
    }

    #[test]
    fn of_keys_at_one_time_the_last_counts() {
        for ease in [Ease::Linear, Ease::Step, Ease::Cubic] {
            let jump = curve(ease, &[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0)]);
            let at = |time| jump.at(time).expect("keys");
            assert_eq!((at(0.5), at(1.0), at(1.5)), (0.0, 1.0, 1.0), "{ease:?}");
        }
        // Without the second key at 1 s a Catmull-Rom curve would not be flat on either side.
        let smooth = curve(Ease::Cubic, &[(0.0, 0.0), (1.0, 0.0), (1.1, 1.0), (2.0, 1.0)]);
        assert_ne!(smooth.at(0.5), Some(0.0));
    }

    #[test]
    fn cubic_curves_follow_their_slopes() {
        // Appendix C of glTF 2.0 half way: (v0 + v1) / 2 + seconds (out0 - in1) / 8; a quarter: 27/32, 9/64, 5/32, -3/64.
        let mut given = curve(Ease::Cubic, &[(1.0, 0.0), (3.0, 1.0)]);
        given.tangents = vec![[9.0, 2.0], [-4.0, 9.0]];
        assert_eq!(given.at(2.0), Some(0.5 + 2.0 * 6.0 / 8.0));
        assert_eq!(given.at(1.5), Some(2.0 * 2.0 * 9.0 / 64.0 + 5.0 / 32.0 + 2.0 * 4.0 * 3.0 / 64.0));
        given.tangents[0][1] = 1.0;
        assert_ne!(given.at(2.0), Some(2.0));
        // Catmull-Rom goes through a parabola's points as the parabola, where both neighbours are there.
        let parabola = curve(Ease::Cubic, &[(0.0, 0.0), (1.0, 1.0), (2.0, 4.0), (3.0, 9.0)]);
        assert_eq!(parabola.at(1.5), Some(2.25));
        // In the first interval the end's slope is the straight one: 0.5 + (1 - 2) / 8.
        assert_eq!(parabola.at(0.5), Some(0.375));
        assert_ne!(curve(Ease::Linear, &[(1.0, 1.0), (2.0, 4.0)]).at(1.5), Some(2.25));
    }

    #[test]
    fn shapes_are_on_the_way_from_pair_to_pair() {
        let mut shapes = ShapeCurve { ease: Ease::Linear, times: vec![0.0, 2.0], shapes: vec![(3, 3), (4, 7)] };
        let key = |from, to, share| Some(Key::Shape { from, to, share });
        assert_eq!(shapes.at(-1.0), key((3, 3), (3, 3), 0.0));
        assert_eq!(shapes.at(0.5), key((3, 3), (4, 7), 0.25));
        assert_eq!(shapes.at(2.0), key((4, 7), (4, 7), 0.0));
        shapes.ease = Ease::Step;
        assert_eq!(shapes.at(0.5), key((3, 3), (3, 3), 0.0));
        assert_eq!(ShapeCurve::default().at(0.0), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn any_keys_are_read(
            times in prop::collection::vec(any::<f32>(), 0..6),
            values in prop::collection::vec(any::<f32>(), 0..6),
            slopes in prop::collection::vec(any::<[f32; 2]>(), 0..6),
            time in any::<f32>(),
        ) {
            for ease in [Ease::Linear, Ease::Step, Ease::Cubic] {
                let curve = Curve { ease, times: times.clone(), values: values.clone(), tangents: slopes.clone() };
                prop_assert_eq!(curve.at(time).is_some(), !times.is_empty() && !values.is_empty());
                let shapes = values.iter().map(|_| (3, 3)).collect();
                let _ = ShapeCurve { ease, times: times.clone(), shapes }.at(time);
            }
        }

        #[test]
        fn straight_curves_stay_between_their_keys(
            mut times in prop::collection::vec(-1e3f32..1e3, 1..8),
            values in prop::collection::vec(0.0f32..=1.0, 8),
            time in -2e3f32..2e3,
        ) {
            times.sort_by(f32::total_cmp);
            let curve = Curve { ease: Ease::Linear, times, values, tangents: Vec::new() };
            let value = curve.at(time).expect("keys");
            prop_assert!((0.0..=1.0).contains(&value), "{}", value);
        }
    }
}
