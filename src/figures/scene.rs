//! Figures in space: simple solids, and pictures of them on white with places to write labels at.

use super::plot::{Label, PALE, Page};
use crate::error::FigureError;
use crate::field::muscle::mesh::{Detail, Surface, surface};
use crate::field::muscle::{AxisPoint, MuscleFrame};
use crate::gpu::Headless;
use crate::render::{Camera, ColorMesh, Frame, Light, Picture, Renderer, Targets, View};
use crate::rig::Image;
use glam::{Mat3, Vec3, Vec4Swizzles};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Rings of a solid from pole to pole, and corners of a ring.
const RINGS: u32 = 40;
const AROUND: u32 = 56;

/// Bone, linear RGB.
pub(super) const BONE: [f32; 3] = [0.56, 0.52, 0.43];

const TENDON: [f32; 3] = [0.72, 0.66, 0.58];

/// A solid of rotation: a sphere's rings, moved by `place`, which takes a unit vector (Y towards its top) and gives a
/// position and an outward normal.
fn solid(color: [f32; 3], place: impl Fn(Vec3) -> (Vec3, Vec3)) -> ColorMesh {
    let mut mesh = ColorMesh::default();
    for ring in 0..=RINGS {
        let up = PI * ring as f32 / RINGS as f32 - FRAC_PI_2;
        for k in 0..AROUND {
            let turn = TAU * k as f32 / AROUND as f32;
            let unit = Vec3::new(up.cos() * turn.cos(), up.sin(), -up.cos() * turn.sin());
            let (position, normal) = place(unit);
            mesh.positions.push(position);
            mesh.normals.push(normal.normalize_or(unit));
            mesh.colors.push(color);
        }
    }
    for ring in 0..RINGS {
        for k in 0..AROUND {
            let [a, b] = [k, (k + 1) % AROUND].map(|k| ring * AROUND + k);
            mesh.triangles.extend([[a, b, b + AROUND], [a, b + AROUND, a + AROUND]]);
        }
    }
    mesh
}

/// An ellipsoid whose half axes are the columns of `half`.
pub(super) fn ellipsoid(center: Vec3, half: Mat3, color: [f32; 3]) -> ColorMesh {
    let normals = half.inverse().transpose();
    solid(color, |unit| (center + half * unit, normals * unit))
}

/// A ball.
pub(super) fn ball(center: Vec3, radius: f32, color: [f32; 3]) -> ColorMesh {
    ellipsoid(center, Mat3::from_diagonal(Vec3::splat(radius)), color)
}

/// A rod with round ends of different thickness.
pub(super) fn rod(from: Vec3, to: Vec3, radii: [f32; 2], color: [f32; 3]) -> ColorMesh {
    let axis = (to - from).normalize_or(Vec3::Y);
    let side = axis.any_orthonormal_vector();
    let turn = Mat3::from_cols(side, axis, side.cross(axis));
    solid(color, |unit| {
        let (center, radius) = if unit.y > 0.0 { (to, radii[1]) } else { (from, radii[0]) };
        (center + turn * unit * radius, turn * unit)
    })
}

/// A tube through points.
pub(super) fn tube(points: &[Vec3], radius: f32, color: [f32; 3]) -> ColorMesh {
    joined(points.windows(2).map(|w| rod(w[0], w[1], [radius; 2], color)))
}

/// An arrow.
pub(super) fn arrow(from: Vec3, to: Vec3, radius: f32, color: [f32; 3]) -> ColorMesh {
    let axis = (to - from).normalize_or(Vec3::Y);
    let neck = to - axis * (6.0 * radius).min(0.6 * from.distance(to));
    let mut mesh = rod(from, neck, [radius; 2], color);
    mesh.append(&rod(neck, to, [2.6 * radius, 0.05 * radius], color));
    mesh
}

/// Several meshes as one.
pub(super) fn joined(meshes: impl IntoIterator<Item = ColorMesh>) -> ColorMesh {
    meshes.into_iter().fold(ColorMesh::default(), |mut all, mesh| {
        all.append(&mesh);
        all
    })
}

/// A muscle's surface in one colour, with its axis as a thin pale line where it is thinner than that; `points` are its
/// own.
pub(super) fn fibre(muscle: &MuscleFrame, points: &[AxisPoint], color: [f32; 3]) -> ColorMesh {
    let axis: Vec<Vec3> = points.iter().map(|p| p.position.xyz()).collect();
    let mut mesh = colored(surface(muscle, points, Detail { rings: 72, around: 64 }), color);
    mesh.append(&tube(&axis, 0.0011, TENDON));
    mesh
}

/// A surface in one colour.
pub(super) fn colored(surface: Surface, color: [f32; 3]) -> ColorMesh {
    ColorMesh {
        colors: vec![color; surface.positions.len()],
        positions: surface.positions,
        normals: surface.normals,
        triangles: surface.triangles,
    }
}

/// Draws pictures of one size.
pub(super) struct Studio<'a> {
    headless: &'a Headless,
    renderer: Renderer,
    targets: Targets,
}

impl<'a> Studio<'a> {
    /// For pictures of `width` x `height` pixels.
    pub(super) fn new(headless: &'a Headless, width: u32, height: u32) -> Result<Studio<'a>, FigureError> {
        let targets = Targets::new(headless, width, height)?;
        let renderer = Renderer::new(&headless.device);
        headless.check()?;
        Ok(Studio { headless, renderer, targets })
    }

    /// The device.
    pub(super) fn headless(&self) -> &'a Headless {
        self.headless
    }

