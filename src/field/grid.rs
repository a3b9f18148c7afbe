//! A group's raw field cached in an oriented grid, and the trilinear look-up that a kernel repeats.
//!
//! Nodes hold the gradient and the distance of the interpolant itself (background 1.7); both are interpolated, the
//! gradient is not differenced. Outside the box there is no field: the box is grown until the distance on its faces is
//! at least the support radius, and where growth has to stop the distances on the faces are raised to it.

use super::GroupGrid;
use super::hrbf::Hrbf;
use glam::{DMat3, DVec3, Mat4, UVec3, Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

/// Points per side of a face at which growth looks at the distance.
const FACE_PROBES: u32 = 12;
/// One step of growth, in support radii.
const GROWTH_STEP: f64 = 0.25;
/// Steps a face may grow at most: 3 support radii beyond the samples.
const GROWTH_STEPS: u32 = 12;

/// A filled grid that is not yet part of a shared node array: its offset is 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilledGrid {
    /// The grid without offset, muscles and joint.
    pub grid: GroupGrid,
    /// Its nodes, x fastest.
    pub nodes: Vec<Vec4>,
    /// Edge of a cell, metres.
    pub cell: f32,
    /// Nodes on the faces whose distance was raised to the support radius.
    pub raised: u32,
}

/// Caches `hrbf` around its centres, `resolution` nodes along the longest side of a box whose axes are the columns of
/// `axes` (orthonormal), until `support_radius` (metres) closes.
///
/// `resolution` is at least 2; the interpolant has at least one centre.
pub fn fill(hrbf: &Hrbf, axes: DMat3, support_radius: f64, resolution: u32) -> FilledGrid {
    let (lo, hi) = closed_box(hrbf, axes, support_radius);
    let cell = (hi - lo).max_element() / f64::from(resolution - 1);
    let size = ((hi - lo) / cell - 1e-9).ceil().max(DVec3::ONE).as_uvec3() + UVec3::ONE;
    let (row, layer) = (size.x as usize, (size.x * size.y) as usize);
    let radius = support_radius as f32;
    let mut nodes = vec![Vec4::ZERO; layer * size.z as usize];
    let raised = nodes
        .par_chunks_mut(row)
        .enumerate()
        .map(|(k, line)| {
            let (y, z) = (k as u32 % size.y, k as u32 / size.y);
            let mut raised = 0;
            for (x, node) in line.iter_mut().enumerate() {
                let at = UVec3::new(x as u32, y, z);
                let (value, gradient) = hrbf.sample(axes * (lo + at.as_dvec3() * cell));
                *node = gradient.as_vec3().extend(value as f32);
                if (at.cmpeq(UVec3::ZERO) | at.cmpeq(size - UVec3::ONE)).any() && node.w < radius {
                    node.w = radius;
                    raised += 1;
                }
            }
            raised
        })
        .sum();
    let to_grid = axes.transpose() * (1.0 / cell);
    let column = |k: usize| to_grid.col(k).as_vec3().extend(0.0);
    let grid = GroupGrid {
        rest_to_grid: Mat4::from_cols(column(0), column(1), column(2), (-lo / cell).as_vec3().extend(1.0)),
        size_x: size.x,
        size_y: size.y,
        size_z: size.z,
        support_radius: radius,
        ..GroupGrid::default()
    };
    FilledGrid { grid, nodes, cell: cell as f32, raised }
}

/// The box around the centres, along `axes`, grown face by face until the field is closed or growth ends.
fn closed_box(hrbf: &Hrbf, axes: DMat3, support_radius: f64) -> (DVec3, DVec3) {
    let to_local = axes.transpose();
    let step = GROWTH_STEP * support_radius;
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &c in &hrbf.centres {
        (lo, hi) = (lo.min(to_local * c), hi.max(to_local * c));
    }
    (lo, hi) = (lo - DVec3::splat(step), hi + DVec3::splat(step));
    for _ in 1..GROWTH_STEPS {
        let open: Vec<bool> =
            (0..6_usize).into_par_iter().map(|f| face_is_open(hrbf, axes, lo, hi, f, support_radius)).collect();
        if !open.contains(&true) {
            break;
        }
        for axis in 0..3 {
            lo[axis] -= if open[2 * axis] { step } else { 0.0 };
            hi[axis] += if open[2 * axis + 1] { step } else { 0.0 };
        }
    }
    (lo, hi)
}

