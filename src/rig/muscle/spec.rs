//! A muscle as its author gives it: ends, shapes, size, keys, drivers.

use crate::field::compose::JointOperator;
use crate::field::muscle::{
    axis::{MAX_SEGMENTS, MIN_SEGMENTS},
    profile::{MAX_ECCENTRICITY, MAX_EXPONENT},
};
use glam::Vec3;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// One end of a muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct Attachment {
    /// Name of the bone that carries it.
    pub bone: String,
    /// Metres, in the bone's own space.
    pub offset: Vec3,
    /// Direction of the section's long axis, in the bone's own space.
    pub normal: Vec3,
}

/// How large a muscle is; of a fibre set, how large all fibres are together (a width is each fibre's own).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MuscleSize {
    /// Cubic metres.
    Volume(f32),
    /// Largest radius at rest with eccentricity 0, metres.
    Width(f32),
}

/// Which side of the body a muscle is on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BodySide {
    /// The character's left.
    Left,
    /// The character's right.
    Right,
    /// Neither.
    #[default]
    Centre,
}

/// One of a muscle's shapes (paper A, section 5.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MuscleShape {
    /// Profile exponent at the origin, 1..=9; 1 makes a blunt, rounded end.
    pub alpha: u32,
    /// Profile exponent at the insertion, 1..=9.
    pub beta: u32,
    /// Eccentricity of the section, 0..=.99.
    pub eccentricity: f32,
    /// Factor on the width that the volume gives, over 0 and at most 10: 1 keeps the volume, more exaggerates (paper A,
    /// figure 14).
    pub width: f32,
}

impl MuscleShape {
    /// The papers' shape at rest: a round, symmetric spindle.
    pub const REST: MuscleShape = MuscleShape { alpha: 3, beta: 3, eccentricity: 0.0, width: 1.0 };
    /// Paper A's default shape of full activation: the belly higher and fuller.
    pub const ACTIVE: MuscleShape = MuscleShape { alpha: 4, beta: 7, eccentricity: 0.0, width: 1.0 };
}

/// Several fibres spread between two lines of end points (paper A, section 5.3).
///
/// Each line starts at the attachment's own offset and goes on through these points, in the attachment's bone space,
/// metres. A line without points stays at its attachment. Fibre `i` of `count` joins the points at the same share
/// `i / (count - 1)` of both lines' lengths.
#[derive(Clone, Debug, PartialEq)]
pub struct FibreSet {
    /// Number of fibres, 2..=32.
    pub count: u32,
    /// Further points of the origin line.
    pub origin_line: Vec<Vec3>,
    /// Further points of the insertion line.
    pub insertion_line: Vec<Vec3>,
    /// Whether fibres may overlap one another; else they collide (paper A, figure 7).
    pub overlap: bool,
}

/// How keys are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ease {
    /// Straight.
    #[default]
    Linear,
    /// Held until the next key.
    Step,
    /// Hermite with the keys' own tangents.
    Cubic,
}

/// A number over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// How the keys are joined.
    pub ease: Ease,
    /// Seconds after the clip's start, ascending.
    pub times: Vec<f32>,
    /// One value per key.
    pub values: Vec<f32>,
    /// Slopes into and out of every key, per second; read for [`Ease::Cubic`] alone. Empty: Catmull-Rom's.
    pub tangents: Vec<[f32; 2]>,
}

/// Profile exponents over time, blended at constant volume from key to key.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeCurve {
    /// Linear or step; cubic is read as linear.
    pub ease: Ease,
    /// Seconds after the clip's start, ascending.
    pub times: Vec<f32>,
    /// `(alpha, beta)` of the rest shape per key; the active shape is blended in as ever.
    pub shapes: Vec<(u32, u32)>,
}

/// What a muscle's keys move. An empty curve leaves a parameter alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Keys {
    /// Activation 0..=1: one more driver, combined by [`Drive::keys`].
    pub activation: Curve,
    /// Replaces the blended eccentricity.
    pub eccentricity: Curve,
    /// Factor on the width, besides the shapes' own.
    pub width: Curve,
    /// Replaces the stiffness.
    pub stiffness: Curve,
    /// Replaces the exponents of the rest shape.
    pub shape: ShapeCurve,
}

/// How a driver's value joins those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Combine {
    /// The larger counts.
    #[default]
    Max,
    /// They add up.
    Add,
    /// They multiply.
    Multiply,
}

