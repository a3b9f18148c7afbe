//! `muscle_joint` against its twin, and the twin against closed forms of straight, bent and shortened muscles.

use crate::muscle_shape::{JOINTS, Muscles};
use crate::support::{JUNK, Random, SIZES, gpu, limb, limb_muscle, run};
use glam::{Mat4, Quat, Vec3, Vec4Swizzles};
use sinew::{
    field::muscle::{self, AxisPoint, MuscleFrame},
    reference::{Reference, Trace},
    rig::{Attachment, BuildOptions, FrameInputs, MuscleJoint, MuscleSize, MuscleSpec, Pose, Rig},
    schedule::{FrameOptions, KernelId, Skinning},
    skinning::{self, MuscleJointInput},
    wrap::MuscleParams,
};

const INSTANCES: usize = 2;

/// Random muscles as shaped, with joints at rest beside them.
struct Crew {
    muscles: Muscles,
    joints_rest: Vec<MuscleJoint>,
    shaped: Vec<MuscleFrame>,
    axes: Vec<AxisPoint>,
}

impl Crew {
    fn random(count: usize, seed: u64) -> Crew {
        let muscles = Muscles::random(count, INSTANCES, seed);
        let mut random = Random(seed + 1);
        let (shaped, axes) = (0..INSTANCES).map(|i| muscles.cpu(i)).fold((vec![], vec![]), |mut all, one| {
            all.0.extend(one.0);
            all.1.extend(one.1);
            all
        });
        let mut joints_rest = Vec::new();
        for (m, rest) in (0..).zip(&muscles.rest) {
            for i in 0..=rest.segments as usize {
                let point = &axes[rest.first_point as usize + i];
                let tangent = (point.tangent.xyz() + random.vec3() * 0.5).normalize();
                joints_rest.push(MuscleJoint {
                    place: (point.position.xyz() + random.vec3() * 0.1).extend(0.01),
                    tangent: tangent.extend(0.012),
                    normal: tangent.cross(random.vec3()).normalize().extend(0.0),
                    swell_long: 60.0 + 20.0 * random.next(),
                    swell_short: 60.0 + 20.0 * random.next(),
                    muscle: m,
                    pad_0: 0,
                });
            }
        }
        Crew { muscles, joints_rest, shaped, axes }
    }

    fn cpu(&self) -> Vec<Mat4> {
        let (count, points) = (self.muscles.rest.len(), self.muscles.points);
        let mut out = vec![Mat4::NAN; points * INSTANCES];
        for instance in 0..INSTANCES {
            let input = MuscleJointInput {
                joints: &self.muscles.joints[instance * JOINTS..][..JOINTS],
                muscles_rest: &self.muscles.rest,
                joints_rest: &self.joints_rest,
                muscles: &self.shaped[instance * count..][..count],
                axes: &self.axes[instance * points..][..points],
            };
            skinning::muscle_joints(&input, &mut out[instance * points..][..points]);
        }
        out
    }

    fn gpu(&self) -> Option<Vec<Mat4>> {
        let gpu = gpu()?;
        let params = MuscleParams {
            muscle_count: self.muscles.rest.len() as u32,
            instance_count: INSTANCES as u32,
            joint_count: JOINTS as u32,
            point_count: self.muscles.points as u32,
            ..MuscleParams::default()
        };
        let inputs: [(&str, &[u8]); 6] = [
            ("params", bytemuck::bytes_of(&params)),
            ("muscles_rest", bytemuck::cast_slice(&self.muscles.rest)),
            ("joints_rest", bytemuck::cast_slice(&self.joints_rest)),
            ("joints", bytemuck::cast_slice(&self.muscles.joints)),
            ("muscles", bytemuck::cast_slice(&self.shaped)),
            ("axes", bytemuck::cast_slice(&self.axes)),
        ];
        let count = self.muscles.points * INSTANCES;
        let sizes = [("muscle_joints", (count + 1) * size_of::<Mat4>())];
        let out = run(&gpu, KernelId::MuscleJoint, count as u64, &inputs, &sizes);
        let mut found: Vec<Mat4> = bytemuck::pod_collect_to_vec(&out[0]);
        assert_eq!(found.pop().map(|m| m.w_axis.w.to_bits()), Some(JUNK), "written beyond the last joint");
        Some(found)
    }
}

