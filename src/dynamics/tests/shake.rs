//! What a shake of the arm does to muscles of several stiffnesses.

use super::arm::{Actor, one_by_one};
use super::*;
use crate::schedule::{Contacts, DynamicsOptions};
use glam::Vec4Swizzles;
use std::sync::Arc;

/// When the arm of `arm_shake` stops, seconds, from one sixtieth of a second to the next, and how long it is watched.
const STOPS: f64 = 1.5;
const ENDS: f64 = 4.0;

/// The swing of the bellies, metres and seconds.
#[derive(Debug)]
struct Swing {
    /// Farthest that any particle is, while the arm shakes, from where it would be without inertia.
    excursion: f32,
    /// Farthest that it is after the stop from where it comes to rest, and farthest on the far side of that.
    after: f32,
    overshoot: f32,
    /// From the stop until no particle is farther from its place of rest than 5 % of the excursion.
    settles: f64,
    /// Farthest that a place of rest is from where it would be without inertia.
    elsewhere: f32,
}

/// Positions of all particles in every substep of the shake.
fn shaken(arm: &Actor, options: &DynamicsOptions) -> Vec<Vec<Vec3>> {
    let mut simulation = Simulation::new(Arc::clone(&arm.bodies));
    let step = |k: u32| {
        let time = f64::from(k) / 240.0;
        arm.frame(&mut simulation, &arm.inputs("arm_shake", time.min(STOPS), None), time, options);
        simulation.particles.iter().map(|p| p.position.xyz()).collect()
    };
    (0..=(ENDS * 240.0) as u32).map(step).collect()
}

/// From each of `from`'s points to each of `to`'s.
fn offsets(from: &[Vec3], to: &[Vec3]) -> Vec<Vec3> {
    from.iter().zip(to).map(|(p, q)| *q - *p).collect()
}

fn most(offsets: &[Vec3]) -> f32 {
    offsets.iter().map(|o| o.length()).fold(0.0, f32::max)
}

fn swing(arm: &Actor, options: &DynamicsOptions) -> Swing {
    let found = shaken(arm, options);
    // What no velocity outlives a substep of has no inertia.
    let still = shaken(arm, &DynamicsOptions { retention: 0.0, ..*options });
    let (stop, end) = ((STOPS * 240.0) as usize, found.len() - 1);
    let excursion = (0..stop).map(|k| most(&offsets(&still[k], &found[k]))).fold(0.0, f32::max);
    let off: Vec<Vec<Vec3>> = found[stop..].iter().map(|at| offsets(&found[end], at)).collect();
    let back = (0..found[0].len()).flat_map(|i| {
        let side = off[0][i].normalize_or_zero();
        off.iter().map(move |o| -o[i].dot(side))
    });
    Swing {
        excursion,
        after: off.iter().map(|o| most(o)).fold(0.0, f32::max),
        overshoot: back.fold(0.0, f32::max),
        settles: off.iter().rposition(|o| most(o) > 0.05 * excursion).unwrap_or(0) as f64 / 240.0,
        elsewhere: most(&offsets(&still[end], &found[end])),
    }
}

#[test]
fn a_shake_dies_away() {
    let Some(arm) = Actor::arm(Some(""), &[]) else { return };
    // Frequency, excursion and settling time at most.
    for (frequency, excursion, settles) in [(6.0f32, 0.1, 0.6), (12.0, 0.04, 0.3), (24.0, 0.011, 0.1)] {
        for contacts in [Contacts::NONE, one_by_one().contacts] {
            let options = DynamicsOptions { frequency, contacts, ..one_by_one() };
            let found = swing(&arm, &options);
            println!("arm_shake at {frequency} Hz, bones {}, skin {}: {found:?}", contacts.bones, contacts.skin);
            assert!(found.excursion < excursion && found.settles < settles, "{frequency} Hz: {found:?}");
            assert!(found.overshoot < found.after && found.after < excursion, "{frequency} Hz: {found:?}");
            assert!(found.elsewhere < 1e-4, "{frequency} Hz: no muscle is left on the other side of a bone: {found:?}");
        }
    }
    let undamped = DynamicsOptions { retention: 1.0, frequency: 6.0, contacts: Contacts::NONE, ..one_by_one() };
    let undamped = swing(&arm, &undamped);
    assert!(undamped.settles > 0.6, "without damping it goes on: {undamped:?}");
}
