//! Figure 13: volume of the muscles over a curl and over a lively motion; beside it that of single muscles over a bend.
//!
//! The paper's lively motion is a jump; the built-in arm is shaken.

use super::motion::{FPS, Play};
use super::plot::{Axis, Corner, Line, LinePlot, PALE, Page, Rect, SERIES};
use super::{Arm, Drawn, Finding};
use crate::error::FigureError;
use crate::field::muscle::bent::{VOLUME, arc};
use crate::field::muscle::mesh::{Detail, surface};
use crate::field::muscle::{AxisPoint, MuscleFrame, Profile};
use crate::rig::{FrameInputs, Pose, Rig};
use crate::schedule::DynamicsOptions;
use crate::wrap::{self, ShapeInput};
use glam::Vec3;
use rayon::prelude::*;

/// What the paper found at most, percent.
const PAPER: f64 = 3.0;
/// What plots show, percent, and what enlarged ones may.
const WHOLE: f64 = 4.0;
const ENLARGED: [f64; 4] = [0.04, 0.1, 0.4, 1.0];
/// Of the muscles in motion: rings as dense as in [`Detail::MEASURE`], since kinks of the axes fall between them, and
/// coarser round them, for an error of .02 % of the volume.
const MOVING: Detail = Detail { rings: 320, around: 192 };
/// Frames from one that is measured to the next.
const EVERY: usize = 5;
/// Pixels of a pair of plots, and the height of the upper one.
const PAIR: [u32; 2] = [680, 980];
const UPPER: u32 = 570;
/// Bends of the single muscles, degrees.
const BENDS: [u32; 11] = [0, 15, 30, 45, 60, 75, 90, 105, 120, 135, 150];
/// Segments of the single muscles.
const SEGMENTS: u32 = 29;

/// Deviation of a muscle's closed mesh from the volume that it is to have, percent.
fn deviation(muscle: &MuscleFrame, points: &[AxisPoint], volume: f64, detail: Detail) -> f64 {
    (surface(muscle, points, detail).volume() / volume - 1.0) * 100.0
}

/// Lines over a motion or a bend: percent over `x`.
type Lines = Vec<Vec<[f64; 2]>>;

/// Deviations of all muscles of a rig, percent.
fn of_all(rig: &Rig, inputs: &FrameInputs, shaped: &[MuscleFrame], axes: &[AxisPoint], detail: Detail) -> Vec<f64> {
    let all: Vec<_> = rig.muscles.iter().zip(shaped).zip(&inputs.muscles).collect();
    let measured = all.into_par_iter().map(|((rest, muscle), own)| {
        let volume = f64::from(rest.origin.w) * f64::from(own.width).powi(2);
        deviation(muscle, muscle.points(axes), volume, detail)
    });
    measured.collect()
}

/// Deviations of all muscles of a rig in one pose, their axes straight, percent.
fn in_pose(rig: &Rig, pose: &Pose, detail: Detail) -> Result<Vec<f64>, FigureError> {
    let inputs = FrameInputs::new(rig, pose)?;
    let mut shaped = vec![MuscleFrame::default(); rig.muscles.len()];
    let mut axes = vec![AxisPoint::default(); rig.point_count as usize];
    let input = ShapeInput { joints: &inputs.joints, inputs: &inputs.muscles, iterates: &[], wraps: &rig.wraps };
    wrap::shape(&rig.muscles, &input, &mut shaped, &mut axes);
    Ok(of_all(rig, &inputs, &shaped, &axes, detail))
}

/// Lines over the frames of a clip that are measured, one per muscle: `x` of the frame's number, and percent.
fn over(
    rig: &Rig,
    poses: &[Pose],
    x: impl Fn(usize) -> f64,
    mut measure: impl FnMut(&Pose, bool) -> Result<Vec<f64>, FigureError>,
) -> Result<Lines, FigureError> {
    let mut lines = vec![Vec::new(); rig.muscles.len()];
    for (i, pose) in poses.iter().enumerate() {
        let found = measure(pose, i % EVERY == 0)?;
        lines.iter_mut().zip(found).for_each(|(line, deviation)| line.push([x(i), deviation]));
    }
    Ok(lines)
}

