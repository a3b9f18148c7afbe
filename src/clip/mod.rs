//! Animation of the file's nodes, sampled to a [`Pose`](crate::rig::Pose).

mod sample;

pub(crate) use sample::node_globals;

use crate::rig::Character;
use glam::{Mat4, Quat, Vec2, Vec3};

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

/// One animation of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Name in the file, or `#N` where it has none.
    pub name: String,
    /// First key of all channels, seconds.
    pub start: f32,
    /// Last key of all channels, seconds.
    pub end: f32,
    /// Channels.
    pub channels: Vec<Channel>,
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
}
