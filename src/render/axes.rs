//! Axes of muscles in motion as beads on strings: what holds each point, how deep it is where it ought not to be, and the
//! path that it came.

use super::color_mesh::ColorMesh;
use super::muscles::{posed, to_posed};
use crate::dynamics::{Depth, Particle};
use crate::field::muscle::AxisPoint;
use crate::rig::{Pose, Rig};
use glam::{Vec3, Vec4Swizzles};
use std::collections::VecDeque;

/// Radius of a bead over the distance of two, and of the string over the bead's.
const BEAD: f32 = 0.28;
const STRING: f32 = 0.35;
/// Linear RGB of beads: free; fixed to a bone; held by another muscle, by a bone, by the skin. Of the palette of Okabe and
/// Ito, which everybody can tell apart.
const FREE: [f32; 3] = [0.80, 0.80, 0.76];
const FIXED: [f32; 3] = [0.02, 0.02, 0.02];
const BY_MUSCLE: [f32; 3] = [0.09, 0.46, 0.81];
const BY_BONE: [f32; 3] = [0.86, 0.60, 0.0];
const BY_SKIN: [f32; 3] = [0.0, 0.34, 0.17];

/// Linear RGB of beads that are too deep in something. No muscle is of such a colour, however active.
const DEEP: [f32; 3] = [1.0, 0.0, 0.55];
/// Share of its radius from which a particle is too deep, and of which a bead is twice as large.
const DEEP_FROM: f32 = 0.02;
const DEEP_TWICE: f32 = 0.2;
/// Linear RGB of paths, and their largest radius over that of a string.
const PATH: [f32; 3] = [1.0, 1.0, 1.0];
const PATH_SHARE: f32 = 0.55;

/// The axes of all muscles of a rig, as [`muscle_meshes`](super::muscle_meshes) takes them, with a bead on each point: light where it is free,
/// black at the ends; blue, amber or green where mostly another muscle, a bone or the skin held it in the last substep;
/// larger and pink where `depths`, if there are any, have it in a bone or in a muscle or outside the skin by more than 2 %
/// of its radius, the larger the deeper, twice as large from 20 % on. Without particles there are no axes to see.
pub fn axis_meshes(
    rig: &Rig,
    pose: &Pose,
    axes: &[AxisPoint],
    particles: &[Particle],
    depths: &[Depth],
) -> Vec<ColorMesh> {
    let meshes = rig.muscles.iter().filter_map(|rest| {
        let (points, to_posed) = posed(pose, rest, axes)?;
        let own = particles.get(rest.first_point as usize..)?.get(..points.len())?;
        let places: Vec<Vec3> = points.iter().map(|p| to_posed.transform_point3(p.position.xyz())).collect();
        let radius = bead_radius(places.iter().copied(), Vec3::length);
        let mut mesh = ColorMesh::default();
        for pair in places.windows(2) {
            add_string(&mut mesh, [pair[0], pair[1]], [STRING * radius; 2], FREE);
        }
        for (i, (&place, particle)) in places.iter().zip(own).enumerate() {
            let share = depths.get(rest.first_point as usize + i).map_or(0.0, Depth::share);
            let (size, color) = bead(particle, share);
            add_bead(&mut mesh, place, size * radius, color);
        }
        Some(mesh)
    });
    meshes.collect()
}

/// Where the points of all axes have been of late, as seen from the bone whose skin a muscle shapes: in the scene, paths of
/// a character that moves would hide it.
#[derive(Clone, Debug, Default)]
pub struct Paths {
    /// Times, seconds, ascending, and places of all points, each in the space of its muscle's field group at rest.
    seen: VecDeque<(f32, Vec<Vec3>)>,
}

impl Paths {
    /// How long a path is, seconds.
    pub const SECONDS: f32 = 0.5;

    /// Forgets all paths.
    pub fn clear(&mut self) {
        self.seen.clear();
    }

    /// Goes on to `time`, seconds; `axes` are the points of all muscles, as for [`axis_meshes`]. What is no later than the
    /// last time begins anew.
    pub fn add(&mut self, time: f32, axes: &[AxisPoint]) {
        if self.seen.back().is_some_and(|(last, before)| *last >= time || before.len() != axes.len()) {
            self.clear();
        }
        self.seen.push_back((time, axes.iter().map(|p| p.position.xyz()).collect()));
        // Room for the rounding of times.
        while self.seen.front().is_some_and(|(first, _)| time - first > 1.001 * Paths::SECONDS) {
            self.seen.pop_front();
        }
    }

