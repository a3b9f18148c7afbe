//! From muscles to the file's tables.

use crate::rig::GroupSpec;
use crate::rig::muscle::{
    Around, Attachment, BodySide, BoneShape, BoneSpec, Collides, Combine, Curve, Drive, Driver, Ease, FibreSet, Keys,
    MuscleShape, MuscleSize, MuscleSpec, Source, Wrap,
};
use glam::Vec3;
use toml_edit::{Array, InlineTable, Table, Value};

/// How much is written of what is at its default.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Detail {
    /// Nothing.
    Needed,
    /// Everything.
    All,
}

/// A muscle's table, keys in the order of the documentation.
pub(super) fn muscle(spec: &MuscleSpec, detail: Detail) -> Table {
    let all = detail == Detail::All;
    let default = Drive::default();
    let mut table = Table::new();
    let mut put = |key: &str, said: bool, value: Value| {
        if said || all {
            table.insert(key, toml_edit::value(value));
        }
    };
    put("name", true, spec.name.as_str().into());
    put("side", spec.side != BodySide::Centre, side(spec.side).into());
    put("bone", true, spec.bone.as_str().into());
    put("origin", true, attachment(&spec.origin, all).into());
    put("insertion", true, attachment(&spec.insertion, all).into());
    if let Some(around) = &spec.wrap {
        put("wrap", true, wrap(around).into());
    }
    if let Some(set) = &spec.fibres {
        put("fibres", true, fibres(set, all).into());
    }
    put("segments", spec.segments != MuscleSpec::SEGMENTS, i64::from(spec.segments).into());
    let MuscleShape { alpha, beta, eccentricity, .. } = spec.rest;
    put("alpha", alpha != MuscleShape::REST.alpha, i64::from(alpha).into());
    put("beta", beta != MuscleShape::REST.beta, i64::from(beta).into());
    put("eccentricity", eccentricity != 0.0, number(eccentricity));
    // One factor of both shapes is said once.
    let scale = if spec.rest.width == spec.active.width { spec.rest.width } else { 1.0 };
    put("rest_width", spec.rest.width != scale, number(spec.rest.width / scale));
    put("active", spec.active != spec.rest, active(spec, scale, all).into());
    put("width_scale", scale != 1.0, number(scale));
    match spec.size {
        MuscleSize::Width(width) => put("width", true, number(width)),
        MuscleSize::Volume(volume) => put("volume", true, number(volume)),
    }
    put("stiffness", spec.stiffness != MuscleSpec::STIFFNESS, number(spec.stiffness));
    put("tendon", spec.tendon != MuscleSpec::TENDON, number(spec.tendon));
    put("collision_group", !spec.collision_group.is_empty(), spec.collision_group.as_str().into());
    put("collides", spec.collides != Collides::default(), collides(spec.collides).into());
    if let Some(hertz) = spec.frequency {
        put("frequency", true, number(hertz));
    }
    put("jiggle", spec.jiggle != 0.0, number(spec.jiggle));
    let drivers: Array = spec.drive.drivers.iter().map(|d| driver(d, &spec.name)).collect();
    put("drivers", spec.drive.drivers != default.drivers, drivers.into());
    put("attack", spec.drive.attack != 0.0, number(spec.drive.attack));
    put("decay", spec.drive.decay != 0.0, number(spec.drive.decay));
    let keyed = spec.keys != Keys::default() || spec.drive.keys != Combine::Max;
    put("keys", keyed, keys(&spec.keys, spec.drive.keys).into());
    table
}

/// A bone's table.
pub(super) fn bone(spec: &BoneSpec) -> Table {
    let mut table = Table::new();
    table.insert("bone", toml_edit::value(spec.bone.as_str()));
    match &spec.shape {
        BoneShape::Capsule { from, to, radius } => {
            let mut capsule = InlineTable::new();
            capsule.insert("from", vector(*from));
            capsule.insert("to", vector(*to));
            capsule.insert("radius", number(*radius));
            table.insert("capsule", toml_edit::value(capsule));
        }
        BoneShape::Mesh(name) => {
            table.insert("mesh", toml_edit::value(name.as_str()));
        }
    }
    table
}

fn side(side: BodySide) -> &'static str {
    match side {
        BodySide::Left => "left",
        BodySide::Right => "right",
        BodySide::Centre => "centre",
    }
}

fn collides(collides: Collides) -> Array {
    let names = [("bones", collides.bones), ("muscles", collides.muscles), ("skin", collides.skin)];
    names.into_iter().filter(|(_, on)| *on).map(|(name, _)| name).collect()
}

fn attachment(end: &Attachment, all: bool) -> InlineTable {
    let mut table = InlineTable::new();
    table.insert("bone", end.bone.as_str().into());
    table.insert("offset", vector(end.offset));
    if all || end.normal != Vec3::Z {
        table.insert("normal", vector(end.normal));
    }
    table
}

