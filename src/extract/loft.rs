//! A muscle's surface as its sections tell it: ellipses lofted along the root curve, with Hermite ends to origin and insertion
//! (paper B, "Muscle Construction"; background 6.3), and how it moves with the muscle's axis (figure 2 b-e).

use super::chain::{Link, Section};
use crate::field::muscle::{
    AxisPoint,
    mesh::{Frame, Surface},
};
use glam::{DVec2, DVec3, Mat3, Mat4, Vec3, Vec4Swizzles};
use std::f64::consts::TAU;

/// Corners of a ring.
pub const AROUND: usize = 24;
/// Rings between the last section and an end.
const END_RINGS: usize = 5;
/// Sections before and after one whose ellipses it is smoothed with.
const MEDIAN: usize = 2;
/// A corner is no farther out than this share of the skin.
const UNDER_SKIN: f64 = 0.97;
/// Least thickening that keeps the volume; beyond it the muscle is stretched so far that it thins evenly (background 6.6).
const THINNEST: f64 = 0.3;

/// A closed surface of rings from the origin to the insertion, metres in scene space at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Loft {
    /// Corners of every ring, anticlockwise as seen from the insertion; the first ones lie towards the skin.
    pub rings_rest: Vec<[DVec3; AROUND]>,
    /// Where it ends: origin and insertion.
    pub ends_rest: [DVec3; 2],
}

/// An ellipse in the plane of a section, about the root curve.
#[derive(Clone, Copy)]
struct Oval {
    centre: DVec2,
    /// Unit vector from there to the skin.
    outward: DVec2,
    /// Direction of the long axis against that, doubled: an axis has no sign.
    doubled: DVec2,
    long: f64,
    short: f64,
}

impl Oval {
    fn new(section: &Section, bump: usize, root_rest: DVec3) -> Oval {
        let ellipse = &section.ellipses[bump];
        let centre = section.plane.to_plane(root_rest);
        let outward = (section.plane.to_plane(section.tip_rest(bump)) - centre).normalize_or(DVec2::X);
        let doubled = DVec2::from_angle(2.0 * (ellipse.angle - outward.to_angle()));
        Oval { centre, outward, doubled, long: ellipse.long, short: ellipse.short }
    }

    /// Distance of the ellipse from the root curve along a unit vector of the plane.
    fn radius(&self, way: DVec2) -> f64 {
        let long_way = self.outward.rotate(DVec2::from_angle(0.5 * self.doubled.to_angle()));
        let (along, across) = (way.dot(long_way) / self.long, way.perp_dot(long_way) / self.short);
        1.0 / along.hypot(across).max(1e-9)
    }

    /// One that is no thicker than the root curve is deep.
    fn within(mut self, depth: f64) -> Oval {
        let out = self.radius(self.outward);
        if out > depth {
            self.short *= depth / out;
        }
        self
    }
}

impl Loft {
    /// The surface of a muscle that a chain of bumps tells, about its root curve; `None` with less than two sections.
    ///
    /// Half axes are medians over neighbouring sections and angles their means, because an ellipse sees less than half of its
    /// muscle. What would stand out of the skin is drawn under it.
    pub(super) fn new(
        sections: &[Section],
        links: &[Link],
        roots_rest: &[DVec3],
        ends_rest: [DVec3; 2],
    ) -> Option<Loft> {
        let ovals: Vec<Oval> =
            links.iter().zip(roots_rest).map(|(l, root)| Oval::new(&sections[l.section], l.bump, *root)).collect();
        let rings: Vec<[DVec3; AROUND]> = (0..links.len())
            .map(|k| {
                let section = &sections[links[k].section];
                let tip = section.plane.to_plane(section.tip_rest(links[k].bump));
                let oval = smoothed(&ovals, k).within(tip.distance(ovals[k].centre));
                ring(section, &oval, ends_rest[1] - ends_rest[0])
            })
            .collect();
        let (first, last) = (rings.first()?, rings.last()?);
        let (second, before) = (rings.get(1)?, rings.get(rings.len().checked_sub(2)?)?);
        let mut rings_rest = end(first, second, ends_rest[0]);
        rings_rest.reverse();
        let to_insertion = end(last, before, ends_rest[1]);
        rings_rest.extend(rings);
        rings_rest.extend(to_insertion);
        Some(Loft { rings_rest, ends_rest })
    }

