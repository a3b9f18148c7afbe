//! What is measured of muscles in motion, against closed forms.

use super::*;
use crate::field::{GroupGrid, muscle::axis::half};
use crate::schedule::{Contacts, DynamicsOptions, Mode};
use std::sync::Arc;

/// Two round muscles side by side with a bone along the first one, `apart` metres of it, and both in a flat skin of which
/// they are `inside` metres. Nothing pushes them out of anything.
fn crowd(apart: f32, inside: f32, change: impl Fn(usize, &mut MuscleSpec)) -> (Simulation, Vec<Depth>) {
    let mut bodies = muscles(&[Vec3::ZERO, Vec3::Z * 0.03], |i, spec| change(i, spec), true);
    bodies.bones.push(BoneRest {
        start: Vec3::new(apart, -1.0, 0.0).extend(0.01),
        end: Vec3::new(apart, 1.0, 0.0).extend(0.0),
        ..BoneRest::default()
    });
    // Links as a rig has them, muscle by muscle: bones, muscles, skins.
    let mut links = Vec::new();
    for (index, muscle) in bodies.muscles.iter_mut().enumerate() {
        muscle.bones_begin = links.len() as u32;
        links.extend((index == 0).then(Link::default));
        muscle.peers_begin = links.len() as u32;
        links.push(Link { index: 1 - index as u32, ..Link::default() });
        muscle.skins_begin = links.len() as u32;
        links.push(Link::default());
        muscle.links_end = links.len() as u32;
    }
    bodies.links = links;
    // One cell of two metres, in which the distance grows with x.
    let grid = GroupGrid {
        rest_to_grid: Mat4::from_scale(Vec3::splat(0.5)) * Mat4::from_translation(Vec3::ONE),
        size_x: 2,
        size_y: 2,
        size_z: 2,
        ..GroupGrid::default()
    };
    let nodes: Vec<Vec4> = (0..8).map(|k| Vec3::X.extend(if k % 2 == 0 { -1.0 } else { 1.0 } - inside)).collect();
    let mut simulation = Simulation::new(Arc::new(bodies));
    let skins = Skins { grids: &[grid], nodes: &nodes };
    let options = DynamicsOptions { contacts: Contacts::NONE, ..DynamicsOptions::default() };
    let inputs = inputs(&[Mat4::IDENTITY; 2], 2, 0.4);
    simulation.advance(skins, &inputs, 0.0, &options);
    let half = half(2, simulation.particles.len() as u32);
    let found = depths(&simulation.bodies, skins, &inputs.joints, &simulation.iterates[..half]);
    (simulation, found)
}

/// The middle of the first muscle, thickest and level.
const MIDDLE: usize = 15;

fn even(_: usize, spec: &mut MuscleSpec) {
    spec.segments = 30;
}

#[test]
fn depths_are_those_of_spheres_in_bones_muscles_and_skin() {
    let (simulation, found) = crowd(0.025, -0.004, even);
    let radius = Profile::of(3, 3).at(0.5).0 * WIDTH;
    let middle = found[MIDDLE];
    let expected = Depth { radius, bone: radius + 0.01 - 0.025, muscle: 2.0 * radius - 0.03, outside: 0.004 };
    let off = |a: Depth, b: Depth| {
        let pairs = [(a.radius, b.radius), (a.bone, b.bone), (a.muscle, b.muscle), (a.outside, b.outside)];
        pairs.iter().map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    assert!(expected.bone > 5e-3 && expected.muscle > 5e-3, "{expected:?}");
    assert!(off(middle, expected) < 1e-6, "{middle:?} {expected:?}");
    assert!((middle.share() - expected.muscle / radius).abs() < 1e-4, "{middle:?}");
    let (_, further) = crowd(0.026, -0.004, even);
    assert!((off(further[MIDDLE], expected) - 1e-3).abs() < 1e-6, "a bone a millimetre further away must be seen");
    // Tendons and ends have no depths, nor has what is clear of everything.
    let spared = simulation.particles.iter().zip(&found).filter(|(p, _)| p.traits.x < 1.0 || p.velocity.w == 0.0);
    assert!(spared.clone().count() > 4 && spared.clone().all(|(_, depth)| depth.share() == 0.0));
    let (_, clear) = crowd(0.5, 0.1, even);
    assert!(clear[MIDDLE].bone == 0.0 && clear[MIDDLE].outside == 0.0, "{:?}", clear[MIDDLE]);
}

#[test]
fn what_a_muscle_may_pass_through_has_no_depth() {
    let (_, found) = crowd(0.025, -0.004, |index, spec| {
        even(index, spec);
        (spec.collides.bones, spec.collides.skin) = (false, false);
    });
    let middle = found[MIDDLE];
    assert!(middle.bone == 0.0 && middle.outside == 0.0 && middle.muscle > 5e-3, "{middle:?}");
}

#[test]
fn springs_in_balance_have_no_violation() {
    let (mut simulation, _) = crowd(0.5, 0.1, even);
    let joints = inputs(&[Mat4::IDENTITY; 2], 2, 0.4).joints;
    let (bodies, compliance) = (Arc::clone(&simulation.bodies), simulation.iterates[0].w);
    let length = LENGTH / 30.0;
    for (i, particle) in simulation.particles.iter_mut().enumerate().take(31) {
        particle.position = Vec3::new(0.0, length * i as f32, 0.0).extend(particle.position.w);
        let pull = (length - particle.spring.w) * particle.traits.y / compliance;
        particle.spring = Vec3::new(0.0, -pull, 0.0).extend(particle.spring.w);
    }
    let found = |s: &Simulation| elastic(&bodies, 0, &joints, &s.particles, &s.iterates, Mode::Xpbd);
    assert!(found(&simulation) < 1e-5, "{}", found(&simulation));
    // Nine tenths of the pull: a tenth of the stretch, which is .98 of the segment's length.
    let spring = &mut simulation.particles[MIDDLE].spring;
    spring.y *= 0.9;
    assert!((found(&simulation) - 0.098).abs() < 1e-5, "{}", found(&simulation));
}
