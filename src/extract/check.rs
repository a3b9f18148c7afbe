//! What is odd about a skin that is to be cut.

use super::section::Surface;
use crate::error::ExtractNote;
use std::collections::HashMap;

/// Triangles smaller than this share of the mean one have no area.
const FLAT: f64 = 1e-5;

/// What a surface's triangles are like beside a closed skin's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Edges of one triangle: the skin is open there.
    pub open_edges: usize,
    /// Edges of more than two triangles: lines of a cut end there.
    pub crowded_edges: usize,
    /// Triangles without area.
    pub flat_triangles: usize,
    /// Parts that no edge joins.
    pub shells: usize,
    /// Whether more of the skin looks inward than outward.
    pub inside_out: bool,
}

impl Faults {
    /// Looks at a surface.
    pub fn of(surface: &Surface) -> Faults {
        let mut edges: HashMap<(u32, u32), usize> = HashMap::new();
        let mut root: Vec<u32> = (0..surface.positions_rest.len() as u32).collect();
        let (mut areas, mut volume) = (Vec::with_capacity(surface.triangles.len()), 0.0);
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|v| surface.positions_rest[v as usize]);
            areas.push((b - a).cross(c - a).length());
            volume += a.dot(b.cross(c));
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                *edges.entry((a.min(b), a.max(b))).or_default() += 1;
                let (a, b) = (find(&mut root, a), find(&mut root, b));
                root[a.max(b) as usize] = a.min(b);
            }
        }
        let mean = areas.iter().sum::<f64>() / areas.len().max(1) as f64;
        let mut shells: Vec<u32> = surface.triangles.iter().map(|t| find(&mut root, t[0])).collect();
        shells.sort_unstable();
        shells.dedup();
        Faults {
            open_edges: edges.values().filter(|&&count| count == 1).count(),
            crowded_edges: edges.values().filter(|&&count| count > 2).count(),
            flat_triangles: areas.iter().filter(|&&area| area < FLAT * mean).count(),
            shells: shells.len(),
            inside_out: volume < 0.0,
        }
    }

    /// What of it a person should know.
    pub fn notes(&self) -> Vec<ExtractNote> {
        let some = |count: usize| (count > 0).then_some(count);
        [
            some(self.open_edges).map(|edges| ExtractNote::Open { edges }),
            some(self.crowded_edges).map(|edges| ExtractNote::Crowded { edges }),
            some(self.flat_triangles).map(|triangles| ExtractNote::Flat { triangles }),
            (self.shells > 1).then_some(ExtractNote::Shells { shells: self.shells }),
            self.inside_out.then_some(ExtractNote::InsideOut),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

/// The first vertex of a vertex' shell, with the way there shortened.
fn find(root: &mut [u32], v: u32) -> u32 {
    let mut at = v;
    while root[at as usize] != at {
        root[at as usize] = root[root[at as usize] as usize];
        at = root[at as usize];
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn tetrahedron(at: DVec3) -> Surface {
        let positions_rest = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| p + at).to_vec();
        Surface { positions_rest, triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], sources: Vec::new() }
    }

    #[test]
    fn faults_are_counted() {
        let whole = tetrahedron(DVec3::ZERO);
        assert_eq!(Faults::of(&whole), Faults { shells: 1, ..Faults::default() });
        assert!(Faults::of(&whole).notes().is_empty());
        let mut open = whole.clone();
        open.triangles.pop();
        assert_eq!(Faults::of(&open).open_edges, 3);
        let mut turned = whole.clone();
        turned.triangles.iter_mut().for_each(|t| t.reverse());
        assert!(Faults::of(&turned).inside_out);
        let mut crowded = whole.clone();
        crowded.positions_rest.push(DVec3::ONE);
        crowded.triangles.push([0, 1, 4]);
        assert_eq!(Faults::of(&crowded).crowded_edges, 1);
        let mut flat = whole.clone();
        flat.positions_rest[3] = DVec3::X * 0.5;
        assert_eq!(Faults::of(&flat).flat_triangles, 1);
        let mut two = whole.clone();
        let other = tetrahedron(DVec3::X * 5.0);
        two.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + 4)));
        two.positions_rest.extend(other.positions_rest);
        assert_eq!(Faults::of(&two).shells, 2);
        assert_eq!(Faults::of(&two).notes(), [ExtractNote::Shells { shells: 2 }]);
    }
}
