//! The muscle files for other people's characters, and the bones found for them: `SINEW_DATA`.

use crate::support::{data, gpu};
use glam::{Mat4, Vec3, Vec4Swizzles};
use sinew::clip::{ClipChoice, Scene};
use sinew::field::evaluate::FieldInput;
use sinew::gpu::{Instance, Output, RigBuffers};
use sinew::parity::{self, CpuResult};
use sinew::reference::Reference;
use sinew::rig::{BuildOptions, ColliderShape, FrameInputs, Pose, Rig, muscle_file};
use sinew::schedule::{FrameOptions, TrackOptions};
use std::path::Path;
use std::sync::{Arc, OnceLock};

const HUMAN: &str = "mh_male_athletic";
const ARMS: [&str; 2] = ["arm_nohand_dense_2172", "arm_male_athletic_2172"];

/// A character with its muscles; all mistakes of the file would end here.
fn load(folder: &Path, name: &str) -> (Scene, Arc<Rig>) {
    let scene = sinew::io::gltf::read(&folder.join("humans").join(format!("{name}.glb"))).expect("the character");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("kernels-tests/fixtures/{name}.muscles.toml"));
    let file = muscle_file::read(&path).expect("a muscle file");
    file.check(&scene.character).expect("names that the character has");
    assert!(file.notes.is_empty() && file.character.as_deref() == Some(name), "{:?}", file.notes);
    let rig = Rig::build(scene.character.clone(), &file.muscles, &BuildOptions::default()).expect("a rig");
    (scene, Arc::new(rig))
}

/// The human, which takes a second to build, once for all tests.
fn human() -> Option<&'static (Scene, Arc<Rig>)> {
    static HUMAN_RIG: OnceLock<Option<(Scene, Arc<Rig>)>> = OnceLock::new();
    HUMAN_RIG.get_or_init(|| data().map(|folder| load(&folder, HUMAN))).as_ref()
}

/// The field of the body at rest, muscles left out.
fn body(rig: &Rig, points: impl Iterator<Item = Vec3>) -> Vec<f32> {
    let mut inputs = FrameInputs::new(rig, &Pose::rest(&rig.character)).expect("the rest pose");
    inputs.groups.iter_mut().for_each(|group| (group.grid.muscle_begin, group.grid.muscle_end) = (0, 0));
    let field = FieldInput { groups: &inputs.groups, nodes: &rig.nodes, muscles: &[], axes: &[] };
    points.map(|p| field.composed(p).sample.value).collect()
}

/// Least field along an axis: the surface's own less what a straight axis may cut off a hollow, as the shin's muscle does
/// above the ankle by a millimetre.
const LEAST: f32 = 0.45;

/// Muscles whose axis leaves the body elsewhere than in the quarters next to its ends, where it stands for the tendon;
/// everything moved by `offset`.
fn strays(rig: &Rig, offset: Vec3) -> Vec<String> {
    let (shaped, axes) = rig.muscles_at_rest();
    let stray = |i: usize| {
        let points = shaped[i].points(&axes);
        let margin = points.len() / 4;
        let field = body(rig, points.iter().map(|p| p.position.xyz() + offset));
        let out = field[margin..points.len() - margin].iter().any(|&value| value < LEAST);
        out.then(|| format!("{} {field:.2?}", rig.muscle_names[i]))
    };
    (0..shaped.len()).filter_map(stray).collect()
}

/// Activation of every muscle of the file.
fn activations(rig: &Rig, pose: &Pose) -> Vec<f32> {
    let parameters = rig.drives.parameters(pose, &rig.axis_ratios(pose)).expect("a pose of the character");
    parameters.iter().map(|p| p.activation).collect()
}

fn activation(rig: &Rig, pose: &Pose, muscle: &str) -> f32 {
    activations(rig, pose)[rig.specs.iter().position(|s| s.name == muscle).expect("the muscle")]
}

fn joint(rig: &Rig, name: &str) -> usize {
    rig.character.joints.iter().position(|j| j.name == name).unwrap_or_else(|| panic!("no {name}"))
}

/// The rest pose with one joint, and all below it, turned about an axis of its own space.
fn turned(rig: &Rig, name: &str, axis: Vec3, angle: f32) -> Pose {
    let (turning, joints) = (joint(rig, name), &rig.character.joints);
    let turn = Mat4::from_axis_angle(axis.normalize(), angle);
    let motion = joints[turning].bind() * turn * joints[turning].inverse_bind;
    let below =
        |j: usize| std::iter::successors(Some(j as u32), |&j| joints[j as usize].parent).any(|a| a == turning as u32);
    let palette = (0..joints.len()).map(|j| if below(j) { motion } else { Mat4::IDENTITY });
    Pose { palette: palette.collect(), ..Pose::default() }
}

