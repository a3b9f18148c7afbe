//! Writes weights of muscles into a GLB, as attributes `_MUSCLE_n` of its skinned primitives, for an artist to paint on.

use super::{Context, container, painted::PREFIX};
use crate::error::{GltfError, one_line};
use crate::rig::{Character, PaintedMuscle, Part};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Component type of a float, and the target of a buffer of vertices.
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
/// Primitive modes that show triangles; one that names none does.
const TRIANGLES: std::ops::RangeInclusive<u64> = 4..=6;

/// The GLB at `path` with `weights`, one run of them per part of its character and muscle, in place of any that it has; all else
/// is as it was. `character` is what [`read`](super::read) makes of the file.
///
/// # Errors
/// The file cannot be read, is no GLB, has a mesh on two skinned nodes, or is not the one that `character` is from.
pub fn with_muscle_weights(
    path: &Path,
    character: &Character,
    weights: &[PaintedMuscle],
) -> Result<Vec<u8>, GltfError> {
    let cx = Context::new(one_line(&path.display().to_string()));
    let bytes = super::plain_file(path).and_then(|()| std::fs::read(path));
    let bytes = bytes.map_err(|e| GltfError::Unreadable { file: cx.file(), reason: one_line(&e.to_string()) })?;
    let container = container::split(&bytes, &cx)?;
    let Some(bin) = container.bin else {
        let what = "weights are written into a .glb, and this is JSON text".to_owned();
        return Err(GltfError::NotGltf { file: cx.file(), what });
    };
    let mut root: Value = serde_json::from_slice(container.json).map_err(|e| GltfError::Json {
        file: cx.file(),
        element: "JSON".into(),
        what: one_line(&e.to_string()),
    })?;
    let mut bin = bin.to_vec();
    let places = places(&root, character, &cx)?;
    for &(mesh, primitive) in &places {
        if let Some(attributes) = attributes(&mut root, mesh, primitive) {
            attributes.retain(|name, _| !name.starts_with(PREFIX));
        }
    }
    for painted in weights {
        let of_part = |part: &&Part| part.vertices == painted.vertices;
        let Some(part) = character.parts.iter().position(|part| of_part(&part)) else { continue };
        let accessor = append(&mut root, &mut bin, &painted.weights);
        let (mesh, primitive) = places[part];
        if let Some(attributes) = attributes(&mut root, mesh, primitive) {
            attributes.insert(format!("{PREFIX}{}", painted.muscle), accessor.into());
        }
    }
    bin.resize(bin.len().next_multiple_of(4), 0);
    root["buffers"][0]["byteLength"] = bin.len().into();
    Ok(container::join(root.to_string().as_bytes(), &bin))
}

/// Mesh and primitive of every part: a node's parts are its mesh's primitives that show triangles, in order.
fn places(root: &Value, character: &Character, cx: &Context) -> Result<Vec<(usize, usize)>, GltfError> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    let mut before = (u32::MAX, 0);
    for part in &character.parts {
        let other = || cx.malformed(&part.name, "the file has changed since it was read", "read it again");
        let mesh = root["nodes"][part.node as usize]["mesh"].as_u64().ok_or_else(other)? as usize;
        let first = if before.0 == part.node { before.1 } else { 0 };
        let primitives = root["meshes"][mesh]["primitives"].as_array().ok_or_else(other)?;
        let shown = |primitive: &Value| {
            let count = |index: &Value| index.as_u64().map(|i| root["accessors"][i as usize]["count"].as_u64());
            TRIANGLES.contains(&primitive["mode"].as_u64().unwrap_or(4))
                && count(&primitive["attributes"]["POSITION"]) == Some(Some(part.vertices.len() as u64))
        };
        let primitive = (first..primitives.len()).find(|&i| shown(&primitives[i])).ok_or_else(other)?;
        if found.contains(&(mesh, primitive)) {
            let what = "two nodes show this mesh, so that one set of weights would stand for both";
            return Err(cx.malformed(&part.name, what, "give each node a mesh of its own"));
        }
        found.push((mesh, primitive));
        before = (part.node, primitive + 1);
    }
    Ok(found)
}

fn attributes(root: &mut Value, mesh: usize, primitive: usize) -> Option<&mut Map<String, Value>> {
    root["meshes"][mesh]["primitives"][primitive]["attributes"].as_object_mut()
}

/// Adds floats to the file, and gives the number of their accessor.
fn append(root: &mut Value, bin: &mut Vec<u8>, values: &[f32]) -> usize {
    bin.resize(bin.len().next_multiple_of(4), 0);
    let view = json!({
        "buffer": 0, "byteOffset": bin.len(), "byteLength": 4 * values.len(), "target": ARRAY_BUFFER
    });
    bin.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    let view = push(root, "bufferViews", view);
    push(
        root,
        "accessors",
        json!({ "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": "SCALAR" }),
    )
}

/// Adds an element to one of the file's lists, and gives its number.
fn push(root: &mut Value, list: &str, element: Value) -> usize {
    match root[list].as_array_mut() {
        Some(elements) => {
            elements.push(element);
            elements.len() - 1
        }
        None => {
            root[list] = json!([element]);
            0
        }
    }
}
