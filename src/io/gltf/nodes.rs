//! The node tree: transforms, one parent each, no cycles, and which nodes the scene shows.

use super::{Context, label};
use crate::clip::{Local, Node};
use crate::error::GltfError;
use glam::{Mat4, Quat, Vec3};
use gltf::json::{self, Root};

/// The nodes of a file as a forest.
pub(super) struct Graph {
    /// All nodes, in file order.
    pub nodes: Vec<Node>,
    /// Node indices, parents before children.
    pub order: Vec<u32>,
    /// Per node: whether the default scene shows it.
    pub in_scene: Vec<bool>,
}

impl Graph {
    /// Reads the nodes and checks that they form a forest.
    pub(super) fn build(root: &Root, cx: &Context) -> Result<Graph, GltfError> {
        let mut nodes = Vec::with_capacity(root.nodes.len());
        for (index, node) in root.nodes.iter().enumerate() {
            let name = crate::error::one_line(node.name.as_deref().unwrap_or_default());
            nodes.push(Node { name, parent: None, local: local(index, node, cx)? });
        }
        for (index, node) in root.nodes.iter().enumerate() {
            for child in node.children.iter().flatten() {
                let element = || label("node", index, node.name.as_deref());
                let Some(child_node) = nodes.get_mut(child.value()) else {
                    return Err(cx.dangling(element(), "child node", child.value(), root.nodes.len()));
                };
                if let Some(other) = child_node.parent.replace(index as u32) {
                    let what = format!("node {} is its child, and a child of node {other} already", child.value());
                    return Err(cx.malformed(element(), what, "give every node one parent"));
                }
            }
        }
        let order = parents_first(root, &nodes, cx)?;
        let in_scene = shown(root, &nodes, &order, cx)?;
        Ok(Graph { nodes, order, in_scene })
    }
}

fn local(index: usize, node: &json::Node, cx: &Context) -> Result<Local, GltfError> {
    let element = || label("node", index, node.name.as_deref());
    if let Some(matrix) = &node.matrix {
        let matrix = Mat4::from_cols_array(matrix);
        return match matrix.is_finite() {
            true => Ok(Local::Matrix(matrix)),
            false => Err(cx.non_finite(element(), "its matrix")),
        };
    }
    let translation = Vec3::from(node.translation.unwrap_or_default());
    let scale = Vec3::from(node.scale.unwrap_or([1.0; 3]));
    let rotation = Quat::from_array(node.rotation.unwrap_or_default().0);
    if !(translation.is_finite() && scale.is_finite() && rotation.is_finite()) {
        return Err(cx.non_finite(element(), "its transform"));
    }
    let rotation = unit(rotation).unwrap_or_else(|| {
        cx.note(format!("{}: its rotation is the zero quaternion and is taken as none", element()));
        Quat::IDENTITY
    });
    Ok(Local::Parts { translation, rotation, scale })
}

/// A quaternion of length 1, or nothing where it has no direction.
pub(super) fn unit(rotation: Quat) -> Option<Quat> {
    let rotation = rotation.as_dquat();
    let length = rotation.length();
    (length.is_finite() && length > 1e-6).then(|| (rotation / length).as_quat())
}

fn parents_first(root: &Root, nodes: &[Node], cx: &Context) -> Result<Vec<u32>, GltfError> {
    let mut order: Vec<u32> = (0..nodes.len() as u32).filter(|&n| nodes[n as usize].parent.is_none()).collect();
    let mut next = 0;
    while let Some(&node) = order.get(next) {
        next += 1;
        order.extend(root.nodes[node as usize].children.iter().flatten().map(|c| c.value() as u32));
    }
    if order.len() == nodes.len() {
        return Ok(order);
    }
    let mut reached = vec![false; nodes.len()];
    order.iter().for_each(|&n| reached[n as usize] = true);
    let cut_off = reached.iter().position(|r| !r).unwrap_or_default();
    let element = label("node", cut_off, Some(&nodes[cut_off].name));
    Err(cx.malformed(element, "its parents form a loop", "let no node be its own ancestor"))
}

/// Which nodes the default scene shows: without one the first, without any scene all nodes.
fn shown(root: &Root, nodes: &[Node], order: &[u32], cx: &Context) -> Result<Vec<bool>, GltfError> {
    let index = root.scene.map_or(0, |s| s.value());
    let Some(scene) = root.scenes.get(index) else {
        return match root.scene {
            None => Ok(vec![true; nodes.len()]),
            Some(_) => Err(cx.dangling("scene", "scene", index, root.scenes.len())),
        };
    };
    let mut shown = vec![false; nodes.len()];
    for node in &scene.nodes {
        let Some(shown) = shown.get_mut(node.value()) else {
            let element = label("scene", index, scene.name.as_deref());
            return Err(cx.dangling(element, "node", node.value(), nodes.len()));
        };
        *shown = true;
    }
    for &node in order {
        if nodes[node as usize].parent.is_some_and(|p| shown[p as usize]) {
            shown[node as usize] = true;
        }
    }
    Ok(shown)
}
