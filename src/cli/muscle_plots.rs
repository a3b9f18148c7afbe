//! `sinew muscles plot`: what the muscles of a file do over a clip, as graphs and as a table.

use crate::args::{MusclesPlot, Skin};
use crate::deform::{Deformer, Machine};
use crate::failure::Failure;
use crate::load::{self, Frames};
use crate::playback::{Moves, Playback};
use crate::print;
use crate::progress::Progress;
use serde::Serialize;
use sinew::dynamics::Bodies;
use sinew::error::OutputError;
use sinew::figures::charts::{self, Moment, Moving};
use sinew::io::atomic::{FileSet, WholeFile};
use sinew::io::png;
use sinew::rig::{FrameInputs, Rig};
use sinew::schedule::{DynamicsOptions, Mode};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

const TABLE: &str = "muscles.csv";

#[derive(Serialize)]
struct Plotted {
    output: PathBuf,
    table: PathBuf,
    motion: String,
    frames: u32,
    muscles: Vec<One>,
    device: String,
    seconds: f64,
}

/// The extremes of one muscle.
#[derive(Serialize)]
struct One {
    muscle: String,
    page: PathBuf,
    shortest_m: f64,
    longest_m: f64,
    /// Largest deviation from the volume that it is to have.
    volume_off_percent: f64,
    fastest_m_per_s: f64,
    /// Absent in `pbd` mode.
    elastic_violation_percent: Option<f64>,
    deepest_in_bone_percent_of_radius: f64,
    deepest_in_muscle_mm: f64,
    farthest_outside_skin_mm: f64,
}

pub fn run(args: &MusclesPlot) -> Result<(), Failure> {
    load::threads(args.compute.threads)?;
    let Some(dynamics) = args.dynamics.options()? else {
        return Err(Failure::Usage(
            "muscles plot shows muscles in motion, and --dynamics is off; leave it out, or give xpbd".into(),
        ));
    };
    let (scene, muscles) = load::input(&args.input)?;
    if muscles.muscles.is_empty() {
        return Err(Failure::Usage("muscles plot needs --muscles with a file that has some".into()));
    }
    let frames = Frames::choose(&args.input.file, &scene, &args.motion)?;
    let options = load::options(Skin::DEFAULT, &args.dynamics, &muscles, true)?;
    // Before the long work, so that a missing adapter or an output that cannot be written is known at once.
    let machine = Machine::open(&args.compute.device)?;
    let mut files = FileSet::open(&args.output).map_err(Failure::input)?;
    let rig = Arc::new(load::rig(&args.input, &scene, &muscles, true, Some(&dynamics))?);
    let mut deformer = Deformer::new(machine, &rig, &options)?;
    let began = Instant::now();
    let mut playback = Playback::new(&scene, &frames, &rig, true);
    let rows = measure(&rig, &mut playback, &frames, &mut deformer, &dynamics)?;
    let motion = format!("{}, {}", frames.describe(&scene), mode(&dynamics));
    let muscles = write(&rig, &motion, &rows, &frames, &mut files, &args.output)?;
    files.keep().map_err(Failure::input)?;
    let plotted = Plotted {
        output: args.output.clone(),
        table: args.output.join(TABLE),
        motion,
        frames: frames.count(),
        muscles,
        device: deformer.describe(),
        seconds: began.elapsed().as_secs_f64(),
    };
    print::noted(args.json, &plotted, &scene.notes, text)
}

/// How the muscles move, in words.
fn mode(dynamics: &DynamicsOptions) -> String {
    match dynamics.mode {
        Mode::Xpbd => format!("xpbd at {} Hz", dynamics.frequency),
        Mode::Pbd => "pbd".into(),
    }
}

/// All muscles at every frame.
fn measure(
    rig: &Rig,
    playback: &mut Playback,
    frames: &Frames,
    deformer: &mut Deformer,
    dynamics: &DynamicsOptions,
) -> Result<Vec<Vec<Moment>>, Failure> {
    let bodies = Bodies::new(rig);
    let progress = Progress::steps("measuring", u64::from(frames.count()));
    let mut rows = Vec::new();
    for number in frames.numbers() {
        let pose = playback.pose(number, deformer)?;
        deformer.pass(&pose)?;
        let shaped = deformer.shaped()?;
        let moving = Moving {
            rig,
            bodies: &bodies,
            muscles: &shaped.muscles,
            axes: &shaped.axes,
            particles: &shaped.particles,
            iterates: &shaped.iterates,
            balances: dynamics.mode == Mode::Xpbd,
        };
        let inputs = FrameInputs::new(rig, &pose).map_err(Failure::input)?;
        rows.push(moving.moments(&inputs, f64::from(number) / f64::from(frames.fps)));
        progress.step()?;
    }
    Ok(rows)
}

