//! `muscle_predict` against its twin.

use crate::dynamics_fixtures::Crowd;
use crate::support::{JUNK, SIZES, gpu, run_variant};
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::{
    dynamics::{DynamicsParams, Particle, StepClock},
    parity::PREDICTED,
    schedule::{DynamicsOptions, KernelId, Mode, Solver},
};

#[derive(PartialEq)]
struct Predicted {
    particles: Vec<Particle>,
    iterates: Vec<Vec4>,
    clocks: Vec<StepClock>,
}

fn played(crowd: &Crowd, params: &DynamicsParams) -> Option<Predicted> {
    played_by(0, crowd, params)
}

fn played_by(variant: usize, crowd: &Crowd, params: &DynamicsParams) -> Option<Predicted> {
    let gpu = gpu()?;
    let inputs: [(&str, &[u8]); 8] = [
        ("params", bytemuck::bytes_of(params)),
        ("bodies", bytemuck::cast_slice(&crowd.muscles)),
        ("inputs", bytemuck::cast_slice(&crowd.inputs)),
        ("moved", bytemuck::cast_slice(&crowd.moved)),
        ("axes", bytemuck::cast_slice(&crowd.axes)),
        ("particles", bytemuck::cast_slice(&crowd.particles)),
        ("clocks", bytemuck::cast_slice(&crowd.clocks)),
        ("wraps", bytemuck::cast_slice(&crowd.wraps)),
    ];
    let sizes = [
        ("particles", (crowd.particles.len() + 1) * size_of::<Particle>()),
        ("iterates", (crowd.iterates.len() + 1) * 16),
        ("clocks", (crowd.clocks.len() + 1) * size_of::<StepClock>()),
    ];
    let items = crowd.muscles.len() * crowd.instances;
    let out = run_variant(&gpu, (KernelId::MusclePredict, variant), items as u64, &inputs, &sizes);
    let mut found = Predicted {
        particles: bytemuck::pod_collect_to_vec(&out[0]),
        iterates: bytemuck::pod_collect_to_vec(&out[1]),
        clocks: bytemuck::pod_collect_to_vec(&out[2]),
    };
    assert_eq!(found.particles.pop().map(|p| p.traits.w.to_bits()), Some(JUNK), "written beyond the last particle");
    assert_eq!(found.iterates.pop().map(|v| v.w.to_bits()), Some(JUNK), "written beyond the last iterate");
    assert_eq!(found.clocks.pop().map(|c| c.age), Some(JUNK), "written beyond the last clock");
    Some(found)
}

/// Largest difference of two entries, as they are up to 1 and as a share beyond; untouched ones must be the same bits.
fn apart(a: Vec4, b: Vec4) -> f32 {
    if b.x.to_bits() == JUNK || !b.is_finite() {
        return if a.to_array().map(f32::to_bits) == b.to_array().map(f32::to_bits) { 0.0 } else { f32::INFINITY };
    }
    let off = (a - b).abs().max_element() / b.abs().max_element().max(1.0);
    if off.is_nan() { f32::INFINITY } else { off }
}

/// Items over the tolerance, and the largest difference.
fn over(found: &Predicted, cpu: &Crowd) -> (Vec<usize>, f32) {
    let particles = found.particles.iter().zip(&cpu.particles).map(|(a, b)| {
        let parts = [(a.position, b.position), (a.velocity, b.velocity), (a.spring, b.spring), (a.pushes, b.pushes)];
        parts.iter().map(|(a, b)| apart(*a, *b)).fold(apart(a.traits, b.traits), f32::max)
    });
    let iterates = found.iterates.iter().zip(&cpu.iterates).map(|(a, b)| apart(*a, *b));
    let all: Vec<f32> = particles.chain(iterates).collect();
    let worst = all.iter().copied().fold(0.0, f32::max);
    ((0..all.len()).filter(|&i| all[i] > PREDICTED.absolute).collect(), worst)
}

fn variants() -> Vec<DynamicsOptions> {
    let options = DynamicsOptions::default();
    vec![options, DynamicsOptions { solver: Solver::Jacobi, ..options }, DynamicsOptions { mode: Mode::Pbd, ..options }]
}

#[test]
fn matches_its_twin_at_every_size() {
    let mut worst = 0.0f32;
    for size in SIZES {
        for (k, options) in variants().iter().enumerate() {
            for carries in [0, 1] {
                let mut crowd = Crowd::new(size, 3, None, 61 + k as u64);
                // The second instance has no substeps left; sections of the third have no direction yet.
                for m in &mut crowd.moved {
                    m.carries = carries;
                }
                let joints = crowd.moved.len() / 3;
                for m in &mut crowd.moved[joints..2 * joints] {
                    m.runs = 0;
                }
                let points = crowd.points();
                for p in &mut crowd.axes[2 * points..] {
                    p.normal = Vec4::ZERO;
                }
                let params = DynamicsParams { carries, ..crowd.params(options, 0) };
                let Some(found) = played(&crowd, &params) else { return };
                crowd.predict(&params);
                let (over, off) = over(&found, &crowd);
                worst = worst.max(off);
                assert!(over.is_empty(), "size {size}, variant {k}, carries {carries}: {off} at {over:?}");
                if size > 0 {
                    assert_eq!(found.clocks, crowd.clocks);
                    assert_eq!(crowd.clocks[0].turn, 2, "a substep has been counted");
                }
            }
        }
    }
    println!("muscle_predict: at most {worst:.2e} apart");
}

