//! The surface of a muscle as a closed mesh that follows its axis: to look at, to export, to measure.

use super::{
    AxisPoint, MuscleFrame,
    axis::{NO_DIRECTION, normal_at},
    evaluate::raw_distance,
};
use glam::{DVec3, Vec3, Vec4Swizzles};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// How fine a surface is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detail {
    /// Rings along the axis, at least 2.
    pub rings: u32,
    /// Corners of a ring, at least 3.
    pub around: u32,
}

impl Detail {
    /// Fine enough that the outline is smooth at a few hundred pixels.
    pub const DISPLAY: Detail = Detail { rings: 40, around: 32 };
    /// Fine enough that the volume of the mesh is the surface's to 5e-5 of it.
    pub const MEASURE: Detail = Detail { rings: 320, around: 512 };
}

/// Rings that an end has besides those along the axis, from its rim to its pole: the cap of a blunt end, the last of
/// the tip of a pointed one, so that an end that turns from one into the other keeps its corners.
const CAP_RINGS: u32 = 8;
/// Most steps to the surface along a ray, and the distance in metres at which it is reached.
const STEPS: u32 = 40;
const ON_SURFACE: f32 = 3e-8;

/// A closed mesh, corners counter-clockwise from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Positions in the muscle's space, metres: rings from the origin to the insertion, and the two poles last.
    pub positions: Vec<Vec3>,
    /// Unit normals, outward.
    pub normals: Vec<Vec3>,
    /// Corner indices.
    pub triangles: Vec<[u32; 3]>,
}

/// The surface where `f_M = 0` (equation 1). `points` are the muscle's own; one that is not present has an empty mesh.
///
/// Every vertex but the poles is found along a ray across the axis, so that it lies on the field's own surface also where
/// the axis bends. A blunt end (exponent 1) gets the rounded cap that its field has. Corners are the same at the same
/// detail whatever the muscle's shape, so that the meshes of a motion are one mesh that moves.
pub fn surface(muscle: &MuscleFrame, points: &[AxisPoint], detail: Detail) -> Surface {
    let mut surface = Surface::default();
    if muscle.present == 0 {
        return surface;
    }
    let around = detail.around.max(3);
    let stations = stations(detail, [0.0, 1.0].map(|s| muscle.profile().at(s).0 > 0.0));
    for &(s, tilt) in &stations {
        let frame = Frame::at(points, s * muscle.length);
        for k in 0..around {
            surface.add(muscle, points, &frame, tilt, TAU * k as f32 / around as f32, s);
        }
    }
    for (s, tilt) in [(0.0, -FRAC_PI_2), (1.0, FRAC_PI_2)] {
        surface.add(muscle, points, &Frame::at(points, s * muscle.length), tilt, 0.0, s);
    }
    surface.close(stations.len() as u32, around);
    surface
}

/// Share of the length and tilt towards the insertion of every ring, from the origin to the insertion.
fn stations(detail: Detail, blunt: [bool; 2]) -> Vec<(f32, f32)> {
    let rings = detail.rings.max(2);
    // Closer together towards both ends, where the profile curves most.
    let along = |i: u32| 0.5 - 0.5 * (PI * i as f32 / rings as f32).cos();
    let end = |i: u32, blunt: bool| {
        let share = i as f32 / CAP_RINGS as f32;
        // A pointed end has no ring at its tip, but its pole.
        if blunt { (0.0, (share - 1.0) * FRAC_PI_2) } else { (along(1) * i as f32 / (CAP_RINGS + 1) as f32, 0.0) }
    };
    let first = (1..=CAP_RINGS).map(|i| end(i, blunt[0]));
    let last = (1..=CAP_RINGS).rev().map(|i| end(i, blunt[1])).map(|(s, tilt)| (1.0 - s, -tilt));
    first.chain((1..rings).map(|i| (along(i), 0.0))).chain(last).collect()
}

