//! What a picture is drawn into, by size.

use super::picture::Picture;
use crate::error::DeviceError;
use crate::gpu::{Headless, readback};

/// Samples per pixel.
pub(super) const SAMPLES: u32 = 4;
/// sRGB, so that blending and resolving happen in linear light.
pub(super) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Colour and depth for pictures of one size, with 4 samples a pixel; reused for every frame.
pub struct Targets {
    pub(super) samples: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
    pub(super) resolved: wgpu::Texture,
    pub(super) resolved_view: wgpu::TextureView,
}

impl Targets {
    /// Allocates for pictures of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`DeviceError::PictureSize`] or [`DeviceError::BufferTooLarge`] before anything is allocated where the adapter
    /// cannot hold the picture; otherwise what the device reports.
    pub fn new(headless: &Headless, width: u32, height: u32) -> Result<Targets, DeviceError> {
        let had = headless.limits.max_texture_dimension_2d;
        if width == 0 || height == 0 || width > had || height > had {
            return Err(DeviceError::PictureSize { width, height, had });
        }
        headless.check_buffer_size("reading the picture", readback::picture_bytes(width, height))?;
        // Colour and depth alike; what is resolved takes a quarter.
        let bytes = u64::from(width) * u64::from(height) * u64::from(SAMPLES) * 4;
        headless.check_buffer_size(&format!("drawing {width} x {height} pixels of {SAMPLES} samples"), bytes)?;
        let texture = |label, sample_count, format, usage| {
            headless.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let samples = texture("samples", SAMPLES, COLOR_FORMAT, attachment);
        let depth = texture("depth", SAMPLES, DEPTH_FORMAT, attachment);
        let resolved = texture("picture", 1, COLOR_FORMAT, attachment | wgpu::TextureUsages::COPY_SRC);
        headless.check()?;
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Targets { samples: view(&samples), depth: view(&depth), resolved_view: view(&resolved), resolved })
    }

    /// Pixels across over pixels down, for [`Camera::frame`](super::Camera::frame).
    pub fn aspect(&self) -> f32 {
        self.resolved.width() as f32 / self.resolved.height() as f32
    }

    /// Waits for the picture drawn last and brings it to the host.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read(&self, headless: &Headless) -> Result<Picture, DeviceError> {
        let rgba = readback::read_rgba(headless, &self.resolved)?;
        Ok(Picture { width: self.resolved.width(), height: self.resolved.height(), rgba })
    }
}
