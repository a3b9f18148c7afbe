//! Paper A's profile for a chain of bumps (prototypes 2): `R_tip(z) = c0 + c1 z + w Phi(s; alpha, beta)`, by trying the
//! exponents and solving for the rest.

use crate::field::muscle::profile::{Profile, ellipse_squared};
use glam::DVec3;
use nalgebra::{Matrix3, Vector3};

/// Exponents that are tried: tips tell sharper ones from a wider belly on a cone no more.
const EXPONENTS: std::ops::RangeInclusive<u32> = 2..=6;

/// Rounds of a primitive's fit, and the steps that each tries for its two ends.
const ROUNDS: usize = 7;
const STEPS: [(f64, f64); 8] =
    [(1.0, 1.0), (-1.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, -1.0), (-1.0, 1.0)];
/// What it counts where a muscle stands out of the skin, squared; and the widths that are tried below the nearest.
const STANDS_OUT: f64 = 3.0;
const NARROWER: [f64; 4] = [1.0, 0.95, 0.9, 0.8];
/// What an end that is moved by all of its play must gain.
const STAY: f64 = 0.1;
/// What a section that is flatter by the whole of [`FLATTER`] must gain: a crest tells little of what is beside it.
const ROUND: f64 = 0.1;
/// Eccentricities that are tried besides the ellipses' own.
const FLATTER: [f32; 4] = [0.6, 0.75, 0.85, 0.9];

/// How far a fit may take a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least and largest width, metres.
    pub width: [f64; 2],
    /// Largest half of the section across its long axis, metres: between skin and bone there is no room for more.
    pub depth: f64,
    /// How far each end may go inward and outward, metres.
    pub play: [[f64; 2]; 2],
    /// Whether the section may become flatter than it is.
    pub flatter: bool,
}

impl Bounds {
    /// Least and largest width of a section of an eccentricity.
    fn width_of(&self, eccentricity: f32) -> [f64; 2] {
        let (short_squared, _) = ellipse_squared(eccentricity);
        let most = self.width[1].min(self.depth / f64::from(short_squared).sqrt());
        [self.width[0].min(most), most]
    }
}

/// What of the limb's outline is the muscle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileFit {
    /// Profile exponent at the origin.
    pub alpha: u32,
    /// Profile exponent at the insertion.
    pub beta: u32,
    /// How far the profile, whose square has the mean 1, carries the tips out, metres.
    pub width: f64,
    /// Where the muscle is thickest, 0..=1.
    pub peak: f64,
    /// Root mean square distance of the tips from the profile, metres.
    pub rms: f64,
}

/// Fits the profile to tips at shares `s` of the muscle's length, `out` metres from the bone. `None` where three unknowns
/// are more than the tips tell, or no profile stands out.
pub fn profile(s: &[f64], out: &[f64]) -> Option<ProfileFit> {
    let mut best: Option<ProfileFit> = None;
    for alpha in EXPONENTS {
        for beta in EXPONENTS {
            let phi: Vec<f64> = s.iter().map(|&s| f64::from(Profile::of(alpha, beta).at(s as f32).0)).collect();
            let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
            for ((&s, &phi), &out) in s.iter().zip(&phi).zip(out) {
                let row = Vector3::new(1.0, s, phi);
                normal += row * row.transpose();
                right += row * out;
            }
            let Some(found) = normal.lu().solve(&right) else { continue };
            let off = |k: usize| found[0] + found[1] * s[k] + found[2] * phi[k] - out[k];
            let rms = ((0..s.len()).map(|k| off(k).powi(2)).sum::<f64>() / s.len() as f64).sqrt();
            if found[2] > 0.0 && best.is_none_or(|b| rms < b.rms) {
                let peak = f64::from(alpha - 1) / f64::from(alpha + beta - 2);
                best = Some(ProfileFit { alpha, beta, width: found[2], peak, rms });
            }
        }
    }
    best
}

/// Paper A's primitive on a straight axis, as far as a skin's crest tells it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primitive {
    /// Ends of its axis, metres in scene space at rest.
    pub ends_rest: [DVec3; 2],
    /// Unit vector along its section's long axis.
    pub normal_rest: DVec3,
    /// Profile exponents.
    pub exponents: (u32, u32),
    /// Eccentricity of its section.
    pub eccentricity: f32,
    /// Its width as muscle files have it: the largest radius that it would have with a round section, metres.
    pub width: f64,
}

