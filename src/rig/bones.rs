//! Shapes of bones, for collisions: as the muscle file gives them, else capsules found from the skeleton and the skin.

use super::muscle::{BoneShape, BoneSpec};
use super::nearest::nearest;
use super::{Character, FrameInputs, Pose, Rig};
use crate::error::BoneError;
use crate::field::{GroupGrid, evaluate::FieldInput};
use glam::{Vec3, Vec4Swizzles};
use rayon::prelude::*;

/// A bone's radius as a share of the median of its distances from the skin around it: about a humerus' and a femur's own
/// on an adult.
const RADIUS_SHARE: f32 = 0.33;
/// Least distance of a bone's axis from the skin, in its radii: what lies nearer is cut off its ends.
const CLEARANCE: f32 = 1.5;
/// Places along a bone at which its distance from the skin is taken.
const PLACES: usize = 33;
/// A child continues a bone where its direction has this cosine to the bone's own Y, or else to where its skin lies.
const ALONG_Y: f32 = 0.85;
const ALONG_SKIN: f32 = 0.7;
/// Children whose cosines differ by less are in one direction: the farthest continues the bone, others are helpers.
const SAME_DIRECTION: f32 = 0.02;
/// Field value at the skin.
const SURFACE: f32 = 0.5;

/// A mesh that a muscle file may name as a bone's shape, besides the skinned parts of the character.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoneMesh {
    /// Its name.
    pub name: String,
    /// Positions in scene space at rest, metres.
    pub positions: Vec<Vec3>,
    /// Corner indices.
    pub triangles: Vec<[u32; 3]>,
}

/// A bone's shape in its joint's own space at rest.
#[derive(Clone, Debug, PartialEq)]
pub enum ColliderShape {
    /// All points within a radius of a segment.
    Capsule {
        /// Centre of one end, metres.
        from: Vec3,
        /// Centre of the other end, metres.
        to: Vec3,
        /// Radius, metres.
        radius: f32,
    },
    /// A mesh.
    Mesh {
        /// Positions, metres.
        positions: Vec<Vec3>,
        /// Corner indices.
        triangles: Vec<[u32; 3]>,
    },
}

/// What muscles collide with: one bone, moved by its joint.
#[derive(Clone, Debug, PartialEq)]
pub struct BoneCollider {
    /// The joint.
    pub joint: u32,
    /// Whether the muscle file gives its shape, rather than the skeleton.
    pub given: bool,
    /// Its shape.
    pub shape: ColliderShape,
    /// Distance field of a mesh in scene space at rest, metres, among the rig's nodes; without nodes for a capsule.
    pub grid: GroupGrid,
}

/// Resolves the shapes that a muscle file gives.
///
/// # Errors
/// A bone or a mesh that the character lacks, a bone that stands twice, or a shape that is not finite or has no size.
pub(super) fn given(
    character: &Character,
    specs: &[BoneSpec],
    meshes: &[BoneMesh],
) -> Result<Vec<BoneCollider>, BoneError> {
    let mut found: Vec<BoneCollider> = Vec::with_capacity(specs.len());
    for spec in specs {
        let bone = || spec.bone.clone();
        let Some(joint) = character.joints.iter().position(|j| j.name == spec.bone) else {
            let names = nearest(&spec.bone, character.joints.iter().map(|j| j.name.as_str()), 3).join(", ");
            return Err(BoneError::UnknownBone { bone: bone(), nearest: names });
        };
        let refuse = |key: &str, what: &str| Err(BoneError::Shape { bone: bone(), key: key.into(), what: what.into() });
        if found.iter().any(|other| other.joint == joint as u32) {
            return refuse("bone", "it stands twice; give each bone one shape");
        }
        let shape = match &spec.shape {
            BoneShape::Capsule { from, to, radius } => {
                if !(from.is_finite() && to.is_finite() && *radius > 0.0 && radius.is_finite()) {
                    return refuse("capsule", "its capsule must be finite, with a radius (m) over 0");
                }
                ColliderShape::Capsule { from: *from, to: *to, radius: *radius }
            }
            BoneShape::Mesh(name) => {
                let shape = mesh(character, joint, name, meshes, &spec.bone)?;
                let ColliderShape::Mesh { positions, triangles } = &shape else { continue };
                let known = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < positions.len());
                if triangles.is_empty() || !triangles.iter().all(known) || positions.iter().any(|p| !p.is_finite()) {
                    return refuse("mesh", "its mesh is empty or not finite; give another one or a capsule");
                }
                shape
            }
        };
        found.push(BoneCollider { joint: joint as u32, given: true, shape, grid: GroupGrid::default() });
    }
    Ok(found)
}

