//! `sinew bake`: deformed vertices as a cache.

use crate::args;
use crate::deform::{Deformer, Machine};
use crate::failure::Failure;
use crate::load::{self, Frames};
use crate::playback::Playback;
use crate::print;
use crate::progress::Progress;
use serde::Serialize;
use sinew::error::OutputError;
use sinew::io::atomic::FileSet;
use sinew::io::{obj, pc2};
use sinew::rig::Character;
use sinew::schedule::{FrameOptions, Skinning};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

#[derive(Serialize)]
struct Baked {
    output: PathBuf,
    format: &'static str,
    motion: String,
    frames: u32,
    vertices: usize,
    /// Vertices that fields can move; absent without implicit skinning.
    active_vertices: Option<usize>,
    device: String,
    seconds: f64,
}

pub fn run(args: &args::Bake) -> Result<(), Failure> {
    load::threads(args.compute.threads)?;
    let format = Format::of(&args.output)?;
    let (mut scene, muscles) = load::input(&args.input)?;
    let frames = Frames::choose(&args.input.file, &scene, &args.motion)?;
    // Both are opened before the long work, so that a missing adapter or an output that cannot be written is known at once.
    let machine = Machine::open(&args.compute.device)?;
    let mut sink = Sink::open(&args.output, format, &scene.character, &frames)?;
    let options = FrameOptions { skinning: args.skinning.into(), ..FrameOptions::default() };
    load::note_idle_muscles(&mut scene, &muscles, options.skinning == Skinning::Implicit);
    let rig = Arc::new(load::rig(&args.input, &scene, &muscles, options.skinning == Skinning::Implicit)?);
    let mut deformer = Deformer::new(machine, &rig, &options)?;
    let began = Instant::now();
    play(&scene.character, &mut Playback::new(&scene, &frames, &rig), &frames, &mut deformer, &options, &mut sink)?;
    sink.finish()?;
    let baked = Baked {
        output: args.output.clone(),
        format: format.name(),
        motion: frames.describe(&scene),
        frames: frames.count(),
        vertices: scene.character.vertex_count(),
        active_vertices: load::active(&rig, options.skinning),
        device: deformer.describe(),
        seconds: began.elapsed().as_secs_f64(),
    };
    print::noted(args.json, &baked, &scene.notes, |b| {
        format!(
            "{}: {} of {} vertices, {}\ndeformed on {} in {:.2} s{}",
            b.output.display(),
            b.format,
            b.vertices,
            b.motion,
            b.device,
            b.seconds,
            load::inactive_text(b.active_vertices)
        )
    })
}

fn play(
    character: &Character,
    playback: &mut Playback,
    frames: &Frames,
    deformer: &mut Deformer,
    options: &FrameOptions,
    sink: &mut Sink,
) -> Result<(), Failure> {
    let progress = Progress::steps("baking", u64::from(frames.count()));
    for number in frames.numbers() {
        let skin = deformer.frame(&playback.pose(number)?, options)?;
        match sink {
            Sink::Pc2(writer) => writer.frame(&skin.positions).map_err(Failure::input)?,
            Sink::Obj { set, stem } => {
                set.write(&format!("{stem}_{number:04}.obj"), |path| {
                    obj::write_frame(path, number, character, &skin.positions, &skin.normals)
                })
                .map_err(Failure::input)?;
            }
        }
        progress.step()?;
    }
    Ok(())
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Pc2,
    ObjSequence,
}

impl Format {
    /// By the extension of `-o`; no extension is a folder.
    fn of(output: &Path) -> Result<Format, Failure> {
        let extension = output.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("pc2") => Ok(Format::Pc2),
            Some("obj") | None => Ok(Format::ObjSequence),
            Some(_) if output.is_dir() => Ok(Format::ObjSequence),
            Some(other) => Err(Failure::Input(format!(
                "{}: .{other} is no format of bake; give NAME.pc2, or NAME.obj or a folder for a sequence of OBJ files",
                output.display()
            ))),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Format::Pc2 => "PC2 cache",
            Format::ObjSequence => "OBJ sequence",
        }
    }
}

/// Where frames go. Dropped before it is finished, it leaves nothing.
enum Sink {
    Pc2(pc2::Writer),
    Obj { set: FileSet, stem: String },
}

impl Sink {
    fn open(output: &Path, format: Format, character: &Character, frames: &Frames) -> Result<Sink, Failure> {
        let open = || -> Result<Sink, OutputError> {
            match format {
                Format::Pc2 => {
                    let points = character.vertex_count();
                    Ok(Sink::Pc2(pc2::Writer::create(output, points, frames.range.first, frames.count())?))
                }
                Format::ObjSequence => {
                    let named = output.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) && !output.is_dir();
                    let (folder, stem) = if named {
                        let stem = output.file_stem().map(|s| s.to_string_lossy().into_owned());
                        (output.parent().unwrap_or(Path::new("")).to_owned(), stem.unwrap_or_default())
                    } else {
                        (output.to_owned(), "frame".to_owned())
                    };
                    Ok(Sink::Obj { set: FileSet::open(&folder)?, stem })
                }
            }
        };
        open().map_err(Failure::input)
    }

    fn finish(self) -> Result<(), Failure> {
        match self {
            Sink::Pc2(writer) => writer.finish().map_err(Failure::input),
            Sink::Obj { set, .. } => {
                set.keep().map_err(Failure::input)?;
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_chooses_the_format() {
        assert_eq!(Format::of(Path::new("a/b.PC2")).expect("known"), Format::Pc2);
        assert_eq!(Format::of(Path::new("walk.obj")).expect("known"), Format::ObjSequence);
        assert_eq!(Format::of(Path::new("out/frames")).expect("known"), Format::ObjSequence);
        assert!(matches!(Format::of(Path::new("walk.abc")), Err(Failure::Input(text)) if text.contains(".abc")));
    }
}
