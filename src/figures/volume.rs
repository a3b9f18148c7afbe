//! Figure 13, top: volume of the muscles over a curl; beside it that of single muscles over a bend.

use super::plot::{Axis, Corner, Line, LinePlot, PALE, Page, Rect, SERIES};
use super::{Arm, Drawn, Finding};
use crate::error::FigureError;
use crate::field::muscle::bent::{VOLUME, arc};
use crate::field::muscle::mesh::{Detail, surface};
use crate::field::muscle::{AxisPoint, MuscleFrame, Profile};
use crate::rig::{FrameInputs, Pose, Rig};
use crate::wrap::{self, ShapeInput};
use glam::Vec3;
use rayon::prelude::*;

/// What the paper found at most, percent.
const PAPER: f64 = 3.0;
/// What the enlarged plots show, percent.
const ENLARGED: f64 = 0.04;
/// Bends of the single muscles, degrees.
const BENDS: [u32; 11] = [0, 15, 30, 45, 60, 75, 90, 105, 120, 135, 150];
/// Segments of the single muscles.
const SEGMENTS: u32 = 29;

/// Deviation of a muscle's closed mesh from the volume that it is to have, percent.
fn deviation(muscle: &MuscleFrame, points: &[AxisPoint], volume: f64, detail: Detail) -> f64 {
    (surface(muscle, points, detail).volume() / volume - 1.0) * 100.0
}

/// Deviations of all muscles of a rig in one pose, percent.
fn in_pose(rig: &Rig, pose: &Pose, detail: Detail) -> Result<Vec<f64>, FigureError> {
    let inputs = FrameInputs::new(rig, pose)?;
    let mut shaped = vec![MuscleFrame::default(); rig.muscles.len()];
    let mut axes = vec![AxisPoint::default(); rig.point_count as usize];
    let input = ShapeInput { joints: &inputs.joints, groups: &inputs.groups, inputs: &inputs.muscles, iterates: &[] };
    wrap::shape(&rig.muscles, &input, &mut shaped, &mut axes);
    let all: Vec<_> = rig.muscles.iter().zip(&shaped).zip(&inputs.muscles).collect();
    let measured = all.into_par_iter().map(|((rest, muscle), own)| {
        let volume = f64::from(rest.origin.w) * f64::from(own.width).powi(2);
        deviation(muscle, muscle.points(&axes), volume, detail)
    });
    Ok(measured.collect())
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
fn over_bends(detail: Detail) -> Vec<Vec<[f64; 2]>> {
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

/// The figure, measured with meshes of a given detail.
pub(super) fn figure(arm: &Arm) -> Result<Drawn, FigureError> {
    draw(arm, Detail::MEASURE)
}

fn draw(arm: &Arm, detail: Detail) -> Result<Drawn, FigureError> {
    let mut page = Page::new(1360, 990)?;
    let last = arm.curl.len().max(2) - 1;
    let mut curl = vec![Vec::new(); arm.rig.muscles.len()];
    for (i, pose) in arm.curl.iter().enumerate() {
        let share = 100.0 * i as f64 / last as f64;
        for (line, deviation) in curl.iter_mut().zip(in_pose(&arm.rig, pose, detail)?) {
            line.push([share, deviation]);
        }
    }
    let bends = over_bends(detail);
    let findings = vec![
        Finding::new("largest deviation over the curl", largest(&curl), "%"),
        Finding::new("largest deviation over a bend of 150 degrees", largest(&bends), "%"),
        Finding::new("the paper's largest", PAPER, "%"),
    ];
    let named = |names: Vec<String>, lines: Vec<Vec<[f64; 2]>>| -> Vec<Line> {
        let pairs = names.into_iter().zip(lines).enumerate();
        pairs.map(|(i, (name, points))| Line::new(name, points, SERIES[i % SERIES.len()])).collect()
    };
    let muscles = arm.rig.muscle_names.iter().map(|name| name.replace('_', " ")).collect();
    let shapes = single().map(|(name, ..)| name.to_string()).to_vec();
    let columns = [
        ("Muscles of the arm over a curl", "share of the curl, %", 0.0..100.0, named(muscles, curl)),
        ("One muscle over a bend of its axis", "bend, degrees", 0.0..150.0, named(shapes, bends)),
    ];
    for ((title, x, range, lines), left) in columns.into_iter().zip([0, 680]) {
        let axis = |name, digits, most: f64| Axis { name, range: -most..most, ticks: 9, digits };
        let mut whole = vec![Line::level("paper A: about 3 %", PAPER, &range, PALE)];
        whole.push(Line::level("", -PAPER, &range, PALE));
        whole.extend(lines.iter().cloned());
        let plot = LinePlot {
            title,
            x: Axis { name: x, range: range.clone(), ticks: 6, digits: 0 },
            y: axis("deviation from *V* = π*w*^2*l*, %", 0, 4.0),
            lines: whole,
            legend: Some(Corner::BottomLeft),
        };
        plot.draw(&mut page, Rect { left, top: 0, width: 680, height: 570 })?;
        let near = LinePlot {
            title: "Enlarged a hundred times (the meshes' own error: 0.01 %)",
            y: axis("deviation, %", 2, ENLARGED),
            lines,
            legend: None,
            ..plot
        };
        near.draw(&mut page, Rect { left, top: 580, width: 680, height: 400 })?;
    }
    Ok(Drawn { image: page.finish(), findings })
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
}
