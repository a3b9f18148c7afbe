//! Changes to a muscle file that leave alone what they do not change: comments, order, spacing, line ends.

use super::write::{self, Detail};
use super::{MuscleFile, SideNames, mirror, place};
use crate::error::MuscleFileError;
use crate::field::compose::JointOperator;
use crate::rig::muscle::{BoneSpec, Drive, JointSpec, MuscleSpec};
use crate::rig::{Character, GroupSpec};
use std::fmt;
use std::path::{Path, PathBuf};
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike, Value};

/// A muscle file while it is edited. What is not edited stays as it is, byte for byte.
#[derive(Clone, Debug)]
pub struct Document {
    path: PathBuf,
    original: String,
    tree: DocumentMut,
    edited: bool,
}

/// Settings of a muscle that can be copied to another: everything but name, side, bone, ends, wrap and fibres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Settings {
    /// Shapes at rest and active with their width factors, segments.
    Shape,
    /// Width or volume.
    Size,
    /// Stiffness, frequency, jiggle, tendon, what the muscle collides with.
    Physics,
    /// Drivers, attack, decay.
    Drive,
    /// Keys, and how keyed activation joins the drivers.
    Keys,
}

impl Settings {
    /// All of them.
    pub const ALL: [Settings; 5] =
        [Settings::Shape, Settings::Size, Settings::Physics, Settings::Drive, Settings::Keys];
}

/// What mirroring did, by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mirrored {
    /// Partners that were added.
    pub added: Vec<String>,
    /// Partners that stood there and were brought in line.
    pub updated: Vec<String>,
    /// Bones whose shape was added or brought in line.
    pub bones: Vec<String>,
    /// Joints whose operator was added or brought in line.
    pub joints: Vec<String>,
    /// Field groups that were added or brought in line.
    pub groups: Vec<String>,
    /// Muscles without a partner: no pattern matches their names.
    pub alone: Vec<String>,
}

impl Document {
    /// Opens a muscle file to edit it.
    ///
    /// # Errors
    /// As [`super::read`]: only a good file is edited.
    pub fn open(path: &Path) -> Result<Document, MuscleFileError> {
        Document::parse(&super::read_text(path)?, path)
    }

    /// Opens a muscle file's text; `path` is for messages.
    ///
    /// # Errors
    /// As [`super::parse`].
    pub fn parse(text: &str, path: &Path) -> Result<Document, MuscleFileError> {
        super::parse(text, path)?;
        let tree = text
            .parse::<DocumentMut>()
            .map_err(|error| place::at_byte(text, path, error.span().map_or(0, |span| span.start), error.message()))?;
        Ok(Document { path: path.into(), original: text.into(), tree, edited: false })
    }

    /// What the file holds as it is now.
    ///
    /// # Errors
    /// As [`super::parse`], where an edit gave a value that is out of its bounds; lines are those of the edited text.
    pub fn file(&self) -> Result<MuscleFile, MuscleFileError> {
        super::parse(&self.to_string(), &self.path)
    }

    /// Sets a muscle's key, such as `width` or `origin.offset`, to a value in the file's own spelling, such as `0.03` or
    /// `[0, 1, 0]`. A comment behind it stays.
    ///
    /// # Errors
    /// No such muscle, no such value, or a file that would no longer be good; it is then left as it was.
    pub fn set(&mut self, muscle: &str, key: &str, value: &str) -> Result<(), MuscleFileError> {
        let value: Value = value.trim().parse().map_err(|_| self.refused(format!("`{value}` is no value")))?;
        self.change(|document| {
            let (keys, last) = key.rsplit_once('.').map_or((None, key), |(keys, last)| (Some(keys), last));
            let mut table: &mut dyn TableLike = document.muscle(muscle)?;
            for step in keys.into_iter().flat_map(|keys| keys.split('.')) {
                let item = table.entry(step).or_insert_with(|| toml_edit::value(toml_edit::InlineTable::new()));
                let Some(next) = item.as_table_like_mut() else {
                    return Err(format!("muscle `{muscle}`: `{step}` of `{key}` is no table"));
                };
                table = next;
            }
            put(table, last, &value.into());
            Ok(())
        })
    }

    /// Adds a muscle behind the others; what is at its default is not written.
    ///
    /// # Errors
    /// A muscle of that name, or a muscle that the file cannot hold; the file is then left as it was.
    pub fn add(&mut self, spec: &MuscleSpec) -> Result<(), MuscleFileError> {
        self.change(|document| document.push("muscle", write::muscle(spec, Detail::Needed)))
    }