    /// The paths of all points in a pose, one mesh a muscle: straight from time to time, thinner the longer ago.
    pub fn meshes(&self, rig: &Rig, pose: &Pose) -> Vec<ColorMesh> {
        let Some((now, _)) = self.seen.back() else { return Vec::new() };
        let meshes = rig.muscles.iter().filter_map(|rest| {
            let to_posed = to_posed(pose, rest)?;
            let own = rest.first_point as usize..=(rest.first_point + rest.segments) as usize;
            let runs = self.seen.iter().map(|(time, places)| Some((time, places.get(own.clone())?)));
            let runs = runs.collect::<Option<Vec<_>>>()?;
            let size = |v: Vec3| to_posed.transform_vector3(v).length();
            let thick = PATH_SHARE * STRING * bead_radius(runs.last()?.1.iter().copied(), size);
            let mut mesh = ColorMesh::default();
            for pair in runs.windows(2) {
                let radii = [0, 1].map(|k| thick * (1.0 - (now - pair[k].0) / Paths::SECONDS).max(0.0));
                for (from, to) in pair[0].1.iter().zip(pair[1].1).filter(|(from, to)| from != to) {
                    add_string(&mut mesh, [from, to].map(|p| to_posed.transform_point3(*p)), radii, PATH);
                }
            }
            Some(mesh)
        });
        meshes.collect()
    }
}

/// Radius of the beads on points at these places; `size` measures the way from one to the next.
fn bead_radius(places: impl ExactSizeIterator<Item = Vec3> + Clone, size: impl Fn(Vec3) -> f32) -> f32 {
    let segments = (places.len() - 1).max(1) as f32;
    let length: f32 = places.clone().zip(places.skip(1)).map(|(p, q)| size(q - p)).sum();
    BEAD * length / segments
}

/// Size and colour of the bead of a particle that is deep in something by a share of its radius.
fn bead(particle: &Particle, share: f32) -> (f32, [f32; 3]) {
    if share > DEEP_FROM { (1.0 + (share / DEEP_TWICE).min(1.0), DEEP) } else { (1.0, bead_color(particle)) }
}

/// The colour of what pushed most.
fn bead_color(particle: &Particle) -> [f32; 3] {
    if particle.velocity.w == 0.0 {
        return FIXED;
    }
    let held = particle.pushes;
    let kinds = [(held.x.max(held.y), BY_MUSCLE), (held.z, BY_BONE), (held.w, BY_SKIN)];
    let most = kinds.iter().fold((0.0, FREE), |most, &kind| if kind.0 > most.0 { kind } else { most });
    most.1
}

/// An icosahedron, round enough for a few pixels.
fn add_bead(mesh: &mut ColorMesh, center: Vec3, radius: f32, color: [f32; 3]) {
    const CORNERS: [[f32; 3]; 12] = {
        const A: f32 = 0.525_731_1;
        const B: f32 = 0.850_650_8;
        [
            [-A, B, 0.0],
            [A, B, 0.0],
            [-A, -B, 0.0],
            [A, -B, 0.0],
            [0.0, -A, B],
            [0.0, A, B],
            [0.0, -A, -B],
            [0.0, A, -B],
            [B, 0.0, -A],
            [B, 0.0, A],
            [-B, 0.0, -A],
            [-B, 0.0, A],
        ]
    };
    const FACES: [[u32; 3]; 20] = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let normals = CORNERS.map(Vec3::from);
    mesh.append(&ColorMesh {
        positions: normals.iter().map(|n| center + *n * radius).collect(),
        normals: normals.to_vec(),
        colors: vec![color; normals.len()],
        triangles: FACES.to_vec(),
    });
}

