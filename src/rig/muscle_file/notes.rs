//! What is odd about a muscle file beside its character, but accepted.

use super::place::Fault;
use super::{MAX_NOTES, MuscleFile, place};
use crate::rig::nearest::nearest;
use crate::rig::{Character, FieldGroups};
use std::collections::BTreeSet;

impl MuscleFile {
    /// What is odd about the file beside a character, one line each with file, line and column: a file for another
    /// character, and muscles that nothing comes of because their bone's whole group follows linear skinning.
    pub fn notes_beside(&self, character: &Character) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(name) = self.character.as_ref().filter(|name| **name != character.name) {
            let what = format!("the muscles are for character `{name}`, and this one is `{}`", character.name);
            notes.push(Fault::new("character.name", what));
        }
        if !self.muscles.is_empty() {
            // Groups that do not fit are an error elsewhere.
            let groups = FieldGroups::detect_beside(character, &self.groups).unwrap_or_default();
            let passive: BTreeSet<&str> = groups
                .groups
                .iter()
                .filter(|group| group.passive)
                .flat_map(|group| &group.joints)
                .filter_map(|&joint| character.joints.get(joint as usize))
                .map(|joint| joint.name.as_str())
                .collect();
            for (i, spec) in self.muscles.iter().enumerate().filter(|(_, spec)| passive.contains(&spec.bone[..])) {
                let what = format!(
                    "muscle `{}`: bone `{}` is of a head, a hand or a foot, whose skin follows linear skinning: the muscle \
                     moves none of it; name a bone above it",
                    spec.name, spec.bone
                );
                notes.push(Fault::new(format!("muscle[{i}].bone"), what));
            }
        }
        self.placed(notes)
    }

    /// Notes on keyed muscles that the file lacks, with the nearest names; `keyed` are names of clips and of muscles in them.
    pub fn notes_on_keyed<'a>(&self, keyed: impl IntoIterator<Item = (&'a str, &'a str)>) -> Vec<String> {
        let known: BTreeSet<&str> = self.muscles.iter().map(|spec| spec.name.as_str()).collect();
        let unknown: BTreeSet<(&str, &str)> = keyed.into_iter().filter(|(_, name)| !known.contains(name)).collect();
        let note = |(clip, name): (&str, &str)| {
            let nearest = nearest(name, self.muscles.iter().map(|spec| spec.name.as_str()), 3).join(", ");
            format!("clip `{clip}` keys muscle `{name}`, which the muscle file lacks; nearest names: {nearest}")
        };
        unknown.into_iter().take(MAX_NOTES).map(note).collect()
    }

    fn placed(&self, notes: Vec<Fault>) -> Vec<String> {
        let placed = |note: Fault| place::at_key(&self.text, &self.path, &note.key, &note.message).to_string();
        notes.into_iter().take(MAX_NOTES).map(placed).collect()
    }
}
