//! `skin_hybrid` against its twin, the twin against a straight limb's closed form, and the weights of skin over muscles.

use crate::skin_linear::Skin;
use crate::support::{JUNK, Random, SIZES, data, gpu, limb, limb_rig, run};
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use sinew::{
    parity,
    reference::Reference,
    rig::{Attachment, BuildOptions, MuscleSize, MuscleSpec, PaintedMuscle, Pose, Rig, muscle_file},
    schedule::{FrameOptions, KernelId, Skinning},
    skinning::{self, HybridInput, WeightedParams},
};

const INSTANCES: usize = 3;
/// Joints of [`Skin`] that are bones here; the others are muscles'.
const BONES: usize = 4;
const MUSCLE_JOINTS: usize = 3;

struct Hybrid {
    skin: Skin,
    muscle_joints: Vec<Mat4>,
}

impl Hybrid {
    fn random(vertices: usize, seed: u64) -> Hybrid {
        let mut random = Random(seed);
        let mut skin = Skin::random(vertices, INSTANCES, seed + 1);
        skin.joints.truncate(BONES * INSTANCES);
        Hybrid { skin, muscle_joints: (0..MUSCLE_JOINTS * INSTANCES).map(|_| random.matrix()).collect() }
    }

    fn cpu(&self) -> Vec<Vec4> {
        let count = self.skin.rest.len();
        let mut out = vec![Vec4::NAN; count * INSTANCES];
        for instance in 0..INSTANCES {
            let input = HybridInput {
                joints: &self.skin.joints[instance * BONES..][..BONES],
                muscle_joints: &self.muscle_joints[instance * MUSCLE_JOINTS..][..MUSCLE_JOINTS],
                positions_rest: &self.skin.rest,
                offsets: &self.skin.offsets,
                influences: &self.skin.influences,
            };
            skinning::hybrid(&input, &mut out[instance * count..][..count]);
        }
        out
    }

    fn gpu(&self) -> Option<Vec<Vec4>> {
        let gpu = gpu()?;
        let threads = self.skin.rest.len() * INSTANCES;
        let params = WeightedParams {
            vertex_count: self.skin.rest.len() as u32,
            instance_count: INSTANCES as u32,
            joint_count: BONES as u32,
            point_count: MUSCLE_JOINTS as u32,
            ..WeightedParams::default()
        };
        let inputs: [(&str, &[u8]); 6] = [
            ("params", bytemuck::bytes_of(&params)),
            ("joints", bytemuck::cast_slice(&self.skin.joints)),
            ("muscle_joints", bytemuck::cast_slice(&self.muscle_joints)),
            ("positions_rest", bytemuck::cast_slice(&self.skin.rest)),
            ("offsets", bytemuck::cast_slice(&self.skin.offsets)),
            ("influences", bytemuck::cast_slice(&self.skin.influences)),
        ];
        let out = run(&gpu, KernelId::SkinHybrid, threads as u64, &inputs, &[("skinned", (threads + 1) * 16)]);
        let mut positions: Vec<Vec4> = bytemuck::pod_collect_to_vec(&out[0]);
        let beyond = positions.pop().expect("one item more");
        assert_eq!(beyond.to_array().map(f32::to_bits), [JUNK; 4], "written beyond the last vertex");
        Some(positions)
    }
}

#[test]
fn matches_its_twin_at_every_size() {
    for size in SIZES {
        let hybrid = Hybrid::random(size, 91);
        let Some(found) = hybrid.gpu() else { return };
        let report = parity::vectors("skinned", &found, &hybrid.cpu(), 1.0, parity::SKINNED);
        assert!(report.pass, "size {size}: {report:?}");
    }
}

#[test]
fn another_weight_of_a_muscle_is_found() {
    let hybrid = Hybrid::random(65, 92);
    let Some(found) = hybrid.gpu() else { return };
    let mut other = Hybrid::random(65, 92);
    let of_muscle = other.skin.influences.iter().position(|i| i.joint as usize >= BONES).expect("one");
    other.skin.influences[of_muscle].weight += 1e-3;
    let report = parity::vectors("skinned", &found, &other.cpu(), 1.0, parity::SKINNED);
    assert!(!report.pass && report.over == INSTANCES, "{report:?}");
}

fn options() -> FrameOptions {
    FrameOptions { skinning: Skinning::Hybrid, ..FrameOptions::default() }
}

/// The limb with a muscle in its axis that all of the skin in its reach is painted to follow.
fn painted_limb() -> Rig {
    let end = |bone: &str, y| Attachment { bone: bone.into(), offset: Vec3::new(0.0, y, 0.0), normal: Vec3::X };
    let spec = MuscleSpec::new("m", "upperarm", end("upperarm", 0.05), end("lowerarm", 0.2), MuscleSize::Width(0.03));
    let mut character = limb(60);
    let vertices = 0..character.positions_rest.len() as u32;
    character.painted = vec![PaintedMuscle { muscle: 0, weights: vec![1.0; vertices.len()], vertices }];
    Rig::build(character, &[spec], &BuildOptions::default()).expect("a limb")
}