/// Largest difference of two matrices, of entries up to 1 as they are and as a share beyond.
fn apart(a: &Mat4, b: &Mat4) -> f32 {
    let (a, b) = (a.to_cols_array(), b.to_cols_array());
    let largest = b.iter().fold(1.0f32, |most, x| most.max(x.abs()));
    let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / largest;
    if off.is_nan() { f32::INFINITY } else { off }
}

/// A foot on an axis of 2 m, and a turn through the difference of two directions: some tens of roundings.
const TOLERANCE: f32 = 5e-6;

#[test]
fn matches_its_twin_at_every_size() {
    for size in SIZES {
        let crew = Crew::random(size, 81);
        let Some(found) = crew.gpu() else { return };
        let worst = found.iter().zip(crew.cpu()).map(|(a, b)| apart(a, &b)).fold(0.0, f32::max);
        println!("{size} muscles: {worst:.1e}");
        assert!(worst < TOLERANCE, "{size} muscles: {worst}");
    }
}

#[test]
fn another_swelling_and_another_place_are_found() {
    let crew = Crew::random(9, 82);
    let Some(found) = crew.gpu() else { return };
    let mut other = Crew::random(9, 82);
    // Many of these random joints swell as much or as little as one may.
    other.joints_rest[..33].iter_mut().for_each(|joint| joint.place.w += 1e-4);
    other.joints_rest[58..].iter_mut().for_each(|joint| joint.place.x += 5e-3);
    let cpu = other.cpu();
    let over: Vec<usize> = (0..crew.muscles.points).filter(|&i| apart(&found[i], &cpu[i]) > TOLERANCE).collect();
    let (swollen, moved) = (over.iter().filter(|&&i| i < 33).count(), over.iter().filter(|&&i| i >= 58).count());
    assert!(swollen > 2 && moved > 10 && over.len() == swollen + moved, "{over:?}");
}

/// Where the muscle of [`rig`] ends at rest, its length, and how far beside the limb's axis it is, metres.
const ORIGIN: f32 = 0.05;
const LENGTH: f32 = 0.45;

/// A straight muscle in the limb's axis.
fn rig(shape: impl Fn(&mut MuscleSpec)) -> Rig {
    let end = |bone: &str, y| Attachment { bone: bone.into(), offset: Vec3::new(0.0, y, 0.0), normal: Vec3::X };
    let (origin, insertion) = (end("upperarm", ORIGIN), end("lowerarm", ORIGIN + LENGTH - 0.3));
    let mut spec = MuscleSpec::new("long", "upperarm", origin, insertion, MuscleSize::Width(0.03));
    shape(&mut spec);
    Rig::build(limb(60), &[spec], &BuildOptions::default()).expect("a limb")
}

fn played(rig: &Rig, lower: Mat4, activation: f32) -> Trace {
    let activations = vec![activation; rig.specs.len()];
    let pose = Pose { palette: vec![Mat4::IDENTITY, lower], activations, ..Pose::default() };
    let options = FrameOptions { skinning: Skinning::Hybrid, ..FrameOptions::default() };
    Reference::new(rig).frame(&pose, &options).expect("a frame")
}

/// The insertion moved so that the muscle has a share of its length.
fn shortened(share: f32) -> Mat4 {
    Mat4::from_translation(Vec3::Y * (LENGTH * (share - 1.0)))
}

