//! Muscles without contacts.

use super::*;
use crate::schedule::{Contacts, DynamicsOptions, Mode, Solver};
use glam::Vec4Swizzles;

fn options() -> DynamicsOptions {
    DynamicsOptions { contacts: Contacts::NONE, retention: 1.0, settle: 0.0, fade: 0.0, ..DynamicsOptions::default() }
}

/// A muscle that stands still, pulled aside as a half sine by 10 mm, after its first frame.
fn plucked(tendon: f32, options: &DynamicsOptions) -> Simulation {
    let bodies = muscles(&[Vec3::ZERO], |_, spec| spec.tendon = tendon, false);
    let mut simulation = Simulation::new(std::sync::Arc::new(bodies));
    simulation.advance(NO_SKIN, &inputs(&[Mat4::IDENTITY; 2], 1, 0.4), 0.0, options);
    let last = simulation.particles.len() - 1;
    for (i, particle) in simulation.particles.iter_mut().enumerate() {
        let share = i as f32 / last as f32;
        particle.position.x += 0.01 * (std::f32::consts::PI * share).sin();
    }
    simulation
}

/// Seconds until the middle first crosses its place at rest.
fn quarter(fps: f64, tendon: f32, stiffness: f32, options: &DynamicsOptions) -> f64 {
    let mut simulation = plucked(tendon, options);
    let frame = inputs(&[Mat4::IDENTITY; 2], 1, stiffness);
    let (mut time, mut before) = (0.0, 0.01f64);
    loop {
        time += 1.0 / fps;
        simulation.advance(NO_SKIN, &frame, time, options);
        let middle =
            (f64::from(simulation.particles[14].position.x) + f64::from(simulation.particles[15].position.x)) / 2.0;
        if middle <= 0.0 {
            return time - (1.0 / fps) * -middle / (before - middle);
        }
        before = middle;
        assert!(time < 4.0, "it never came back");
    }
}

#[test]
fn explore() {
    for f in [6.0, 12.0, 24.0] {
        for (inner, outer) in [(8, 2), (15, 1), (60, 2)] {
            let o = DynamicsOptions { frequency: f, inner, outer, ..options() };
            let q = quarter(240.0, 0.0, 0.4, &o);
            println!(
                "f {f} inner {inner} outer {outer}: quarter {q:.5} analytic {:.5} ratio {:.3}; tendons {:.3}; jacobi {:.3}",
                0.25 / f,
                q * 4.0 * f64::from(f),
                quarter(240.0, 0.1, 0.4, &o) * 4.0 * f64::from(f),
                quarter(240.0, 0.0, 0.4, &DynamicsOptions { solver: Solver::Jacobi, ..o }) * 4.0 * f64::from(f)
            );
        }
    }
    for rate in [60, 120, 240] {
        let o = DynamicsOptions {
            rate,
            retention: 1.0,
            settle: 0.0,
            fade: 0.0,
            contacts: Contacts::NONE,
            ..DynamicsOptions::pbd()
        };
        println!(
            "pbd rate {rate}: {:.4} jacobi {:.4}",
            quarter(rate.into(), 0.0, 0.4, &o),
            quarter(rate.into(), 0.0, 0.4, &DynamicsOptions { solver: Solver::Jacobi, ..o })
        );
    }
    for fps in [24.0, 30.0, 60.0, 120.0] {
        println!("fps {fps} {:.5}", quarter(fps, 0.1, 0.4, &options()));
    }
    let _ = Mode::Pbd;
    let mut s = plucked(0.1, &options());
    let frame = inputs(&[Mat4::IDENTITY; 2], 1, 0.4);
    for k in 0..40 {
        s.advance(NO_SKIN, &frame, (k + 1) as f64 / 240.0, &options());
        println!("{} {:?}", k, s.particles[15].position.xyz());
    }
}
