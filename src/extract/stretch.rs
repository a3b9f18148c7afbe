//! Stretches over which chains stand out, and what part of the trunk is there.
//!
//! Over a trunk or a thigh a broad muscle hardly rises along its length: what tells it is that it stands out across it, by direct
//! variation.

use super::{
    body::Body,
    chain::{Belly, Link, Section, roots, without_strays},
    trunk::Sweep,
};
use crate::rig::groups::Side;
use glam::DVec3;

/// A stretch ends where its bumps stand out by less than this share of what they do on either side.
const VALLEY: f64 = 0.35;
/// Least length of a muscle, in heights of the trunk.
const LEAST_LENGTH: f64 = 0.12;
/// Fewest sections of a muscle: planes over the trunk are close.
const FEWEST: usize = 8;
/// Height of the hip's crest over the hips, in heights of the trunk.
const CREST: f64 = 0.21;
/// Nearer to the middle of the body than this, in half shoulder widths, is bone, cartilage or the navel: muscles come in pairs.
const MIDDLE: f64 = 0.06;
/// Sections before and after one over which it is averaged.
const AROUND: usize = 1;

/// The stretches of a chain over a trunk that are long enough, in its order.
pub fn stretches(sections: &[Section], chain: &[Link], sweep: Sweep, body: &Body) -> Vec<Belly> {
    let bone = match sweep {
        // The acromion parts the trapezius from the deltoid.
        Sweep::Shoulder(side) => Some(body.shoulders_rest[usize::from(side == Side::Right)]),
        // The hip's crest parts what is on the hip from the oblique.
        Sweep::Abdomen => Some(body.hip_rest() + body.up * (CREST * body.height())),
        _ => None,
    };
    let found = parted(sections, chain, bone.and_then(|bone| before(sections, chain, bone)));
    found.into_iter().filter(|belly| belly.length > LEAST_LENGTH * body.height()).collect()
}

/// The stretches of a chain, cut where it hardly stands out, and at another place where that is known.
pub fn parted(sections: &[Section], chain: &[Link], at: Option<usize>) -> Vec<Belly> {
    let out: Vec<f64> = (0..chain.len())
        .map(|k| {
            let around = &chain[k.saturating_sub(AROUND)..(k + AROUND + 1).min(chain.len())];
            around.iter().map(|l| sections[l.section].bumps[l.bump].prominence).sum::<f64>() / around.len() as f64
        })
        .collect();
    let mut cuts = vec![0];
    cuts.extend(split(&out));
    cuts.extend(at);
    cuts.push(chain.len());
    cuts.sort_unstable();
    cuts.dedup();
    let pieces = cuts.windows(2).map(|w| &chain[w[0]..w[1]]);
    pieces.filter(|piece| piece.len() >= FEWEST).map(|piece| stretch(sections, piece)).collect()
}

/// Where a chain hardly stands out between two parts that do.
fn split(out: &[f64]) -> Vec<usize> {
    let most = |range: &[f64]| range.iter().copied().fold(0.0, f64::max);
    let mut open = Vec::from([(0, out.len())]);
    let mut cuts = Vec::new();
    while let Some((start, end)) = open.pop() {
        // The deepest place that has something higher on both sides.
        let inner = start + 1..end.saturating_sub(1);
        let is_valley = |&k: &usize| out[k] < VALLEY * most(&out[start..k]).min(most(&out[k + 1..end]));
        let valleys: Vec<usize> = inner.filter(is_valley).collect();
        let Some(&at) = valleys.iter().min_by(|&&a, &&b| out[a].total_cmp(&out[b])) else { continue };
        cuts.push(at);
        open.push((start, at));
        open.push((at, end));
    }
    cuts
}

/// How many of a chain's planes are before a bone's place, where some are and some are not.
fn before(sections: &[Section], chain: &[Link], bone: DVec3) -> Option<usize> {
    let before = |l: &&Link| {
        let plane = &sections[l.section].plane;
        (bone - plane.origin_rest).dot(plane.normal()) > 1e-9
    };
    let at = chain.iter().take_while(before).count();
    (at > 0 && at < chain.len()).then_some(at)
}

/// One stretch, as it is.
pub fn stretch(sections: &[Section], piece: &[Link]) -> Belly {
    let links = without_strays(sections, piece);
    let (roots_rest, stray) = roots(sections, &links);
    let mean = |of: &dyn Fn(&Link) -> f64| links.iter().map(of).sum::<f64>() / links.len() as f64;
    let tip = |l: &Link| sections[l.section].tip_rest(l.bump);
    let (a, b) = (tip(&links[0]), tip(&links[links.len() - 1]));
    let height = |l: &Link| {
        let off = (tip(l) - a).reject_from(b - a);
        off.dot(sections[l.section].outward_rest(l.bump))
    };
    Belly {
        stray,
        height: links.iter().map(height).fold(0.0, f64::max),
        length: a.distance(b),
        prominence: mean(&|l| sections[l.section].bumps[l.bump].prominence),
        sharpness: mean(&|l| sections[l.section].bumps[l.bump].sharpness),
        links,
        roots_rest,
    }
}

/// Where on the trunk a stretch is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Its side.
    pub side: Side,
    /// Distance from the middle, half shoulder widths.
    pub across: f64,
    /// Height, from 0 at the hips to 1 at the shoulders.
    pub height: f64,
    /// Around the trunk, degrees: 0 in front, 90 outside, 180 behind.
    pub degrees: f64,
    /// Over the upper arm rather than beside or under it: cosine between up and the way from the bone, -1..=1.
    pub over_arm: f64,
}

impl Place {
    /// Of points of the skin, metres in scene space at rest.
    pub fn of(body: &Body, points: &[DVec3]) -> Place {
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let off = middle - body.hip_rest();
        let lateral = off.dot(body.left);
        let height = off.dot(body.up) / body.height();
        let ahead = (middle - body.hip_rest().lerp(body.shoulder_rest(), height)).dot(body.ahead);
        let side = usize::from(lateral <= 0.0);
        let (shoulder, elbow) = (body.shoulders_rest[side], body.elbows_rest[side]);
        let from_bone = (middle - shoulder).reject_from(elbow - shoulder);
        Place {
            over_arm: from_bone.normalize_or_zero().dot(body.up.reject_from(elbow - shoulder).normalize_or_zero()),
            side: if lateral > 0.0 { Side::Left } else { Side::Right },
            across: lateral.abs() / (0.5 * body.shoulders_rest[0].distance(body.shoulders_rest[1])),
            height,
            degrees: lateral.abs().atan2(ahead).to_degrees(),
        }
    }

    /// Whether it is on the middle of the body.
    pub fn is_middle(&self) -> bool {
        self.across < MIDDLE
    }
}