/// Writes a page per muscle and the table; `rows` are the frames.
fn write(
    rig: &Rig,
    motion: &str,
    rows: &[Vec<Moment>],
    frames: &Frames,
    files: &mut FileSet,
    output: &Path,
) -> Result<Vec<One>, Failure> {
    let progress = Progress::steps("drawing", rig.muscle_names.len() as u64);
    let mut found = Vec::new();
    for (index, name) in rig.muscle_names.iter().enumerate() {
        let moments: Vec<Moment> = rows.iter().map(|row| row[index]).collect();
        let image = charts::page(name, motion, &moments).map_err(Failure::input)?;
        let file = file_name(index, name);
        files.write(&file, |path| png::write(path, image.width, image.height, &image.rgba)).map_err(Failure::input)?;
        found.push(extremes(name, output.join(file), &moments));
        progress.step()?;
    }
    files.write(TABLE, |path| write_table(path, rig, rows, frames)).map_err(Failure::input)?;
    Ok(found)
}

/// A name of its own for each muscle's page, which any file system takes; in the muscle file's order.
fn file_name(index: usize, muscle: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    format!("{index:02}_{}.png", muscle.chars().map(plain).collect::<String>())
}

/// One line per muscle and frame.
fn write_table(path: &Path, rig: &Rig, rows: &[Vec<Moment>], frames: &Frames) -> Result<(), OutputError> {
    let mut file = WholeFile::create(path)?;
    let headings = Moment::COLUMNS.map(|(heading, _)| heading);
    file.put(format!("muscle,frame,{}\n", headings.join(",")).as_bytes())?;
    for (index, name) in rig.muscle_names.iter().enumerate() {
        let name = format!("\"{}\"", name.replace('"', "\"\""));
        for (row, frame) in rows.iter().zip(frames.numbers()) {
            let cells = Moment::COLUMNS.map(|(_, value)| cell(value(&row[index])));
            file.put(format!("{name},{frame},{}\n", cells.join(",")).as_bytes())?;
        }
    }
    file.finish()
}

/// A number in seven digits, which is what single precision has; nothing for what is not known.
fn cell(value: f64) -> String {
    if value.is_nan() { String::new() } else { format!("{:?}", (value as f32)) }
}

fn extremes(name: &str, page: PathBuf, moments: &[Moment]) -> One {
    let most = |value: fn(&Moment) -> f64| moments.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
    let violation = most(|m| m.violation);
    One {
        muscle: name.into(),
        page,
        shortest_m: -most(|m| -m.length),
        longest_m: most(|m| m.length),
        volume_off_percent: 100.0 * most(|m| (m.volume / m.wanted - 1.0).abs()),
        fastest_m_per_s: most(|m| m.speed),
        elastic_violation_percent: violation.is_finite().then_some(violation),
        deepest_in_bone_percent_of_radius: most(|m| m.bone),
        deepest_in_muscle_mm: most(|m| m.muscle),
        farthest_outside_skin_mm: most(|m| m.outside),
    }
}

fn text(p: &Plotted) -> String {
    let widest = p.muscles.iter().map(|m| m.muscle.chars().count()).max().unwrap_or(0).max(6);
    let mut text = format!(
        "{:widest$}  {:>14}  {:>8}  {:>8}  {:>8}  {:>8}  {:>8}  {:>8}\n",
        "muscle", "length", "volume", "fastest", "springs", "in bone", "in other", "outside"
    );
    for m in &p.muscles {
        let springs = m.elastic_violation_percent.map_or("-".into(), |v| format!("{v:.2} %"));
        text += &format!(
            "{:widest$}  {:>5.3}..{:.3} m  {:>6.2} %  {:>4.2} m/s  {springs:>8}  {:>6.2} %  {:>5.2} mm  {:>5.2} mm\n",
            m.muscle,
            m.shortest_m,
            m.longest_m,
            m.volume_off_percent,
            m.fastest_m_per_s,
            m.deepest_in_bone_percent_of_radius,
            m.deepest_in_muscle_mm,
            m.farthest_outside_skin_mm,
        );
    }
    text + &format!(
        "{}: {} pages and {TABLE}, {}\nmoved on {} in {:.2} s",
        p.output.display(),
        p.muscles.len(),
        p.motion,
        p.device,
        p.seconds
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_page_has_a_name_that_any_file_system_takes() {
        assert_eq!(file_name(3, "biceps_l"), "03_biceps_l.png");
        assert_eq!(file_name(12, "a/b: \"c\""), "12_a_b___c_.png");
        assert_ne!(file_name(0, "a/b"), file_name(1, "a:b"));
    }

    #[test]
    fn cells_hold_what_single_precision_does() {
        assert_eq!([0.25, 1.0 / 3.0, f64::NAN].map(cell), ["0.25", "0.33333334", ""]);
    }
}
