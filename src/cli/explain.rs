//! `sinew inspect --vertex` and `--schedule`: one frame, taken apart. Plays the clip on the CPU reference.

mod vertex;

use crate::args;
use crate::failure::Failure;
use crate::load::{self, Frames};
use crate::playback::{Moves, Playback};
use crate::print;
use serde::Serialize;
use sinew::clip::Scene;
use sinew::reference::{Motion, Reference};
use sinew::rig::muscle_file::MuscleFile;
use sinew::rig::{Pose, Rig};
use sinew::schedule::{Entry, FrameOptions, KernelId, Step, outline};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Frame whose schedule is shown where none is named: the first that a motion moves to.
const FRAME: u32 = 1;

#[derive(Serialize)]
struct Schedule {
    character: String,
    motion: String,
    /// Substeps of the dynamics.
    substeps: usize,
    /// Sub-poses of the tracker.
    sub_poses: usize,
    dispatches: usize,
    /// What runs, repetitions folded.
    entries: Vec<Folded>,
    kernels: Vec<Runs>,
    /// Every dispatch, in order.
    steps: Vec<Dispatch>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Folded {
    Step { kernel: String, items: u32 },
    Repeat { times: u32, entries: Vec<Folded> },
}

#[derive(Serialize)]
struct Runs {
    kernel: String,
    dispatches: u32,
    /// Threads of all of them together, per instance.
    items: u64,
}

#[derive(Serialize)]
struct Dispatch {
    kernel: String,
    items: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    reads: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    writes: Option<String>,
    sub_pose: u32,
    outer: u32,
    projects: bool,
}

/// A rig on its way to the frame that is asked for.
struct Play<'a> {
    rig: &'a Rig,
    options: FrameOptions,
    motion: Motion,
}

impl Moves for Play<'_> {
    fn reset(&mut self) {
        self.motion = Motion::new(self.rig, &self.options);
    }

    fn pass(&mut self, pose: &Pose) -> Result<(), Failure> {
        let reference = Reference::new(self.rig);
        reference.advance(&mut self.motion, pose, &self.options).map_err(Failure::input)?;
        Ok(())
    }
}

pub fn run(args: &args::Inspect, scene: &Scene, muscles: &MuscleFile) -> Result<(), Failure> {
    let options =
        load::options(args::Skin { tracking: args.tracking, ..args::Skin::DEFAULT }, &args.dynamics, muscles, true)?;
    let motion = args::Motion { clip: args.clip.clone(), frames: None, fps: args.fps };
    let frames = Frames::choose(&args.input.file, scene, &motion)?;
    let frame = args.frame.unwrap_or(FRAME.min(frames.range.last));
    let named = |what: String| Failure::Input(format!("{}: {what}", args.input.file.display()));
    if frame > frames.range.last {
        let (clip, last) = (load::clip_name(scene, frames.clip), frames.range.last);
        return Err(named(format!(
            "--frame {frame} is outside {clip}, which has frames 0..{last} at {} fps; give one of them",
            frames.fps
        )));
    }
    let count = scene.character.vertex_count();
    if let Some(vertex) = args.vertex.filter(|&v| v as usize >= count) {
        let last = count.saturating_sub(1);
        return Err(named(format!(
            "--vertex {vertex} is not there: vertices are numbered 0 to {last}; give one of them"
        )));
    }
    let rig = load::rig(&args.input, scene, muscles, true, options.dynamics.as_ref())?;
    let mut play = Play { rig: &rig, options, motion: Motion::new(&rig, &options) };
    let pose = Playback::new(scene, &frames, &rig, true).pose(frame, &mut play)?;
    let motion = format!("{}, frame {frame} at {} fps", load::clip_name(scene, frames.clip), frames.fps);
    let Some(vertex) = args.vertex else {
        let trace = Reference::new(&rig).next(&mut play.motion, &pose, &options).map_err(Failure::input)?;
        let schedule = Schedule::new(&rig, motion, &trace.steps);
        return print::noted(args.json, &schedule, &scene.notes, text);
    };
    let found = Reference::new(&rig).explain(&mut play.motion, &pose, &options, vertex).map_err(Failure::input)?;
    let Some(found) = found else { return Err(named(format!("--vertex {vertex} is not there"))) };
    let skin = play.motion.skin.as_ref();
    let tracks = skin.map_or(&[][..], |skin| &skin.tracks);
    let positions = skin.map_or(&[][..], |skin| &skin.positions);
    let words = vertex::Vertex::new(&rig, vertex, motion, &found, (positions, tracks));
    print::noted(args.json, &words, &scene.notes, vertex::text)
}

impl Schedule {
    fn new(rig: &Rig, motion: String, steps: &[Step]) -> Schedule {
        let mut kernels: BTreeMap<KernelId, (u32, u64)> = BTreeMap::new();
        for step in steps {
            let runs = kernels.entry(step.kernel).or_default();
            *runs = (runs.0 + 1, runs.1 + u64::from(step.items));
        }
        let of = |kernel| steps.iter().filter(move |step| step.kernel == kernel);
        Schedule {
            character: rig.character.name.clone(),
            motion,
            substeps: of(KernelId::MusclePredict).filter(|step| !step.carries).count(),
            sub_poses: of(KernelId::TrackCarry).count(),
            dispatches: steps.len(),
            entries: folded(&outline(steps)),
            kernels: kernels
                .into_iter()
                .map(|(kernel, (dispatches, items))| Runs { kernel: kernel.name(), dispatches, items })
                .collect(),
            steps: steps.iter().map(dispatch).collect(),
        }
    }
}

fn folded(entries: &[Entry]) -> Vec<Folded> {
    let one = |entry: &Entry| match entry {
        Entry::Step { kernel, items, .. } => Folded::Step { kernel: kernel.name(), items: *items },
        Entry::Repeat { times, entries } => Folded::Repeat { times: *times, entries: folded(entries) },
    };
    entries.iter().map(one).collect()
}

fn dispatch(step: &Step) -> Dispatch {
    let buffer = |positions| format!("{positions:?}").to_lowercase();
    Dispatch {
        kernel: step.kernel.name(),
        items: step.items,
        reads: step.reads.map(buffer),
        writes: step.writes.map(buffer),
        sub_pose: step.sub_pose,
        outer: step.outer,
        projects: step.projects,
    }
}

fn text(schedule: &Schedule) -> String {
    let mut text = format!(
        "{}, {}: {} dispatches in {} substeps of the muscles and {} sub-poses of the skin\n",
        schedule.character, schedule.motion, schedule.dispatches, schedule.substeps, schedule.sub_poses
    );
    write_entries(&mut text, &schedule.entries, 1);
    text += "dispatches, and threads of all of them per instance:\n";
    for runs in &schedule.kernels {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {:<20} {:>5} {:>12}", runs.kernel, runs.dispatches, runs.items);
    }
    text
}

/// One line per entry; what repeats stands in braces, on one line where it is one kernel.
fn write_entries(text: &mut String, entries: &[Folded], depth: usize) {
    let indent = "  ".repeat(depth);
    for entry in entries {
        let _ = match entry {
            Folded::Step { kernel, items } => writeln!(text, "{indent}{kernel} ({items})"),
            Folded::Repeat { times, entries } => match &entries[..] {
                [Folded::Step { kernel, items }] => writeln!(text, "{indent}{times} x {kernel} ({items})"),
                several => {
                    let _ = writeln!(text, "{indent}{times} x {{");
                    write_entries(text, several, depth + 1);
                    writeln!(text, "{indent}}}")
                }
            },
        };
    }
}
