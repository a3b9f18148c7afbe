//! A muscle's partner on the other side: reflected in the character's sagittal plane, x = 0 of scene space at rest.

use super::SideNames;
use crate::error::MuscleError;
use crate::rig::muscle::{Around, Attachment, BodySide, BoneShape, BoneSpec, JointSpec, MuscleSpec, Source};
use crate::rig::{Character, GroupSpec};
use glam::{DMat4, DVec3, Vec3};

/// Numbers are written to the micrometre: finer ones only make a file hard to read.
const STEPS_PER_METRE: f64 = 1e6;

/// The partner of a muscle, attached to the bones of the other side.
pub(super) fn muscle(spec: &MuscleSpec, character: &Character, names: &SideNames) -> Result<MuscleSpec, MuscleError> {
    let mut partner = spec.clone();
    partner.name = names.other(&spec.name);
    partner.side = match spec.side {
        BodySide::Left => BodySide::Right,
        BodySide::Right => BodySide::Left,
        BodySide::Centre => BodySide::Centre,
    };
    partner.collision_group = names.other(&spec.collision_group);
    let across = |key: &str, bone: &str| {
        let other = names.other(bone);
        Across::new(character, bone, &other).map(|across| (across, other)).map_err(|missing| MuscleError::Value {
            muscle: spec.name.clone(),
            key: key.into(),
            what: missing,
        })
    };
    partner.bone = across("bone", &spec.bone)?.1;
    let (origin, bone) = across("origin.bone", &spec.origin.bone)?;
    partner.origin = origin.attachment(&spec.origin, bone);
    let (insertion, bone) = across("insertion.bone", &spec.insertion.bone)?;
    partner.insertion = insertion.attachment(&spec.insertion, bone);
    if let Some(wrap) = &mut partner.wrap {
        let (bone, other) = across(&format!("wrap.{}", wrap.around.key()), wrap.around.name())?;
        wrap.side = wrap.side.map(|p| bone.point(p));
        match &mut wrap.around {
            Around::Joint(joint) => *joint = other,
            Around::Bone { bone: name, ends } => {
                *name = other;
                *ends = ends.map(|ends| ends.map(|p| bone.point(p)));
            }
        }
    }
    if let Some(set) = &mut partner.fibres {
        set.origin_line.iter_mut().for_each(|p| *p = origin.point(*p));
        set.insertion_line.iter_mut().for_each(|p| *p = insertion.point(*p));
    }
    for (d, driver) in partner.drive.drivers.iter_mut().enumerate() {
        match &mut driver.source {
            Source::Angle { joint, axis, .. } => {
                let (bone, other) = across(&format!("drivers[{d}].angle.joint"), joint)?;
                // Turns change their sense in a mirror, so the axis turns round as well; unless the partner's bind is the
                // mirror already, which drivers take out of it.
                *axis = axis.map(|axis| bone.direction(axis) * bone.handedness());
                *joint = other;
            }
            Source::Table { column, .. } => *column = names.other(column),
            Source::Length { .. } | Source::Constant(_) => {}
        }
    }
    Ok(partner)
}

/// The partner of a bone's shape; `Err` names what is missing.
pub(super) fn bone(spec: &BoneSpec, character: &Character, names: &SideNames) -> Result<BoneSpec, String> {
    let other = names.other(&spec.bone);
    let across = Across::new(character, &spec.bone, &other)?;
    let shape = match &spec.shape {
        BoneShape::Capsule { from, to, radius } => {
            BoneShape::Capsule { from: across.point(*from), to: across.point(*to), radius: *radius }
        }
        BoneShape::Mesh(name) => BoneShape::Mesh(names.other(name)),
    };
    Ok(BoneSpec { bone: other, shape })
}

/// The partner of a joint; `Err` names what is missing.
pub(super) fn joint(spec: &JointSpec, character: &Character, names: &SideNames) -> Result<JointSpec, String> {
    let joint = names.other(&spec.joint);
    Across::new(character, &spec.joint, &joint)?;
    Ok(JointSpec { joint, operator: spec.operator })
}

/// The partner of a field group; `Err` names what is missing.
pub(super) fn group(spec: &GroupSpec, character: &Character, names: &SideNames) -> Result<GroupSpec, String> {
    let across = |joint: &String| {
        let other = names.other(joint);
        Across::new(character, joint, &other).map(|_| other)
    };
    let joints = spec.joints.iter().map(across).collect::<Result<_, _>>()?;
    Ok(GroupSpec { name: names.other(&spec.name), joints, ..spec.clone() })
}

/// From one bone's space through the mirror into its partner's.
struct Across(DMat4);

impl Across {
    fn new(character: &Character, bone: &str, other: &str) -> Result<Across, String> {
        let joint = |name: &str| {
            character.joints.iter().find(|j| j.name == name).ok_or_else(|| {
                let names = character.joints.iter().map(|j| j.name.as_str());
                let nearest = crate::rig::nearest::nearest(name, names, 3).join(", ");
                format!("bone `{name}` is not a joint of the character, so nothing can be mirrored to it; nearest names: {nearest}")
            })
        };
        let bind = joint(bone)?.inverse_bind.as_dmat4().inverse();
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        Ok(Across(joint(other)?.inverse_bind.as_dmat4() * mirror * bind))
    }

    fn point(&self, p: Vec3) -> Vec3 {
        rounded(self.0.transform_point3(p.as_dvec3()))
    }

    fn direction(&self, v: Vec3) -> Vec3 {
        rounded(self.0.transform_vector3(v.as_dvec3()).normalize_or_zero())
    }

    /// 1 where the way keeps the sense of turns, -1 where it turns it round.
    fn handedness(&self) -> f32 {
        self.0.determinant().signum() as f32
    }

    fn attachment(&self, end: &Attachment, bone: String) -> Attachment {
        Attachment { bone, offset: self.point(end.offset), normal: self.direction(end.normal) }
    }
}

fn rounded(v: DVec3) -> Vec3 {
    // 0 + x turns -0 into 0.
    ((v * STEPS_PER_METRE).round() / STEPS_PER_METRE + DVec3::ZERO).as_vec3()
}
