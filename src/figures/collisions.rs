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

const PANEL: [u32; 2] = [430, 440];
const TITLES: [&str; 3] = ["Implicit Skinning alone", "Muscles without collisions", "Muscles and bones collide"];
/// The columns with muscles, in the findings.
const CASES: [&str; 2] = ["without collisions", "with collisions"];
/// Cosine of the angle round the bone within which skin is over the biceps.
const OVER: f32 = 0.8;
/// Shares of the humerus's length between which it is over the belly, above the fold of the elbow.
const BELLY: std::ops::Range<f32> = 0.3..0.7;

/// What collisions should raise the surface by at least, metres, and how many times as high it should be.
const LEAST_RISE: f32 = 8e-3;
const LEAST_RATIO: f32 = 1.5;
/// The quantity that is held to them: how far the skin stands out of itself without muscles, at most.
const LARGEST: &str = "largest bulge of the skin over the biceps";

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

/// How far vertices over a muscle's belly stand out of the skin without muscles, along its normals, metres: of those that
/// `on_bone` has, the ones on the side of the line to which the muscle lies.
fn bulge(bare: &Seen, skin: &[Vec3], on_bone: impl Fn(usize) -> bool, line: [Vec3; 2], toward: Vec3) -> Vec<f32> {
    let span = line[1] - line[0];
    let places = bare.positions.iter().zip(&bare.normals).zip(skin).enumerate();
    let over = |p: Vec3| {
        let along = (p - line[0]).dot(span) / span.length_squared();
        away(line, p).normalize_or_zero().dot(toward) > OVER && BELLY.contains(&along)
    };
    let chosen = places.filter(|(v, ((p, _), _))| on_bone(*v) && over(**p));
    chosen.map(|(_, ((p, normal), moved))| (*moved - *p).dot(*normal)).collect()
}

/// The figure.
pub(super) fn figure(headless: &Headless, arm: &Arm) -> Result<Drawn, FigureError> {
    let lacks = || Figure::Collisions.lacks("the built-in arm's biceps and humerus");
    let poses = flexed(arm);
    let (last, before) = poses.split_last().ok_or_else(lacks)?;
    let index = muscle(&arm.rig, BICEPS).ok_or_else(lacks)?;
    let (line, bone) = humerus(&arm.rig, last).ok_or_else(lacks)?;
    let joint = arm.rig.muscles[index].origin_joint;
    let bare = Arc::new(Rig::build(arm.rig.character.clone(), &[], &BuildOptions::default())?);
    let studio = Studio::new(headless, PANEL[0], PANEL[1])?;
    let camera = camera(&arm.rig, &[last], studio.aspect())?;
    let moving = Some(DynamicsOptions::default());
    let cases = [(&bare, None), (&arm.rig, Some(without_collisions())), (&arm.settled, moving)];
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
    let (_, toward) = farthest(&own(&seen[2]), line);
    let flexed = [1, 2].map(|case| farthest(&own(&seen[case]), line).0);
    // The bent forearm lies on the same side of the humerus.
    let of_upper_arm = |v: usize| arm.rig.character.influences_of(v).iter().any(|i| i.joint == joint && i.weight > 0.5);
    let bulges = [1, 2].map(|case| bulge(&seen[0], &seen[case].positions, of_upper_arm, line, toward));
    let note = |case: usize| {
        let metres = [flexed[case], mean(&bulges[case]), most(&bulges[case])];
        let [surface, skin, highest] = metres.map(|metres| metres * 1000.0);
        format!("biceps {surface:.1} mm, skin up {skin:.1} mm, at most {highest:.1} mm")
    };
    let notes = [String::new(), note(0), note(1)];
    let rises = Rises { flexed, stretched, bone, bulges };
    Ok(Drawn { image: sheet(&TITLES, &rows, &notes)?.finish(), findings: rises.findings() })
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len().max(1) as f32
}

fn most(values: &[f32]) -> f32 {
    values.iter().copied().fold(0.0, f32::max)
}

/// How far the biceps and the skin over it rise, metres, in the two cases.
struct Rises {
    /// Largest distance of the muscle's surface from the humerus's axis, flexed.
    flexed: [f32; 2],
    /// The same with the arm stretched and nothing activated.
    stretched: Vec<f32>,
    /// Radius of the humerus.
    bone: f32,
    /// Distances of the skin over the muscle from the skin without muscles.
    bulges: [Vec<f32>; 2],
}

impl Rises {
    /// What "the surface is raised" can mean, all of it. The skin's largest bulge is what [`LEAST_RISE`] and
    /// [`LEAST_RATIO`] are asked of; the others say by how much they fall short of them.
    fn findings(&self) -> Vec<Finding> {
        let swelling = [0, 1].map(|i| self.flexed[i] - self.stretched.get(i).copied().unwrap_or_default());
        let named = [
            ("biceps' surface from the humerus's axis", self.flexed),
            ("biceps' surface from the humerus's surface", self.flexed.map(|height| height - self.bone)),
            ("biceps' surface from where the stretched arm has it", swelling),
            ("mean bulge of the skin over the biceps", self.bulges.each_ref().map(|b| mean(b))),
            (LARGEST, self.bulges.each_ref().map(|b| most(b))),
        ];
        named.into_iter().flat_map(|(name, values)| findings(name, values)).collect()
    }
}

