//! The character as it comes from a file: skeleton, skin mesh, influences, materials.

use super::PaintedMuscle;
use glam::{Mat4, Vec2, Vec3};
use std::ops::Range;

/// One joint of the skeleton that moves the skin.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name in the file, or `joint_N` where the file has none.
    pub name: String,
    /// Index of the nearest ancestor that is a joint too; always smaller than the joint's own index.
    pub parent: Option<u32>,
    /// Index of the file's node.
    pub node: u32,
    /// Scene space at rest to the joint's own space.
    pub inverse_bind: Mat4,
}

impl Joint {
    /// The joint's own space to scene space at rest.
    pub fn bind(&self) -> Mat4 {
        self.inverse_bind.inverse()
    }
}

crate::gpu_struct! {
    /// One joint's share in one vertex.
    pub struct Influence {
        /// Index into [`Character::joints`].
        pub joint: u32,
        /// Share in 0..=1; the shares of a vertex add up to 1.
        pub weight: f32,
    }
}

/// A contiguous run of the skin that came from one primitive of the file.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name of the mesh, with the primitive's number where it has several.
    pub name: String,
    /// Index of the file's node that carries the mesh.
    pub node: u32,
    /// Vertices of the part.
    pub vertices: Range<u32>,
    /// Triangles of the part.
    pub triangles: Range<u32>,
    /// Index into [`Character::materials`].
    pub material: u32,
}

/// What is needed of a material to show a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file, or empty.
    pub name: String,
    /// Base colour, linear RGBA.
    pub base_color: [f32; 4],
    /// Base-colour texture: index into [`Character::images`], sampled with `TEXCOORD_0`.
    pub texture: Option<u32>,
    /// Whether back faces are shown.
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Material { name: String::new(), base_color: [0.8, 0.8, 0.8, 1.0], texture: None, double_sided: false }
    }
}

/// A decoded picture, sRGB, 8 bits per channel, rows from the top.
#[derive(Clone)]
pub struct Image {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// `width * height * 4` bytes.
    pub rgba: Vec<u8>,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Image {{ {} x {} }}", self.width, self.height)
    }
}

/// Skeleton, skin and influences of one character, all in scene space at rest (the bind pose).
///
/// Vertices are in cache order: skinned meshes by ascending node index, then primitive, then `POSITION` order.
/// Joints are ordered so that a parent precedes its children.
#[derive(Clone, Debug, Default)]
pub struct Character {
    /// Name for messages: the file's stem.
    pub name: String,
    /// Joints, parents first.
    pub joints: Vec<Joint>,
    /// Positions at rest, one per vertex.
    pub positions_rest: Vec<Vec3>,
    /// Unit normals at rest, one per vertex; area-weighted face normals where the file has none.
    pub normals_rest: Vec<Vec3>,
    /// Texture coordinates, one per vertex; zero where the file has none.
    pub uvs: Vec<Vec2>,
    /// Corner indices of every triangle.
    pub triangles: Vec<[u32; 3]>,
    /// `influence_offsets[v]..influence_offsets[v + 1]` are the influences of vertex `v`; one longer than the vertices.
    pub influence_offsets: Vec<u32>,
    /// Influences of all vertices, ascending by vertex, strongest first within a vertex.
    pub influences: Vec<Influence>,
    /// Weights of muscles that the file paints, part by part; where it paints none, weights are found.
    pub painted: Vec<PaintedMuscle>,
    /// Runs of the skin by primitive.
    pub parts: Vec<Part>,
    /// Materials; never empty.
    pub materials: Vec<Material>,
    /// Textures.
    pub images: Vec<Image>,
}

impl Character {
    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions_rest.len()
    }

    /// Influences of vertex `v`, strongest first.
    pub fn influences_of(&self, v: usize) -> &[Influence] {
        &self.influences[self.influence_offsets[v] as usize..self.influence_offsets[v + 1] as usize]
    }

    /// Corners of the smallest box around the vertices at rest.
    pub fn bounds_rest(&self) -> (Vec3, Vec3) {
        self.positions_rest.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)))
    }

    /// Longest side of the box at rest, the "height" that tolerances refer to.
    pub fn height_rest(&self) -> f32 {
        let (lo, hi) = self.bounds_rest();
        if self.positions_rest.is_empty() { 0.0 } else { (hi - lo).max_element() }
    }
}

/// Where the joints are at one moment, and what is keyed of the muscles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// Per joint: its global transform times its inverse bind matrix, scene space at rest to scene space posed.
    pub palette: Vec<Mat4>,
    /// Per node of the file: its global transform, for rigid parts.
    pub nodes: Vec<Mat4>,
    /// Seconds after the clip's start.
    pub time: f32,
    /// Muscle parameters that the clip, or the caller, keys at this moment. Muscles that a rig lacks are passed over.
    pub keyed: Vec<Keyed>,
    /// Activation per muscle of the file, in its order, in place of what drivers and keys say; empty leaves it to them.
    pub activations: Vec<f32>,
}

/// One keyed parameter of one muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyed {
    /// Name of the muscle.
    pub muscle: String,
    /// The parameter and its value.
    pub key: Key,
}

/// A muscle parameter at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Key {
    /// Activation 0..=1, joined with the drivers as the muscle's `Drive::keys` says.
    Activation(f32),
    /// Eccentricity 0..=.99.
    Eccentricity(f32),
    /// Factor on the width.
    Width(f32),
    /// Stiffness 0..=1.
    Stiffness(f32),
    /// Exponents of the rest shape, on the way from one pair to the next.
    Shape {
        /// `(alpha, beta)` that is left.
        from: (u32, u32),
        /// `(alpha, beta)` that is approached.
        to: (u32, u32),
        /// 0..=1 of the way.
        share: f32,
    },
}

impl Pose {
    /// The bind pose: nothing moves.
    pub fn rest(character: &Character) -> Pose {
        Pose { palette: vec![Mat4::IDENTITY; character.joints.len()], ..Pose::default() }
    }
}
