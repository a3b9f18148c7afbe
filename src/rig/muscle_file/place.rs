//! Where in a muscle file a value stands, and mistakes that name the place.

use super::words;
use crate::error::{MuscleFileError, is_unprintable};
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// A value that is wrong, by its place in the file: `muscle[3].insertion.offset`.
#[derive(Debug)]
pub(super) struct Fault {
    pub key: String,
    pub message: String,
}

impl Fault {
    pub fn new(key: impl Into<String>, message: impl Into<String>) -> Fault {
        Fault { key: key.into(), message: message.into() }
    }

    /// The same fault, seen from the table that `key` is in.
    pub fn within(self, table: &str, whose: &str) -> Fault {
        let key = if self.key.is_empty() { table.into() } else { format!("{table}.{}", self.key) };
        Fault { key, message: format!("{whose}: {}", self.message) }
    }
}

/// The error at a byte of the text.
pub(super) fn at_byte(text: &str, path: &Path, byte: usize, message: &str) -> MuscleFileError {
    let mut end = byte.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    // Keys and values that are repeated may hold anything.
    let message: String = message.chars().map(|c| if is_unprintable(c) { ' ' } else { c }).collect();
    let before = &text[..end];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    MuscleFileError::Parse {
        path: path.into(),
        line: before.matches('\n').count() + 1,
        column: before[line_start..].chars().count() + 1,
        message: message.split_whitespace().collect::<Vec<_>>().join(" "),
    }
}

/// The error at a value of the text; where that value is left to its default, at what holds it.
pub(super) fn at_key(text: &str, path: &Path, key: &str, message: &str) -> MuscleFileError {
    at_byte(text, path, byte_of(text, key), message)
}

/// The parser's or the tables' own error.
pub(super) fn of_parser(text: &str, path: &Path, error: &toml::de::Error) -> MuscleFileError {
    let (byte, message) = words::of(text, error);
    at_byte(text, path, byte, &message)
}

/// The number of the muscle with a name.
pub(super) fn muscle_index(text: &str, name: &str) -> Option<usize> {
    index(text, "muscle", "name", name)
}

/// The number of the entry about a bone's shape.
pub(super) fn bone_index(text: &str, bone: &str) -> Option<usize> {
    index(text, "bone", "bone", bone)
}

/// The key of a joint's table; names may hold anything, dots included.
pub(super) fn of_joint(name: &str) -> String {
    format!("joints.\"{name}\"")
}

/// The key of a field group's table.
pub(super) fn of_group(name: &str) -> String {
    format!("groups.\"{name}\"")
}

fn index(text: &str, tables: &str, key: &str, wanted: &str) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let entries = document.get_ref().get(tables)?.get_ref().as_array()?;
    entries.iter().position(|e| e.get_ref().get(key).and_then(|n| n.get_ref().as_str()) == Some(wanted))
}

/// The steps of a key: names, and numbers of items. What stands in quotes is one name.
fn steps(key: &str) -> Vec<(&str, Option<usize>)> {
    let mut found = Vec::new();
    for (i, piece) in key.splitn(3, '"').enumerate() {
        if i == 1 {
            found.push((piece, None));
        } else {
            let plain = piece.split(['.', '[', ']']).filter(|step| !step.is_empty());
            found.extend(plain.map(|step| (step, step.parse().ok())));
        }
    }
    found
}

/// First byte of the value at a key such as `muscle[3].keys.width[2]`.
fn byte_of(text: &str, key: &str) -> usize {
    let Ok(document) = DeTable::parse(text) else { return 0 };
    let mut steps = steps(key).into_iter();
    let Some(mut here) = steps.next().and_then(|(first, _)| document.get_ref().get(first)) else { return 0 };
    for (step, index) in steps {
        let next = match (index, here.get_ref()) {
            // Keys with an `ease` stand one level deeper than keys without.
            (Some(index), DeValue::Table(table)) => table.get("points").and_then(|points| points.get_ref().get(index)),
            (Some(index), value) => value.get(index),
            (None, value) => value.get(step),
        };
        match next {
            Some(next) => here = next,
            None => break,
        }
    }
    // A whole muscle is best shown by its name.
    let named = here.get_ref().get("name").or_else(|| here.get_ref().get("bone")).unwrap_or(here);
    let shown = if key.starts_with("muscle") || key.starts_with("bone") { named } else { here };
    shown.span().start
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_by_their_keys() {
        let text = "[[muscle]]\nname = \"a\"\nkeys = { width = { ease = \"step\", points = [[0, 1], [2, 3]] } }\n\
                    origin = { bone = \"b\", offset = [1, 2, 3] }\n[[muscle]]\nname = \"é\"\nalpha = 4\n";
        let shown = |key: &str| {
            let rest = &text[byte_of(text, key)..];
            rest.chars().take(4).collect::<String>()
        };
        assert_eq!(shown("muscle[0].keys.width[1]"), "[2, ");
        assert_eq!(shown("muscle[0].origin.offset"), "[1, ");
        assert_eq!(shown("muscle[0].origin.offset[2]"), "3] }");
        assert_eq!(shown("muscle[1].alpha"), "4\n");
        assert_eq!(shown("muscle[1].beta"), "\"é\"\n");
        assert_eq!(byte_of(text, "nothing[7].here"), 0);
        let joints = "joints = { \"a.b[1]\" = { operator = \"union\" }, 3 = {} }";
        assert_eq!(&joints[byte_of(joints, &format!("{}.operator", of_joint("a.b[1]")))..][..7], "\"union\"");
        assert_eq!(&joints[byte_of(joints, &of_joint("3"))..], "{} }");
        assert_eq!(muscle_index(text, "é"), Some(1));
        assert_eq!(muscle_index(text, "b"), None);
    }
}
