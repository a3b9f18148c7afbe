//! What stands in a muscle file, table by table. The JSON Schema is derived from the same declarations, so that what it
//! says and what is read cannot differ; every key's comment is its description there.

use super::curve::Exact;
use super::curve::{CurveTable, ShapeCurveTable};
use crate::field::compose::JointOperator;
use crate::rig::muscle::{BodySide, Combine, Ease};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The muscles of one character. Metres, radians, seconds.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Sinew muscle file")]
pub(super) struct File {
    /// The character that the muscles belong to.
    #[serde(default)]
    pub character: CharacterTable,
    /// The muscles, in the order in which they are shown.
    #[serde(default, rename = "muscle")]
    pub muscles: Vec<MuscleTable>,
    /// Shapes of bones, for collisions.
    #[serde(default, rename = "bone")]
    pub bones: Vec<BoneTable>,
    /// How limbs are joined, by the name of the joint between them: that of the limb farther from the body.
    #[serde(default)]
    pub joints: BTreeMap<String, JointTable>,
    /// Field groups in place of those that are found, by name.
    #[serde(default)]
    pub groups: BTreeMap<String, GroupTable>,
    /// Regions of the skin in which `sinew extract` must find a muscle, however little it shows.
    #[serde(default, rename = "mark")]
    pub marks: Vec<MarkTable>,
}

/// A region that must yield its muscle.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MarkTable {
    /// A limb's joint, or a part of the trunk: abdomen_l, chest_l, shoulder_l, neck_l and their right ones.
    pub region: String,
    /// From where to where around it, degrees: 0 in front, 90 outside, 180 behind, -90 inside.
    pub degrees: [f64; 2],
    /// What its muscle is called, without a side; a name is proposed where nothing is said.
    pub name: Option<String>,
}

/// The character.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CharacterTable {
    /// Its name.
    pub name: Option<String>,
}

/// One muscle.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["width"] }, { "required": ["volume"] }]))]
pub(super) struct MuscleTable {
    /// Name, unique in the file.
    pub name: String,
    /// Side of the body: left, right, or centre where nothing is said.
    #[serde(default)]
    pub side: SideName,
    /// The bone whose skin the muscle shapes.
    pub bone: String,
    /// The end on the body's side.
    pub origin: AttachmentTable,
    /// The end that moves.
    pub insertion: AttachmentTable,
    /// What the muscle lies round on its way; straight from origin to insertion where there is no such table.
    pub wrap: Option<WrapTable>,
    /// Several fibres spread between two lines, in place of one spindle.
    pub fibres: Option<FibresTable>,
    /// Segments of the axis, 3 to 63; 29 where nothing is said.
    #[schemars(range(min = 3, max = 63))]
    pub segments: Option<u32>,
    /// Profile exponent at the origin at rest, 1 to 9; 3 where nothing is said. The profile along the muscle is
    /// s^(alpha-1) (1-s)^(beta-1); a larger one draws the belly away from that end, and 1 makes a blunt end.
    #[schemars(range(min = 1, max = 9))]
    pub alpha: Option<u32>,
    /// Profile exponent at the insertion at rest, 1 to 9; 3 where nothing is said.
    #[schemars(range(min = 1, max = 9))]
    pub beta: Option<u32>,
    /// Eccentricity of the section at rest: 0 is round, 0.99 the flattest.
    #[schemars(range(min = 0.0, max = 0.99))]
    pub eccentricity: Option<f32>,
    /// Factor on the width at rest, over 0 and at most 10; 1 keeps the volume.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rest_width: Option<f32>,
    /// The shape at full activation; the same as at rest where there is no such table.
    pub active: Option<ActiveTable>,
    /// Factor on the width of both shapes, over 0; more than 1 exaggerates. Times a shape's own it is at most 10.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub width_scale: Option<f32>,
    /// Largest radius at rest were the section round, metres. Of a fibre set, each fibre's own.
    pub width: Option<f32>,
    /// Volume in place of the width, cubic metres. Of a fibre set, all fibres' together.
    pub volume: Option<f32>,
    /// Stiffness of the axis, 0 to 1; 0.4 where nothing is said.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub stiffness: Option<f32>,
    /// Share of the length at each end that is tendon, 0 to 0.45; 0.1 where nothing is said.
    #[schemars(range(min = 0.0, max = 0.45))]
    pub tendon: Option<f32>,
    /// Muscles of the same group collide with one another; without one the muscle collides with none.
    pub collision_group: Option<String>,
    /// What the muscle collides with; bones, muscles and skin where nothing is said, and nothing where the list is empty.
    pub collides: Option<Vec<CollidesName>>,
    /// Frequency of its sideways swing, 1 to 60 Hz, in place of the one that the stiffness stands for.
    #[schemars(range(min = 1.0, max = 60.0))]
    pub frequency: Option<f32>,
    /// How much of the bones' acceleration along the muscle shifts its belly, 0 to 1; 0 where nothing is said.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub jiggle: Option<f32>,
    /// What activates the muscle, in order; without any word its own shortening, fully at 70 % of its rest length.
    pub drivers: Option<Vec<DriverTable>>,
    /// Seconds from no to full activation at the quickest; 0 follows at once.
    #[schemars(range(min = 0.0))]
    pub attack: Option<f32>,
    /// Seconds from full to no activation at the quickest; 0 follows at once.
    #[schemars(range(min = 0.0))]
    pub decay: Option<f32>,
    /// Values over time.
    pub keys: Option<KeysTable>,
}

