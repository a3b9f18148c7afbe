//! `skin_weighted` against its twin, the twin against a straight muscle's closed form, and the rest pose.

use crate::skin_linear::joint;
use crate::support::{JUNK, Random, SIZES, data, gpu, limb, limb_muscle, limb_rig, run};
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use sinew::{
    error::WeightError,
    field::{
        muscle::{self, AxisPoint, MuscleFrame, MuscleInput, MuscleRest, MuscleWeight, Profile},
        transfer::transfer,
    },
    parity::{self, Tolerance},
    reference::Reference,
    rig::{BuildOptions, JointFrame, PaintedMuscle, Pose, Rig, WeightTarget, muscle_file},
    schedule::{FrameOptions, KernelId, Skinning},
    skinning::{self, WeightedInput, WeightedParams},
};

const JOINTS: usize = 3;
const MUSCLES: usize = 6;
const INSTANCES: usize = 3;

/// Muscles of three instances, and vertices about them.
#[derive(Clone)]
struct Crowd {
    joints: Vec<JointFrame>,
    muscles: Vec<MuscleFrame>,
    axes: Vec<AxisPoint>,
    points: usize,
    targets: Vec<WeightTarget>,
    weights: Vec<MuscleWeight>,
    skinned: Vec<Vec4>,
}

fn shaped(rest: &MuscleRest, input: &MuscleInput, axes: &mut Vec<AxisPoint>, at: impl Fn(f32) -> Vec3) -> MuscleFrame {
    let first = axes.len();
    let share = |k: u32| k as f32 / rest.segments as f32;
    axes.extend((0..=rest.segments).map(|k| AxisPoint { position: at(share(k)).extend(0.0), ..AxisPoint::default() }));
    muscle::shape(rest, input, &mut axes[first..], Vec3::X, Vec3::X)
}

impl Crowd {
    fn random(vertices: usize, seed: u64) -> Crowd {
        let mut random = Random(seed);
        let mut crowd = Crowd {
            joints: (0..JOINTS * INSTANCES).map(|_| joint(&random.matrix())).collect(),
            muscles: Vec::new(),
            axes: Vec::new(),
            points: MUSCLES * 13,
            targets: Vec::new(),
            weights: Vec::new(),
            skinned: Vec::new(),
        };
        for instance in 0..INSTANCES {
            for m in 0..MUSCLES {
                let (start, along, bow) = (random.vec3() * 0.1, random.vec3().normalize() * 0.2, random.vec3() * 0.04);
                let first_point = (crowd.axes.len() - instance * crowd.points) as u32;
                let insertion = Vec3::ZERO.extend(0.02);
                let rest = MuscleRest {
                    origin: start.extend(2e-4),
                    insertion,
                    segments: 12,
                    first_point,
                    ..MuscleRest::default()
                };
                let input = MuscleInput::new(&Profile::of(3, 3), 0.1 * m as f32);
                let at = |s: f32| start + along * s + bow * (4.0 * s * (1.0 - s));
                crowd.muscles.push(shaped(&rest, &input, &mut crowd.axes, at));
            }
        }
        for vertex in 0..vertices {
            let begin = crowd.weights.len() as u32;
            let count = if vertices > 1 { vertex % 4 } else { 2 };
            for k in 0..count {
                let muscle = ((vertex + 2 * k) % MUSCLES) as u32;
                let joint = muscle % JOINTS as u32;
                let inward = random.vec3().normalize().extend(0.0);
                crowd.weights.push(MuscleWeight { inward, muscle, joint, weight: random.next().abs(), pad_0: 0 });
            }
            let end = crowd.weights.len() as u32;
            crowd.targets.push(WeightTarget { begin, end, iso: 0.1 + 0.4 * random.next().abs(), pad_0: 0 });
        }
        for instance in 0..INSTANCES {
            for vertex in 0..vertices {
                let spread = random.vec3();
                let own = crowd.targets[vertex];
                let about = crowd.weights.get(own.begin as usize).filter(|_| own.begin < own.end);
                let place = about.map_or(spread, |own| {
                    let points = instance * crowd.points + own.muscle as usize * 13;
                    let point = crowd.axes[points + vertex % 13].position.xyz() + spread * 0.03;
                    crowd.joints[instance * JOINTS + own.joint as usize].matrix.transform_point3(point)
                });
                crowd.skinned.push(place.extend(1.0));
            }
        }
        crowd
    }