/// Where rings stand: a point of the axis with smooth directions, so that rings on either side of a bend do not cross.
pub(crate) struct Frame {
    /// The point of the axis, metres.
    pub(crate) center: Vec3,
    tangent: Vec3,
    normal: Vec3,
    binormal: Vec3,
}

impl Frame {
    /// At a distance along the axis, metres.
    pub(crate) fn at(points: &[AxisPoint], arc: f32) -> Frame {
        let last = points.len() - 2;
        let i = points[1..=last].partition_point(|p| p.arc() <= arc);
        let point = &points[i];
        let share = ((arc - point.arc()) / point.tangent.w.max(NO_DIRECTION)).clamp(0.0, 1.0);
        let own = point.tangent.xyz();
        let bisector = |j: usize| {
            let before = points[j.saturating_sub(1)].tangent.xyz();
            (before + points[j.min(last)].tangent.xyz()).normalize_or(own)
        };
        let (start, end) = (if i == 0 { own } else { bisector(i) }, if i == last { own } else { bisector(i + 1) });
        let tangent = start.lerp(end, share).normalize_or(own);
        let (wanted, _) = normal_at(point, share);
        let normal = wanted.reject_from_normalized(tangent).normalize_or(tangent.any_orthonormal_vector());
        let center = point.position.xyz() + own * (share * point.tangent.w);
        Frame { center, tangent, normal, binormal: tangent.cross(normal) }
    }

    /// A point of the axis' space along normal, binormal and tangent.
    pub(crate) fn local(&self, p: Vec3) -> Vec3 {
        let beside = p - self.center;
        Vec3::new(beside.dot(self.normal), beside.dot(self.binormal), beside.dot(self.tangent))
    }

    /// The way back, as a vector from the frame's point.
    pub(crate) fn scene(&self, beside: Vec3) -> Vec3 {
        self.normal * beside.x + self.binormal * beside.y + self.tangent * beside.z
    }
}

impl Surface {
    /// The corners of [`surface`] at a detail with every vertex at one point: a muscle without a field, in a sequence.
    pub fn collapsed(detail: Detail, at: Vec3) -> Surface {
        let (rings, around) = (stations(detail, [false; 2]).len() as u32, detail.around.max(3));
        let count = (rings * around + 2) as usize;
        let mut surface = Surface { positions: vec![at; count], normals: vec![Vec3::Y; count], triangles: Vec::new() };
        surface.close(rings, around);
        surface
    }

    /// A closed mesh of rings of `around` vertices each, anticlockwise about the way from the first pole to the second. Normals are
    /// those of the triangles around a vertex, by their areas.
    pub fn of_rings(mut positions: Vec<Vec3>, around: u32, poles: [Vec3; 2]) -> Surface {
        let rings = positions.len() as u32 / around;
        positions.extend(poles);
        let mut surface = Surface { normals: vec![Vec3::ZERO; positions.len()], positions, triangles: Vec::new() };
        surface.close(rings, around);
        for t in &surface.triangles {
            let [a, b, c] = t.map(|i| surface.positions[i as usize]);
            let area = (b - a).cross(c - a);
            t.iter().for_each(|&i| surface.normals[i as usize] += area);
        }
        surface.normals.iter_mut().for_each(|n| *n = n.normalize_or(Vec3::Y));
        surface
    }

    /// Adds the surface's point on the ray from the axis at an angle `theta` from the section's long axis, tilted from
    /// the section towards the insertion.
    fn add(&mut self, muscle: &MuscleFrame, points: &[AxisPoint], frame: &Frame, tilt: f32, theta: f32, s: f32) {
        let across = frame.normal * theta.cos() + frame.binormal * theta.sin();
        let ray = across * tilt.cos() + frame.tangent * tilt.sin();
        let mut away = muscle.radius(s, ray.dot(frame.normal));
        let mut normal = ray;
        let (mut inside, mut outside) = (0.0, f32::INFINITY);
        for _ in 0..STEPS {
            let Some((distance, gradient)) = raw_distance(muscle, points, frame.center + ray * away) else { break };
            normal = gradient.normalize_or(ray);
            if distance.abs() < ON_SURFACE {
                break;
            }
            *(if distance < 0.0 { &mut inside } else { &mut outside }) = away;
            // Newton's step along the ray, or the middle where it leaves what is known.
            let next = away - distance / gradient.dot(ray);
            let middle = if outside < f32::INFINITY { 0.5 * (inside + outside) } else { 2.0 * away };
            away = if next > inside && next < outside { next } else { middle };
        }
        self.positions.push(frame.center + ray * away);
        self.normals.push(normal);
    }

