use super::*;
use crate::field::grid::sample;
use glam::Vec4Swizzles;
use std::collections::HashMap;

type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

const MARGIN: f64 = 0.03;

/// A sphere of unit radius: an icosahedron whose triangles are halved along every edge, `times` over.
fn ball(times: u32) -> Mesh {
    let g = (1.0 + 5f32.sqrt()) / 2.0;
    let mut positions: Vec<Vec3> = (0..3)
        .flat_map(|axis| {
            [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)].map(|(a, b)| {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3]) = (a, b);
                Vec3::from(p).normalize()
            })
        })
        .collect();
    let close = |a: Vec3, b: Vec3| a.distance(b) < 1.1;
    let mut triangles = Vec::new();
    for a in 0..12u32 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [x, y, z] = [a, b, c].map(|i| positions[i as usize]);
                if close(x, y) && close(y, z) && close(z, x) {
                    triangles.push(if (y - x).cross(z - x).dot(x) > 0.0 { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..times {
        let mut halves = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *halves.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]: [u32; 3]| {
                let (x, y, z) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
            })
            .collect();
    }
    (positions, triangles)
}

/// A ball whose halves are drawn apart along Y: a capsule of the given radius and length between centres.
fn capsule(times: u32, radius: f32, length: f32) -> Mesh {
    let (mut positions, triangles) = ball(times);
    for p in &mut positions {
        *p = *p * radius + Vec3::Y * (0.5 * length * p.y.signum() * f32::from(p.y != 0.0));
    }
    (positions, triangles)
}

