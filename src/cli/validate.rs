//! `sinew validate`: a muscle file against its character. Needs no adapter and fits no fields.

use crate::args::{self, Input};
use crate::failure::Failure;
use crate::{load, print};
use serde::Serialize;
use sinew::rig::muscle::Source;
use sinew::rig::{Attachment, Character, MuscleSize, MuscleSpec};
use std::path::PathBuf;

#[derive(Serialize)]
struct Validated {
    character: String,
    muscle_file: PathBuf,
    muscles: Vec<Muscle>,
    bones: Vec<String>,
}

#[derive(Serialize)]
struct Muscle {
    name: String,
    bone: String,
    fibres: u32,
    rest_length_metres: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    width_metres: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    volume_cubic_metres: Option<f32>,
    drivers: Vec<&'static str>,
    keyed: bool,
}

pub fn run(args: &args::Validate) -> Result<(), Failure> {
    let input = Input { file: args.file.clone(), muscles: Some(args.muscles.clone()) };
    let (scene, file) = load::input(&input)?;
    // Resolves every muscle against the skeleton; fields say nothing about the file.
    load::rig(&input, &scene, &file, false, None)?;
    let validated = Validated {
        character: scene.character.name.clone(),
        muscle_file: args.muscles.clone(),
        muscles: file.muscles.iter().map(|spec| muscle(spec, &scene.character)).collect(),
        bones: file.bones.iter().map(|b| b.bone.clone()).collect(),
    };
    print::noted(args.json, &validated, &file.notes, text)
}

fn muscle(spec: &MuscleSpec, character: &Character) -> Muscle {
    let place = |end: &Attachment| {
        let joint = character.joints.iter().find(|j| j.name == end.bone);
        joint.map(|j| j.bind().transform_point3(end.offset)).unwrap_or_default()
    };
    let (width_metres, volume_cubic_metres) = match spec.size {
        MuscleSize::Width(width) => (Some(width), None),
        MuscleSize::Volume(volume) => (None, Some(volume)),
    };
    let kind = |source: &Source| match source {
        Source::Length { .. } => "length",
        Source::Angle { .. } => "angle",
        Source::Constant(_) => "constant",
        Source::Table { .. } => "table",
    };
    Muscle {
        name: spec.name.clone(),
        bone: spec.bone.clone(),
        fibres: spec.fibres.as_ref().map_or(1, |set| set.count),
        rest_length_metres: place(&spec.origin).distance(place(&spec.insertion)),
        width_metres,
        volume_cubic_metres,
        drivers: spec.drive.drivers.iter().map(|d| kind(&d.source)).collect(),
        keyed: spec.keys != Default::default(),
    }
}

fn text(found: &Validated) -> String {
    let (count, file, character) = (found.muscles.len(), found.muscle_file.display(), &found.character);
    let some = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let (muscles, bones) = (some(count, "muscle"), some(found.bones.len(), "bone shape"));
    let mut text = format!("{file}: {muscles} and {bones} fit {character}\n");
    for m in &found.muscles {
        let size = match (m.width_metres, m.volume_cubic_metres) {
            (Some(width), _) => format!("radius {:.2} cm", width * 100.0),
            (_, volume) => format!("{:.0} ml", volume.unwrap_or(0.0) * 1e6),
        };
        let fibres = if m.fibres > 1 { format!(", {} fibres", m.fibres) } else { String::new() };
        let keyed = if m.keyed { ", keyed" } else { "" };
        let drivers = if m.drivers.is_empty() { "nothing".into() } else { m.drivers.join(", ") };
        let length = m.rest_length_metres * 100.0;
        text += &format!("  {}: on {}, {length:.1} cm, {size}{fibres}; driven by {drivers}{keyed}\n", m.name, m.bone);
    }
    text
}