/// Where an activation comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// Length of the path, straight or round what the muscle lies round, over its rest length: 1 at `min` and below, 0 at `max` and above; the other way
    /// round when inverted.
    Length {
        /// Ratio at one end of the range.
        min: f32,
        /// Ratio at the other end.
        max: f32,
        /// Whether stretching activates, rather than shortening.
        invert: bool,
    },
    /// Angle of a joint against its parent, from its rest pose: 0 at `from`, 1 at `to`.
    Angle {
        /// Name of the joint.
        joint: String,
        /// Axis in the joint's own space, to count turns about it alone, with their sign; else the whole angle.
        axis: Option<Vec3>,
        /// Radians where activation begins.
        from: f32,
        /// Radians where it is full.
        to: f32,
    },
    /// Always the same.
    Constant(f32),
    /// A column of a table over time, as a force or activity model supplies: CSV, first column `time` in seconds.
    Table {
        /// The table, relative to the muscle file.
        file: PathBuf,
        /// Heading of the column; the muscle's name by default.
        column: String,
        /// The column, once the table has been read.
        curve: Curve,
    },
}

/// One driver of a muscle's activation.
#[derive(Clone, Debug, PartialEq)]
pub struct Driver {
    /// Where the value comes from.
    pub source: Source,
    /// How it joins the drivers before it.
    pub combine: Combine,
}

/// All that activates a muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Drivers in order; the first one's value is the start.
    pub drivers: Vec<Driver>,
    /// How activation keys join what the drivers say.
    pub keys: Combine,
    /// Seconds from 0 to 1 at most; 0 is at once.
    pub attack: f32,
    /// Seconds from 1 to 0 at most; 0 is at once.
    pub decay: f32,
}

impl Default for Drive {
    /// Active in so far as it is shorter than at rest, fully at 70 %.
    fn default() -> Drive {
        let source = Source::Length { min: 0.7, max: 1.0, invert: false };
        Drive { drivers: vec![Driver { source, combine: Combine::Max }], keys: Combine::Max, attack: 0.0, decay: 0.0 }
    }
}

/// What a muscle collides with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Collides {
    /// Bones.
    pub bones: bool,
    /// Muscles of its collision group.
    pub muscles: bool,
    /// The skin, from within.
    pub skin: bool,
}

impl Default for Collides {
    /// With everything.
    fn default() -> Collides {
        Collides { bones: true, muscles: true, skin: true }
    }
}

/// What a muscle lies round on its way from origin to insertion (paper B, "Bending Around a Joint", "Bending Around a Bone").
#[derive(Clone, Debug, PartialEq)]
pub struct Wrap {
    /// The obstacle.
    pub around: Around,
    /// Its radius, metres, without the muscle's own thickness.
    pub radius: f32,
    /// A point on the side where the muscle lies, metres, in the obstacle's bone's own space; without one it is the side of the
    /// shorter way at rest.
    pub side: Option<Vec3>,
}

/// The obstacle of a [`Wrap`].
#[derive(Clone, Debug, PartialEq)]
pub enum Around {
    /// A sphere about a joint, by the joint's name.
    Joint(String),
    /// A cylinder along a bone.
    Bone {
        /// Name of the bone.
        bone: String,
        /// Centres of its two ends, metres, in the bone's own space; without them from the bone's joint to its child.
        ends: Option<[Vec3; 2]>,
    },
}

impl Around {
    /// Name of the joint in whose space the obstacle is given.
    pub fn name(&self) -> &str {
        match self {
            Around::Joint(name) | Around::Bone { bone: name, .. } => name,
        }
    }

    /// The key that gives the name in a muscle file.
    pub(in crate::rig) fn key(&self) -> &'static str {
        match self {
            Around::Joint(_) => "joint",
            Around::Bone { .. } => "bone",
        }
    }
}

/// A muscle as its author gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct MuscleSpec {
    /// Its name, unique in the file.
    pub name: String,
    /// Which side it is on.
    pub side: BodySide,
    /// The bone whose field it joins.
    pub bone: String,
    /// End on the body's side.
    pub origin: Attachment,
    /// End that moves.
    pub insertion: Attachment,
    /// What it lies round; straight from end to end where there is nothing.
    pub wrap: Option<Wrap>,
    /// Where it is more than one fibre.
    pub fibres: Option<FibreSet>,
    /// Segments of the axis, 3..=63.
    pub segments: u32,
    /// Shape of activation 0.
    pub rest: MuscleShape,
    /// Shape of activation 1.
    pub active: MuscleShape,
    /// Volume, or width at rest.
    pub size: MuscleSize,
    /// Stiffness k, 0 to 1 (paper A, section 6.2).
    pub stiffness: f32,
    /// Share of the length at each end that is tendon, 0..=.45.
    pub tendon: f32,
    /// Muscles of the same name here collide with one another; empty collides with none.
    pub collision_group: String,
    /// What it collides with, of what the dynamics have on.
    pub collides: Collides,
    /// Frequency of its sideways swing, hertz, in place of the one that its stiffness stands for.
    pub frequency: Option<f32>,
    /// How much of the bones' acceleration along it shifts its belly, 0 (not at all) to 1.
    pub jiggle: f32,
    /// What activates it.
    pub drive: Drive,
    /// What is keyed.
    pub keys: Keys,
}

