//! From the file's tables to muscles, with every number within its bounds.

use super::curve::{CurveTable, Exact, ShapeCurveTable};
use super::place::Fault;
use super::tables::{
    ActiveTable, AngleTable, AttachmentTable, BoneTable, DriverTable, FibresTable, KeysTable, LengthTable, MuscleTable,
    TimeTable,
};
use crate::rig::muscle::{
    Attachment, BoneShape, BoneSpec, Combine, Curve, Drive, Driver, Ease, FibreSet, Keys, MuscleShape, MuscleSize,
    MuscleSpec, ShapeCurve, Source,
};
use glam::Vec3;
use std::ops::RangeInclusive;

type Checked<T> = Result<T, Fault>;

/// Longest name: what is longer is no name.
const LONGEST_NAME: usize = 256;
/// Activations, stiffness and the like.
const SHARE: RangeInclusive<f32> = 0.0..=1.0;

/// One muscle; keys of faults are the muscle's own.
pub(super) fn muscle(table: MuscleTable) -> Checked<MuscleSpec> {
    let size = match (table.width, table.volume) {
        (Some(width), None) => MuscleSize::Width(positive("width", width, "m")?),
        (None, Some(volume)) => MuscleSize::Volume(positive("volume", volume, "m^3")?),
        (None, None) => return Err(Fault::new("", "it needs `width` (m) or `volume` (m^3)")),
        (Some(_), Some(_)) => return Err(Fault::new("volume", "it has both `width` and `volume`; keep one")),
    };
    let name = name("name", table.name)?;
    let (origin, insertion) = (attachment("origin", table.origin)?, attachment("insertion", table.insertion)?);
    let spec = MuscleSpec::new(&name, &self::name("bone", table.bone)?, origin, insertion, size);
    let scale = table.width_scale.map_or(Ok(1.0), |w| positive("width_scale", w, ""))?;
    let rest = MuscleShape {
        alpha: exponent("alpha", table.alpha.unwrap_or(MuscleShape::REST.alpha))?,
        beta: exponent("beta", table.beta.unwrap_or(MuscleShape::REST.beta))?,
        eccentricity: within("eccentricity", table.eccentricity.unwrap_or(0.0), MuscleSpec::ECCENTRICITY_RANGE)?,
        width: scale * table.rest_width.map_or(Ok(1.0), |w| positive("rest_width", w, ""))?,
    };
    let active = table.active.map_or(Ok(rest), |table| active(table, rest, scale))?;
    let drivers = match table.drivers {
        Some(tables) => tables.into_iter().enumerate().map(|(i, table)| driver(i, table, &name)).collect(),
        None => Ok(Drive::default().drivers),
    };
    let (keys, combine) = keys(table.keys.unwrap_or_default())?;
    let drive = Drive {
        drivers: drivers?,
        keys: combine,
        attack: seconds("attack", table.attack)?,
        decay: seconds("decay", table.decay)?,
    };
    Ok(MuscleSpec {
        side: table.side.into(),
        fibres: table.fibres.map(fibres).transpose()?,
        segments: whole("segments", table.segments.unwrap_or(MuscleSpec::SEGMENTS), MuscleSpec::SEGMENTS_RANGE)?,
        rest,
        active,
        stiffness: within("stiffness", table.stiffness.unwrap_or(MuscleSpec::STIFFNESS), SHARE)?,
        tendon: within("tendon", table.tendon.unwrap_or(MuscleSpec::TENDON), MuscleSpec::TENDON_RANGE)?,
        collision_group: table
            .collision_group
            .map_or(Ok(String::new()), |group| self::name("collision_group", group))?,
        drive,
        keys,
        ..spec
    })
}

/// What is odd about a muscle but good; keys are the muscle's own.
pub(super) fn notes(spec: &MuscleSpec) -> Vec<Fault> {
    let shapes = [("", spec.rest), ("active.", spec.active)];
    let ends = shapes.iter().flat_map(|(table, shape)| {
        [("alpha", shape.alpha, "origin"), ("beta", shape.beta, "insertion")].map(move |end| (*table, end))
    });
    ends.filter(|(table, (_, exponent, _))| *exponent == 1 && (table.is_empty() || spec.active != spec.rest))
        .map(|(table, (name, _, end))| {
            Fault::new(format!("{table}{name}"), format!("{name} of 1 makes a blunt, rounded end at the {end}"))
        })
        .collect()
}

/// One bone's shape; keys of faults are the table's own.
pub(super) fn bone(table: BoneTable) -> Checked<BoneSpec> {
    let shape = match (table.capsule, table.mesh) {
        (Some(capsule), None) => BoneShape::Capsule {
            from: point("capsule.from", capsule.from)?,
            to: point("capsule.to", capsule.to)?,
            radius: positive("capsule.radius", capsule.radius, "m")?,
        },
        (None, Some(mesh)) => BoneShape::Mesh(name("mesh", mesh)?),
        (None, None) => return Err(Fault::new("", "it needs `capsule` or `mesh`")),
        (Some(_), Some(_)) => return Err(Fault::new("mesh", "it has both `capsule` and `mesh`; keep one")),
    };
    Ok(BoneSpec { bone: name("bone", table.bone)?, shape })
}

