//! `sinew extract`: muscles found in the skin, as a muscle file. Needs no adapter and fits no fields.

use crate::args;
use crate::extract_report::{self, TABLE};
use crate::failure::Failure;
use crate::loft_meshes;
use crate::print;
use crate::progress::Progress;
use serde::Serialize;
use sinew::extract::{self, Extracted, limb::Verdict};
use sinew::io::atomic::WholeFile;
use sinew::rig::{muscle::MarkSpec, muscle_file::Document, roles::Roles};
use std::path::PathBuf;
use std::time::Instant;

#[derive(Serialize)]
struct Report {
    character: String,
    output: PathBuf,
    muscles: Vec<Muscle>,
    sections: usize,
    planes_without_outline: usize,
    bones: usize,
    joints: usize,
    short: usize,
    seconds: f64,
    /// The folder of the report, and how many files it has.
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    files: Option<usize>,
    /// The lofted surfaces.
    #[serde(skip_serializing_if = "Option::is_none")]
    meshes: Option<loft_meshes::Written>,
}

#[derive(Serialize)]
struct Muscle {
    name: String,
    bone: String,
    degrees: f64,
    sections: usize,
    width_metres: f32,
    alpha: u32,
    beta: u32,
    profile_rms_millimetres: f64,
    ellipse_rms_millimetres: f64,
    skin_rms_millimetres: f64,
    confidence: f64,
    /// Whether the file had a muscle of that name, which stays as it was.
    kept: bool,
}

pub fn run(args: &args::Extract) -> Result<(), Failure> {
    let mut scene = sinew::io::gltf::read(&args.file).map_err(Failure::input)?;
    let mut document = match args.output.exists() {
        true => Document::open(&args.output),
        false => Document::parse(&head(&scene.character.name), &args.output),
    }
    .map_err(Failure::input)?;
    let before = document.file().map_err(Failure::input)?;
    let marks: Vec<MarkSpec> =
        before.marks.iter().cloned().chain(args.must.iter().map(|mark| mark.0.clone())).collect();
    let started = Instant::now();
    let roles = Roles::find(&scene.character);
    let progress = Progress::unknown("looking for muscles");
    let extraction = extract::extract(&scene.character, &roles, &marks).map_err(Failure::input)?;
    drop(progress);
    let seconds = started.elapsed().as_secs_f64();
    scene.notes.extend(extraction.notes.iter().map(ToString::to_string));
    let names = || extraction.muscles.iter().map(|m| m.spec.name.as_str());
    if let Some(unknown) = args.without.iter().find(|name| !names().any(|n| n == name.as_str())) {
        let found = names().collect::<Vec<_>>().join(", ");
        return Err(Failure::Usage(format!("--without {unknown}: no such muscle was found; there are {found}")));
    }
    let wanted = |found: &&Extracted| !args.without.contains(&found.spec.name);
    let is_there = |found: &Extracted| before.muscle(&found.spec.name).is_some();
    for muscle in extraction.muscles.iter().filter(wanted).filter(|m| !is_there(m)) {
        document.add(&muscle.spec).map_err(Failure::input)?;
    }
    let mut file = WholeFile::create(&args.output).map_err(Failure::input)?;
    file.put(document.to_string().as_bytes()).map_err(Failure::input)?;
    let drawn = match &args.report {
        Some(folder) => Some(extract_report::write(folder, &scene.character, &roles, &extraction)?),
        None => None,
    };
    let found: Vec<&Extracted> = extraction.muscles.iter().filter(wanted).collect();
    let lofted = |folder: &PathBuf| loft_meshes::write(args, folder, &scene, &found);
    let meshes = args.meshes.as_ref().map(lofted).transpose()?;
    file.finish().map_err(Failure::input)?;
    let regions = || extraction.regions.iter().map(|(_, found)| found).chain(extraction.sweeps.iter().map(|(_, f)| f));
    let verdicts = |wanted| regions().flat_map(|found| &found.bellies).filter(|(_, v)| *v == wanted).count();
    let report = Report {
        character: scene.character.name.clone(),
        output: args.output.clone(),
        muscles: extraction.muscles.iter().filter(wanted).map(|found| muscle(found, is_there(found))).collect(),
        sections: regions().map(|found| found.sections.len()).sum(),
        planes_without_outline: regions().map(|found| found.rejected).sum(),
        bones: verdicts(Verdict::Ridge) + verdicts(Verdict::Bone),
        joints: verdicts(Verdict::Joint),
        short: verdicts(Verdict::Short),
        seconds,
        report: args.report.clone(),
        files: drawn,
        meshes,
    };
    print::noted(args.json, &report, &scene.notes, text)
}

fn head(character: &str) -> String {
    // A string in JSON is one in TOML.
    let name = serde_json::Value::from(character);
    format!(
        "# Muscles that `sinew extract` found in the skin. Lengths are metres, offsets and normals in the bone's own space.\n\
         # Names are proposals. Edit what you know better.\n\n[character]\nname = {name}\n"
    )
}

fn muscle(found: &Extracted, kept: bool) -> Muscle {
    Muscle {
        name: found.spec.name.clone(),
        bone: found.spec.bone.clone(),
        degrees: found.degrees,
        sections: found.sections,
        width_metres: found.width(),
        alpha: found.spec.rest.alpha,
        beta: found.spec.rest.beta,
        profile_rms_millimetres: found.profile_rms * 1e3,
        ellipse_rms_millimetres: found.ellipse_rms * 1e3,
        skin_rms_millimetres: found.skin_rms * 1e3,
        confidence: found.confidence,
        kept,
    }
}

fn text(report: &Report) -> String {
    let mut text = format!(
        "{}: {} muscles, in {} sections ({} planes without an outline; of what else stands out {} are bone, {} joints, {} too \
         short) in {:.2} s\n",
        report.output.display(),
        report.muscles.len(),
        report.sections,
        report.planes_without_outline,
        report.bones,
        report.joints,
        report.short,
        report.seconds
    );
    if let (Some(folder), Some(files)) = (&report.report, report.files) {
        text += &format!("  {}: {files} files, {TABLE} among them\n", folder.display());
    }
    text += &report.meshes.as_ref().map_or(String::new(), loft_meshes::Written::describe);
    for m in &report.muscles {
        text += &format!(
            "  {}: shapes {} at {:.0} degrees, radius {:.1} cm, {} sections; ellipses {:.2} mm, profile {:.2} mm, muscle {:.1} mm \
             off the skin; confidence {:.2}{}\n",
            m.name,
            m.bone,
            m.degrees,
            m.width_metres * 100.0,
            m.sections,
            m.ellipse_rms_millimetres,
            m.profile_rms_millimetres,
            m.skin_rms_millimetres,
            m.confidence,
            if m.kept { "; the file has it, and keeps its own" } else { "" }
        );
    }
    text
}