#[test]
fn skin_over_a_shortened_muscle_swells_about_its_axis() {
    let rig = painted_limb();
    let share = 0.75;
    let lower = Mat4::from_translation(Vec3::Y * (0.45 * (share - 1.0)));
    let pose = Pose { palette: vec![Mat4::IDENTITY, lower], ..Pose::default() };
    let trace = Reference::new(&rig).frame(&pose, &options()).expect("a frame");
    let thick: Vec<f32> = trace.muscle_joints.iter().map(|m| m.transform_vector3(Vec3::X).length()).collect();
    let mut seen = 0;
    for (v, rest) in rig.positions_rest.iter().enumerate() {
        let s = (rest.y - 0.05) / 0.45;
        // Within a segment of the ends the outermost joint stands for those that there are none of.
        if rig.weights.of(v).is_empty() || !(0.07..0.93).contains(&s) {
            continue;
        }
        // A cubic B-spline of the joints' thickness, in the knots' own form.
        let at = s * 29.0;
        let bump = |x: f32| {
            let x = x.abs();
            if x < 1.0 { (4.0 - 6.0 * x * x + 3.0 * x * x * x) / 6.0 } else { (2.0 - x).max(0.0).powi(3) / 6.0 }
        };
        let swollen: f32 = thick.iter().enumerate().map(|(i, k)| k * bump(at - i as f32)).sum();
        let wanted = Vec3::new(rest.x * swollen, rest.y, rest.z * swollen);
        let found = trace.positions()[v].xyz();
        assert!(found.distance(wanted) < 2e-5, "vertex {v} at {s}: {found} {wanted}");
        seen += usize::from(found.with_y(0.0).length() > 1.1 * Vec3::new(rest.x, 0.0, rest.z).length());
    }
    assert!(seen > 100, "{seen} vertices swell");
}

#[test]
fn skin_is_moved_by_muscles_over_them_and_by_bones_elsewhere() {
    let rig = limb_rig(40);
    let (offsets, influences) = (&rig.muscle_joints.offsets, &rig.muscle_joints.influences);
    let bones = rig.character.joints.len() as u32;
    let (mut over, mut beside) = (0, 0);
    for v in 0..rig.positions_rest.len() {
        let own = &influences[offsets[v] as usize..offsets[v + 1] as usize];
        let whole: f32 = own.iter().map(|i| i.weight).sum();
        assert!((whole - 1.0).abs() < 1e-6 && own.iter().all(|i| i.weight > 0.0), "vertex {v}: {own:?}");
        let by_muscle: f32 = own.iter().filter(|i| i.joint >= bones).map(|i| i.weight).sum();
        let weight = rig.weights.of(v).first().map_or(0.0, |w| w.weight);
        assert!(by_muscle <= weight + 1e-3, "vertex {v}: {by_muscle} {weight}");
        over += usize::from(by_muscle > 0.9);
        beside += usize::from(by_muscle == 0.0);
    }
    assert!(over > 10 && beside > 300, "{over} over the muscle, {beside} beside it");
}

#[test]
fn rest_leaves_the_skin_where_it_is() {
    let mut rigs = vec![limb_rig(40), painted_limb()];
    if let Some(folder) = data() {
        let name = "arm_nohand_dense_2172";
        let scene = sinew::io::gltf::read(&folder.join(format!("humans/{name}.glb"))).expect("the arm");
        let path = format!("{}/kernels-tests/fixtures/{name}.muscles.toml", env!("CARGO_MANIFEST_DIR"));
        let file = muscle_file::read(path.as_ref()).expect("its muscles");
        rigs.push(Rig::build(scene.character, &file.muscles, &BuildOptions::default()).expect("a rig"));
    }
    for rig in &rigs {
        let trace = Reference::new(rig).frame(&Pose::rest(&rig.character), &options()).expect("a frame");
        let moved = trace.positions().iter().zip(&rig.positions_rest).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        println!("{}: {moved:.1e} m at rest", rig.character.name);
        assert!(moved < 2e-6, "{}: {moved} m", rig.character.name);
        let lower = Pose {
            palette: (0..rig.character.joints.len()).map(|j| Mat4::from_rotation_x(0.01 * j as f32)).collect(),
            ..Pose::default()
        };
        let other = Reference::new(rig).frame(&lower, &options()).expect("a frame");
        assert!(other.positions() != trace.positions());
    }
    // Without muscles it is linear skinning.
    let bare = Rig::build(limb(12), &[], &BuildOptions::default()).expect("a rig");
    let trace = Reference::new(&bare).frame(&Pose::rest(&bare.character), &options()).expect("a frame");
    assert!(trace.muscle_joints.is_empty() && trace.skinned.len() == bare.positions_rest.len());
}
