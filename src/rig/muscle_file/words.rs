//! The parser's and the deserialiser's mistakes in words that whoever writes a muscle file knows: keys, lists and tables
//! rather than fields, sequences and structs.

use crate::error::one_line;
use crate::rig::muscle::MuscleSpec;
use crate::rig::nearest::nearest;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Characters of a wrong text that are repeated.
const REPEATED: usize = 40;

/// A mistake's place, first byte, and its words.
pub(super) fn of(text: &str, error: &toml::de::Error) -> (usize, String) {
    let span = error.span().unwrap_or(0..0);
    let Ok(document) = DeTable::parse(text) else {
        return (span.start, of_syntax(error.message(), text.get(span).unwrap_or_default()));
    };
    if let Some(found) = of_top(document.get_ref()) {
        return found;
    }
    (span.start, in_words(error.message(), &Place::at(document.get_ref(), &span)))
}

/// A text that is no TOML; `there` is what stands at the place.
fn of_syntax(message: &str, there: &str) -> String {
    let there = one_line(there);
    match (message, &there[..]) {
        ("duplicate key", "muscle" | "bone") => {
            format!("`{there}` stands here in another form than before; write [[{there}]] for each {there}")
        }
        ("duplicate key", _) => format!("key `{there}` stands twice; keep one"),
        _ => message.into(),
    }
}

/// The file's own tables in another form than theirs: which says more than what is missed inside them.
fn of_top(document: &DeTable) -> Option<(usize, String)> {
    for key in ["muscle", "bone"] {
        let value = document.get(key);
        let what = match value.map(Spanned::get_ref) {
            None | Some(DeValue::Array(_)) => continue,
            Some(DeValue::Table(_)) => format!("write [[{key}]], in double brackets, for each {key}"),
            Some(_) => {
                format!("key `{key}` stands outside of all tables; write [[muscle]] or [[bone]] on a line before it")
            }
        };
        return value.map(|value| (value.span().start, what));
    }
    let character = document.get("character")?;
    let list = matches!(character.get_ref(), DeValue::Array(_));
    list.then(|| (character.span().start, "write [character], in single brackets; a file has one".into()))
}

/// What stands at a mistake.
#[derive(Default)]
struct Place {
    /// ``muscle `biceps`: `` inside that muscle, else empty.
    whose: String,
    /// Keys from the top, inmost last; empty where the mistake is not at a value.
    keys: Vec<String>,
    /// Whether it is inside a list at the inmost key, rather than that key's own value.
    listed: bool,
}

impl Place {
    fn at(document: &DeTable, span: &Range<usize>) -> Place {
        let mut place = Place::default();
        for (key, value) in document {
            let found = match value.get_ref() {
                // Each muscle is named by its own entry.
                DeValue::Array(entries) if matches!(&key.get_ref()[..], "muscle" | "bone") => entries.iter().any(|e| {
                    let kind = key.get_ref();
                    let name = e.get_ref().get(if kind == "muscle" { "name" } else { "bone" });
                    let name = name.and_then(|name| name.get_ref().as_str());
                    place.whose = name.map_or(String::new(), |name| format!("{kind} `{}`: ", one_line(name)));
                    place.find(e, span)
                }),
                _ => {
                    place.whose.clear();
                    place.find_key(key.get_ref(), value, span)
                }
            };
            if found {
                place.keys.reverse();
                return place;
            }
        }
        Place::default()
    }

    /// Whether the value, or one inside it, has the span; keys are gathered inmost first.
    fn find(&mut self, value: &Spanned<DeValue>, span: &Range<usize>) -> bool {
        if value.span() == *span {
            return true;
        }
        match value.get_ref() {
            DeValue::Array(items) => {
                let found = items.iter().any(|item| self.find(item, span));
                self.listed |= found && self.keys.is_empty();
                found
            }
            DeValue::Table(table) => table.iter().any(|(key, value)| self.find_key(key.get_ref(), value, span)),
            _ => false,
        }
    }

    fn find_key(&mut self, key: &str, value: &Spanned<DeValue>, span: &Range<usize>) -> bool {
        let found = self.find(value, span);
        if found {
            self.keys.push(one_line(key));
        }
        found
    }

    /// The inmost key that is not the list of keys of a curve with an `ease`.
    fn key(&self) -> &str {
        self.keys.iter().rev().map(String::as_str).find(|key| *key != "points").unwrap_or_default()
    }

    /// The value in words.
    fn subject(&self) -> String {
        match (self.key(), self.listed) {
            ("", _) => "this".into(),
            (key, false) => format!("`{key}`"),
            (key, true) => format!("an item of `{key}`"),
        }
    }
}

