//! Materials as far as they are shown: base colour, its texture, and which sides.

use super::accessor::Source;
use super::label;
use crate::rig::{Image, Material};
use gltf::json::image;
use std::collections::HashMap;
use std::io::Cursor;

/// Longest side of a texture, pixels.
const SIDE: u32 = 8192;
/// Pixels of all textures of a file together.
const PIXELS: u64 = 1 << 27;
/// Longest file of a texture, bytes.
const FILE: u64 = 1 << 28;

/// Materials and images in the order in which surfaces first ask for them. A texture that cannot be read leaves a note
/// and a material without texture: it changes no shape.
#[derive(Default)]
pub(super) struct Materials {
    pub materials: Vec<Material>,
    pub images: Vec<Image>,
    known: HashMap<Option<usize>, u32>,
    /// Per image of the file: its place here, or none where it cannot be shown.
    known_images: HashMap<usize, Option<u32>>,
    pixels: u64,
}

impl Materials {
    /// The place of the file's material `index`, or of the default one.
    pub(super) fn place(&mut self, source: &Source, index: Option<usize>, place: &str) -> u32 {
        if let Some(&known) = self.known.get(&index) {
            return known;
        }
        let material = match index {
            Some(at) => self.read(source, at, place),
            None => Material::default(),
        };
        let at = self.materials.len() as u32;
        self.materials.push(material);
        self.known.insert(index, at);
        at
    }

    fn read(&mut self, source: &Source, index: usize, place: &str) -> Material {
        let Some(json) = source.root.materials.get(index) else {
            source.cx.note(format!("{place}: it refers to material {index}, which the file does not have"));
            return Material::default();
        };
        let element = label("material", index, json.name.as_deref());
        let pbr = &json.pbr_metallic_roughness;
        let texture = pbr.base_color_texture.as_ref().and_then(|info| {
            if info.tex_coord != 0 {
                source.cx.note(format!("{element}: its texture uses TEXCOORD_{}, only 0 is read", info.tex_coord));
                return None;
            }
            let texture = source.root.textures.get(info.index.value());
            let image = texture.map(|t| t.source.value()).filter(|&i| i < source.root.images.len());
            if image.is_none() {
                source.cx.note(format!("{element}: its texture has no image that is read, and is left out"));
            }
            self.image(source, image?)
        });
        let base_color = pbr.base_color_factor.0;
        let finite = base_color.iter().all(|c| c.is_finite());
        Material {
            name: crate::error::one_line(json.name.as_deref().unwrap_or_default()),
            base_color: if finite { base_color.map(|c| c.clamp(0.0, 1.0)) } else { [1.0; 4] },
            texture,
            double_sided: json.double_sided,
        }
    }

    fn image(&mut self, source: &Source, index: usize) -> Option<u32> {
        if let Some(&known) = self.known_images.get(&index) {
            return known;
        }
        let json = &source.root.images[index];
        let element = label("image", index, json.name.as_deref());
        let place = match self.decode(source, json, &element) {
            Ok(image) => {
                self.pixels += u64::from(image.width) * u64::from(image.height);
                self.images.push(image);
                Some(self.images.len() as u32 - 1)
            }
            Err(why) => {
                source.cx.note(format!("{element}: {why}; shown without it"));
                None
            }
        };
        self.known_images.insert(index, place);
        place
    }

    fn decode(&self, source: &Source, json: &image::Image, element: &str) -> Result<Image, String> {
        let fetched;
        let bytes = match (&json.uri, json.buffer_view) {
            (Some(uri), _) => {
                fetched = source.buffers.fetch(uri, element, FILE).map_err(|e| e.to_string())?;
                &fetched[..]
            }
            (None, Some(view)) => source.buffers.view(view, element).map_err(|e| e.to_string())?.0,
            (None, None) => return Err("it has neither a URI nor a buffer view".into()),
        };
        let unreadable =
            |e: &dyn std::fmt::Display| format!("cannot be read ({})", crate::error::one_line(&e.to_string()));
        let reader = || ::image::ImageReader::new(Cursor::new(bytes)).with_guessed_format();
        let (width, height) = reader().map_err(|e| unreadable(&e))?.into_dimensions().map_err(|e| unreadable(&e))?;
        let pixels = u64::from(width) * u64::from(height);
        if width > SIDE || height > SIDE || pixels > PIXELS - self.pixels {
            return Err(format!(
                "{width} x {height} pixels are more than the {SIDE} a side, or {PIXELS} in all, that are read"
            ));
        }
        let mut reader = reader().map_err(|e| unreadable(&e))?;
        let mut limits = ::image::Limits::default();
        limits.max_image_width = Some(SIDE);
        limits.max_image_height = Some(SIDE);
        // Sixteen bits in four channels, and the decoder's own rows.
        limits.max_alloc = Some(pixels * 8 + (64 << 20));
        reader.limits(limits);
        let rgba = reader.decode().map_err(|e| unreadable(&e))?.into_rgba8();
        Ok(Image { width: rgba.width(), height: rgba.height(), rgba: rgba.into_raw() })
    }
}
