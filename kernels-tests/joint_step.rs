//! `joint_step` against its twin.

use crate::dynamics_fixtures::joint_frame;
use crate::support::{JUNK, Random, SIZES, gpu, run};
use glam::{Mat4, Vec3};
use sinew::{
    dynamics::{DynamicsParams, MovedJoint, StepClock, joints},
    parity::MOVED_JOINTS,
    rig::JointFrame,
    schedule::KernelId,
};

struct Joints {
    clocks: Vec<StepClock>,
    before: Vec<JointFrame>,
    now: Vec<JointFrame>,
    count: usize,
}

impl Joints {
    fn random(count: usize, seed: u64) -> Joints {
        let mut random = Random(seed);
        let clock = StepClock { step: 0.21, turns: 4, age: 7, fade: 60, full_retention: 0.9, ..StepClock::default() };
        // On the way, at its end, beyond it, settling, at its beginning.
        let clocks = vec![
            StepClock { first: 0.13, turn: 2, ..clock },
            StepClock { first: 0.37, turn: 3, ..clock },
            StepClock { first: 0.2, turn: 4, ..clock },
            StepClock { turn: 2, settling: 4, ..StepClock { first: 0.0, step: 0.0, ..clock } },
            StepClock { first: 0.9, turn: 0, ..clock },
        ];
        let (mut before, mut now) = (Vec::new(), Vec::new());
        for i in 0..count * clocks.len() {
            let from = random.matrix();
            // A joint that stands still, one that has no volume, one that turns, and one whose quaternion changes sign.
            let to = match i % 4 {
                0 => from,
                1 => Mat4::from_scale(Vec3::new(0.0, 1.0, 1.0)),
                _ => Mat4::from_rotation_translation(random.rotation(), random.vec3()) * from,
            };
            before.push(joint_frame(from));
            let mut last = joint_frame(to);
            last.real = if i % 4 == 3 { -last.real } else { last.real };
            now.push(last);
        }
        Joints { clocks, before, now, count }
    }

    fn cpu(&self, carries: bool) -> Vec<MovedJoint> {
        let mut moved = vec![MovedJoint::default(); self.now.len()];
        for (instance, clock) in self.clocks.iter().enumerate() {
            let own = instance * self.count..(instance + 1) * self.count;
            let both = [&self.before[own.clone()], &self.now[own.clone()]].concat();
            joints::step(clock, carries, &both, &mut moved[own]);
        }
        moved
    }

    fn gpu(&self, carries: bool) -> Option<Vec<MovedJoint>> {
        let gpu = gpu()?;
        let params = DynamicsParams {
            instance_count: self.clocks.len() as u32,
            joint_count: self.count as u32,
            carries: carries.into(),
            ..DynamicsParams::default()
        };
        let inputs: [(&str, &[u8]); 4] = [
            ("params", bytemuck::bytes_of(&params)),
            ("clocks", bytemuck::cast_slice(&self.clocks)),
            ("joints_before", bytemuck::cast_slice(&self.before)),
            ("joints", bytemuck::cast_slice(&self.now)),
        ];
        let items = self.now.len();
        let size = (items + 1) * size_of::<MovedJoint>();
        let out = run(&gpu, KernelId::JointStep, items as u64, &inputs, &[("moved", size)]);
        let mut moved: Vec<MovedJoint> = bytemuck::pod_collect_to_vec(&out[0]);
        assert_eq!(moved.pop().map(|m| m.runs), Some(JUNK), "written beyond the last joint");
        Some(moved)
    }
}

/// Largest difference, of entries as they are up to 1 and as a share of them beyond.
fn apart(a: &MovedJoint, b: &MovedJoint) -> f32 {
    if (a.runs, a.carries) != (b.runs, b.carries) || (a.carry == Mat4::ZERO) != (b.carry == Mat4::ZERO) {
        return f32::INFINITY;
    }
    let size = |m: &Mat4| m.to_cols_array().iter().fold(1.0f32, |s, x| s.max(x.abs()));
    let matrices = [(&a.matrix, &b.matrix), (&a.carry, &b.carry), (&a.to_rest, &b.to_rest)];
    let off = |(a, b): (&Mat4, &Mat4)| {
        let pairs = a.to_cols_array().into_iter().zip(b.to_cols_array());
        pairs.fold(0.0f32, |d, (x, y)| if (x - y).is_nan() { f32::INFINITY } else { d.max((x - y).abs()) }) / size(b)
    };
    let numbers = (a.scale - b.scale).abs().max((a.retention - b.retention).abs());
    matrices.into_iter().map(off).fold(numbers, f32::max)
}

#[test]
fn matches_its_twin_at_every_size() {
    let mut worst = 0.0f32;
    for size in SIZES {
        let joints = Joints::random(size, 51);
        for carries in [false, true] {
            let Some(found) = joints.gpu(carries) else { return };
            for (i, (gpu, cpu)) in found.iter().zip(joints.cpu(carries)).enumerate() {
                let off = apart(gpu, &cpu);
                worst = worst.max(off);
                assert!(
                    off <= MOVED_JOINTS.absolute,
                    "size {size}, carries {carries}, joint {i}: {off}\n{gpu:?}\n{cpu:?}"
                );
            }
        }
    }
    println!("joint_step: at most {worst:.2e} apart");
}

#[test]
fn another_clock_is_found() {
    let joints = Joints::random(64, 52);
    let Some(found) = joints.gpu(false) else { return };
    let mut other = Joints::random(64, 52);
    other.clocks[1].first += 1e-3;
    let cpu = other.cpu(false);
    let over: Vec<usize> = (0..found.len()).filter(|&i| apart(&found[i], &cpu[i]) > MOVED_JOINTS.absolute).collect();
    assert!(over.len() >= 32 && over.iter().all(|i| (64..128).contains(i)), "{over:?}");
}
