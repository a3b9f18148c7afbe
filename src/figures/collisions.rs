//! Figure 15: the bent arm without muscles, with muscles that pass through bones, and with muscles that bones hold off.

use super::actor::{Actor, Seen, camera};
use super::motion::{BICEPS, away, flexed, humerus, muscle};
use super::scene::{Studio, sheet};
use super::{Arm, Drawn, Figure, Finding};
use crate::dynamics::Particle;
use crate::error::FigureError;
use crate::gpu::Headless;
use crate::render::View;
use crate::rig::{BuildOptions, Pose, Rig};
use crate::schedule::{Contacts, DynamicsOptions};
use glam::{Vec3, Vec4Swizzles};
use std::sync::Arc;

const PANEL: [u32; 2] = [470, 470];
const TITLES: [&str; 3] = ["Implicit Skinning alone", "Muscles without collisions", "Muscles and bones collide"];
/// Cosine of the angle round the bone within which skin is over the biceps.
const OVER: f32 = 0.8;
/// Shares of the humerus's length between which it is over the belly, above the fold of the elbow.
const BELLY: std::ops::Range<f32> = 0.3..0.7;

fn without_collisions() -> DynamicsOptions {
    DynamicsOptions { contacts: Contacts::NONE, ..DynamicsOptions::default() }
}

/// Farthest of a muscle's surface from a line, metres, and the direction in which its axis is farthest.
fn farthest(own: &[Particle], line: [Vec3; 2]) -> (f32, Vec3) {
    own.iter().fold((0.0, Vec3::ZERO), |(most, direction), p| {
        let offset = away(line, p.position.xyz());
        let height = offset.length() + p.position.w;
        if height > most { (height, offset.normalize_or_zero()) } else { (most, direction) }
    })
}

/// How far vertices over a muscle's belly stand out of the skin without muscles, along its normals, metres: on the side of
/// the line to which the muscle lies.
fn bulge(bare: &Seen, skin: &[Vec3], line: [Vec3; 2], toward: Vec3) -> Vec<f32> {
    let span = line[1] - line[0];
    let places = bare.positions.iter().zip(&bare.normals).zip(skin);
    let over = |p: Vec3| {
        let along = (p - line[0]).dot(span) / span.length_squared();
        away(line, p).normalize_or_zero().dot(toward) > OVER && BELLY.contains(&along)
    };
    places.filter(|((p, _), _)| over(**p)).map(|((p, normal), moved)| (*moved - *p).dot(*normal)).collect()
}

/// The figure.
pub(super) fn figure(headless: &Headless, arm: &Arm) -> Result<Drawn, FigureError> {
    let lacks = || Figure::Collisions.lacks("the built-in arm's biceps and humerus");
    let poses = flexed(arm);
    let (last, before) = poses.split_last().ok_or_else(lacks)?;
    let index = muscle(&arm.rig, BICEPS).ok_or_else(lacks)?;
    let (line, bone) = humerus(&arm.rig, last).ok_or_else(lacks)?;
    let bare = Arc::new(Rig::build(arm.rig.character.clone(), &[], &BuildOptions::default())?);
    let studio = Studio::new(headless, PANEL[0], PANEL[1])?;
    let camera = camera(&arm.rig, &[last], studio.aspect())?;
    let cases =
        [(&bare, None), (&arm.rig, Some(without_collisions())), (&arm.settled, Some(DynamicsOptions::default()))];
    let rest = &arm.rig.muscles[index];
    let own = |seen: &Seen| seen.particles[rest.first_point as usize..][..=rest.segments as usize].to_vec();
    let mut stretched = Vec::new();
    let (mut rows, mut seen) = ([Vec::new(), Vec::new()], Vec::new());
    for (rig, dynamics) in cases {
        let mut actor = Actor::new(&studio, rig, dynamics)?;
        if let Some((start, others)) = before.split_first() {
            let start = Pose { activations: vec![0.0; rig.specs.len()], ..start.clone() };
            let at_first = actor.show(&start)?;
            if dynamics.is_some() {
                let (line, _) = humerus(&arm.rig, &start).ok_or_else(lacks)?;
                stretched.push(farthest(&own(&at_first), line).0);
                actor.pass(others)?;
            }
        }
        let frame = actor.show(last)?;
        rows[0].push(actor.draw(&camera, last, &frame, View::Skin)?);
        rows[1].push(actor.draw(&camera, last, &frame, View::Xray)?);
        seen.push(frame);
    }
    let [(low, _), (high, toward)] = [1, 2].map(|case| farthest(&own(&seen[case]), line));
    let [without, with] = [1, 2].map(|case| bulge(&seen[0], &seen[case].positions, line, toward));
    let rises = Rises {
        flexed: [low, high],
        stretched: [stretched[0], stretched[1]],
        bone,
        bulges: [&without, &with].map(|b| mean(b)),
    };
    let note = |height: f32| format!("biceps' surface {:.1} mm from the humerus's axis", height * 1000.0);
    let notes = [String::new(), note(low), note(high)];
    Ok(Drawn { image: sheet(&TITLES, &rows, &notes)?.finish(), findings: rises.findings() })
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len().max(1) as f32
}

