//! `muscle_shape` against its twin, and the twin against the volume that it must keep.

use crate::support::{JUNK, Random, SIZES, gpu, run};
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use sinew::{
    field::muscle::{AxisPoint, MuscleFrame, MuscleInput, MuscleRest, Profile},
    rig::JointFrame,
    schedule::KernelId,
    wrap::{self, MuscleParams, ShapeInput},
};

struct Muscles {
    rest: Vec<MuscleRest>,
    inputs: Vec<MuscleInput>,
    joints: Vec<JointFrame>,
    points: usize,
}

/// Muscles and the points of their axes.
type Shaped = (Vec<MuscleFrame>, Vec<AxisPoint>);

const JOINTS: usize = 4;

impl Muscles {
    fn random(count: usize, instances: usize, seed: u64) -> Muscles {
        let mut random = Random(seed);
        let mut points = 0;
        let rest = (0..count)
            .map(|i| {
                let (origin, insertion) = (random.vec3(), random.vec3());
                let segments = 3 + (i as u32 * 7) % 61;
                points += segments as usize + 1;
                MuscleRest {
                    origin: origin.extend(2e-4),
                    // Every eighth muscle is a point in its rest pose and in every pose of its one joint.
                    insertion: if i % 8 == 7 { origin } else { insertion }.extend(0.01),
                    origin_normal: random.vec3().normalize().extend(origin.distance(insertion)),
                    insertion_normal: random.vec3().normalize().extend(0.0),
                    origin_joint: (i % JOINTS) as u32,
                    insertion_joint: if i % 8 == 7 { (i % JOINTS) as u32 } else { ((i + 1) % JOINTS) as u32 },
                    joint: (i * 3 % JOINTS) as u32,
                    segments,
                    first_point: points as u32 - segments - 1,
                    ..MuscleRest::default()
                }
            })
            .collect();
        let inputs = (0..count * instances)
            .map(|i| {
                let (alpha, beta) = (1 + i as u32 % 9, 9 - i as u32 % 7);
                let share = random.next().abs();
                let profile = Profile::blend(&[((alpha, beta), share), ((4, 7), 1.0 - share)]);
                let input = MuscleInput::new(&profile, 0.9 * random.next().abs());
                let shift = [0.0, 0.2, -0.1][i % 3];
                MuscleInput { activation: share, width: 1.0, shift, ..input }
            })
            .collect();
        let joints =
            (0..JOINTS * instances).map(|_| JointFrame { matrix: random.matrix(), ..JointFrame::default() }).collect();
        Muscles { rest, inputs, joints, points }
    }

    fn cpu(&self, instance: usize) -> Shaped {
        let mut shaped = vec![MuscleFrame::default(); self.rest.len()];
        let mut axes = vec![AxisPoint::default(); self.points];
        let input = ShapeInput {
            joints: &self.joints[instance * JOINTS..][..JOINTS],
            inputs: &self.inputs[instance * self.rest.len()..][..self.rest.len()],
            iterates: &[],
        };
        wrap::shape(&self.rest, &input, &mut shaped, &mut axes);
        (shaped, axes)
    }

    fn gpu(&self, instances: usize) -> Option<Shaped> {
        let gpu = gpu()?;
        let params = MuscleParams {
            muscle_count: self.rest.len() as u32,
            instance_count: instances as u32,
            joint_count: JOINTS as u32,
            point_count: self.points as u32,
            ..MuscleParams::default()
        };
        let (count, points) = (self.rest.len() * instances, self.points * instances);
        let inputs: [(&str, &[u8]); 5] = [
            ("params", bytemuck::bytes_of(&params)),
            ("muscles_rest", bytemuck::cast_slice(&self.rest)),
            ("inputs", bytemuck::cast_slice(&self.inputs)),
            ("joints", bytemuck::cast_slice(&self.joints)),
            ("iterates", &[]),
        ];
        let sizes =
            [("shaped", (count + 1) * size_of::<MuscleFrame>()), ("axes", (points + 1) * size_of::<AxisPoint>())];
        let out = run(&gpu, KernelId::MuscleShape, count as u64, &inputs, &sizes);
        let mut shaped: Vec<MuscleFrame> = bytemuck::pod_collect_to_vec(&out[0]);
        let mut axes: Vec<AxisPoint> = bytemuck::pod_collect_to_vec(&out[1]);
        assert_eq!(shaped.pop().map(|m| m.terms), Some(JUNK), "written beyond the last muscle");
        assert_eq!(axes.pop().map(|p| p.turn.w.to_bits()), Some(JUNK), "written beyond the last point");
        Some((shaped, axes))
    }
}

