//! The minimal muscle file: straight muscles with one shape each (`NAME.muscles.toml`).

use super::muscle::{Attachment, MuscleShape, MuscleSize, MuscleSpec};
use crate::error::MuscleFileError;
use glam::Vec3;
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default, rename = "character")]
    _character: Option<CharacterTable>,
    #[serde(default, rename = "muscle")]
    muscles: Vec<MuscleTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CharacterTable {
    #[serde(default, rename = "name")]
    _name: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MuscleTable {
    name: String,
    #[serde(default, rename = "side")]
    _side: Option<Side>,
    bone: String,
    origin: AttachmentTable,
    insertion: AttachmentTable,
    #[serde(default = "default_exponent")]
    alpha: u32,
    #[serde(default = "default_exponent")]
    beta: u32,
    #[serde(default)]
    eccentricity: f32,
    width: Option<f32>,
    volume: Option<toml::Spanned<f32>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Side {
    Left,
    Right,
    Centre,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AttachmentTable {
    bone: String,
    offset: [f32; 3],
    #[serde(default = "default_normal")]
    normal: [f32; 3],
}

fn default_exponent() -> u32 {
    3
}

fn default_normal() -> [f32; 3] {
    [0.0, 0.0, 1.0]
}

/// Reads the muscles of a file.
///
/// # Errors
/// The file cannot be read, or is not a muscle file: line and column are named.
pub fn read(path: &Path) -> Result<Vec<MuscleSpec>, MuscleFileError> {
    let text = std::fs::read_to_string(path).map_err(|source| MuscleFileError::Read { path: path.into(), source })?;
    parse(&text, path)
}

/// Reads the muscles of a text; `path` is for messages.
///
/// # Errors
/// As [`read`], less the file system's.
pub fn parse(text: &str, path: &Path) -> Result<Vec<MuscleSpec>, MuscleFileError> {
    let at = |offset: usize, message: String| {
        let before = &text[..offset.min(text.len())];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        MuscleFileError::Parse {
            path: path.into(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            message: message.split_whitespace().collect::<Vec<_>>().join(" "),
        }
    };
    let file: File = toml::from_str(text)
        .map_err(|error| at(error.span().map_or(0, |span| span.start), error.message().to_owned()))?;
    let mut specs: Vec<MuscleSpec> = Vec::with_capacity(file.muscles.len());
    for table in file.muscles {
        // The name's own place is the best pointer that the parser keeps for a muscle as a whole.
        let place = text.find(&format!("\"{}\"", table.name)).unwrap_or(0);
        if specs.iter().any(|s| s.name == table.name) {
            return Err(at(place, format!("muscle `{}` stands twice; names must differ", table.name)));
        }
        let size = match (table.width, table.volume) {
            (Some(width), None) => MuscleSize::Width(width),
            (None, Some(volume)) => MuscleSize::Volume(volume.into_inner()),
            (None, None) => {
                return Err(at(place, format!("muscle `{}` needs `width` (m) or `volume` (m^3)", table.name)));
            }
            (Some(_), Some(volume)) => {
                let why = format!("muscle `{}` has both `width` and `volume`; keep one", table.name);
                return Err(at(volume.span().start, why));
            }
        };
        let shape =
            MuscleShape { alpha: table.alpha, beta: table.beta, eccentricity: table.eccentricity, ..MuscleShape::REST };
        let spec = MuscleSpec::new(&table.name, &table.bone, table.origin.into(), table.insertion.into(), size);
        specs.push(MuscleSpec { rest: shape, active: shape, ..spec });
    }
    Ok(specs)
}

impl From<AttachmentTable> for Attachment {
    fn from(table: AttachmentTable) -> Attachment {
        Attachment { bone: table.bone, offset: Vec3::from(table.offset), normal: Vec3::from(table.normal) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
[[muscle]]
name = "biceps"
bone = "upperarm"
origin = { bone = "upperarm", offset = [0.0, 0.02, 0.01] }
insertion = { bone = "lowerarm", offset = [0.0, 0.03, 0.0], normal = [1.0, 0.0, 0.0] }
width = 0.02
"#;

    fn failure(text: &str) -> String {
        parse(text, Path::new("arm.muscles.toml")).expect_err("must be refused").to_string()
    }

    #[test]
    fn a_minimal_muscle_has_the_default_shape() {
        let muscles = parse(GOOD, Path::new("x")).expect("good file");
        assert_eq!(muscles.len(), 1);
        assert_eq!(muscles[0].rest, MuscleShape::REST);
        assert_eq!(muscles[0].size, MuscleSize::Width(0.02));
        assert_eq!(muscles[0].origin.normal, Vec3::Z);
    }

    #[test]
    fn mistakes_name_line_and_column() {
        assert!(failure(&GOOD.replace("width", "widht")).starts_with("arm.muscles.toml:7:1: unknown field `widht`"));
        assert!(failure(&GOOD.replace("0.02\n", "\"wide\"\n")).starts_with("arm.muscles.toml:7:9: invalid type"));
        assert!(failure(&GOOD.replace("width = 0.02", "")).contains("needs `width`"));
        assert!(
            failure(&format!("{GOOD}volume = 1e-4\n")).starts_with("arm.muscles.toml:8:10: muscle `biceps` has both")
        );
        assert!(failure(&format!("{GOOD}{GOOD}")).contains("stands twice"));
        assert!(failure("[[muscle]").starts_with("arm.muscles.toml:1:"));
        for text in ["", GOOD] {
            assert!(!failure(&format!("{text}\nnonsense")).contains('\n'));
        }
    }
}
