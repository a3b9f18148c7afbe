//! Figure 10: a frame of the built-in arm as its schedule has it.

use super::plot::{Align, Label, PALE, Page, RULE, SERIES, polyline};
use super::{Arm, Drawn, Figure, Finding};
use crate::error::FigureError;
use crate::reference::{Motion, Reference};
use crate::schedule::{DynamicsOptions, Entry, FrameOptions, KernelId, outline};

const WIDTH: u32 = 1080;
const TOP: f64 = 112.0;
const ROW: f64 = 34.0;
/// Left ends of names and words, right ends of numbers, pixels; and by how much a repetition is indented.
const NAMES: f64 = 60.0;
const WORDS: f64 = 430.0;
const NUMBERS: [f64; 2] = [900.0, 1040.0];
const INDENT: f64 = 62.0;
/// Which frame of the curl is shown: one under way.
const FRAME: usize = 2;

/// What a kernel does, and which colour of the series it has: muscles, tracker, output.
fn words(kernel: KernelId, projects: bool, carries: bool) -> (&'static str, usize) {
    match kernel {
        KernelId::JointStep if carries => ("joints on to the frame", 2),
        KernelId::MusclePredict if carries => ("axes on to the frame", 2),
        KernelId::JointStep => ("joints at the end of a substep", 2),
        KernelId::MusclePredict => ("muscles on by their own motion", 2),
        KernelId::MuscleProject => ("springs, bones, muscles, skin", 2),
        KernelId::MuscleShape => ("axes, length, width, section", 2),
        KernelId::GroupBound => ("spheres around groups and muscles", 1),
        KernelId::TrackStart => ("skin from geometric skinning", 1),
        KernelId::TrackCarry => ("skin on with its joints", 1),
        KernelId::TrackPlace => ("groups as vertices see them", 1),
        KernelId::TrackFold => ("what folding joints displace", 1),
        KernelId::TrackMarch if projects => ("last steps to the iso-values", 1),
        KernelId::TrackMarch => ("a step to the iso-values", 1),
        KernelId::TrackTurn => ("how the skin has turned", 1),
        KernelId::TrackSpan => ("what its edges come to", 1),
        KernelId::TrackSlide => ("the skin relaxed along the field", 1),
        KernelId::TrackAverage if projects => ("pressed skin smoothed", 1),
        KernelId::TrackAverage => ("the skin to its neighbours' mean", 1),
        KernelId::TrackSpread => ("copies at seams", 3),
        KernelId::Normals => ("normals and vertex buffer", 3),
        KernelId::SkinWeighted => ("skinned vertices to their muscles", 3),
        KernelId::MuscleJoint => ("muscles as joints", 2),
        KernelId::SkinHybrid => ("skinning by bones and muscles", 3),
        KernelId::SkinLinear | KernelId::SkinDualQuaternion => ("geometric skinning", 3),
        KernelId::FieldSample | KernelId::MuscleSample | KernelId::OperatorSample => ("samples", 3),
    }
}

