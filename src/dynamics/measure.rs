//! What muscles in motion fall short of: how deep their particles are in what was to keep them out, and how far their
//! springs are from balance. Nothing here moves anything.

use super::{
    BONES, Bodies, Link, MUSCLES, MovedJoint, MuscleBody, Particle, SKIN, StepClock, Surroundings, joints,
    simulation::Skins,
};
use crate::{field::muscle::axis::run, rig::JointFrame, schedule::Mode};
use glam::{Vec3, Vec4, Vec4Swizzles};

/// How deep a particle is in what was to keep it out, metres; 0 where it is clear of it, in tendons, at the ends, and
/// where its muscle does not collide with such things at all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Depth {
    /// Radius of the sphere that collides: the muscle's mean radius there.
    pub radius: f32,
    /// Depth of the sphere in the bone that it is deepest in.
    pub bone: f32,
    /// Depth of the sphere in the other muscle that it is deepest in.
    pub muscle: f32,
    /// Distance of the particle itself from the skin, outward.
    pub outside: f32,
}

impl Depth {
    /// The largest of the three, as a share of the radius.
    pub fn share(&self) -> f32 {
        self.bone.max(self.muscle).max(self.outside) / self.radius.max(1e-9)
    }
}

/// Depths of all particles of an instance, at a frame whose joints are `joints`. `iterates` is the first half of the
/// instance's, as the frame left it ([`half`](crate::field::muscle::axis::half)).
///
/// It is measured whether the contacts were on or not, so that it also says what they would have to do.
pub fn depths(bodies: &Bodies, skins: Skins, joints: &[JointFrame], iterates: &[Vec4]) -> Vec<Depth> {
    let moved = standing(joints);
    let around = Surroundings {
        muscles: &bodies.muscles,
        bones: &bodies.bones,
        links: &bodies.links,
        moved: &moved,
        grids: skins.grids,
        nodes: skins.nodes,
        iterates,
    };
    let mut found = Vec::with_capacity(bodies.particles_rest.len());
    for (index, muscle) in bodies.muscles.iter().enumerate() {
        let own = &bodies.particles_rest[muscle.first_point as usize..][..=muscle.segments as usize];
        let at = &iterates[run(index, muscle.first_point) + 2..];
        let ends = (at[0].xyz(), at[2 * muscle.segments as usize].xyz());
        found.extend(own.iter().enumerate().map(|(i, particle)| {
            let (place, share) = (at[2 * i], i as f32 / muscle.segments as f32);
            let free = particle.velocity.w > 0.0 && particle.traits.x >= 1.0;
            let refuge = ends.0.lerp(ends.1, share);
            if free {
                depth(&around, muscle, place, share, refuge)
            } else {
                Depth { radius: place.w, ..Depth::default() }
            }
        }));
    }
    found
}

/// One particle's, outside the tendons; `place` is its position with its radius in `w`.
fn depth(around: &Surroundings, muscle: &MuscleBody, place: Vec4, share: f32, refuge: Vec3) -> Depth {
    let (p, radius) = (place.xyz(), place.w);
    let links = |kind: u32, from: u32, to: u32| {
        let on = muscle.collides & kind != 0;
        if on { &around.links[from as usize..to as usize] } else { &[] }
    };
    let deepest =
        |links: &[Link], distance: &dyn Fn(&Link) -> f32| links.iter().map(|link| -distance(link)).fold(0.0, f32::max);
    let bones = links(BONES, muscle.bones_begin, muscle.peers_begin);
    let peers = links(MUSCLES, muscle.peers_begin, muscle.skins_begin);
    let within = links(SKIN, muscle.skins_begin, muscle.links_end);
    Depth {
        radius,
        bone: deepest(bones, &|link| around.bone(link, p, radius, 1.0, share).distance),
        muscle: deepest(peers, &|link| around.muscle(link, p, radius).distance),
        outside: if within.is_empty() { 0.0 } else { (-around.skin(within, p, refuge).distance).max(0.0) },
    }
}

/// Largest error of a muscle's segments over their length, as the last substep left them, contacts' last word included: how
/// far a stretch is from the one under which the spring would pull as its multiplier says. 0 is the exact implicit step. In
/// `pbd` mode, which knows no pull, only tendons count: no place of the particles gives the muscle's own segments their rest
/// length.
///
/// `particles` and `iterates` are those of the whole instance, the latter as for [`depths`].
pub fn elastic(
    bodies: &Bodies,
    index: usize,
    joints: &[JointFrame],
    particles: &[Particle],
    iterates: &[Vec4],
    mode: Mode,
) -> f32 {
    let muscle = &bodies.muscles[index];
    let own = &particles[muscle.first_point as usize..][..=muscle.segments as usize];
    let softness = iterates[run(index, muscle.first_point)].w;
    let scale = standing(&joints[muscle.driver as usize..][..1])[0].scale;
    let one = |pair: &[Particle]| {
        let span = pair[1].position.xyz() - pair[0].position.xyz();
        let (length, rest, stiffer) = (span.length().max(1e-9), pair[0].spring.w * scale, pair[0].traits.y);
        let stretch = span * ((length - rest) / length);
        match mode {
            Mode::Xpbd => (stretch + pair[0].spring.xyz() * (softness / stiffer)).length() / length,
            Mode::Pbd if stiffer > 1.0 => stretch.length() / length,
            Mode::Pbd => 0.0,
        }
    };
    own.windows(2).map(one).fold(0.0, f32::max)
}

/// Joints that stand still.
fn standing(joints: &[JointFrame]) -> Vec<MovedJoint> {
    let mut moved = vec![MovedJoint::default(); joints.len()];
    joints::step(&StepClock::default(), true, &[joints, joints].concat(), &mut moved);
    moved
}
