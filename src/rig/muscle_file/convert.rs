//! From the file's tables to muscles, with every number within its bounds.

use super::curve::{CurveTable, Exact, ShapeCurveTable};
use super::place::Fault;
use super::tables::{
    ActiveTable, AngleTable, AttachmentTable, BoneTable, CollidesName, DriverTable, FibresTable, GroupTable,
    JointTable, KeysTable, LengthTable, MarkTable, MuscleTable, TimeTable, WrapKind, WrapTable,
};
use crate::error::is_unprintable;
use crate::rig::GroupSpec;
use crate::rig::muscle::check::{self, Wrong};
use crate::rig::muscle::{
    Around, Attachment, BoneShape, BoneSpec, Collides, Combine, Curve, Drive, Driver, Ease, FibreSet, JointSpec, Keys,
    MarkSpec, MuscleShape, MuscleSize, MuscleSpec, ShapeCurve, Source, Wrap,
};
use glam::Vec3;

type Checked<T> = Result<T, Fault>;

impl From<Wrong> for Fault {
    fn from(wrong: Wrong) -> Fault {
        Fault::new(wrong.key, wrong.what)
    }
}

/// Longest name: what is longer is no name.
const LONGEST_NAME: usize = 256;

/// One muscle; keys of faults are the muscle's own.
pub(super) fn muscle(table: MuscleTable) -> Checked<MuscleSpec> {
    let size = match (table.width, table.volume) {
        (Some(width), None) => MuscleSize::Width(width),
        (None, Some(volume)) => MuscleSize::Volume(volume),
        (None, None) => return Err(Fault::new("", "it needs `width` (m) or `volume` (m^3)")),
        (Some(_), Some(_)) => return Err(Fault::new("volume", "it has both `width` and `volume`; keep one")),
    };
    let name = name("name", table.name)?;
    let (origin, insertion) = (attachment("origin", table.origin)?, attachment("insertion", table.insertion)?);
    let spec = MuscleSpec::new(&name, &self::name("bone", table.bone)?, origin, insertion, size);
    let scale = factor("width_scale", table.width_scale)?;
    let rest = MuscleShape {
        alpha: table.alpha.unwrap_or(MuscleShape::REST.alpha),
        beta: table.beta.unwrap_or(MuscleShape::REST.beta),
        eccentricity: table.eccentricity.unwrap_or(MuscleShape::REST.eccentricity),
        width: scaled("rest_width", table.rest_width, scale)?,
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
        attack: table.attack.unwrap_or(0.0),
        decay: table.decay.unwrap_or(0.0),
    };
    let spec = MuscleSpec {
        side: table.side.into(),
        wrap: table.wrap.map(wrap).transpose()?,
        fibres: table.fibres.map(fibres),
        segments: table.segments.unwrap_or(MuscleSpec::SEGMENTS),
        rest,
        active,
        stiffness: table.stiffness.unwrap_or(MuscleSpec::STIFFNESS),
        tendon: table.tendon.unwrap_or(MuscleSpec::TENDON),
        collision_group: table
            .collision_group
            .map_or(Ok(String::new()), |group| self::name("collision_group", group))?,
        collides: table.collides.map_or(Collides::default(), |names| collides(&names)),
        frequency: table.frequency,
        jiggle: table.jiggle.unwrap_or(0.0),
        drive,
        keys,
        ..spec
    };
    check::muscle(&spec)?;
    Ok(spec)
}

/// A factor on the width; 1 where nothing is said.
fn factor(key: &str, value: Option<f32>) -> Checked<f32> {
    let value = value.unwrap_or(1.0);
    check::within(key, value, MuscleSpec::WIDTH_RANGE)?;
    Ok(value)
}

