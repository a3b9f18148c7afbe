//! Meshes of muscles, for looking at.

use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

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

/// A muscle's centre line, with the direction of its section's long axis at each point.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Points from origin to insertion, metres.
    pub points: Vec<Vec3>,
    /// Per point a vector towards the section's long axis; need not be unit or square to the axis.
    pub normals: Vec<Vec3>,
}

impl Axis {
    /// A straight axis of `segments` segments from `p0` to `p1`, closer together towards both ends, where the
    /// profile curves most.
    pub fn straight(p0: Vec3, p1: Vec3, normal: Vec3, segments: u32) -> Axis {
        let segments = segments.max(1);
        let points = (0..=segments).map(|i| p0.lerp(p1, 0.5 - 0.5 * (PI * i as f32 / segments as f32).cos())).collect();
        Axis { points, normals: vec![normal; segments as usize + 1] }
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

/// A closed tube round `axis`.
///
/// `radius(s, theta)` is the distance from the axis in metres at share `s` of its length, `theta` from the long axis
/// turning right-handed about the axis; `color(s)` is linear RGB; `around` vertices make a section (at least 3).
/// Both ends are closed by a fan to the axis' own end point. Normals are the area-weighted mean of the faces.
/// An axis without length gives an empty mesh, as does one whose normals are not as many as its points.
pub fn tube(axis: &Axis, around: u32, radius: impl Fn(f32, f32) -> f32, color: impl Fn(f32) -> [f32; 3]) -> ColorMesh {
    let around = around.max(3);
    let points = &axis.points;
    let lengths: Vec<f32> = points.windows(2).map(|w| w[0].distance(w[1])).collect();
    let total: f32 = lengths.iter().sum();
    if !(total > 0.0 && total.is_finite()) || axis.normals.len() != points.len() {
        return ColorMesh::default();
    }
    let mut mesh = ColorMesh::default();
    let mut passed = 0.0;
    for (i, &point) in points.iter().enumerate() {
        let s = passed / total;
        passed += lengths.get(i).copied().unwrap_or(0.0);
        let before = points[i.saturating_sub(1)];
        let after = points[(i + 1).min(points.len() - 1)];
        let tangent = (after - before).normalize_or(Vec3::Y);
        let normal = axis.normals[i].reject_from_normalized(tangent).normalize_or(tangent.any_orthonormal_vector());
        let binormal = tangent.cross(normal);
        let color = color(s);
        for k in 0..around {
            let theta = TAU * k as f32 / around as f32;
            let turn = Vec2::from_angle(theta);
            mesh.positions.push(point + (normal * turn.x + binormal * turn.y) * radius(s, theta));
            mesh.colors.push(color);
        }
    }
    let rings = points.len() as u32;
    for i in 0..rings - 1 {
        for k in 0..around {
            let [a, b] = [k, (k + 1) % around].map(|k| i * around + k);
            let [c, d] = [a + around, b + around];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    for (ring, point, s) in [(0, points[0], 0.0), (rings - 1, points[points.len() - 1], 1.0)] {
        let pole = mesh.positions.len() as u32;
        mesh.positions.push(point);
        mesh.colors.push(color(s));
        for k in 0..around {
            let [a, b] = [k, (k + 1) % around].map(|k| ring * around + k);
            mesh.triangles.push(if ring == 0 { [pole, b, a] } else { [pole, a, b] });
        }
    }
    mesh.normals = smooth_normals(&mesh.positions, &mesh.triangles);
    // A pointed end has no area at its pole: it looks along the axis.
    for (k, out) in [(2, points[0] - points[1]), (1, points[points.len() - 1] - points[points.len() - 2])] {
        let pole = mesh.normals.len() - k;
        if mesh.normals[pole] == Vec3::ZERO {
            mesh.normals[pole] = out.normalize_or(Vec3::Y);
        }
    }
    mesh
}

/// Area-weighted vertex normals, unit; zero where a vertex touches no area.
fn smooth_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        let face = (b - a).cross(c - a);
        for &i in t {
            normals[i as usize] += face;
        }
    }
    normals.into_iter().map(Vec3::normalize_or_zero).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    fn volume(mesh: &ColorMesh) -> f32 {
        mesh.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    fn spindle(normal: Vec3) -> ColorMesh {
        let axis = Axis::straight(Vec3::new(0.0, 0.1, 0.0), Vec3::new(0.3, 0.1, 0.0), normal, 48);
        tube(&axis, 64, |s, _| 0.05 * (4.0 * s * (1.0 - s)).sqrt(), |_| [1.0, 0.0, 0.0])
    }

    #[test]
    fn a_spindle_has_an_ellipsoids_volume_and_faces_outward() {
        // Half axes 0.15, 0.05, 0.05; an inscribed mesh of 64 sides and 48 rings lacks under 1 %.
        let exact = 4.0 / 3.0 * PI * 0.15 * 0.05 * 0.05;
        let mesh = spindle(Vec3::Y);
        let ratio = volume(&mesh) / exact;
        assert!((0.99..1.0).contains(&ratio), "{ratio}");
        let center = Vec3::new(0.15, 0.1, 0.0);
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((n.length() - 1.0).abs() < 1e-4);
            assert!(n.dot(*p - center) > 0.0, "{p} {n}");
        }
    }

    #[test]
    fn every_edge_is_shared_by_two_faces_in_opposite_sense() {
        let mesh = spindle(Vec3::Z);
        let mut edges = HashMap::new();
        for t in &mesh.triangles {
            for k in 0..3 {
                *edges.entry((t[k], t[(k + 1) % 3])).or_insert(0) += 1;
            }
        }
        assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)));
    }

    #[test]
    fn the_long_axis_follows_the_normal() {
        let axis = Axis::straight(Vec3::ZERO, Vec3::X, Vec3::new(0.7, 0.0, 2.0), 8);
        let mesh = tube(&axis, 32, |_, theta| if theta.cos().abs() > 0.99 { 0.2 } else { 0.1 }, |_| [0.0; 3]);
        let reach = |d: Vec3| mesh.positions.iter().map(|p| p.dot(d)).fold(0.0, f32::max);
        assert!((reach(Vec3::Z) - 0.2).abs() < 1e-6 && reach(Vec3::Y) < 0.11);
    }

    #[test]
    fn an_axis_without_length_is_empty() {
        let point = Axis { points: vec![Vec3::ONE; 4], normals: vec![Vec3::X; 4] };
        assert_eq!(tube(&point, 8, |_, _| 0.1, |_| [0.0; 3]), ColorMesh::default());
        let none = Axis { points: Vec::new(), normals: Vec::new() };
        assert_eq!(tube(&none, 8, |_, _| 0.1, |_| [0.0; 3]), ColorMesh::default());
    }

    #[test]
    fn appended_meshes_keep_their_own_corners() {
        let mut both = spindle(Vec3::Y);
        let single = both.clone();
        both.append(&single);
        assert_eq!(both.triangles.len(), 2 * single.triangles.len());
        assert!((volume(&both) / volume(&single) - 2.0).abs() < 1e-4);
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
