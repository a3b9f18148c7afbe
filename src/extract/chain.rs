//! Bumps linked from section to section, and what tells a muscle from what only looks like one (prototypes 2).

use super::{
    bump::{self, Bump, Crossing},
    ellipse::{self, Ellipse},
    outline,
    section::Plane,
    window::Outline,
};
use glam::{DVec2, DVec3};
use nalgebra::{Matrix3, RowVector3, Vector3};

/// Tips nearer to a bridge than this many deviations of the smoothing are the bridge's own corners.
const BRIDGE_MARGIN: f64 = 2.0;
/// Roughness from which outlines are taken for noisy, and from which for as noisy as a bad scan, perimeters.
const NOISE: [f64; 2] = [5e-4, 9e-4];
/// Sections that a chain may leap over.
const GAP: usize = 2;
/// Sections before and after one whose median is its depth.
const MEDIAN: usize = 3;
/// Rounds of a curve's fit.
const ROUNDS: usize = 6;
/// Tips at a belly's ends may be this far off its line, perimeters.
const STRAY: f64 = 0.03;
/// Tips at a belly's ends stand out by this share of its mean prominence.
const FAINT: f64 = 0.4;
/// Fewest sections of a muscle.
pub(super) const FEWEST: usize = 5;
/// Least height of a belly over its chord, metres, and in lengths of the muscle.
pub const LEAST_BELLY: [f64; 2] = [0.0012, 0.008];
/// Least mean prominence of a belly's tips.
pub const LEAST_MEAN_PROMINENCE: f64 = 0.3;
/// Least mean curvature of a belly's tips: a bare limb between two muscles stands out as well, but round.
pub const LEAST_SHARPNESS: f64 = 1.2;
/// A tip may lie this far under its belly's chord, metres: a twentieth of the least height.
const UNDER: f64 = 6e-5;

/// What stands out of near-planar outlines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation {
    /// Deviation of the Gaussian that leaves an outline's shape at large, perimeters.
    pub large: f64,
    /// How far a bump stands out of that at least, perimeters.
    pub least: f64,
}

/// How outlines of a region are smoothed and its bumps linked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Least and largest deviation of the smoothing Gaussian, perimeters.
    pub smoothing: [f64; 2],
    /// How far a tip may be from the next section's, perimeters.
    pub reach: f64,
    /// Points of an outline.
    pub points: usize,
    /// Expected ratio of a muscle's short axis to its long one.
    pub aspect: f64,
    /// Where outlines are near-planar bumps are found by direct variation, and their prominences are perimeters.
    pub variation: Option<Variation>,
}

impl Settings {
    /// For arms: their outlines are small, and their muscles round.
    pub const ARM: Settings =
        Settings { smoothing: [0.02, 0.04], reach: 0.07, points: 96, aspect: ellipse::ASPECT, variation: None };
    /// For thighs, whose muscles are broad and flat.
    pub const THIGH: Settings = Settings {
        smoothing: [0.013, 0.04],
        reach: 0.07,
        points: 96,
        aspect: ellipse::ASPECT,
        variation: Some(Variation { large: 0.07, least: 0.001 }),
    };
    /// For shins.
    pub const SHIN: Settings =
        Settings { smoothing: [0.013, 0.04], reach: 0.07, points: 96, aspect: ellipse::ASPECT, variation: None };
}

/// One section of a limb, with the bumps in its outline.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Its number among the planes across the region.
    pub number: usize,
    /// The plane.
    pub plane: Plane,
    /// Its outline, sampled evenly; in the plane's axes.
    pub outline: Vec<DVec2>,
    /// Which of its points are on bridges over what was cut away.
    pub bridged: Vec<bool>,
    /// Length of the outline, metres.
    pub perimeter: f64,
    /// Bumps of the smoothed outline.
    pub bumps: Vec<Bump>,
    /// An ellipse for every bump.
    pub ellipses: Vec<Ellipse>,
}