/// What one quantity comes to without collisions and with them, metres.
fn findings(name: &str, [without, with]: [f32; 2]) -> Vec<Finding> {
    let rise = with - without;
    // What sinks in one case has no ratio.
    let ratio = (without > 0.0).then_some(with / without);
    let short = 1.0 - (rise / LEAST_RISE).min(ratio.map_or(f32::INFINITY, |ratio| ratio / LEAST_RATIO));
    let mut findings: Vec<Finding> = [without, with]
        .into_iter()
        .zip(CASES)
        .map(|(value, case)| Finding::new(format!("{name}, {case}"), f64::from(value) * 1000.0, "mm"))
        .collect();
    findings.push(Finding::new(format!("{name}: raised by"), f64::from(rise) * 1000.0, "mm"));
    findings.extend(ratio.map(|ratio| Finding::new(format!("{name}: ratio"), f64::from(ratio), "")));
    findings.push(Finding::new(
        format!("{name}: short of 8 mm or 1.5 times by"),
        f64::from(short.max(0.0)) * 100.0,
        "%",
    ));
    findings
}

#[cfg(test)]
mod tests {
    use super::super::motion::{Play, tests::arm};
    use super::*;
    use crate::reference::{Motion, Reference};
    use crate::schedule::FrameOptions;

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

    /// The skin in the last of the poses, on the CPU.
    fn skin(rig: &Rig, poses: &[Pose], dynamics: Option<DynamicsOptions>) -> Seen {
        let options = FrameOptions { dynamics, ..FrameOptions::default() };
        let (last, before) = poses.split_last().expect("poses");
        let reference = Reference::new(rig);
        let mut motion = Motion::new(rig, &options);
        let of_rig = |pose: &Pose| match rig.specs.is_empty() {
            true => Pose { activations: Vec::new(), ..pose.clone() },
            false => pose.clone(),
        };
        for pose in before.iter().filter(|_| dynamics.is_some()) {
            reference.advance(&mut motion, &of_rig(pose), &options).expect("a frame");
        }
        let trace = reference.next(&mut motion, &of_rig(last), &options).expect("a frame");
        Seen {
            positions: trace.positions().iter().map(|p| p.xyz()).collect(),
            normals: trace.normals.iter().map(|n| n.xyz()).collect(),
            muscles: trace.muscles,
            axes: trace.axes,
            particles: trace.particles,
        }
    }

    #[test]
    fn collisions_raise_the_skins_largest_bulge_by_8_mm_and_half_as_high_again() {
        let arm = arm();
        let poses = flexed(&arm);
        let index = muscle(&arm.rig, BICEPS).expect("a biceps");
        let rest = &arm.rig.muscles[index];
        let (line, _) = humerus(&arm.rig, poses.last().expect("poses")).expect("a humerus");
        let bare = Rig::build(arm.rig.character.clone(), &[], &BuildOptions::default()).expect("a rig");
        let bare = skin(&bare, &poses, None);
        let seen = skin(&arm.settled, &poses, Some(DynamicsOptions::default()));
        let own = &seen.particles[rest.first_point as usize..][..=rest.segments as usize];
        let (_, toward) = farthest(own, line);
        let highest = |seen: &Seen| {
            let of_upper_arm = |v: usize| {
                let mut influences = arm.rig.character.influences_of(v).iter();
                influences.any(|i| i.joint == rest.origin_joint && i.weight > 0.5)
            };
            most(&bulge(&bare, &seen.positions, of_upper_arm, line, toward))
        };
        let value = |values, what: &str| {
            let found = findings(LARGEST, values);
            found.iter().find(|f| f.name.ends_with(what)).expect("a finding").value
        };
        let without = highest(&skin(&arm.rig, &poses, Some(without_collisions())));
        let with = [without, highest(&seen)];
        println!("{LARGEST}: {with:?} m");
        assert!(value(with, "raised by") >= 8.0 && value(with, "ratio") >= 1.5, "{with:?}");
        assert_eq!(value(with, "times by"), 0.0);
        // Without the bone, what else collides does not do it.
        let contacts = Contacts { bones: false, ..Contacts::ALL };
        let through = DynamicsOptions { contacts, ..DynamicsOptions::default() };
        let through = [without, highest(&skin(&arm.rig, &poses, Some(through)))];
        assert!(value(through, "times by") > 10.0, "it is the bone that does: {through:?}");
    }

    #[test]
    fn what_falls_short_says_by_how_much() {
        let short = |values| findings("x", values).last().expect("findings").value;
        assert_eq!(short([0.004, 0.013]), 0.0);
        assert!((short([0.058, 0.072]) - 17.2).abs() < 0.1, "of the ratio: {}", short([0.058, 0.072]));
        assert!((short([0.0003, 0.0046]) - 46.25).abs() < 0.1, "of the rise: {}", short([0.0003, 0.0046]));
    }

    #[test]
    fn a_bulge_counts_over_the_muscle_alone() {
        let bare = Seen {
            positions: [[0.05, 0.15], [-0.05, 0.15], [0.05, 0.25], [0.05, 0.15]]
                .map(|[x, y]| Vec3::new(x, y, 0.0))
                .to_vec(),
            normals: vec![Vec3::X, Vec3::NEG_X, Vec3::X, Vec3::X],
            muscles: Vec::new(),
            axes: Vec::new(),
            particles: Vec::new(),
        };
        let moved: Vec<Vec3> = bare.positions.iter().zip(&bare.normals).map(|(p, n)| *p + *n * 0.01).collect();
        let found = bulge(&bare, &moved, |v| v < 3, [Vec3::ZERO, Vec3::Y * 0.3], Vec3::X);
        assert!(found.len() == 1 && (found[0] - 0.01).abs() < 1e-6, "{found:?}");
    }
}