/// A mesh by name, brought to a joint's own space.
fn mesh(
    character: &Character,
    joint: usize,
    name: &str,
    meshes: &[BoneMesh],
    bone: &str,
) -> Result<ColliderShape, BoneError> {
    let to_joint = &character.joints[joint].inverse_bind;
    let local = |positions: &[Vec3]| positions.iter().map(|p| to_joint.transform_point3(*p)).collect();
    if let Some(part) = character.parts.iter().find(|part| part.name == name) {
        let (first, end) = (part.vertices.start as usize, part.vertices.end as usize);
        let triangles = &character.triangles[part.triangles.start as usize..part.triangles.end as usize];
        return Ok(ColliderShape::Mesh {
            positions: local(&character.positions_rest[first..end]),
            triangles: triangles.iter().map(|t| t.map(|i| i.wrapping_sub(part.vertices.start))).collect(),
        });
    }
    if let Some(mesh) = meshes.iter().find(|mesh| mesh.name == name) {
        return Ok(ColliderShape::Mesh { positions: local(&mesh.positions), triangles: mesh.triangles.clone() });
    }
    let names = character.parts.iter().map(|p| p.name.as_str()).chain(meshes.iter().map(|m| m.name.as_str()));
    let nearest = nearest(name, names, 3).join(", ");
    Err(BoneError::UnknownMesh { bone: bone.into(), mesh: name.into(), nearest })
}

/// Capsules for the bones that muscles need and the file does not give: every joint that carries the end of a muscle
/// or belongs to a field group that has muscles.
///
/// A capsule goes from its joint to the child that continues the bone, or through the joint's skin where there is none.
/// It is [`RADIUS_SHARE`] of its distance from the skin thick, and cut off where it would come near the skin or leave the
/// body. Ascending by joint together with `given`.
pub(super) fn with_capsules(rig: &Rig, mut given: Vec<BoneCollider>, skinned_bones: &[BoneSpec]) -> Vec<BoneCollider> {
    let character = &rig.character;
    let Ok(inputs) = FrameInputs::new(rig, &Pose::rest(character)) else { return given };
    let (shaped, axes) = rig.muscles_at_rest();
    let field = FieldInput { groups: &inputs.groups, nodes: &rig.nodes, muscles: &shaped, axes: &axes };
    let skin = Skin::of(character, skinned_bones);
    let needed = |j: u32| {
        let group = rig.groups.group_of_joint[j as usize];
        rig.muscles.iter().any(|m| [m.origin_joint, m.insertion_joint].contains(&j) || m.group == group)
    };
    let joints: Vec<u32> =
        (0..character.joints.len() as u32).filter(|&j| needed(j) && given.iter().all(|b| b.joint != j)).collect();
    let inside = |p: Vec3| field.composed(p).sample.value > SURFACE;
    let found = joints.par_iter().filter_map(|&joint| {
        let (from, to, radius) = capsule(&skin, &inside, axis(character, joint)?)?;
        let own = &character.joints[joint as usize];
        let [from, to] = [from, to].map(|p| own.inverse_bind.transform_point3(p));
        let radius = radius * own.inverse_bind.determinant().abs().cbrt();
        let finite = from.is_finite() && to.is_finite() && radius > 0.0 && radius.is_finite();
        let shape = ColliderShape::Capsule { from, to, radius };
        finite.then_some(BoneCollider { joint, given: false, shape, grid: GroupGrid::default() })
    });
    let found: Vec<BoneCollider> = found.collect();
    given.extend(found);
    given.sort_by_key(|bone| bone.joint);
    given
}

/// From where to where a joint's bone goes, scene space at rest; none for a helper that lies on its parent's bone, or
/// where nothing says.
pub(super) fn axis(character: &Character, joint: u32) -> Option<(Vec3, Vec3)> {
    let origin = |j: u32| character.joints[j as usize].bind().w_axis.xyz();
    let from = origin(joint);
    let skin = || {
        (0..character.vertex_count()).filter(|&v| character.influences_of(v).first().is_some_and(|i| i.joint == joint))
    };
    let (sum, count) = skin().fold((Vec3::ZERO, 0), |(sum, n), v| (sum + character.positions_rest[v], n + 1));
    let own_y = character.joints[joint as usize].bind().y_axis.xyz().normalize_or_zero();
    let to_skin = if count > 0 { (sum / count as f32 - from).normalize_or_zero() } else { Vec3::ZERO };
    if let Some(child) = continuing(character, joint, own_y, to_skin) {
        return Some((from, origin(child)));
    }
    if let Some(parent) = character.joints[joint as usize].parent {
        let start = origin(parent);
        let onward = |j: u32| {
            continuing(
                character,
                parent,
                character.joints[j as usize].bind().y_axis.xyz().normalize_or_zero(),
                Vec3::ZERO,
            )
        };
        let end = onward(parent).filter(|&child| child != joint).map(origin);
        if end.is_some_and(|end| on_segment(from, start, end)) {
            return None;
        }
    }
    let along = if own_y.dot(to_skin) > ALONG_Y || count == 0 { own_y } else { to_skin };
    let far = skin().map(|v| (character.positions_rest[v] - from).dot(along)).fold(0.0, f32::max);
    (far > 0.0).then_some((from, from + along * far))
}

