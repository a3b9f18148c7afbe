//! One picture: what is in it, and how it is drawn.

use super::camera::Camera;
use super::color_mesh::ColorMesh;
use super::mesh::{SkinMesh, VERTEX_STRIDE, upload};
use super::picture::Picture;
use super::renderer::{Renderer, SOLID_STRIDE};
use super::shader::ViewParams;
use super::targets::Targets;
use crate::error::DeviceError;
use crate::gpu::Headless;
use glam::Mat4;
use wgpu::util::DeviceExt;

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// The skin as it is, and nothing under it.
    #[default]
    Skin,
    /// Muscles under glassy skin.
    Xray,
    /// Muscles, with no more than a breath of skin to tell where they are.
    Muscles,
    /// Coloured meshes, and what surfaces there are as they are.
    Colors,
}

impl View {
    /// Whether it shows muscles.
    pub fn shows_muscles(self) -> bool {
        matches!(self, View::Xray | View::Muscles)
    }
}

/// How surfaces are lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Light {
    /// Lights that show form, fixed to the camera: key from the upper left front, fill, two from behind.
    #[default]
    Studio,
    /// None: the material's own colour, to the bit.
    Flat,
    /// The studio's lights, on white paper: for figures in print.
    Paper,
}

/// A mesh with the vertices it has in this frame.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// Corners, texture coordinates and materials.
    pub mesh: &'a SkinMesh,
    /// Position and normal per vertex, [`VERTEX_STRIDE`] bytes each; its buffer needs `VERTEX`.
    pub vertices: wgpu::BufferSlice<'a>,
    /// The vertices' space to scene space.
    pub model: Mat4,
}

/// Everything that one picture is made of.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    /// Where it is taken from.
    pub camera: &'a Camera,
    /// What it shows.
    pub view: View,
    /// How it is lit.
    pub light: Light,
    /// Skin and rigid parts.
    pub surfaces: &'a [Surface<'a>],
    /// Muscles and the like, in scene space; not shown by [`View::Skin`].
    pub solids: &'a [ColorMesh],
    /// What is seen through all else, such as axes within muscles; not shown by [`View::Skin`].
    pub marks: &'a [ColorMesh],
}

/// Depth up to which marks are drawn, and from which on everything else is, where there are marks.
const MARKS_DEPTH: f32 = 0.1;

impl Frame<'_> {
    fn params(&self) -> ViewParams {
        let camera = self.camera;
        let (ghost_facing, ghost_edge, ghost_power) = match self.view {
            View::Muscles => (0.03, 0.26, 2.5),
            View::Skin | View::Xray | View::Colors => (0.14, 0.85, 2.0),
        };
        ViewParams {
            view_projection: camera.view_projection(),
            eye: camera.eye.extend(1.0),
            right: camera.right.extend(0.0),
            up: camera.up.extend(0.0),
            toward: camera.toward.extend(0.0),
            lit: if self.light == Light::Flat { 0.0 } else { 1.0 },
            ghost_facing,
            ghost_edge,
            ghost_power,
        }
    }

    fn check_surfaces(&self) -> Result<(), DeviceError> {
        for (i, surface) in self.surfaces.iter().enumerate() {
            let bad = |problem| Err(DeviceError::Undrawable { what: format!("surface {i}"), problem });
            let (needed, had) = (surface.mesh.vertex_count as u64 * VERTEX_STRIDE, surface.vertices.size());
            if had < needed {
                return bad(format!("its vertices need {needed} bytes, the buffer gives {had}"));
            }
            if !surface.vertices.buffer().usage().contains(wgpu::BufferUsages::VERTEX) {
                return bad("its vertex buffer was made without VERTEX".to_string());
            }
        }
        Ok(())
    }
}

/// The coloured meshes of one frame on the device.
struct Solids {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

impl Solids {
    fn upload(headless: &Headless, meshes: &[ColorMesh]) -> Result<Solids, DeviceError> {
        let mut vertices: Vec<[[f32; 3]; 3]> = Vec::new();
        let mut indices: Vec<[u32; 3]> = Vec::new();
        for (i, mesh) in meshes.iter().enumerate() {
            let count = mesh.positions.len();
            let bad = |problem| Err(DeviceError::Undrawable { what: format!("coloured mesh {i}"), problem });
            if mesh.normals.len() != count || mesh.colors.len() != count {
                let (n, c) = (mesh.normals.len(), mesh.colors.len());
                return bad(format!("{count} positions with {n} normals and {c} colours"));
            }
            if let Some(t) = mesh.triangles.iter().find(|t| t.iter().any(|&v| v as usize >= count)) {
                return bad(format!("a triangle has corners {t:?} of {count} vertices"));
            }
            let base = vertices.len() as u32;
            let corners = mesh.positions.iter().zip(&mesh.normals).zip(&mesh.colors);
            vertices.extend(corners.map(|((p, n), &c)| [p.to_array(), n.to_array(), c]));
            indices.extend(mesh.triangles.iter().map(|t| t.map(|v| v + base)));
        }
        debug_assert_eq!(size_of::<[[f32; 3]; 3]>() as u64, SOLID_STRIDE);
        Ok(Solids {
            vertices: upload(headless, "coloured vertices", &vertices, wgpu::BufferUsages::VERTEX)?,
            indices: upload(headless, "corners of coloured meshes", &indices, wgpu::BufferUsages::INDEX)?,
            count: indices.len() as u32 * 3,
        })
    }
}

impl Renderer {
    /// Draws a frame and brings the picture to the host.
    ///
    /// # Errors
    /// As [`encode`](Renderer::encode), and what the device reports.
    pub fn draw(&self, headless: &Headless, targets: &Targets, frame: &Frame<'_>) -> Result<Picture, DeviceError> {
        self.draw_after(headless, targets, frame, |_| ())
    }