impl Primitive {
    /// Distance of a point from the axis, of the surface there for a width of one, and the profile's share
    /// of its most.
    fn at(&self, profile: &Profile, most: f64, p: DVec3) -> (f64, f64, f64) {
        let way = self.ends_rest[1] - self.ends_rest[0];
        let s = ((p - self.ends_rest[0]).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        let out = p - (self.ends_rest[0] + way * s);
        let distance = out.length();
        let cosine = if distance > 0.0 { (out.dot(self.normal_rest) / distance).clamp(-1.0, 1.0) } else { 1.0 };
        let (u, v) = ellipse_squared(self.eccentricity);
        let across = f64::from(u) * cosine * cosine + f64::from(v) * (1.0 - cosine * cosine);
        let thick = f64::from(profile.at(s as f32).0);
        (distance, thick / most / across.sqrt(), thick / most)
    }

    /// Fits its width to a crest of weighted points, and how far its ends lie out along a direction: what is left of paper A's
    /// parameters where exponents and eccentricity are known. Neither goes farther than the crest asks for.
    ///
    /// The tips of a cone tell its exponents to one or so: of those beside them the nearest to the crest are taken. A crest that
    /// is broader than a round section with room under it is a flat muscle's.
    pub fn fit(&mut self, crest: &[(DVec3, f64)], outward: DVec3, bounds: &Bounds) {
        let (alpha, beta) = self.exponents;
        let near = |n: u32| (n - 1).max(*EXPONENTS.start())..=(n + 1).min(*EXPONENTS.end());
        let start = *self;
        let own = start.eccentricity;
        let flatter = FLATTER.into_iter().filter(|&e| bounds.flatter && e > own);
        let mut best = f64::MAX;
        for eccentricity in std::iter::once(own).chain(flatter) {
            let cost = 1.0 + ROUND * f64::from(eccentricity - own) / f64::from(FLATTER[FLATTER.len() - 1]);
            for exponents in near(alpha).flat_map(|a| near(beta).map(move |b| (a, b))) {
                let mut other = Primitive { exponents, eccentricity, ..start };
                other.fit_ends(crest, outward, bounds);
                let off = other.fit_width(crest, bounds.width_of(eccentricity)) * cost;
                if off < best {
                    (best, *self) = (off, other);
                }
            }
        }
    }

    fn fit_ends(&mut self, crest: &[(DVec3, f64)], outward: DVec3, bounds: &Bounds) {
        let (play, bounds) = (bounds.play, bounds.width_of(self.eccentricity));
        let start = self.ends_rest;
        let mut out = [0.0; 2];
        let mut step = 0.5;
        let mut best = self.fit_width(crest, bounds);
        for _ in 0..ROUNDS {
            for (a, b) in STEPS {
                let tried = [out[0] + a * step, out[1] + b * step].map(|x: f64| x.clamp(-1.0, 1.0));
                let mut other = *self;
                let way = |k: usize| tried[k] * play[k][usize::from(tried[k] > 0.0)];
                (0..2).for_each(|k| other.ends_rest[k] = start[k] + outward * way(k));
                let off = other.fit_width(crest, bounds) * (1.0 + STAY * (tried[0] * tried[0] + tried[1] * tried[1]));
                if off < best {
                    (best, out) = (off, tried);
                    (self.ends_rest, self.width) = (other.ends_rest, other.width);
                }
            }
            step *= 0.6;
        }
    }

    /// Takes the width with which its surface is nearest to a crest of weighted points, within `bounds`, metres; returns how far
    /// off it is then, with more weight where it stands out of the skin: skin encloses muscles.
    fn fit_width(&mut self, crest: &[(DVec3, f64)], bounds: [f64; 2]) -> f64 {
        let profile = Profile::of(self.exponents.0, self.exponents.1);
        let most = f64::from(profile.max());
        let at: Vec<(f64, f64, f64)> = crest
            .iter()
            .map(|(p, weight)| {
                let (distance, unit, belly) = self.at(&profile, most, *p);
                (distance, unit, weight * belly)
            })
            .collect();
        let (mut both, mut own, mut total) = (0.0, 0.0, 0.0);
        for (distance, unit, weight) in &at {
            both += weight * distance * unit;
            own += weight * unit * unit;
            total += weight;
        }
        let middle = if own > 0.0 { (both / own).clamp(bounds[0], bounds[1]) } else { bounds[0] };
        let off = |width: f64| {
            let one = |(distance, unit, weight): &(f64, f64, f64)| {
                let out = width * unit - distance;
                weight * out * out * if out > 0.0 { STANDS_OUT } else { 1.0 }
            };
            (at.iter().map(one).sum::<f64>() / total.max(1e-12)).sqrt()
        };
        let tried = NARROWER.map(|share| (share * middle).max(bounds[0])).map(|width| (off(width), width));
        let best = tried.into_iter().fold((f64::MAX, middle), |best, one| if one.0 < best.0 { one } else { best });
        self.width = best.1;
        best.0
    }

    /// How far a crest of weighted points is from its surface, root mean square, metres. Points count by how thick the muscle is
    /// beside them: where it thins out to a tendon, skin lies on something else.
    pub fn off(&self, crest: &[(DVec3, f64)]) -> f64 {
        let profile = Profile::of(self.exponents.0, self.exponents.1);
        let most = f64::from(profile.max());
        let (mut sum, mut total) = (0.0, 0.0);
        for (p, weight) in crest {
            let (distance, unit, belly) = self.at(&profile, most, *p);
            sum += weight * belly * (distance - self.width * unit).powi(2);
            total += weight * belly;
        }
        (sum / total.max(1e-12)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_on_a_cone_is_found_again() {
        for (alpha, beta) in [(3, 3), (4, 6), (2, 5)] {
            let s: Vec<f64> = (0..15).map(|k| f64::from(k) / 14.0).collect();
            let out: Vec<f64> = s
                .iter()
                .map(|&s| 0.04 - 0.01 * s + 0.012 * f64::from(Profile::of(alpha, beta).at(s as f32).0))
                .collect();
            let found = profile(&s, &out).expect("a profile");
            assert_eq!((found.alpha, found.beta), (alpha, beta));
            assert!((found.width - 0.012).abs() < 1e-5 && found.rms < 1e-6, "{found:?}");
        }
        assert!(profile(&[0.0, 0.25, 0.5, 0.75, 1.0], &[0.03, 0.02, 0.01, 0.02, 0.03]).is_none(), "a hollow");
    }

    #[test]
    fn a_primitive_is_found_again_from_its_crest() {
        let known = Primitive {
            ends_rest: [DVec3::new(0.0, 0.0, 0.02), DVec3::new(0.3, 0.0, 0.02)],
            normal_rest: DVec3::Y,
            exponents: (3, 4),
            eccentricity: 0.8,
            width: 0.02,
        };
        let profile = Profile::of(3, 4);
        let crest: Vec<(DVec3, f64)> = (3..28)
            .flat_map(|k| [-0.4_f64, 0.0, 0.4].map(|angle| (f64::from(k) / 30.0, angle)))
            .map(|(s, angle)| {
                let way = DVec3::new(0.0, angle.sin(), angle.cos());
                let on_axis = known.ends_rest[0].lerp(known.ends_rest[1], s);
                let (_, unit, _) = known.at(&profile, f64::from(profile.max()), on_axis + way * 1e-3);
                (on_axis + way * (unit * known.width), 1.0)
            })
            .collect();
        assert!(known.off(&crest) < 1e-6);
        let ends_rest = known.ends_rest.map(|p| p - DVec3::Z * 0.005);
        let mut found = Primitive { ends_rest, exponents: (3, 3), width: 0.01, ..known };
        let before = found.off(&crest);
        let bounds = Bounds { width: [0.005, 0.04], depth: 0.04, play: [[0.01; 2]; 2], flatter: false };
        found.fit(&crest, DVec3::Z, &bounds);
        assert!(before > 0.005 && found.off(&crest) < 0.0007, "{before} {}", found.off(&crest));
        assert!(found.exponents == (3, 4) && (found.width - 0.02).abs() < 0.002, "{found:?}");
    }
}
