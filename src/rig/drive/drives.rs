//! All muscles' drivers and keys, and what a pose makes of them.

use super::parameters::{Keyed, MuscleParameters, share};
use super::source::{Moment, ReadyDriver, Watched, activation};
use crate::error::{MuscleError, PoseError};
use crate::rig::muscle::{MuscleSpec, check};
use crate::rig::{Character, Pose};
use std::collections::HashMap;

/// One muscle.
#[derive(Clone, Debug)]
struct Entry {
    spec: MuscleSpec,
    drivers: Vec<ReadyDriver>,
}

/// The drivers and keys of all muscles of a file, with their joints found.
#[derive(Clone, Debug, Default)]
pub struct Drives {
    entries: Vec<Entry>,
    by_name: HashMap<String, usize>,
    watched: Watched,
    joints: usize,
}

impl Drives {
    /// Finds what the muscles' drivers name.
    ///
    /// # Errors
    /// A joint that the character lacks (nearest names are listed), a table that was not read
    /// ([`load_tables`](super::load_tables)), an axis without direction, or a time or range that is no number.
    pub fn new(character: &Character, specs: &[MuscleSpec]) -> Result<Drives, MuscleError> {
        let mut drives = Drives { joints: character.joints.len(), ..Drives::default() };
        for (index, spec) in specs.iter().enumerate() {
            check::speeds(&spec.drive).map_err(|wrong| wrong.of(spec))?;
            let drivers = (0..spec.drive.drivers.len())
                .map(|number| ReadyDriver::new(spec, number, character, &mut drives.watched))
                .collect::<Result<_, _>>()?;
            drives.entries.push(Entry { spec: spec.clone(), drivers });
            drives.by_name.entry(spec.name.clone()).or_insert(index);
        }
        Ok(drives)
    }

    /// Number of muscles.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are no muscles.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Whether no muscle has attack or decay: a pose then needs no [`Effort`](super::Effort).
    pub fn is_immediate(&self) -> bool {
        self.entries.iter().all(|e| (e.spec.drive.attack, e.spec.drive.decay) == (0.0, 0.0))
    }

    /// Index of the muscle of this name; of equal names the first.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.by_name.get(name).copied()
    }

    /// Seconds from 0 to 1 and from 1 to 0 at most, of one muscle.
    pub(super) fn attack_and_decay(&self, muscle: usize) -> (f32, f32) {
        let drive = &self.entries[muscle].spec.drive;
        (drive.attack, drive.decay)
    }

    /// The parameters of every muscle, in the file's order, at this pose.
    ///
    /// `ratios` holds current over rest length of each muscle's path, the mean over its fibres; a missing one
    /// counts as 1. Keys of the file and tables are read at [`Pose::time`]. What the pose keys replaces the file's key of
    /// the same parameter, and of two such the last counts; a keyed activation is joined with the drivers either way.
    /// [`Pose::activations`] replaces all of that. Anything that is not finite makes its muscle's activation 0, and
    /// leaves other parameters to the muscle's shapes.
    ///
    /// # Errors
    /// The pose has another number of joints, or of activations.
    pub fn parameters(&self, pose: &Pose, ratios: &[f32]) -> Result<Vec<MuscleParameters>, PoseError> {
        if pose.palette.len() != self.joints {
            return Err(PoseError::JointCount { given: pose.palette.len(), needed: self.joints });
        }
        if !pose.activations.is_empty() && pose.activations.len() != self.len() {
            return Err(PoseError::ActivationCount { given: pose.activations.len(), needed: self.len() });
        }
        let mut keyed: Vec<Keyed> = self.entries.iter().map(|e| Keyed::of_curves(&e.spec, pose.time)).collect();
        for key in &pose.keyed {
            if let Some(muscle) = self.index_of(&key.muscle) {
                keyed[muscle].set(&key.key);
            }
        }
        let turns = self.watched.turns(pose);
        let of_one = |(muscle, (entry, keyed)): (usize, (&Entry, &Keyed))| {
            let activation = match pose.activations.get(muscle) {
                Some(&given) => share(given),
                None => {
                    let at =
                        Moment { turns: &turns, time: pose.time, ratio: ratios.get(muscle).copied().unwrap_or(1.0) };
                    activation(&entry.drivers, keyed.activation, entry.spec.drive.keys, &at)
                }
            };
            MuscleParameters::new(&entry.spec, keyed, activation)
        };
        Ok(self.entries.iter().zip(&keyed).enumerate().map(of_one).collect())
    }
}
