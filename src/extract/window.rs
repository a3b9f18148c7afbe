//! A cut without what does not belong to its region: the rest is closed by straight bridges, on which nothing is a muscle
//! (prototypes 2).

use super::section::Cut;
use glam::DVec2;

/// Fewest points of a piece that is kept.
const FEWEST: usize = 4;

/// A closed outline that may have bridges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// In the plane's axes, metres; anticlockwise.
    pub points: Vec<DVec2>,
    /// Per point whether the way from it to the next is a bridge.
    pub bridged: Vec<bool>,
}

impl Outline {
    /// A closed cut as it is.
    pub fn whole(cut: &Cut) -> Outline {
        Outline { points: cut.points.clone(), bridged: vec![false; cut.points.len()] }
    }

    /// Length of all but the bridges, metres.
    pub fn skin(&self) -> f64 {
        let count = self.points.len();
        let ways = (0..count).filter(|&k| !self.bridged[k]);
        ways.map(|k| self.points[k].distance(self.points[(k + 1) % count])).sum()
    }
}

/// The points of a cut for which `inside` holds, and bridges from where it ends to where it begins again. `None` where nothing
/// is left.
pub fn clip(cut: &Cut, inside: impl Fn(usize) -> bool) -> Option<Outline> {
    let count = cut.points.len();
    let kept: Vec<bool> = (0..count).map(inside).collect();
    if cut.closed && kept.iter().all(|&k| k) {
        return Some(Outline::whole(cut));
    }
    // An open cut begins at its beginning; a closed one after a point that is cut away.
    let first = if cut.closed { kept.iter().position(|&k| !k)? + 1 } else { 0 };
    let mut outline = Outline::default();
    let mut run: Vec<DVec2> = Vec::new();
    for k in (0..count).map(|k| (first + k) % count) {
        if kept[k] {
            run.push(cut.points[k]);
        } else {
            outline.add(&mut run);
        }
    }
    outline.add(&mut run);
    let area = super::section::twice_area(&outline.points);
    if area < 0.0 {
        // Flags belong to the way after a point: reversed, to the one before it.
        outline.points.reverse();
        outline.bridged.reverse();
        outline.bridged.rotate_left(1);
    }
    (outline.points.len() > 2 * FEWEST).then_some(outline)
}

impl Outline {
    fn add(&mut self, run: &mut Vec<DVec2>) {
        if run.len() >= FEWEST {
            self.bridged.extend((1..=run.len()).map(|k| k == run.len()));
            self.points.append(run);
        }
        run.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn circle(count: usize) -> Cut {
        let points = (0..count).map(|k| DVec2::from_angle(TAU * k as f64 / count as f64)).collect();
        Cut { points, edges: vec![(0, 1); count], closed: true }
    }

    #[test]
    fn what_is_cut_away_is_bridged() {
        let cut = circle(60);
        let whole = clip(&cut, |_| true).expect("all of it");
        assert!(whole.bridged.iter().all(|b| !b) && (whole.skin() - cut.length()).abs() < 1e-12);
        let half = clip(&cut, |k| cut.points[k].x > -0.5).expect("most of it");
        assert_eq!(half.bridged.iter().filter(|b| **b).count(), 1);
        assert!((half.skin() - TAU * 2.0 / 3.0).abs() < 0.15, "{}", half.skin());
        let two = clip(&cut, |k| cut.points[k].y.abs() > 0.5).expect("above and below");
        assert_eq!(two.bridged.iter().filter(|b| **b).count(), 2);
        assert!(clip(&cut, |k| k < 3).is_none(), "a scrap is none");
        // Turned round, the bridges stay where they are.
        let mut turned = cut.clone();
        turned.points.reverse();
        let same = clip(&turned, |k| turned.points[k].x > -0.5).expect("most of it");
        assert!((same.skin() - half.skin()).abs() < 1e-12);
        assert!(super::super::section::twice_area(&same.points) > 0.0);
    }
}