/// Skin on the muscle's surface at rest is on its surface at any length, where a bone carries it along the muscle: a section's
/// area is what the muscle has there now, so that what is inside is the muscle's volume.
#[test]
fn skin_on_a_muscles_surface_keeps_its_volume() {
    for (exponents, share) in [((3, 3), 0.7f32), ((3, 3), 0.85), ((3, 4), 0.8), ((3, 3), 1.3)] {
        let rig = rig(|spec| (spec.rest.alpha, spec.rest.beta) = exponents);
        let trace = played(&rig, shortened(share), 0.0);
        let (now, points) = (&trace.muscles[0], trace.muscles[0].points(&trace.axes));
        let at_rest = &rig.muscles_at_rest().0[0];
        let (mut within, mut volume, mut compared) = (0.0f64, 0.0f64, 0);
        for (joint, matrix) in rig.muscle_joints.joints.iter().zip(&trace.muscle_joints) {
            let place = joint.place.xyz();
            let share_now = muscle::project(points, place).arc * now.inverse_length;
            let wanted = now.radius(share_now, 1.0);
            let found = matrix.transform_vector3(Vec3::X).length() * joint.place.w;
            let largest = at_rest.width * at_rest.profile().max();
            let sunk = wanted - joint.place.w < -0.249 * joint.place.w.max(0.4 * largest);
            if joint.place.w > 0.4 * largest && !sunk {
                assert!((found - wanted).abs() < 2e-6, "{exponents:?} at {share}, {share_now}: {found} {wanted}");
                compared += 1;
                within += f64::from(found * found);
                volume += f64::from(wanted * wanted);
            }
            let slid = matrix.transform_point3(place);
            assert!((slid.y - place.y).abs() < 1e-6, "skin stays where its bone has it: {place} {slid}");
        }
        assert!(compared >= 8 && (within / volume - 1.0).abs() < 1e-4, "{compared} joints: {within} {volume}");
        let still = played(&rig, Mat4::IDENTITY, 0.0);
        let swollen = still.muscle_joints.iter().map(|m| m.transform_vector3(Vec3::X).length());
        assert!(swollen.fold(0.0, f32::max) < 1.0 + 1e-5, "a muscle at its length does not swell");
        let fullest = trace.muscle_joints.iter().map(|m| m.transform_vector3(Vec3::X).length()).fold(0.0, f32::max);
        assert!(share > 1.0 || fullest > 0.8 / share.sqrt() + 0.1, "{share}: {fullest}");
        // The area times the length is what it was (paper A, equation 3).
        assert!((now.width / at_rest.width - 1.0 / share.sqrt()).abs() < 1e-4);
    }
}

#[test]
fn a_muscle_that_collapses_lets_the_skin_go_smoothly() {
    let rig = rig(|_| ());
    let joints = |share: f32| played(&rig, shortened(share), 0.0).muscle_joints;
    assert!(joints(0.25).iter().all(|m| apart(m, &Mat4::IDENTITY) < 1e-6), "its bone alone moves its joints");
    assert!(joints(0.6).iter().any(|m| apart(m, &Mat4::IDENTITY) > 0.2));
    let shares: Vec<f32> = (0..=80).map(|i| 0.2 + 0.005 * i as f32).collect();
    let steps = shares.windows(2).map(|pair| {
        let (a, b) = (joints(pair[0]), joints(pair[1]));
        a.iter().zip(&b).map(|(a, b)| apart(a, b)).fold(0.0, f32::max)
    });
    let largest = steps.fold(0.0, f32::max);
    assert!(largest < 0.1, "in steps of half a percent: {largest}");
}

#[test]
fn a_uniform_swelling_is_one_over_the_root_of_the_length() {
    // In the middle of a symmetric muscle that shortens from both ends.
    let rig = rig(|_| ());
    let share = 0.8f32;
    let half = Mat4::from_translation(Vec3::Y * (0.5 * LENGTH * (share - 1.0)));
    let up = half.inverse();
    let pose = Pose { palette: vec![up, half], ..Pose::default() };
    let options = FrameOptions { skinning: Skinning::Hybrid, ..FrameOptions::default() };
    let trace = Reference::new(&rig).frame(&pose, &options).expect("a frame");
    // The upper bone, whose skin it shapes, has moved up by a tenth of the length: the joint that the middle has now.
    let middle = ORIGIN + 0.5 * LENGTH - 0.1 * LENGTH;
    let near = |a: &&MuscleJoint, b: &&MuscleJoint| (a.place.y - middle).abs().total_cmp(&(b.place.y - middle).abs());
    let joint = rig.muscle_joints.joints.iter().min_by(near).expect("one");
    let i = rig.muscle_joints.joints.iter().position(|j| j == joint).expect("it");
    let largest = rig.muscles_at_rest().0[0].radius(0.5, 1.0);
    let found = trace.muscle_joints[i].transform_vector3(Vec3::X).length() * joint.place.w;
    assert!((found / (largest / share.sqrt()) - 1.0).abs() < 0.01, "{found} {largest}");
}

