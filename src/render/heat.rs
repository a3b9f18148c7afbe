//! The skin in colours that tell a signed measure.

use super::color_mesh::ColorMesh;
use crate::rig::Character;
use glam::Vec3;

/// The colour of a measure from -1 to 1, linear RGB: blue, near white at 0, red.
pub fn signed_color(value: f32) -> [f32; 3] {
    const NEUTRAL: [f32; 3] = [0.72, 0.72, 0.70];
    // Half way and in full; red is darker than blue's half, and blue's full darker than red's, for eyes that mix them up.
    const RED: [[f32; 3]; 2] = [[0.80, 0.24, 0.12], [0.48, 0.0, 0.02]];
    const BLUE: [[f32; 3]; 2] = [[0.16, 0.36, 0.80], [0.01, 0.03, 0.34]];
    let value = if value.is_nan() { 0.0 } else { value.clamp(-1.0, 1.0) };
    let ends = if value > 0.0 { RED } else { BLUE };
    let t = 2.0 * value.abs();
    let (from, to, t) = if t < 1.0 { (NEUTRAL, ends[0], t) } else { (ends[0], ends[1], t - 1.0) };
    std::array::from_fn(|c| from[c] + (to[c] - from[c]) * t)
}

/// A character's deformed skin, coloured by a measure per vertex. All have one entry per vertex.
pub fn colored_skin(character: &Character, positions: &[Vec3], normals: &[Vec3], measures: &[f32]) -> ColorMesh {
    ColorMesh {
        positions: positions.to_vec(),
        normals: normals.to_vec(),
        colors: measures.iter().map(|&measure| signed_color(measure)).collect(),
        triangles: character.triangles.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_told_apart_and_sizes_get_darker() {
        let red = |v: f32| signed_color(v)[0] - signed_color(v)[2];
        let light = |v: f32| signed_color(v).iter().sum::<f32>();
        for k in 1..=10 {
            let v = k as f32 / 10.0;
            assert!(red(v) > 0.1 && red(-v) < -0.1, "{v}");
            assert!(light(v) < light(v - 0.1) && light(-v) < light(0.1 - v), "{v}");
        }
        assert_eq!(signed_color(3.0), signed_color(1.0));
        assert_eq!(signed_color(f32::NAN), signed_color(0.0));
    }
}
