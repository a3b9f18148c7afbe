//! A limb of any number of vertices: three joints, four influences a vertex, one muscle.

use glam::{Mat4, Vec2, Vec3};
use sinew::rig::{
    Attachment, BuildOptions, Character, Influence, Joint, Material, MuscleShape, MuscleSize, MuscleSpec, Part, Pose,
    Rig,
};

const LENGTH: f32 = 0.6;
const RADIUS: f32 = 0.04;

/// A rig of exactly `vertices` vertices, 12 or more a ring; the last ring may be open.
pub fn rig(vertices: usize) -> Rig {
    let around = ((vertices as f32).sqrt() * 0.65) as usize;
    let rings = vertices.div_ceil(around);
    let place = |v: usize| {
        let (y, angle) =
            ((v / around) as f32 / (rings - 1) as f32, (v % around) as f32 / around as f32 * std::f32::consts::TAU);
        Vec3::new(RADIUS * angle.cos(), y * LENGTH, RADIUS * angle.sin())
    };
    let positions_rest: Vec<Vec3> = (0..vertices).map(place).collect();
    let mut triangles = Vec::new();
    for ring in 0..rings - 1 {
        for k in 0..around {
            let at = |r: usize, k: usize| (r * around + k % around) as u32;
            let quad = [at(ring, k), at(ring + 1, k), at(ring + 1, k + 1), at(ring, k + 1)];
            if quad.iter().all(|&i| (i as usize) < vertices) {
                triangles.extend([[quad[0], quad[1], quad[3]], [quad[3], quad[1], quad[2]]]);
            }
        }
    }
    let mut influences = Vec::with_capacity(4 * vertices);
    for p in &positions_rest {
        // Four influences a vertex, the last one always slight: what a mesh from an editor has.
        let near = |y: f32| (-((p.y - y) / 0.12).powi(2)).exp() + 1e-3;
        let mut four = [(0, near(0.15)), (1, near(0.45)), (2, near(0.75)), (0, 1e-3)];
        let sum: f32 = four.iter().map(|f| f.1).sum();
        four.sort_by(|a, b| b.1.total_cmp(&a.1));
        influences.extend(four.map(|(joint, weight)| Influence { joint, weight: weight / sum }));
    }
    let joint = |name: &str, parent, y: f32| Joint {
        name: name.into(),
        parent,
        node: 0,
        inverse_bind: Mat4::from_translation(Vec3::new(0.0, -y, 0.0)),
    };
    let character = Character {
        name: "tube".into(),
        joints: vec![joint("upperarm", None, 0.0), joint("lowerarm", Some(0), 0.3), joint("hand", Some(1), 0.58)],
        normals_rest: positions_rest.iter().map(|p| Vec3::new(p.x, 0.0, p.z).normalize()).collect(),
        uvs: vec![Vec2::ZERO; vertices],
        influence_offsets: (0..=vertices as u32).map(|v| 4 * v).collect(),
        influences,
        painted: Vec::new(),
        parts: vec![Part {
            name: "tube".into(),
            node: 0,
            vertices: 0..vertices as u32,
            triangles: 0..triangles.len() as u32,
            material: 0,
        }],
        triangles,
        positions_rest,
        materials: vec![Material::default()],
        images: Vec::new(),
    };
    let end = |bone: &str, offset| Attachment { bone: bone.into(), offset, normal: Vec3::X };
    let origin = end("upperarm", Vec3::new(0.0, 0.03, 0.022));
    let insertion = end("lowerarm", Vec3::new(0.0, 0.05, 0.025));
    let shape = MuscleShape { eccentricity: 0.4, ..MuscleShape::REST };
    let spec = MuscleSpec::new("flexor", "upperarm", origin, insertion, MuscleSize::Width(0.017));
    let muscle = MuscleSpec { rest: shape, active: shape, ..spec };
    Rig::build(character, &[muscle], &BuildOptions::default()).expect("a limb with a muscle")
}

/// The elbow bent forward by `degrees`, the hand with it.
pub fn bent(rig: &Rig, degrees: f32) -> Pose {
    let elbow = Mat4::from_translation(Vec3::Y * 0.3);
    let turn = elbow * Mat4::from_rotation_x(degrees.to_radians()) * elbow.inverse();
    let mut pose = Pose::rest(&rig.character);
    pose.palette[1..].fill(turn);
    pose
}
