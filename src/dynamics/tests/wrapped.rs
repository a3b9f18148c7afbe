//! Muscles that lie round a joint.

use super::*;
use crate::field::muscle::wrap::{Course, MuscleWrap, Spacing, sphere::Side};
use crate::schedule::{Contacts, DynamicsOptions};
use glam::Vec4Swizzles;
use std::f32::consts::PI;
use std::sync::Arc;

/// Radius of the joint, metres, and how far beside it the muscle passes at rest.
const RADIUS: f32 = 0.02;
const BESIDE: f32 = 0.024;

fn free() -> DynamicsOptions {
    DynamicsOptions { contacts: Contacts::NONE, retention: 1.0, fade: 0.0, ..DynamicsOptions::default() }
}

/// A muscle along Y past a hinge a third from its insertion, about Z; it lies round it where `follows`.
fn past_a_hinge(follows: bool) -> Arc<Bodies> {
    let mut bodies = muscles(&[Vec3::X * BESIDE], |_, _| (), false);
    let hinge = Vec3::Y * (LENGTH * 2.0 / 3.0);
    let (origin, insertion) = (bodies.muscles[0].origin.xyz() - hinge, bodies.muscles[0].insertion.xyz() - hinge);
    let side = Side::at_rest(origin, insertion, RADIUS, None).expect("a side");
    bodies.wraps.push(MuscleWrap {
        to_rest: Mat4::from_translation(hinge),
        side: side.axis.extend(side.swept),
        radius: RADIUS,
        rest_length: LENGTH,
        joint: 1,
        sphere: 1,
        tendon: 3,
        segments: bodies.muscles[0].segments,
        ..MuscleWrap::default()
    });
    bodies.muscles[0].wrap = follows.into();
    Arc::new(bodies)
}

/// The hinge bent by an angle, the muscle on the outer side, and all of it moved by `whole`.
fn bent(angle: f32, whole: Mat4) -> FrameInputs {
    let hinge = Vec3::Y * (LENGTH * 2.0 / 3.0);
    let turn = Mat4::from_translation(hinge) * Mat4::from_rotation_z(angle) * Mat4::from_translation(-hinge);
    inputs(&[whole, whole * turn], 1, 0.4)
}

/// Farthest that any particle is from the path, metres.
fn off(simulation: &Simulation, frame: &FrameInputs) -> f32 {
    let (muscle, wrap) = (&simulation.bodies.muscles[0], &simulation.bodies.wraps[0]);
    let [from, to] = [0, 1].map(|joint: usize| frame.joints[joint].matrix);
    let ends = (from.transform_point3(muscle.origin.xyz()), to.transform_point3(muscle.insertion.xyz()));
    let course = Course::new(wrap, &(to * wrap.to_rest), ends.0, ends.1, Spacing::Tension);
    let away = |(i, p): (u32, &Particle)| p.position.xyz().distance(course.point(i));
    (0..).zip(&simulation.particles).map(away).fold(0.0, f32::max)
}

#[test]
fn an_axis_rests_on_its_path() {
    for angle in [0.0, 0.5, 1.4, 2.2] {
        let rests = |follows| {
            let mut simulation = Simulation::new(past_a_hinge(follows));
            let frame = bent(angle, Mat4::IDENTITY);
            for k in 0..=30 {
                simulation.advance(NO_SKIN, &frame, f64::from(k) / 30.0, &free());
            }
            off(&simulation, &frame)
        };
        let (with, without) = (rests(true), rests(false));
        println!("bent by {angle}: {with} m off its path, {without} m without");
        assert!(with < 2e-6, "{angle}: {with}");
        assert!(angle == 0.0 || without > 2e-3, "{angle}: a straight axis must be seen: {without}");
    }
}

/// Without inertia it is carried along the path and nothing else.
#[test]
fn a_quick_bend_leaves_the_axis_on_its_path() {
    let options = DynamicsOptions { retention: 0.0, ..free() };
    for whole in [Mat4::IDENTITY, Mat4::from_rotation_translation(glam::Quat::from_rotation_x(0.7), Vec3::ONE)] {
        let played = |follows| {
            let mut simulation = Simulation::new(past_a_hinge(follows));
            let mut most = 0.0f32;
            for k in 0..=16 {
                let share = k as f32 / 16.0;
                let frame = bent(2.2 * share, Mat4::from_translation(whole.w_axis.xyz() * share) * whole);
                simulation.advance(NO_SKIN, &frame, f64::from(k) / 60.0, &options);
                most = most.max(off(&simulation, &frame));
            }
            most
        };
        let (with, without) = (played(true), played(false));
        println!("{with} m off its path, {without} m without");
        assert!(with < 2e-5 && without > 0.01, "{with} {without}");
    }
}

/// Seconds until a muscle that was pulled along the hinge's axis first crosses its path.
fn quarter(angle: f32) -> f32 {
    let mut simulation = Simulation::new(past_a_hinge(true));
    let frame = bent(angle, Mat4::IDENTITY);
    simulation.advance(NO_SKIN, &frame, 0.0, &free());
    for (i, particle) in simulation.particles.iter_mut().enumerate() {
        particle.position.z += 0.01 * (PI * i as f32 / 29.0).sin();
    }
    let mut before = 0.01;
    for k in 1..240 {
        simulation.advance(NO_SKIN, &frame, f64::from(k) / 240.0, &free());
        let now = simulation.particles[14].position.z;
        if now <= 0.0 {
            return (k as f32 + now / (before - now)) / 240.0;
        }
        before = now;
    }
    f32::INFINITY
}

#[test]
fn it_swings_about_its_path_as_about_a_chord() {
    let straight = quarter(0.0);
    // A quarter of 12 Hz, a fifth late as every muscle is; the path of the bent one is longer by a tenth, and so its tension.
    assert!((0.15..0.25).contains(&(straight * 4.0 * 12.0 - 1.0)), "{straight}");
    let bent = quarter(1.4);
    println!("a quarter period is {straight} s straight, {bent} s bent");
    assert!((bent / straight - 1.0).abs() < 0.08, "{straight} {bent}");
}