    /// As [`draw`](Renderer::draw), behind what `before` encodes: a deformer's work on the vertices that are drawn.
    ///
    /// # Errors
    /// As [`draw`](Renderer::draw).
    pub fn draw_after(
        &self,
        headless: &Headless,
        targets: &Targets,
        frame: &Frame<'_>,
        before: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<Picture, DeviceError> {
        let mut encoder =
            headless.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("picture") });
        before(&mut encoder);
        self.encode(headless, &mut encoder, targets, frame)?;
        headless.queue.submit([encoder.finish()]);
        targets.read(headless)
    }

    /// Encodes the drawing of a frame behind whatever `encoder` holds, so that a deformer's work may come before it in
    /// the same submission; [`Targets::read`] brings the picture after that.
    ///
    /// # Errors
    /// [`DeviceError::Undrawable`] for a vertex buffer that is too small or a coloured mesh that is inconsistent,
    /// [`DeviceError::BufferTooLarge`] for one that does not fit.
    pub fn encode(
        &self,
        headless: &Headless,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        frame: &Frame<'_>,
    ) -> Result<(), DeviceError> {
        frame.check_surfaces()?;
        let shown = if frame.view == View::Skin { &[] } else { frame.solids };
        let solids = Solids::upload(headless, shown)?;
        let marks = Solids::upload(headless, if frame.view == View::Skin { &[] } else { frame.marks })?;
        let (width, height) = (targets.resolved.width() as f32, targets.resolved.height() as f32);
        let models: Vec<Mat4> = frame.surfaces.iter().map(|s| s.model).collect();
        let models = upload(headless, "model matrices", &models, wgpu::BufferUsages::VERTEX)?;
        let params = headless.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("view"),
            contents: bytemuck::bytes_of(&frame.params()),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let view = headless.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("view"),
            layout: &self.view_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: params.as_entire_binding() }],
        });

        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &targets.samples,
                depth_slice: None,
                resolve_target: Some(&targets.resolved_view),
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::WHITE), store: wgpu::StoreOp::Discard },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_bind_group(0, &view, &[]);
        if marks.count > 0 {
            pass.set_viewport(0.0, 0.0, width, height, MARKS_DEPTH, 1.0);
        }
        if frame.light != Light::Paper {
            pass.set_pipeline(&self.background);
            pass.draw(0..3, 0..1);
        }
        self.draw_solids(&mut pass, &solids);
        let pipelines: &[_] = match frame.view {
            View::Skin | View::Colors => &[&self.skin],
            View::Xray | View::Muscles => &[&self.skin_depth, &self.skin_ghost],
        };
        for pipeline in pipelines {
            pass.set_pipeline(pipeline);
            draw_surfaces(&mut pass, frame.surfaces, &models);
        }
        if marks.count > 0 {
            pass.set_viewport(0.0, 0.0, width, height, 0.0, MARKS_DEPTH);
            self.draw_solids(&mut pass, &marks);
        }
        Ok(())
    }

    fn draw_solids(&self, pass: &mut wgpu::RenderPass<'_>, solids: &Solids) {
        if solids.count > 0 {
            pass.set_pipeline(&self.solid);
            pass.set_vertex_buffer(0, solids.vertices.slice(..));
            pass.set_index_buffer(solids.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..solids.count, 0, 0..1);
        }
    }
}

fn draw_surfaces(pass: &mut wgpu::RenderPass<'_>, surfaces: &[Surface<'_>], models: &wgpu::Buffer) {
    pass.set_vertex_buffer(2, models.slice(..));
    for (i, surface) in (0u32..).zip(surfaces) {
        pass.set_vertex_buffer(0, surface.vertices);
        pass.set_vertex_buffer(1, surface.mesh.uvs.slice(..));
        pass.set_index_buffer(surface.mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
        for run in &surface.mesh.runs {
            pass.set_bind_group(1, &surface.mesh.look.materials[run.material as usize], &[]);
            pass.draw_indexed(run.triangles.start * 3..run.triangles.end * 3, 0, i..i + 1);
        }
    }
}
