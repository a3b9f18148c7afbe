//! What can be wrong with a rig, its muscles and its poses.

use super::{FieldError, TableError};
use std::path::PathBuf;

/// A rig that cannot be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// The character is not consistent in itself.
    #[error("character `{character}`: {what}")]
    Character {
        /// Name of the character.
        character: String,
        /// What is inconsistent, with the element's index.
        what: String,
    },
    /// A muscle that does not fit the character.
    #[error(transparent)]
    Muscle(#[from] MuscleError),
    /// A bone's shape that does not fit the character.
    #[error(transparent)]
    Bone(#[from] BoneError),
    /// A given field group that does not fit the character.
    #[error(transparent)]
    Group(#[from] GroupError),
    /// A given operator of a joint that does not fit the character.
    #[error(transparent)]
    Joint(#[from] JointError),
    /// A field that could not be fitted.
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// Why muscles cannot displace the skin by weights.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WeightError {
    /// There are no muscles, or no fields for them to live in.
    #[error(
        "skinning by muscles needs muscles, and there are none; give a muscle file that has some, or choose linear skinning"
    )]
    NoMuscles,
    /// The file paints weights of a muscle that is not there.
    #[error(
        "attribute `_MUSCLE_{muscle}` paints muscle {muscle}, and the muscle file has {muscles}, counted from 0; \
         give it the muscle file that it was painted for, or remove the attribute"
    )]
    Unknown {
        /// Number of the muscle.
        muscle: u32,
        /// How many there are.
        muscles: usize,
    },
    /// No muscle reaches the skin with a weight.
    #[error(
        "`{character}`: no vertex has a weight of any muscle; make the muscles wider so that they reach the skin, or paint \
         `_MUSCLE_n`"
    )]
    NoVertex {
        /// Name of the character.
        character: String,
    },
}

/// A muscle that does not fit its character.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MuscleError {
    /// A bone that the character does not have.
    #[error("muscle `{muscle}`: {role} bone `{bone}` is not a joint of the character; nearest names: {nearest}")]
    UnknownBone {
        /// Name of the muscle.
        muscle: String,
        /// `field`, `origin` or `insertion`.
        role: &'static str,
        /// The name that was given.
        bone: String,
        /// Names that look like it.
        nearest: String,
    },
    /// A bone whose field was not fitted.
    #[error(
        "muscle `{muscle}`: bone `{bone}` carries no skin field, so no skin could follow; name a bone that moves skin"
    )]
    NoField {
        /// Name of the muscle.
        muscle: String,
        /// The bone.
        bone: String,
    },
    /// A number outside what it may be.
    #[error("muscle `{muscle}`: {what}")]
    Value {
        /// Name of the muscle.
        muscle: String,
        /// Where the muscle file has the value, from the muscle's own table: `insertion.offset`, `drivers[0].angle.joint`.
        key: String,
        /// The value, its bounds and the remedy.
        what: String,
    },
    /// A table of a driver that cannot be read.
    #[error("muscle `{muscle}`: {source}")]
    Table {
        /// Name of the muscle.
        muscle: String,
        /// Number of the driver, from 0.
        driver: usize,
        /// Why, with the table's own line and column.
        source: TableError,
    },
}

impl MuscleError {
    /// The muscle, and where its file has the value that is wrong, from the muscle's own table.
    pub fn place(&self) -> (&str, String) {
        match self {
            MuscleError::UnknownBone { muscle, role: "field", .. } => (muscle, "bone".into()),
            MuscleError::UnknownBone { muscle, role, .. } => (muscle, format!("{role}.bone")),
            MuscleError::NoField { muscle, .. } => (muscle, "bone".into()),
            MuscleError::Value { muscle, key, .. } => (muscle, key.clone()),
            MuscleError::Table { muscle, driver, source } => {
                let key = if matches!(source, TableError::Column { .. }) { "column" } else { "file" };
                (muscle, format!("drivers[{driver}].table.{key}"))
            }
        }
    }
}

/// A bone's shape that does not fit its character.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BoneError {
    /// A bone that the character does not have.
    #[error("bone `{bone}`: it is not a joint of the character; nearest names: {nearest}")]
    UnknownBone {
        /// The name that was given.
        bone: String,
        /// Names that look like it.
        nearest: String,
    },
    /// A mesh that the character's file does not have.
    #[error("bone `{bone}`: mesh `{mesh}` is not in the character's file; nearest names: {nearest}")]
    UnknownMesh {
        /// The bone.
        bone: String,
        /// The name that was given.
        mesh: String,
        /// Names that look like it.
        nearest: String,
    },
    /// A shape that nothing can collide with.
    #[error("bone `{bone}`: {what}")]
    Shape {
        /// The bone.
        bone: String,
        /// Where the muscle file has the value, from the bone's own table.
        key: String,
        /// What is wrong, and the remedy.
        what: String,
    },
}

