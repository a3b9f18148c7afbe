//! Test clips made by code for any skeleton: hinges swept step by step, an arm raised, a squat, fingers curled.
//!
//! They move the bind pose by the [`Roles`] of its joints, and so need no animation in the file.

use crate::error::ClipError;
use crate::rig::roles::{Hinge, LimbRoles, Roles};
use crate::rig::{Character, groups::Side};
use glam::{DAffine3, DMat4, DQuat, DVec3, Quat, Vec3};
use std::f32::consts::TAU;

/// Degrees that a swept joint turns by in a second: half a degree a frame at 30 frames a second.
const SWEEP: f32 = 15.0;
/// Angle between a hinge's bones at the end, degrees.
const HINGE_END: f32 = 140.0;
/// Angle between the raised arm and straight down, degrees.
const RAISED: f32 = 165.0;
/// Share of it that clavicles do.
const GIRDLE_SHARE: f32 = 0.25;
/// Turns of a finger's joints at the end, degrees, from the knuckle on.
const CURL: [f32; 3] = [80.0, 100.0, 65.0];
/// The squat: seconds down and up again, and degrees at its deepest: thigh from upright, knee, trunk.
const SQUAT_SECONDS: f32 = 4.0;
const SQUAT: [f32; 3] = [85.0, 110.0, 35.0];

/// A clip that is made by code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TestClip {
    /// All elbows from straight to 140 degrees, half a degree a frame at 30 frames a second.
    Elbow,
    /// All knees from straight to 140 degrees, at the same rate.
    Knee,
    /// The arms raised sideways from rest, with the clavicles, at the same rate.
    Shoulder,
    /// Down and up again in four seconds, on its feet.
    Squat,
    /// The fingers, without the thumbs, curled from rest.
    Finger,
}

impl TestClip {
    /// All of them.
    pub const ALL: [TestClip; 5] =
        [TestClip::Elbow, TestClip::Knee, TestClip::Shoulder, TestClip::Squat, TestClip::Finger];

    /// The name by which it is chosen.
    pub fn name(self) -> &'static str {
        match self {
            TestClip::Elbow => "test:elbow",
            TestClip::Knee => "test:knee",
            TestClip::Shoulder => "test:shoulder",
            TestClip::Squat => "test:squat",
            TestClip::Finger => "test:finger",
        }
    }
}

/// One joint's turn over the clip, about its place at rest and beside what the joint above does.
#[derive(Clone, Copy, Debug)]
struct Turn {
    joint: u32,
    origin: Vec3,
    /// Unit vector at rest.
    axis: Vec3,
    /// What comes before the turn.
    before: Quat,
    /// Degrees at the start and at the end.
    degrees: [f32; 2],
}

/// A made clip for one character.
#[derive(Clone, Debug)]
struct Made {
    seconds: f32,
    /// Whether it goes back to its start.
    returns: bool,
    turns: Vec<Turn>,
    /// Joints and places of theirs that stay on the ground.
    planted: Vec<(u32, Vec3)>,
}

/// All made clips of a character, and what it lacks for the others.
#[derive(Clone, Debug)]
pub(crate) struct MadeClips {
    clips: Vec<Result<Made, &'static str>>,
    /// The joint that each joint moves with, and all joints in an order in which that one comes first.
    moves_with: Vec<Option<u32>>,
    order: Vec<u32>,
}

impl MadeClips {
    pub fn new(character: &Character) -> MadeClips {
        let roles = Roles::find(character);
        let clips = TestClip::ALL.map(|clip| Made::new(clip, &roles, character)).to_vec();
        MadeClips { clips, order: order(&roles.moves_with), moves_with: roles.moves_with }
    }

