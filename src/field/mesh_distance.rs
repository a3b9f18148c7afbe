//! Signed distances from a triangle mesh, cached in a grid.
//!
//! Distances are exact: those from the nearest point of any triangle. What is inside is told by the generalised winding
//! number (Jacobson et al. 2013), over half a turn in either sense, so that meshes with holes, with their faces turned
//! inside out, or with shells that overlap have an inside too; far triangles count together as one dipole (Barill et al.
//! 2018). A hole is closed where the winding number is half a turn: there the sign changes, and the distance from the
//! hole's rim stays.
//!
//! Gradients at nodes are unit vectors away from the nearest point. Between nodes they turn smoothly, and shrink where
//! the nearest point jumps from one side to another.

use super::GroupGrid;
use super::grid::FilledGrid;
use crate::error::MeshDistanceError;
use glam::{DMat3, DVec3, Mat4, UVec3, Vec3, Vec4};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicU64, Ordering};

mod tree;

use tree::Tree;

/// Most triangles of a mesh.
const MOST_TRIANGLES: usize = 1_000_000;
/// Most boxes and triangles that all nodes of a grid look at together: six times what a bone of 80,000 triangles needs
/// (440 a node; 120 for 4,800 triangles), and some ten seconds of one core.
const MOST_VISITS: u64 = 200_000_000;
/// Nodes along the longest side of a grid, at least and at most. Between them it has as many as make [`NODES`]: long
/// bones are thin, and their thickness is what muscles lie on.
const LONGEST: [f64; 2] = [48.0, 96.0];
/// What cells may measure, metres: f32 has room for all that is made of them.
const SIZES: std::ops::Range<f64> = 1e-15..1e15;
/// Nodes that a grid is to have together.
const NODES: f64 = 65_536.0;
/// Distance, in cells, up to which the direction from the nearest point is lost to rounding, and the triangle's own
/// normal stands for it.
const ON_SURFACE: f64 = 1e-3;

/// Caches the distance from a mesh around it, up to `margin` (metres, over 0) beyond its box along the columns of `axes`
/// (orthonormal). `support_radius` of the grid is the margin.
///
/// The longest side has 48 to 96 nodes. Triangles without area and those that stand twice do no harm.
///
/// # Errors
/// A mesh without triangles, of more than a million of them, of no finite size, or whose triangles overlap so much that the
/// search for the nearest would take minutes.
pub fn fill(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    axes: DMat3,
    margin: f64,
) -> Result<FilledGrid, MeshDistanceError> {
    fill_within(positions, triangles, axes, margin, MOST_VISITS)
}

/// [`fill`] with the most boxes and triangles to look at.
fn fill_within(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    axes: DMat3,
    margin: f64,
    most_visits: u64,
) -> Result<FilledGrid, MeshDistanceError> {
    if triangles.len() > MOST_TRIANGLES {
        return Err(MeshDistanceError::TooManyTriangles { triangles: triangles.len(), most: MOST_TRIANGLES });
    }
    let corners = distinct(positions, triangles);
    let to_local = axes.transpose();
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in corners.iter().flatten() {
        (lo, hi) = (lo.min(to_local * *corner), hi.max(to_local * *corner));
    }
    (lo, hi) = (lo - margin, hi + margin);
    let longest = (hi - lo).max_element();
    let cell =
        ((hi - lo).element_product() / NODES).cbrt().clamp(longest / (LONGEST[1] - 1.0), longest / (LONGEST[0] - 1.0));
    // Grid coordinates are found in f32: a cell is to be told from its place.
    let place = lo.abs().max(hi.abs()).max_element();
    if corners.is_empty() || !(SIZES.contains(&cell) && place * 1e-5 < cell) {
        return Err(MeshDistanceError::NoSize);
    }
    let size = ((hi - lo) / cell - 1e-9).ceil().max(DVec3::ONE).as_uvec3() + UVec3::ONE;
    let closed = is_closed(&corners);
    let tree = Tree::new(corners);
    let (row, layer) = (size.x as usize, (size.x * size.y) as usize);
    let mut nodes = vec![Vec4::ZERO; layer * size.z as usize];
    let visits = AtomicU64::new(0);
    nodes.par_chunks_mut(row).enumerate().for_each(|(k, line)| {
        // All rows are filled unless the sum passes the bound, whichever comes first: the answer is always the same.
        if visits.load(Ordering::Relaxed) > most_visits {
            return;
        }
        let (y, z) = (k as u32 % size.y, k as u32 / size.y);
        let mut before = Before { within: f64::INFINITY, sign: None };
        let mut seen = 0;
        for (x, node) in line.iter_mut().enumerate() {
            let at = axes * (lo + UVec3::new(x as u32, y, z).as_dvec3() * cell);
            let (distance, gradient) = signed_distance(&tree, at, &before, cell, &mut seen);
            *node = gradient.as_vec3().extend(distance as f32);
            before.within = distance.abs() + cell;
            before.sign = (closed && distance.abs() > 1.001 * cell).then_some(distance.signum());
        }
        visits.fetch_add(seen, Ordering::Relaxed);
    });
    if visits.into_inner() > most_visits {
        return Err(MeshDistanceError::Tangled);
    }
    let to_grid = axes.transpose() * (1.0 / cell);
    let column = |k: usize| to_grid.col(k).as_vec3().extend(0.0);
    let grid = GroupGrid {
        rest_to_grid: Mat4::from_cols(column(0), column(1), column(2), (-lo / cell).as_vec3().extend(1.0)),
        size_x: size.x,
        size_y: size.y,
        size_z: size.z,
        support_radius: margin as f32,
        ..GroupGrid::default()
    };
    Ok(FilledGrid { grid, nodes, cell: cell as f32, raised: 0 })
}

