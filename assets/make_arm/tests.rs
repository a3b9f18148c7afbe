//! Checks of the files in the repository, of what the sources make today, and of the checks themselves.

use crate::{MODELS, mesh, muscles, skeleton::Skeleton};
use glam::DVec3;
use std::{collections::HashMap, path::Path};

/// A model read back from the repository.
struct Model {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    uvs: Vec<[f32; 2]>,
    weights: Vec<[f32; 4]>,
    triangles: Vec<[u32; 3]>,
    joints: Vec<String>,
    clips: Vec<(String, f32)>,
}

fn asset(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn model(name: &str) -> Model {
    let file = asset(name);
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&file).expect("a valid GLB");
    let blob = blob.expect("a binary chunk");
    let bytes = |accessor: gltf::Accessor| -> Vec<u8> {
        let view = accessor.view().expect("a view");
        let start = view.offset() + accessor.offset();
        blob[start..start + accessor.count() * accessor.size()].to_vec()
    };
    let floats = |accessor: gltf::Accessor| -> Vec<f32> {
        bytes(accessor).chunks_exact(4).map(|c| f32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect()
    };
    let primitive = document.meshes().next().expect("a mesh").primitives().next().expect("a primitive");
    let attribute = |semantic| floats(primitive.get(&semantic).expect("the attribute"));
    let points =
        |values: Vec<f32>| values.chunks_exact(3).map(|c| DVec3::new(c[0].into(), c[1].into(), c[2].into())).collect();
    let indices = bytes(primitive.indices().expect("indices"));
    let indices: Vec<u32> = indices.chunks_exact(2).map(|c| u16::from_le_bytes([c[0], c[1]]).into()).collect();
    let skin = document.skins().next().expect("a skin");
    Model {
        positions: points(attribute(gltf::Semantic::Positions)),
        normals: points(attribute(gltf::Semantic::Normals)),
        uvs: attribute(gltf::Semantic::TexCoords(0)).chunks_exact(2).map(|c| [c[0], c[1]]).collect(),
        weights: attribute(gltf::Semantic::Weights(0)).chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect(),
        triangles: indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        joints: skin.joints().map(|j| j.name().unwrap_or_default().to_owned()).collect(),
        clips: document
            .animations()
            .map(|a| {
                let ends = a.samplers().map(|s| *floats(s.input()).last().expect("keys"));
                (a.name().unwrap_or_default().to_owned(), ends.fold(0.0, f32::max))
            })
            .collect(),
    }
}

/// What is wrong with a mesh that ought to be one closed, outward, non-degenerate surface.
fn faults(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<String> {
    let mut faults = Vec::new();
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    for t in triangles {
        for i in 0..3 {
            *edges.entry((t[i], t[(i + 1) % 3])).or_default() += 1;
        }
    }
    let unpaired = edges.iter().filter(|&(&(a, b), &n)| n != 1 || edges.get(&(b, a)) != Some(&1)).count();
    if unpaired > 0 {
        faults.push(format!("{unpaired} edges without exactly one opposite"));
    }
    let used: std::collections::BTreeSet<u32> = triangles.iter().flatten().copied().collect();
    let euler = used.len() as i64 - edges.len() as i64 / 2 + triangles.len() as i64;
    if euler != 2 || used.len() != positions.len() {
        faults.push(format!("Euler characteristic {euler}, {} of {} vertices used", used.len(), positions.len()));
    }
    let thin = triangles.iter().filter(|t| {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        // Twice the area over the square of the longest side: 0.87 for equal sides, 0 for a sliver.
        (b - a).cross(c - a).length() < 0.01 * longest || longest < 1e-8
    });
    let thin = thin.count();
    if thin > 0 {
        faults.push(format!("{thin} degenerate triangles"));
    }
    let litres = volume(positions, triangles) * 1e3;
    if !(2.5..3.8).contains(&litres) {
        faults.push(format!("{litres} litres"));
    }
    faults
}

fn volume(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let six = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        a.dot(b.cross(c))
    };
    triangles.iter().map(six).sum::<f64>() / 6.0
}

/// Distance from a point to a triangle's nearest point.
fn to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let beside = |a: DVec3, b: DVec3| (b - a).cross(p - a).dot(normal) < 0.0;
    if !beside(a, b) && !beside(b, c) && !beside(c, a) {
        return (p - a).dot(normal).abs() / normal.length();
    }
    let edge =
        |a: DVec3, b: DVec3| p.distance(a + (b - a) * ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0));
    edge(a, b).min(edge(b, c)).min(edge(c, a))
}

/// Distance to the skin, negative outside; the sign from the solid angle that the skin fills.
fn depth(p: DVec3, corners: &[[DVec3; 3]]) -> f64 {
    let mut angle = 0.0;
    let mut nearest = f64::INFINITY;
    for &triangle in corners {
        let [a, b, c] = triangle.map(|q| q - p);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        angle += a.dot(b.cross(c)).atan2(below);
        nearest = nearest.min(to_triangle(p, triangle));
    }
    // A full turn is 4 pi, and each term is half a solid angle.
    if angle > std::f64::consts::PI { nearest } else { -nearest }
}