    fn made(&self, clip: TestClip) -> Result<&Made, &'static str> {
        let index = TestClip::ALL.iter().position(|c| *c == clip).unwrap_or_default();
        self.clips[index].as_ref().map_err(|missing| *missing)
    }

    /// What the character lacks for a clip.
    pub fn check(&self, clip: TestClip, character: &Character) -> Result<(), ClipError> {
        self.made(clip).map(drop).map_err(|missing| ClipError::Limb {
            character: character.name.clone(),
            clip: clip.name(),
            missing,
        })
    }

    /// Seconds; 0 where the character lacks something.
    pub fn seconds(&self, clip: TestClip) -> f32 {
        self.made(clip).map_or(0.0, |made| made.seconds)
    }

    /// Every joint's motion, scene space at rest to scene space posed.
    pub fn motion(&self, clip: TestClip, time: f32) -> Vec<DMat4> {
        let mut motion = vec![DAffine3::IDENTITY; self.moves_with.len()];
        let Ok(made) = self.made(clip) else { return motion.into_iter().map(DMat4::from).collect() };
        let share = made.share(time);
        for &j in &self.order {
            let above = self.moves_with[j as usize].map_or(DAffine3::IDENTITY, |p| motion[p as usize]);
            let own = made.turns.iter().filter(|turn| turn.joint == j).fold(above, |m, turn| m * turn.at(share));
            motion[j as usize] = own;
        }
        let slides = made.planted.iter().map(|&(joint, place)| {
            let place = place.as_dvec3();
            place - motion[joint as usize].transform_point3(place)
        });
        let slide = slides.sum::<DVec3>() / made.planted.len().max(1) as f64;
        motion.into_iter().map(|m| DMat4::from(DAffine3::from_translation(slide) * m)).collect()
    }
}

/// All joints, each after the one that it moves with.
fn order(moves_with: &[Option<u32>]) -> Vec<u32> {
    let mut followers = vec![Vec::new(); moves_with.len()];
    let mut order = Vec::with_capacity(moves_with.len());
    for (j, leader) in (0..).zip(moves_with) {
        match leader {
            Some(leader) => followers[*leader as usize].push(j),
            None => order.push(j),
        }
    }
    let mut next = 0;
    while let Some(&j) = order.get(next) {
        order.append(&mut followers[j as usize]);
        next += 1;
    }
    order
}

impl Turn {
    fn at(&self, share: f32) -> DAffine3 {
        let degrees = self.degrees[0] + (self.degrees[1] - self.degrees[0]) * share;
        let turn = DQuat::from_axis_angle(self.axis.as_dvec3().normalize(), f64::from(degrees).to_radians());
        let turn = turn * self.before.as_dquat().normalize();
        let origin = self.origin.as_dvec3();
        DAffine3::from_translation(origin) * DAffine3::from_quat(turn) * DAffine3::from_translation(-origin)
    }
}

const NO_ARM: &str = "an arm of two bones";
const NO_LEG: &str = "legs of two bones each";
const NO_BODY: &str = "a body with two arms or legs, whose feet or knees tell where its front is";
const NO_ELBOW: &str = "an arm that is bent at rest, or a body whose feet or knees tell where its front is";
const NO_FINGER: &str = "fingers of two joints or more";

impl Made {
    fn new(clip: TestClip, roles: &Roles, character: &Character) -> Result<Made, &'static str> {
        match clip {
            TestClip::Elbow => swept(&roles.arms, NO_ARM, NO_ELBOW, |arm| arm.elbow(roles.axes.as_ref())),
            TestClip::Knee => swept(&roles.legs, NO_LEG, NO_BODY, |leg| leg.knee(roles.axes.as_ref())),
            TestClip::Shoulder => raised(roles, character),
            TestClip::Squat => squat(roles),
            TestClip::Finger => curled(roles, character),
        }
    }

    /// Share of the way from the first degrees to the last.
    fn share(&self, time: f32) -> f32 {
        let t = if time.is_nan() { 0.0 } else { (time / self.seconds).clamp(0.0, 1.0) };
        if self.returns { 0.5 - 0.5 * (TAU * t).cos() } else { t }
    }

    /// A clip in which the joint that turns most does so at the sweep's rate.
    fn sweep(turns: Vec<Turn>) -> Made {
        let most = turns.iter().map(|turn| (turn.degrees[1] - turn.degrees[0]).abs()).fold(0.0, f32::max);
        Made { seconds: most / SWEEP, returns: false, turns, planted: Vec::new() }
    }
}

