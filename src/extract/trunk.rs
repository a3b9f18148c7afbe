//! Planes across trunk, shoulders and neck (paper B, figure 1c; prototypes 2): level ones across the abdomen, sagittal ones across
//! each side of the chest, a sweep over each shoulder from the neck to the arm, and across the neck.

use super::{
    body::{Body, Part, Shares},
    chain::{Link, Section, Settings, Variation, link},
    section::{Cut, Plane, Surface, cut},
    stretch::Place,
    window::{self, Outline},
};
use crate::rig::groups::Side;
use glam::DVec3;

/// Planes of a sweep.
pub const PLANES: usize = 49;
/// The level planes begin this far below the hips and end this far above the shoulders, in heights of the trunk.
const LEVELS: [f64; 2] = [-0.25, 1.05];
/// Sagittal planes: from the middle to the shoulder, in half shoulder widths.
const SAGITTAL: [f64; 2] = [0.06, 1.0];
/// A chest begins at this height of the trunk.
const CHEST: f64 = 0.42;
/// Sagittal planes alone handle what is above this height of the trunk and within this of its front, degrees.
const CHEST_BOTTOM: f64 = 0.66;
const CHEST_FRONT: f64 = 70.0;
/// Where the sweep over a shoulder begins, in half shoulder widths from it, and where it ends, in upper arms from it.
const SWEEP: [f64; 2] = [0.72, 0.42];
/// The sweep sees skin this near to the plane's origin, in upper arms.
const SWEEP_REACH: f64 = 0.5;
/// Planes across the neck, in necks from its first joint to the head's.
const NECK: [f64; 2] = [-0.25, 0.9];

/// Expected ratio of a trunk's muscle's thickness to its breadth: they are sheets.
const ASPECT: f64 = 0.5;
/// How far a bump stands out at least, perimeters: what a coarse mesh's facets do is a quarter of it.
const LEAST_VARIATION: f64 = 0.001;

/// A group of planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sweep {
    /// Level planes from hips to shoulders.
    Abdomen,
    /// Sagittal planes of a side.
    Chest(Side),
    /// From the neck over the shoulder to the arm.
    Shoulder(Side),
    /// Across the neck.
    Neck,
}

impl Sweep {
    /// All that a body has.
    pub fn of(body: &Body) -> Vec<Sweep> {
        let sides = [Side::Left, Side::Right];
        let mut sweeps = vec![Sweep::Abdomen];
        sweeps.extend(sides.map(Sweep::Chest));
        sweeps.extend(sides.map(Sweep::Shoulder));
        sweeps.extend(body.neck_rest.map(|_| Sweep::Neck));
        sweeps
    }