/// The figure.
pub(super) fn figure(arm: &Arm) -> Result<Drawn, FigureError> {
    let options = FrameOptions { dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() };
    let reference = Reference::new(&arm.settled);
    let mut motion = Motion::new(&arm.settled, &options);
    let shown = arm.curl.get(FRAME).or(arm.curl.last()).ok_or_else(|| Figure::Schedule.lacks("a pose of the arm"))?;
    for pose in arm.curl.iter().take(FRAME) {
        reference.advance(&mut motion, pose, &options)?;
    }
    let steps = reference.next(&mut motion, shown, &options)?.steps;
    let entries = outline(&steps);
    let height = TOP + ROW * entries.iter().map(rows).sum::<u32>() as f64 + 70.0;
    let mut page = Page::new(WIDTH, height as u32)?;
    Label::new("One frame of the built-in arm", 21.0).draw(&mut page, 0.5 * f64::from(WIDTH), 34.0)?;
    for (name, x, align) in [
        ("kernel", NAMES, Align::Left),
        ("what it does", WORDS, Align::Left),
        ("threads", NUMBERS[0], Align::Right),
        ("a frame", NUMBERS[1], Align::Right),
    ] {
        Label::new(name, 15.0).align(align).color(PALE).draw(&mut page, x, TOP - 26.0)?;
    }
    let mut y = TOP;
    for entry in &entries {
        draw(&mut page, entry, 0, 1, &mut y)?;
    }
    let note = format!("{} dispatches; the CPU reference plays the same list", steps.len());
    Label::new(&note, 16.0).color(PALE).draw(&mut page, 0.5 * f64::from(WIDTH), y + 30.0)?;
    let of = |wanted: &[KernelId]| steps.iter().filter(|step| wanted.contains(&step.kernel)).count() as f64;
    let findings = vec![
        Finding::new("dispatches of a frame", steps.len() as f64, ""),
        Finding::new("sub-poses", of(&[KernelId::TrackCarry]), ""),
        Finding::new("marches", of(&[KernelId::TrackMarch]), ""),
        Finding::new("sweeps of relaxation", of(&[KernelId::TrackSlide]), ""),
        Finding::new(
            "dispatches that move muscles",
            of(&[KernelId::JointStep, KernelId::MusclePredict, KernelId::MuscleProject]),
            "",
        ),
    ];
    Ok(Drawn { image: page.finish(), findings })
}

/// Lines that an entry takes.
fn rows(entry: &Entry) -> u32 {
    match entry {
        Entry::Step { .. } => 1,
        Entry::Repeat { entries, .. } => entries.iter().map(rows).sum(),
    }
}

fn draw(page: &mut Page, entry: &Entry, depth: u32, times: u32, y: &mut f64) -> Result<(), FigureError> {
    let left = NAMES + INDENT * f64::from(depth);
    match entry {
        Entry::Step { kernel, items, projects, carries } => {
            let (what, series) = words(*kernel, *projects, *carries);
            let middle = *y + 0.5 * ROW;
            page.dot([left + 5.0, middle], 5.0, SERIES[series])?;
            let name = kernel.name().replace('_', " ");
            Label::new(&name, 17.0).align(Align::Left).draw(page, left + 20.0, middle)?;
            Label::new(what, 15.0).align(Align::Left).color(PALE).draw(page, WORDS, middle)?;
            for (number, right) in [*items, times].into_iter().zip(NUMBERS) {
                Label::new(&number.to_string(), 16.0).align(Align::Right).draw(page, right, middle)?;
            }
            *y += ROW;
            polyline(page, &[[WORDS, *y], [NUMBERS[1], *y]], RULE, 1.0)
        }
        Entry::Repeat { times: own, entries } => {
            let top = *y;
            for inner in entries {
                draw(page, inner, depth + 1, times * own, y)?;
            }
            let (bracket, low, high) = (left + INDENT - 14.0, top + 4.0, *y - 4.0);
            polyline(page, &[[bracket + 8.0, low], [bracket, low], [bracket, high], [bracket + 8.0, high]], PALE, 1.8)?;
            let label = format!("{own} ×");
            Label::new(&label, 17.0).align(Align::Right).draw(page, bracket - 8.0, 0.5 * (low + high))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::motion::tests::arm;
    use super::*;

    #[test]
    fn the_chart_counts_what_the_frame_dispatches() {
        let arm = arm();
        let drawn = figure(&arm).expect("a figure");
        let found = |name: &str| drawn.findings.iter().find(|f| f.name == name).expect("a finding").value;
        let sub_poses = found("sub-poses");
        assert!(sub_poses >= 1.0);
        // Five passes of a march and four sweeps each, and six last marches.
        assert_eq!(found("marches"), 5.0 * sub_poses + 6.0);
        assert_eq!(found("sweeps of relaxation"), 20.0 * sub_poses);
        assert_ne!(found("marches"), 5.0 * sub_poses, "without the last ones");
        assert!(drawn.image.width >= 900 && drawn.image.height >= 500, "{}", drawn.image.height);
    }
}
