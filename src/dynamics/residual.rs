//! What the constraints lack at the end of a frame: how good the solver's solution is.

use super::{Depth, Simulation, Skins, depths, elastic};
use crate::{field::muscle::axis::half, rig::FrameInputs, schedule::DynamicsOptions};

/// What one muscle's constraints lack. Contacts count as in [`Depth`], and whether or not they are on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Largest error of a segment over its length ([`elastic`]).
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
    let iterates = &simulation.iterates[..half(bodies.muscles.len() as u32, simulation.particles.len() as u32)];
    let depths = depths(bodies, skins, &inputs.joints, iterates);
    let of = |index: usize| {
        let muscle = &bodies.muscles[index];
        let own = &depths[muscle.first_point as usize..][..=muscle.segments as usize];
        let most = |depth: fn(&Depth) -> f32| own.iter().map(depth).fold(0.0, f32::max);
        Residual {
            elastic: elastic(bodies, index, &inputs.joints, &simulation.particles, iterates, options.mode),
            bone: most(|d| d.bone),
            muscle: most(|d| d.muscle),
            skin: most(|d| d.outside),
        }
    };
    (0..bodies.muscles.len()).map(of).collect()
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
