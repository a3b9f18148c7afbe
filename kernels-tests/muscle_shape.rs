//! `muscle_shape` against its twin, and the twin against the volume that it must keep.

use crate::support::{JUNK, Random, SIZES, gpu, run_variant};
use crate::wrap_fixtures::across;
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use sinew::{
    field::muscle::{AxisPoint, MuscleFrame, MuscleInput, MuscleRest, Profile, axis, wrap::MuscleWrap},
    rig::JointFrame,
    schedule::KernelId,
    wrap::{self, MuscleParams, ShapeInput},
};

/// Random muscles of several instances.
pub struct Muscles {
    pub rest: Vec<MuscleRest>,
    inputs: Vec<MuscleInput>,
    pub joints: Vec<JointFrame>,
    pub points: usize,
    wraps: Vec<MuscleWrap>,
    /// First halves of the iterates of all instances, where axes come from them.
    iterates: Vec<Vec4>,
}

/// Muscles and the points of their axes.
type Shaped = (Vec<MuscleFrame>, Vec<AxisPoint>);

/// Joints of an instance.
pub const JOINTS: usize = 4;

impl Muscles {
    pub fn random(count: usize, instances: usize, seed: u64) -> Muscles {
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
        Muscles { rest, inputs, joints, points, wraps: Vec::new(), iterates: Vec::new() }
    }

    /// Two of three muscles lie round something, that a joint carries which may be none of theirs.
    fn wrapped(mut self, seed: u64) -> Muscles {
        let mut random = Random(seed);
        for (i, rest) in self.rest.iter_mut().enumerate().filter(|(i, _)| i % 3 > 0) {
            let (origin, insertion) = (rest.origin.xyz(), rest.insertion.xyz());
            let found = across(origin, insertion, i / 2 % JOINTS, rest.segments, i % 2 == 0, &mut random);
            if let Some(wrap) = found {
                self.wraps.push(wrap);
                rest.wrap = self.wraps.len() as u32;
            }
        }
        self
    }

    /// Axes somewhere about the straight lines between their ends.
    fn moving(mut self, instances: usize, seed: u64) -> Muscles {
        let mut random = Random(seed);
        for instance in 0..instances {
            let joints = &self.joints[instance * JOINTS..][..JOINTS];
            for rest in &self.rest {
                let at = |joint: u32, p: Vec4| joints[joint as usize].matrix.transform_point3(p.xyz());
                let (from, to) = (at(rest.origin_joint, rest.origin), at(rest.insertion_joint, rest.insertion));
                self.iterates.extend([Vec4::ZERO; 2]);
                for i in 0..=rest.segments {
                    let place = from.lerp(to, i as f32 / rest.segments as f32) + random.vec3() * 0.02;
                    self.iterates.extend([place.extend(0.01), Vec4::Y.with_w(0.01)]);
                }
            }
        }
        self
    }

    /// Length of a first half of the iterates; the second half, which nobody reads, is as long.
    fn half(&self) -> usize {
        axis::half(self.rest.len() as u32, self.points as u32)
    }

    pub fn cpu(&self, instance: usize) -> Shaped {
        let mut shaped = vec![MuscleFrame::default(); self.rest.len()];
        let mut axes = vec![AxisPoint::default(); self.points];
        let input = ShapeInput {
            joints: &self.joints[instance * JOINTS..][..JOINTS],
            inputs: &self.inputs[instance * self.rest.len()..][..self.rest.len()],
            iterates: if self.iterates.is_empty() {
                &[]
            } else {
                &self.iterates[instance * self.half()..][..self.half()]
            },
            wraps: &self.wraps,
        };
        wrap::shape(&self.rest, &input, &mut shaped, &mut axes);
        (shaped, axes)
    }

    fn gpu(&self, instances: usize) -> Option<Shaped> {
        self.gpu_by(0, instances)
    }