    /// Joins `rings` rings of `around` vertices and the two poles behind them.
    fn close(&mut self, rings: u32, around: u32) {
        for ring in 0..rings - 1 {
            for k in 0..around {
                let [a, b] = [k, (k + 1) % around].map(|k| ring * around + k);
                let [c, d] = [a + around, b + around];
                self.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        let pole = rings * around;
        for k in 0..around {
            let next = (k + 1) % around;
            let end = (rings - 1) * around;
            self.triangles.extend([[pole, next, k], [pole + 1, end + k, end + next]]);
        }
    }

    /// Enclosed volume, cubic metres, by the divergence theorem in f64.
    pub fn volume(&self) -> f64 {
        let at = |i: u32| self.positions[i as usize].as_dvec3();
        let base = self.positions.first().map_or(DVec3::ZERO, |p| p.as_dvec3());
        let corners = self.triangles.iter().map(|t| t.map(|i| at(i) - base));
        corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{arc_muscle, muscle};
    use super::*;
    use crate::field::muscle::evaluate;
    use std::collections::HashMap;

    fn is_closed(surface: &Surface) -> bool {
        let mut edges = HashMap::new();
        for t in &surface.triangles {
            for k in 0..3 {
                *edges.entry((t[k], t[(k + 1) % 3])).or_insert(0) += 1;
            }
        }
        edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
    }

    #[test]
    fn every_vertex_lies_on_the_fields_surface_and_the_mesh_is_closed() {
        for (bend, alpha, beta, e) in [(0.0, 3, 4, 0.6), (2.0, 4, 7, 0.8), (2.6, 3, 3, 0.0), (1.0, 1, 3, 0.5)] {
            let (m, points) = arc_muscle(bend, 29, (alpha, beta), e);
            let surface = surface(&m, &points, Detail::DISPLAY);
            assert!(is_closed(&surface), "bend {bend}");
            for (p, n) in surface.positions[..surface.positions.len() - 2].iter().zip(&surface.normals) {
                // A pointed tip is thinner than a distance can be told.
                let tip = [points[0], points[29]].iter().any(|end| p.distance(end.position.xyz()) < 2e-3);
                let off = raw_distance(&m, &points, *p).map_or(if tip { 0.0 } else { 1.0 }, |(d, _)| d.abs());
                assert!(off < 1e-6, "bend {bend}: {p} is {off} off");
                if tip {
                    continue;
                }
                let off = evaluate(&m, &points, *p + *n * 2e-3).value;
                assert!(off < 0.49, "outward along the normal: {off}");
            }
        }
    }

    #[test]
    fn corners_are_the_same_whatever_the_shape() {
        let mesh = |alpha, beta| {
            let (m, points) = arc_muscle(1.0, 29, (alpha, beta), 0.5);
            surface(&m, &points, Detail::DISPLAY)
        };
        let round = mesh(3, 3);
        let scale = round.volume();
        for (alpha, beta) in [(1, 3), (3, 1), (1, 1), (4, 7)] {
            let other = mesh(alpha, beta);
            assert!(is_closed(&other), "({alpha}, {beta})");
            assert_eq!((other.triangles == round.triangles, other.positions.len()), (true, round.positions.len()));
            assert!(other.volume() / scale > 0.9, "({alpha}, {beta}): {}", other.volume() / scale);
        }
        let none = Surface::collapsed(Detail::DISPLAY, Vec3::X);
        assert_eq!((none.positions.len(), &none.triangles), (round.positions.len(), &round.triangles));
        let coarse = Surface::collapsed(Detail { rings: 39, ..Detail::DISPLAY }, Vec3::X);
        assert!(coarse.triangles != round.triangles, "other rings, other corners");
    }

    #[test]
    fn an_end_that_turns_pointed_keeps_its_vertices_in_place() {
        // On the way from a blunt origin to a pointed one, as activation takes it; the last step crosses over.
        let mesh = |share: f32| {
            let (mut m, points) = arc_muscle(1.0, 29, (3, 3), 0.5);
            let blend = crate::field::muscle::Profile::blend(&[((1, 3), share), ((3, 3), 1.0 - share)]);
            (m.factors, m.exponents, m.terms) = (blend.factors, blend.exponents, blend.terms);
            (surface(&m, &points, Detail::DISPLAY), m.length)
        };
        let farthest = |a: &Surface, b: &Surface| {
            a.positions.iter().zip(&b.positions).map(|(p, q)| p.distance(*q)).fold(0.0f32, f32::max)
        };
        let ((pointed, length), (nearly, _), (blunt, _)) = (mesh(0.0), mesh(1e-3), mesh(0.5));
        assert!(farthest(&pointed, &nearly) < 3e-3 * length, "{}", farthest(&pointed, &nearly));
        assert!(farthest(&pointed, &blunt) > 3e-2 * length, "{}", farthest(&pointed, &blunt));
    }

    #[test]
    fn the_meshs_volume_converges_to_its_own_tenth_of_a_bound() {
        // A measure must be five times as sharp as the bound it serves, .1 % straight: here against pi w^2 l, exact
        // for a straight axis, and against a mesh twice as fine where it bends.
        let (m, points) = muscle(0.6, (3, 3));
        let exact = std::f64::consts::PI * f64::from(m.width).powi(2) * f64::from(m.length);
        let found = surface(&m, &points, Detail::MEASURE).volume();
        assert!((found / exact - 1.0).abs() < 2e-4, "{}", found / exact - 1.0);
        let coarse = surface(&m, &points, Detail { rings: 10, around: 12 }).volume();
        assert!((coarse / exact - 1.0).abs() > 1e-2, "a coarse mesh must be seen: {}", coarse / exact - 1.0);
        let (bent, points) = arc_muscle(2.6, 29, (3, 3), 0.0);
        let finer = Detail { rings: 2 * Detail::MEASURE.rings, around: 2 * Detail::MEASURE.around };
        let ratio = surface(&bent, &points, Detail::MEASURE).volume() / surface(&bent, &points, finer).volume();
        assert!((ratio - 1.0).abs() < 2e-4, "{}", ratio - 1.0);
    }

    /// Largest error of the volume over bends up to 150 degrees.
    fn worst_volume(widen: f32, bend: std::ops::RangeInclusive<u32>) -> f64 {
        let mut worst = 0.0f64;
        for degrees in bend.step_by(30) {
            let shapes = [((3, 3), 0.0), ((4, 7), 0.0), ((3, 3), 0.7), ((2, 3), 0.5), ((3, 3), -0.6)];
            for (exponents, e) in shapes {
                let (mut m, points) = arc_muscle((degrees as f32).to_radians(), 29, exponents, e);
                let expected = std::f64::consts::PI * f64::from(m.width).powi(2) * f64::from(m.length);
                m.width *= widen;
                let error = surface(&m, &points, Detail::MEASURE).volume() / expected - 1.0;
                worst = if error.abs() > worst.abs() { error } else { worst };
            }
        }
        worst
    }

    #[test]
    fn volume_is_kept_straight_and_bent() {
        let straight = worst_volume(1.0, 0..=0);
        assert!(straight.abs() < 1e-3, "straight: {straight}");
        let bent = worst_volume(1.0, 30..=150);
        assert!(bent.abs() < 1e-2, "bent by up to 150 degrees: {bent}");
        let wider = worst_volume(1.01, 0..=0);
        assert!(wider.abs() > 1e-2, "a muscle 1 % wider must be seen: {wider}");
    }
}
