//! Field groups that the muscle file gives in place of those that are found.

use super::names::{BodyPart, Side};
use super::parts::Key;
use super::structure::MOST_GROUPS;
use crate::error::GroupError;
use crate::rig::Character;
use crate::rig::muscle::find_joint;

/// A field group that is given.
///
/// What hangs below its joints and would have shared their field goes with them: fingertips with fingers, twist joints
/// with limbs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GroupSpec {
    /// The group's name.
    pub name: String,
    /// Names of the joints that share the field.
    pub joints: Vec<String>,
    /// Whether each of the joints has a field of its own instead, under its own name.
    pub separate: bool,
    /// Whether vertices bound almost wholly to it follow linear skinning; by default where all its joints are of one
    /// head, hand or foot and not separate.
    pub passive: Option<bool>,
}

/// A given group among the character's joints.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Given {
    /// Its name.
    pub name: String,
    /// Name of the entry that gives it.
    pub entry: String,
    /// What is said of its passivity.
    pub passive: Option<bool>,
    /// The part of the body that it stands for: that of its joints, where they agree.
    pub body: Option<(BodyPart, Option<Side>)>,
}

/// Puts given groups into the keys of joints.
pub(super) fn give(
    character: &Character,
    specs: &[GroupSpec],
    keys: &mut [Option<Key>],
) -> Result<Vec<Given>, GroupError> {
    let mut given: Vec<Given> = Vec::new();
    let mut listed: Vec<Option<u32>> = vec![None; keys.len()];
    for spec in specs {
        let group = || spec.name.clone();
        if spec.joints.is_empty() {
            return Err(GroupError::Empty { group: group() });
        }
        for (number, name) in spec.joints.iter().enumerate() {
            let joint = find_joint(name, character).map_err(|nearest| GroupError::UnknownJoint {
                group: group(),
                joint: name.clone(),
                number,
                nearest,
            })?;
            if let Some(other) = listed[joint] {
                let other = given[other as usize].entry.clone();
                return Err(GroupError::Twice { group: group(), joint: name.clone(), number, other });
            }
            let body = match keys[joint] {
                Some(Key::Body(part, side)) if !spec.separate => Some((part, side)),
                _ => None,
            };
            if number == 0 || spec.separate {
                let own = if spec.separate { name } else { &spec.name };
                given.push(Given { name: own.clone(), entry: group(), passive: spec.passive, body });
            }
            if let Some(last) = given.last_mut().filter(|last| last.body != body) {
                last.body = None;
            }
            listed[joint] = Some(given.len() as u32 - 1);
        }
    }
    if given.len() > MOST_GROUPS {
        return Err(GroupError::TooMany { given: given.len(), most: MOST_GROUPS });
    }
    // Parents precede their children.
    let found = keys.to_vec();
    let mut heads: Vec<Option<usize>> = vec![None; keys.len()];
    for (j, joint) in character.joints.iter().enumerate() {
        let above = joint.parent.and_then(|p| heads[p as usize]);
        let goes_with = |head: &usize| found[j].is_some() && found[j] == found[*head];
        heads[j] = if listed[j].is_some() { Some(j) } else { above.filter(goes_with) };
        if let Some(group) = heads[j].and_then(|head| listed[head]) {
            keys[j] = Some(Key::Given(group));
        }
    }
    Ok(given)
}
