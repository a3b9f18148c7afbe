//! Drivers made ready: joints found, axes in scene space.

use crate::error::MuscleError;
use crate::math::{polar, transform_vector};
use crate::rig::muscle::{Combine, Curve, MuscleSpec, Source, find_driver_joint};
use crate::rig::{Character, Pose};
use glam::{Mat4, Quat, Vec3};

/// A source with its joint found.
#[derive(Clone, Debug)]
pub(super) enum Ready {
    Length { min: f32, max: f32, invert: bool },
    Angle { joint: usize, axis: Option<Vec3>, from: f32, to: f32 },
    Constant(f32),
    Table(Curve),
}

/// A driver with its joint found.
#[derive(Clone, Debug)]
pub(super) struct ReadyDriver {
    source: Ready,
    combine: Combine,
}

/// What drivers read of one moment.
pub(super) struct Moment<'a> {
    pub turns: &'a Turns,
    pub time: f32,
    /// Current over rest length of this muscle's path.
    pub ratio: f32,
}

/// Joints whose turn some driver reads.
#[derive(Clone, Debug, Default)]
pub(super) struct Watched {
    /// The joint and its parent, indices into the character's joints.
    joints: Vec<(usize, Option<usize>)>,
}

/// How the watched joints are turned against their parents from the rest pose, seen in scene space at rest.
pub(super) struct Turns(Vec<Quat>);

impl Watched {
    fn place(&mut self, joint: usize, parent: Option<u32>) -> usize {
        let found = self.joints.iter().position(|(known, _)| *known == joint);
        found.unwrap_or_else(|| {
            self.joints.push((joint, parent.map(|p| p as usize)));
            self.joints.len() - 1
        })
    }

    /// A joint that the pose lacks is not turned.
    ///
    /// A palette entry takes scene space at rest to scene space posed, `P = G B^-1` of the joint's transforms posed and
    /// at rest, so `P_parent^-1 P` is the turn against the parent, carried to scene space at rest.
    pub(super) fn turns(&self, pose: &Pose) -> Turns {
        let rotation = |joint: usize| pose.palette.get(joint).map_or(Quat::IDENTITY, |m| polar(m).0);
        Turns(
            self.joints
                .iter()
                .map(|&(joint, parent)| parent.map_or(Quat::IDENTITY, rotation).conjugate() * rotation(joint))
                .collect(),
        )
    }
}

impl ReadyDriver {
    /// Finds what driver number `number` of a muscle needs.
    pub(super) fn new(
        spec: &MuscleSpec,
        number: usize,
        character: &Character,
        watched: &mut Watched,
    ) -> Result<ReadyDriver, MuscleError> {
        let driver = &spec.drive.drivers[number];
        let fail = |what: &str| MuscleError::Value {
            muscle: spec.name.clone(),
            key: format!("drivers[{number}]"),
            what: format!("driver {}: {what}", number + 1),
        };
        let source = match &driver.source {
            &Source::Length { min, max, invert } => {
                if !(min.is_finite() && max.is_finite()) {
                    return Err(fail("its length ratios must be finite numbers"));
                }
                Ready::Length { min, max, invert }
            }
            Source::Angle { joint, axis, from, to } => {
                if !(from.is_finite() && to.is_finite()) {
                    return Err(fail("its angles must be finite numbers, in radians"));
                }
                let index = find_driver_joint(spec, number, character, joint)?;
                let joint = &character.joints[index];
                let axis = match axis.map(|axis| axis.normalize_or_zero()) {
                    Some(Vec3::ZERO) => return Err(fail("its axis has no direction; name one or leave the axis out")),
                    // A mirrored bind turns the sense of rotations too: the proper rotation of the polar split does.
                    axis => axis.map(|a| transform_vector(&Mat4::from_quat(polar(&joint.bind()).0), a)),
                };
                Ready::Angle { joint: watched.place(index, joint.parent), axis, from: *from, to: *to }
            }
            &Source::Constant(value) => Ready::Constant(value),
            Source::Table { file, column, curve } => {
                if curve.at(0.0).is_none() {
                    let what = format!("column `{column}` of {} is not read; read the tables first", file.display());
                    return Err(fail(&crate::error::one_line(&what)));
                }
                Ready::Table(curve.clone())
            }
        };
        Ok(ReadyDriver { source, combine: driver.combine })
    }

    fn value(&self, at: &Moment) -> f64 {
        match &self.source {
            &Ready::Length { min, max, invert } => {
                let stretched = ramp(at.ratio, min, max);
                if invert { stretched } else { 1.0 - stretched }
            }
            &Ready::Angle { joint, axis, from, to } => ramp(angle(at.turns.0[joint], axis), from, to),
            &Ready::Constant(value) => f64::from(value),
            Ready::Table(curve) => curve.at(at.time).map_or(f64::NAN, f64::from),
        }
    }
}

/// All that a muscle's drivers and its activation key say together: 0..=1, and 0 where any of them is not finite.
pub(super) fn activation(drivers: &[ReadyDriver], key: Option<f32>, keys: Combine, at: &Moment) -> f32 {
    let given = drivers.iter().map(|d| (d.value(at), d.combine)).chain(key.map(|k| (f64::from(k), keys)));
    let mut joined: Option<f64> = None;
    for (value, combine) in given {
        if !value.is_finite() {
            return 0.0;
        }
        joined = Some(match (joined, combine) {
            (None, _) => value,
            (Some(before), Combine::Max) => before.max(value),
            (Some(before), Combine::Add) => before + value,
            (Some(before), Combine::Multiply) => before * value,
        });
    }
    super::parameters::share(joined.unwrap_or(0.0) as f32)
}

/// 0 at `from`, 1 at `to`, straight between and held outside; a jump where both are the same.
fn ramp(value: f32, from: f32, to: f32) -> f64 {
    let (value, from, to) = (f64::from(value), f64::from(from), f64::from(to));
    if from == to {
        return if value.is_nan() { f64::NAN } else { f64::from(u8::from(value >= to)) };
    }
    // NaN passes through a clamp.
    ((value - from) / (to - from)).clamp(0.0, 1.0)
}

/// Radians: of the whole turn, 0..=pi, or of its part about the axis with its sign, -pi..=pi.
fn angle(turn: Quat, axis: Option<Vec3>) -> f32 {
    // A quaternion and its opposite are the same turn; this one is the shorter way round.
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let part = axis.map_or_else(|| turn.xyz().length(), |axis| turn.xyz().dot(axis));
    2.0 * part.atan2(turn.w)
}
