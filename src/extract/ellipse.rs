//! Ellipses in bumps: fitted to a bump's crest, and held near what such a bump would have (background 6.2, prototypes 2).
//!
//! A crest shows less than half of its ellipse. What it does not show comes from priors: the axes' ratio, the chord's
//! direction, and a length of the chord's size.

use super::bump::Bump;
use glam::DVec2;
use nalgebra::{SMatrix, SVector};
use std::f64::consts::PI;

/// Expected ratio of the short axis to the long one, in a limb.
pub const ASPECT: f64 = 0.9;
/// Expected half long axis, in chords from one end of the bump to the other.
pub const HALF_AXIS: f64 = 0.45;
/// How strongly the priors hold.
pub const PRIOR: f64 = 0.3;
/// The prior of the angle and that of the long axis, in those of the ratio.
const PRIORS: [f64; 2] = [0.3, 0.1];
/// The crest is where the curvature is above this share of the way from its least to its most.
const CREST: f64 = 0.4;
/// A crest goes no farther from its tip than one of so many parts of the outline.
const WIDEST: usize = 8;
/// Iterations of the fit.
const ITERATIONS: usize = 30;

/// An ellipse in the plane of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Metres, in the plane's axes.
    pub centre: DVec2,
    /// Direction of its long axis in the plane, radians.
    pub angle: f64,
    /// Half its long axis, metres.
    pub long: f64,
    /// Half its short axis, metres.
    pub short: f64,
    /// Root mean square distance of the crest from it, metres.
    pub rms: f64,
}

/// Centre, angle and the logarithms of the two half axes.
type Parameters = SVector<f64, 5>;

/// Fits an ellipse to a bump's crest: the points around its tip where `curved`, the outline's curvature, is above
/// `CREST` of the way from the bump's least to its most. The tip counts most (paper B: weights decrease along the bump). `aspect` is the expected ratio of
/// the axes.
///
/// Minimises `sum omega (F / |grad F|)² / chord²` and the priors (background 6.2) by Levenberg and Marquardt.
pub fn fit(outline: &[DVec2], curved: &[f64], bump: &Bump, aspect: f64) -> Ellipse {
    let count = outline.len();
    let [begin, tip, end] = [bump.begin, bump.tip, bump.end].map(|k| outline[k]);
    let crest = crest(curved, bump);
    let reach = crest.clone().count() as f64 * 0.5;
    let points: Vec<(DVec2, f64)> = crest
        .map(|k| {
            let away = (k + count - bump.tip) % count;
            let away = away.min(count - away) as f64 / reach.max(1.0);
            (outline[k], (-(away / 0.6).powi(2)).exp().sqrt())
        })
        .collect();
    // The chord of a lone bump has no length: its ends are one.
    let span = begin
        .distance(end)
        .max(outline[crest_end(curved, bump, count - 1)].distance(outline[crest_end(curved, bump, 1)]));
    let along = if begin.distance(end) > 0.5 * span { end - begin } else { (tip - end).perp() };
    let problem = Problem { points, chord: span.max(1e-6), angle: along.to_angle(), aspect };
    let long = HALF_AXIS * problem.chord;
    // Outlines run anticlockwise: inward is on the left of the way from begin to end.
    let centre = tip + DVec2::from_angle(problem.angle).perp() * (aspect * long);
    let start = Parameters::new(centre.x, centre.y, problem.angle, long.ln(), (aspect * long).ln());
    let found = problem.solve(start);
    let (long, short) = (found[3].exp(), found[4].exp());
    let (long, short, angle) = if long >= short { (long, short, found[2]) } else { (short, long, found[2] + 0.5 * PI) };
    Ellipse {
        centre: DVec2::new(found[0], found[1]),
        angle: angle.rem_euclid(PI),
        long,
        short,
        rms: problem.rms(&found),
    }
}

/// The crest's points, anticlockwise.
fn crest(curved: &[f64], bump: &Bump) -> impl Iterator<Item = usize> + Clone {
    let count = curved.len();
    let first = crest_end(curved, bump, count - 1);
    let span = (crest_end(curved, bump, 1) + count - first) % count;
    (0..=span).map(move |k| (first + k) % count)
}

/// The last point of the crest in steps of 1, or of one less than a round: at least two from the tip.
fn crest_end(curved: &[f64], bump: &Bump, step: usize) -> usize {
    let count = curved.len();
    let low = if step == 1 { bump.end } else { bump.begin };
    let most = match (low + count - bump.tip) % count {
        0 => count / 2,
        on if step == 1 => on,
        on => count - on,
    };
    let most = most.min(count / WIDEST);
    let least = (1..=most).map(|k| curved[(bump.tip + k * step) % count]).fold(curved[bump.tip], f64::min);
    let bent = least + CREST * (curved[bump.tip] - least);
    let run = (1..=most).take_while(|k| curved[(bump.tip + k * step) % count] >= bent).count().max(2);
    (bump.tip + run * step) % count
}

