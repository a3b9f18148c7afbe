//! `sinew bake`: deformed vertices as a cache.

use crate::args;
use crate::deform::{Deformer, Machine};
use crate::failure::Failure;
use crate::load::{self, Frames};
use crate::muscle_meshes;
use crate::playback::Playback;
use crate::print;
use crate::progress::Progress;
use serde::Serialize;
use sinew::error::OutputError;
use sinew::io::atomic::FileSet;
use sinew::io::{obj, pc2};
use sinew::rig::{Character, Rig};
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
    /// The muscles' surfaces; absent where they are not asked for.
    muscle_meshes: Option<muscle_meshes::Written>,
    device: String,
    seconds: f64,
}

pub fn run(args: &args::Bake) -> Result<(), Failure> {
    load::threads(args.compute.threads)?;
    let format = Format::of(&args.output)?;
    args.dynamics.options()?;
    let (mut scene, muscles) = load::input(&args.input)?;
    let frames = Frames::choose(&args.input.file, &scene, &args.motion)?;
    let fields = args.skin.needs_fields();
    let options = load::options(args.skin, &args.dynamics, &muscles, fields)?;
    let meshes = args.muscle_meshes.as_deref();
    let check = |out| muscle_meshes::Sink::check(out, muscles.muscles.len(), options.skinning);
    let meshes = meshes.map(check).transpose()?;
    // Both are opened before the long work, so that a missing adapter or an output that cannot be written is known at once.
    let machine = Machine::open(&args.compute.device)?;
    let sink = Sink::open(&args.output, format, &scene.character, &frames)?;
    let meshes = meshes.map(|place| sink.beside(place)).transpose()?;
    load::note_idle_muscles(&mut scene, &muscles, fields);
    let rig = Arc::new(load::rig_for(&options, &args.input, &scene, &muscles, fields)?);
    let mut deformer = Deformer::new(machine, &rig, &options)?;
    let began = Instant::now();
    let mut sinks = Sinks { skin: sink, meshes };
    let mut playback = Playback::new(&scene, &frames, &rig, options.remembers());
    play(&rig, &mut playback, &frames, &mut deformer, &mut sinks)?;
    sinks.skin.finish()?;
    let muscle_meshes = sinks.meshes.map(muscle_meshes::Sink::finish).transpose()?;
    let baked = Baked {
        output: args.output.clone(),
        format: format.name(),
        motion: frames.describe(&scene),
        frames: frames.count(),
        vertices: scene.character.vertex_count(),
        active_vertices: load::active(&rig, options.skinning),
        muscle_meshes,
        device: deformer.describe(),
        seconds: began.elapsed().as_secs_f64(),
    };
    print::noted(args.json, &baked, &scene.notes, |b| {
        format!(
            "{}: {} of {} vertices, {}{}\ndeformed on {} in {:.2} s{}",
            b.output.display(),
            b.format,
            b.vertices,
            b.motion,
            b.muscle_meshes.as_ref().map_or(String::new(), muscle_meshes::Written::describe),
            b.device,
            b.seconds,
            load::inactive_text(b.active_vertices)
        )
    })
}

/// All that a frame is written to. What was opened last is dropped first, because its folder may be in the other's.
struct Sinks {
    meshes: Option<muscle_meshes::Sink>,
    skin: Sink,
}

fn play(
    rig: &Rig,
    playback: &mut Playback,
    frames: &Frames,
    deformer: &mut Deformer,
    sinks: &mut Sinks,
) -> Result<(), Failure> {
    let progress = Progress::steps("baking", u64::from(frames.count()));
    for number in frames.numbers() {
        let pose = playback.pose(number, deformer)?;
        let skin = deformer.frame(&pose)?;
        match &mut sinks.skin {
            Sink::Pc2(writer) => writer.frame(&skin.positions).map_err(Failure::input)?,
            Sink::Obj { set, place } => {
                set.write(&place.file(number), |path| {
                    obj::write_frame(path, number, &rig.character, &skin.positions, &skin.normals)
                })
                .map_err(Failure::input)?;
            }
        }
        if let Some(meshes) = &mut sinks.meshes {
            meshes.frame(number, rig, &pose, &deformer.shaped()?)?;
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
        let extension = output.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match Sequence::of(output, "frame") {
            _ if extension == "pc2" => Ok(Format::Pc2),
            Some(_) => Ok(Format::ObjSequence),
            None => Err(Failure::Input(format!(
                "{}: .{extension} is no format of bake; give NAME.pc2, or NAME.obj or a folder for a sequence of OBJ files",
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

/// Names of an OBJ sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// The folder of its files.
    pub folder: PathBuf,
    stem: String,
}

impl Sequence {
    /// Of NAME.obj, or of a folder, whose files begin with `stem`; none of another extension.
    pub fn of(output: &Path, stem: &str) -> Option<Sequence> {
        let extension = output.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            _ if output.is_dir() => {}
            Some("obj") => {
                let stem = output.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
                return Some(Sequence { folder: output.parent().unwrap_or(Path::new("")).to_owned(), stem });
            }
            None => {}
            Some(_) => return None,
        }
        Some(Sequence { folder: output.to_owned(), stem: stem.into() })
    }

    /// Name of a frame's file.
    pub fn file(&self, number: u32) -> String {
        format!("{}_{number:04}.obj", self.stem)
    }

    /// Whether both name the same files; the folders exist.
    fn is_same(&self, other: &Sequence) -> bool {
        let real = |folder: &Path| {
            std::fs::canonicalize(if folder.as_os_str().is_empty() { Path::new(".") } else { folder }).ok()
        };
        self.stem == other.stem && real(&self.folder) == real(&other.folder)
    }
}

/// Where frames go. Dropped before it is finished, it leaves nothing.
enum Sink {
    Pc2(pc2::Writer),
    Obj { set: FileSet, place: Sequence },
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
                    let place = Sequence::of(output, "frame")
                        .unwrap_or_else(|| Sequence { folder: output.to_owned(), stem: "frame".into() });
                    Ok(Sink::Obj { set: FileSet::open(&place.folder)?, place })
                }
            }
        };
        open().map_err(Failure::input)
    }

    /// Opens the muscles' meshes beside this one's files.
    fn beside(&self, place: Sequence) -> Result<muscle_meshes::Sink, Failure> {
        let meshes = muscle_meshes::Sink::open(place.clone())?;
        match self {
            Sink::Obj { place: own, .. } if own.is_same(&place) => Err(Failure::Input(format!(
                "--muscle-meshes: {} is also the output's; give it another name",
                place.folder.join(place.file(0)).display()
            ))),
            _ => Ok(meshes),
        }
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