/// Side of the body.
#[derive(Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum SideName {
    Left,
    Right,
    #[default]
    Centre,
}

/// What a muscle can collide with.
#[derive(Clone, Copy, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "lowercase")]
pub(super) enum CollidesName {
    Bones,
    Muscles,
    Skin,
}

/// One end of a muscle.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AttachmentTable {
    /// The bone that carries it.
    pub bone: String,
    /// Metres, in the bone's own space at rest.
    pub offset: Exact<[f32; 3]>,
    /// Direction of the section's long axis, in the bone's own space; Z where nothing is said.
    pub normal: Option<Exact<[f32; 3]>>,
}

/// What a muscle lies round: a sphere on a joint, or a cylinder on a bone.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    { "properties": { "kind": { "const": "sphere" } }, "required": ["joint"] },
    { "properties": { "kind": { "const": "cylinder" } }, "required": ["bone"] }]))]
pub(super) struct WrapTable {
    /// Its form.
    pub kind: WrapKind,
    /// The joint in the middle of a sphere.
    pub joint: Option<String>,
    /// The bone along the axis of a cylinder.
    pub bone: Option<String>,
    /// Radius of the joint or bone, metres; half the muscle's thickness is added to it.
    pub radius: f32,
    /// Centre of one end of a cylinder, metres, in the bone's own space at rest; the bone's joint where nothing is said.
    pub from: Option<Exact<[f32; 3]>>,
    /// Centre of its other end; the joint's child where nothing is said. Both ends or none.
    pub to: Option<Exact<[f32; 3]>>,
    /// A point on the side where the muscle lies, metres, in the joint's or bone's own space at rest; the side of the shorter
    /// way at rest where nothing is said.
    pub side: Option<Exact<[f32; 3]>>,
}

/// Form of what a muscle lies round.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum WrapKind {
    Sphere,
    Cylinder,
}

/// A fibre set.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FibresTable {
    /// Number of fibres, 2 to 32.
    #[schemars(range(min = 2, max = 32))]
    pub count: u32,
    /// Points after the origin's own on the line from which the fibres start; metres, in the origin bone's space.
    #[serde(default)]
    pub origin_line: Vec<Exact<[f32; 3]>>,
    /// Points after the insertion's own on the line where the fibres end; metres, in the insertion bone's space.
    #[serde(default)]
    pub insertion_line: Vec<Exact<[f32; 3]>>,
    /// Whether the fibres may overlap; else they collide with one another.
    #[serde(default)]
    pub overlap: bool,
}

/// The shape at full activation.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ActiveTable {
    /// Profile exponent at the origin, 1 to 9; 4 where nothing is said.
    #[schemars(range(min = 1, max = 9))]
    pub alpha: Option<u32>,
    /// Profile exponent at the insertion, 1 to 9; 7 where nothing is said.
    #[schemars(range(min = 1, max = 9))]
    pub beta: Option<u32>,
    /// Eccentricity of the section; as at rest where nothing is said.
    #[schemars(range(min = 0.0, max = 0.99))]
    pub eccentricity: Option<f32>,
    /// Factor on the width, over 0 and at most 10; 1 keeps the volume.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub width: Option<f32>,
}

/// One driver: one of length, angle, constant and table.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["length"] }, { "required": ["angle"] }, { "required": ["constant"] },
    { "required": ["table"] }]))]
pub(super) struct DriverTable {
    /// The muscle's length over its length at rest.
    pub length: Option<LengthTable>,
    /// The angle of a joint.
    pub angle: Option<AngleTable>,
    /// Always the same value.
    pub constant: Option<f32>,
    /// A column of a table over time.
    pub table: Option<TimeTable>,
    /// How it joins the drivers before it: the larger (max), the sum (add) or the product (multiply).
    #[serde(default)]
    pub combine: CombineName,
}

/// Activation by length: 1 at `min` and below, 0 at `max` and above.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LengthTable {
    /// Ratio of full activation; 0.7 where nothing is said.
    pub min: Option<f32>,
    /// Ratio of no activation; 1 where nothing is said.
    pub max: Option<f32>,
    /// Whether stretching activates rather than shortening.
    #[serde(default)]
    pub invert: bool,
}