/// Least depth of the surface of every muscle's flesh under the skin.
fn flesh_depths(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<(&'static str, f64)> {
    let corners: Vec<[DVec3; 3]> = triangles.iter().map(|t| t.map(|i| positions[i as usize])).collect();
    let skeleton = Skeleton::bind();
    let least = |muscle: &muscles::Muscle| {
        let sweep = muscle.sweep(&skeleton);
        let samples = (0..=16).flat_map(|i| (0..16).map(move |k| (f64::from(i) / 16.0, f64::from(k) / 16.0)));
        samples.map(|(s, turn)| depth(sweep.surface(s, turn), &corners)).fold(f64::INFINITY, f64::min)
    };
    muscles::all().iter().map(|m| (m.name, least(m))).collect()
}

#[test]
fn models_are_closed_and_of_an_arms_size() {
    let counts = MODELS.map(|(name, _, _)| {
        let model = model(name);
        assert_eq!(faults(&model.positions, &model.triangles), Vec::<String>::new(), "{name}");
        let low = model.positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        assert!(
            (-0.80..-0.60).contains(&low),
            "{name}: an arm hangs down from the shoulder at the origin, not to {low}"
        );
        model.positions.len()
    });
    assert_eq!(counts[0], 2172);
    assert!((18_000..=22_000).contains(&counts[1]));
}

#[test]
fn a_broken_mesh_is_noticed() {
    let whole = model("arm.glb");
    let broken = |change: fn(&mut Model)| {
        let mut model = model("arm.glb");
        change(&mut model);
        faults(&model.positions, &model.triangles).join("; ")
    };
    assert_eq!(faults(&whole.positions, &whole.triangles).len(), 0);
    let hole = broken(|m| m.triangles.truncate(4339));
    assert!(hole.contains("edges without") && hole.contains("Euler"), "{hole}");
    assert!(broken(|m| m.triangles[7].swap(0, 1)).contains("edges without"));
    assert!(broken(|m| m.triangles.iter_mut().for_each(|t| t.swap(0, 1))).contains("litres"));
    assert!(broken(|m| m.positions[100] = m.positions[101]).contains("degenerate"));
    assert!(broken(|m| m.positions.push(DVec3::ZERO)).contains("vertices used"));
}

#[test]
fn attributes_are_sound() {
    for (name, _, _) in MODELS {
        let model = model(name);
        let count = model.positions.len();
        assert_eq!((model.normals.len(), model.uvs.len(), model.weights.len()), (count, count, count));
        // Rounding to f32 moves a unit normal's length by less than 2e-7.
        assert!(model.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6));
        assert!(model.uvs.iter().flatten().all(|&c| (0.0..=1.0).contains(&c)));
        for weights in &model.weights {
            assert!(weights.iter().all(|&w| (0.0..=1.0).contains(&w)));
            assert_eq!(weights.iter().sum::<f32>(), 1.0, "shares are multiples of 1/4096, so their sum is exact");
        }
        for joint in 0..3 {
            assert!(model.weights.iter().any(|w| w[joint] == 1.0), "{name}: joint {joint} owns no vertex");
        }
        assert_eq!(model.joints, ["upperarm", "lowerarm", "hand"]);
        assert_eq!(model.clips, [("curl".to_owned(), 2.0), ("shake".to_owned(), 2.0)]);
    }
}

#[test]
fn weights_change_gently_along_the_arm() {
    let model = model("arm_20k.glb");
    for t in &model.triangles {
        for i in 0..3 {
            let (a, b) = (t[i] as usize, t[(i + 1) % 3] as usize);
            let length = model.positions[a].distance(model.positions[b]);
            for joint in 0..3 {
                let change = f64::from((model.weights[a][joint] - model.weights[b][joint]).abs());
                // The blend over 0.05 m is steepest in its middle, 15/8 of its mean slope; 1/4096 is the rounding.
                assert!(change <= length * 1.875 / 0.05 + 1.0 / 2048.0, "{change} over {length} m");
            }
        }
    }
}

#[test]
fn flesh_lies_just_under_the_skin() {
    let model = model("arm.glb");
    let depths = flesh_depths(&model.positions, &model.triangles);
    assert!(depths.iter().all(|(_, depth)| (0.001..0.004).contains(depth)), "metres under the skin: {depths:?}");
    // Under a skin that is 3 mm thinner everywhere they poke out.
    let thin: Vec<DVec3> = model.positions.iter().zip(&model.normals).map(|(p, n)| *p - *n * 0.003).collect();
    assert!(flesh_depths(&thin, &model.triangles).iter().all(|&(_, depth)| depth < 0.001));
}

#[test]
fn sources_still_make_the_files() {
    let (name, m, rings) = MODELS[0];
    let made = mesh::build(&Skeleton::bind(), m, rings);
    let stored = model(name);
    assert_eq!(made.triangles, stored.triangles);
    let drift = made
        .positions
        .iter()
        .zip(&stored.positions)
        .map(|(a, b)| DVec3::new(a[0].into(), a[1].into(), a[2].into()).distance(*b));
    // Other machines' sine and cosine may differ in the last bit; nothing else may.
    assert!(drift.fold(0.0, f64::max) < 1e-6);
    assert_eq!(muscles::muscle_file(&Skeleton::bind()).as_bytes(), asset("arm.muscles.toml"));
}