/// Whether the distance falls below `support_radius` at a probe on face `f`: axis `f / 2`, low side where `f` is even.
fn face_is_open(hrbf: &Hrbf, axes: DMat3, lo: DVec3, hi: DVec3, f: usize, support_radius: f64) -> bool {
    let (axis, second, third) = (f / 2, (f / 2 + 1) % 3, (f / 2 + 2) % 3);
    (0..FACE_PROBES * FACE_PROBES).any(|k| {
        let at = |probe: u32| f64::from(probe) / f64::from(FACE_PROBES - 1);
        let mut t = DVec3::ZERO;
        t[axis] = (f % 2) as f64;
        t[second] = at(k % FACE_PROBES);
        t[third] = at(k / FACE_PROBES);
        hrbf.sample(axes * (lo + (hi - lo) * t)).0 < support_radius
    })
}

/// Raw distance (metres) and gradient of a group's field at a point in scene space at rest; `None` outside its box.
///
/// `nodes` is the array that the grid's offset refers to. Plain f32 operations in a fixed order, for a kernel to
/// repeat: `u = c0 x + c1 y + c2 z + c3`, `cell = min(u32(u), size - 2)`, then `a + (b - a) t` along x, y, z.
#[inline]
pub fn sample(grid: &GroupGrid, nodes: &[Vec4], p_rest: Vec3) -> Option<(f32, Vec3)> {
    let m = &grid.rest_to_grid;
    let u = m.x_axis.xyz() * p_rest.x + m.y_axis.xyz() * p_rest.y + m.z_axis.xyz() * p_rest.z + m.w_axis.xyz();
    let size = UVec3::new(grid.size_x, grid.size_y, grid.size_z);
    if !(u.cmpge(Vec3::ZERO).all() && u.cmple((size - UVec3::ONE).as_vec3()).all()) {
        return None;
    }
    let at = u.as_uvec3().min(size - UVec3::splat(2));
    let t = u - at.as_vec3();
    let first = (grid.offset + at.x + grid.size_x * (at.y + grid.size_y * at.z)) as usize;
    let (row, layer) = (grid.size_x as usize, (grid.size_x * grid.size_y) as usize);
    let along_x = |k: usize| nodes[k] + (nodes[k + 1] - nodes[k]) * t.x;
    let along_y = |k: usize| {
        let (a, b) = (along_x(k), along_x(k + row));
        a + (b - a) * t.y
    };
    let (a, b) = (along_y(first), along_y(first + layer));
    let node = a + (b - a) * t.z;
    Some((node.w, node.xyz()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::hrbf::HermiteSample;

    const SUPPORT: f64 = 0.06;

    /// A capsule of radius .08 along a slanted axis, by 80 golden-angle samples and two end points.
    fn capsule() -> (Hrbf, DMat3) {
        let x = DVec3::new(0.6, -0.3, 0.2).normalize();
        let (y, z) = x.any_orthonormal_pair();
        let mut samples: Vec<HermiteSample> = (0..80)
            .map(|k| {
                let angle = f64::from(k) * 2.399_963_229_728_653;
                let normal = y * angle.cos() + z * angle.sin();
                let along = x * (f64::from(k) / 79.0 - 0.5) * 0.3;
                HermiteSample { position: DVec3::new(0.2, 1.4, 0.1) + along + normal * 0.08, normal }
            })
            .collect();
        for end in [-1.0, 1.0] {
            let position = DVec3::new(0.2, 1.4, 0.1) + x * end * 0.23;
            samples.push(HermiteSample { position, normal: x * end });
        }
        (Hrbf::fit(&samples).unwrap(), DMat3::from_cols(x, y, z))
    }

    /// Largest errors of distance and gradient over points with |d| < r.
    fn worst_error(hrbf: &Hrbf, filled: &FilledGrid) -> (f64, f64) {
        let (mut distance, mut direction, mut seen) = (0.0_f64, 0.0_f64, 0);
        for k in 0..4000 {
            let t = f64::from(k);
            let p = DVec3::new(0.2, 1.4, 0.1) + DVec3::new((t * 1.7).sin(), (t * 0.9).cos(), (t * 2.3).sin()) * 0.16;
            let (value, gradient) = hrbf.sample(p);
            if value.abs() < SUPPORT {
                let (d, g) = sample(&filled.grid, &filled.nodes, p.as_vec3()).unwrap();
                distance = distance.max((f64::from(d) - value).abs());
                direction = direction.max((g.as_dvec3() - gradient).length());
                seen += 1;
            }
        }
        assert!(seen > 300, "{seen}");
        (distance, direction)
    }

    #[test]
    fn look_up_agrees_with_the_interpolant_and_improves_quadratically() {
        let (hrbf, axes) = capsule();
        let at = |resolution| worst_error(&hrbf, &fill(&hrbf, axes, SUPPORT, resolution));
        let (coarse, fine, finest) = (at(24), at(48), at(96));
        // Trilinear interpolation errs by cell² / 8 times the sum of second derivatives, about 2 / R along the limb:
        // a cell of 12 mm on R = 80 mm gives 0.45 mm, and more around the tips.
        assert!(fine.0 < 0.015 * SUPPORT, "{fine:?}");
        for (a, b) in [(coarse.0, fine.0), (fine.0, finest.0)] {
            assert!(a / b > 3.0 && a / b < 5.5, "{coarse:?} {fine:?} {finest:?}");
        }
        assert!(fine.1 < 0.05, "{fine:?}");
    }

    #[test]
    fn a_disturbed_node_is_noticed() {
        let (hrbf, axes) = capsule();
        let mut filled = fill(&hrbf, axes, SUPPORT, 48);
        let middle = filled.nodes.len() / 2 + 5;
        for node in &mut filled.nodes[middle - 400..middle] {
            node.w += 2e-3;
        }
        assert!(worst_error(&hrbf, &filled).0 > 0.015 * SUPPORT);
    }

    #[test]
    fn nodes_sit_at_whole_coordinates() {
        let (hrbf, axes) = capsule();
        let filled = fill(&hrbf, axes, SUPPORT, 16);
        let back = filled.grid.rest_to_grid.as_dmat4().inverse();
        let (sx, sy, sz) = (filled.grid.size_x, filled.grid.size_y, filled.grid.size_z);
        assert_eq!(sx.max(sy).max(sz), 16);
        for (x, y, z) in [(1, 1, 1), (sx - 2, 2, 1), (3, sy - 2, sz - 2), (sx / 2, sy / 2, sz / 2)] {
            let p = back.transform_point3(UVec3::new(x, y, z).as_dvec3());
            let node = filled.nodes[(x + sx * (y + sy * z)) as usize];
            assert!((f64::from(node.w) - hrbf.sample(p).0).abs() < 1e-6);
            let (d, g) = sample(&filled.grid, &filled.nodes, p.as_vec3()).unwrap();
            assert!((d - node.w).abs() < 1e-5 && (g - node.xyz()).length() < 1e-4);
        }
    }

    #[test]
    fn support_is_closed_on_every_face() {
        let (hrbf, axes) = capsule();
        let filled = fill(&hrbf, axes, SUPPORT, 24);
        let back = filled.grid.rest_to_grid.inverse();
        let last = UVec3::new(filled.grid.size_x, filled.grid.size_y, filled.grid.size_z).as_vec3() - Vec3::ONE;
        for k in 0..600 {
            let t = k as f32;
            let mut u = Vec3::new((t * 0.37).fract(), (t * 0.61).fract(), (t * 0.83).fract()) * last;
            u = u.clamp(Vec3::splat(1e-3), last - 1e-3);
            u[k % 3] = if k % 2 == 0 { 1e-3 } else { last[k % 3] - 1e-3 };
            let (d, _) = sample(&filled.grid, &filled.nodes, back.transform_point3(u)).unwrap();
            assert!(d >= filled.grid.support_radius * 0.99, "{d}");
        }
        // An infinite slab can never close: its faces are raised instead.
        let slab: Vec<_> = (0..25)
            .map(|k| HermiteSample {
                position: DVec3::new(f64::from(k % 5) * 0.1, f64::from(k / 5) * 0.1, 0.0),
                normal: DVec3::Z,
            })
            .collect();
        let slab = Hrbf::fit(&slab).unwrap();
        let filled = fill(&slab, DMat3::IDENTITY, SUPPORT, 24);
        assert!(filled.raised > 0 && filled.nodes.iter().all(|n| n.is_finite()));
    }

    #[test]
    fn outside_and_nan_give_nothing() {
        let (hrbf, axes) = capsule();
        let filled = fill(&hrbf, axes, SUPPORT, 16);
        for p in [Vec3::splat(5.0), Vec3::NAN, Vec3::INFINITY, Vec3::new(0.2, f32::NAN, 0.1)] {
            assert_eq!(sample(&filled.grid, &filled.nodes, p), None);
        }
        assert!(sample(&filled.grid, &filled.nodes, Vec3::new(0.2, 1.4, 0.1)).is_some());
    }
}