/// Activation by the angle of a joint from its rest pose: 0 at `from`, 1 at `to`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AngleTable {
    /// The joint.
    pub joint: String,
    /// Axis in the joint's own space, to count turns about it alone, with their sign; else the whole angle counts.
    pub axis: Option<Exact<[f32; 3]>>,
    /// Radians where activation begins.
    #[serde(default)]
    pub from: f32,
    /// Radians where it is full.
    pub to: f32,
}

/// Activation from a table over time: CSV whose first column is `time` in seconds.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TimeTable {
    /// The table's file, from the muscle file's folder.
    pub file: String,
    /// Heading of the column; the muscle's name where nothing is said.
    pub column: Option<String>,
}

/// How two values are joined.
#[derive(Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum CombineName {
    #[default]
    Max,
    Add,
    Multiply,
}

/// Values over time. Times are seconds after the clip's start, ascending.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct KeysTable {
    /// Activation, 0 to 1.
    pub activation: Option<CurveTable>,
    /// Eccentricity, 0 to 0.99, in place of the shapes' own.
    pub eccentricity: Option<CurveTable>,
    /// Factor on the width, over 0 and at most 10, besides the shapes' own.
    pub width: Option<CurveTable>,
    /// Stiffness, 0 to 1, in place of the muscle's own.
    pub stiffness: Option<CurveTable>,
    /// Exponents at rest, blended at constant volume from key to key.
    pub shape: Option<ShapeCurveTable>,
    /// How keyed activation joins what the drivers say.
    #[serde(default)]
    pub combine: CombineName,
}

/// How keys are joined.
#[derive(Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum EaseName {
    #[default]
    Linear,
    Step,
    Cubic,
}

/// A field group.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GroupTable {
    /// The joints that share one field; what hangs below them and would have shared theirs goes with them.
    pub joints: Vec<String>,
    /// Whether each of the joints has a field of its own instead, under its own name; false where nothing is said.
    #[serde(default)]
    pub separate: bool,
    /// Whether vertices bound almost wholly to the group follow linear skinning; as found where nothing is said: so they do on
    /// heads, hands and feet.
    pub passive: Option<bool>,
}

/// A joint.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct JointTable {
    /// What joins the fields of the two limbs: union and blend at any angle; contact (elbow is the same), elbow2, test-elbow,
    /// finger, finger2 and camel open from the union to the blend by the angle between them; bulge swells in the fold.
    pub operator: OperatorName,
}

/// An operator that joins two limbs.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum OperatorName {
    Union,
    Blend,
    Contact,
    Bulge,
    Elbow,
    Elbow2,
    TestElbow,
    Finger,
    Finger2,
    Camel,
}

/// The shape of a bone for collisions: a capsule or a mesh.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["capsule"] }, { "required": ["mesh"] }]))]
pub(super) struct BoneTable {
    /// The bone.
    pub bone: String,
    /// A capsule in the bone's own space at rest.
    pub capsule: Option<CapsuleTable>,
    /// A skinned part or a rigid mesh of the character's file, by name.
    pub mesh: Option<String>,
}

/// A capsule, metres.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CapsuleTable {
    /// Centre of one end.
    pub from: Exact<[f32; 3]>,
    /// Centre of the other end.
    pub to: Exact<[f32; 3]>,
    /// Radius.
    pub radius: f32,
}

impl From<SideName> for BodySide {
    fn from(name: SideName) -> BodySide {
        match name {
            SideName::Left => BodySide::Left,
            SideName::Right => BodySide::Right,
            SideName::Centre => BodySide::Centre,
        }
    }
}

impl From<OperatorName> for JointOperator {
    fn from(name: OperatorName) -> JointOperator {
        match name {
            OperatorName::Union => JointOperator::Union,
            OperatorName::Blend => JointOperator::Blend,
            OperatorName::Contact => JointOperator::Contact,
            OperatorName::Bulge => JointOperator::Bulge,
            OperatorName::Elbow => JointOperator::Elbow,
            OperatorName::Elbow2 => JointOperator::Elbow2,
            OperatorName::TestElbow => JointOperator::TestElbow,
            OperatorName::Finger => JointOperator::Finger,
            OperatorName::Finger2 => JointOperator::Finger2,
            OperatorName::Camel => JointOperator::Camel,
        }
    }
}

impl From<CombineName> for Combine {
    fn from(name: CombineName) -> Combine {
        match name {
            CombineName::Max => Combine::Max,
            CombineName::Add => Combine::Add,
            CombineName::Multiply => Combine::Multiply,
        }
    }
}

impl From<EaseName> for Ease {
    fn from(name: EaseName) -> Ease {
        match name {
            EaseName::Linear => Ease::Linear,
            EaseName::Step => Ease::Step,
            EaseName::Cubic => Ease::Cubic,
        }
    }
}