    /// Sets what joins the limbs at a joint.
    ///
    /// # Errors
    /// A file that would no longer be good; it is then left as it was.
    pub fn set_joint(&mut self, joint: &str, operator: JointOperator) -> Result<(), MuscleFileError> {
        self.change(|document| document.put_joint(joint, operator))
    }

    /// Gives a field group, in place of the one of its name.
    ///
    /// # Errors
    /// A file that would no longer be good; it is then left as it was.
    pub fn set_group(&mut self, spec: &GroupSpec) -> Result<(), MuscleFileError> {
        self.change(|document| document.put_group(spec))
    }

    /// Copies settings from one muscle to others.
    ///
    /// # Errors
    /// No muscle of one of the names; the file is then left as it was.
    pub fn copy(&mut self, from: &str, to: &[&str], settings: &[Settings]) -> Result<(), MuscleFileError> {
        let file = self.file()?;
        let find = |name: &str| file.muscle(name).ok_or_else(|| self.refused(missing(&file, name)));
        let source = find(from)?;
        let targets = to.iter().map(|name| find(name)).collect::<Result<Vec<_>, _>>()?;
        self.change(|document| {
            for target in targets {
                let changed = settings.iter().fold(target.clone(), |spec, &s| copied(source, spec, s));
                update(document.muscle(&target.name)?, target, &changed);
            }
            Ok(())
        })
    }

    /// Gives every muscle, and every bone's shape, whose name `names` matches its partner on the other side: added behind
    /// the others, or brought in line where it stands. Bones are named by the same patterns; those that no pattern
    /// matches belong to both sides. Everything is reflected in x = 0 of scene space at rest.
    ///
    /// # Errors
    /// A bone that the character lacks, with line and column; the file is then left as it was.
    pub fn mirror(&mut self, character: &Character, names: &SideNames) -> Result<Mirrored, MuscleFileError> {
        let file = self.file()?;
        let mut done = Mirrored::default();
        let mut pairs = Vec::new();
        for spec in &file.muscles {
            match names.partner(&spec.name) {
                Some(name) if name == spec.name => {}
                Some(_) => {
                    let partner = mirror::muscle(spec, character, names).map_err(|error| file.locate(&error))?;
                    pairs.push((spec, partner));
                }
                None if !pairs.iter().any(|(_, p): &(_, MuscleSpec)| p.name == spec.name) => {
                    done.alone.push(spec.name.clone());
                }
                None => {}
            }
        }
        done.alone.retain(|name| !pairs.iter().any(|(_, partner)| partner.name == *name));
        let mut bones: Vec<BoneSpec> = Vec::new();
        for (i, spec) in file.bones.iter().enumerate().filter(|(_, spec)| names.partner(&spec.bone).is_some()) {
            let partner = mirror::bone(spec, character, names);
            bones.push(partner.map_err(|what| place::at_key(&file.text, &self.path, &format!("bone[{i}]"), &what))?);
        }
        let joints = file.joints.iter().filter(|spec| names.partner(&spec.joint).is_some()).map(|spec| {
            let located = |what: String| place::at_key(&file.text, &self.path, &place::of_joint(&spec.joint), &what);
            mirror::joint(spec, character, names).map_err(located)
        });
        let joints = joints.collect::<Result<Vec<JointSpec>, _>>()?;
        let groups = file.groups.iter().filter(|spec| names.partner(&spec.name).is_some()).map(|spec| {
            let located = |what: String| place::at_key(&file.text, &self.path, &place::of_group(&spec.name), &what);
            mirror::group(spec, character, names).map_err(located)
        });
        let groups = groups.collect::<Result<Vec<GroupSpec>, _>>()?;
        self.change(|document| {
            for (source, partner) in &pairs {
                if let Some(old) = file.muscle(&partner.name) {
                    update(document.muscle(&partner.name)?, old, partner);
                    done.updated.push(partner.name.clone());
                } else {
                    // The source's own order and spacing, without its comments: they speak of the other side.
                    let mut table = document.muscle(&source.name)?.clone();
                    plain(&mut table);
                    update(&mut table, source, partner);
                    document.push("muscle", table)?;
                    done.added.push(partner.name.clone());
                }
            }
            for partner in bones {
                let old = file.bones.iter().any(|b| b.bone == partner.bone);
                let table = write::bone(&partner);
                match document.tables("bone").and_then(|t| t.iter_mut().find(|t| is(t, "bone", &partner.bone))) {
                    Some(stands) if old => merge(stands, &table, &table),
                    _ => document.push("bone", table)?,
                }
                done.bones.push(partner.bone);
            }
            for partner in joints {
                document.put_joint(&partner.joint, partner.operator)?;
                done.joints.push(partner.joint);
            }
            for partner in groups {
                document.put_group(&partner)?;
                done.groups.push(partner.name);
            }
            Ok(())
        })?;
        Ok(done)
    }

