//! Bumps of an outline: triangles between its points, pruned from the tips inwards until a semicircle is full (paper B,
//! section 4; background 6.1), then what real bodies need besides (prototypes 2).

use super::{
    outline::{self, curvature},
    section::surrounds,
};
use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};
use std::{collections::HashMap, f64::consts::PI};

/// Least height of a bump over its chord, in chords.
pub const LEAST_HEIGHT: f64 = 0.06;
/// Least chord of a bump, in perimeters over pi.
pub const LEAST_CHORD: f64 = 0.07;
/// Least prominence of a tip's curvature, in units of the curvature of a circle of the same perimeter.
pub const LEAST_PROMINENCE: f64 = 0.2;
/// Prominence from which a tip needs no triangles to be one.
const SURE_PROMINENCE: f64 = 0.6;
/// A hollow ends where the curvature is this far above its least, same unit.
const RISE: f64 = 0.1;
/// Two tips are as high where they differ by less than this share of the least prominence.
const ALIKE: f64 = 0.01;
/// A vertex stands outside a semicircle by this share of its radius.
const OUTSIDE: f64 = 1e-9;

/// A part of an outline that stands out. Points are indices into the outline, anticlockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// Where the outline is bent most.
    pub tip: usize,
    /// The least bent point before the tip.
    pub begin: usize,
    /// The least bent point after it.
    pub end: usize,
    /// Curvature at the tip, 1 on a circle of the outline's perimeter.
    pub sharpness: f64,
    /// How far the tip's curvature stands above the higher of the two lows that part it from sharper tips, same unit.
    pub prominence: f64,
}

impl Bump {
    /// Number of points from `begin` to `end`.
    pub fn span(&self, count: usize) -> usize {
        (self.end + count - self.begin) % count
    }
}

/// How a run of pruned triangles ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PruneEnd {
    /// A vertex stood outside the semicircle.
    Outside,
    /// A triangle with three neighbours was reached.
    Junction,
    /// Nothing was left.
    Spent,
}

/// A run of triangles that grew inwards from a tip.
#[derive(Clone, Debug, PartialEq)]
pub struct Pruned {
    /// The terminal triangle's corner opposite to its inner side.
    pub tip: usize,
    /// First and last point of the boundary around the run, anticlockwise.
    pub chord: (usize, usize),
    /// How many triangles it has.
    pub triangles: usize,
    /// Why it grew no further.
    pub end: PruneEnd,
}

/// An outline that crosses itself has no inside to triangulate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the outline crosses itself between points {0} and the one after it")]
pub struct Crossing(pub usize);

struct Corner {
    position: Point2<f64>,
    index: usize,
}

impl HasPosition for Corner {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// The triangles inside an outline: the constrained Delaunay triangulation of its points, `n - 2` of them.
///
/// # Errors
/// The outline crosses itself.
pub fn triangulate(outline: &[DVec2]) -> Result<Vec<[usize; 3]>, Crossing> {
    let mut cdt = ConstrainedDelaunayTriangulation::<Corner>::new();
    let mut handles = Vec::with_capacity(outline.len());
    for (index, p) in outline.iter().enumerate() {
        let corner = Corner { position: Point2::new(p.x, p.y), index };
        handles.push(cdt.insert(corner).map_err(|_| Crossing(index))?);
    }
    for k in 0..handles.len() {
        let (a, b) = (handles[k], handles[(k + 1) % handles.len()]);
        if a == b || !cdt.can_add_constraint(a, b) {
            return Err(Crossing(k));
        }
        cdt.add_constraint(a, b);
    }
    let inside = |t: &[usize; 3]| surrounds(outline, t.iter().map(|&k| outline[k]).sum::<DVec2>() / 3.0);
    let faces = cdt.inner_faces().map(|face| face.vertices().map(|v| v.data().index));
    Ok(faces.filter(inside).collect())
}

/// Grows a run of triangles inwards from every terminal triangle, until a vertex of the run stands outside the semicircle
/// over its inner side.
pub fn prune(outline: &[DVec2], triangles: &[[usize; 3]]) -> Vec<Pruned> {
    let count = outline.len();
    let side = |t: &[usize; 3], k: usize| (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]));
    let on_boundary = |(a, b): (usize, usize)| b - a == 1 || (a == 0 && b == count - 1);
    let mut beside: HashMap<(usize, usize), Vec<usize>> = HashMap::new();
    for (f, t) in triangles.iter().enumerate() {
        (0..3).for_each(|k| beside.entry(side(t, k)).or_default().push(f));
    }
    let inner = |f: usize| (0..3).map(|k| side(&triangles[f], k)).filter(|&s| !on_boundary(s)).collect::<Vec<_>>();
    let mut runs = Vec::new();
    for (f, terminal) in triangles.iter().enumerate() {
        let &[first] = inner(f).as_slice() else { continue };
        let tip = terminal.iter().copied().find(|&v| v != first.0 && v != first.1).unwrap_or(terminal[0]);
        let mut region = vec![tip];
        let (mut chord, mut face, mut grown) = (first, f, 1);
        let end = loop {
            let (a, b) = (outline[chord.0], outline[chord.1]);
            let (middle, radius) = ((a + b) * 0.5, a.distance(b) * 0.5);
            if region.iter().any(|&v| outline[v].distance(middle) > radius * (1.0 + OUTSIDE)) {
                break PruneEnd::Outside;
            }
            let Some(&next) = beside[&chord].iter().find(|&&other| other != face) else { break PruneEnd::Spent };
            let sides = inner(next);
            match sides.len() {
                3 => break PruneEnd::Junction,
                2 => {}
                _ => break PruneEnd::Spent,
            }
            let onward = if sides[0] == chord { sides[1] } else { sides[0] };
            region.extend([chord.0, chord.1].iter().filter(|&&v| v != onward.0 && v != onward.1));
            (chord, face, grown) = (onward, next, grown + 1);
        };
        let forward = (tip + count - chord.0) % count <= (chord.1 + count - chord.0) % count;
        let chord = if forward { chord } else { (chord.1, chord.0) };
        runs.push(Pruned { tip, chord, triangles: grown, end });
    }
    runs
}