/// How far the biceps and the skin over it rise, metres; in pairs, without collisions and with them.
struct Rises {
    /// Largest distance of the muscle's surface from the humerus's axis, flexed.
    flexed: [f32; 2],
    /// The same with the arm stretched and nothing activated.
    stretched: [f32; 2],
    /// Radius of the humerus.
    bone: f32,
    /// Mean distance of the skin over the muscle from the skin without muscles.
    bulges: [f32; 2],
}

impl Rises {
    /// What "raised so many times" can mean, all of it.
    fn findings(&self) -> Vec<Finding> {
        let [low, high] = self.flexed;
        let millimetres = |name: &str, metres: f32| Finding::new(name, f64::from(metres) * 1000.0, "mm");
        let ratio = |name: &str, [low, high]: [f32; 2]| Finding::new(name, f64::from(high / low.max(1e-9)), "");
        let swelling = [0, 1].map(|case| self.flexed[case] - self.stretched[case]);
        let mut findings = vec![
            millimetres("biceps' surface from the humerus's axis, without collisions", low),
            millimetres("biceps' surface from the humerus's axis, with collisions", high),
            millimetres("rise of the biceps' surface", high - low),
            ratio("ratio of its distances from the axis", self.flexed),
            ratio("ratio of its heights over the humerus's surface", self.flexed.map(|height| height - self.bone)),
            ratio("ratio of its rises from the stretched arm", swelling),
            ratio("ratio of the skin's mean bulges over the skin without muscles", self.bulges),
        ];
        for (case, name) in ["without collisions", "with collisions"].into_iter().enumerate() {
            findings.push(millimetres(&format!("rise of the surface from the stretched arm, {name}"), swelling[case]));
            let bulge = format!("mean bulge of the skin over the biceps, {name}");
            findings.push(millimetres(&bulge, self.bulges[case]));
        }
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::super::motion::{Play, tests::arm};
    use super::*;

    fn height(arm: &Arm, rig: &Rig, options: &DynamicsOptions) -> f32 {
        let poses = flexed(arm);
        let mut play = Play::new(rig, options);
        play.all(&poses).expect("frames");
        let rest = &rig.muscles[muscle(rig, BICEPS).expect("a biceps")];
        let own = &play.simulation.particles[rest.first_point as usize..][..=rest.segments as usize];
        let (line, _) = humerus(rig, poses.last().expect("poses")).expect("a humerus");
        farthest(own, line).0
    }

    #[test]
    fn the_bone_raises_the_biceps() {
        let arm = arm();
        let [with, without] =
            [height(&arm, &arm.settled, &DynamicsOptions::default()), height(&arm, &arm.rig, &without_collisions())];
        assert!(with - without >= 8e-3, "{with} {without}");
        let contacts = Contacts { bones: false, ..Contacts::ALL };
        let through = height(&arm, &arm.rig, &DynamicsOptions { contacts, ..without_collisions() });
        assert!(through - without < 8e-3, "it is the bone that does: {through} {without}");
    }

    #[test]
    fn a_bulge_counts_over_the_muscle_alone() {
        let bare = Seen {
            positions: vec![Vec3::new(0.05, 0.15, 0.0), Vec3::new(-0.05, 0.15, 0.0), Vec3::new(0.05, 0.25, 0.0)],
            normals: vec![Vec3::X, Vec3::NEG_X, Vec3::X],
            muscles: Vec::new(),
            axes: Vec::new(),
            particles: Vec::new(),
        };
        let moved: Vec<Vec3> = bare.positions.iter().zip(&bare.normals).map(|(p, n)| *p + *n * 0.01).collect();
        let found = bulge(&bare, &moved, [Vec3::ZERO, Vec3::Y * 0.3], Vec3::X);
        assert!(found.len() == 1 && (found[0] - 0.01).abs() < 1e-6, "{found:?}");
    }
}