/// The child that continues a joint's bone.
fn continuing(character: &Character, joint: u32, own_y: Vec3, to_skin: Vec3) -> Option<u32> {
    let from = character.joints[joint as usize].bind().w_axis.xyz();
    let least = 1e-3 * character.height_rest();
    let children: Vec<(u32, Vec3)> = (0u32..)
        .zip(&character.joints)
        .filter(|(_, child)| child.parent == Some(joint))
        .map(|(c, child)| (c, child.bind().w_axis.xyz() - from))
        .filter(|(_, offset)| offset.length() > least)
        .collect();
    [(own_y, ALONG_Y), (to_skin, ALONG_SKIN)].into_iter().find_map(|(along, enough)| {
        let cosine = |offset: Vec3| offset.normalize_or_zero().dot(along);
        let best = children.iter().map(|&(_, offset)| cosine(offset)).fold(enough, f32::max);
        let aligned =
            children.iter().filter(|(_, offset)| cosine(*offset) > enough && cosine(*offset) > best - SAME_DIRECTION);
        aligned.max_by(|a, b| a.1.length().total_cmp(&b.1.length())).map(|&(child, _)| child)
    })
}

/// Whether a point lies between the ends of a segment, a tenth of its length off it at most.
fn on_segment(p: Vec3, start: Vec3, end: Vec3) -> bool {
    let along = end - start;
    let share = (p - start).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    (0.02..=0.98).contains(&share) && (p - start - along * share).length() < 0.1 * along.length()
}

/// The capsule along an axis: ends and radius, scene space at rest.
fn capsule(skin: &Skin, inside: &impl Fn(Vec3) -> bool, (from, to): (Vec3, Vec3)) -> Option<(Vec3, Vec3, f32)> {
    let place = |i: usize| from.lerp(to, i as f32 / (PLACES - 1) as f32);
    let near = skin.near(from, to);
    let most = from.distance(to);
    let distances: Vec<f32> =
        (0..PLACES).map(|i| if inside(place(i)) { skin.distance(&near, place(i), most) } else { 0.0 }).collect();
    let (mut first, mut last, mut start) = (0, 0, 0);
    for i in 0..=PLACES {
        if distances.get(i).is_none_or(|d| *d <= 0.0) {
            if i - start > last - first {
                (first, last) = (start, i);
            }
            start = i + 1;
        }
    }
    let mut sorted = distances[first..last].to_vec();
    sorted.sort_by(f32::total_cmp);
    let radius = RADIUS_SHARE * sorted.get(sorted.len() / 2)?;
    let clear = |i: &usize| distances[*i] >= CLEARANCE * radius;
    let (first, last) = ((first..last).find(clear)?, (first..last).rev().find(clear)?);
    let nearest = distances[first..=last].iter().fold(f32::INFINITY, |a, &b| a.min(b));
    Some((place(first), place(last), radius.min(nearest / CLEARANCE)))
}

/// The skin's triangles with the spheres around them.
struct Skin {
    triangles: Vec<([Vec3; 3], Vec3, f32)>,
}

impl Skin {
    /// All of it but the parts that are bones themselves.
    fn of(character: &Character, bones: &[BoneSpec]) -> Skin {
        let is_bone = |name: &str| bones.iter().any(|b| matches!(&b.shape, BoneShape::Mesh(mesh) if mesh == name));
        let hidden: Vec<_> = character.parts.iter().filter(|p| is_bone(&p.name)).map(|p| p.triangles.clone()).collect();
        let shown = (0u32..).zip(&character.triangles).filter(|(i, _)| !hidden.iter().any(|range| range.contains(i)));
        let triangles = shown.map(|(_, t)| {
            let corners = t.map(|i| character.positions_rest[i as usize]);
            let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
            (corners, centre, corners.iter().map(|c| c.distance(centre)).fold(0.0, f32::max))
        });
        Skin { triangles: triangles.collect() }
    }

    /// The triangles that can be within a segment's length of it.
    fn near(&self, from: Vec3, to: Vec3) -> Vec<u32> {
        let (middle, reach) = ((from + to) * 0.5, 1.5 * from.distance(to));
        let numbered = (0u32..).zip(&self.triangles);
        numbered.filter(|(_, t)| t.1.distance(middle) - t.2 < reach).map(|(i, _)| i).collect()
    }

    /// Distance from a point to the nearest of some triangles, at most `most`.
    fn distance(&self, near: &[u32], p: Vec3, most: f32) -> f32 {
        near.iter().fold(most, |best, &i| {
            let (corners, centre, radius) = &self.triangles[i as usize];
            if p.distance(*centre) - radius >= best { best } else { best.min(to_triangle(p, corners)) }
        })
    }
}

/// Distance from a point to a triangle: to its plane where the point is over it, else to its nearest edge.
fn to_triangle(p: Vec3, [a, b, c]: &[Vec3; 3]) -> f32 {
    let normal = (*b - *a).cross(*c - *a);
    let over = |from: Vec3, to: Vec3| (to - from).cross(p - from).dot(normal) >= 0.0;
    if over(*a, *b) && over(*b, *c) && over(*c, *a) && normal.length_squared() > 0.0 {
        return (p - *a).dot(normal.normalize_or_zero()).abs();
    }
    let edge = |from: Vec3, to: Vec3| {
        let along = to - from;
        let share = ((p - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        p.distance(from + along * share)
    };
    edge(*a, *b).min(edge(*b, *c)).min(edge(*c, *a))
}