/// Lines over a clip whose muscles move: see [`over`].
fn moving(rig: &Rig, poses: &[Pose], x: impl Fn(usize) -> f64, detail: Detail) -> Result<Lines, FigureError> {
    let mut play = Play::new(rig, &DynamicsOptions::default());
    over(rig, poses, x, |pose, measured| {
        play.next(pose)?;
        let some = || of_all(rig, &play.inputs, &play.shaped, &play.simulation.axes, detail);
        Ok(if measured { some() } else { Vec::new() })
    })
}

/// A muscle whose axis is bent evenly, its section normal square to the bend.
fn bent(degrees: u32, profile: &Profile, eccentricity: f32) -> (MuscleFrame, Vec<AxisPoint>) {
    arc((degrees as f32).to_radians(), SEGMENTS, profile, eccentricity, Vec3::Z)
}

/// The single muscles: name, profile, eccentricity.
fn single() -> [(&'static str, Profile, f32); 4] {
    let half = Profile::blend(&[((3, 3), 0.5), ((4, 7), 0.5)]);
    [
        ("(3, 3)", Profile::of(3, 3), 0.0),
        ("(3, 3), *e* = 0.7", Profile::of(3, 3), 0.7),
        ("(3, 3) and (4, 7), *a* = 0.5", half, 0.0),
        ("(4, 7)", Profile::of(4, 7), 0.0),
    ]
}

/// Deviations over the bends, percent, per single muscle.
fn over_bends(detail: Detail) -> Lines {
    let one = |profile: &Profile, eccentricity: f32| {
        let measured = BENDS.into_par_iter().map(|degrees| {
            let (muscle, points) = bent(degrees, profile, eccentricity);
            [f64::from(degrees), deviation(&muscle, &points, f64::from(VOLUME), detail)]
        });
        measured.collect()
    };
    single().iter().map(|(_, profile, eccentricity)| one(profile, *eccentricity)).collect()
}

fn largest<'a>(lines: impl IntoIterator<Item = &'a Vec<[f64; 2]>>) -> f64 {
    lines.into_iter().flatten().map(|p| p[1].abs()).fold(0.0, f64::max)
}

/// The figure.
pub(super) fn figure(arm: &Arm) -> Result<Drawn, FigureError> {
    let last = arm.curl.len().max(2) - 1;
    let share = |i: usize| 100.0 * i as f64 / last as f64;
    let straight = over(&arm.rig, &arm.curl, share, |pose, measured| {
        if measured { in_pose(&arm.rig, pose, Detail::MEASURE) } else { Ok(Vec::new()) }
    })?;
    let curl = moving(&arm.settled, &arm.curl, share, MOVING)?;
    let shake = moving(&arm.settled, &arm.shake, |i| i as f64 / f64::from(FPS), MOVING)?;
    let bends = over_bends(Detail::MEASURE);
    let findings = vec![
        Finding::new("largest deviation over the curl", largest(&straight), "%"),
        Finding::new("largest deviation over the curl with dynamics", largest(&curl), "%"),
        Finding::new("largest deviation over the shaking with dynamics", largest(&shake), "%"),
        Finding::new("largest deviation over a bend of 150 degrees", largest(&bends), "%"),
        Finding::new("the paper's largest", PAPER, "%"),
    ];
    let muscles: Vec<String> = arm.rig.muscle_names.iter().map(|name| name.replace('_', " ")).collect();
    let shapes = single().map(|(name, ..)| name.to_string()).to_vec();
    let over = "share of the curl, %";
    let seconds = arm.shake.len().saturating_sub(1) as f64 / f64::from(FPS);
    let mut page = Page::new(2 * PAIR[0], 2 * PAIR[1])?;
    let pairs = [
        ("Curl, axes straight", over, 0.0..100.0, named(&muscles, straight)),
        ("Curl, with dynamics", over, 0.0..100.0, named(&muscles, curl)),
        ("Shaking arm, with dynamics", "time, s", 0.0..seconds, named(&muscles, shake)),
        ("One muscle over a bend of its axis", "bend, degrees", 0.0..150.0, named(&shapes, bends)),
    ];
    for (i, (title, x, range, lines)) in (0..).zip(pairs) {
        let [left, top] = [i % 2 * PAIR[0], i / 2 * PAIR[1]];
        let x = Axis { name: x, digits: if range.end < 10.0 { 1 } else { 0 }, range, ticks: 6 };
        pair(&mut page, [left, top], title, x, lines)?;
    }
    Ok(Drawn { image: page.finish(), findings })
}