fn boxed(half: Vec3) -> Mesh {
    let at = |i: usize| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| bit as f32 * 2.0 - 1.0);
    let positions = (0..8).map(|i| Vec3::from(at(i)) * half).collect();
    let faces = [[0u32, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (positions, faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
}

fn box_distance(p: Vec3, half: Vec3) -> f32 {
    let q = p.abs() - half;
    q.max(Vec3::ZERO).length() + q.max_element().min(0.0)
}

fn filled(mesh: &Mesh) -> FilledGrid {
    fill(&mesh.0, &mesh.1, DMat3::IDENTITY, MARGIN).expect("a mesh with a field")
}

/// Largest error at points in the grid, in cells, of the distance where `counts` says that it counts.
fn worst(filled: &FilledGrid, expected: impl Fn(Vec3) -> f32, counts: impl Fn(Vec3) -> bool) -> f32 {
    let back = filled.grid.rest_to_grid.as_dmat4().inverse();
    let last = UVec3::new(filled.grid.size_x, filled.grid.size_y, filled.grid.size_z).as_dvec3() - 1.0;
    let (mut error, mut seen) = (0.0f32, 0);
    for k in 0..6000 {
        let t = f64::from(k);
        let share = DVec3::new((t * 0.754_877_67).fract(), (t * 0.569_840_29).fract(), (t * 0.618_033_99).fract());
        let p = back.transform_point3(share * last * 0.999_99).as_vec3();
        if counts(p) {
            let (distance, _) = sample(&filled.grid, &filled.nodes, p).expect("in the grid");
            error = error.max((distance - expected(p)).abs() / filled.cell);
            seen += 1;
        }
    }
    assert!(seen > 200, "{seen}");
    error
}

#[test]
fn a_sphere_is_a_sphere_and_better_the_finer_it_is() {
    let mut mesh = ball(5);
    mesh.0.iter_mut().for_each(|p| *p *= 0.1);
    let field = filled(&mesh);
    assert_eq!(field.grid.size_x.max(field.grid.size_y), 48);
    // Trilinear interpolation errs by cell^2 / (4 r); the mesh itself lies 0.04 mm inside its sphere, and at its centre the
    // distance has a kink of its own.
    let error = worst(&field, |p| p.length() - 0.1, |p| p.length() > 0.03);
    assert!(error < 0.06, "{error}");
    assert!(worst(&field, |p| p.length() - 0.104, |p| p.length() > 0.03) > 0.5, "another radius must be seen");
    for node in &field.nodes {
        assert!((node.xyz().length() - 1.0).abs() < 1e-5, "{node}");
    }
    let mut worst_angle = 0.0f32;
    for k in 0..2000 {
        let t = k as f32;
        let direction = Vec3::new((t * 1.7).sin(), (t * 0.9).cos(), (t * 2.3).sin()).normalize();
        let p = direction * (0.06 + 0.06 * (t * 0.37).fract());
        let (_, gradient) = sample(&field.grid, &field.nodes, p).expect("in the grid");
        worst_angle = worst_angle.max((gradient.normalize() - direction).length());
    }
    // The nearest triangle's normal stands for that of the sphere: by up to half the angle of a triangle's edge, 1 degree.
    assert!(worst_angle < 0.02, "{worst_angle}");
}

#[test]
fn boxes_and_capsules_have_their_own_distances() {
    let half = Vec3::new(0.1, 0.03, 0.02);
    let field = filled(&boxed(half));
    // Kinks at edges are rounded by a share of a cell.
    let error = worst(&field, |p| box_distance(p, half), |_| true);
    assert!(error < 0.5, "{error}");
    let outside = worst(&field, |p| box_distance(p, half), |p| (p.abs() - half).min_element() > field.cell);
    // Beside a corner, one cell and more from it on every side: cell^2 / (4 r) again.
    assert!(outside < 0.1, "{outside}");
    assert!(worst(&field, |p| box_distance(p, half * 1.1), |_| true) > 1.0, "another box must be seen");
    // A long bone: 3 cm thick and 40 cm long.
    let field = filled(&capsule(5, 0.015, 0.37));
    assert!(field.grid.size_y > 64 && field.nodes.len() < 120_000, "{:?}", field.grid);
    let axis = |p: Vec3| (p - Vec3::Y * p.y.clamp(-0.185, 0.185)).length();
    let error = worst(&field, |p| axis(p) - 0.015, |p| axis(p) > 2.0 * field.cell);
    // Again cell^2 / (4 r), at two cells from the axis and more.
    assert!(error < 0.125, "{error} cells of {} m", field.cell);
}

#[test]
fn inverted_and_doubled_meshes_have_an_inside() {
    let half = Vec3::new(0.1, 0.05, 0.05);
    let (positions, triangles) = boxed(half);
    let flipped: Vec<[u32; 3]> = triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let right = filled(&(positions.clone(), triangles.clone()));
    // All the same but what lies on a triangle itself, where the turn of its corners tells the last bits.
    let same = |mesh: Mesh| {
        let other = filled(&mesh);
        other.nodes.iter().zip(&right.nodes).all(|(a, b)| (*a - *b).abs().max_element() < 1e-5)
    };
    assert!(same((positions.clone(), flipped.clone())), "inverted");
    assert!(same((positions.clone(), [triangles.clone(), flipped].concat())), "both sides");
    let apart: Vec<Vec3> = positions.iter().map(|p| *p * 1.0001).collect();
    let twice: Vec<[u32; 3]> = triangles
        .iter()
        .chain(&triangles)
        .copied()
        .enumerate()
        .map(|(i, t)| if i < 12 { t } else { t.map(|c| c + 8) })
        .collect();
    let doubled = filled(&([positions.clone(), apart].concat(), twice));
    assert!(worst(&doubled, |p| box_distance(p, half), |_| true) < 0.5, "wound round twice");
    let without = |n: usize| (positions.clone(), triangles[..triangles.len() - n].to_vec());
    assert!(!same(without(2)), "a missing face must be seen");
}

#[test]
fn an_open_tube_has_an_inside_between_its_ends() {
    let (positions, triangles) = capsule(4, 0.02, 0.2);
    let open: Vec<[u32; 3]> =
        triangles.into_iter().filter(|t| t.iter().any(|&i| positions[i as usize].y < 0.1)).collect();
    let field = filled(&(positions, open));
    let at = |y: f32| sample(&field.grid, &field.nodes, Vec3::new(0.003, y, 0.0)).expect("in the grid").0;
    for y in [-0.09f32, -0.05, 0.0, 0.05, 0.08] {
        assert!(at(y) < -0.012, "{y}: {}", at(y));
    }
    for y in [-0.14f32, 0.115, 0.12] {
        assert!(at(y) > 0.0, "{y}: {}", at(y));
    }
}

#[test]
fn odd_triangles_do_no_harm_and_odd_meshes_are_refused() {
    let (mut positions, mut triangles) = boxed(Vec3::splat(0.05));
    let clean = filled(&(positions.clone(), triangles.clone()));
    positions.push(Vec3::new(0.05, 0.0, 0.05));
    triangles.extend([[0, 0, 0], [5, 5, 7], [5, 8, 7], [3, 3, 1]]);
    let dirty = filled(&(positions.clone(), triangles));
    assert!(dirty.nodes.iter().all(|n| n.is_finite()));
    assert!(worst(&dirty, |p| box_distance(p, Vec3::splat(0.05)), |_| true) < 0.5);
    assert_eq!(dirty.nodes.len(), clean.nodes.len());
    let refused = |positions: &[Vec3], triangles: &[[u32; 3]]| {
        // Not `expect_err`, which would print all nodes.
        let Err(error) = fill(positions, triangles, DMat3::IDENTITY, MARGIN) else { panic!("it has a field") };
        error
    };
    assert_eq!(refused(&positions, &[]), MeshDistanceError::NoSize);
    assert_eq!(refused(&[Vec3::splat(1e9); 3], &[[0, 1, 2]]), MeshDistanceError::NoSize);
    assert_eq!(
        refused(&[Vec3::splat(f32::MAX), Vec3::splat(-f32::MAX), Vec3::X], &[[0, 1, 2]]),
        MeshDistanceError::NoSize
    );
    assert!(matches!(refused(&positions, &vec![[0, 1, 2]; 1_000_001]), MeshDistanceError::TooManyTriangles { .. }));
    // One point is a point.
    let point = filled(&(vec![Vec3::ZERO], vec![[0, 0, 0]]));
    assert!(worst(&point, |p| p.length(), |p| p.length() > 2.0 * point.cell) < 0.2);
}

#[test]
fn triangles_over_one_another_end_soon() {
    // A fan of slivers through one line: every one is nearest somewhere on it, and no box tells them apart.
    let n = 20_000u32;
    let mut positions = vec![Vec3::NEG_Y * 0.1, Vec3::Y * 0.1];
    positions.extend((0..n).map(|i| {
        let angle = i as f32 * std::f32::consts::TAU / n as f32;
        Vec3::new(angle.cos(), 0.0, angle.sin()) * 0.1
    }));
    let triangles: Vec<[u32; 3]> = (0..n).map(|i| [0, 1, 2 + i]).collect();
    let found = fill_within(&positions, &triangles, DMat3::IDENTITY, MARGIN, MOST_VISITS / 50);
    assert_eq!(found, Err(MeshDistanceError::Tangled));
}

#[test]
fn a_hundred_thousand_triangles_take_a_moment() {
    let mut mesh = capsule(6, 0.02, 0.3);
    mesh.0.iter_mut().for_each(|p| *p *= 1.0 + 0.02 * (p.y * 90.0).sin());
    assert_eq!(mesh.1.len(), 81_920);
    let started = std::time::Instant::now();
    let field = fill_within(&mesh.0, &mesh.1, DMat3::IDENTITY, MARGIN, MOST_VISITS / 4);
    let nodes = field.expect("few visits").nodes.len();
    println!("{:?} for {nodes} nodes", started.elapsed());
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
}