/// A prism, or a pyramid without its point, of three sides and open ends, which beads or the next string close.
fn add_string(mesh: &mut ColorMesh, [from, to]: [Vec3; 2], radii: [f32; 2], color: [f32; 3]) {
    let along = (to - from).normalize_or(Vec3::Y);
    let across = along.any_orthonormal_vector();
    let third = along.cross(across);
    let side = |k: u32| {
        let (sine, cosine) = (std::f32::consts::TAU * k as f32 / 3.0).sin_cos();
        across * cosine + third * sine
    };
    let normals: Vec<Vec3> = (0..6).map(|i| side(i % 3)).collect();
    let place = |(i, n): (usize, &Vec3)| if i < 3 { from + *n * radii[0] } else { to + *n * radii[1] };
    mesh.append(&ColorMesh {
        positions: normals.iter().enumerate().map(place).collect(),
        colors: vec![color; normals.len()],
        triangles: (0..3).flat_map(|k| [[k, (k + 1) % 3, k + 3], [(k + 1) % 3, (k + 1) % 3 + 3, k + 3]]).collect(),
        normals,
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    fn volume(mesh: &ColorMesh) -> f32 {
        let corners = mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize]));
        corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    #[test]
    fn beads_face_outward_and_are_nearly_round() {
        let mut bead = ColorMesh::default();
        add_bead(&mut bead, Vec3::new(1.0, 2.0, 3.0), 0.5, FREE);
        let share = volume(&bead) / (4.0 / 3.0 * std::f32::consts::PI * 0.125);
        assert!((0.58..0.63).contains(&share), "{share}: an icosahedron fills .605 of its sphere");
        bead.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(volume(&bead) < 0.0, "inside out must be seen");
    }

    #[test]
    fn a_bead_has_the_colour_of_what_holds_it_most() {
        let color = |pushes, mobility| {
            bead_color(&Particle { pushes, velocity: Vec3::ZERO.extend(mobility), ..Particle::default() })
        };
        assert_eq!(color(Vec4::ZERO, 1.0), FREE);
        assert_eq!(color(Vec4::ONE, 0.0), FIXED);
        assert_eq!(color(Vec4::new(0.0, 0.3, 0.1, 0.2), 1.0), BY_MUSCLE);
        assert_eq!(color(Vec4::new(0.0, 0.1, 0.3, 0.2), 1.0), BY_BONE);
        assert_eq!(color(Vec4::new(0.0, 0.1, 0.1, 0.2), 1.0), BY_SKIN);
    }

    #[test]
    fn what_is_too_deep_is_pink_and_larger_the_deeper() {
        let held = Particle { velocity: Vec4::W, pushes: Vec4::Z, ..Particle::default() };
        assert_eq!(bead(&held, 0.0199), (1.0, BY_BONE));
        let sizes = [0.021, 0.1, 0.2, 5.0].map(|share| {
            assert_eq!(bead(&held, share).1, DEEP, "{share}");
            bead(&held, share).0
        });
        assert!(sizes[0] > 1.0 && sizes[0] < sizes[1] && sizes[1] < sizes[2], "{sizes:?}");
        assert_eq!(sizes[2..], [2.0, 2.0]);
    }

    #[test]
    fn a_path_is_what_was_seen_in_the_last_half_second() {
        let mut paths = Paths::default();
        let point = |x: f32| [AxisPoint { position: Vec4::X * x, ..AxisPoint::default() }];
        let places = |paths: &Paths| paths.seen.iter().map(|(_, places)| places[0].x).collect::<Vec<_>>();
        for frame in 0..40 {
            paths.add(frame as f32 / 30.0, &point(frame as f32));
        }
        assert_eq!(places(&paths), (24..40).map(|f| f as f32).collect::<Vec<_>>());
        paths.add(0.2, &point(0.0));
        assert_eq!(places(&paths), [0.0], "what goes back in time begins anew");
        paths.clear();
        assert!(places(&paths).is_empty());
    }

    #[test]
    fn a_string_thins_out_from_end_to_end() {
        let mut mesh = ColorMesh::default();
        add_string(&mut mesh, [Vec3::ZERO, Vec3::Y], [0.0, 0.25], PATH);
        let widths: Vec<f32> = mesh.positions.iter().map(|p| (p.x * p.x + p.z * p.z).sqrt()).collect();
        assert!(widths[..3].iter().all(|w| *w == 0.0) && widths[3..].iter().all(|w| (w - 0.25).abs() < 1e-6));
    }
}