    fn cpu(&self, instance: usize) -> Vec<Vec4> {
        let count = self.targets.len();
        let mut displaced = vec![Vec4::NAN; count];
        let input = WeightedInput {
            joints: &self.joints[instance * JOINTS..(instance + 1) * JOINTS],
            muscles: &self.muscles[instance * MUSCLES..(instance + 1) * MUSCLES],
            axes: &self.axes[instance * self.points..(instance + 1) * self.points],
            targets: &self.targets,
            weights: &self.weights,
            skinned: &self.skinned[instance * count..(instance + 1) * count],
        };
        skinning::weighted(&input, &mut displaced);
        displaced
    }

    fn gpu(&self) -> Option<Vec<Vec4>> {
        let gpu = gpu()?;
        let threads = self.skinned.len();
        let params = WeightedParams {
            vertex_count: self.targets.len() as u32,
            instance_count: INSTANCES as u32,
            joint_count: JOINTS as u32,
            muscle_count: MUSCLES as u32,
            point_count: self.points as u32,
            ..WeightedParams::default()
        };
        let inputs: [(&str, &[u8]); 7] = [
            ("params", bytemuck::bytes_of(&params)),
            ("joints", bytemuck::cast_slice(&self.joints)),
            ("muscles", bytemuck::cast_slice(&self.muscles)),
            ("axes", bytemuck::cast_slice(&self.axes)),
            ("targets", bytemuck::cast_slice(&self.targets)),
            ("weights", bytemuck::cast_slice(&self.weights)),
            ("skinned", bytemuck::cast_slice(&self.skinned)),
        ];
        let size = (threads + 1) * 16;
        let out = run(&gpu, KernelId::SkinWeighted, threads as u64, &inputs, &[("displaced", size)]);
        let mut positions: Vec<Vec4> = bytemuck::pod_collect_to_vec(&out[0]);
        let beyond = positions.pop().expect("one item more");
        assert_eq!(beyond.to_array().map(f32::to_bits), [JUNK; 4], "written beyond the last vertex");
        Some(positions)
    }
}

/// Metres. Both sides do the same steps. Where a driver fuses operations, one of them may find itself within the field's tolerance
/// of 1e-5 a step before the other: with these supports the field's slope is at least 7 per metre where it counts. In a thin
/// end, where the value is hardly reached, one may turn back a step earlier: a thousandth of the vertices.
const DISPLACED: Tolerance = Tolerance { absolute: 2e-6, share_over: 1e-3 };

#[test]
fn matches_its_twin_at_every_size() {
    for size in SIZES.into_iter().chain([3000]) {
        let crowd = Crowd::random(size, 31);
        let Some(gpu) = crowd.gpu() else { return };
        let mut moved = 0;
        for instance in 0..INSTANCES {
            let cpu = crowd.cpu(instance);
            let range = instance * size..(instance + 1) * size;
            moved += cpu.iter().zip(&crowd.skinned[range.clone()]).filter(|(a, b)| a.distance(**b) > 1e-3).count();
            let report = parity::vectors("displaced", &gpu[range], &cpu, 1.0, DISPLACED);
            assert!(report.pass, "size {size}: {report:?}");
        }
        assert!(size < 100 || moved > size / 2, "only {moved} move");
    }
}

#[test]
fn a_changed_weight_is_found() {
    let crowd = Crowd::random(3000, 32);
    let Some(gpu) = crowd.gpu() else { return };
    let mut changed = crowd.clone();
    changed.weights.iter_mut().for_each(|own| own.weight *= 0.99);
    let report = parity::vectors("displaced", &gpu[..3000], &changed.cpu(0), 1.0, DISPLACED);
    assert!(!report.pass && report.over > 300, "{report:?}");
    changed = crowd;
    changed.targets.iter_mut().for_each(|target| target.iso += 1e-3);
    assert!(!parity::vectors("displaced", &gpu[..3000], &changed.cpu(0), 1.0, DISPLACED).pass);
}

