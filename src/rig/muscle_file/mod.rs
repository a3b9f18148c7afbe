//! The muscle file, `NAME.muscles.toml`: read, checked, edited, mirrored, described.
//!
//! [`read`] gives muscles to build a rig from, [`Document`] changes a file and leaves comments, order and spacing alone,
//! and [`schema`] is the JSON Schema that an editor checks against while a file is written by hand.

mod convert;
mod curve;
mod edit;
mod mirror;
mod names;
mod notes;
mod place;
mod schema;
mod tables;
#[cfg(test)]
mod tests;
mod words;
mod write;

pub use edit::{Document, Mirrored, Settings};
pub use names::SideNames;
pub use schema::schema;

use crate::error::{BoneError, GroupError, JointError, MuscleError, MuscleFileError, one_line};
use crate::rig::drive::load_tables;
use crate::rig::muscle::{
    BoneSpec, JointSpec, MarkSpec, MuscleSpec, Source, find_bone, find_driver_joint, find_joint, find_wrap_joint,
};
use crate::rig::{Character, FieldGroups, GroupSpec};
use place::Fault;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest file, bytes: ten times what 500 muscles need, and a parsed one still fits a small machine's memory.
pub const MAX_BYTES: u64 = 4 << 20;
/// Most muscles, and most bones, of one file.
pub const MAX_MUSCLES: usize = 4096;

/// What a muscle file holds.
#[derive(Clone, Debug, Default)]
pub struct MuscleFile {
    /// Name of the character, where it is given.
    pub character: Option<String>,
    /// The muscles, in the file's order.
    pub muscles: Vec<MuscleSpec>,
    /// Bones whose shape for collisions the file gives.
    pub bones: Vec<BoneSpec>,
    /// Joints whose operator the file gives, by name.
    pub joints: Vec<JointSpec>,
    /// Field groups that the file gives, by name.
    pub groups: Vec<GroupSpec>,
    /// Regions in which extraction must find a muscle.
    pub marks: Vec<MarkSpec>,
    /// What is odd but accepted, one line each, with file, line and column.
    pub notes: Vec<String>,
    path: PathBuf,
    text: String,
}

/// Reads a muscle file, and the tables that its drivers name.
///
/// # Errors
/// The file cannot be read, is over [`MAX_BYTES`], or is not a muscle file: line and column are named. So they are of a table
/// that cannot be read.
pub fn read(path: &Path) -> Result<MuscleFile, MuscleFileError> {
    let mut file = parse(&read_text(path)?, path)?;
    let loaded = load_tables(&mut file.muscles, path.parent().unwrap_or(Path::new("")));
    loaded.map_err(|error| file.locate(&error))?;
    Ok(file)
}

/// The text of a muscle file.
fn read_text(path: &Path) -> Result<String, MuscleFileError> {
    let failed = |source| MuscleFileError::Read { path: path.into(), source };
    let mut bytes = Vec::new();
    std::fs::File::open(path).and_then(|f| f.take(MAX_BYTES + 1).read_to_end(&mut bytes)).map_err(failed)?;
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(&error.as_bytes()[..good]).into_owned();
        place::at_byte(&text, path, good, "not UTF-8 text; save the file as UTF-8")
    })
}

/// Reads a muscle file's text; `path` is for messages. Tables of drivers are not read: see [`load_tables`].
///
/// # Errors
/// As [`read`], less the file system's.
pub fn parse(text: &str, path: &Path) -> Result<MuscleFile, MuscleFileError> {
    if text.len() as u64 > MAX_BYTES {
        let most = MAX_BYTES >> 20;
        return Err(place::at_byte(text, path, 0, &format!("the file is over {most} MiB, more than a muscle file is")));
    }
    let file: tables::File = toml::from_str(text).map_err(|error| place::of_parser(text, path, &error))?;
    let placed = |fault: Fault| place::at_key(text, path, &fault.key, &fault.message);
    let character = file.character.name.map(convert::character).transpose();
    let character = character.map_err(|fault| placed(fault.within("character", "the character")))?;
    let (muscles, bones) = specs(file.muscles, file.bones).map_err(placed)?;
    let joints = joints(file.joints).map_err(placed)?;
    let groups = groups(file.groups).map_err(placed)?;
    let marks = marks(file.marks).map_err(placed)?;
    let notes = muscles.iter().enumerate().flat_map(|(i, spec)| {
        let whose = format!("muscle `{}`", spec.name);
        convert::notes(spec).into_iter().map(move |note| note.within(&format!("muscle[{i}]"), &whose))
    });
    let notes = notes.take(MAX_NOTES).map(|note| placed(note).to_string()).collect();
    Ok(MuscleFile { character, muscles, bones, joints, groups, marks, notes, path: path.into(), text: text.into() })
}

/// Notes that are kept: finding each one's line reads the file again, and nobody reads more of them.
const MAX_NOTES: usize = 16;

