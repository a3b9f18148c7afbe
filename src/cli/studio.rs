//! Drawing a character's frames.

use crate::args::{Size, ViewArg};
use crate::deform::Shaped;
use crate::failure::Failure;
use crate::load::Frames;
use glam::{Mat4, Vec3, Vec4Swizzles};
use sinew::clip::Scene;
use sinew::error::DeviceError;
use sinew::gpu::Headless;
use sinew::reference::Reference;
use sinew::render::{
    Camera, ColorMesh, Direction, Frame, Light, Look, Picture, Renderer, Run, SkinMesh, Surface, Targets, View,
    bone_meshes, muscle_meshes, vertex_buffer,
};
use sinew::rig::{Pose, Rig};
use sinew::schedule::{FrameOptions, Skinning};
use sinew::wgpu::Buffer;
use std::sync::Arc;

impl From<ViewArg> for View {
    fn from(argument: ViewArg) -> View {
        match argument {
            ViewArg::Skin => View::Skin,
            ViewArg::Xray => View::Xray,
            ViewArg::Muscles => View::Muscles,
            ViewArg::Crease | ViewArg::Compare => View::Colors,
        }
    }
}

/// A rigid mesh on the device.
struct Rigid {
    mesh: SkinMesh,
    vertices: Buffer,
    node: u32,
}

/// One character before the camera.
pub struct Studio {
    renderer: Renderer,
    targets: Targets,
    skin: SkinMesh,
    rigid: Vec<Rigid>,
}

impl Studio {
    /// Uploads what stays from frame to frame.
    pub fn open(headless: &Headless, scene: &Scene, size: Size) -> Result<Studio, Failure> {
        let open = || -> Result<Studio, DeviceError> {
            let targets = Targets::new(headless, size.width, size.height)?;
            let renderer = Renderer::new(&headless.device);
            let look = Arc::new(Look::of(headless, &renderer, &scene.character)?);
            let skin = SkinMesh::of(headless, &look, &scene.character)?;
            let rigid = scene.rigid.iter().map(|part| {
                let whole = Run { triangles: 0..part.triangles.len() as u32, material: part.material };
                Ok(Rigid {
                    mesh: SkinMesh::upload(headless, &look, &part.triangles, &part.uvs, &[whole])?,
                    vertices: vertex_buffer(headless, &part.positions, &part.normals)?,
                    node: part.node,
                })
            });
            let rigid = rigid.collect::<Result<Vec<_>, DeviceError>>()?;
            headless.check()?;
            Ok(Studio { renderer, targets, skin, rigid })
        };
        open().map_err(Failure::device)
    }

    /// Pixels across over pixels down.
    pub fn aspect(&self) -> f32 {
        self.targets.aspect()
    }

    /// Draws one frame; `vertices` holds the deformed skin, none where `solids` do; `shaped` the muscles where the view shows
    /// them, and `marks` what it shows through all else.
    pub fn draw(
        &self,
        headless: &Headless,
        (rig, pose): (&Rig, &Pose),
        (vertices, mut solids): (Option<&Buffer>, Vec<ColorMesh>),
        (shaped, marks): (Option<&Shaped>, &[ColorMesh]),
        camera: &Camera,
        view: View,
    ) -> Result<Picture, Failure> {
        if let Some(Shaped { muscles, axes, .. }) = shaped {
            solids.extend(muscle_meshes(rig, pose, muscles, axes));
            solids.extend(bone_meshes(rig, pose));
        }
        let mut surfaces: Vec<Surface> = vertices
            .iter()
            .map(|vertices| Surface { mesh: &self.skin, vertices: vertices.slice(..), model: Mat4::IDENTITY })
            .collect();
        surfaces.extend(self.rigid.iter().map(|part| Surface {
            mesh: &part.mesh,
            vertices: part.vertices.slice(..),
            model: node_matrix(pose, part.node),
        }));
        let frame = Frame { camera, view, light: Light::Studio, surfaces: &surfaces, solids: &solids, marks };
        self.renderer.draw(headless, &self.targets, &frame).map_err(Failure::device)
    }
}

fn node_matrix(pose: &Pose, node: u32) -> Mat4 {
    pose.nodes.get(node as usize).copied().unwrap_or(Mat4::IDENTITY)
}

/// Most poses that the camera is set up for, and most points that are kept for it.
const POSES: u32 = 16;
const POINTS: usize = 4_000_000;

/// Where a character is in frames of a clip, skinned linearly: what the camera must hold. Fields move the skin by less
/// than the camera's margin.
pub fn points(scene: &Scene, rig: &Rig, frames: &Frames) -> Result<Vec<Vec3>, Failure> {
    let options = FrameOptions { skinning: Skinning::Linear, ..FrameOptions::default() };
    let vertices = scene.character.vertex_count() + scene.rigid.iter().map(|part| part.positions.len()).sum::<usize>();
    let poses = (POINTS / vertices.max(1)).clamp(2, POSES as usize) as u32;
    let mut points = Vec::new();
    for number in frames.spread(poses) {
        let pose = frames.pose(scene, number);
        let trace = Reference::new(rig).frame(&pose, &options).map_err(Failure::input)?;
        points.extend(trace.positions().iter().map(|p| p.xyz()));
        for part in &scene.rigid {
            let matrix = node_matrix(&pose, part.node);
            points.extend(part.positions.iter().map(|&p| matrix.transform_point3(p)));
        }
    }
    Ok(points)
}

/// Pixels that suit points seen from a direction: upright, wide or square.
pub fn size_for(points: &[Vec3], direction: Direction) -> Size {
    let azimuth = direction.azimuth.to_radians();
    let right = Vec3::new(azimuth.cos(), 0.0, -azimuth.sin());
    let extent = |axis: Vec3| {
        let along = points.iter().map(|p| p.dot(axis));
        let (low, high) = along.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    };
    let (width, height) = match extent(right) / extent(Vec3::Y).max(1e-9) {
        ratio if ratio > 1.25 => (1280, 960),
        ratio if ratio < 0.8 => (960, 1280),
        _ => (960, 960),
    };
    Size { width, height }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_suits_the_shape() {
        let human = [Vec3::new(-0.4, 0.0, -0.15), Vec3::new(0.4, 1.8, 0.15)];
        assert_eq!(size_for(&human, Direction::FRONT), Size { width: 960, height: 1280 });
        let arm = [Vec3::new(0.0, -0.1, -0.1), Vec3::new(0.7, 0.1, 0.1)];
        assert_eq!(size_for(&arm, Direction::FRONT), Size { width: 1280, height: 960 });
        assert_eq!(size_for(&arm, Direction::SIDE), Size { width: 960, height: 960 });
    }
}