fn wrap(wrap: &Wrap) -> InlineTable {
    let mut table = InlineTable::new();
    let (kind, ends) = match &wrap.around {
        Around::Joint(_) => ("sphere", None),
        Around::Bone { ends, .. } => ("cylinder", *ends),
    };
    table.insert("kind", kind.into());
    table.insert(wrap.around.key(), wrap.around.name().into());
    table.insert("radius", number(wrap.radius));
    if let Some([from, to]) = ends {
        table.insert("from", vector(from));
        table.insert("to", vector(to));
    }
    if let Some(side) = wrap.side {
        table.insert("side", vector(side));
    }
    table
}

fn fibres(set: &FibreSet, all: bool) -> InlineTable {
    let mut table = InlineTable::new();
    table.insert("count", i64::from(set.count).into());
    for (key, line) in [("origin_line", &set.origin_line), ("insertion_line", &set.insertion_line)] {
        if all || !line.is_empty() {
            table.insert(key, line.iter().map(|&p| vector(p)).collect::<Array>().into());
        }
    }
    if all || set.overlap {
        table.insert("overlap", set.overlap.into());
    }
    table
}

fn active(spec: &MuscleSpec, scale: f32, all: bool) -> InlineTable {
    let mut table = InlineTable::new();
    table.insert("alpha", i64::from(spec.active.alpha).into());
    table.insert("beta", i64::from(spec.active.beta).into());
    if all || spec.active.eccentricity != spec.rest.eccentricity {
        table.insert("eccentricity", number(spec.active.eccentricity));
    }
    if all || spec.active.width != scale {
        table.insert("width", number(spec.active.width / scale));
    }
    table
}

fn driver(driver: &Driver, muscle: &str) -> Value {
    let mut source = InlineTable::new();
    let (kind, value): (_, Value) = match &driver.source {
        Source::Length { min, max, invert } => {
            source.insert("min", number(*min));
            source.insert("max", number(*max));
            if *invert {
                source.insert("invert", true.into());
            }
            ("length", source.into())
        }
        Source::Angle { joint, axis, from, to } => {
            source.insert("joint", joint.as_str().into());
            if let Some(axis) = axis {
                source.insert("axis", vector(*axis));
            }
            source.insert("from", number(*from));
            source.insert("to", number(*to));
            ("angle", source.into())
        }
        Source::Constant(value) => ("constant", number(*value)),
        Source::Table { file, column, .. } => {
            source.insert("file", file.to_string_lossy().as_ref().into());
            if column != muscle {
                source.insert("column", column.as_str().into());
            }
            ("table", source.into())
        }
    };
    let mut table = InlineTable::new();
    table.insert(kind, value);
    if driver.combine != Combine::Max {
        table.insert("combine", combine(driver.combine).into());
    }
    table.into()
}

fn combine(combine: Combine) -> &'static str {
    match combine {
        Combine::Max => "max",
        Combine::Add => "add",
        Combine::Multiply => "multiply",
    }
}

fn keys(keys: &Keys, joined: Combine) -> InlineTable {
    let mut table = InlineTable::new();
    let curves = [
        ("activation", &keys.activation),
        ("eccentricity", &keys.eccentricity),
        ("width", &keys.width),
        ("stiffness", &keys.stiffness),
    ];
    for (key, curve) in curves.into_iter().filter(|(_, curve)| !curve.times.is_empty()) {
        table.insert(key, eased(curve.ease, points(curve)));
    }
    if !keys.shape.times.is_empty() {
        let points = keys.shape.times.iter().zip(&keys.shape.shapes).map(|(&time, &(alpha, beta))| {
            Value::from([number(time), i64::from(alpha).into(), i64::from(beta).into()].into_iter().collect::<Array>())
        });
        table.insert("shape", eased(keys.shape.ease, points.collect()));
    }
    if joined != Combine::Max {
        table.insert("combine", combine(joined).into());
    }
    table
}

fn points(curve: &Curve) -> Array {
    let slopes = |i: usize| curve.tangents.get(i).copied().into_iter().flatten();
    let point = |(i, (&time, &value)): (usize, (&f32, &f32))| {
        Value::from([time, value].into_iter().chain(slopes(i)).map(number).collect::<Array>())
    };
    curve.times.iter().zip(&curve.values).enumerate().map(point).collect()
}

fn eased(ease: Ease, points: Array) -> Value {
    let name = match ease {
        Ease::Linear => return points.into(),
        Ease::Step => "step",
        Ease::Cubic => "cubic",
    };
    let mut table = InlineTable::new();
    table.insert("ease", name.into());
    table.insert("points", points.into());
    table.into()
}

fn vector(v: Vec3) -> Value {
    v.to_array().into_iter().map(number).collect::<Array>().into()
}

/// The shortest number that reads back as the same `f32`.
fn number(x: f32) -> Value {
    // Every f32 in decimal is a number; 0 + x turns -0 into 0, which nobody means.
    Value::from(format!("{:e}", 0.0 + x).parse::<f64>().unwrap_or(f64::from(x)))
}

/// A field group's table.
pub(super) fn group(spec: &GroupSpec) -> Table {
    let mut table = Table::new();
    table.insert("joints", toml_edit::value(spec.joints.iter().map(String::as_str).collect::<Array>()));
    if spec.separate {
        table.insert("separate", toml_edit::value(true));
    }
    if let Some(passive) = spec.passive {
        table.insert("passive", toml_edit::value(passive));
    }
    table
}
