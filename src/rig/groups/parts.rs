//! From names and skeleton to a key per joint: joints of one key share one field.

use super::names::{self, BodyPart, Reading, Side, Word};
use crate::rig::Character;

/// What decides the group of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Key {
    /// A part of the body.
    Body(BodyPart, Option<Side>),
    /// Nothing known: a group of its own until the structure merges it.
    Own(u32),
    /// One of the groups that the muscle file gives.
    Given(u32),
}

/// Key of every joint; `None` for joints that move no vertex and that no name places.
pub(super) fn keys(character: &Character) -> Vec<Option<Key>> {
    let joints = &character.joints;
    let readings: Vec<Reading> = joints.iter().map(|j| names::read(&j.name)).collect();
    let weight = weights(character);
    let mut keys: Vec<Option<Key>> = vec![None; joints.len()];
    for j in 0..joints.len() {
        let reading = &readings[j];
        if weight[j] == 0.0 && (reading.control || below_control(character, &readings, j)) {
            continue;
        }
        let above = joints[j].parent.and_then(|p| keys[p as usize]);
        let side = reading.side.or(match above {
            Some(Key::Body(_, side)) => side,
            _ => None,
        });
        let part = match (above, reading.word) {
            (Some(Key::Body(part, _)), _) if part.is_end() => Some(part),
            (_, Word::Part(part)) => Some(part),
            (_, Word::Shoulder) => Some(shoulder(character, &readings, j)),
            (_, Word::Spine) => Some(BodyPart::Trunk),
            (above, Word::Arm) => Some(next_in_chain(above, reading, ARM)),
            (above, Word::Leg) => Some(next_in_chain(above, reading, LEG)),
            (_, Word::Unknown) => None,
        };
        keys[j] = match part {
            Some(part) => Some(Key::Body(part, if part.is_middle() { None } else { side })),
            None if weight[j] > 0.0 => Some(Key::Own(j as u32)),
            None => None,
        };
    }
    name_roots(character, &mut keys);
    name_head(character, &mut keys);
    keys
}

const ARM: [BodyPart; 3] = [BodyPart::UpperArm, BodyPart::Forearm, BodyPart::Hand];
const LEG: [BodyPart; 3] = [BodyPart::Thigh, BodyPart::Calf, BodyPart::Foot];

/// Summed weight of every joint over the vertices.
fn weights(character: &Character) -> Vec<f64> {
    let mut weight = vec![0.0; character.joints.len()];
    for influence in &character.influences {
        weight[influence.joint as usize] += f64::from(influence.weight);
    }
    weight
}

/// Whether an ancestor is an animator's handle.
fn below_control(character: &Character, readings: &[Reading], j: usize) -> bool {
    ancestors(character, j).any(|a| readings[a].control)
}

/// Ancestors of a joint, nearest first.
fn ancestors(character: &Character, j: usize) -> impl Iterator<Item = usize> {
    let parent = |k: usize| character.joints[k].parent.map(|p| p as usize);
    std::iter::successors(parent(j), move |&k| parent(k))
}

/// A joint called just `arm` or `leg`: the limb bone after its parent's, or the same for a twist joint.
fn next_in_chain(above: Option<Key>, reading: &Reading, limb: [BodyPart; 3]) -> BodyPart {
    let Some(Key::Body(part, _)) = above else { return limb[0] };
    match limb.iter().position(|&p| p == part) {
        Some(k) if reading.twist => limb[k],
        Some(k) => limb[(k + 1).min(2)],
        None => limb[0],
    }
}

/// `shoulder` is an upper arm where the next arm joint below it is a forearm, and a clavicle otherwise.
fn shoulder(character: &Character, readings: &[Reading], j: usize) -> BodyPart {
    // Parents precede their children: one pass marks what hangs below.
    let mut below = vec![false; character.joints.len()];
    below[j] = true;
    let mut next = (j + 1..below.len()).filter(|&k| {
        below[k] = character.joints[k].parent.is_some_and(|p| below[p as usize]);
        below[k]
    });
    let first_below = next.find_map(|k| match readings[k].word {
        Word::Part(BodyPart::UpperArm) | Word::Arm => Some(BodyPart::Trunk),
        Word::Part(BodyPart::Forearm) => Some(BodyPart::UpperArm),
        _ => None,
    });
    first_below.unwrap_or(BodyPart::Trunk)
}

/// A skin-moving joint of unknown name above the trunk belongs to the trunk.
fn name_roots(character: &Character, keys: &mut [Option<Key>]) {
    for j in (0..keys.len()).rev() {
        let trunk = |k: usize| matches!(keys[k], Some(Key::Body(BodyPart::Trunk, _)));
        let child = |k: &usize| character.joints[*k].parent == Some(j as u32) && trunk(*k);
        if !matches!(keys[j], Some(Key::Own(_))) {
            continue;
        }
        if let Some(k) = (j + 1..keys.len()).find(child) {
            keys[j] = keys[k];
        }
    }
}

/// Without a joint called head, the last neck joint carries it.
fn name_head(character: &Character, keys: &mut [Option<Key>]) {
    let is = |key: &Option<Key>, part| *key == Some(Key::Body(part, None));
    if keys.iter().any(|k| is(k, BodyPart::Head)) {
        return;
    }
    let leaf = |j: usize| !character.joints.iter().any(|c| c.parent == Some(j as u32));
    if let Some(j) = (0..keys.len()).rev().find(|&j| is(&keys[j], BodyPart::Neck) && leaf(j)) {
        keys[j] = Some(Key::Body(BodyPart::Head, None));
    }
}
