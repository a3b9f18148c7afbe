//! Plane sections of the posed arm: skin, muscles and bones as the constraints of the dynamics see them.

use super::motion::{Play, capsule};
use super::plot::{INK, Page, Rect};
use crate::error::FigureError;
use crate::field::grid;
use crate::field::muscle::project;
use crate::math::transform_point;
use crate::rig::{Image, Pose, Rig};
use glam::Vec3;
use rayon::prelude::*;

/// sRGB of what is cut.
const SKIN: [f64; 3] = [252.0, 240.0, 231.0];
const MUSCLE: [f64; 3] = [240.0, 205.0, 197.0];
const CHOSEN: [f64; 3] = [224.0, 150.0, 140.0];
const BONE: [f64; 3] = [206.0, 200.0, 182.0];
/// Farther than anything, metres.
const FAR: f32 = 1.0;

/// A plane in scene space that is looked at from the side to which `right` x `up` points.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    /// What is in the picture's middle.
    pub center: Vec3,
    /// Unit vectors in it.
    pub right: Vec3,
    /// See [`Plane::right`].
    pub up: Vec3,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Pixels a metre.
    pub scale: f32,
}

impl Plane {
    /// The plane through a point with `up` in it, and `right` as nearly as may be.
    pub fn new(center: Vec3, right: Vec3, up: Vec3, size: [u32; 2], meters: f32) -> Plane {
        let up = up.normalize_or(Vec3::Y);
        let right = right.reject_from_normalized(up).normalize_or(up.any_orthonormal_vector());
        Plane { center, right, up, size, scale: size[0] as f32 / meters }
    }

    /// The pixel of a point, which need not lie in the plane.
    pub fn at(&self, point: Vec3) -> [f64; 2] {
        let offset = (point - self.center) * self.scale;
        let half = self.size.map(|s| 0.5 * f64::from(s));
        [half[0] + f64::from(offset.dot(self.right)), half[1] - f64::from(offset.dot(self.up))]
    }

    /// Whether the picture shows a pixel.
    pub fn shows(&self, [x, y]: [f64; 2]) -> bool {
        (0.0..=f64::from(self.size[0])).contains(&x) && (0.0..=f64::from(self.size[1])).contains(&y)
    }

    fn point(&self, x: u32, y: u32) -> Vec3 {
        let across = (x as f32 + 0.5 - 0.5 * self.size[0] as f32) / self.scale;
        let down = (y as f32 + 0.5 - 0.5 * self.size[1] as f32) / self.scale;
        self.center + self.right * across - self.up * down
    }
}

/// The arm at one moment of its motion.
#[derive(Clone)]
pub(super) struct Moment<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// Its pose.
    pub pose: Pose,
    /// Its muscles.
    pub play: Play<'a>,
}

impl Moment<'_> {
    /// Signed distance of a point from the skin, metres, negative inside, and its gradient: of all field groups that of
    /// the surface which it is deepest in.
    pub fn skin(&self, p: Vec3) -> (f32, Vec3) {
        let mut nearest = (FAR, Vec3::ZERO);
        for frame in &self.play.inputs.groups {
            let Some((distance, gradient)) =
                grid::sample(&frame.grid, &self.rig.nodes, transform_point(&frame.to_rest, p))
            else {
                continue;
            };
            if distance < nearest.0 {
                nearest = (distance, frame.to_rest.transpose().transform_vector3(gradient));
            }
        }
        nearest
    }

    /// Distance of a point from the surface of the nearest bone, metres, and the direction away from it.
    pub fn bone(&self, p: Vec3) -> (f32, Vec3) {
        let mut nearest = (FAR, Vec3::ZERO);
        for bone in &self.rig.bones {
            let Some(([from, to], radius)) = capsule(self.rig, &self.pose, bone.joint as usize) else { continue };
            let span = to - from;
            let share = ((p - from).dot(span) / span.length_squared()).clamp(0.0, 1.0);
            let away = p - (from + span * share);
            if away.length() - radius < nearest.0 {
                nearest = (away.length() - radius, away.normalize_or_zero());
            }
        }
        nearest
    }

    /// Distance of a point from a muscle's surface, metres: its field `f_M`. Far off, anything large.
    pub fn muscle(&self, index: usize, p: Vec3) -> f32 {
        let shaped = &self.play.shaped[index];
        let group = &self.play.inputs.groups[self.rig.muscles[index].group as usize];
        let p_rest = transform_point(&group.to_rest, p);
        if shaped.present == 0 || !shaped.reaches(p_rest) {
            return FAR;
        }
        let on = project(shaped.points(&self.play.simulation.axes), p_rest);
        let outward = on.offset.normalize_or_zero();
        on.offset.length() - shaped.radius(on.arc * shaped.inverse_length, outward.dot(on.normal))
    }

    /// The section, one muscle of it in a stronger colour, on a page of the plane's size.
    pub fn page(&self, plane: &Plane, chosen: usize) -> Result<Page, FigureError> {
        let [width, height] = plane.size;
        let rows: Vec<u8> = (0..width * height)
            .into_par_iter()
            .flat_map_iter(|i| {
                let color = self.color(plane.point(i % width, i / width), plane.scale, chosen);
                [color[0], color[1], color[2], 255]
            })
            .collect();
        let mut page = Page::new(width, height)?;
        page.paste(&Image { width, height, rgba: rows }, 0, 0);
        Ok(page)
    }

    fn color(&self, p: Vec3, scale: f32, chosen: usize) -> [u8; 3] {
        let mut color = [255.0; 3];
        let mut lay = |distance: f32, fill: [f64; 3], line: f64| {
            let pixels = f64::from(distance * scale);
            let inside = (0.5 - pixels).clamp(0.0, 1.0);
            let edge = (0.5 + 0.5 * line - pixels.abs()).clamp(0.0, 1.0);
            for (c, own) in color.iter_mut().enumerate() {
                *own += (fill[c] - *own) * inside;
                *own += (0.55 * fill[c] - *own) * edge;
            }
        };
        lay(self.skin(p).0, SKIN, 3.0);
        // The chosen muscle on top of those that overlap it.
        let others = (0..self.rig.muscles.len()).filter(|index| *index != chosen);
        for index in others.chain([chosen]) {
            lay(self.muscle(index, p), if index == chosen { CHOSEN } else { MUSCLE }, 1.5);
        }
        lay(self.bone(p).0, BONE, 2.0);
        color.map(|c| c.round() as u8)
    }
}