fn place(rig: &Rig, pose: &Pose, name: &str) -> Vec3 {
    let j = joint(rig, name);
    pose.palette[j].transform_point3(rig.character.joints[j].bind().w_axis.xyz())
}

/// The frame at 30 a second of `biceps_curl` in which the left biceps is shortest.
fn flexed(scene: &Scene, rig: &Rig) -> Pose {
    let clip = scene.choose_clip(Some("biceps_curl")).expect("the clip");
    let biceps = rig.specs.iter().position(|s| s.name == "biceps_l").expect("the biceps");
    let poses = (0..scene.frame_count(clip, 30.0)).map(|frame| scene.pose(clip, frame as f32 / 30.0));
    poses.min_by(|a, b| rig.axis_ratios(a)[biceps].total_cmp(&rig.axis_ratios(b)[biceps])).expect("a frame")
}

fn check_muscles(name: &str, scene: &Scene, rig: &Rig) {
    assert_eq!(strays(rig, Vec3::ZERO), Vec::<String>::new(), "{name}: outside the body");
    let moved = strays(rig, Vec3::Z * 0.1).len();
    assert!(moved * 3 > rig.muscles.len(), "{name}: 10 cm further to the front only {moved} are outside");

    let rest = scene.pose(ClipChoice::Rest, 0.0);
    assert!(activations(rig, &rest).iter().all(|&a| a == 0.0), "{name}: {:?}", activations(rig, &rest));
    let full = flexed(scene, rig);
    let reached = activation(rig, &full, "biceps_l");
    assert!(reached >= 0.9, "{name}: biceps {reached} at full flexion");
    assert!(activation(rig, &full, "triceps_lateral_l") == 0.0, "{name}: the triceps helps to flex");
}

#[test]
fn muscles_of_the_human_lie_in_his_body_and_rest_where_he_does() {
    let Some((scene, rig)) = human() else { return };
    check_muscles(HUMAN, scene, rig);
    assert!(rig.specs.len() >= 24, "a dozen a side, not {}", rig.specs.len());
}

#[test]
fn muscles_of_the_arms_lie_in_them_and_rest_where_they_do() {
    let Some(folder) = data() else { return };
    for name in ARMS {
        let (scene, rig) = load(&folder, name);
        check_muscles(name, &scene, &rig);
        assert!(!rig.bones.is_empty(), "{name} has no bones");
    }
}

#[test]
fn angle_drivers_turn_the_way_of_their_muscles() {
    let Some((_, rig)) = human() else { return };
    let rest = Pose::rest(&rig.character);
    for side in ["l", "r"] {
        let name = |base: &str| format!("{base}_{side}");
        let of = |pose: &Pose, base: &str| activation(rig, pose, &name(base));
        for sign in [-0.6, 0.6] {
            // The elbow: what stretches the biceps is what the triceps does.
            let pose = turned(rig, &name("lowerarm"), Vec3::X, sign);
            let biceps = rig.specs.iter().position(|s| s.name == name("biceps")).expect("the biceps");
            let straightened = rig.axis_ratios(&pose)[biceps] > 1.0;
            assert_eq!(of(&pose, "triceps_lateral") > 0.9, straightened, "elbow_{side} {sign}");
            // The ankle: the calf points the foot, the shin's muscle lifts it.
            let pose = turned(rig, &name("foot"), Vec3::X, sign);
            let pointed = place(rig, &pose, &name("ball")).y < place(rig, &rest, &name("ball")).y;
            assert_eq!(of(&pose, "gastrocnemius_medial") > 0.9, pointed, "ankle_{side} {sign}");
            assert_eq!(of(&pose, "tibialis_anterior") > 0.9, !pointed, "ankle_{side} {sign}");
            // The wrist: the fingers go to the side of the muscles that bend it, seen from their tendons.
            let flip = if side == "l" { 1.0 } else { -1.0 };
            let pose = turned(rig, &name("hand"), Vec3::new(0.74, -0.18 * flip, -0.64 * flip), 1.7 * sign);
            let end = |base: &str| {
                let i = rig.muscle_names.iter().position(|n| *n == name(base)).expect("a muscle");
                rig.muscles[i].insertion.xyz()
            };
            let lean = |pose: &Pose| {
                let tip = place(rig, pose, &name("middle_03"));
                tip.distance(end("flexors")) - tip.distance(end("extensors"))
            };
            let palmward = lean(&pose) < lean(&rest);
            assert_eq!(of(&pose, "flexors") > 0.9, palmward, "wrist_{side} {sign}");
            assert_eq!(of(&pose, "extensors") > 0.9, !palmward, "wrist_{side} {sign}");
        }
    }
}