impl BoneError {
    /// The bone, and where its file has the value that is wrong, from the bone's own table.
    pub fn place(&self) -> (&str, &str) {
        match self {
            BoneError::UnknownBone { bone, .. } => (bone, "bone"),
            BoneError::UnknownMesh { bone, .. } => (bone, "mesh"),
            BoneError::Shape { bone, key, .. } => (bone, key),
        }
    }
}

/// A given field group that does not fit its character.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GroupError {
    /// A joint that the character does not have.
    #[error("group `{group}`: `{joint}` is not a joint of the character; nearest names: {nearest}")]
    UnknownJoint {
        /// The group.
        group: String,
        /// The name that was given.
        joint: String,
        /// Its number in the group's list, from 0.
        number: usize,
        /// Names that look like it.
        nearest: String,
    },
    /// A joint that stands twice.
    #[error("group `{group}`: joint `{joint}` stands in group `{other}` already; keep it in one")]
    Twice {
        /// The group.
        group: String,
        /// The joint.
        joint: String,
        /// Its number in the group's list, from 0.
        number: usize,
        /// The group that had it first.
        other: String,
    },
    /// A group without joints.
    #[error("group `{group}`: it has no joints; name at least one, or leave the group out")]
    Empty {
        /// The group.
        group: String,
    },
    /// Too little skin for a field.
    #[error("group `{group}`: {joints} moves too little skin for a field; join it with its neighbours")]
    Bare {
        /// The group.
        group: String,
        /// The group's own name, or that of the joint where joints are separate.
        joints: String,
    },
    /// More groups than a character can have.
    #[error("{given} groups are given, at most {most} are possible; join some")]
    TooMany {
        /// Groups given.
        given: usize,
        /// The most.
        most: usize,
    },
}

/// A joint of the muscle file at which nothing can be joined.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum JointError {
    /// No such joint.
    #[error("joint `{joint}`: the character has no such joint; nearest names: {nearest}")]
    Unknown {
        /// The name that was given.
        joint: String,
        /// Names that look like it.
        nearest: String,
    },
    /// A joint inside one field, or beside none.
    #[error(
        "joint `{joint}`: it does not lie between two field groups; name the first joint of a limb that has a field, \
         as `sinew inspect` lists them"
    )]
    Within {
        /// The joint.
        joint: String,
    },
}

impl JointError {
    /// The joint.
    pub fn joint(&self) -> &str {
        match self {
            JointError::Unknown { joint, .. } | JointError::Within { joint } => joint,
        }
    }
}

impl GroupError {
    /// The group, and where its file has the value that is wrong, from the group's own table.
    pub fn place(&self) -> (&str, String) {
        match self {
            GroupError::UnknownJoint { group, number, .. } | GroupError::Twice { group, number, .. } => {
                (group, format!("joints[{number}]"))
            }
            GroupError::Empty { group } => (group, "joints".into()),
            GroupError::Bare { group, .. } => (group, String::new()),
            GroupError::TooMany { .. } => ("", String::new()),
        }
    }
}

/// A muscle file that cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MuscleFileError {
    /// The file system refused.
    #[error("{}: cannot read the muscle file: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Not what a muscle file holds.
    #[error("{}:{line}:{column}: {message}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong, in one line.
        message: String,
    },
    /// A change that cannot be made.
    #[error("{}: {message}", path.display())]
    Edit {
        /// The file.
        path: PathBuf,
        /// What cannot be done, and the remedy.
        message: String,
    },
}

/// A pose that cannot be played.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// Another character's pose.
    #[error(
        "the pose has {given} joint matrices and the character {needed} joints; sample it from the character's own scene"
    )]
    JointCount {
        /// Matrices given.
        given: usize,
        /// Joints of the character.
        needed: usize,
    },
    /// A matrix that is not finite.
    #[error("at {time} s the matrix of joint `{joint}` is not finite; mend the clip's keys there")]
    NonFinite {
        /// The joint.
        joint: String,
        /// Seconds after the clip's start.
        time: f32,
    },
    /// A time that is not finite: which substeps lead to it is not to be told.
    #[error("the pose's time is {time} s; give it finite seconds")]
    Time {
        /// The time given, seconds.
        time: f32,
    },
    /// Activations of another number of muscles.
    #[error("the pose has {given} activations and the muscle file {needed} muscles; give one each, or none")]
    ActivationCount {
        /// Activations given.
        given: usize,
        /// Muscles of the rig.
        needed: usize,
    },
}
