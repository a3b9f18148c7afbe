//! Muscles without contacts.

use super::*;
use crate::schedule::{Contacts, DynamicsOptions, Solver};
use glam::{DVec3, Vec4Swizzles};
use std::f32::consts::PI;
use std::sync::Arc;

fn free() -> DynamicsOptions {
    DynamicsOptions { contacts: Contacts::NONE, retention: 1.0, settle: 0.0, fade: 0.0, ..DynamicsOptions::default() }
}

fn still(stiffness: f32) -> FrameInputs {
    inputs(&[Mat4::IDENTITY; 2], 1, stiffness)
}

/// A muscle that stands still at time 0, pulled aside by `amount` metres times a half sine.
fn plucked(tendon: f32, amount: f32, options: &DynamicsOptions) -> Simulation {
    let bodies = muscles(&[Vec3::ZERO], |_, spec| spec.tendon = tendon, false);
    let mut simulation = Simulation::new(Arc::new(bodies));
    simulation.advance(NO_SKIN, &still(0.4), 0.0, options);
    let last = simulation.particles.len() - 1;
    for (i, particle) in simulation.particles.iter_mut().enumerate() {
        particle.position.x += amount * (PI * i as f32 / last as f32).sin();
    }
    simulation
}

/// Seconds until the middle first crosses its place at rest, seen at `fps` frames a second.
fn quarter(fps: f64, tendon: f32, stiffness: f32, options: &DynamicsOptions) -> f64 {
    let mut simulation = plucked(tendon, 0.01, options);
    let frame = still(stiffness);
    let (mut frames, mut before) = (0.0, 0.01f64);
    loop {
        frames += 1.0;
        simulation.advance(NO_SKIN, &frame, frames / fps, options);
        let middle = simulation.particles[14..16].iter().map(|p| f64::from(p.position.x)).sum::<f64>() / 2.0;
        if middle <= 0.0 {
            return (frames - -middle / (before - middle)) / fps;
        }
        before = middle;
        assert!(frames < 4.0 * fps, "it never came back");
    }
}

#[test]
fn the_first_quarter_period_is_that_of_a_string() {
    for frequency in [6.0f32, 12.0, 24.0] {
        let options = DynamicsOptions { frequency, ..free() };
        let error = quarter(240.0, 0.1, 0.4, &options) * 4.0 * f64::from(frequency) - 1.0;
        println!("a quarter period at {frequency} Hz is {:.1} % late", 100.0 * error);
        // Masses are heavier in the middle than a string's.
        assert!((0.15..0.25).contains(&error), "{frequency} Hz: {error}");
    }
    let error = quarter(240.0, 0.1, 0.7, &free()) * 4.0 * 12.0 - 1.0;
    assert!(error < -0.25, "a stiffer muscle is quicker: {error}");
}

#[test]
fn frame_rates_agree_to_the_bit() {
    let run = |fps: u32| {
        let mut simulation = plucked(0.1, 0.01, &free());
        let frame = still(0.4);
        for k in 1..=fps / 2 {
            simulation.advance(NO_SKIN, &frame, f64::from(k) / f64::from(fps), &free());
        }
        simulation.particles
    };
    let reference = run(240);
    for fps in [24, 30, 60, 120] {
        assert_eq!(run(fps), reference, "{fps}");
    }
    assert_ne!(run(48), plucked(0.1, 0.01, &free()).particles, "it has moved");
}

#[test]
fn the_papers_period_is_proportional_to_the_time_step() {
    let pbd = |rate| DynamicsOptions {
        rate,
        contacts: Contacts::NONE,
        retention: 1.0,
        settle: 0.0,
        fade: 0.0,
        ..DynamicsOptions::pbd()
    };
    let period = |rate: u32| quarter(f64::from(rate), 0.0, 0.4, &pbd(rate));
    let (slow, middle, quick) = (period(60), period(120), period(240));
    assert!((slow / middle - 2.0).abs() < 0.02 && (middle / quick - 2.0).abs() < 0.02, "{slow} {middle} {quick}");
    let compliant = |rate: u32| quarter(f64::from(rate), 0.0, 0.4, &DynamicsOptions { rate, ..free() });
    assert!((compliant(120) / compliant(240) - 1.0).abs() < 0.05, "compliance has hardly any of that");
}

#[test]
fn jacobi_is_gauss_seidel_by_the_matching_rule() {
    // n_Jacobi = n_GS (2 / omega) / (1 - k / 2), background 4.5.
    for k in [0.1f32, 0.4, 0.7] {
        let base = DynamicsOptions {
            contacts: Contacts::NONE,
            retention: 1.0,
            settle: 0.0,
            fade: 0.0,
            ..DynamicsOptions::pbd()
        };
        let sweeps =
            15.0 * (2.0 / (2.0 * f64::from(crate::dynamics::chain::JACOBI_SHARE))) / (1.0 - f64::from(k) / 2.0);
        let red_black = quarter(60.0, 0.0, k, &base);
        let jacobi = |inner| quarter(60.0, 0.0, k, &DynamicsOptions { solver: Solver::Jacobi, inner, ..base });
        let error = jacobi(sweeps.round() as u32) / red_black - 1.0;
        assert!(error.abs() < 0.05, "k = {k}: {error}");
        assert!(jacobi(15) / red_black > 1.15, "as many sweeps are softer");
    }
}

/// Stiffness of a spring between the tendons, N/m, of a muscle whose swing is at the frequency of the options: that of a
/// string with as much mass and tension, made up for the lag of an implicit step.
fn stiffness(simulation: &Simulation, options: &DynamicsOptions) -> f64 {
    let muscle = &simulation.bodies.muscles[0];
    let (mass, segments) = (f64::from(muscle.insertion.w), f64::from(muscle.segments));
    let phase = std::f64::consts::TAU * f64::from(options.frequency) * f64::from(options.seconds());
    4.0 * mass * (f64::from(options.frequency) * phase.tan() / phase).powi(2) * segments / 0.98
}

