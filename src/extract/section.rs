//! A skin cut by a plane.
//!
//! A crossing keeps the edge that it lies on, so that what is known of the skin's vertices is known along the cut.

use crate::rig::Character;
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// A skin without seams: vertices at one place are one.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Metres, scene space at rest.
    pub positions_rest: Vec<DVec3>,
    /// Corners of every triangle that has three.
    pub triangles: Vec<[u32; 3]>,
    /// Per vertex one of the character's that is there; empty where no character is behind it.
    pub sources: Vec<u32>,
}

impl Surface {
    /// The welded skin of a character.
    pub fn new(character: &Character) -> Surface {
        let mut places = HashMap::new();
        let mut surface = Surface::default();
        let place = |(v, p): (usize, &glam::Vec3)| {
            // Adding zero makes one of the two zeros.
            let key = (*p + glam::Vec3::ZERO).to_array().map(f32::to_bits);
            *places.entry(key).or_insert_with(|| {
                surface.positions_rest.push(p.as_dvec3());
                surface.sources.push(v as u32);
                surface.positions_rest.len() as u32 - 1
            })
        };
        let welded: Vec<u32> = character.positions_rest.iter().enumerate().map(place).collect();
        let corners = character.triangles.iter().map(|t| t.map(|v| welded[v as usize]));
        surface.triangles = corners.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        surface
    }
}

/// A plane with axes in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Where its axes begin, metres in scene space at rest.
    pub origin_rest: DVec3,
    /// Unit axes in the plane, square to each other.
    pub axes: [DVec3; 2],
}

impl Plane {
    /// The plane through a point across a direction, with its first axis as near to `x` as can be.
    pub fn across(origin_rest: DVec3, direction: DVec3, x: DVec3) -> Plane {
        let normal = direction.normalize();
        let flat = x - normal * normal.dot(x);
        let x = if flat.length_squared() > 1e-12 { flat.normalize() } else { normal.any_orthonormal_vector() };
        Plane { origin_rest, axes: [x, normal.cross(x)] }
    }

    /// Unit normal: the two axes and it are right-handed.
    pub fn normal(&self) -> DVec3 {
        self.axes[0].cross(self.axes[1])
    }

    /// From the plane's axes to scene space.
    pub fn to_scene(&self, p: DVec2) -> DVec3 {
        self.origin_rest + self.axes[0] * p.x + self.axes[1] * p.y
    }

    /// From scene space to the plane's axes, along the normal.
    pub fn to_plane(&self, p: DVec3) -> DVec2 {
        let away = p - self.origin_rest;
        DVec2::new(away.dot(self.axes[0]), away.dot(self.axes[1]))
    }
}

/// One line along which a plane cuts a skin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cut {
    /// In the plane's axes, metres; anticlockwise where it is closed.
    pub points: Vec<DVec2>,
    /// Per point the edge that it lies on, by the surface's vertices.
    pub edges: Vec<(u32, u32)>,
    /// Whether its end is its beginning.
    pub closed: bool,
}

impl Cut {
    /// Length, metres.
    pub fn length(&self) -> f64 {
        let closing = usize::from(self.closed);
        let count = self.points.len();
        (1..count + closing).map(|k| self.points[k % count].distance(self.points[k - 1])).sum()
    }

    /// Whether a closed line goes round a point.
    pub fn surrounds(&self, p: DVec2) -> bool {
        self.closed && surrounds(&self.points, p)
    }
}

/// Whether a closed polygon goes round a point (crossings to the right of it).
pub fn surrounds(polygon: &[DVec2], p: DVec2) -> bool {
    let mut inside = false;
    for (k, b) in polygon.iter().enumerate() {
        let a = polygon[(k + polygon.len() - 1) % polygon.len()];
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y) {
            inside = !inside;
        }
    }
    inside
}

/// Twice the signed area of a closed polygon.
pub fn twice_area(polygon: &[DVec2]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum()
}

const NONE: u32 = u32::MAX;