fn active(table: ActiveTable, rest: MuscleShape, scale: f32) -> Checked<MuscleShape> {
    Ok(MuscleShape {
        alpha: exponent("active.alpha", table.alpha.unwrap_or(MuscleShape::ACTIVE.alpha))?,
        beta: exponent("active.beta", table.beta.unwrap_or(MuscleShape::ACTIVE.beta))?,
        eccentricity: within(
            "active.eccentricity",
            table.eccentricity.unwrap_or(rest.eccentricity),
            MuscleSpec::ECCENTRICITY_RANGE,
        )?,
        width: scale * table.width.map_or(Ok(1.0), |w| positive("active.width", w, ""))?,
    })
}

fn attachment(key: &str, table: AttachmentTable) -> Checked<Attachment> {
    let normal = table.normal.map_or(Ok(Vec3::Z), |n| direction(&format!("{key}.normal"), n))?;
    let offset = point(&format!("{key}.offset"), table.offset)?;
    Ok(Attachment { bone: name(&format!("{key}.bone"), table.bone)?, offset, normal })
}

fn fibres(table: FibresTable) -> Checked<FibreSet> {
    if table.origin_line.is_empty() && table.insertion_line.is_empty() {
        let what = "all fibres are the same; give `origin_line` or `insertion_line` a point";
        return Err(Fault::new("fibres.count", what));
    }
    let line = |key: &str, points: Vec<Exact<[f32; 3]>>| -> Checked<Vec<Vec3>> {
        points.into_iter().enumerate().map(|(i, p)| point(&format!("fibres.{key}[{i}]"), p)).collect()
    };
    Ok(FibreSet {
        count: whole("fibres.count", table.count, MuscleSpec::FIBRES_RANGE)?,
        origin_line: line("origin_line", table.origin_line)?,
        insertion_line: line("insertion_line", table.insertion_line)?,
        overlap: table.overlap,
    })
}

fn driver(index: usize, table: DriverTable, muscle: &str) -> Checked<Driver> {
    let key = format!("drivers[{index}]");
    let combine = table.combine.into();
    let source = match (table.length, table.angle, table.constant, table.table) {
        (Some(LengthTable { min, max, invert }), None, None, None) => {
            let min = positive(&format!("{key}.length.min"), min.unwrap_or(0.7), "")?;
            let max = positive(&format!("{key}.length.max"), max.unwrap_or(1.0), "")?;
            if min >= max {
                return Err(Fault::new(
                    format!("{key}.length"),
                    format!("min is {min} and max {max}; min must be the smaller"),
                ));
            }
            Source::Length { min, max, invert }
        }
        (None, Some(AngleTable { joint, axis, from, to }), None, None) => {
            let joint = name(&format!("{key}.angle.joint"), joint)?;
            let axis = axis.map(|a| direction(&format!("{key}.angle.axis"), a)).transpose()?;
            let from = finite(&format!("{key}.angle.from"), from)?;
            let to = finite(&format!("{key}.angle.to"), to)?;
            if from == to {
                return Err(Fault::new(format!("{key}.angle.to"), "from and to are the same angle; they must differ"));
            }
            Source::Angle { joint, axis, from, to }
        }
        (None, None, Some(value), None) => Source::Constant(finite(&format!("{key}.constant"), value)?),
        (None, None, None, Some(TimeTable { file, column })) => {
            if file.is_empty() || file.len() > 4096 || file.contains('\0') {
                return Err(Fault::new(format!("{key}.table.file"), "this names no file"));
            }
            let column = column.map_or(Ok(muscle.to_owned()), |c| name(&format!("{key}.table.column"), c))?;
            Source::Table { file: file.into(), column, curve: Curve::default() }
        }
        _ => return Err(Fault::new(key, "a driver is one of `length`, `angle`, `constant` and `table`")),
    };
    Ok(Driver { source, combine })
}

fn keys(table: KeysTable) -> Checked<(Keys, Combine)> {
    let positive = f32::MIN_POSITIVE..=f32::MAX;
    let keys = Keys {
        activation: curve("keys.activation", table.activation, SHARE)?,
        eccentricity: curve("keys.eccentricity", table.eccentricity, MuscleSpec::ECCENTRICITY_RANGE)?,
        width: curve("keys.width", table.width, positive)?,
        stiffness: curve("keys.stiffness", table.stiffness, SHARE)?,
        shape: shape_curve("keys.shape", table.shape)?,
    };
    Ok((keys, table.combine.into()))
}