/// The bumps of a smoothed, evenly sampled, anticlockwise outline, by their tips.
///
/// # Errors
/// The outline crosses itself.
pub fn detect(outline: &[DVec2]) -> Result<Vec<Bump>, Crossing> {
    let count = outline.len();
    let curved = curvature(outline);
    let peak = |&k: &usize| curved[k] >= curved[(k + 1) % count] && curved[k] > curved[(k + count - 1) % count];
    let least_chord = LEAST_CHORD * outline::perimeter(outline) / PI;
    let alike = ALIKE * LEAST_PROMINENCE;
    let mut tips: Vec<usize> = Vec::new();
    for run in prune(outline, &triangulate(outline)?) {
        let (a, b) = (outline[run.chord.0], outline[run.chord.1]);
        let chord = a.distance(b);
        let arc = (run.chord.1 + count - run.chord.0) % count;
        let along = (0..=arc).map(|k| (run.chord.0 + k) % count);
        let height = along.clone().map(|k| (b - a).perp_dot(outline[k] - a).abs() / chord).fold(0.0, f64::max);
        if chord < least_chord || height < LEAST_HEIGHT * chord {
            continue;
        }
        // The triangle's corner is somewhere on the bump, and a run may hold two: what is bent most stands out.
        tips.extend(along.filter(peak));
    }
    // Where four points are on one circle the triangles are arbitrary, and a run may end before it has begun.
    tips.extend(
        (0..count).filter(peak).filter(|&k| curved[k] > 1.0 && prominence(&curved, k, alike) >= SURE_PROMINENCE),
    );
    tips.sort_unstable();
    tips.dedup();
    tips.retain(|&tip| prominence(&curved, tip, alike) >= LEAST_PROMINENCE);
    Ok((0..tips.len())
        .map(|k| {
            let tip = tips[k];
            let before = tips[(k + tips.len() - 1) % tips.len()];
            let after = tips[(k + 1) % tips.len()];
            Bump {
                tip,
                begin: low(&curved, tip, before, count - 1, RISE),
                end: low(&curved, tip, after, 1, RISE),
                sharpness: curved[tip],
                prominence: prominence(&curved, tip, alike),
            }
        })
        .collect())
}

/// The bumps of a near-planar outline by direct variation (paper B, section 4): where it stands out of its own shape at large by
/// `least` more than at the lows on either side. `varied` is that [`variation`](outline::variation) in any unit, `curved` the
/// curvature.
pub fn vary(varied: &[f64], curved: &[f64], least: f64) -> Vec<Bump> {
    let count = varied.len();
    let peak = |&k: &usize| varied[k] >= varied[(k + 1) % count] && varied[k] > varied[(k + count - 1) % count];
    let tips: Vec<usize> = (0..count).filter(peak).filter(|&k| prominence(varied, k, ALIKE * least) >= least).collect();
    let bump = |k: usize| {
        let tip = tips[k];
        let (before, after) = (tips[(k + tips.len() - 1) % tips.len()], tips[(k + 1) % tips.len()]);
        let (begin, end) = (low(varied, tip, before, count - 1, least), low(varied, tip, after, 1, least));
        // Over the lows beside it, not over those beside its equal on the other side of the body.
        Bump { tip, begin, end, sharpness: curved[tip], prominence: varied[tip] - varied[begin].max(varied[end]) }
    };
    (0..tips.len()).map(bump).collect()
}

/// How far one has to go down from a tip to come to one that is as high; `alike` says what difference is none, for left and right
/// differ by rounding alone.
fn prominence(curved: &[f64], tip: usize, alike: f64) -> f64 {
    let count = curved.len();
    let enough = curved[tip] - alike;
    let low = |step: usize| {
        let mut lowest = curved[tip];
        for value in (1..count).map(|k| curved[(tip + k * step) % count]) {
            if value > curved[tip] || (value > enough && lowest < enough) {
                break;
            }
            lowest = lowest.min(value);
        }
        lowest
    };
    curved[tip] - low(1).max(low(count - 1))
}