/// A straight muscle of 20 cm along Y, thickest in the middle.
fn straight(width: f32) -> (MuscleFrame, Vec<AxisPoint>) {
    let rest = MuscleRest {
        origin: Vec4::new(0.0, 0.0, 0.0, 2e-4),
        insertion: Vec4::new(0.0, 0.2, 0.0, 0.02),
        segments: 20,
        ..MuscleRest::default()
    };
    let input = MuscleInput { width, ..MuscleInput::new(&Profile::of(3, 3), 0.0) };
    let mut axes = Vec::new();
    let frame = shaped(&rest, &input, &mut axes, |s| Vec3::Y * (0.2 * s));
    (frame, axes)
}

/// Where a vertex that lies `above` the muscle's surface at rest goes as it gets `width` times as wide, by one weight.
fn beside(above: f32, width: f32, weight: f32) -> Vec3 {
    let (rest, axes_rest) = straight(1.0);
    let (now, axes) = straight(width);
    let start = Vec3::new(rest.radius(0.5, 1.0) + above, 0.1, 0.0);
    let weights = [MuscleWeight { inward: Vec4::NEG_X, weight, ..MuscleWeight::default() }];
    let iso = muscle::pull(&[rest], &axes_rest, &weights, |_| (Mat4::IDENTITY, 1.0), start).sample.value;
    // All of it turned and moved by a joint, which changes nothing.
    let pose = Mat4::from_translation(Vec3::new(0.3, -0.1, 0.2)) * Mat4::from_rotation_z(0.7);
    let mut displaced = [Vec4::NAN];
    let input = WeightedInput {
        joints: &[joint(&pose)],
        muscles: &[now],
        axes: &axes,
        targets: &[WeightTarget { begin: 0, end: 1, iso, pad_0: 0 }],
        weights: &weights,
        skinned: &[pose.transform_point3(start).extend(1.0)],
    };
    skinning::weighted(&input, &mut displaced);
    pose.inverse().transform_point3(displaced[0].xyz())
}

#[test]
fn a_vertex_keeps_its_value_beside_a_straight_muscle() {
    for (above, width) in [(0.004, 1.25), (0.002, 1.05), (0.008, 1.4), (0.003, 0.97), (0.0, 1.2), (-0.002, 1.1)] {
        let ([rest, _], [now, _]) = ([straight(1.0).0; 2], [straight(width).0; 2]);
        let (before, after) = (rest.radius(0.5, 1.0), now.radius(0.5, 1.0));
        let start = Vec3::new(before + above, 0.1, 0.0);
        let supports = [rest, now].map(|m| muscle::widened(&m).support_radius);
        let whole = beside(above, width, 1.0);
        if above >= 0.0 {
            // Equal values outside are equal shares of the support.
            let expected = after + above * supports[1] / supports[0];
            assert!((whole - Vec3::new(expected, 0.1, 0.0)).length() < 1e-5, "{above} {width}: {whole} {expected}");
            let value = |x: f32| transfer(x - after, supports[1]).0;
            let iso = transfer(above, supports[0]).0;
            assert!((value(whole.x) - iso).abs() < 1e-4, "{above} {width}");
            assert!((value(whole.x + 1e-4) - iso).abs() > 1e-4, "a tenth of a millimetre must be seen");
        }
        let (none, half) = (beside(above, width, 0.0), beside(above, width, 0.5));
        assert!((none - start).length() < 1e-6, "without weight: {none}");
        assert!((half - (start + whole) * 0.5).length() < 1e-5, "half of it: {half}, {whole}");
        assert!((whole - start).length() > 3e-4, "it moves");
    }
}

#[test]
fn skin_past_a_muscles_axis_leaves_it_where_it_belongs_and_what_is_left_behind_stays() {
    let radius = straight(1.0).0.radius(0.5, 1.0);
    // Geometric skinning has taken the vertex from the surface to the axis, and past it.
    for depth in [0.9, 1.0, 1.1] {
        let (rest, axes) = straight(1.0);
        let weights = [MuscleWeight { inward: Vec4::NEG_X, weight: 1.0, ..MuscleWeight::default() }];
        let mut displaced = [Vec4::NAN];
        let at = |x: f32, displaced: &mut [Vec4]| {
            let input = WeightedInput {
                joints: &[joint(&Mat4::IDENTITY)],
                muscles: &[rest],
                axes: &axes,
                targets: &[WeightTarget { begin: 0, end: 1, iso: 0.45, pad_0: 0 }],
                weights: &weights,
                skinned: &[Vec4::new(x, 0.1, 0.0, 1.0)],
            };
            skinning::weighted(&input, displaced);
            displaced[0].x
        };
        let found = at(radius * (1.0 - depth), &mut displaced);
        assert!(found > radius && found < 1.5 * radius, "{depth}: {found}");
        let far = 3.0 * radius;
        assert_eq!(at(far, &mut displaced), far, "what the muscle has left");
    }
}

