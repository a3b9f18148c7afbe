//! `sinew muscles`: edits of the muscle file that leave comments, order and spacing alone, and plots of its muscles.

use crate::args::{Muscles, MusclesCopy, MusclesMirror, MusclesVerb};
use crate::failure::Failure;
use crate::muscle_plots;
use crate::muscle_weights;
use crate::print;
use serde::Serialize;
use sinew::io::atomic::WholeFile;
use sinew::rig::muscle_file::{Document, Settings, SideNames};
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Edited {
    output: PathBuf,
    added: Vec<String>,
    updated: Vec<String>,
    bones: Vec<String>,
    joints: Vec<String>,
    groups: Vec<String>,
    alone: Vec<String>,
}

pub fn run(args: &Muscles) -> Result<(), Failure> {
    match &args.verb {
        MusclesVerb::Mirror(args) => mirror(args),
        MusclesVerb::Copy(args) => copy(args),
        MusclesVerb::Plot(args) => muscle_plots::run(args),
        MusclesVerb::Weights(args) => muscle_weights::run(args),
    }
}

fn mirror(args: &MusclesMirror) -> Result<(), Failure> {
    let mut document = Document::open(&args.file).map_err(Failure::input)?;
    let scene = sinew::io::gltf::read(&args.character).map_err(Failure::input)?;
    let names = match (&args.from, &args.to) {
        (Some(from), Some(to)) => SideNames::pattern(from, to),
        _ => SideNames::left_to_right(),
    };
    let done = document.mirror(&scene.character, &names).map_err(Failure::input)?;
    write(&args.output, &document)?;
    let edited = Edited {
        output: args.output.clone(),
        added: done.added,
        updated: done.updated,
        bones: done.bones,
        joints: done.joints,
        groups: done.groups,
        alone: done.alone,
    };
    print::result(args.json, &edited, text)
}

fn copy(args: &MusclesCopy) -> Result<(), Failure> {
    let mut document = Document::open(&args.file).map_err(Failure::input)?;
    let settings: Vec<Settings> = match &args.only[..] {
        [] => Settings::ALL.into(),
        only => only.iter().map(|&s| s.into()).collect(),
    };
    let to: Vec<&str> = args.to.iter().map(String::as_str).collect();
    document.copy(&args.from, &to, &settings).map_err(Failure::input)?;
    write(&args.output, &document)?;
    let (added, bones, joints, groups, alone) = Default::default();
    print::result(
        args.json,
        &Edited { output: args.output.clone(), added, updated: args.to.clone(), bones, joints, groups, alone },
        text,
    )
}

fn write(path: &Path, document: &Document) -> Result<(), Failure> {
    let mut file = WholeFile::create(path).map_err(Failure::input)?;
    file.put(document.to_string().as_bytes()).map_err(Failure::input)?;
    file.finish().map_err(Failure::input)
}

fn text(edited: &Edited) -> String {
    let counts = [
        ("added", &edited.added),
        ("updated", &edited.updated),
        ("bone shapes", &edited.bones),
        ("joint operators", &edited.joints),
        ("field groups", &edited.groups),
        ("without a partner", &edited.alone),
    ];
    let lines = counts.iter().filter(|(_, names)| !names.is_empty());
    let lines = lines.map(|(what, names)| format!("\n  {} {what}: {}", names.len(), names.join(" ")));
    format!("{}{}", edited.output.display(), lines.collect::<String>())
}
