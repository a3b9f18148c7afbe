//! The skins of a file merged into one skeleton.

use super::accessor::Source;
use super::label;
use crate::clip::Node;
use crate::error::GltfError;
use crate::rig::Joint;
use glam::{DMat4, Mat4, Vec4};
use gltf::json::accessor::Type;
use std::collections::HashMap;

/// How far the last row of an inverse bind matrix may be from 0 0 0 1. Exporters leave rounding there; more is not an
/// affine transform.
const LAST_ROW: f32 = 1e-4;
/// Least volume that an inverse bind matrix may leave of a cube, relative to the lengths of its axes: below it, the
/// inverse has no correct digit in f32.
const LEAST_VOLUME: f64 = 1e-6;

/// The joints of all skins, and how the skins count them.
pub(super) struct Skeleton {
    /// Joints, parents first.
    pub joints: Vec<Joint>,
    /// Per skin (empty for those not asked for): what its joints are here.
    pub skins: Vec<Vec<SkinJoint>>,
}

/// One joint of one skin.
pub(super) struct SkinJoint {
    /// Index into [`Skeleton::joints`].
    pub joint: u32,
    /// Why its inverse bind matrix cannot be used; then no vertex may use the joint.
    pub broken: Option<&'static str>,
}

/// A joint before it has its place in the order.
struct Draft {
    node: u32,
    skin: usize,
    inverse_bind: Mat4,
}

/// Merges the given skins: a node with one inverse bind matrix is one joint, however many skins list it.
pub(super) fn merge(
    source: &Source,
    skins: &[usize],
    nodes: &[Node],
    order: &[u32],
    globals: &[DMat4],
) -> Result<Skeleton, GltfError> {
    let mut drafts: Vec<Draft> = Vec::new();
    let mut known: HashMap<(u32, [u32; 16]), u32> = HashMap::new();
    let mut locals: Vec<Vec<SkinJoint>> = source.root.skins.iter().map(|_| Vec::new()).collect();
    for &skin in skins {
        let matrices = inverse_binds(source, skin)?;
        let element = label("skin", skin, source.root.skins[skin].name.as_deref());
        for (at, index) in source.root.skins[skin].joints.iter().enumerate() {
            let node = index.value();
            if node >= nodes.len() {
                return Err(source.cx.dangling(element, "joint node", node, nodes.len()));
            }
            let stored = matrices.as_ref().map_or(Mat4::IDENTITY, |m| m[at]);
            let (inverse_bind, broken) = match usable(stored) {
                Ok(matrix) => (matrix, None),
                Err(why) => (stand_in(globals[node]), Some(why)),
            };
            if let Some(why) = broken {
                let joint = label("joint", at, Some(&nodes[node].name));
                source.cx.note(format!("{element}, {joint}: its inverse bind matrix {why}; no vertex uses it"));
            }
            let key = (node as u32, inverse_bind.to_cols_array().map(f32::to_bits));
            let joint = *known.entry(key).or_insert(drafts.len() as u32);
            if joint as usize == drafts.len() {
                drafts.push(Draft { node: node as u32, skin, inverse_bind });
            }
            locals[skin].push(SkinJoint { joint, broken });
        }
    }
    let parents = parents(&drafts, nodes, order);
    let (joints, place) = place(&drafts, &parents, nodes);
    locals.iter_mut().flatten().for_each(|local| local.joint = place[local.joint as usize]);
    Ok(Skeleton { joints, skins: locals })
}

/// The matrices of a skin; none where the file leaves them out, which means identity.
fn inverse_binds(source: &Source, skin: usize) -> Result<Option<Vec<Mat4>>, GltfError> {
    let json = &source.root.skins[skin];
    let element = label("skin", skin, json.name.as_deref());
    if json.joints.is_empty() {
        return Err(source.cx.malformed(element, "it has no joints", "bind the mesh to an armature with bones"));
    }
    let Some(index) = json.inverse_bind_matrices else { return Ok(None) };
    let flat = source.decimals(index, &[Type::Mat4], &format!("{element}, inverse bind matrices"))?;
    let matrices: Vec<Mat4> = flat.chunks_exact(16).map(Mat4::from_cols_slice).collect();
    if matrices.len() < json.joints.len() {
        let what = format!("it has {} joints and {} inverse bind matrices", json.joints.len(), matrices.len());
        return Err(source.cx.malformed(element, what, "export the file again"));
    }
    Ok(Some(matrices))
}