/// Largest difference of two shaped muscles, lengths in metres; infinite where they are of different kinds.
fn difference(a: &MuscleFrame, b: &MuscleFrame) -> f32 {
    let kind = |m: &MuscleFrame| (m.present, m.exponents, m.terms, m.first_point, m.segments);
    if kind(a) != kind(b) {
        return f32::INFINITY;
    }
    let vectors = [(a.factors, b.factors), (a.lowest, b.lowest), (a.highest, b.highest)];
    let numbers = [
        (a.length, b.length),
        (a.inverse_length, b.inverse_length),
        (a.width, b.width),
        (a.support_radius, b.support_radius),
        (a.long_squared, b.long_squared),
        (a.activation, b.activation),
    ];
    let largest = vectors.iter().map(|(a, b)| (*a - *b).abs().max_element() / (1.0 + a.abs().max_element()));
    numbers.iter().map(|(a, b)| (a - b).abs() / (1.0 + a.abs())).chain(largest).fold(0.0, f32::max)
}

/// Largest difference of two points of an axis, metres and directions alike.
fn apart(a: &AxisPoint, b: &AxisPoint) -> f32 {
    let parts = [
        (a.position.with_w(0.0), b.position.with_w(0.0)),
        (Vec4::splat(a.position.w * a.tangent.w), Vec4::splat(b.position.w * b.tangent.w)),
        (a.tangent, b.tangent),
        (a.normal, b.normal),
        (a.turn.with_w(0.0) * a.normal.w.min(1.0), b.turn.with_w(0.0) * b.normal.w.min(1.0)),
        (Vec4::splat(a.turn.w), Vec4::splat(b.turn.w)),
    ];
    parts.iter().map(|(a, b)| (*a - *b).abs().max_element() / (1.0 + a.abs().max_element())).fold(0.0, f32::max)
}

/// Square roots and divisions of two ulp each on values near 1, through three matrices. The direction in which a normal
/// turns to its neighbour is divided by the turn: it is compared times its angle.
const TOLERANCE: f32 = 4e-6;
/// Tangents divide differences of positions, which are of the order of 3 m here, by segments of down to 2 cm.
const AXIS_TOLERANCE: f32 = 1e-4;

#[test]
fn matches_its_twin_at_every_size() {
    for size in SIZES {
        let muscles = Muscles::random(size, 3, 31);
        let Some((shaped, axes)) = muscles.gpu(3) else { return };
        for instance in 0..3 {
            let (cpu, cpu_axes) = muscles.cpu(instance);
            for (i, cpu) in cpu.iter().enumerate() {
                let off = difference(&shaped[instance * size + i], cpu);
                assert!(off < TOLERANCE, "size {size}, instance {instance}, muscle {i}: {off}");
            }
            for (i, cpu) in cpu_axes.iter().enumerate() {
                let off = apart(&axes[instance * muscles.points + i], cpu);
                assert!(off < AXIS_TOLERANCE, "size {size}, instance {instance}, point {i}: {off}");
            }
        }
    }
}

#[test]
fn a_moved_end_is_found() {
    let muscles = Muscles::random(65, 1, 32);
    let Some((shaped, axes)) = muscles.gpu(1) else { return };
    let mut moved = Muscles::random(65, 1, 32);
    moved.rest[20].insertion.x += 1e-3;
    let (cpu, cpu_axes) = moved.cpu(0);
    let over: Vec<usize> = (0..65).filter(|&i| difference(&shaped[i], &cpu[i]) >= TOLERANCE).collect();
    assert_eq!(over, [20]);
    let own = moved.rest[20].first_point as usize..=(moved.rest[20].first_point + moved.rest[20].segments) as usize;
    let over: Vec<usize> = (0..axes.len()).filter(|&i| apart(&axes[i], &cpu_axes[i]) >= AXIS_TOLERANCE).collect();
    assert!(!over.is_empty() && over.iter().all(|i| own.contains(i)), "{over:?} of {own:?}");
}

#[test]
fn twin_keeps_volume_and_frames_its_sections() {
    let muscles = Muscles::random(64, 1, 33);
    let (shaped, axes) = muscles.cpu(0);
    for (i, m) in shaped.iter().enumerate() {
        if i % 8 == 7 {
            assert_eq!(m.present, 0, "a muscle without length");
            continue;
        }
        let volume = std::f64::consts::PI * f64::from(m.width).powi(2) * f64::from(m.length);
        assert!((volume / 2e-4 - 1.0).abs() < 1e-5, "muscle {i}: {volume}");
        for p in m.points(&axes) {
            let square = p.tangent.xyz().dot(p.normal.xyz());
            assert!(square.abs() < 1e-4 && (p.normal.xyz().length() - 1.0).abs() < 1e-5, "muscle {i}: {square}");
        }
    }
}

#[test]
fn twin_is_the_same_wherever_the_character_stands() {
    let mut muscles = Muscles::random(16, 1, 34);
    let common = Mat4::from_rotation_translation(glam::Quat::from_rotation_z(0.8), Vec3::new(3.0, -1.0, 2.0));
    let (before, _) = muscles.cpu(0);
    muscles.joints.iter_mut().for_each(|j| j.matrix = common * j.matrix);
    for (a, b) in before.iter().zip(muscles.cpu(0).0) {
        assert!(difference(a, &b) < 2e-5, "{}", difference(a, &b));
    }
}