/// Whether all of a bone's surface, its radius times `factor`, is in the body.
fn is_inside(rig: &Rig, bone: usize, factor: f32) -> bool {
    let bone = &rig.bones[bone];
    let ColliderShape::Capsule { from, to, radius } = bone.shape else { panic!("a capsule was to be found") };
    let bind = rig.character.joints[bone.joint as usize].bind();
    let along = (to - from).normalize_or(Vec3::Y);
    let (across, third) = along.any_orthonormal_pair();
    let ring = |k: usize| {
        let angle = k as f32 * std::f32::consts::TAU / 12.0;
        (across * angle.cos() + third * angle.sin()) * radius * factor
    };
    let surface = (0..=10).flat_map(|i| (0..12).map(move |k| (i, k)));
    let tips = [from - along * radius * factor, to + along * radius * factor];
    let points = surface.map(|(i, k)| from.lerp(to, i as f32 / 10.0) + ring(k)).chain(tips);
    body(rig, points.map(|p| bind.transform_point3(p))).iter().all(|&value| value > 0.5)
}

#[test]
fn bones_are_as_thick_as_bones_and_stay_under_the_skin() {
    let Some((_, rig)) = human() else { return };
    let find = |name: &str| rig.bones.iter().position(|b| b.joint as usize == joint(rig, name)).expect("a bone");
    let size = |name: &str| match rig.bones[find(name)].shape {
        ColliderShape::Capsule { from, to, radius } => (from.distance(to) * 100.0, radius * 100.0),
        ColliderShape::Mesh { .. } => panic!("{name} is a mesh"),
    };
    for (name, lengths, radii) in [
        ("upperarm", 20.0..27.0, 0.8..1.8),
        ("lowerarm", 20.0..28.0, 0.6..1.5),
        ("thigh", 34.0..44.0, 1.2..2.8),
        ("calf", 34.0..46.0, 0.5..2.2),
        ("clavicle", 8.0..19.0, 0.4..1.5),
    ] {
        let sides = ["l", "r"].map(|side| size(&format!("{name}_{side}")));
        for (length, radius) in sides {
            assert!(lengths.contains(&length) && radii.contains(&radius), "{name}: {length} cm, radius {radius} cm");
        }
        assert!((sides[0].1 / sides[1].1 - 1.0).abs() < 0.1, "{name}: {sides:?}");
    }
    let outside = |factor| (0..rig.bones.len()).filter(|&b| !is_inside(rig, b, factor)).count();
    assert_eq!(outside(1.0), 0, "bones outside the body");
    assert!(outside(5.0) > rig.bones.len() / 2, "bones five times as thick must be seen");
}

#[test]
fn the_human_with_his_muscles_is_the_same_on_either_side() {
    let Some((scene, rig)) = human() else { return };
    let Some(gpu) = gpu() else { return };
    // In one sub-pose: over the ten that a leap from rest takes, folds magnify rounding errors.
    let track = TrackOptions { direct_degrees: 180.0, ..TrackOptions::default() };
    let (pose, options) = (flexed(scene, rig), FrameOptions { track, ..FrameOptions::default() });
    let buffers = Arc::new(RigBuffers::upload(&gpu.device, Arc::clone(rig)).expect("buffers"));
    let mut instance = Instance::new(&gpu.kernels, &gpu.device, &gpu.queue, &buffers, Output::Owned).expect("instance");
    instance.set_options(&gpu.queue, &options);
    instance.set_pose(&gpu.queue, &pose).expect("pose");
    gpu.submit(|encoder| instance.encode(encoder));
    let found = parity::capture(&gpu, instance.batch(), 0).expect("readback");
    let compare = |pose: &Pose| {
        let trace = Reference::new(rig).frame(pose, &options).expect("a frame");
        parity::compare(&found, CpuResult(&trace), scene.character.height_rest())
    };
    let stages = compare(&pose);
    assert!(stages.len() == 6 && stages.iter().all(|s| s.pass), "{stages:#?}");
    let mut tense = pose.clone();
    tense.activations = vec![0.5; rig.specs.len()];
    let other = compare(&tense);
    assert!(other.iter().any(|s| s.stage == "muscles" && !s.pass), "other activations must be seen");
}
