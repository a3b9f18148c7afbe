//! What the constraints lack at the end of a frame: how good the solver's solution is.

use super::{MovedJoint, MuscleBody, Particle, Simulation, Skins, StepClock, Surroundings, joints};
use crate::{
    field::muscle::axis::{half, run},
    rig::{FrameInputs, JointFrame},
    schedule::{DynamicsOptions, Mode},
};
use glam::Vec4Swizzles;

/// What one muscle's constraints lack. Contacts count outside the tendons, and whether or not they are on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Largest error of a segment over its length: how far its stretch is from what its pull says. In `pbd` mode, which
    /// knows no pull, only tendons count: no place of the particles gives the muscle's own segments their rest length.
    pub elastic: f32,
    /// Deepest in a bone, metres.
    pub bone: f32,
    /// Deepest in another muscle, metres.
    pub muscle: f32,
    /// Farthest outside the skin, metres.
    pub skin: f32,
}

impl Residual {
    /// The worse of two, in everything.
    pub fn worse(self, other: Residual) -> Residual {
        Residual {
            elastic: self.elastic.max(other.elastic),
            bone: self.bone.max(other.bone),
            muscle: self.muscle.max(other.muscle),
            skin: self.skin.max(other.skin),
        }
    }

    /// Deepest in anything, metres.
    pub fn depth(&self) -> f32 {
        self.bone.max(self.muscle).max(self.skin)
    }
}

/// Every muscle's residual in the frame that `simulation` was advanced to last, with its inputs. Elastic ones are those of
/// the last substep where the frame ends with it.
pub fn residuals(
    simulation: &Simulation,
    skins: Skins,
    inputs: &FrameInputs,
    options: &DynamicsOptions,
) -> Vec<Residual> {
    let bodies = &*simulation.bodies;
    let mut moved = vec![MovedJoint::default(); inputs.joints.len()];
    let joints: Vec<JointFrame> = [&inputs.joints[..], &inputs.joints].concat();
    joints::step(&StepClock::default(), true, &joints, &mut moved);
    let around = Surroundings {
        muscles: &bodies.muscles,
        bones: &bodies.bones,
        links: &bodies.links,
        moved: &moved,
        grids: skins.grids,
        nodes: skins.nodes,
        iterates: &simulation.iterates[..half(bodies.muscles.len() as u32, simulation.particles.len() as u32)],
    };
    let of = |(index, muscle): (usize, &MuscleBody)| {
        let own = &simulation.particles[muscle.first_point as usize..][..=muscle.segments as usize];
        let softness = around.iterates[run(index, muscle.first_point)].w;
        let elastic = elastic(own, softness, moved[muscle.driver as usize].scale, options.mode);
        contacts(&around, muscle, own).worse(Residual { elastic, ..Residual::default() })
    };
    bodies.muscles.iter().enumerate().map(of).collect()
}

fn elastic(own: &[Particle], softness: f32, scale: f32, mode: Mode) -> f32 {
    let of = |pair: &[Particle]| {
        let span = pair[1].position.xyz() - pair[0].position.xyz();
        let (length, rest, stiffer) = (span.length().max(1e-9), pair[0].spring.w * scale, pair[0].traits.y);
        let stretch = span * ((length - rest) / length);
        match mode {
            Mode::Xpbd => (stretch + pair[0].spring.xyz() * (softness / stiffer)).length() / length,
            Mode::Pbd if stiffer > 1.0 => stretch.length() / length,
            Mode::Pbd => 0.0,
        }
    };
    own.windows(2).map(of).fold(0.0, f32::max)
}

fn contacts(around: &Surroundings, muscle: &MuscleBody, own: &[Particle]) -> Residual {
    let links = |from: u32, to: u32| &around.links[from as usize..to as usize];
    let mut worst = Residual::default();
    let ends = (own[0].position.xyz(), own[own.len() - 1].position.xyz());
    for (i, particle) in own.iter().enumerate().filter(|(_, p)| p.traits.x >= 1.0) {
        let (p, radius) = (particle.position.xyz(), particle.position.w);
        let share = i as f32 / muscle.segments as f32;
        let deepest = |depth: f32, distance: f32| depth.max(-distance);
        let bones = links(muscle.bones_begin, muscle.peers_begin).iter();
        let peers = links(muscle.peers_begin, muscle.skins_begin).iter();
        let skins = links(muscle.skins_begin, muscle.links_end);
        worst.bone = bones.map(|l| around.bone(l, p, radius, 1.0, share).distance).fold(worst.bone, deepest);
        worst.muscle = peers.map(|l| around.muscle(l, p, radius).distance).fold(worst.muscle, deepest);
        if !skins.is_empty() {
            worst.skin = deepest(worst.skin, around.skin(skins, p, ends.0.lerp(ends.1, share)).distance);
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::super::tests::{NO_SKIN, inputs, muscles};
    use super::*;
    use crate::schedule::Contacts;
    use glam::{Mat4, Vec3};
    use std::sync::Arc;

    /// The residual of one of two muscles side by side, plucked and left alone for a while.
    fn plucked(options: &DynamicsOptions, apart: f32) -> Residual {
        let bodies = muscles(&[Vec3::ZERO, Vec3::X * apart], |_, _| (), true);
        let mut simulation = Simulation::new(Arc::new(bodies));
        let frame = inputs(&[Mat4::IDENTITY; 2], 2, 0.4);
        simulation.advance(NO_SKIN, &frame, 0.0, options);
        simulation.particles[15].position.z += 0.01;
        simulation.advance(NO_SKIN, &frame, 1.0 / 60.0, options);
        residuals(&simulation, NO_SKIN, &frame, options)[0]
    }

    #[test]
    fn more_sweeps_leave_less() {
        let with = |inner| {
            let options = DynamicsOptions { contacts: Contacts::NONE, inner, ..DynamicsOptions::default() };
            plucked(&options, 1.0).elastic
        };
        let (few, some, many) = (with(1), with(8), with(200));
        assert!(many < 1e-4 && many < some && some < few, "{many} {some} {few}");
    }

    #[test]
    fn what_overlaps_is_seen() {
        let options = DynamicsOptions { contacts: Contacts::NONE, ..DynamicsOptions::default() };
        assert_eq!(plucked(&options, 0.2).depth(), 0.0);
        let deep = plucked(&options, 0.04);
        assert!((0.01..0.03).contains(&deep.muscle) && deep.bone == 0.0 && deep.skin == 0.0, "{deep:?}");
        let apart = plucked(&DynamicsOptions::default(), 0.04);
        assert!(apart.muscle < 0.5 * deep.muscle, "contacts part them: {apart:?}");
    }

    #[test]
    fn raw_stiffness_counts_its_tendons_alone() {
        let still = plucked(&DynamicsOptions { contacts: Contacts::NONE, ..DynamicsOptions::pbd() }, 1.0);
        assert!(still.elastic > 0.0 && still.elastic < 0.9, "a muscle's own segments stay 98 % too long: {still:?}");
    }
}
