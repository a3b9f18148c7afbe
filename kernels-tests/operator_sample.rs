//! `operator_sample`, the clean union and every joint's operator, against its twin: the same bits, on random pairs and on
//! the values where branches meet.

use crate::support::{JUNK, Random, SIZES, gpu, run};
use glam::Vec4;
use sinew::{
    field::compose::{JointOperator, OperatorInput, curves, operate},
    parity::{self, Tolerance},
    schedule::KernelId,
};

struct Pairs {
    left: Vec<Vec4>,
    right: Vec<Vec4>,
}

impl Pairs {
    /// Random values and gradients; a third of the gradients run nearly side by side.
    fn random(count: usize, seed: u64) -> Pairs {
        let mut random = Random(seed);
        let mut pairs = Pairs { left: Vec::new(), right: Vec::new() };
        for i in 0..count {
            let gradient = random.vec3() * 30.0;
            let spread = if i.is_multiple_of(3) { 3.0 } else { 60.0 };
            pairs.left.push(gradient.extend(0.5 + 0.5 * random.next()));
            pairs.right.push((gradient + random.vec3() * spread).extend(0.5 + 0.5 * random.next()));
        }
        pairs
    }

    /// Every pair of values at which branches meet, and their neighbours; with gradients and without.
    fn edges() -> Pairs {
        let marks = [0.0f32, 1e-30, 1e-6, 0.25, 0.5, 0.55, 0.7, 0.914, 1.0];
        let values: Vec<f32> = marks
            .iter()
            .flat_map(|v| [v.next_down().max(0.0), *v, v.next_up().min(1.0)])
            .filter(|v| v.is_normal() || *v == 0.0)
            .collect();
        let (along, against) = (Vec4::new(3.0, 4.0, 0.0, 0.0), Vec4::new(-3.0, -4.0, 1e-6, 0.0));
        let mut pairs = Pairs { left: Vec::new(), right: Vec::new() };
        for a in &values {
            for b in &values {
                for (left, right) in
                    [(along, along), (along, against), (along, Vec4::Z), (along, Vec4::ZERO), (Vec4::ZERO, Vec4::ZERO)]
                {
                    pairs.left.push(left.with_w(*a));
                    pairs.right.push(right.with_w(*b));
                }
            }
        }
        pairs
    }

    fn input(&self, operator: Option<JointOperator>) -> OperatorInput<'_> {
        OperatorInput { operator: operator.map(JointOperator::params), left: &self.left, right: &self.right }
    }

    fn cpu(&self, operator: Option<JointOperator>) -> Vec<Vec4> {
        let mut samples = vec![Vec4::NAN; self.left.len()];
        operate(&self.input(operator), &mut samples);
        samples
    }

    fn gpu(&self, operator: Option<JointOperator>) -> Option<(bool, Vec<Vec4>)> {
        let gpu = gpu()?;
        let params = self.input(operator).params();
        let inputs: [(&str, &[u8]); 4] = [
            ("params", bytemuck::bytes_of(&params)),
            ("curves", bytemuck::cast_slice(curves())),
            ("left", bytemuck::cast_slice(&self.left)),
            ("right", bytemuck::cast_slice(&self.right)),
        ];
        let count = self.left.len();
        let out = run(&gpu, KernelId::OperatorSample, count as u64, &inputs, &[("samples", (count + 1) * 16)]);
        let mut samples: Vec<Vec4> = bytemuck::pod_collect_to_vec(&out[0]);
        assert_eq!(samples.pop().map(|s| s.x.to_bits()), Some(JUNK), "written beyond the last pair");
        Some((gpu.headless.info.device_type == wgpu::DeviceType::Cpu, samples))
    }
}

fn operators() -> impl Iterator<Item = Option<JointOperator>> {
    JointOperator::ALL.into_iter().map(Some).chain([None])
}

/// Where a driver fuses multiplications and additions or rounds divisions loosely, values and derivatives, all up to 1,
/// differ by a few units in their last place; near the corner of a box, and where the opening is all but closed, what is
/// divided is a difference, and a step more or less decides between branches that meet there.
const LOOSE: Tolerance = Tolerance { absolute: 1e-5, share_over: 1e-2 };

#[track_caller]
fn same(strict: bool, gpu: &[Vec4], cpu: &[Vec4], what: &str) {
    let bits = |samples: &[Vec4]| samples.iter().map(|s| s.to_array().map(f32::to_bits)).collect::<Vec<_>>();
    if strict {
        let first = gpu.iter().zip(cpu).position(|(a, b)| bits(&[*a]) != bits(&[*b]));
        assert!(first.is_none(), "{what}: pair {first:?}: {:?}", first.map(|i| (gpu[i], cpu[i])));
        return;
    }
    let scaled = |samples: &[Vec4]| samples.iter().map(|s| *s * Vec4::new(0.02, 0.02, 0.02, 1.0)).collect::<Vec<_>>();
    let report = parity::vectors("operators", &scaled(gpu), &scaled(cpu), 1.0, LOOSE);
    assert!(report.pass, "{what}: {report:?}");
}

#[test]
fn has_the_bits_of_its_twin() {
    for size in SIZES.into_iter().chain([20_000]) {
        let pairs = Pairs::random(size, 81);
        for operator in operators() {
            let Some((strict, gpu)) = pairs.gpu(operator) else { return };
            let cpu = pairs.cpu(operator);
            same(strict, &gpu, &cpu, &format!("size {size}, {operator:?}"));
            let changed =
                cpu.iter().zip(pairs.left.iter().zip(&pairs.right)).filter(|(c, (l, r))| c.w > l.w.max(r.w) + 1e-4);
            let changed = changed.count();
            let union = operator == Some(JointOperator::Union);
            assert!(size < 1000 || union || changed * 50 > size, "{operator:?} changes {changed} only");
        }
    }
}

#[test]
fn has_the_bits_of_its_twin_where_branches_meet() {
    let pairs = Pairs::edges();
    for operator in operators() {
        let cpu = pairs.cpu(operator);
        for (found, (a, b)) in cpu.iter().zip(pairs.left.iter().zip(&pairs.right)) {
            assert!(found.is_finite() && found.w >= a.w.max(b.w) && found.w <= 1.0, "{operator:?} of {a} {b}: {found}");
        }
        let Some((strict, gpu)) = pairs.gpu(operator) else { return };
        assert!(gpu.iter().all(|v| v.is_finite()), "{operator:?}");
        if strict {
            same(strict, &gpu, &cpu, &format!("{operator:?}"));
        }
    }
}

#[test]
fn another_operator_and_a_changed_pair_are_found() {
    let pairs = Pairs::random(2000, 82);
    let Some((strict, gpu)) = pairs.gpu(Some(JointOperator::Contact)) else { return };
    let differs = |pairs: &Pairs, operator| {
        let cpu = pairs.cpu(operator);
        std::panic::catch_unwind(|| same(strict, &gpu, &cpu, "")).is_err()
    };
    assert!(!differs(&pairs, Some(JointOperator::Elbow)), "the same operator by its other name");
    for other in [Some(JointOperator::Elbow2), Some(JointOperator::Blend), Some(JointOperator::Bulge), None] {
        assert!(differs(&pairs, other), "{other:?}");
    }
    let mut nudged = Pairs::random(2000, 82);
    nudged.left.iter_mut().for_each(|v| v.w += 1e-4);
    assert!(differs(&nudged, Some(JointOperator::Contact)));
}
