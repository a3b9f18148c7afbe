//! What can be said of a muscle without its character: the one place where its numbers have their bounds, for the muscle
//! file as for specs that a program makes.

use super::{
    Around, Attachment, Curve, Drive, FibreSet, Keys, MuscleShape, MuscleSize, MuscleSpec, ShapeCurve, Source, Wrap,
};
use crate::error::MuscleError;
use glam::Vec3;
use std::ops::RangeInclusive;

/// A value out of its bounds.
#[derive(Debug)]
pub(in crate::rig) struct Wrong {
    /// Where the muscle file has it, from the muscle's own table: `keys.width[2][1]`.
    pub key: String,
    /// The value, its bounds and the remedy.
    pub what: String,
}

pub(in crate::rig) type Checked = Result<(), Wrong>;

impl Wrong {
    pub fn new(key: impl Into<String>, what: impl Into<String>) -> Wrong {
        Wrong { key: key.into(), what: what.into() }
    }

    /// As the error of a muscle.
    pub fn of(self, spec: &MuscleSpec) -> MuscleError {
        MuscleError::Value { muscle: spec.name.clone(), key: self.key, what: self.what }
    }
}

/// All numbers of a muscle.
pub(in crate::rig) fn muscle(spec: &MuscleSpec) -> Checked {
    match spec.size {
        MuscleSize::Width(width) => positive("width", width, "m")?,
        MuscleSize::Volume(volume) => positive("volume", volume, "m^3")?,
    }
    attachment("origin", &spec.origin)?;
    attachment("insertion", &spec.insertion)?;
    spec.wrap.as_ref().map_or(Ok(()), wrap)?;
    spec.fibres.as_ref().map_or(Ok(()), fibres)?;
    whole("segments", spec.segments, MuscleSpec::SEGMENTS_RANGE)?;
    shape("", "rest_width", &spec.rest)?;
    shape("active.", "active.width", &spec.active)?;
    within("stiffness", spec.stiffness, MuscleSpec::STIFFNESS_RANGE)?;
    within("tendon", spec.tendon, MuscleSpec::TENDON_RANGE)?;
    spec.frequency.map_or(Ok(()), |hertz| within("frequency", hertz, MuscleSpec::FREQUENCY_RANGE))?;
    within("jiggle", spec.jiggle, MuscleSpec::JIGGLE_RANGE)?;
    speeds(&spec.drive)?;
    for (i, driver) in spec.drive.drivers.iter().enumerate() {
        source(&format!("drivers[{i}]"), &driver.source)?;
    }
    keys(&spec.keys)
}

fn shape(table: &str, width: &str, shape: &MuscleShape) -> Checked {
    whole(&format!("{table}alpha"), shape.alpha, MuscleSpec::EXPONENTS_RANGE)?;
    whole(&format!("{table}beta"), shape.beta, MuscleSpec::EXPONENTS_RANGE)?;
    within(&format!("{table}eccentricity"), shape.eccentricity, MuscleSpec::ECCENTRICITY_RANGE)?;
    within(width, shape.width, MuscleSpec::WIDTH_RANGE)
}

fn attachment(key: &str, end: &Attachment) -> Checked {
    point(&format!("{key}.offset"), end.offset)?;
    direction(&format!("{key}.normal"), end.normal)
}

fn wrap(wrap: &Wrap) -> Checked {
    positive("wrap.radius", wrap.radius, "m")?;
    if let Around::Bone { ends: Some([from, to]), .. } = wrap.around {
        point("wrap.from", from)?;
        point("wrap.to", to)?;
        if (to - from).try_normalize().is_none() {
            return Err(Wrong::new("wrap.to", "from and to are the same point; the bone lies between them"));
        }
    }
    wrap.side.map_or(Ok(()), |side| point("wrap.side", side))
}

fn fibres(set: &FibreSet) -> Checked {
    whole("fibres.count", set.count, MuscleSpec::FIBRES_RANGE)?;
    if set.origin_line.is_empty() && set.insertion_line.is_empty() {
        let what = "all fibres are the same; give `origin_line` or `insertion_line` a point";
        return Err(Wrong::new("fibres.count", what));
    }
    for (key, line) in [("origin_line", &set.origin_line), ("insertion_line", &set.insertion_line)] {
        for (i, &at) in line.iter().enumerate() {
            point(&format!("fibres.{key}[{i}]"), at)?;
        }
    }
    Ok(())
}

/// Attack and decay.
pub(in crate::rig) fn speeds(drive: &Drive) -> Checked {
    for (key, seconds) in [("attack", drive.attack), ("decay", drive.decay)] {
        if !(seconds.is_finite() && seconds >= 0.0) {
            return Err(Wrong::new(key, format!("{key} is {seconds} s, and must be 0 or more")));
        }
    }
    Ok(())
}