/// A circle's outline.
pub(super) fn circle(center: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let at = |i: u32| f64::from(i) / 72.0 * std::f64::consts::TAU;
    (0..=72).map(|i| [center[0] + radius * at(i).cos(), center[1] + radius * at(i).sin()]).collect()
}

/// A spring between two places.
pub(super) fn spring(from: [f64; 2], to: [f64; 2], swing: f64) -> Vec<[f64; 2]> {
    const TEETH: u32 = 4;
    let along = [to[0] - from[0], to[1] - from[1]];
    let length = along[0].hypot(along[1]).max(1e-9);
    let across = [-along[1] / length, along[0] / length];
    let at = |i: u32| {
        let share = f64::from(i) / f64::from(TEETH);
        let aside = if i == 0 || i == TEETH { 0.0 } else { swing * f64::from(1 - 2 * (i as i32 % 2)) };
        [from[0] + along[0] * share + across[0] * aside, from[1] + along[1] * share + across[1] * aside]
    };
    (0..=TEETH).map(at).collect()
}

/// A frame round a picture.
pub(super) fn outline(page: &mut Page, place: Rect) -> Result<(), FigureError> {
    let [left, top] = [place.left, place.top].map(f64::from);
    let [right, bottom] = [place.left + place.width, place.top + place.height].map(f64::from);
    let corners = [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]];
    super::plot::polyline(page, &corners, INK, 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::motion::{held, tests::arm};
    use super::*;
    use crate::schedule::DynamicsOptions;

    #[test]
    fn sections_know_inside_from_outside() {
        let arm = arm();
        let mut play = Play::new(&arm.settled, &DynamicsOptions::default());
        let poses: Vec<Pose> = held(&arm.curl[0]).collect();
        play.all(&poses).expect("frames");
        let moment = Moment { rig: &arm.settled, pose: poses[0].clone(), play };
        let own = moment.play.simulation.particles[15].position;
        let inside = own.truncate();
        assert!(moment.muscle(0, inside) < -0.5 * own.w && moment.skin(inside).0 < 0.0 && moment.bone(inside).0 > 0.0);
        let outside = inside + Vec3::X * 0.3;
        assert!(moment.muscle(0, outside) > 0.0 && moment.skin(outside).0 > 0.0 && moment.bone(outside).0 > 0.1);
        let (distance, gradient) = moment.skin(inside);
        let nearer = moment.skin(inside + gradient.normalize() * 0.002).0;
        assert!(nearer > distance && nearer < 0.0, "it grows outward: {distance} {nearer}");
    }

    #[test]
    fn a_plane_shows_its_points_where_they_are() {
        let plane = Plane::new(Vec3::ONE, Vec3::new(1.0, 1.0, 0.0), Vec3::Y * 2.0, [200, 100], 0.5);
        assert_eq!(plane.at(Vec3::ONE), [100.0, 50.0]);
        let [x, y] = plane.at(plane.point(150, 20));
        assert!((x - 150.5).abs() < 1e-3 && (y - 20.5).abs() < 1e-3, "a pixel's middle: {x} {y}");
        assert!(plane.shows([x, y]) && !plane.shows([x, 101.0]));
        assert_eq!(plane.at(Vec3::ONE + Vec3::Z * 0.1), [100.0, 50.0], "what is beside the plane is seen in it");
    }
}