    /// The root curve: the middles of the rings between both ends.
    pub fn curve_rest(&self) -> Vec<DVec3> {
        let middles = self.rings_rest.iter().map(|ring| ring.iter().sum::<DVec3>() / AROUND as f64);
        std::iter::once(self.ends_rest[0]).chain(middles).chain([self.ends_rest[1]]).collect()
    }

    /// As a mesh at rest, scene space.
    pub fn surface_rest(&self) -> Surface {
        let rings: Vec<Vec3> = self.rings_rest.iter().flatten().map(|p| p.as_vec3()).collect();
        Surface::of_rings(rings, AROUND as u32, self.ends_rest.map(|p| p.as_vec3()))
    }

    /// Tied to an axis at rest, whose points are in scene space at rest too.
    pub fn bound(&self, axis_rest: &[AxisPoint]) -> Bound {
        let length = axis_rest.windows(2).map(|w| w[0].position.xyz().distance(w[1].position.xyz())).sum();
        let corner = |p: &DVec3| {
            let p = p.as_vec3();
            let share = share_of(axis_rest, p) / length;
            Corner { share, beside: Frame::at(axis_rest, share * length).local(p) }
        };
        let corners = self.rings_rest.iter().flatten().chain(&self.ends_rest).map(corner).collect();
        let mut bound = Bound { corners, length, areas: [0.0; 3] };
        bound.areas = bound.areas();
        bound
    }
}

/// The ellipse of a section, smoothed over its neighbours.
fn smoothed(ovals: &[Oval], k: usize) -> Oval {
    let around = &ovals[k.saturating_sub(MEDIAN)..(k + MEDIAN + 1).min(ovals.len())];
    let median = |of: fn(&Oval) -> f64| {
        let mut values: Vec<f64> = around.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let doubled = around.iter().map(|o| o.doubled).sum::<DVec2>().normalize_or(ovals[k].doubled);
    Oval { doubled, long: median(|o| o.long), short: median(|o| o.short), ..ovals[k] }
}

/// The corners of an ellipse, anticlockwise about the muscle's way, none of them out of the skin.
fn ring(section: &Section, oval: &Oval, way: DVec3) -> [DVec3; AROUND] {
    let turn = if section.plane.normal().dot(way) < 0.0 { -1.0 } else { 1.0 };
    std::array::from_fn(|k| {
        let out = oval.outward.rotate(DVec2::from_angle(turn * TAU * k as f64 / AROUND as f64));
        let skin = section.skin_along(oval.centre, out).unwrap_or(f64::INFINITY);
        section.plane.to_scene(oval.centre + out * oval.radius(out).min(UNDER_SKIN * skin))
    })
}

/// Rings from a muscle's last section to its end: cubic Hermite curves from every corner, which begin as the muscle goes on from
/// the section before and arrive along the root curve.
fn end(last: &[DVec3; AROUND], before: &[DVec3; AROUND], end_rest: DVec3) -> Vec<[DVec3; AROUND]> {
    let middle = last.iter().sum::<DVec3>() / AROUND as f64;
    let arrival = (end_rest - middle).normalize_or_zero();
    let at = |k: usize, t: f64| {
        let length = last[k].distance(end_rest);
        let start = (last[k] - before[k]).normalize_or_zero() * length;
        let (t2, t3) = (t * t, t * t * t);
        last[k] * (2.0 * t3 - 3.0 * t2 + 1.0)
            + start * (t3 - 2.0 * t2 + t)
            + end_rest * (3.0 * t2 - 2.0 * t3)
            + arrival * (length * (t3 - t2))
    };
    (1..=END_RINGS).map(|r| std::array::from_fn(|k| at(k, r as f64 / (END_RINGS + 1) as f64))).collect()
}

/// How far along a polyline the point is that is nearest to `p`, metres.
fn share_of(points: &[AxisPoint], p: Vec3) -> f32 {
    let mut best = (f32::MAX, 0.0);
    let mut before = 0.0;
    for pair in points.windows(2) {
        let (from, way) = (pair[0].position.xyz(), pair[1].position.xyz() - pair[0].position.xyz());
        let share = ((p - from).dot(way) / way.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let off = p.distance_squared(from + way * share);
        if off < best.0 {
            best = (off, before + way.length() * share);
        }
        before += way.length();
    }
    best.1
}

/// A corner beside an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    /// Share of the axis' length.
    share: f32,
    /// Along normal, binormal and tangent of the axis there, metres.
    beside: Vec3,
}

/// A lofted surface that moves with a muscle's axis: straight, round a joint, or round a bone.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    corners: Vec<Corner>,
    /// Length of the axis at rest, metres.
    length: f32,
    /// Integrals of the sections' areas by `g^0`, `g^1` and `g^2` over the muscle (background 6.6).
    areas: [f64; 3],
}