    /// What pipelines it has.
    pub(super) fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Pixels across over pixels down.
    pub(super) fn aspect(&self) -> f32 {
        self.targets.aspect()
    }

    /// Draws solids on white.
    pub(super) fn solids(&self, camera: &Camera, solids: &[ColorMesh]) -> Result<Image, FigureError> {
        self.frame(&Frame { camera, view: View::Muscles, light: Light::Paper, surfaces: &[], solids, marks: &[] })
    }

    /// Draws a frame.
    pub(super) fn frame(&self, frame: &Frame<'_>) -> Result<Image, FigureError> {
        let Picture { width, height, rgba } = self.renderer.draw(self.headless, &self.targets, frame)?;
        Ok(Image { width, height, rgba })
    }
}

/// A picture's camera with its place on a page: where a point in space is drawn.
pub(super) struct Shown<'a> {
    /// The camera.
    pub(super) camera: &'a Camera,
    /// The picture's corner and size, in the page's pixels.
    pub(super) corner: [u32; 2],
    /// Pixels across and down.
    pub(super) size: [u32; 2],
}

impl Shown<'_> {
    /// The pixel of a point in space.
    pub(super) fn at(&self, point: Vec3) -> [f64; 2] {
        let clip = self.camera.view_projection() * point.extend(1.0);
        let [x, y] = [clip.x / clip.w, -clip.y / clip.w].map(|v| f64::from(0.5 + 0.5 * v));
        [
            f64::from(self.corner[0]) + x * f64::from(self.size[0]),
            f64::from(self.corner[1]) + y * f64::from(self.size[1]),
        ]
    }
}

/// Puts a picture on a page and gives the way from its space to the page.
pub(super) fn place<'a>(page: &mut Page, image: &Image, camera: &'a Camera, left: u32, top: u32) -> Shown<'a> {
    page.paste(image, left, top);
    Shown { camera, corner: [left, top], size: [image.width, image.height] }
}

/// Rows of pictures of one size, each column between its title and its note.
pub(super) fn sheet(titles: &[&str], rows: &[Vec<Image>], notes: &[String]) -> Result<Page, FigureError> {
    const TITLE: u32 = 56;
    const NOTE: u32 = 44;
    let [width, height] = rows.iter().flatten().next().map_or([1, 1], |image| [image.width, image.height]);
    let mut page = Page::new(width * titles.len() as u32, TITLE + height * rows.len() as u32 + NOTE)?;
    for (column, title) in (0..).zip(titles) {
        for (row, images) in (0..).zip(rows) {
            if let Some(image) = images.get(column as usize) {
                page.paste(image, column * width, TITLE + row * height);
            }
        }
        let middle = (f64::from(column) + 0.5) * f64::from(width);
        Label::new(title, 20.0).draw(&mut page, middle, 28.0)?;
        if let Some(note) = notes.get(column as usize) {
            let bottom = f64::from(page.size().1);
            Label::new(note, 16.0).color(PALE).draw(&mut page, middle, bottom - 24.0)?;
        }
    }
    Ok(page)
}

/// The linear value of an sRGB colour, for solids that match what a page writes.
pub(super) fn linear(color: [u8; 3]) -> [f32; 3] {
    color.map(|byte| {
        let v = f32::from(byte) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume of a closed mesh.
    fn volume(mesh: &ColorMesh) -> f32 {
        let corner = |i: u32| mesh.positions[i as usize];
        mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
    }

    #[test]
    fn solids_are_closed_and_face_outward() {
        let sphere = volume(&ball(Vec3::ZERO, 0.5, BONE));
        assert!((sphere / (4.0 / 3.0 * PI * 0.125) - 1.0).abs() < 0.03, "{sphere}");
        let rod = rod(Vec3::ZERO, Vec3::new(0.0, 0.6, 0.8), [0.1; 2], BONE);
        let expected = PI * 0.01 + 4.0 / 3.0 * PI * 0.001;
        assert!((volume(&rod) / expected - 1.0).abs() < 0.03, "{}", volume(&rod));
        assert!((volume(&rod) / expected - 1.1).abs() > 0.03, "a thicker rod must be seen");
        for (p, n) in rod.positions.iter().zip(&rod.normals) {
            let along = p.dot(Vec3::new(0.0, 0.6, 0.8)).clamp(0.0, 1.0);
            assert!((*p - Vec3::new(0.0, 0.6, 0.8) * along).dot(*n) > 0.0);
        }
    }

    #[test]
    fn a_point_is_found_where_it_is_drawn() {
        let camera = Camera::frame((Vec3::NEG_ONE, Vec3::ONE), crate::render::Direction::FRONT, 1.0);
        let view = Shown { camera: &camera, corner: [100, 50], size: [200, 200] };
        assert_eq!(view.at(Vec3::ZERO).map(f64::round), [200.0, 150.0]);
        let [right, up] = [view.at(Vec3::X), view.at(Vec3::Y)];
        assert!(right[0] > 230.0 && (right[1] - 150.0).abs() < 1e-3 && up[1] < 120.0);
    }
}
