//! What stays on the device from frame to frame: materials, indices, texture coordinates.

use super::picture::Picture;
use super::renderer::Renderer;
use crate::error::DeviceError;
use crate::gpu::Headless;
use crate::rig::{Character, Image, Material};
use glam::{Vec2, Vec3};
use std::ops::Range;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// Bytes of one vertex as the deformer writes it: position and normal, three `f32` each.
pub const VERTEX_STRIDE: u64 = 24;

crate::gpu_struct! {
    /// A material as the shader reads it.
    pub struct MaterialParams {
        /// Linear RGBA.
        pub base_color: glam::Vec4,
    }
}

/// The materials of a character with their textures, uploaded once and shared by its meshes.
pub struct Look {
    pub(super) materials: Vec<wgpu::BindGroup>,
}

impl Look {
    /// Uploads every material and every texture, with mip levels made in linear light.
    ///
    /// A texture larger than the device allows enters at the first level that fits. Transparency is ignored.
    ///
    /// # Errors
    /// [`DeviceError::Undrawable`] for a texture whose bytes do not match its size or a material that names a texture
    /// that is not there; otherwise what the device reports.
    pub fn upload(
        headless: &Headless,
        renderer: &Renderer,
        materials: &[Material],
        images: &[Image],
    ) -> Result<Look, DeviceError> {
        let textures = images
            .iter()
            .enumerate()
            .map(|(i, image)| upload_texture(headless, &format!("texture {i}"), image))
            .collect::<Result<Vec<_>, _>>()?;
        let white = upload_texture(headless, "white", &Image { width: 1, height: 1, rgba: vec![255; 4] })?;
        let sampler = headless.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("base colour"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let bind = |(i, material): (usize, &Material)| {
            let texture = match material.texture {
                None => &white,
                Some(t) => textures.get(t as usize).ok_or_else(|| DeviceError::Undrawable {
                    what: format!("material {i} {:?}", material.name),
                    problem: format!("it names texture {t} of {}", textures.len()),
                })?,
            };
            let params = headless.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("material"),
                contents: bytemuck::bytes_of(&MaterialParams { base_color: material.base_color.into() }),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            Ok(headless.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("material"),
                layout: &renderer.material_layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: params.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(texture) },
                    wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(&sampler) },
                ],
            }))
        };
        let materials = materials.iter().enumerate().map(bind).collect::<Result<Vec<_>, DeviceError>>()?;
        headless.check()?;
        Ok(Look { materials })
    }

    /// Uploads the materials of a character.
    ///
    /// # Errors
    /// As [`upload`](Look::upload).
    pub fn of(headless: &Headless, renderer: &Renderer, character: &Character) -> Result<Look, DeviceError> {
        Look::upload(headless, renderer, &character.materials, &character.images)
    }
}

fn upload_texture(headless: &Headless, what: &str, image: &Image) -> Result<wgpu::TextureView, DeviceError> {
    let expected = image.width as u64 * image.height as u64 * 4;
    if expected == 0 || image.rgba.len() as u64 != expected {
        let problem = format!("{} x {} pixels with {} bytes", image.width, image.height, image.rgba.len());
        return Err(DeviceError::Undrawable { what: what.to_string(), problem });
    }
    let mut level = Picture { width: image.width, height: image.height, rgba: image.rgba.clone() };
    while level.width.max(level.height) > headless.limits.max_texture_dimension_2d {
        level = level.reduced(2);
    }
    let size = wgpu::Extent3d { width: level.width, height: level.height, depth_or_array_layers: 1 };
    let levels = size.max_mips(wgpu::TextureDimension::D2);
    let texture = headless.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(what),
        size,
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for mip_level in 0..levels {
        if mip_level > 0 {
            level = level.reduced(2);
        }
        headless.queue.write_texture(
            wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() },
            &level.rgba,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(level.width * 4), rows_per_image: None },
            wgpu::Extent3d { width: level.width, height: level.height, depth_or_array_layers: 1 },
        );
    }
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}

/// Triangles of a mesh that share a material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// Triangles of the run.
    pub triangles: Range<u32>,
    /// Index into the look's materials.
    pub material: u32,
}

/// The unchanging half of a mesh whose vertices the deformer moves: corners, texture coordinates, materials.
pub struct SkinMesh {
    pub(super) look: Arc<Look>,
    pub(super) indices: wgpu::Buffer,
    pub(super) uvs: wgpu::Buffer,
    pub(super) runs: Vec<Run>,
    /// Vertices that a vertex buffer must hold.
    pub(super) vertex_count: u32,
}