#[test]
fn rest_is_rest_and_the_whole_turns_as_one() {
    for rig in [rig(|_| ()), Rig::build(limb(40), &[limb_muscle()], &BuildOptions::default()).expect("a limb")] {
        let still = played(&rig, Mat4::IDENTITY, 0.0).muscle_joints;
        let off = still.iter().map(|m| apart(m, &Mat4::IDENTITY)).fold(0.0, f32::max);
        assert!(off < 2e-5, "{off}");
        let whole = Mat4::from_rotation_translation(Quat::from_rotation_x(1.1), Vec3::new(2.0, -1.0, 0.5));
        let pose = Pose { palette: vec![whole; 2], ..Pose::default() };
        let options = FrameOptions { skinning: Skinning::Hybrid, ..FrameOptions::default() };
        let found = Reference::new(&rig).frame(&pose, &options).expect("a frame").muscle_joints;
        assert!(found.iter().all(|m| apart(m, &whole) < 5e-5));
        assert!(found.iter().all(|m| apart(m, &Mat4::IDENTITY) > 0.1));
    }
}

#[test]
fn a_muscle_that_bends_away_takes_its_joints_aside_and_turns_them() {
    let rig = rig(|_| ());
    let (rest, inputs) = (&rig.muscles[0], FrameInputs::new(&rig, &Pose::rest(&rig.character)).expect("rest"));
    // From the origin on an arc in the plane of X and Y, as long as the muscle.
    let bend = 0.9f32;
    let radius = LENGTH / bend;
    let turn = |s: f32| Quat::from_rotation_z(bend * s);
    let centre = Vec3::new(-radius, ORIGIN, 0.0);
    let place = |s: f32| centre + turn(s) * (Vec3::X * radius);
    let point = |i: u32| AxisPoint { position: place(i as f32 / 29.0).extend(0.0), ..AxisPoint::default() };
    let mut points: Vec<AxisPoint> = (0..30).map(point).collect();
    let frame = muscle::shape(rest, &inputs.muscles[0], &mut points, Vec3::X, turn(1.0) * Vec3::X);
    let input = MuscleJointInput {
        joints: &inputs.joints,
        muscles_rest: &rig.muscles,
        joints_rest: &rig.muscle_joints.joints,
        muscles: &[frame],
        axes: &points,
    };
    let mut found = vec![Mat4::NAN; 30];
    skinning::muscle_joints(&input, &mut found);
    for (joint, m) in rig.muscle_joints.joints.iter().zip(&found) {
        // The foot of a point on the arc's plane, on the ray from the centre through it.
        let q = joint.place.xyz();
        let ray = (q - centre).normalize();
        let s = ray.y.atan2(ray.x) / bend;
        let wanted = centre + ray * radius;
        // The farther it has gone aside, in its own radii, the less the skin follows.
        let hold = 1.0 / (1.0 + q.distance_squared(wanted) * joint.swell_long * joint.swell_short).sqrt();
        let at = m.transform_point3(q);
        // The axis' direction between two chords is a quarter of a degree off.
        assert!(at.distance(q.lerp(wanted, hold)) < 5e-4, "{q}: {at} {wanted} {hold}");
        // At the ends it is a chord's, half a step off the arc's.
        let along = (m.transform_vector3(Vec3::Y) - Vec3::Y) / hold + Vec3::Y;
        assert!(along.normalize().distance(turn(s) * Vec3::Y) < bend / 58.0 + 2e-3, "{s}: {along}");
        let across = m.transform_vector3(Vec3::Z);
        assert!(across.normalize().distance(Vec3::Z) < 1e-4, "{across}");
    }
    assert!(found[29].transform_point3(rig.muscle_joints.joints[29].place.xyz()).x < -8e-3, "it has gone aside");
}

#[test]
fn an_exaggerated_muscle_is_wider_and_a_flatter_one_as_large() {
    let thickness = |found: &[Mat4], axis: Vec3| found[14].transform_vector3(axis).length();
    let wide = played(&rig(|spec| spec.active.width = 1.5), Mat4::IDENTITY, 1.0).muscle_joints;
    assert!((thickness(&wide, Vec3::X) - 1.5).abs() < 0.01, "{}", thickness(&wide, Vec3::X));
    let flat = played(&rig(|spec| spec.active.eccentricity = 0.7), Mat4::IDENTITY, 1.0).muscle_joints;
    let (long, short) = (thickness(&flat, Vec3::X), thickness(&flat, Vec3::Z));
    assert!(long > 1.1 && (long * short - 1.0).abs() < 1e-3, "{long} {short}");
}