fn named(names: &[String], lines: Lines) -> Vec<Line> {
    let pairs = names.iter().zip(lines).enumerate();
    pairs.map(|(i, (name, points))| Line::new(name.clone(), points, SERIES[i % SERIES.len()])).collect()
}

/// A plot beside what the paper found, and the same enlarged.
fn pair(page: &mut Page, [left, top]: [u32; 2], title: &str, x: Axis, lines: Vec<Line>) -> Result<(), FigureError> {
    let axis = |name, digits, most: f64| Axis { name, range: -most..most, ticks: 9, digits };
    let mut whole = vec![Line::level("paper A: about 3 %", PAPER, &x.range, PALE)];
    whole.push(Line::level("", -PAPER, &x.range, PALE));
    whole.extend(lines.iter().cloned());
    let most = lines.iter().flat_map(|line| &line.points).map(|p| p[1].abs()).fold(0.0, f64::max);
    let enlarged = ENLARGED.into_iter().find(|shown| most <= *shown).unwrap_or(WHOLE);
    let y = axis("deviation from *V* = π*w*^2*l*, %", 0, WHOLE);
    let plot = LinePlot { title, x, y, lines: whole, legend: Some(Corner::BottomLeft) };
    plot.draw(page, Rect { left, top, width: PAIR[0], height: UPPER })?;
    let title = format!("Enlarged {} times", WHOLE / enlarged);
    let y = axis("deviation, %", 2, enlarged);
    let near = LinePlot { title: &title, y, lines, legend: None, ..plot };
    near.draw(page, Rect { left, top: top + UPPER, width: PAIR[0], height: PAIR[1] - UPPER - 20 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of the measure's vertices: its error is some 4e-4 of the volume.
    const COARSE: Detail = Detail { rings: 80, around: 128 };

    #[test]
    fn bends_keep_the_volume_and_a_wider_muscle_does_not() {
        let worst = largest(&over_bends(COARSE));
        assert!(worst < 1.0, "{worst} %");
        let (mut muscle, points) = bent(90, &Profile::of(3, 3), 0.0);
        muscle.width *= 1.01;
        let wider = deviation(&muscle, &points, f64::from(VOLUME), COARSE);
        assert!(wider > 1.0, "a muscle 1 % wider must be seen: {wider} %");
    }
    #[test]
    fn muscles_in_motion_keep_their_volume() {
        let arm = super::super::motion::tests::arm();
        let of = |poses: &[Pose]| largest(&moving(&arm.settled, poses, |i| i as f64, COARSE).expect("frames"));
        let (curl, shake) = (of(&arm.curl[..31]), of(&arm.shake[..16]));
        assert!(curl < 1.0 && shake < 1.0, "{curl} % {shake} %");
        let (mut inflated, axes) = arm.settled.muscles_at_rest();
        inflated.iter_mut().for_each(|muscle| muscle.width *= 1.01);
        let inputs = FrameInputs { muscles: arm.settled.rest_inputs(), ..FrameInputs::default() };
        let seen = of_all(&arm.settled, &inputs, &inflated, &axes, COARSE);
        assert!(seen.iter().all(|deviation| *deviation > 1.0), "muscles 1 % wider must be seen: {seen:?}");
    }
}