/// The lowest point on the way from a tip to the next one, in steps of 1 or of one less than a round: the first hollow, which ends
/// where what follows is higher by `rise`, for beyond it the limb goes on.
fn low(curved: &[f64], tip: usize, next: usize, step: usize, rise: f64) -> usize {
    let count = curved.len();
    let mut lowest = (tip + step) % count;
    for at in (1..count).map(|k| (tip + k * step) % count).take_while(|&at| at != next) {
        if curved[at] < curved[lowest] {
            lowest = at;
        }
        if curved[at] > curved[lowest] + rise {
            break;
        }
    }
    lowest
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn wavy(count: usize, lobes: f64, height: f64) -> Vec<DVec2> {
        let point = |k: usize| {
            let angle = TAU * (k as f64 + 0.3) / count as f64;
            DVec2::from_angle(angle) * 0.05 * (1.0 + height * (lobes * angle).cos())
        };
        outline::resample(&(0..count).map(point).collect::<Vec<_>>(), count)
    }

    #[test]
    fn an_outline_of_n_points_has_n_less_two_triangles() {
        let triangles = triangulate(&wavy(96, 3.0, 0.2)).expect("simple");
        assert_eq!(triangles.len(), 94);
        let mut crossed = wavy(96, 3.0, 0.2);
        crossed.swap(10, 40);
        assert!(triangulate(&crossed).is_err());
    }

    #[test]
    fn lobes_are_counted() {
        for (lobes, height) in [(3.0, 0.1), (4.0, 0.06), (5.0, 0.06)] {
            let outline = wavy(96, lobes, height);
            let bumps = detect(&outline).expect("simple");
            assert_eq!(bumps.len(), lobes as usize, "{lobes}");
            for bump in &bumps {
                let angle = outline[bump.tip].to_angle().rem_euclid(TAU / lobes);
                assert!(angle.min(TAU / lobes - angle) < 0.08, "a tip at {angle} of {lobes}");
                assert!((bump.span(96) as f64 - 96.0 / lobes).abs() < 3.0, "{bump:?}");
            }
        }
    }

    #[test]
    fn circles_have_no_bumps_and_ellipses_their_two_ends() {
        assert!(detect(&wavy(96, 3.0, 0.0)).expect("simple").is_empty());
        let flat: Vec<DVec2> = wavy(96, 3.0, 0.0).iter().map(|p| *p * DVec2::new(1.0, 0.7)).collect();
        assert_eq!(detect(&outline::resample(&flat, 96)).expect("simple").len(), 2);
    }

    #[test]
    fn runs_of_triangles_grow_from_every_lobe() {
        let outline = wavy(96, 3.0, 0.2);
        let runs = prune(&outline, &triangulate(&outline).expect("simple"));
        let long: Vec<&Pruned> = runs.iter().filter(|run| run.triangles > 20).collect();
        assert_eq!(long.len(), 3, "{runs:?}");
        for run in long {
            let (a, b) = (outline[run.chord.0], outline[run.chord.1]);
            let inside = |k: usize| outline[k % 96].distance((a + b) * 0.5) <= a.distance(b) * 0.5 * 1.2;
            let arc = (run.chord.1 + 96 - run.chord.0) % 96;
            assert!(run.end != PruneEnd::Spent && (0..=arc).all(|k| inside(run.chord.0 + k)), "{run:?}");
        }
    }

    #[test]
    fn what_varies_along_a_flat_outline_is_found() {
        // A trunk: broad and shallow, with two low mounds in front.
        let mounds = |height: f64| -> Vec<DVec2> {
            let point = |k: usize| {
                let angle = TAU * (k as f64 + 0.3) / 400.0;
                let away = |at: f64| (-((angle - at) / 0.15).powi(2)).exp();
                DVec2::from_angle(angle) * DVec2::new(0.1, 0.16) * (1.0 + height * (away(0.3) + away(TAU - 0.3)))
            };
            outline::resample(&(0..400).map(point).collect::<Vec<_>>(), 160)
        };
        let found = |height: f64| {
            let outline = outline::smooth(&mounds(height), 0.01 * outline::perimeter(&mounds(height)));
            let varied = outline::variation(&outline, 0.045 * outline::perimeter(&outline));
            let bumps = vary(&varied, &curvature(&outline), 0.001 * outline::perimeter(&outline));
            bumps
                .into_iter()
                .filter(|bump| outline[bump.tip].y.abs() < 0.08 && outline[bump.tip].x > 0.0)
                .collect::<Vec<_>>()
        };
        assert_eq!(found(0.06).len(), 2, "{:?}", found(0.06));
        let [a, b] = [found(0.06)[0], found(0.06)[1]].map(|bump| bump.prominence);
        assert!((a - b).abs() < 0.05 * a, "{a} {b}: left and right are alike");
        assert!(found(0.0).is_empty(), "{:?}", found(0.0));
    }
}
