//! Animation of the file's nodes and muscles, sampled to a [`Pose`](crate::rig::Pose).

mod made;
mod sample;

pub use made::TestClip;
pub(crate) use sample::node_globals;

use crate::rig::muscle::{Curve, ShapeCurve};
use crate::rig::{Character, Key};
use glam::{Mat4, Quat, Vec2, Vec3};
use made::MadeClips;
use std::sync::OnceLock;

/// How a key reaches the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight, spherical for rotations.
    Linear,
    /// Held until the next key.
    Step,
    /// Hermite with in and out tangents: three values per key.
    CubicSpline,
}

/// What a channel moves, with the values of its keys.
#[derive(Clone, Debug, PartialEq)]
pub enum Track {
    /// Metres.
    Translation(Vec<Vec3>),
    /// Unit quaternions (tangents of cubic splines are not unit).
    Rotation(Vec<Quat>),
    /// Factors.
    Scale(Vec<Vec3>),
}

impl Track {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Track::Translation(values) | Track::Scale(values) => values.len(),
            Track::Rotation(values) => values.len(),
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The keys of one property of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Index into [`Scene::nodes`].
    pub node: u32,
    /// Key times in seconds, ascending; of equal ones the last counts.
    pub times: Vec<f32>,
    /// How the keys are joined.
    pub interpolation: Interpolation,
    /// Values: one per key, three (in-tangent, value, out-tangent) for cubic splines.
    pub track: Track,
}

/// Which parameter of a muscle a channel keys, with its keys; times in seconds as in [`Channel::times`].
#[derive(Clone, Debug, PartialEq)]
pub enum MuscleTrack {
    /// 0..=1, joined with the muscle's drivers.
    Activation(Curve),
    /// 0..=.99.
    Eccentricity(Curve),
    /// Factor, 0..=10.
    Width(Curve),
    /// 0..=1.
    Stiffness(Curve),
    /// Exponents of the rest shape, 1..=9.
    Shape(ShapeCurve),
}

impl MuscleTrack {
    /// The key at a time; `None` where there are none.
    pub fn at(&self, time: f32) -> Option<Key> {
        match self {
            MuscleTrack::Activation(curve) => curve.at(time).map(Key::Activation),
            MuscleTrack::Eccentricity(curve) => curve.at(time).map(Key::Eccentricity),
            MuscleTrack::Width(curve) => curve.at(time).map(Key::Width),
            MuscleTrack::Stiffness(curve) => curve.at(time).map(Key::Stiffness),
            MuscleTrack::Shape(curve) => curve.at(time),
        }
    }
}

/// The keys of one parameter of one muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct MuscleChannel {
    /// Name of the muscle in the muscle file.
    pub muscle: String,
    /// The parameter and its keys.
    pub track: MuscleTrack,
}

impl MuscleChannel {
    /// Key times in seconds, as in [`Channel::times`].
    pub fn times(&self) -> &[f32] {
        match &self.track {
            MuscleTrack::Activation(c)
            | MuscleTrack::Eccentricity(c)
            | MuscleTrack::Width(c)
            | MuscleTrack::Stiffness(c) => &c.times,
            MuscleTrack::Shape(c) => &c.times,
        }
    }
}

/// One animation of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Name in the file, or `#N` where it has none.
    pub name: String,
    /// First key of all channels, seconds.
    pub start: f32,
    /// Last key of all channels, seconds.
    pub end: f32,
    /// Channels that move nodes.
    pub channels: Vec<Channel>,
    /// Channels that key muscles.
    pub muscle_channels: Vec<MuscleChannel>,
}

impl Clip {
    /// Whether nothing is keyed.
    pub fn is_empty(&self) -> bool {
        self.channels.is_empty() && self.muscle_channels.is_empty()
    }
}

/// A node's local transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Local {
    /// Animatable parts, applied scale first.
    Parts {
        /// Metres.
        translation: Vec3,
        /// Unit quaternion.
        rotation: Quat,
        /// Factors.
        scale: Vec3,
    },
    /// A matrix, which glTF does not let animations touch.
    Matrix(Mat4),
}

/// One node of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name in the file, or empty.
    pub name: String,
    /// Parent node.
    pub parent: Option<u32>,
    /// Transform relative to the parent, as the file has it.
    pub local: Local,
}

/// A mesh that hangs rigidly from a node: rendered, never cached.
#[derive(Clone, Debug)]
pub struct RigidPart {
    /// Name of the mesh.
    pub name: String,
    /// The node it hangs from.
    pub node: u32,
    /// Positions in the node's space.
    pub positions: Vec<Vec3>,
    /// Unit normals in the node's space.
    pub normals: Vec<Vec3>,
    /// Texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Corner indices.
    pub triangles: Vec<[u32; 3]>,
    /// Index into the character's materials.
    pub material: u32,
}

/// Everything a file brought: the character, the nodes that carry it, and their animation.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Skeleton and skin.
    pub character: Character,
    /// All nodes of the file, in file order.
    pub nodes: Vec<Node>,
    /// Node indices, parents before children.
    pub node_order: Vec<u32>,
    /// Animations of the file.
    pub clips: Vec<Clip>,
    /// Rigid meshes.
    pub rigid: Vec<RigidPart>,
    /// What was odd but accepted, one line each, naming the element.
    pub notes: Vec<String>,
    /// Clips made by code, once one of them is asked for.
    pub(crate) made: OnceLock<MadeClips>,
}

/// Which motion is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClipChoice {
    /// The bind pose.
    Rest,
    /// The file's own node transforms.
    Default,
    /// An animation, by index into [`Scene::clips`].
    Clip(usize),
    /// A clip that is made by code; the bind pose where the character lacks what it moves.
    Test(TestClip),
}