    /// What it is called as a whole.
    pub fn title(self) -> &'static str {
        match self {
            Sweep::Abdomen => "abdomen",
            Sweep::Neck => "neck",
            Sweep::Chest(Side::Left) => "chest_l",
            Sweep::Chest(Side::Right) => "chest_r",
            Sweep::Shoulder(Side::Left) => "shoulder_l",
            Sweep::Shoulder(Side::Right) => "shoulder_r",
        }
    }

    /// What a side of it is called; `None` for a side that it does not have.
    pub fn name(self, side: Side) -> Option<String> {
        match self {
            Sweep::Abdomen | Sweep::Neck => {
                Some(format!("{}_{}", self.title(), if side == Side::Left { "l" } else { "r" }))
            }
            Sweep::Chest(own) | Sweep::Shoulder(own) => (own == side).then(|| self.title().to_owned()),
        }
    }

    /// Its planes, in order.
    pub fn planes(self, body: &Body) -> Vec<Plane> {
        let share = |k: usize| k as f64 / (PLANES - 1) as f64;
        let between = |range: [f64; 2], k: usize| range[0] + (range[1] - range[0]) * share(k);
        let plane = |k: usize| match self {
            Sweep::Abdomen => {
                let origin = body.hip_rest().lerp(body.shoulder_rest(), between(LEVELS, k));
                Plane::across(origin, body.up, body.ahead)
            }
            Sweep::Chest(side) => {
                let shoulder = body.shoulders_rest[index(side)] - body.shoulder_rest();
                Plane::across(body.shoulder_rest() + shoulder * between(SAGITTAL, k), outward(body, side), body.ahead)
            }
            Sweep::Shoulder(side) => over_shoulder(body, side, share(k)),
            Sweep::Neck => {
                let [first, head] = body.neck_rest.unwrap_or([body.shoulder_rest(), body.shoulder_rest() + body.up]);
                Plane::across(first.lerp(head, between(NECK, k)), head - first, body.ahead)
            }
        };
        (0..PLANES).map(plane).collect()
    }

    /// Of a plane's cuts what belongs to the region.
    fn outline(self, body: &Body, shares: &Shares, plane: &Plane, cuts: &[Cut]) -> Option<Outline> {
        let arms =
            |cut: &Cut, k: usize| shares.at(cut, k, Part::Arm(Side::Left)) + shares.at(cut, k, Part::Arm(Side::Right));
        let above = |cut: &Cut, k: usize| shares.at(cut, k, Part::Neck) + shares.at(cut, k, Part::Head);
        let height =
            |cut: &Cut, k: usize| (plane.to_scene(cut.points[k]) - body.hip_rest()).dot(body.up) / body.height();
        let reach = SWEEP_REACH * body.shoulders_rest[0].distance(body.elbows_rest[0]);
        let inside = |cut: &Cut, k: usize| match self {
            Sweep::Abdomen => arms(cut, k) < 0.5,
            Sweep::Chest(_) => arms(cut, k) < 0.6 && above(cut, k) < 0.3 && height(cut, k) > CHEST,
            Sweep::Shoulder(_) => cut.points[k].length() < reach && above(cut, k) < 0.5,
            Sweep::Neck => arms(cut, k) < 0.3 && shares.at(cut, k, Part::Head) < 0.9,
        };
        let clipped = cuts.iter().filter_map(|cut| window::clip(cut, |k| inside(cut, k)));
        clipped.max_by(|a, b| a.skin().total_cmp(&b.skin()))
    }

    /// Whether it handles a place: not the middle of the body, where bone is, nor with level planes the chest's front.
    fn sees(self, place: &Place) -> bool {
        let chest = self == Sweep::Abdomen && place.degrees < CHEST_FRONT && place.height > CHEST_BOTTOM;
        !place.is_middle() && !chest
    }

    /// How its outlines are smoothed and its bumps linked.
    pub fn settings(self) -> Settings {
        // What is level goes all round the body, the others round a part of it.
        let (reach, large) = if self == Sweep::Abdomen { (0.05, 0.045) } else { (0.06, 0.08) };
        let variation = Variation { large, least: LEAST_VARIATION };
        let variation = (!matches!(self, Sweep::Shoulder(_))).then_some(variation);
        Settings { smoothing: [0.013, 0.04], reach, points: 160, aspect: ASPECT, variation }
    }
}

/// The plane of the sweep over a shoulder at a share of its way: its normal turns from the body's side to the arm.
fn over_shoulder(body: &Body, side: Side, share: f64) -> Plane {
    let (shoulder, elbow) = (body.shoulders_rest[index(side)], body.elbows_rest[index(side)]);
    let side = outward(body, side);
    let inner = shoulder - side * (SWEEP[0] * (shoulder - body.shoulder_rest()).length());
    let origin = match share {
        s if s < 0.5 => inner.lerp(shoulder, 2.0 * s),
        s => shoulder.lerp(elbow, SWEEP[1] * (2.0 * s - 1.0)),
    };
    let turned = ((share - 0.2) / 0.6).clamp(0.0, 1.0);
    let turned = turned * turned * (3.0 - 2.0 * turned);
    Plane::across(origin, side.lerp((elbow - shoulder).normalize(), turned), body.ahead)
}

/// The body's direction to a side.
pub fn outward(body: &Body, side: Side) -> DVec3 {
    if side == Side::Left { body.left } else { -body.left }
}

/// 0 for the left side, 1 for the right one.
pub fn index(side: Side) -> usize {
    usize::from(side == Side::Right)
}

/// Sections of a sweep, and the chains of their bumps.
pub fn sections(surface: &Surface, shares: &Shares, body: &Body, sweep: Sweep) -> (Vec<Section>, Vec<Vec<Link>>) {
    let settings = sweep.settings();
    let planes = sweep.planes(body);
    let section = |(k, plane): (usize, &Plane)| {
        let outline = sweep.outline(body, shares, plane, &cut(surface, plane))?;
        let mut section = Section::new(k, *plane, &outline, &settings).ok()?;
        section.keep(|tip| sweep.sees(&Place::of(body, &[tip])));
        Some(section)
    };
    let sections: Vec<Section> = planes.iter().enumerate().filter_map(section).collect();
    let chains = link(&sections, &settings);
    (sections, chains)
}