/// All lines along which a plane cuts a surface, the longest first. A vertex in the plane counts as in front of it, so that
/// every triangle is cut in one line or not at all. Where more than two triangles meet in an edge, lines end.
pub fn cut(surface: &Surface, plane: &Plane) -> Vec<Cut> {
    let normal = plane.normal();
    let heights: Vec<f64> = surface.positions_rest.iter().map(|p| (*p - plane.origin_rest).dot(normal)).collect();
    let mut crossings: HashMap<(u32, u32), u32> = HashMap::new();
    let mut edges: Vec<(u32, u32)> = Vec::new();
    let mut links: Vec<[u32; 2]> = Vec::new();
    for triangle in &surface.triangles {
        let front = triangle.map(|v| heights[v as usize] >= 0.0);
        if front[0] == front[1] && front[1] == front[2] {
            continue;
        }
        let mut ends = [NONE; 2];
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            if front[k] == front[(k + 1) % 3] {
                continue;
            }
            let key = (a.min(b), a.max(b));
            let id = *crossings.entry(key).or_insert_with(|| {
                edges.push(key);
                links.push([NONE; 2]);
                edges.len() as u32 - 1
            });
            ends[usize::from(ends[0] != NONE)] = id;
        }
        for (from, to) in [(ends[0], ends[1]), (ends[1], ends[0])] {
            if let Some(free) = links[from as usize].iter_mut().find(|link| **link == NONE) {
                *free = to;
            }
        }
    }
    let point = |id: u32| {
        let (a, b) = edges[id as usize];
        let (below, above) = (heights[a as usize], heights[b as usize]);
        let share = below / (below - above);
        plane.to_plane(surface.positions_rest[a as usize].lerp(surface.positions_rest[b as usize], share))
    };
    let mut cuts = walk(&links, &edges, point);
    cuts.sort_by(|a, b| b.length().total_cmp(&a.length()));
    cuts
}

/// Strings crossings together: open lines from their ends, then closed ones.
fn walk(links: &[[u32; 2]], edges: &[(u32, u32)], point: impl Fn(u32) -> DVec2) -> Vec<Cut> {
    let mut seen = vec![false; links.len()];
    let mut cuts = Vec::new();
    let starts = (0..links.len()).filter(|&id| links[id][1] == NONE).chain(0..links.len());
    for start in starts {
        if seen[start] {
            continue;
        }
        let mut cut = Cut { closed: true, ..Cut::default() };
        let mut id = start as u32;
        loop {
            seen[id as usize] = true;
            cut.points.push(point(id));
            cut.edges.push(edges[id as usize]);
            match links[id as usize].iter().find(|&&next| next != NONE && !seen[next as usize]) {
                Some(&next) => id = next,
                None => break,
            }
        }
        cut.closed = links[start].contains(&id) && links[id as usize].contains(&(start as u32)) && cut.points.len() > 2;
        if cut.closed && twice_area(&cut.points) < 0.0 {
            cut.points.reverse();
            cut.edges.reverse();
        }
        cuts.push(cut);
    }
    cuts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron with its tip up.
    fn tetrahedron() -> Surface {
        let positions_rest = vec![
            DVec3::new(0.0, 0.0, 0.0),
            DVec3::new(1.0, 0.0, 0.0),
            DVec3::new(0.0, 1.0, 0.0),
            DVec3::new(0.0, 0.0, 1.0),
        ];
        Surface { positions_rest, triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], sources: Vec::new() }
    }

    fn level(z: f64) -> Plane {
        Plane::across(DVec3::Z * z, DVec3::Z, DVec3::X)
    }

    #[test]
    fn a_tetrahedron_is_cut_in_triangles() {
        for z in [0.1, 0.25, 0.5] {
            let cuts = cut(&tetrahedron(), &level(z));
            assert_eq!(cuts.len(), 1);
            assert!(cuts[0].closed && cuts[0].points.len() == 3 && cuts[0].edges.contains(&(1, 3)), "{z}");
            let expected = (1.0 - z) * (2.0 + 2.0_f64.sqrt());
            assert!((cuts[0].length() - expected).abs() < 1e-12 && twice_area(&cuts[0].points) > 0.0, "{z}");
            assert!(cuts[0].surrounds(DVec2::splat(0.2 * (1.0 - z))) && !cuts[0].surrounds(DVec2::splat(0.9)));
        }
        assert!(cut(&tetrahedron(), &level(1.5)).is_empty());
    }

    #[test]
    fn a_hole_leaves_an_open_line() {
        let mut open = tetrahedron();
        open.triangles.pop();
        let cuts = cut(&open, &level(0.5));
        assert!(cuts.len() == 1 && !cuts[0].closed && cuts[0].points.len() == 3);
    }

    #[test]
    fn a_plane_goes_there_and_back() {
        let plane = Plane::across(DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.3, -0.5, 1.0), DVec3::X);
        let p = DVec2::new(0.4, -0.7);
        assert!((plane.to_plane(plane.to_scene(p)) - p).length() < 1e-12);
        assert!((plane.normal() - DVec3::new(0.3, -0.5, 1.0).normalize()).length() < 1e-12);
    }
}