    /// Makes a change, and takes it back where it fails or leaves no good file.
    fn change(&mut self, change: impl FnOnce(&mut Document) -> Result<(), String>) -> Result<(), MuscleFileError> {
        let before = self.clone();
        let made = change(self).map_err(|what| before.refused(what));
        self.edited = true;
        let made = made.and_then(|()| self.file().map(drop));
        if made.is_err() {
            *self = before;
        }
        made
    }

    fn refused(&self, message: String) -> MuscleFileError {
        MuscleFileError::Edit { path: self.path.clone(), message }
    }

    fn tables(&mut self, kind: &str) -> Option<&mut ArrayOfTables> {
        self.tree.get_mut(kind)?.as_array_of_tables_mut()
    }

    fn muscle(&mut self, name: &str) -> Result<&mut Table, String> {
        let tables = self.tables("muscle").ok_or_else(|| FORM.to_owned())?;
        tables.iter_mut().find(|t| is(t, "name", name)).ok_or_else(|| format!("there is no muscle `{name}`"))
    }

    fn put_joint(&mut self, joint: &str, operator: JointOperator) -> Result<(), String> {
        let mut table = Table::new();
        table.insert("operator", toml_edit::value(operator.name()));
        self.put_named("joints", joint, table)
    }

    fn put_group(&mut self, spec: &GroupSpec) -> Result<(), String> {
        self.put_named("groups", &spec.name, write::group(spec))
    }

    /// Brings the table of a name in line, or adds it.
    fn put_named(&mut self, kind: &str, name: &str, mut table: Table) -> Result<(), String> {
        let mut all = Table::new();
        all.set_implicit(true);
        let form = || format!("`{kind}` is no table; write [{kind}.NAME] for each");
        let tables = self.tree.entry(kind).or_insert(Item::Table(all)).as_table_like_mut().ok_or_else(form)?;
        if let Some(stands) = tables.get_mut(name) {
            merge(stands.as_table_like_mut().ok_or_else(form)?, &table, &table);
            return Ok(());
        }
        table.decor_mut().set_prefix("\n");
        tables.insert(name, Item::Table(table));
        Ok(())
    }

    /// Adds a table behind those of its kind, or behind everything.
    fn push(&mut self, kind: &str, mut table: Table) -> Result<(), String> {
        table.set_position(None);
        let first = self.tree.is_empty() && self.original.trim().is_empty();
        table.decor_mut().set_prefix(if first { "" } else { "\n" });
        let item = self.tree.entry(kind).or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
        item.as_array_of_tables_mut().ok_or_else(|| FORM.to_owned())?.push(table);
        Ok(())
    }
}

const FORM: &str =
    "muscles and bones that stand in one list cannot be edited; give each a [[muscle]] or [[bone]] of its own";

fn missing(file: &MuscleFile, name: &str) -> String {
    let nearest = crate::rig::nearest::nearest(name, file.muscles.iter().map(|m| m.name.as_str()), 3).join(", ");
    format!("there is no muscle `{name}`; nearest names: {nearest}")
}

fn is(table: &Table, key: &str, name: &str) -> bool {
    table.get(key).and_then(Item::as_str) == Some(name)
}

fn copied(from: &MuscleSpec, to: MuscleSpec, settings: Settings) -> MuscleSpec {
    let from = from.clone();
    match settings {
        Settings::Shape => MuscleSpec { rest: from.rest, active: from.active, segments: from.segments, ..to },
        Settings::Size => MuscleSpec { size: from.size, ..to },
        Settings::Physics => MuscleSpec {
            stiffness: from.stiffness,
            tendon: from.tendon,
            collision_group: from.collision_group,
            collides: from.collides,
            frequency: from.frequency,
            jiggle: from.jiggle,
            ..to
        },
        Settings::Drive => {
            let mut drive = Drive { keys: to.drive.keys, ..from.drive };
            for driver in &mut drive.drivers {
                // A column that goes by the muscle's name goes by the other's.
                if let crate::rig::muscle::Source::Table { column, .. } = &mut driver.source
                    && *column == from.name
                {
                    column.clone_from(&to.name);
                }
            }
            MuscleSpec { drive, ..to }
        }
        Settings::Keys => {
            let drive = Drive { keys: from.drive.keys, ..to.drive };
            MuscleSpec { keys: from.keys, drive, ..to }
        }
    }
}

