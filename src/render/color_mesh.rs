//! Coloured meshes, for looking at.

use glam::Vec3;

/// A mesh with a colour per vertex, in scene space, made anew for each frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColorMesh {
    /// Positions, metres.
    pub positions: Vec<Vec3>,
    /// Unit normals, outward.
    pub normals: Vec<Vec3>,
    /// Linear RGB.
    pub colors: Vec<[f32; 3]>,
    /// Corner indices, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl ColorMesh {
    /// Adds another mesh behind this one.
    pub fn append(&mut self, other: &ColorMesh) {
        let base = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.colors.extend(&other.colors);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
    }
}

/// The colour of a muscle at `activation` 0..=1, linear RGB: muted rose at rest, saturated red when fully active.
pub fn activation_color(activation: f32) -> [f32; 3] {
    // Rest, half active, active; chosen to differ in lightness too, for eyes that tell red and grey apart badly.
    const RAMP: [[f32; 3]; 3] = [[0.40, 0.27, 0.36], [0.64, 0.17, 0.16], [0.86, 0.035, 0.02]];
    let t = if activation.is_nan() { 0.0 } else { activation.clamp(0.0, 1.0) * 2.0 };
    let (from, to, t) = if t < 1.0 { (RAMP[0], RAMP[1], t) } else { (RAMP[1], RAMP[2], t - 1.0) };
    std::array::from_fn(|c| from[c] + (to[c] - from[c]) * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn appended_meshes_keep_their_own_corners() {
        let triangle = ColorMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            colors: vec![[1.0, 0.0, 0.0]; 3],
            triangles: vec![[0, 1, 2]],
        };
        let mut both = triangle.clone();
        both.append(&triangle);
        assert_eq!(both.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(both.positions.len(), 6);
    }

    #[test]
    fn redder_means_more_active() {
        let redness = |a: f32| activation_color(a)[0] - activation_color(a)[1] - activation_color(a)[2];
        let steps: Vec<f32> = (0..=10).map(|i| redness(i as f32 / 10.0)).collect();
        assert!(steps.windows(2).all(|w| w[1] > w[0] + 0.02), "{steps:?}");
        assert_eq!(activation_color(7.0), activation_color(1.0));
        assert_eq!(activation_color(f32::NAN), activation_color(0.0));
    }
}