fn curve(key: &str, table: Option<CurveTable>, range: RangeInclusive<f32>) -> Checked<Curve> {
    let Some(table) = table else { return Ok(Curve::default()) };
    let mut curve = Curve { ease: table.ease.into(), ..Curve::default() };
    let slopes = table.points.first().is_some_and(|point| point.len() == 4);
    if slopes && curve.ease != Ease::Cubic {
        let what = "slopes are read of cubic keys alone; write { ease = \"cubic\", points = [..] }";
        return Err(Fault::new(format!("{key}[0]"), what));
    }
    for (i, point) in table.points.iter().enumerate() {
        let at = format!("{key}[{i}]");
        let (time, value) = match point[..] {
            [time, value] if !slopes => (time, value),
            [time, value, slope_in, slope_out] if slopes => {
                curve.tangents.push([finite(&at, slope_in)?, finite(&at, slope_out)?]);
                (time, value)
            }
            _ => {
                let form =
                    if slopes { "[seconds, value, slope in, slope out] like the first" } else { "[seconds, value]" };
                return Err(Fault::new(at, format!("a key of {} numbers; write {form}", point.len())));
            }
        };
        ascending(&at, time, curve.times.last())?;
        curve.times.push(time);
        curve.values.push(within(&format!("{at}[1]"), value, range.clone())?);
    }
    Ok(curve)
}

fn shape_curve(key: &str, table: Option<ShapeCurveTable>) -> Checked<ShapeCurve> {
    let Some(table) = table else { return Ok(ShapeCurve::default()) };
    let mut curve = ShapeCurve { ease: table.ease.into(), ..ShapeCurve::default() };
    for (i, &Exact((time, alpha, beta))) in table.points.iter().enumerate() {
        let at = format!("{key}[{i}]");
        ascending(&at, time, curve.times.last())?;
        curve.times.push(time);
        curve.shapes.push((exponent(&format!("{at}[1]"), alpha)?, exponent(&format!("{at}[2]"), beta)?));
    }
    Ok(curve)
}

fn ascending(key: &str, time: f32, before: Option<&f32>) -> Checked<()> {
    let time = finite(&format!("{key}[0]"), time)?;
    match before {
        Some(&before) if time <= before => {
            let what = format!("the key at {time} s follows one at {before} s; times must ascend");
            Err(Fault::new(format!("{key}[0]"), what))
        }
        _ => Ok(()),
    }
}

fn name(key: &str, name: String) -> Checked<String> {
    match name.len() {
        0 if key != "collision_group" => Err(Fault::new(key, format!("{} is empty; give it a name", last(key)))),
        0..=LONGEST_NAME => Ok(name),
        long => Err(Fault::new(key, format!("{} is {long} bytes long; at most {LONGEST_NAME} are read", last(key)))),
    }
}

fn exponent(key: &str, value: u32) -> Checked<u32> {
    whole(key, value, MuscleSpec::EXPONENTS_RANGE)
}

fn whole(key: &str, value: u32, range: RangeInclusive<u32>) -> Checked<u32> {
    if range.contains(&value) {
        return Ok(value);
    }
    let (low, high) = (range.start(), range.end());
    Err(Fault::new(key, format!("{} is {value}, and must be a whole number from {low} to {high}", last(key))))
}

fn within(key: &str, value: f32, range: RangeInclusive<f32>) -> Checked<f32> {
    if range.contains(&value) {
        return Ok(value);
    }
    let bounds = match (*range.start(), *range.end()) {
        (_, f32::MAX) => "a positive, finite number".into(),
        (low, high) => format!("in {low} to {high}"),
    };
    Err(Fault::new(key, format!("{} is {value}, and must be {bounds}", last(key))))
}

fn positive(key: &str, value: f32, unit: &str) -> Checked<f32> {
    // Smaller than the smallest normal number is 0 to some processors.
    if value.is_normal() && value > 0.0 {
        return Ok(value);
    }
    let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
    Err(Fault::new(key, format!("{} is {value}, and must be a positive, finite number{unit}", last(key))))
}

fn seconds(key: &str, value: Option<f32>) -> Checked<f32> {
    match value.unwrap_or(0.0) {
        value if value.is_finite() && value >= 0.0 => Ok(value),
        value => Err(Fault::new(key, format!("{key} is {value}, and must be 0 or more seconds"))),
    }
}

fn finite(key: &str, value: f32) -> Checked<f32> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(Fault::new(key, format!("{} is {value}, and must be finite", last(key))))
}

fn point(key: &str, Exact(value): Exact<[f32; 3]>) -> Checked<Vec3> {
    for (i, &coordinate) in value.iter().enumerate() {
        if !coordinate.is_finite() {
            return Err(Fault::new(format!("{key}[{i}]"), format!("{} holds {coordinate}, not finite", last(key))));
        }
    }
    Ok(Vec3::from(value))
}

fn direction(key: &str, value: Exact<[f32; 3]>) -> Checked<Vec3> {
    let direction = point(key, value)?;
    if direction.try_normalize().is_none() {
        return Err(Fault::new(key, format!("{} has no direction; give a vector that is not zero", last(key))));
    }
    Ok(direction)
}

/// The last word of a key that is no index.
fn last(key: &str) -> &str {
    let key = key.rsplit('.').find(|word| !word.is_empty()).unwrap_or(key);
    key.split('[').next().unwrap_or(key)
}