    fn gpu_by(&self, variant: usize, instances: usize) -> Option<Shaped> {
        let gpu = gpu()?;
        let halves = self.iterates.chunks(self.half().max(1)).flat_map(|half| [half, half].concat());
        let iterates: Vec<Vec4> = halves.collect();
        let params = MuscleParams {
            muscle_count: self.rest.len() as u32,
            instance_count: instances as u32,
            joint_count: JOINTS as u32,
            point_count: self.points as u32,
            moving: (!iterates.is_empty()).into(),
            ..MuscleParams::default()
        };
        let (count, points) = (self.rest.len() * instances, self.points * instances);
        let inputs: [(&str, &[u8]); 6] = [
            ("params", bytemuck::bytes_of(&params)),
            ("muscles_rest", bytemuck::cast_slice(&self.rest)),
            ("inputs", bytemuck::cast_slice(&self.inputs)),
            ("joints", bytemuck::cast_slice(&self.joints)),
            ("iterates", bytemuck::cast_slice(&iterates)),
            ("wraps", bytemuck::cast_slice(&self.wraps)),
        ];
        let sizes =
            [("shaped", (count + 1) * size_of::<MuscleFrame>()), ("axes", (points + 1) * size_of::<AxisPoint>())];
        let out = run_variant(&gpu, (KernelId::MuscleShape, variant), count as u64, &inputs, &sizes);
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

/// Largest differences of muscles and points from the twin's.
fn off(muscles: &Muscles, instances: usize) -> Option<(f32, f32)> {
    let (shaped, axes) = muscles.gpu(instances)?;
    let count = muscles.rest.len();
    let (mut worst, mut worst_point) = (0.0f32, 0.0f32);
    for instance in 0..instances {
        let (cpu, cpu_axes) = muscles.cpu(instance);
        let pairs = shaped[instance * count..].iter().zip(&cpu);
        worst = pairs.fold(worst, |most, (a, b)| most.max(difference(a, b)));
        let pairs = axes[instance * muscles.points..].iter().zip(&cpu_axes);
        worst_point = pairs.fold(worst_point, |most, (a, b)| most.max(apart(a, b)));
    }
    Some((worst, worst_point))
}

#[test]
fn matches_its_twin_at_every_size() {
    for size in SIZES {
        for muscles in [Muscles::random(size, 3, 31), Muscles::random(size, 3, 31).moving(3, 35)] {
            let Some((muscle, point)) = off(&muscles, 3) else { return };
            assert!(muscle < TOLERANCE && point < AXIS_TOLERANCE, "size {size}: {muscle} {point}");
        }
    }
}

/// A path goes through the obstacle's frame and back and through two arc sines of 1e-6, on muscles of 1 to 3 m, and the sections'
/// normals turn into the plane of segments of 2 cm.
const WRAPPED_AXIS_TOLERANCE: f32 = 5e-4;

#[test]
fn matches_its_twin_round_joints_and_bones() {
    for size in SIZES {
        for wrapped in
            [Muscles::random(size, 3, 36).wrapped(37), Muscles::random(size, 3, 36).moving(3, 38).wrapped(37)]
        {
            let Some((muscle, point)) = off(&wrapped, 3) else { return };
            println!("size {size}: {muscle:.1e} {point:.1e}");
            assert!(muscle < TOLERANCE && point < WRAPPED_AXIS_TOLERANCE, "size {size}: {muscle} {point}");
        }
    }
}

#[test]
fn a_larger_obstacle_and_another_side_are_found() {
    for change in [|wrap: &mut MuscleWrap| wrap.radius *= 1.01, |wrap: &mut MuscleWrap| wrap.side = -wrap.side] {
        let muscles = Muscles::random(65, 1, 36).wrapped(37);
        let Some((_, axes)) = muscles.gpu(1) else { return };
        let mut other = Muscles::random(65, 1, 36).wrapped(37);
        other.wraps.iter_mut().for_each(change);
        let (_, cpu_axes) = other.cpu(0);
        let over = |rest: &MuscleRest| {
            let own = rest.first_point as usize..=(rest.first_point + rest.segments) as usize;
            own.clone().any(|i| apart(&axes[i], &cpu_axes[i]) >= WRAPPED_AXIS_TOLERANCE)
        };
        let found = muscles.rest.iter().filter(|rest| over(rest)).count();
        let straight = muscles.rest.iter().filter(|rest| rest.wrap == 0 && over(rest)).count();
        assert!(found >= 10 && straight == 0, "{found} differ, {straight} of them straight");
    }
}

#[test]
fn the_pipeline_for_straight_muscles_gives_the_same_bits() {
    let muscles = Muscles::random(65, 2, 39).moving(2, 40);
    let (Some(all), Some(straight)) = (muscles.gpu_by(0, 2), muscles.gpu_by(1, 2)) else { return };
    assert!(all == straight);
    let wrapped = muscles.wrapped(37);
    let (Some(all), Some(straight)) = (wrapped.gpu_by(0, 2), wrapped.gpu_by(1, 2)) else { return };
    assert!(all != straight, "which cannot follow a path");
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