/// The matrix with an exact last row, or why it is not a transform that can be turned round.
fn usable(stored: Mat4) -> Result<Mat4, &'static str> {
    if !stored.is_finite() {
        return Err("is not finite");
    }
    if (stored.row(3) - Vec4::W).abs().max_element() > LAST_ROW {
        return Err("does not end in the row 0 0 0 1");
    }
    let mut matrix = stored;
    (matrix.x_axis.w, matrix.y_axis.w, matrix.z_axis.w, matrix.w_axis.w) = (0.0, 0.0, 0.0, 1.0);
    let wide = matrix.as_dmat4();
    let lengths = wide.x_axis.length() * wide.y_axis.length() * wide.z_axis.length();
    let flat = wide.determinant().abs() <= LEAST_VOLUME * lengths;
    if flat || !wide.inverse().as_mat4().is_finite() {
        return Err("flattens space and cannot be inverted");
    }
    Ok(matrix)
}

/// For a joint that moves nothing: as if it were bound where the file shows it.
fn stand_in(global: DMat4) -> Mat4 {
    usable(global.inverse().as_mat4()).unwrap_or(Mat4::IDENTITY)
}

/// Per draft the draft of its nearest ancestor node that is a joint, of the same skin where that has one there.
fn parents(drafts: &[Draft], nodes: &[Node], order: &[u32]) -> Vec<Option<u32>> {
    let mut first: HashMap<u32, u32> = HashMap::new();
    let mut of_skin: HashMap<(u32, usize), u32> = HashMap::new();
    for (index, draft) in (0u32..).zip(drafts) {
        first.entry(draft.node).or_insert(index);
        of_skin.entry((draft.node, draft.skin)).or_insert(index);
    }
    let mut nearest: Vec<Option<u32>> = vec![None; nodes.len()];
    for &node in order {
        if let Some(parent) = nodes[node as usize].parent {
            nearest[node as usize] = if first.contains_key(&parent) { Some(parent) } else { nearest[parent as usize] };
        }
    }
    let parent = |draft: &Draft| {
        let ancestor = nearest[draft.node as usize]?;
        of_skin.get(&(ancestor, draft.skin)).or_else(|| first.get(&ancestor)).copied()
    };
    drafts.iter().map(parent).collect()
}

/// The joints in the order of the drafts, except that a parent comes before its first child; and per draft its place.
fn place(drafts: &[Draft], parents: &[Option<u32>], nodes: &[Node]) -> (Vec<Joint>, Vec<u32>) {
    let mut place: Vec<Option<u32>> = vec![None; drafts.len()];
    let mut joints: Vec<Joint> = Vec::with_capacity(drafts.len());
    for start in 0..drafts.len() as u32 {
        let mut chain = Vec::new();
        let mut at = Some(start);
        while let Some(draft) = at.filter(|&d| place[d as usize].is_none()) {
            chain.push(draft);
            at = parents[draft as usize];
        }
        for draft in chain.into_iter().rev() {
            let index = joints.len() as u32;
            place[draft as usize] = Some(index);
            let Draft { node, inverse_bind, .. } = drafts[draft as usize];
            let name = &nodes[node as usize].name;
            joints.push(Joint {
                name: if name.is_empty() { format!("joint_{index}") } else { name.clone() },
                parent: parents[draft as usize].and_then(|p| place[p as usize]),
                node,
                inverse_bind,
            });
        }
    }
    (joints, place.into_iter().flatten().collect())
}