/// The deserialiser's words in the file's own.
fn in_words(message: &str, place: &Place) -> String {
    for (kind, word) in [("unknown field `", "key"), ("unknown variant `", "value")] {
        let Some(rest) = message.strip_prefix(kind) else { continue };
        // Known names are listed after the unknown one, which may hold anything.
        let Some((unknown, known)) = rest.rsplit_once("`, expected ") else { continue };
        let known: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
        let best = nearest(unknown, known.iter().copied(), 1);
        let unknown = one_line(unknown);
        return match best.first() {
            Some(best) => format!("unknown {word} `{unknown}`; did you mean `{best}`? Known are {}", known.join(", ")),
            None => format!("unknown {word} `{unknown}`"),
        };
    }
    let Place { whose, .. } = place;
    if let Some((key, _)) = message.strip_prefix("missing field `").and_then(|rest| rest.split_once('`')) {
        let table = place.keys.last().map(|table| format!(" of `{table}`")).unwrap_or_default();
        return format!("{whose}key `{key}`{table} is missing");
    }
    let subject = place.subject();
    if message == "wanted string or table" {
        return format!("{whose}{subject} must be {}", words_of(place.key()));
    }
    let Some((found, wanted)) = message.rsplit_once(", expected ") else { return message.into() };
    let wanted = wanted_words(wanted, place);
    if let Some(count) = found.strip_prefix("invalid length ") {
        return format!("{whose}{subject} is a list of {count}, and must be {wanted}");
    }
    match found.strip_prefix("invalid type: ").or_else(|| found.strip_prefix("invalid value: ")) {
        Some(found) => format!("{whose}{subject} is {}, and must be {wanted}", found_words(found)),
        None => message.into(),
    }
}

/// What stands in the file.
fn found_words(found: &str) -> String {
    match found.split_once(' ') {
        None if found == "map" => "a table".into(),
        None if found == "sequence" => "a list".into(),
        Some(("string", text)) if text.chars().nth(REPEATED).is_some() => {
            format!("the text {}…", one_line(&text.chars().take(REPEATED).collect::<String>()))
        }
        Some(("string", text)) => format!("the text {}", one_line(text)),
        _ => one_line(found.split('`').nth(1).unwrap_or(found)),
    }
}

/// What is to stand there.
fn wanted_words(wanted: &str, place: &Place) -> String {
    let key = place.key();
    let words = match wanted {
        "u32" => {
            let range = match key {
                "alpha" | "beta" | "shape" => MuscleSpec::EXPONENTS_RANGE,
                "segments" => MuscleSpec::SEGMENTS_RANGE,
                "count" => MuscleSpec::FIBRES_RANGE,
                _ => return "a whole number".into(),
            };
            return format!("a whole number from {} to {}", range.start(), range.end());
        }
        "f32" => "a number",
        "a map" if key == "groups" => "a table, [groups.NAME] for each group",
        "a map" => "a table, [joints.NAME] for each joint",
        "a boolean" => "true or false",
        "a string" => "text in quotes",
        "a sequence" => match key {
            "collides" => "a list, [\"bones\", \"muscles\", \"skin\"]",
            "degrees" => "two numbers, [from, to]",
            "joints" => "a list of joints' names, [\"index_01_l\", ..]",
            "drivers" => "a list of drivers, [{ length = {} }, ..]",
            "origin_line" | "insertion_line" => "a list of points, [[x, y, z], ..]",
            "activation" | "eccentricity" | "width" | "stiffness" => "a key, [seconds, value]",
            _ => "a list, [..]",
        },
        _ if wanted.starts_with("struct ") => "a table, { key = value, .. }",
        _ if wanted.starts_with("a list of numbers") || wanted.starts_with("a tuple") || wanted.contains("array") => {
            match key {
                "shape" => "[seconds, alpha, beta]",
                "degrees" => "two numbers, [from, to]",
                _ => "three numbers, [x, y, z]",
            }
        }
        other => other,
    };
    words.into()
}

/// Keys whose value is one of a few words.
fn words_of(key: &str) -> &'static str {
    match key {
        "collides" => "\"bones\", \"muscles\" or \"skin\"",
        "side" => "\"left\", \"right\" or \"centre\"",
        "combine" => "\"max\", \"add\" or \"multiply\"",
        "operator" => "the name of an operator in quotes, \"contact\"",
        "ease" => "\"linear\", \"step\" or \"cubic\"",
        _ => "text in quotes",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_name_may_hold_anything() {
        let message = in_words("unknown field `a`, expected `b`, expected one of `alpha`, `beta`", &Place::default());
        assert!(message.contains("did you mean `"), "{message}");
        assert_eq!(in_words("missing field `bone`", &Place::default()), "key `bone` is missing");
    }

    #[test]
    fn a_wrong_text_is_repeated_in_part() {
        assert_eq!(found_words("string \"a, expected b\""), "the text \"a, expected b\"");
        assert!(found_words(&format!("string \"{}\"", "x".repeat(1 << 20))).len() < 64);
        assert_eq!((found_words("floating point `3.5`"), found_words("map")), ("3.5".into(), "a table".into()));
    }
}