fn weighted() -> FrameOptions {
    FrameOptions { skinning: Skinning::Weighted, ..FrameOptions::default() }
}

#[test]
fn rest_leaves_skin_over_muscles_where_it_is() {
    let mut rigs = vec![limb_rig(40)];
    if let Some(folder) = data() {
        for name in ["mh_male_athletic", "arm_nohand_dense_2172", "arm_male_athletic_2172"] {
            let scene = sinew::io::gltf::read(&folder.join(format!("humans/{name}.glb"))).expect("a human");
            let path = format!("{}/kernels-tests/fixtures/{name}.muscles.toml", env!("CARGO_MANIFEST_DIR"));
            let file = muscle_file::read(path.as_ref()).expect("its muscles");
            rigs.push(Rig::build(scene.character, &file.muscles, &BuildOptions::default()).expect("a rig"));
        }
    }
    for rig in &rigs {
        rig.check_weights().expect("weights");
        let trace = Reference::new(rig).frame(&Pose::rest(&rig.character), &weighted()).expect("a frame");
        let moved = trace.positions().iter().zip(&rig.positions_rest).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        let (bound, name) = (1e-5 * rig.character.height_rest(), &rig.character.name);
        println!(
            "{name}: {} of {} vertices follow muscles, {moved:.1e} m at rest",
            rig.weights.followers(),
            trace.tracked.len()
        );
        assert!(moved < bound, "{name}: {moved} m");
        let tense = Pose { activations: vec![1.0; rig.specs.len()], ..Pose::rest(&rig.character) };
        let other = Reference::new(rig).frame(&tense, &weighted()).expect("a frame");
        // The limb's muscle has the same shape at any activation.
        assert!(name == "limb" || other.tracked != trace.tracked, "{name}: activation must be seen");
        assert!(rig.weights.weights.iter().all(|own| own.weight > 0.0 && own.weight <= 1.0));
    }
}

#[test]
fn paint_stands_for_the_weights_that_would_be_found() {
    let found = limb_rig(40);
    let painted = |muscle, weight: f32| {
        let mut character = limb(40);
        let vertices = 0..character.positions_rest.len() as u32;
        character.painted = vec![PaintedMuscle { muscle, weights: vec![weight; vertices.len()], vertices }];
        Rig::build(character, &[limb_muscle()], &BuildOptions::default())
    };
    let half = painted(0, 0.5).expect("a rig");
    assert!(half.weights.weights.iter().all(|own| own.weight == 0.5) && half.weights.followers() > 100);
    assert!(found.weights.weights.iter().any(|own| own.weight > 0.9) && half.weights != found.weights);
    assert_eq!(
        painted(0, 0.0).expect("a rig").check_weights(),
        Err(WeightError::NoVertex { character: "limb".into() })
    );
    let error = painted(3, 0.5).expect("a rig").check_weights().expect_err("a muscle too many").to_string();
    assert!(error.contains("`_MUSCLE_3`") && error.contains("has 1,") && error.contains("remove"), "{error}");
    let error = painted(0, 1.5).expect_err("beyond 1").to_string();
    assert!(error.contains("muscle 0") && error.contains("vertex 0") && error.contains("0..=1"), "{error}");
    let bare = Rig::build(limb(12), &[], &BuildOptions::default()).expect("a rig");
    let error = bare.check_weights().expect_err("no muscles").to_string();
    assert!(error.contains("give a muscle file"), "{error}");
    let trace = Reference::new(&bare).frame(&Pose::rest(&bare.character), &weighted()).expect("a frame");
    assert!(trace.tracked.is_empty(), "without muscles it is linear skinning");
}