fn specs(
    muscles: Vec<tables::MuscleTable>,
    bones: Vec<tables::BoneTable>,
) -> Result<(Vec<MuscleSpec>, Vec<BoneSpec>), Fault> {
    for (count, kind) in [(muscles.len(), "muscle"), (bones.len(), "bone")] {
        if count > MAX_MUSCLES {
            let what = format!("{count} {kind}s; a file holds at most {MAX_MUSCLES}");
            return Err(Fault::new(format!("{kind}[{MAX_MUSCLES}]"), what));
        }
    }
    let mut names = BTreeSet::new();
    let mut specs = Vec::with_capacity(muscles.len());
    for (i, table) in muscles.into_iter().enumerate() {
        let (place, whose) = (format!("muscle[{i}]"), format!("muscle `{}`", one_line(&table.name)));
        if !names.insert(table.name.clone()) {
            return Err(Fault::new(format!("{place}.name"), format!("{whose} stands twice; names must differ")));
        }
        specs.push(convert::muscle(table).map_err(|fault| fault.within(&place, &whose))?);
    }
    let mut names = BTreeSet::new();
    let mut shapes = Vec::with_capacity(bones.len());
    for (i, table) in bones.into_iter().enumerate() {
        let (place, whose) = (format!("bone[{i}]"), format!("bone `{}`", one_line(&table.bone)));
        if !names.insert(table.bone.clone()) {
            return Err(Fault::new(format!("{place}.bone"), format!("{whose} stands twice; give each bone one shape")));
        }
        shapes.push(convert::bone(table).map_err(|fault| fault.within(&place, &whose))?);
    }
    Ok((specs, shapes))
}

fn joints(tables: BTreeMap<String, tables::JointTable>) -> Result<Vec<JointSpec>, Fault> {
    if tables.len() > MAX_MUSCLES {
        return Err(Fault::new("joints", format!("{} joints; a file holds at most {MAX_MUSCLES}", tables.len())));
    }
    let joint = |(name, table): (String, tables::JointTable)| {
        let (place, whose) = (place::of_joint(&name), format!("joint `{}`", one_line(&name)));
        convert::joint(name, &table).map_err(|fault| fault.within(&place, &whose))
    };
    tables.into_iter().map(joint).collect()
}

fn groups(tables: BTreeMap<String, tables::GroupTable>) -> Result<Vec<GroupSpec>, Fault> {
    let group = |(name, table): (String, tables::GroupTable)| {
        let (place, whose) = (place::of_group(&name), format!("group `{}`", one_line(&name)));
        convert::group(name, table).map_err(|fault| fault.within(&place, &whose))
    };
    tables.into_iter().map(group).collect()
}

fn marks(tables: Vec<tables::MarkTable>) -> Result<Vec<MarkSpec>, Fault> {
    let mark = |(i, table): (usize, tables::MarkTable)| {
        let (place, whose) = (format!("mark[{i}]"), format!("mark `{}`", one_line(&table.region)));
        convert::mark(table).map_err(|fault| fault.within(&place, &whose))
    };
    tables.into_iter().take(MAX_MUSCLES).enumerate().map(mark).collect()
}

impl MuscleFile {
    /// The file's path, as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A muscle by its name.
    pub fn muscle(&self, name: &str) -> Option<&MuscleSpec> {
        self.muscles.iter().find(|spec| spec.name == name)
    }

    /// What is wrong with a muscle, with the line and column of the value in this file.
    pub fn locate(&self, error: &MuscleError) -> MuscleFileError {
        let (muscle, key) = error.place();
        let key = place::muscle_index(&self.text, muscle).map_or(String::new(), |i| format!("muscle[{i}].{key}"));
        place::at_key(&self.text, &self.path, &key, &error.to_string())
    }

    /// What is wrong with a bone's shape, with the line and column of the value in this file.
    pub fn locate_bone(&self, error: &BoneError) -> MuscleFileError {
        let (bone, key) = error.place();
        let key = place::bone_index(&self.text, bone).map_or(String::new(), |i| format!("bone[{i}].{key}"));
        place::at_key(&self.text, &self.path, &key, &error.to_string())
    }

    /// What is wrong with a field group, with the line and column of the value in this file.
    pub fn locate_group(&self, error: &GroupError) -> MuscleFileError {
        let (group, key) = error.place();
        let place = place::of_group(group);
        let key = if key.is_empty() { place } else { format!("{place}.{key}") };
        place::at_key(&self.text, &self.path, &key, &error.to_string())
    }

    /// What is wrong with a joint's operator, with the line and column of its table in this file.
    pub fn locate_joint(&self, error: &JointError) -> MuscleFileError {
        place::at_key(&self.text, &self.path, &place::of_joint(error.joint()), &error.to_string())
    }

    /// Checks every bone and joint that the file names against the character. What a rig needs besides, the muscles'
    /// lengths and fields, is checked where it is built.
    ///
    /// # Errors
    /// A name that the character lacks, with line, column and the nearest names.
    pub fn check(&self, character: &Character) -> Result<(), MuscleFileError> {
        for spec in &self.muscles {
            for (role, bone) in
                [("field", &spec.bone), ("origin", &spec.origin.bone), ("insertion", &spec.insertion.bone)]
            {
                find_bone(spec, character, role, bone).map_err(|error| self.locate(&error))?;
            }
            find_wrap_joint(spec, character).map_err(|error| self.locate(&error))?;
            for (number, driver) in spec.drive.drivers.iter().enumerate() {
                if let Source::Angle { joint, .. } = &driver.source {
                    find_driver_joint(spec, number, character, joint).map_err(|error| self.locate(&error))?;
                }
            }
        }
        for spec in &self.joints {
            find_joint(&spec.joint, character)
                .map_err(|nearest| self.locate_joint(&JointError::Unknown { joint: spec.joint.clone(), nearest }))?;
        }
        for spec in &self.bones {
            find_joint(&spec.bone, character)
                .map_err(|nearest| self.locate_bone(&BoneError::UnknownBone { bone: spec.bone.clone(), nearest }))?;
        }
        if !self.groups.is_empty() {
            FieldGroups::detect_beside(character, &self.groups).map_err(|error| self.locate_group(&error))?;
        }
        Ok(())
    }
}