impl Section {
    /// Samples a closed cut, finds its bumps and fits their ellipses.
    ///
    /// # Errors
    /// The smoothed outline crosses itself.
    pub fn new(number: usize, plane: Plane, cut: &Outline, settings: &Settings) -> Result<Section, Crossing> {
        let (points, bridged) = outline::from_front(&cut.points, &cut.bridged);
        let outline = outline::resample(&points, settings.points);
        let bridged = outline::bridged_samples(&points, &bridged, settings.points);
        let perimeter = outline::perimeter(&outline);
        let spacing = 1.4 * perimeter / outline::corners(&cut.points).max(1) as f64;
        let [least, most] = settings.smoothing.map(|share| share * perimeter);
        let noise = (outline::roughness(&outline) / perimeter - NOISE[0]) / (NOISE[1] - NOISE[0]);
        let least = least + (most - least) * noise.clamp(0.0, 1.0);
        let deviation = spacing.max(least).min(most);
        let smoothed = outline::smooth(&outline, deviation);
        let margin = (BRIDGE_MARGIN * deviation / perimeter * settings.points as f64).ceil() as usize;
        let near_bridge =
            |tip: usize| (0..=2 * margin).any(|k| bridged[(tip + settings.points + k - margin) % settings.points]);
        let curved = outline::curvature(&smoothed);
        let found = match settings.variation {
            Some(Variation { large, least }) => {
                let varied = outline::variation(&smoothed, large * perimeter).into_iter().map(|v| v / perimeter);
                bump::vary(&varied.collect::<Vec<_>>(), &curved, least)
            }
            None => bump::detect(&smoothed)?,
        };
        let bumps: Vec<Bump> = found.into_iter().filter(|bump| !near_bridge(bump.tip)).collect();
        let ellipses = bumps.iter().map(|bump| ellipse::fit(&outline, &curved, bump, settings.aspect)).collect();
        Ok(Section { number, plane, outline, bridged, perimeter, bumps, ellipses })
    }

    /// Leaves out bumps whose tips, in scene space at rest, are not wanted.
    pub fn keep(&mut self, wanted: impl Fn(DVec3) -> bool) {
        let kept: Vec<bool> = (0..self.bumps.len()).map(|bump| wanted(self.tip_rest(bump))).collect();
        let mut of_bumps = kept.iter();
        self.bumps.retain(|_| *of_bumps.next().unwrap_or(&true));
        let mut of_ellipses = kept.iter();
        self.ellipses.retain(|_| *of_ellipses.next().unwrap_or(&true));
    }

    fn tip(&self, bump: usize) -> DVec2 {
        self.outline[self.bumps[bump].tip]
    }

    /// Where a bump's tip is, metres in scene space at rest.
    pub fn tip_rest(&self, bump: usize) -> DVec3 {
        self.plane.to_scene(self.tip(bump))
    }

    /// Unit vector in the plane out of the muscle at a bump, scene space at rest: from its ellipse's centre to its tip.
    pub fn outward_rest(&self, bump: usize) -> DVec3 {
        let out = (self.tip(bump) - self.ellipses[bump].centre).normalize_or_zero();
        self.plane.axes[0] * out.x + self.plane.axes[1] * out.y
    }

    /// How far the skin is from a point of the plane along a unit vector of it, metres; `None` where there is none.
    pub fn skin_along(&self, from: DVec2, way: DVec2) -> Option<f64> {
        let count = self.outline.len();
        let crossing = |k: usize| {
            let (a, b) = (self.outline[k] - from, self.outline[(k + 1) % count] - from);
            let (beside_a, beside_b) = (way.perp_dot(a), way.perp_dot(b));
            let share = beside_a / (beside_a - beside_b);
            let far = way.dot(a.lerp(b, share));
            ((beside_a < 0.0) != (beside_b < 0.0) && far > 0.0).then_some(far)
        };
        (0..count).filter_map(crossing).min_by(f64::total_cmp)
    }

    /// Points of a bump around its tip to a share of its span on either side, metres in scene space at rest, with weights that decrease
    /// along it (background 6.2).
    pub fn crest_rest(&self, bump: usize, share: f64) -> Vec<(DVec3, f64)> {
        let (bump, count) = (&self.bumps[bump], self.outline.len());
        let half = (bump.span(count) as f64 * share).max(1.0);
        let near = (half.ceil() as usize).min(count / 4);
        let one = |k: usize| {
            let away = (k as f64 - near as f64) / half;
            (self.plane.to_scene(self.outline[(bump.tip + count + k - near) % count]), (-(away / 0.6).powi(2)).exp())
        };
        (0..=2 * near).map(one).collect()
    }

    /// From the middle of the outline to a bump's tip, in the plane's axes.
    fn outward(&self, bump: usize) -> DVec2 {
        self.tip(bump) - self.outline.iter().sum::<DVec2>() / self.outline.len() as f64
    }
}

/// A bump of a section: indices into the sections and into its bumps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// Index of the section.
    pub section: usize,
    /// Index of the bump.
    pub bump: usize,
}