/// Brings a muscle's table from what it says to what it is to say.
fn update(table: &mut Table, old: &MuscleSpec, new: &MuscleSpec) {
    let (mut needed, mut all) = (write::muscle(new, Detail::Needed), write::muscle(new, Detail::All));
    let same: [(&[&str], bool); 8] = [
        (&["origin"], old.origin == new.origin),
        (&["insertion"], old.insertion == new.insertion),
        (&["wrap"], old.wrap == new.wrap),
        (&["fibres"], old.fibres == new.fibres),
        (&["collides"], old.collides == new.collides),
        (&["drivers"], old.drive.drivers == new.drive.drivers),
        (&["keys"], old.keys == new.keys && old.drive.keys == new.drive.keys),
        (
            &["alpha", "beta", "eccentricity", "rest_width", "active", "width_scale"],
            old.rest == new.rest && old.active == new.active,
        ),
    ];
    // What says the same in other words stays in them.
    for key in same.into_iter().filter(|(_, same)| *same).flat_map(|(keys, _)| keys) {
        needed.remove(key);
        match table.get(key).cloned() {
            Some(stands) => drop(all.insert(key, stands)),
            None => drop(all.remove(key)),
        }
    }
    merge(table, &needed, &all);
}

/// Gives every key that stands its value in `all`, takes away those without one, and adds what is `needed`.
fn merge(table: &mut dyn TableLike, needed: &dyn TableLike, all: &dyn TableLike) {
    let keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).collect();
    for key in keys {
        match all.get(&key) {
            None => drop(table.remove(&key)),
            Some(new) => {
                let nested = needed.get(&key).and_then(Item::as_table_like);
                match (table.get_mut(&key).and_then(Item::as_table_like_mut), new.as_table_like()) {
                    // A table that is not needed whole still needs all of its members: one left out would have a default.
                    (Some(stands), Some(new)) => merge(stands, nested.unwrap_or(new), new),
                    _ => put(table, &key, new),
                }
            }
        }
    }
    for (key, value) in needed.iter() {
        if !table.contains_key(key) {
            put(table, key, value);
        }
    }
}

/// Sets a key; the comment and the spacing round the value that stands there stay, and so does a value that is the same.
fn put(table: &mut dyn TableLike, key: &str, new: &Item) {
    match table.get_mut(key) {
        Some(stands) if same(stands, new) => {}
        Some(stands) => {
            let decor = stands.as_value().map(|value| value.decor().clone());
            *stands = new.clone();
            if let (Some(decor), Some(value)) = (decor, stands.as_value_mut()) {
                *value.decor_mut() = decor;
            }
        }
        None => drop(table.insert(key, new.clone())),
    }
}

/// Whether two values read the same.
fn same(a: &Item, b: &Item) -> bool {
    let number = |v: &Value| v.as_float().or_else(|| v.as_integer().map(|i| i as f64)).map(|x| x as f32);
    fn both<T: PartialEq>(a: Option<T>, b: Option<T>) -> bool {
        a.is_some() && a == b
    }
    let equal = |a: &Value, b: &Value| {
        both(number(a), number(b)) || both(a.as_str(), b.as_str()) || both(a.as_bool(), b.as_bool())
    };
    fn values(a: &Value, b: &Value, equal: &dyn Fn(&Value, &Value) -> bool) -> bool {
        match (a, b) {
            (Value::Array(a), Value::Array(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| values(a, b, equal))
            }
            _ => equal(a, b),
        }
    }
    matches!((a.as_value(), b.as_value()), (Some(a), Some(b)) if values(a, b, &equal))
}

/// Takes the comments out of a table, and leaves the spacing within its lines.
fn plain(table: &mut Table) {
    let keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).collect();
    for key in keys {
        if let Some(mut key) = table.key_mut(&key) {
            key.leaf_decor_mut().set_prefix("");
        }
        match table.get_mut(&key) {
            Some(Item::Value(value)) => value.decor_mut().set_suffix(""),
            Some(Item::Table(inner)) => {
                inner.decor_mut().set_prefix("");
                inner.decor_mut().set_suffix("");
                inner.set_position(None);
                plain(inner);
            }
            _ => {}
        }
    }
    table.decor_mut().set_suffix("");
}

impl fmt::Display for Document {
    /// The file's text.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.edited {
            return f.write_str(&self.original);
        }
        // The tree keeps everything but these three: a byte order mark, the kind of line end, a last line without one.
        let mut text = self.tree.to_string();
        if !self.original.ends_with('\n') && text.ends_with('\n') && !self.original.is_empty() {
            text.pop();
        }
        let lines = |end: &str| self.original.matches(end).count();
        if lines("\r\n") * 2 > lines("\n") {
            text = text.replace('\n', "\r\n");
        }
        let mark = if self.original.starts_with('\u{feff}') { "\u{feff}" } else { "" };
        write!(f, "{mark}{text}")
    }
}