fn source(key: &str, source: &Source) -> Checked {
    match *source {
        Source::Length { min, max, .. } => {
            positive(&format!("{key}.length.min"), min, "")?;
            positive(&format!("{key}.length.max"), max, "")?;
            if min >= max {
                let what = format!("min is {min} and max {max}; min must be the smaller");
                return Err(Wrong::new(format!("{key}.length"), what));
            }
        }
        Source::Angle { axis, from, to, .. } => {
            axis.map_or(Ok(()), |axis| direction(&format!("{key}.angle.axis"), axis))?;
            finite(&format!("{key}.angle.from"), from)?;
            finite(&format!("{key}.angle.to"), to)?;
            if from == to {
                let what = "from and to are the same angle; they must differ";
                return Err(Wrong::new(format!("{key}.angle.to"), what));
            }
        }
        Source::Constant(value) => finite(&format!("{key}.constant"), value)?,
        Source::Table { .. } => {}
    }
    Ok(())
}

fn keys(keys: &Keys) -> Checked {
    curve("keys.activation", &keys.activation, MuscleSpec::ACTIVATION_RANGE)?;
    curve("keys.eccentricity", &keys.eccentricity, MuscleSpec::ECCENTRICITY_RANGE)?;
    curve("keys.width", &keys.width, MuscleSpec::WIDTH_RANGE)?;
    curve("keys.stiffness", &keys.stiffness, MuscleSpec::STIFFNESS_RANGE)?;
    let ShapeCurve { times, shapes, .. } = &keys.shape;
    ascending("keys.shape", times, shapes.len())?;
    for (i, &(alpha, beta)) in shapes.iter().enumerate() {
        whole(&format!("keys.shape[{i}][1]"), alpha, MuscleSpec::EXPONENTS_RANGE)?;
        whole(&format!("keys.shape[{i}][2]"), beta, MuscleSpec::EXPONENTS_RANGE)?;
    }
    Ok(())
}

fn curve(key: &str, curve: &Curve, range: RangeInclusive<f32>) -> Checked {
    ascending(key, &curve.times, curve.values.len())?;
    if !curve.tangents.is_empty() && curve.tangents.len() != curve.times.len() {
        let (given, keys) = (curve.tangents.len(), curve.times.len());
        return Err(Wrong::new(key, format!("{} has {keys} keys and slopes of {given}", said(key))));
    }
    for (i, &value) in curve.values.iter().enumerate() {
        within(&format!("{key}[{i}][1]"), value, range.clone())?;
    }
    curve.tangents.iter().flatten().enumerate().try_for_each(|(i, &slope)| finite(&format!("{key}[{}]", i / 2), slope))
}

fn ascending(key: &str, times: &[f32], values: usize) -> Checked {
    if times.len() != values {
        return Err(Wrong::new(key, format!("{} has {} times and {values} values", said(key), times.len())));
    }
    for (i, &time) in times.iter().enumerate() {
        let at = format!("{key}[{i}][0]");
        finite(&at, time)?;
        if let Some(&before) = i.checked_sub(1).and_then(|i| times.get(i))
            && time <= before
        {
            return Err(Wrong::new(at, format!("the key at {time} s follows one at {before} s; times must ascend")));
        }
    }
    Ok(())
}

fn whole(key: &str, value: u32, range: RangeInclusive<u32>) -> Checked {
    if range.contains(&value) {
        return Ok(());
    }
    let (low, high) = (range.start(), range.end());
    Err(Wrong::new(key, format!("{} is {value}, and must be a whole number from {low} to {high}", said(key))))
}

pub(in crate::rig) fn within(key: &str, value: f32, range: RangeInclusive<f32>) -> Checked {
    if range.contains(&value) {
        return Ok(());
    }
    let bounds = match (*range.start(), *range.end()) {
        (f32::MIN_POSITIVE, high) => format!("over 0 and at most {high}"),
        (low, high) => format!("in {low} to {high}"),
    };
    Err(Wrong::new(key, format!("{} is {value}, and must be {bounds}", said(key))))
}

pub(in crate::rig) fn positive(key: &str, value: f32, unit: &str) -> Checked {
    // Smaller than the smallest normal number is 0 to some processors.
    if value.is_normal() && value > 0.0 {
        return Ok(());
    }
    let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
    Err(Wrong::new(key, format!("{} is {value}, and must be a positive, finite number{unit}", said(key))))
}

fn finite(key: &str, value: f32) -> Checked {
    if value.is_finite() {
        return Ok(());
    }
    Err(Wrong::new(key, format!("{} is {value}, and must be finite", said(key))))
}

pub(in crate::rig) fn point(key: &str, value: Vec3) -> Checked {
    match value.to_array().iter().position(|coordinate| !coordinate.is_finite()) {
        Some(i) => Err(Wrong::new(format!("{key}[{i}]"), format!("{} holds {}, not finite", said(key), value[i]))),
        None => Ok(()),
    }
}

fn direction(key: &str, value: Vec3) -> Checked {
    point(key, value)?;
    match value.try_normalize() {
        Some(_) => Ok(()),
        None => Err(Wrong::new(key, format!("{} has no direction; give a vector that is not zero", said(key)))),
    }
}

/// A key in words: its last word that is no index; of the active shape's both, as the shape at rest has the same ones.
fn said(key: &str) -> &str {
    if key.starts_with("active.") {
        return key;
    }
    let key = key.rsplit('.').find(|word| !word.is_empty()).unwrap_or(key);
    key.split('[').next().unwrap_or(key)
}