struct Problem {
    /// Points and the square roots of their weights.
    points: Vec<(DVec2, f64)>,
    chord: f64,
    angle: f64,
    aspect: f64,
}

impl Problem {
    /// Distance from the ellipse to first order.
    fn distance(x: &Parameters, p: DVec2) -> f64 {
        let (long, short) = (x[3].exp(), x[4].exp());
        let own = DVec2::from_angle(-x[2]).rotate(p - DVec2::new(x[0], x[1]));
        let value = (own.x / long).powi(2) + (own.y / short).powi(2) - 1.0;
        let slope = 2.0 * DVec2::new(own.x / (long * long), own.y / (short * short)).length();
        value / slope.max(1e-9)
    }

    fn residuals(&self, x: &Parameters) -> Vec<f64> {
        let total = self.points.iter().map(|(_, w)| w * w).sum::<f64>().sqrt();
        let far = self.points.iter().map(|(p, w)| w / total * Self::distance(x, *p) / self.chord);
        let mut turn = (x[2] - self.angle).rem_euclid(PI);
        if turn > 0.5 * PI {
            turn -= PI;
        }
        let priors = [
            PRIOR * (x[4] - x[3] - self.aspect.ln()),
            PRIOR * PRIORS[0] * turn,
            PRIOR * PRIORS[1] * (x[3] - (HALF_AXIS * self.chord).ln()),
        ];
        far.chain(priors).collect()
    }

    fn rms(&self, x: &Parameters) -> f64 {
        let sum: f64 = self.points.iter().map(|(p, _)| Self::distance(x, *p).powi(2)).sum();
        (sum / self.points.len() as f64).sqrt()
    }

    fn solve(&self, start: Parameters) -> Parameters {
        let size = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
        let steps = Parameters::new(1e-4 * self.chord, 1e-4 * self.chord, 1e-4, 1e-4, 1e-4);
        let (mut x, mut damping) = (start, 1e-3);
        let mut now = self.residuals(&x);
        for _ in 0..ITERATIONS {
            let columns: Vec<Vec<f64>> = (0..5)
                .map(|k| {
                    let mut step = Parameters::zeros();
                    step[k] = steps[k];
                    let (more, less) = (self.residuals(&(x + step)), self.residuals(&(x - step)));
                    more.iter().zip(&less).map(|(a, b)| (a - b) / (2.0 * steps[k])).collect()
                })
                .collect();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let mut normal = SMatrix::<f64, 5, 5>::from_fn(|r, c| dot(&columns[r], &columns[c]));
            let slope = Parameters::from_fn(|r, _| dot(&columns[r], &now));
            (0..5).for_each(|k| normal[(k, k)] *= 1.0 + damping);
            let Some(change) = normal.lu().solve(&slope) else { break };
            let next = x - change;
            let after = self.residuals(&next);
            if size(&after) < size(&now) {
                let gained = size(&now) - size(&after);
                (x, damping) = (next, damping * 0.3);
                now = after;
                if gained < 1e-12 {
                    break;
                }
            } else {
                damping *= 10.0;
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::super::{bump::detect, outline};
    use super::*;
    use std::f64::consts::TAU;

    /// A round limb with one round muscle half out of it.
    fn limb(muscle: DVec2, radius: f64) -> Vec<DVec2> {
        let far = |angle: f64| {
            let way = DVec2::from_angle(angle);
            let (along, off) = (way.dot(muscle), way.perp_dot(muscle));
            let out = if off.abs() < radius { along + (radius * radius - off * off).sqrt() } else { 0.0 };
            // A smooth maximum: skin does not follow the crease.
            let (a, b) = (0.036, out);
            let h = (0.5 + 0.5 * (a - b) / 0.004).clamp(0.0, 1.0);
            way * (b + (a - b) * h + 0.004 * h * (1.0 - h))
        };
        let dense: Vec<DVec2> = (0..720).map(|k| far(TAU * f64::from(k) / 720.0)).collect();
        outline::resample(&dense, 96)
    }

    #[test]
    fn a_muscles_centre_is_found_from_its_crest() {
        for (away, radius) in [(0.024, 0.019), (0.026, 0.016), (0.022, 0.020)] {
            let muscle = DVec2::from_angle(0.7) * away;
            let raw = limb(muscle, radius);
            let smoothed = outline::smooth(&raw, 0.025 * outline::perimeter(&raw));
            let bumps = detect(&smoothed).expect("simple");
            let tip = |b: &&super::Bump| (smoothed[b.tip].to_angle() - 0.7).abs() < 0.2;
            let bump = bumps.iter().find(tip).expect("the muscle's bump");
            let ellipse = fit(&raw, &outline::curvature(&smoothed), bump, ASPECT);
            let off = ellipse.centre.distance(muscle);
            println!("muscle {away} {radius}: off {off:.4} {ellipse:?}");
            assert!(off < 0.005, "{off}");
            assert!(ellipse.rms < 0.001 && ellipse.short <= ellipse.long);
        }
    }
}
