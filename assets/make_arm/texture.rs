//! The base-colour picture: skin that differs from back to palm, with redder joints and nails.

use crate::mesh::{self, DIGIT_ROW};
use glam::DVec3;
use image::{
    ExtendedColorType, ImageEncoder, ImageResult,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};

/// Pixels across and down.
const SIZE: u32 = 256;

/// The picture as a PNG file.
pub fn png() -> ImageResult<Vec<u8>> {
    let mut rgb = Vec::with_capacity((SIZE * SIZE * 3) as usize);
    for y in 0..SIZE {
        for x in 0..SIZE {
            let [u, v] = [x, y].map(|i| (f64::from(i) + 0.5) / f64::from(SIZE));
            let colour = colour(u, v) + DVec3::splat(mottle(x, y));
            rgb.extend(colour.to_array().map(|c| c.clamp(0.0, 255.0).round() as u8));
        }
    }
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Adaptive).write_image(
        &rgb,
        SIZE,
        SIZE,
        ExtendedColorType::Rgb8,
    )?;
    Ok(file)
}

/// 1 at `centre`, falling off smoothly over `reach`.
fn near(x: f64, centre: f64, reach: f64) -> f64 {
    (-((x - centre) / reach).powi(2)).exp()
}

/// 0 below `from`, 1 above `to`.
fn rise(x: f64, from: f64, to: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// sRGB, 0 to 255; `u` runs from the back (0) to the palm's side (1), `v` along arm and digits.
fn colour(u: f64, v: f64) -> DVec3 {
    let (back, front) = (DVec3::new(214.0, 160.0, 131.0), DVec3::new(231.0, 183.0, 156.0));
    let (red, nail, pale) =
        (DVec3::new(205.0, 128.0, 106.0), DVec3::new(238.0, 190.0, 176.0), DVec3::new(247.0, 226.0, 212.0));
    let mut colour = back.lerp(front, rise(u, 0.15, 0.85));
    let behind = 1.0 - rise(u, 0.10, 0.45);
    if v < DIGIT_ROW {
        let at = mesh::metres_of_row(v);
        // The shoulder sees more sun than the rest; the elbow is redder, and the hand a little.
        colour = colour.lerp(back * 0.97, 0.5 * (1.0 - rise(at, 0.02, 0.20)));
        colour = colour.lerp(red, 0.40 * behind * near(at, 0.305, 0.025));
        return colour.lerp(red, 0.12 * rise(at, 0.50, 0.60));
    }
    let over = (v - DIGIT_ROW) / (1.0 - DIGIT_ROW);
    colour = colour.lerp(red, 0.12 + 0.16 * rise(over, 0.60, 1.0));
    for joint in mesh::JOINT_ROWS {
        colour = colour.lerp(red, 0.38 * behind * near(over, joint, 0.045));
        colour = colour.lerp(red * 0.92, 0.22 * (1.0 - behind) * near(over, joint, 0.014));
    }
    // A nail: a rounded patch with a pale free edge.
    let across = u / 0.26;
    let along = (over - 0.905) / 0.062;
    let edge = (across.powi(4) + along.powi(4)).sqrt().sqrt();
    let free = rise(over, 0.945, 0.957);
    let patch = colour.lerp(red * 0.9, 0.5 * near(edge, 1.0, 0.12));
    patch.lerp(nail.lerp(pale, free), 1.0 - rise(edge, 0.86, 1.0))
}

/// Faint unevenness: a grid of numbers from a hash, blended smoothly.
fn mottle(x: u32, y: u32) -> f64 {
    const CELL: u32 = 16;
    let at = |cx: u32, cy: u32| {
        let mut h = cx.wrapping_mul(0x9E37_79B1) ^ cy.wrapping_mul(0x85EB_CA77);
        h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
        f64::from((h ^ (h >> 13)) % 1024) / 1023.0 - 0.5
    };
    let share = |i: u32| rise(f64::from(i % CELL) / f64::from(CELL), 0.0, 1.0);
    let (cx, cy) = (x / CELL, y / CELL);
    let row = |cy: u32| at(cx, cy) + (at(cx + 1, cy) - at(cx, cy)) * share(x);
    7.0 * (row(cy) + (row(cy + 1) - row(cy)) * share(y))
}