/// Corners of all triangles, each triangle once whichever way it is turned: exporters double faces to have both sides
/// shown, and their windings would cancel.
fn distinct(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[DVec3; 3]> {
    let mut known = HashSet::with_capacity(triangles.len());
    let mut corners = Vec::with_capacity(triangles.len());
    for triangle in triangles {
        let own = triangle.map(|i| positions[i as usize]);
        // 0 + x turns -0 into 0.
        let mut key = own.map(|p| (p + 0.0).to_array().map(f32::to_bits));
        key.sort_unstable();
        if known.insert(key) {
            corners.push(own.map(|p| p.as_dvec3()));
        }
    }
    corners
}

/// Whether every edge is left as often as it is come back by: then the winding number is whole everywhere, and the same
/// wherever one can go without crossing the mesh.
fn is_closed(corners: &[[DVec3; 3]]) -> bool {
    let bits = |p: DVec3| (p + 0.0).to_array().map(f64::to_bits);
    let mut edges: HashMap<_, i32> = HashMap::with_capacity(corners.len() * 3 / 2);
    for &[a, b, c] in corners {
        for (from, to) in [(a, b), (b, c), (c, a)].map(|(from, to)| (bits(from), bits(to))) {
            *edges.entry((from.min(to), from.max(to))).or_default() += (from < to) as i32 - (from > to) as i32;
        }
    }
    edges.values().all(|&left| left == 0)
}

/// What a node's neighbour in its row says of it.
struct Before {
    /// Most distance that it may have: a cell more than the neighbour.
    within: f64,
    /// Its sign, where the mesh cannot lie between the two.
    sign: Option<f64>,
}

/// Distance and gradient at a point.
fn signed_distance(tree: &Tree, p: DVec3, before: &Before, cell: f64, seen: &mut u64) -> (f64, DVec3) {
    let (nearest, triangle) = tree.nearest(p, before.within, seen);
    let sign = before.sign.unwrap_or_else(|| if inside(tree, p, seen) { -1.0 } else { 1.0 });
    let away = p - nearest;
    let distance = away.length();
    if distance > ON_SURFACE * cell {
        return (sign * distance, away * (sign / distance));
    }
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let step = normal * (0.1 * cell);
    let turned = inside(tree, p + step, seen) && !inside(tree, p - step, seen);
    (sign * distance, if turned { -normal } else { normal })
}

fn inside(tree: &Tree, p: DVec3, seen: &mut u64) -> bool {
    tree.winding(p, seen).abs() > 0.5
}

/// The point of a triangle that is nearest to `p`: over its plane, else on its nearest edge.
fn nearest_on_triangle(p: DVec3, [a, b, c]: &[DVec3; 3]) -> DVec3 {
    let normal = (*b - *a).cross(*c - *a);
    let squared = normal.length_squared();
    let over = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) >= 0.0;
    if squared > 0.0 && over(*a, *b) && over(*b, *c) && over(*c, *a) {
        return p - normal * ((p - *a).dot(normal) / squared);
    }
    let edge = |from: DVec3, to: DVec3| {
        let along = to - from;
        let share = (p - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        from + along * share.clamp(0.0, 1.0)
    };
    let nearer = |x: DVec3, y: DVec3| if p.distance_squared(x) <= p.distance_squared(y) { x } else { y };
    nearer(nearer(edge(*a, *b), edge(*b, *c)), edge(*c, *a))
}

/// Share of the whole sphere that a triangle covers from `p`, with its sense (van Oosterom and Strackee 1983).
fn turns(p: DVec3, corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let bottom = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    a.dot(b.cross(c)).atan2(bottom) / TAU
}

/// Share of the whole sphere that far triangles of a summed `area` (as a vector, half the cross product) cover, which
/// are `away` (Barill et al., first term).
fn dipole(away: DVec3, area: DVec3) -> f64 {
    let distance = away.length();
    area.dot(away) / (4.0 * PI * distance * distance * distance)
}

#[cfg(test)]
mod tests;