/// Bumps of successive sections that belong together. The nearest pairs are linked first.
pub fn link(sections: &[Section], settings: &Settings) -> Vec<Vec<Link>> {
    let mut chains: Vec<Vec<Link>> = Vec::new();
    for (s, section) in sections.iter().enumerate() {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (c, chain) in chains.iter().enumerate() {
            let last = chain[chain.len() - 1];
            let before = &sections[last.section];
            let gap = section.number - before.number - 1;
            if gap > GAP {
                continue;
            }
            for bump in 0..section.bumps.len() {
                let off = section.tip(bump).distance(before.tip(last.bump)) / section.perimeter;
                if off < settings.reach * (1.0 + 0.5 * gap as f64) {
                    pairs.push((off, c, bump));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut taken = vec![false; section.bumps.len()];
        let mut grown = vec![false; chains.len()];
        for (_, c, bump) in pairs {
            if !taken[bump] && !grown[c] {
                (taken[bump], grown[c]) = (true, true);
                chains[c].push(Link { section: s, bump });
            }
        }
        let free = (0..section.bumps.len()).filter(|&bump| !taken[bump]);
        chains.extend(free.map(|bump| vec![Link { section: s, bump }]).collect::<Vec<_>>());
    }
    chains
}

/// A part of a chain whose tips rise and fall as over a muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct Belly {
    /// Its bumps.
    pub links: Vec<Link>,
    /// Where its axis is at each of them: its root curve, metres in scene space at rest.
    pub roots_rest: Vec<DVec3>,
    /// How far its tips stray from a smooth line, perimeters.
    pub stray: f64,
    /// How far the highest tip stands over the chord from the first to the last, metres.
    pub height: f64,
    /// Length of that chord, metres.
    pub length: f64,
    /// Mean prominence of its tips.
    pub prominence: f64,
    /// Mean curvature of its tips, 1 on a circle of the outline's perimeter.
    pub sharpness: f64,
}

impl Belly {
    /// Where its first and last tip are, metres in scene space at rest.
    pub fn ends(&self, sections: &[Section]) -> [DVec3; 2] {
        [0, self.links.len() - 1].map(|k| sections[self.links[k].section].tip_rest(self.links[k].bump))
    }

    /// Per section its share of the way from end to end, 0..=1, and how far its tip stands out of the limb, metres.
    pub fn reach(&self, sections: &[Section]) -> (Vec<f64>, Vec<f64>) {
        let [a, b] = self.ends(sections);
        let out: DVec2 = self.links.iter().map(|l| sections[l.section].outward(l.bump)).sum();
        let out = out.normalize_or_zero();
        let one = |l: &Link| {
            let section = &sections[l.section];
            let share = (section.tip_rest(l.bump) - a).dot(b - a) / (b - a).length_squared();
            (share, section.tip(l.bump).dot(out))
        };
        self.links.iter().map(one).unzip()
    }
}

/// The bellies of a chain, from the largest on: wherever tips stand above their chord, high and long enough.
pub fn bellies(sections: &[Section], chain: &[Link]) -> Vec<Belly> {
    let mut found = Vec::new();
    let mut parts = vec![chain.to_vec()];
    while let Some(part) = parts.pop() {
        let Some((from, to, height)) = highest(sections, &part) else { continue };
        let links = without_strays(sections, &part[from..=to]);
        let ends = [links[0], links[links.len() - 1]].map(|l| sections[l.section].tip_rest(l.bump));
        let length = ends[0].distance(ends[1]);
        let mean = |of: &dyn Fn(&Bump) -> f64| {
            links.iter().map(|l| of(&sections[l.section].bumps[l.bump])).sum::<f64>() / links.len() as f64
        };
        let (prominence, sharpness) = (mean(&|b| b.prominence), mean(&|b| b.sharpness));
        let stands_out = prominence > LEAST_MEAN_PROMINENCE && sharpness > LEAST_SHARPNESS;
        if height >= LEAST_BELLY[0].max(LEAST_BELLY[1] * length) && stands_out {
            let (roots_rest, stray) = roots(sections, &links);
            found.push(Belly { links, roots_rest, stray, height, length, prominence, sharpness });
        }
        // The last tip of one belly may be the first of the next.
        parts.push(part[..=from].to_vec());
        parts.push(part[to..].to_vec());
    }
    found
}

/// A belly without the sections at its ends whose tips are not on its line, or hardly stand out: there its bump has not begun,
/// and another one may have been taken for it.
pub(super) fn without_strays<'a>(sections: &[Section], links: &'a [Link]) -> Vec<Link> {
    let mut links: &'a [Link] = links;
    while links.len() > FEWEST {
        let (places, tips) = line(sections, links);
        let fitted = curve(&places, &tips);
        let prominence = |k: usize| sections[links[k].section].bumps[links[k].bump].prominence;
        let usual = (0..links.len()).map(prominence).sum::<f64>() / links.len() as f64;
        let off = |k: usize| tips[k].distance(fitted[k]) / sections[links[k].section].perimeter;
        let strays = |k: usize| off(k) > STRAY || prominence(k) < FAINT * usual;
        links = match (strays(0), strays(links.len() - 1)) {
            (true, _) => &links[1..],
            (_, true) => &links[..links.len() - 1],
            _ => break,
        };
    }
    links.to_vec()
}

/// Numbers of a belly's sections and its tips.
fn line(sections: &[Section], links: &[Link]) -> (Vec<f64>, Vec<DVec3>) {
    links.iter().map(|l| (sections[l.section].number as f64, sections[l.section].tip_rest(l.bump))).unzip()
}

/// The root curve of a belly (paper B): as deep under the tips as the ellipses' centres are, less what one section alone
/// says; where a bump begins, its ellipse and its tip may be anything. And how far tips stray from a curve, perimeters.
pub(super) fn roots(sections: &[Section], links: &[Link]) -> (Vec<DVec3>, f64) {
    let depth = |l: &Link| {
        let section = &sections[l.section];
        (section.ellipses[l.bump].centre - section.tip(l.bump)) / section.perimeter
    };
    let depths: Vec<DVec2> = links.iter().map(depth).collect();
    let median = |k: usize, of: &dyn Fn(&DVec2) -> f64| {
        let around = &depths[k.saturating_sub(MEDIAN)..(k + MEDIAN + 1).min(depths.len())];
        let mut values: Vec<f64> = around.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (places, tips) = line(sections, links);
    let lines = curve(&places, &tips);
    let perimeter = |k: usize| sections[links[k].section].perimeter;
    let stray = (0..tips.len()).map(|k| (tips[k].distance_squared(lines[k])) / perimeter(k).powi(2)).sum::<f64>();
    let deep: Vec<DVec3> = (0..links.len())
        .map(|k| {
            let plane = &sections[links[k].section].plane;
            let depth = DVec2::new(median(k, &|d| d.x), median(k, &|d| d.y)) * perimeter(k);
            lines[k] + plane.axes[0] * depth.x + plane.axes[1] * depth.y
        })
        .collect();
    (curve(&places, &deep), (stray / tips.len() as f64).sqrt())
}

/// Points on the parabola nearest to all but the strays (least squares, reweighted by Cauchy's rule).
fn curve(places: &[f64], points: &[DVec3]) -> Vec<DVec3> {
    let (first, last) = (places[0], places[places.len() - 1]);
    let row = |place: f64| {
        let x = (2.0 * place - first - last) / (last - first).max(1.0);
        Vector3::new(1.0, x, x * x)
    };
    let mut weights = vec![1.0; points.len()];
    let mut fitted = points.to_vec();
    for _ in 0..ROUNDS {
        let mut normal = Matrix3::identity() * 1e-9;
        let mut right = Matrix3::zeros();
        for ((&place, p), &weight) in places.iter().zip(points).zip(&weights) {
            let row = row(place);
            normal += row * row.transpose() * weight;
            right += row * RowVector3::new(p.x, p.y, p.z) * weight;
        }
        let Some(found) = normal.lu().solve(&right) else { return points.to_vec() };
        fitted = places
            .iter()
            .map(|&place| {
                let p = row(place).transpose() * found;
                DVec3::new(p[0], p[1], p[2])
            })
            .collect();
        let off: Vec<f64> = points.iter().zip(&fitted).map(|(p, q)| p.distance(*q)).collect();
        let mut sorted = off.clone();
        sorted.sort_by(f64::total_cmp);
        let usual = sorted[sorted.len() / 2].max(1e-5);
        weights = off.iter().map(|off| 1.0 / (1.0 + (off / (2.0 * usual)).powi(2))).collect();
    }
    fitted
}

/// The run of a chain with the largest area between its tips and their chord, and how high it is.
fn highest(sections: &[Section], chain: &[Link]) -> Option<(usize, usize, f64)> {
    if chain.len() < FEWEST {
        return None;
    }
    let out: DVec2 = chain.iter().map(|l| sections[l.section].outward(l.bump)).sum();
    let out = out.normalize_or_zero();
    let first = sections[chain[0].section].plane;
    let points: Vec<DVec2> = chain
        .iter()
        .map(|l| {
            let section = &sections[l.section];
            let along = (section.plane.origin_rest - first.origin_rest).dot(first.normal());
            DVec2::new(along, section.tip(l.bump).dot(out))
        })
        .collect();
    let mut best: Option<(f64, usize, usize, f64)> = None;
    for from in 0..points.len() {
        for to in from + FEWEST - 1..points.len() {
            let (a, b) = (points[from], points[to]);
            let above = |k: usize| points[k].y - (a.y + (b.y - a.y) * (points[k].x - a.x) / (b.x - a.x));
            let heights: Vec<f64> = (from..=to).map(above).collect();
            let area: f64 = heights.iter().sum();
            if heights.iter().all(|&h| h > -UNDER) && best.is_none_or(|(most, ..)| area > most) {
                best = Some((area, from, to, heights.iter().copied().fold(0.0, f64::max)));
            }
        }
    }
    best.map(|(_, from, to, height)| (from, to, height))
}
