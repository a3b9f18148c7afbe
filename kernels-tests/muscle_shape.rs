//! `muscle_shape` against its twin, and the twin against the volume that it must keep.

use crate::support::{JUNK, Random, SIZES, gpu, run};
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use sinew::{
    field::{
        evaluate::GroupFrame,
        muscle::{MuscleFrame, MuscleRest, ellipse_squared, profile_max, profile_scale},
    },
    rig::JointFrame,
    schedule::KernelId,
    wrap::{self, MuscleParams},
};

struct Muscles {
    rest: Vec<MuscleRest>,
    joints: Vec<JointFrame>,
    groups: Vec<GroupFrame>,
}

const JOINTS: usize = 4;
const GROUPS: usize = 3;

impl Muscles {
    fn random(count: usize, instances: usize, seed: u64) -> Muscles {
        let mut random = Random(seed);
        let rest = (0..count)
            .map(|i| {
                let (alpha, beta) = (2 + i as u32 % 8, 9 - i as u32 % 7);
                let (short_squared, long_squared) = ellipse_squared(0.9 * random.next().abs());
                let (origin, insertion) = (random.vec3(), random.vec3());
                MuscleRest {
                    origin: origin.extend(2e-4),
                    // Every eighth muscle is a point in its rest pose and in every pose of its one joint.
                    insertion: if i % 8 == 7 { origin } else { insertion }.extend(0.01),
                    origin_normal: random.vec3().normalize().extend(origin.distance(insertion)),
                    insertion_normal: random.vec3().normalize().extend(0.0),
                    origin_joint: (i % JOINTS) as u32,
                    insertion_joint: if i % 8 == 7 { (i % JOINTS) as u32 } else { ((i + 1) % JOINTS) as u32 },
                    group: (i % GROUPS) as u32,
                    alpha,
                    beta,
                    profile_scale: profile_scale(alpha, beta),
                    profile_max: profile_max(alpha, beta),
                    short_squared,
                    long_squared,
                    ..MuscleRest::default()
                }
            })
            .collect();
        let joints =
            (0..JOINTS * instances).map(|_| JointFrame { matrix: random.matrix(), ..JointFrame::default() }).collect();
        let groups = (0..GROUPS * instances)
            .map(|_| GroupFrame { to_rest: random.matrix().inverse(), present: 1, ..GroupFrame::default() })
            .collect();
        Muscles { rest, joints, groups }
    }

    fn cpu(&self, instance: usize) -> Vec<MuscleFrame> {
        let mut shaped = vec![MuscleFrame::default(); self.rest.len()];
        let joints = &self.joints[instance * JOINTS..][..JOINTS];
        wrap::shape(&self.rest, joints, &self.groups[instance * GROUPS..][..GROUPS], &mut shaped);
        shaped
    }

    fn gpu(&self, instances: usize) -> Option<Vec<MuscleFrame>> {
        let gpu = gpu()?;
        let params = MuscleParams {
            muscle_count: self.rest.len() as u32,
            instance_count: instances as u32,
            joint_count: JOINTS as u32,
            group_count: GROUPS as u32,
        };
        let count = self.rest.len() * instances;
        let inputs: [(&str, &[u8]); 4] = [
            ("params", bytemuck::bytes_of(&params)),
            ("muscles_rest", bytemuck::cast_slice(&self.rest)),
            ("joints", bytemuck::cast_slice(&self.joints)),
            ("groups", bytemuck::cast_slice(&self.groups)),
        ];
        let size = size_of::<MuscleFrame>();
        let out = run(&gpu, KernelId::MuscleShape, count as u64, &inputs, &[("shaped", (count + 1) * size)]);
        let mut shaped: Vec<MuscleFrame> = bytemuck::pod_collect_to_vec(&out[0]);
        assert_eq!(shaped.pop().map(|m| m.alpha), Some(JUNK), "written beyond the last muscle");
        Some(shaped)
    }
}

/// Largest difference of two shaped muscles, lengths in metres and directions alike; infinite where they are of
/// different kinds. Directions across a nearly parallel normal magnify rounding: those are left out by their size.
fn difference(a: &MuscleFrame, b: &MuscleFrame) -> f32 {
    if (a.present, a.alpha, a.beta) != (b.present, b.alpha, b.beta) {
        return f32::INFINITY;
    }
    let vectors = [(a.origin, b.origin), (a.axis, b.axis), (a.normal, b.normal)];
    let largest =
        vectors.iter().map(|(a, b): &(Vec4, Vec4)| (*a - *b).abs().max_element() / (1.0 + a.abs().max_element()));
    largest.fold((a.support_radius - b.support_radius).abs().max((a.activation - b.activation).abs()), f32::max)
}

/// Two square roots and two divisions of two ulp each on values near 1, through three matrices.
const TOLERANCE: f32 = 4e-6;

#[test]
fn matches_its_twin_at_every_size() {
    for size in SIZES {
        let muscles = Muscles::random(size, 3, 31);
        let Some(gpu) = muscles.gpu(3) else { return };
        for instance in 0..3 {
            for (i, cpu) in muscles.cpu(instance).iter().enumerate() {
                let apart = difference(&gpu[instance * size + i], cpu);
                assert!(apart < TOLERANCE, "size {size}, instance {instance}, muscle {i}: {apart}");
            }
        }
    }
}

#[test]
fn a_moved_end_is_found() {
    let muscles = Muscles::random(65, 1, 32);
    let Some(gpu) = muscles.gpu(1) else { return };
    let mut moved = Muscles::random(65, 1, 32);
    moved.rest[20].insertion.x += 1e-3;
    let over: Vec<usize> =
        moved.cpu(0).iter().enumerate().filter(|(i, c)| difference(&gpu[*i], c) >= TOLERANCE).map(|(i, _)| i).collect();
    assert_eq!(over, [20]);
}

#[test]
fn twin_keeps_volume_and_frames_its_section() {
    let muscles = Muscles::random(64, 1, 33);
    for (i, m) in muscles.cpu(0).iter().enumerate() {
        if i % 8 == 7 {
            assert_eq!(m.present, 0, "a muscle without length");
            continue;
        }
        let volume = std::f64::consts::PI * f64::from(m.normal.w).powi(2) * f64::from(m.origin.w);
        assert!((volume / 2e-4 - 1.0).abs() < 1e-5, "muscle {i}: {volume}");
        assert!(m.axis.xyz().dot(m.normal.xyz()).abs() < 1e-5 && (m.normal.xyz().length() - 1.0).abs() < 1e-5);
    }
}

#[test]
fn twin_is_the_same_wherever_the_character_stands() {
    let mut muscles = Muscles::random(16, 1, 34);
    let common = Mat4::from_rotation_translation(glam::Quat::from_rotation_z(0.8), Vec3::new(3.0, -1.0, 2.0));
    muscles.groups.iter_mut().for_each(|g| g.to_rest = Mat4::IDENTITY);
    let before = muscles.cpu(0);
    muscles.joints.iter_mut().for_each(|j| j.matrix = common * j.matrix);
    muscles.groups.iter_mut().for_each(|g| g.to_rest = common.inverse());
    for (a, b) in before.iter().zip(muscles.cpu(0)) {
        assert!(difference(a, &b) < 2e-5, "{}", difference(a, &b));
    }
}