impl MuscleSpec {
    /// What profile exponents may be.
    pub const EXPONENTS_RANGE: RangeInclusive<u32> = 1..=MAX_EXPONENT;
    /// What eccentricities may be.
    pub const ECCENTRICITY_RANGE: RangeInclusive<f32> = 0.0..=MAX_ECCENTRICITY;
    /// How many segments an axis may have.
    pub const SEGMENTS_RANGE: RangeInclusive<u32> = MIN_SEGMENTS..=MAX_SEGMENTS;
    /// How many fibres a set may have.
    pub const FIBRES_RANGE: RangeInclusive<u32> = 2..=32;
    /// What activations may be.
    pub const ACTIVATION_RANGE: RangeInclusive<f32> = 0.0..=1.0;
    /// What stiffness may be.
    pub const STIFFNESS_RANGE: RangeInclusive<f32> = 0.0..=1.0;
    /// Largest factor on a width: ten times as thick is a slip, and much more overflows further on.
    pub const MAX_WIDTH: f32 = 10.0;
    /// What factors on the width may be.
    pub const WIDTH_RANGE: RangeInclusive<f32> = f32::MIN_POSITIVE..=Self::MAX_WIDTH;
    /// What a frequency may be, hertz.
    pub const FREQUENCY_RANGE: RangeInclusive<f32> = 1.0..=60.0;
    /// What jiggle may be.
    pub const JIGGLE_RANGE: RangeInclusive<f32> = 0.0..=1.0;
    /// What share of the length may be tendon, at each end.
    pub const TENDON_RANGE: RangeInclusive<f32> = 0.0..=0.45;
    /// Segments of an axis where nothing else is said: the paper's 30 particles.
    pub const SEGMENTS: u32 = 29;
    /// Stiffness where nothing else is said.
    pub const STIFFNESS: f32 = 0.4;
    /// Share of tendon where nothing else is said.
    pub const TENDON: f32 = 0.1;

    /// A muscle with everything but ends and size at its default; its active shape is its rest shape.
    pub fn new(name: &str, bone: &str, origin: Attachment, insertion: Attachment, size: MuscleSize) -> MuscleSpec {
        MuscleSpec {
            name: name.into(),
            side: BodySide::Centre,
            bone: bone.into(),
            origin,
            insertion,
            wrap: None,
            fibres: None,
            segments: Self::SEGMENTS,
            rest: MuscleShape::REST,
            active: MuscleShape::REST,
            size,
            stiffness: Self::STIFFNESS,
            tendon: Self::TENDON,
            collision_group: String::new(),
            collides: Collides::default(),
            frequency: None,
            jiggle: 0.0,
            drive: Drive::default(),
            keys: Keys::default(),
        }
    }
}

/// The shape of a bone, for collisions.
#[derive(Clone, Debug, PartialEq)]
pub enum BoneShape {
    /// A capsule in the bone's own space, metres.
    Capsule {
        /// Centre of one end.
        from: Vec3,
        /// Centre of the other end.
        to: Vec3,
        /// Radius.
        radius: f32,
    },
    /// A mesh of the character's file, by name.
    Mesh(String),
}

/// How the limbs at a joint are joined, where the muscle file says it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointSpec {
    /// Name of the joint: the elbow is the lower arm's.
    pub joint: String,
    /// What joins the joint's limb to its parent's.
    pub operator: JointOperator,
}

/// A region in which there is a muscle, where the muscle file says so.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkSpec {
    /// A limb's joint, or a part of the trunk: `abdomen_l`, `chest_r`, `shoulder_l`, `neck_r`.
    pub region: String,
    /// From where to where around it, degrees: 0 in front, 90 outside, 180 behind, -90 inside. May go over 180.
    pub degrees: [f64; 2],
    /// What its muscle is called, without a side; proposed where there is none.
    pub name: Option<String>,
}

impl MarkSpec {
    /// Whether its degrees are a range: over 0 wide, and a whole turn at most.
    pub fn is_range(degrees: [f64; 2]) -> bool {
        let width = degrees[1] - degrees[0];
        width > 0.0 && width <= 360.0
    }

    /// Whether an angle is in the range.
    pub fn holds(&self, degrees: f64) -> bool {
        let [from, to] = self.degrees;
        (degrees - from).rem_euclid(360.0) <= to - from
    }
}

/// A bone whose shape the muscle file gives.
#[derive(Clone, Debug, PartialEq)]
pub struct BoneSpec {
    /// Name of the joint.
    pub bone: String,
    /// Its shape.
    pub shape: BoneShape,
}
