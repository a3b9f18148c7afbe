//! Figure 2: the arm at rest, with its flexors activated, and flexed; its muscles moved by the dynamics.

use super::actor::{Actor, Seen, camera};
use super::motion::{BICEPS, activated, flexed, held, muscle};
use super::scene::{Studio, sheet};
use super::{Arm, Drawn, Figure, Finding};
use crate::error::FigureError;
use crate::field::muscle::mesh::{Detail, surface};
use crate::gpu::Headless;
use crate::render::View;
use crate::rig::Pose;
use crate::schedule::DynamicsOptions;

const PANEL: [u32; 2] = [410, 600];
const TITLES: [&str; 3] = ["(a) Input pose", "(b) Muscles activated", "(c) Arm flexed"];
const STATES: [&str; 3] = ["at rest", "activated", "flexed"];
/// Fine enough that the mesh's volume is the surface's to .02 %.
const DETAIL: Detail = Detail { rings: 160, around: 256 };

/// The biceps in one state: largest mean radius and length in metres, volume in cubic metres.
fn measured(seen: &Seen, index: usize) -> [f64; 3] {
    let muscle = &seen.muscles[index];
    let volume = surface(muscle, muscle.points(&seen.axes), DETAIL).volume();
    [f64::from(muscle.width * muscle.profile().max()), f64::from(muscle.length), volume]
}

/// One motion from the stretched arm, held still, over its activation to the bent one: the poses before each state, the
/// state's own last.
fn states(arm: &Arm) -> [Vec<Pose>; 3] {
    let start = arm.curl.first().cloned().unwrap_or_default();
    let rest = vec![Pose { activations: vec![0.0; arm.rig.specs.len()], ..start.clone() }];
    let tensed: Vec<Pose> = held(&activated(&arm.rig, start)).skip(1).collect();
    let after = tensed.last().map_or(0.0, |pose| pose.time);
    let bent = flexed(arm).into_iter().skip(1).map(|pose| Pose { time: pose.time + after, ..pose }).collect();
    [rest, tensed, bent]
}

/// The figure.
pub(super) fn figure(headless: &Headless, arm: &Arm) -> Result<Drawn, FigureError> {
    let index = muscle(&arm.rig, BICEPS).ok_or_else(|| Figure::Flexion.lacks("the built-in arm's biceps"))?;
    let studio = Studio::new(headless, PANEL[0], PANEL[1])?;
    let mut actor = Actor::new(&studio, &arm.settled, Some(DynamicsOptions::default()))?;
    let states = states(arm);
    let shown: Vec<&Pose> = states.iter().filter_map(|poses| poses.last()).collect();
    let camera = camera(&arm.rig, &shown, studio.aspect())?;
    let (mut rows, mut notes, mut findings) = ([Vec::new(), Vec::new()], Vec::new(), Vec::new());
    let expected = f64::from(arm.rig.muscles[index].origin.w);
    for (poses, state) in states.iter().zip(STATES) {
        let Some((last, before)) = poses.split_last() else { continue };
        actor.pass(before)?;
        let seen = actor.show(last)?;
        rows[0].push(actor.draw(&camera, last, &seen, View::Xray)?);
        rows[1].push(actor.draw(&camera, last, &seen, View::Skin)?);
        let [radius, length, volume] = measured(&seen, index);
        notes.push(format!("biceps: radius {:.1} mm, volume {:.1} ml", radius * 1000.0, volume * 1e6));
        findings.push(Finding::new(format!("biceps {state}: largest mean radius"), radius * 1000.0, "mm"));
        findings.push(Finding::new(format!("biceps {state}: length"), length * 1000.0, "mm"));
        findings.push(Finding::new(format!("biceps {state}: volume"), volume * 1e6, "ml"));
        let deviation = 100.0 * (volume / expected - 1.0);
        findings.push(Finding::new(format!("biceps {state}: deviation of its volume"), deviation, "%"));
    }
    Ok(Drawn { image: sheet(&TITLES, &rows, &notes)?.finish(), findings })
}

#[cfg(test)]
mod tests {
    use super::super::motion::{Play, tests::arm};
    use super::*;

    #[test]
    fn states_are_one_motion_and_keep_the_volume() {
        let arm = arm();
        let states = states(&arm);
        let times: Vec<f32> = states.iter().flatten().map(|pose| pose.time).collect();
        assert!(times.windows(2).all(|t| (t[1] - t[0] - 1.0 / 30.0).abs() < 1e-3), "no jump starts it anew: {times:?}");
        assert_eq!(states[0][0].palette, states[1][29].palette, "activated in the same pose");
        assert_ne!(states[1][29].palette, states[2][29].palette);
        let index = muscle(&arm.rig, BICEPS).expect("a biceps");
        let mut play = Play::new(&arm.settled, &DynamicsOptions::default());
        let widths = states.map(|poses| {
            play.all(&poses).expect("frames");
            let muscle = &play.shaped[index];
            let volume = surface(muscle, muscle.points(&play.simulation.axes), DETAIL).volume();
            let deviation = volume / f64::from(arm.rig.muscles[index].origin.w) - 1.0;
            assert!(deviation.abs() < 0.01, "{deviation}");
            let mut wider = *muscle;
            wider.width *= 1.01;
            let wider = surface(&wider, muscle.points(&play.simulation.axes), DETAIL).volume();
            assert!((wider / volume - 1.0).abs() > 0.01, "a wider muscle must be seen");
            muscle.width * muscle.profile().max()
        });
        assert!(widths[1] > 1.05 * widths[0] && widths[2] > 1.05 * widths[1], "{widths:?}");
    }
}