/// Hinges from straight to their end.
fn swept(
    limbs: &[LimbRoles],
    none: &'static str,
    blind: &'static str,
    hinge: impl Fn(&LimbRoles) -> Option<Hinge>,
) -> Result<Made, &'static str> {
    let turn = |hinge: Hinge| Turn {
        joint: hinge.joint,
        origin: hinge.origin,
        axis: hinge.axis,
        before: hinge.straight,
        degrees: [0.0, HINGE_END],
    };
    let turns: Vec<Turn> = limbs.iter().map(|limb| hinge(limb).map(turn).ok_or(blind)).collect::<Result<_, _>>()?;
    if turns.is_empty() { Err(none) } else { Ok(Made::sweep(turns)) }
}

/// Arms from rest sideways and up, with the clavicles.
fn raised(roles: &Roles, character: &Character) -> Result<Made, &'static str> {
    let axes = roles.axes.ok_or(NO_BODY)?;
    let mut turns = Vec::new();
    for arm in &roles.arms {
        let out = if arm.side == Some(Side::Left) { axes.left } else { -axes.left };
        let Some(bone) = (arm.places[1] - arm.places[0]).try_normalize() else { continue };
        let degrees = RAISED - bone.dot(out).atan2(bone.dot(-axes.up)).to_degrees();
        let turn = |joint: u32, origin: Vec3, share: f32| Turn {
            joint,
            origin,
            axis: (-axes.up).cross(out),
            before: Quat::IDENTITY,
            degrees: [0.0, share * degrees],
        };
        let girdle = arm.girdle.map(|joint| turn(joint, place(character, joint), GIRDLE_SHARE));
        turns.push(turn(arm.upper, arm.places[0], if girdle.is_some() { 1.0 - GIRDLE_SHARE } else { 1.0 }));
        turns.extend(girdle);
    }
    if turns.is_empty() { Err(NO_ARM) } else { Ok(Made::sweep(turns)) }
}

/// Hips, knees and ankles with the trunk leaning forward, the feet flat where they stand.
fn squat(roles: &Roles) -> Result<Made, &'static str> {
    let (axes, pelvis) = (roles.axes.ok_or(NO_BODY)?, roles.pelvis.ok_or(NO_BODY)?);
    let [thigh, knee, lean] = SQUAT;
    let hips = roles.legs.iter().map(|leg| leg.places[0]).sum::<Vec3>() / roles.legs.len().max(1) as f32;
    // About the left the top goes forward, and what hangs goes back.
    let turn = |joint: u32, origin: Vec3, degrees: f32| Turn {
        joint,
        origin,
        axis: axes.left,
        before: Quat::IDENTITY,
        degrees: [0.0, degrees],
    };
    let mut turns = vec![turn(pelvis, hips, lean)];
    for leg in &roles.legs {
        let [hip, middle, ankle] = leg.places;
        turns.extend([turn(leg.upper, hip, -thigh - lean), turn(leg.lower, middle, knee)]);
        turns.extend(leg.end.map(|foot| turn(foot, ankle, thigh - knee)));
    }
    let planted: Vec<(u32, Vec3)> = roles.legs.iter().map(|leg| (leg.lower, leg.places[2])).collect();
    if planted.is_empty() {
        return Err(NO_LEG);
    }
    Ok(Made { seconds: SQUAT_SECONDS, returns: true, turns, planted })
}

/// Fingers into the palm.
fn curled(roles: &Roles, character: &Character) -> Result<Made, &'static str> {
    let place = |j: u32| place(character, j);
    let mut turns = Vec::new();
    for hand in roles.arms.iter().filter(|arm| !arm.digits.is_empty()) {
        let Some(curl) = hand.curl(roles.axes.as_ref(), place) else { continue };
        for digit in &hand.digits {
            let along = (place(digit[1]) - place(digit[0])).normalize_or_zero();
            let Some(axis) = curl.reject_from(along).try_normalize().filter(|axis| axis.is_finite()) else { continue };
            turns.extend(digit.iter().zip(CURL).map(|(&joint, degrees)| Turn {
                joint,
                origin: place(joint),
                axis,
                before: Quat::IDENTITY,
                degrees: [0.0, degrees],
            }));
        }
    }
    if turns.is_empty() { Err(NO_FINGER) } else { Ok(Made::sweep(turns)) }
}

/// Where a joint is at rest, metres.
fn place(character: &Character, joint: u32) -> Vec3 {
    character.joints[joint as usize].bind().w_axis.truncate()
}

#[cfg(test)]
mod tests;
