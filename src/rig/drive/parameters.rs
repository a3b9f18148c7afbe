//! A muscle's parameters at one moment, and how they come about from its two shapes and its keys.

use crate::field::muscle::{MuscleInput, Profile, profile::MAX_ECCENTRICITY};
use crate::rig::Key;
use crate::rig::muscle::MuscleSpec;

/// Pairs of profile exponents and how much each counts: `Phi = sum w_i phi_i / sqrt(F)`, `F = w^T G w` with the Gram
/// matrix `G` of the pairs, which whoever reads this computes.
///
/// The weights are those of a plain linear blend: 0..=1, adding up to 1. No pair stands twice and none has weight 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeBlend {
    pairs: [((u32, u32), f32); Self::MOST],
    count: usize,
}

impl ShapeBlend {
    /// Pairs that a blend holds at most.
    pub const MOST: usize = 4;

    /// `(alpha, beta)`, each 1..=9, and weight; never empty.
    pub fn pairs(&self) -> &[((u32, u32), f32)] {
        &self.pairs[..self.count]
    }

    /// One pair alone.
    pub(crate) fn one(pair: (u32, u32)) -> ShapeBlend {
        ShapeBlend { pairs: [(pair, 1.0); Self::MOST], count: 1 }
    }

    /// The pair on the way `from` one `to` another, blended with the `active` one by activation.
    fn new(from: (u32, u32), to: (u32, u32), share: f32, active: (u32, u32), activation: f32) -> ShapeBlend {
        let rest = 1.0 - activation;
        let given = [(from, rest * (1.0 - share)), (to, rest * share), (active, activation)];
        let mut blend = ShapeBlend { pairs: [((3, 3), 0.0); Self::MOST], count: 0 };
        for (pair, weight) in given.into_iter().filter(|(_, weight)| *weight > 0.0) {
            match blend.pairs[..blend.count].iter_mut().find(|(known, _)| *known == pair) {
                // The parts of one rounded whole may add up to a bit more than it.
                Some((_, sum)) => *sum = (*sum + weight).min(1.0),
                None => {
                    blend.pairs[blend.count] = (pair, weight);
                    blend.count += 1;
                }
            }
        }
        // Shares so small that a weight vanished leave the other one.
        if blend.count == 0 { ShapeBlend::one(from) } else { blend }
    }
}

/// One muscle at one moment. Every number is finite and in its range, whatever keys and drivers said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MuscleParameters {
    /// 0 at rest to 1 fully active.
    pub activation: f32,
    /// Eccentricity of the section, 0..=.99.
    pub eccentricity: f32,
    /// Factor on the width that the volume gives, 0..=10.
    pub width: f32,
    /// Stiffness k, 0..=1.
    pub stiffness: f32,
    /// Profile exponents and their weights.
    pub shapes: ShapeBlend,
}

/// `(alpha, beta)`.
type Pair = (u32, u32);

/// What is keyed of one muscle at one moment.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Keyed {
    pub activation: Option<f32>,
    eccentricity: Option<f32>,
    width: Option<f32>,
    stiffness: Option<f32>,
    /// Two pairs and the share of the way.
    shape: Option<(Pair, Pair, f32)>,
}

impl Keyed {
    /// What the muscle's own curves say.
    pub(super) fn of_curves(spec: &MuscleSpec, time: f32) -> Keyed {
        let keys = &spec.keys;
        let mut keyed = Keyed {
            activation: keys.activation.at(time),
            eccentricity: keys.eccentricity.at(time),
            width: keys.width.at(time),
            stiffness: keys.stiffness.at(time),
            shape: None,
        };
        if let Some(key) = keys.shape.at(time) {
            keyed.set(&key);
        }
        keyed
    }

    /// Puts a key in place of what was keyed.
    pub(super) fn set(&mut self, key: &Key) {
        match *key {
            Key::Activation(value) => self.activation = Some(value),
            Key::Eccentricity(value) => self.eccentricity = Some(value),
            Key::Width(value) => self.width = Some(value),
            Key::Stiffness(value) => self.stiffness = Some(value),
            Key::Shape { from, to, share } => self.shape = Some((from, to, share)),
        }
    }
}

impl MuscleParameters {
    /// Blends a muscle's shapes by activation, and lets keys replace what they key.
    pub(super) fn new(spec: &MuscleSpec, keyed: &Keyed, activation: f32) -> MuscleParameters {
        let activation = share(activation);
        let blend = |rest: f32, active: f32| rest + (active - rest) * activation;
        let (rest, active) = (&spec.rest, &spec.active);
        let own = (rest.alpha, rest.beta);
        let (from, to, way) = keyed.shape.unwrap_or((own, own, 0.0));
        let width = blend(rest.width, active.width) * finite(keyed.width).unwrap_or(1.0);
        MuscleParameters {
            activation,
            eccentricity: finite(keyed.eccentricity)
                .or(finite(Some(blend(rest.eccentricity, active.eccentricity))))
                .unwrap_or(0.0)
                .clamp(0.0, MAX_ECCENTRICITY),
            width: finite(Some(width)).unwrap_or(1.0).clamp(0.0, MuscleSpec::MAX_WIDTH),
            stiffness: share(finite(keyed.stiffness).unwrap_or(spec.stiffness)),
            shapes: ShapeBlend::new(
                exponents(from),
                exponents(to),
                share(way),
                exponents((active.alpha, active.beta)),
                activation,
            ),
        }
    }
}

impl From<&MuscleParameters> for MuscleInput {
    fn from(parameters: &MuscleParameters) -> MuscleInput {
        MuscleInput {
            width: parameters.width,
            activation: parameters.activation,
            stiffness: parameters.stiffness,
            ..MuscleInput::new(&Profile::blend(parameters.shapes.pairs()), parameters.eccentricity)
        }
    }
}

fn finite(value: Option<f32>) -> Option<f32> {
    value.filter(|v| v.is_finite())
}

/// Into 0..=1; what is not finite is 0.
pub(super) fn share(value: f32) -> f32 {
    if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 }
}

fn exponents((alpha, beta): Pair) -> Pair {
    (alpha.clamp(1, 9), beta.clamp(1, 9))
}