/// A shape's own factor on the width times that of both shapes, where a product out of bounds is to be looked for.
fn scaled(key: &str, own: Option<f32>, scale: f32) -> Checked<f32> {
    let width = factor(key, own)? * scale;
    if MuscleSpec::WIDTH_RANGE.contains(&width) {
        return Ok(width);
    }
    let most = MuscleSpec::MAX_WIDTH;
    let what = format!("width_scale times {key} is {width}, and must be over 0 and at most {most}");
    Err(Fault::new("width_scale", what))
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
        (Some(capsule), None) => {
            let (from, to) = (Vec3::from(capsule.from.0), Vec3::from(capsule.to.0));
            check::point("capsule.from", from)?;
            check::point("capsule.to", to)?;
            check::positive("capsule.radius", capsule.radius, "m")?;
            BoneShape::Capsule { from, to, radius: capsule.radius }
        }
        (None, Some(mesh)) => BoneShape::Mesh(name("mesh", mesh)?),
        (None, None) => return Err(Fault::new("", "it needs `capsule` or `mesh`")),
        (Some(_), Some(_)) => return Err(Fault::new("mesh", "it has both `capsule` and `mesh`; keep one")),
    };
    Ok(BoneSpec { bone: name("bone", table.bone)?, shape })
}

/// One joint's operator; keys of faults are the table's own.
pub(super) fn joint(joint: String, table: &JointTable) -> Checked<JointSpec> {
    Ok(JointSpec { joint: name("", joint)?, operator: table.operator.into() })
}

/// One field group; keys of faults are the table's own.
pub(super) fn group(group: String, table: GroupTable) -> Checked<GroupSpec> {
    let numbered = table.joints.into_iter().enumerate();
    let joints = numbered.map(|(i, joint)| name(&format!("joints[{i}]"), joint)).collect::<Checked<_>>()?;
    Ok(GroupSpec { name: name("", group)?, joints, separate: table.separate, passive: table.passive })
}

/// A region that must yield its muscle; keys of faults are the table's own.
pub(super) fn mark(table: MarkTable) -> Checked<MarkSpec> {
    if !MarkSpec::is_range(table.degrees) {
        let [from, to] = table.degrees;
        let what = format!("degrees go from {from} to {to}; the second one must be larger, by 360 at most");
        return Err(Fault::new("degrees", what));
    }
    let named = table.name.map(|own| name("name", own)).transpose()?;
    Ok(MarkSpec { region: name("region", table.region)?, degrees: table.degrees, name: named })
}

/// The character's name.
pub(super) fn character(name: String) -> Checked<String> {
    self::name("name", name)
}

fn active(table: ActiveTable, rest: MuscleShape, scale: f32) -> Checked<MuscleShape> {
    Ok(MuscleShape {
        alpha: table.alpha.unwrap_or(MuscleShape::ACTIVE.alpha),
        beta: table.beta.unwrap_or(MuscleShape::ACTIVE.beta),
        eccentricity: table.eccentricity.unwrap_or(rest.eccentricity),
        width: scaled("active.width", table.width, scale)?,
    })
}

fn attachment(key: &str, table: AttachmentTable) -> Checked<Attachment> {
    let normal = table.normal.map_or(Vec3::Z, |normal| Vec3::from(normal.0));
    Ok(Attachment { bone: name(&format!("{key}.bone"), table.bone)?, offset: Vec3::from(table.offset.0), normal })
}

fn collides(names: &[CollidesName]) -> Collides {
    let has = |name| names.contains(&name);
    Collides { bones: has(CollidesName::Bones), muscles: has(CollidesName::Muscles), skin: has(CollidesName::Skin) }
}

fn wrap(table: WrapTable) -> Checked<Wrap> {
    let ends = match (table.from, table.to) {
        (Some(from), Some(to)) => Some([from, to].map(|p| Vec3::from(p.0))),
        (None, None) => None,
        (Some(_), None) => return Err(Fault::new("wrap.from", "a wrap has both `from` and `to`, or neither")),
        (None, Some(_)) => return Err(Fault::new("wrap.to", "a wrap has both `from` and `to`, or neither")),
    };
    let around = match (table.kind, table.joint, table.bone, ends) {
        (WrapKind::Sphere, Some(joint), None, None) => Around::Joint(name("wrap.joint", joint)?),
        (WrapKind::Cylinder, None, Some(bone), ends) => Around::Bone { bone: name("wrap.bone", bone)?, ends },
        (WrapKind::Sphere, None, ..) => return Err(Fault::new("wrap", "a sphere needs `joint`, in its middle")),
        (WrapKind::Sphere, _, Some(_), _) => {
            return Err(Fault::new("wrap.bone", "a sphere is on a `joint` and has no `bone`; a cylinder has"));
        }
        (WrapKind::Sphere, ..) => return Err(Fault::new("wrap.from", "a sphere has no ends; a cylinder has")),
        (WrapKind::Cylinder, _, None, _) => return Err(Fault::new("wrap", "a cylinder needs `bone`, along its axis")),
        (WrapKind::Cylinder, ..) => {
            return Err(Fault::new("wrap.joint", "a cylinder is on a `bone` and has no `joint`; a sphere has"));
        }
    };
    Ok(Wrap { around, radius: table.radius, side: table.side.map(|p| Vec3::from(p.0)) })
}