impl Bound {
    /// The surface on an axis in some pose, whose points are in a space that `to_posed` takes to scene space.
    ///
    /// Every corner keeps its place beside the axis, whose frames are those of the path's straight and wound parts. Sections grow by
    /// `1 + kappa (1 - u^2)^2`, which keeps the volume and leaves the ends as they are (background 6.6).
    pub fn posed(&self, points: &[AxisPoint], to_posed: &Mat4) -> Surface {
        let length: f32 = points.windows(2).map(|w| w[0].position.xyz().distance(w[1].position.xyz())).sum();
        let grown = growth(self.areas, f64::from(length / self.length));
        let turn = Mat3::from_mat4(*to_posed);
        let place = |corner: &Corner| {
            let frame = Frame::at(points, corner.share * length);
            let swollen = corner.beside * Vec3::new(1.0, 1.0, 0.0) * grown(f64::from(corner.share)) as f32;
            to_posed.transform_point3(frame.center) + turn * frame.scene(swollen.with_z(corner.beside.z))
        };
        let mut places: Vec<Vec3> = self.corners.iter().map(place).collect();
        let ends = [places[places.len() - 2], places[places.len() - 1]];
        places.truncate(places.len() - 2);
        Surface::of_rings(places, AROUND as u32, ends)
    }

    /// `A_n`, from the areas of the rings across the axis.
    fn areas(&self) -> [f64; 3] {
        let rings = self.corners[..self.corners.len() - 2].chunks(AROUND).map(|ring| {
            let share = ring.iter().map(|c| f64::from(c.share)).sum::<f64>() / ring.len() as f64;
            let flat = |c: &Corner| c.beside.truncate().as_dvec2();
            let area = (0..ring.len()).map(|k| flat(&ring[k]).perp_dot(flat(&ring[(k + 1) % ring.len()])));
            (share, 0.5 * area.sum::<f64>().abs())
        });
        let stations: Vec<(f64, f64)> = std::iter::once((0.0, 0.0)).chain(rings).chain([(1.0, 0.0)]).collect();
        let of = |n: i32| {
            let at = |&(share, area): &(f64, f64)| area * shape(share).powi(n);
            stations.windows(2).map(|w| (w[1].0 - w[0].0) * 0.5 * (at(&w[0]) + at(&w[1]))).sum()
        };
        [of(0), of(1), of(2)]
    }
}

/// `g`: where along a muscle it thickens, 0 at both ends and 1 in the middle.
fn shape(share: f64) -> f64 {
    let u = 2.0 * share - 1.0;
    (1.0 - u * u).powi(2)
}

/// By what sections at a share of the length grow, where the axis is `stretch` times as long as at rest (background 6.6).
fn growth([a0, a1, a2]: [f64; 3], stretch: f64) -> impl Fn(f64) -> f64 {
    let root = a1 * a1 + a0 * a2 * (1.0 / stretch - 1.0);
    let kappa = (root.max(0.0).sqrt() - a1) / a2.max(f64::MIN_POSITIVE);
    let holds = root >= 0.0 && 1.0 + kappa >= THINNEST;
    move |share| if holds { 1.0 + kappa * shape(share) } else { 1.0 / stretch.sqrt() }
}

#[cfg(test)]
mod tests;