impl SkinMesh {
    /// Uploads corners and texture coordinates, one of these per vertex.
    ///
    /// # Errors
    /// [`DeviceError::Undrawable`] for a corner, run or material that is not there, [`DeviceError::BufferTooLarge`] for
    /// a mesh that does not fit; otherwise what the device reports.
    pub fn upload(
        headless: &Headless,
        look: &Arc<Look>,
        triangles: &[[u32; 3]],
        uvs: &[Vec2],
        runs: &[Run],
    ) -> Result<SkinMesh, DeviceError> {
        let bad = |what: String, problem: String| Err(DeviceError::Undrawable { what, problem });
        if let Some(t) = triangles.iter().position(|t| t.iter().any(|&i| i as usize >= uvs.len())) {
            return bad(format!("triangle {t}"), format!("corners {:?} of {} vertices", triangles[t], uvs.len()));
        }
        for (i, run) in runs.iter().enumerate() {
            if run.triangles.start > run.triangles.end || run.triangles.end as usize > triangles.len() {
                return bad(format!("run {i}"), format!("triangles {:?} of {}", run.triangles, triangles.len()));
            }
            if run.material as usize >= look.materials.len() {
                return bad(format!("run {i}"), format!("material {} of {}", run.material, look.materials.len()));
            }
        }
        let indices = upload(headless, "the corners of a mesh", triangles, wgpu::BufferUsages::INDEX)?;
        let uvs_buffer = upload(headless, "texture coordinates", uvs, wgpu::BufferUsages::VERTEX)?;
        Ok(SkinMesh {
            look: look.clone(),
            indices,
            uvs: uvs_buffer,
            runs: runs.iter().filter(|r| !r.triangles.is_empty()).cloned().collect(),
            vertex_count: uvs.len() as u32,
        })
    }

    /// The skin of a character: its vertices in cache order, one run per part.
    ///
    /// # Errors
    /// As [`upload`](SkinMesh::upload).
    pub fn of(headless: &Headless, look: &Arc<Look>, character: &Character) -> Result<SkinMesh, DeviceError> {
        let runs: Vec<Run> =
            character.parts.iter().map(|p| Run { triangles: p.triangles.clone(), material: p.material }).collect();
        SkinMesh::upload(headless, look, &character.triangles, &character.uvs, &runs)
    }
}

/// A vertex buffer from the host: rigid parts, poses from the reference. Also takes new vertices by `write_buffer`.
///
/// # Errors
/// [`DeviceError::Undrawable`] where normals are not as many as positions, [`DeviceError::BufferTooLarge`].
pub fn vertex_buffer(headless: &Headless, positions: &[Vec3], normals: &[Vec3]) -> Result<wgpu::Buffer, DeviceError> {
    let vertices = interleaved(positions, normals)?;
    upload(headless, "vertices", &vertices, wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST)
}

/// Positions and normals in the order of a vertex buffer, [`VERTEX_STRIDE`] bytes a vertex.
///
/// # Errors
/// [`DeviceError::Undrawable`] where normals are not as many as positions.
pub fn interleaved(positions: &[Vec3], normals: &[Vec3]) -> Result<Vec<[Vec3; 2]>, DeviceError> {
    if positions.len() != normals.len() {
        let problem = format!("{} positions with {} normals", positions.len(), normals.len());
        return Err(DeviceError::Undrawable { what: "a mesh".to_string(), problem });
    }
    Ok(positions.iter().zip(normals).map(|(&p, &n)| [p, n]).collect())
}

/// A buffer with the bytes of `items`; one element long where there are none, because a buffer cannot be empty.
pub(super) fn upload<T: bytemuck::Pod>(
    headless: &Headless,
    what: &str,
    items: &[T],
    usage: wgpu::BufferUsages,
) -> Result<wgpu::Buffer, DeviceError> {
    headless.check_buffer_size(what, size_of_val(items) as u64)?;
    let empty = [T::zeroed()];
    let items = if items.is_empty() { &empty } else { items };
    let descriptor =
        wgpu::util::BufferInitDescriptor { label: Some(what), contents: bytemuck::cast_slice(items), usage };
    Ok(headless.device.create_buffer_init(&descriptor))
}