/// One substep by alternating directions and a direct solve of the tridiagonal system for the positions, in f64.
fn direct(simulation: &Simulation, options: &DynamicsOptions) -> Vec<DVec3> {
    let own = &simulation.particles;
    let n = own.len() - 1;
    let h = f64::from(options.seconds());
    let stiffness = stiffness(simulation, options);
    let spring = |j: usize| stiffness * h * h * f64::from(own[j].traits.y);
    let start: Vec<DVec3> =
        own.iter().map(|p| (p.position.xyz() + p.velocity.xyz() * options.seconds()).as_dvec3()).collect();
    let mut at = start.clone();
    for _ in 0..400 {
        let rest: Vec<DVec3> = (0..n).map(|j| (at[j + 1] - at[j]).normalize() * f64::from(own[j].spring.w)).collect();
        let (mut upper, mut right) = (vec![0.0; n], vec![DVec3::ZERO; n]);
        for i in 1..n {
            let m = 1.0 / f64::from(own[i].velocity.w);
            let (below, above) = (spring(i - 1), spring(i));
            let mut value = start[i] * m + rest[i - 1] * below - rest[i] * above;
            let mut diagonal = m + below + above;
            if i == 1 {
                value += at[0] * below;
            } else {
                diagonal += below * upper[i - 1];
                value += right[i - 1] * below;
            }
            value += if i == n - 1 { at[n] * above } else { DVec3::ZERO };
            upper[i] = -above / diagonal;
            right[i] = value / diagonal;
        }
        for i in (1..n).rev() {
            at[i] = if i == n - 1 { right[i] } else { right[i] - at[i + 1] * upper[i] };
        }
    }
    at
}

#[test]
fn a_substep_is_that_of_a_direct_solve() {
    // Shares of what the muscle was plucked by: sixteen sweeps end nearer to the solution where it is looser.
    for (frequency, tolerance) in [(6.0, 5e-4), (12.0, 2e-3), (24.0, 2e-2)] {
        let options = DynamicsOptions { frequency, ..free() };
        let mut simulation = plucked(0.1, 0.01, &options);
        let mut most = 0.0f64;
        for step in 1..=20 {
            let expected = direct(&simulation, &options);
            let before: Vec<DVec3> = simulation.particles.iter().map(|p| p.position.xyz().as_dvec3()).collect();
            simulation.advance(NO_SKIN, &still(0.4), f64::from(step) / 240.0, &options);
            let farthest = |from: &[DVec3]| {
                let pairs = simulation.particles.iter().zip(from);
                pairs.map(|(p, q)| p.position.xyz().as_dvec3().distance(*q)).fold(0.0, f64::max)
            };
            let error = farthest(&expected);
            assert!(error < tolerance * 0.01, "{frequency} Hz, step {step}: {error} m");
            most = most.max(farthest(&before));
        }
        assert!(most > 5.0 * tolerance * 0.01, "standing still would be found: {most}");
    }
}

/// Kinetic and elastic energy, joules.
fn energy(simulation: &Simulation, options: &DynamicsOptions) -> f64 {
    let own = &simulation.particles;
    let n = own.len() - 1;
    let stiffness = stiffness(simulation, options);
    let kinetic: f64 =
        own[1..n].iter().map(|p| 0.5 / f64::from(p.velocity.w) * p.velocity.xyz().as_dvec3().length_squared()).sum();
    let elastic: f64 = (0..n)
        .map(|j| {
            let length = own[j + 1].position.xyz().as_dvec3().distance(own[j].position.xyz().as_dvec3());
            0.5 * stiffness * f64::from(own[j].traits.y) * (length - f64::from(own[j].spring.w)).powi(2)
        })
        .sum();
    kinetic + elastic
}

#[test]
fn a_released_muscle_never_gains_energy() {
    for frequency in [6.0, 12.0, 24.0] {
        let options = DynamicsOptions { frequency, ..free() };
        let at_rest = energy(&plucked(0.1, 0.0, &options), &options);
        let mut simulation = plucked(0.1, 0.03, &options);
        let mut before = energy(&simulation, &options);
        let start = before - at_rest;
        for step in 1..=480 {
            simulation.advance(NO_SKIN, &still(0.4), f64::from(step) / 240.0, &options);
            let now = energy(&simulation, &options);
            assert!(now - before <= 1e-4 * now, "{frequency} Hz, step {step}: {before} to {now}");
            // Stricter than asked for: of what it was plucked by, not of all its tension.
            assert!(now - before <= 1e-3 * start, "{frequency} Hz, step {step}: {before} to {now} of {start}");
            before = now;
        }
        assert!(before - at_rest < 0.02 * start, "it comes to rest");
    }
}

#[test]
fn a_muscle_follows_its_bones_without_lag() {
    let options = DynamicsOptions { contacts: Contacts::NONE, ..DynamicsOptions::default() };
    let bodies = Arc::new(muscles(&[Vec3::ZERO], |_, _| (), false));
    let mut simulation = Simulation::new(bodies);
    for frame in 0..90 {
        let time = f64::from(frame) / 30.0;
        let moved = Mat4::from_translation(Vec3::X * 3.0 * time as f32);
        simulation.advance(NO_SKIN, &inputs(&[moved; 2], 1, 0.4), time, &options);
    }
    let middle = simulation.particles[15].position.x - simulation.particles[0].position.x;
    assert!(middle.abs() < 3e-4, "3 m/s leaves it {middle} m behind");
}
