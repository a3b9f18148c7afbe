//! Writes a mesh, its skeleton and its clips as one self-contained GLB file.

use crate::{clips::Clip, mesh::Mesh, skeleton::Skeleton};
use glam::{DMat4, DQuat, DVec3};
use serde_json::{Value, json};

/// Component types and targets as glTF numbers them.
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The binary chunk as it grows, with the views and accessors into it.
///
/// JSON keys are given in alphabetical order throughout: the bytes are the same whether the JSON library sorts or not.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Binary {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteLength": bytes.len(), "byteOffset": self.bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, view: usize, component: u32, kind: &str, count: usize) -> usize {
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, rows: &[[f32; N]], kind: &str, target: Option<u32>) -> usize {
        let bytes: Vec<u8> = rows.iter().flatten().flat_map(|f| f.to_le_bytes()).collect();
        let view = self.view(&bytes, target);
        self.accessor(view, FLOAT, kind, rows.len())
    }

    /// As [`Binary::floats`], with the smallest and largest of every column.
    fn bounded<const N: usize>(&mut self, rows: &[[f32; N]], kind: &str, target: Option<u32>) -> usize {
        let accessor = self.floats(rows, kind, target);
        let column = |start: f32, pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..N).map(|i| rows.iter().map(|r| r[i]).fold(start, pick)).collect()
        };
        let entry = &self.accessors[accessor];
        self.accessors[accessor] = json!({
            "bufferView": entry["bufferView"],
            "componentType": FLOAT,
            "count": rows.len(),
            "max": column(f32::NEG_INFINITY, f32::max),
            "min": column(f32::INFINITY, f32::min),
            "type": kind,
        });
        accessor
    }
}

/// The file's bytes.
pub fn write(mesh: &Mesh, skeleton: &Skeleton, clips: &[Clip], texture: &[u8]) -> Vec<u8> {
    let mut binary = Binary::default();
    let primitive = primitive(&mut binary, mesh);
    let inverse_binds: Vec<[f32; 16]> = skeleton
        .bones()
        .iter()
        .map(|(_, frame)| DMat4::from_rotation_translation(frame.rotation, frame.origin).inverse().as_mat4())
        .map(|m| m.to_cols_array())
        .collect();
    let inverse_binds = binary.floats(&inverse_binds, "MAT4", None);
    let animations: Vec<Value> = clips.iter().map(|clip| animation(&mut binary, clip)).collect();
    let image = binary.view(texture, None);
    binary.bytes.resize(binary.bytes.len().next_multiple_of(4), 0);
    let document = json!({
        "accessors": binary.accessors,
        "animations": animations,
        "asset": { "generator": "make-arm, an example of sinew", "version": "2.0" },
        "bufferViews": binary.views,
        "buffers": [{ "byteLength": binary.bytes.len() }],
        "images": [{ "bufferView": image, "mimeType": "image/png", "name": "skin" }],
        "materials": [{
            "name": "skin",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.96, 0.93, 0.91, 1.0],
                "baseColorTexture": { "index": 0 },
                "metallicFactor": 0.0,
                "roughnessFactor": 0.6,
            },
        }],
        "meshes": [{ "name": "arm", "primitives": [primitive] }],
        "nodes": nodes(skeleton),
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071 }],
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "skins": [{ "inverseBindMatrices": inverse_binds, "joints": [1, 2, 3], "name": "arm", "skeleton": 1 }],
        "textures": [{ "sampler": 0, "source": 0 }],
    });
    container(document.to_string().into_bytes(), binary.bytes)
}

fn primitive(binary: &mut Binary, mesh: &Mesh) -> Value {
    let vertices = Some(ARRAY_BUFFER);
    let count = mesh.positions.len();
    let position = binary.bounded(&mesh.positions, "VEC3", vertices);
    let normal = binary.floats(&mesh.normals, "VEC3", vertices);
    let uv = binary.floats(&mesh.uvs, "VEC2", vertices);
    // A joint without weight must be 0.
    let joints: Vec<u8> = mesh
        .weights
        .iter()
        .flat_map(|weights| [0, 1, 2, 3].map(|j| if weights[j] > 0.0 { j as u8 } else { 0 }))
        .collect();
    let joints = binary.view(&joints, vertices);
    let joints = binary.accessor(joints, UNSIGNED_BYTE, "VEC4", count);
    let weights = binary.floats(&mesh.weights, "VEC4", vertices);
    let indices: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|&i| (i as u16).to_le_bytes()).collect();
    let indices = binary.view(&indices, Some(ELEMENT_ARRAY_BUFFER));
    let indices = binary.accessor(indices, UNSIGNED_SHORT, "SCALAR", mesh.triangles.len() * 3);
    json!({
        "attributes": { "JOINTS_0": joints, "NORMAL": normal, "POSITION": position, "TEXCOORD_0": uv, "WEIGHTS_0": weights },
        "indices": indices,
        "material": 0,
    })
}

fn quaternion(rotation: DQuat) -> [f32; 4] {
    rotation.as_quat().normalize().to_array()
}

/// The skinned mesh, then the bones in the order of the skin's joints.
fn nodes(skeleton: &Skeleton) -> Vec<Value> {
    let bones = skeleton.bones();
    let mut nodes = vec![json!({ "mesh": 0, "name": "arm", "skin": 0 })];
    for (i, (name, frame)) in bones.iter().enumerate() {
        let (rotation, translation) = match i.checked_sub(1).map(|parent| bones[parent].1) {
            Some(parent) => (parent.rotation.inverse() * frame.rotation, parent.local(frame.origin)),
            None => (frame.rotation, frame.origin),
        };
        let clean = |v: DVec3| (v * 1e9).round() / 1e9 + DVec3::ZERO;
        let (rotation, translation) = (quaternion(rotation), clean(translation).as_vec3().to_array());
        nodes.push(if i + 1 < bones.len() {
            json!({ "children": [i + 2], "name": name, "rotation": rotation, "translation": translation })
        } else {
            json!({ "name": name, "rotation": rotation, "translation": translation })
        });
    }
    nodes
}

fn animation(binary: &mut Binary, clip: &Clip) -> Value {
    let times: Vec<[f32; 1]> = clip.times.iter().map(|&t| [t as f32]).collect();
    let input = binary.bounded(&times, "SCALAR", None);
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for track in &clip.tracks {
        let rotations: Vec<[f32; 4]> = track.rotations.iter().map(|&r| quaternion(r)).collect();
        let output = binary.floats(&rotations, "VEC4", None);
        channels.push(json!({
            "sampler": samplers.len(),
            "target": { "node": track.bone + 1, "path": "rotation" },
        }));
        samplers.push(json!({ "input": input, "interpolation": "LINEAR", "output": output }));
    }
    json!({ "channels": channels, "name": clip.name, "samplers": samplers })
}

/// Header, JSON chunk padded with spaces, binary chunk padded with zeros.
fn container(mut json: Vec<u8>, binary: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = Vec::with_capacity(28 + json.len() + binary.len());
    file.extend_from_slice(b"glTF");
    for number in [2, (28 + json.len() + binary.len()) as u32] {
        file.extend_from_slice(&number.to_le_bytes());
    }
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &binary)] {
        file.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
        file.extend_from_slice(kind);
        file.extend_from_slice(chunk);
    }
    file
}