fn fibres(table: FibresTable) -> FibreSet {
    let line = |points: Vec<Exact<[f32; 3]>>| points.into_iter().map(|p| Vec3::from(p.0)).collect();
    FibreSet {
        count: table.count,
        origin_line: line(table.origin_line),
        insertion_line: line(table.insertion_line),
        overlap: table.overlap,
    }
}

fn driver(index: usize, table: DriverTable, muscle: &str) -> Checked<Driver> {
    let key = format!("drivers[{index}]");
    let combine = table.combine.into();
    let source = match (table.length, table.angle, table.constant, table.table) {
        (Some(LengthTable { min, max, invert }), None, None, None) => {
            Source::Length { min: min.unwrap_or(0.7), max: max.unwrap_or(1.0), invert }
        }
        (None, Some(AngleTable { joint, axis, from, to }), None, None) => {
            let joint = name(&format!("{key}.angle.joint"), joint)?;
            Source::Angle { joint, axis: axis.map(|a| Vec3::from(a.0)), from, to }
        }
        (None, None, Some(value), None) => Source::Constant(value),
        (None, None, None, Some(TimeTable { file, column })) => {
            if file.is_empty() || file.len() > 4096 || file.contains(is_unprintable) {
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
    let keys = Keys {
        activation: curve("keys.activation", table.activation)?,
        eccentricity: curve("keys.eccentricity", table.eccentricity)?,
        width: curve("keys.width", table.width)?,
        stiffness: curve("keys.stiffness", table.stiffness)?,
        shape: table.shape.map(shape_curve).unwrap_or_default(),
    };
    Ok((keys, table.combine.into()))
}

fn curve(key: &str, table: Option<CurveTable>) -> Checked<Curve> {
    let Some(table) = table else { return Ok(Curve::default()) };
    let mut curve = Curve { ease: table.ease.into(), ..Curve::default() };
    let slopes = table.points.first().is_some_and(|point| point.len() == 4);
    if slopes && curve.ease != Ease::Cubic {
        let what = "slopes are read of cubic keys alone; write { ease = \"cubic\", points = [..] }";
        return Err(Fault::new(format!("{key}[0]"), what));
    }
    for (i, point) in table.points.iter().enumerate() {
        let (time, value) = match point[..] {
            [time, value] if !slopes => (time, value),
            [time, value, slope_in, slope_out] if slopes => {
                curve.tangents.push([slope_in, slope_out]);
                (time, value)
            }
            _ => {
                let form =
                    if slopes { "[seconds, value, slope in, slope out] like the first" } else { "[seconds, value]" };
                let what = format!("a key of {} numbers; write {form}", point.len());
                return Err(Fault::new(format!("{key}[{i}]"), what));
            }
        };
        curve.times.push(time);
        curve.values.push(value);
    }
    Ok(curve)
}

fn shape_curve(table: ShapeCurveTable) -> ShapeCurve {
    let (times, shapes) = table.points.iter().map(|&Exact((time, alpha, beta))| (time, (alpha, beta))).unzip();
    ShapeCurve { ease: table.ease.into(), times, shapes }
}

fn name(key: &str, name: String) -> Checked<String> {
    let what = if key.is_empty() { "the name" } else { key.rsplit('.').next().unwrap_or(key) };
    if name.is_empty() && key != "collision_group" {
        return Err(Fault::new(key, format!("{what} is empty; give it a name")));
    }
    if name.len() > LONGEST_NAME {
        return Err(Fault::new(key, format!("{what} is {} bytes long; at most {LONGEST_NAME} are read", name.len())));
    }
    // A terminal takes them for commands: names are repeated in notes, errors and results.
    if let Some(c) = name.chars().find(|&c| is_unprintable(c)) {
        let what =
            format!("{what} holds the control character U+{:04X}; keep to characters that can be seen", c as u32);
        return Err(Fault::new(key, what));
    }
    Ok(name)
}