/// A muscle's springs pull by small numbers; their difference as a share of the strongest, which a segment's length, found from
/// the ends of two paths, decides: 1e-7 m of 2 mm at the shortest.
const PULLS: f32 = 5e-4;

/// Largest difference of one muscle's springs, as a share of the strongest.
fn pulls_apart(crowd: &Crowd, found: &Predicted, index: usize) -> f32 {
    let muscle = &crowd.muscles[index];
    let own = muscle.first_point as usize..=(muscle.first_point + muscle.segments) as usize;
    let strongest = crowd.particles[own.clone()].iter().map(|p| p.spring.xyz().length()).fold(1e-12, f32::max);
    let off = |i: usize| (found.particles[i].spring - crowd.particles[i].spring).xyz().length();
    own.map(off).fold(0.0, f32::max) / strongest
}

#[test]
fn matches_its_twin_round_joints_and_bones() {
    let (mut worst, mut worst_pull) = (0.0f32, 0.0f32);
    for size in SIZES {
        for (k, options) in variants().iter().enumerate() {
            for carries in [0, 1] {
                let mut crowd = Crowd::new(size, 2, None, 71 + k as u64).wrapped(72);
                crowd.moved.iter_mut().for_each(|m| m.carries = carries);
                let params = DynamicsParams { carries, ..crowd.params(options, 0) };
                let Some(found) = played(&crowd, &params) else { return };
                crowd.predict(&params);
                let (_, off) = over(&found, &crowd);
                let pulls = (0..size).map(|m| pulls_apart(&crowd, &found, m)).fold(0.0, f32::max);
                worst = worst.max(off);
                worst_pull = worst_pull.max(pulls);
                assert!(
                    off < PREDICTED.absolute && pulls < PULLS,
                    "size {size}, variant {k}, {carries}: {off} {pulls}"
                );
            }
        }
    }
    println!("muscle_predict round obstacles: at most {worst:.2e} apart, springs {worst_pull:.2e}");
}

#[test]
fn a_larger_obstacle_is_found() {
    let mut crowd = Crowd::new(9, 1, None, 73).wrapped(74);
    let params = crowd.params(&DynamicsOptions::default(), 0);
    let Some(found) = played(&crowd, &params) else { return };
    crowd.wraps.iter_mut().for_each(|wrap| wrap.radius *= 1.05);
    crowd.predict(&params);
    let over: Vec<usize> = (0..9).filter(|&m| pulls_apart(&crowd, &found, m) > PULLS).collect();
    assert!(over.len() >= 3 && over.iter().all(|m| m % 3 > 0), "{over:?}");
}

#[test]
fn the_pipeline_for_straight_muscles_gives_the_same_bits() {
    let crowd = Crowd::new(9, 2, None, 75);
    let params = crowd.params(&DynamicsOptions::default(), 0);
    assert!(played_by(0, &crowd, &params) == played_by(1, &crowd, &params));
    let crowd = crowd.wrapped(76);
    let Some(found) = played_by(1, &crowd, &params) else { return };
    assert!(played_by(0, &crowd, &params) != Some(found), "which cannot follow a path");
}

#[test]
fn another_velocity_and_another_stiffness_are_found() {
    let mut crowd = Crowd::new(5, 1, None, 64);
    let params = crowd.params(&DynamicsOptions::default(), 0);
    let Some(found) = played(&crowd, &params) else { return };
    let first = crowd.muscles[3].first_point as usize;
    crowd.particles[first + 2].velocity.x += 1.0;
    crowd.inputs[1].stiffness += 0.1;
    crowd.predict(&params);
    let (over, _) = over(&found, &crowd);
    assert!(over.contains(&(first + 2)), "{over:?}");
    let box_of = |k: usize| crowd.particles.len() + sinew::field::muscle::axis::run(k, crowd.muscles[k].first_point);
    assert!(over.contains(&box_of(1)) && !over.contains(&box_of(0)), "{over:?}");
}

#[test]
fn another_jiggle_and_another_frequency_are_found() {
    let mut crowd = Crowd::new(5, 1, None, 66);
    let params = crowd.params(&DynamicsOptions::default(), 0);
    let Some(found) = played(&crowd, &params) else { return };
    crowd.muscles[0].jiggle -= 0.2;
    crowd.muscles[2].frequency += 1.0;
    crowd.predict(&params);
    let (over, _) = over(&found, &crowd);
    assert!(over.contains(&(crowd.muscles[0].first_point as usize)), "{over:?}");
    let box_of = |k: usize| crowd.particles.len() + sinew::field::muscle::axis::run(k, crowd.muscles[k].first_point);
    assert!(over.contains(&box_of(2)) && !over.contains(&box_of(1)), "{over:?}");
}

#[test]
fn a_muscle_without_length_or_scale_stays_finite() {
    let mut crowd = Crowd::new(4, 1, None, 65);
    for p in &mut crowd.particles {
        p.position = Vec3::ONE.extend(0.0);
    }
    for m in &mut crowd.moved {
        m.scale = 0.0;
    }
    let params = crowd.params(&DynamicsOptions::default(), 0);
    let Some(found) = played(&crowd, &params) else { return };
    crowd.predict(&params);
    for (side, particles, iterates) in
        [("GPU", &found.particles, &found.iterates), ("CPU", &crowd.particles, &crowd.iterates)]
    {
        assert!(particles.iter().all(|p| p.position.is_finite() && p.velocity.is_finite()), "{side}");
        let half = crowd.half();
        assert!(iterates[..half].iter().all(|v| v.is_finite() && v.xyz().length() < 1e3), "{side}");
    }
}
