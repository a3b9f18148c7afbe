//! Builds small glTF files element by element.

use crate::clip::Scene;
use crate::error::GltfError;
use crate::io::gltf::from_bytes;
use serde_json::{Value, json};

pub const U8: u32 = 5121;
pub const I8: u32 = 5120;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A GLB in the making: its JSON, to be changed at will, and its binary chunk.
#[derive(Clone)]
pub struct Glb {
    pub json: Value,
    pub bin: Vec<u8>,
}

pub fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub fn shorts(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

impl Glb {
    /// No nodes, no meshes, one buffer.
    pub fn empty() -> Glb {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
            "buffers": [{"byteLength": 0}], "bufferViews": [], "accessors": []
        });
        Glb { json, bin: Vec::new() }
    }

    /// A square of two triangles in the x-y plane, on node 0, skinned to node 1 at the origin and its child, node 2, at
    /// (0, 1, 0): its two lower vertices follow the first joint, the two upper ones the second.
    pub fn square() -> Glb {
        let mut glb = Glb::empty();
        let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
        let position = glb.accessor(F32, "VEC3", &floats(&corners));
        let index = glb.accessor(U16, "SCALAR", &shorts(&[0, 1, 2, 2, 1, 3]));
        let joints = glb.accessor(U8, "VEC4", &[0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
        let weights = glb.accessor(F32, "VEC4", &floats(&[1.0, 0.0, 0.0, 0.0].repeat(4)));
        let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let mut binds = [identity, identity].concat();
        binds[16 + 13] = -1.0;
        let binds = glb.accessor(F32, "MAT4", &floats(&binds));
        glb.json["scenes"][0]["nodes"] = json!([0, 1]);
        glb.json["nodes"] = json!([
            {"name": "body", "mesh": 0, "skin": 0},
            {"name": "lower", "children": [2]},
            {"name": "upper", "translation": [0, 1, 0]}
        ]);
        glb.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": binds}]);
        glb.json["meshes"] = json!([{"name": "square", "primitives": [{
            "attributes": {"POSITION": position, "JOINTS_0": joints, "WEIGHTS_0": weights}, "indices": index
        }]}]);
        glb
    }

    /// The first primitive's attributes.
    pub fn attributes(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]["attributes"]
    }

    /// Appends a view of these bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()}));
        self.bin.extend(bytes);
        views.len() - 1
    }

    /// Appends an accessor that covers these bytes.
    pub fn accessor(&mut self, component: u32, kind: &str, bytes: &[u8]) -> usize {
        let size = match component {
            U8 | I8 => 1,
            U16 | I16 => 2,
            _ => 4,
        };
        let numbers = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let view = self.view(bytes);
        let count = bytes.len() / (size * numbers);
        let accessor = json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
        self.push("accessors", accessor)
    }

    /// As [`Glb::accessor`], normalised.
    pub fn normalised(&mut self, component: u32, kind: &str, bytes: &[u8]) -> usize {
        let index = self.accessor(component, kind, bytes);
        self.json["accessors"][index]["normalized"] = json!(true);
        index
    }

    /// Appends an element to a top-level array.
    pub fn push(&mut self, collection: &str, element: Value) -> usize {
        if self.json.get(collection).is_none() {
            self.json[collection] = json!([]);
        }
        let elements = self.json[collection].as_array_mut().unwrap();
        elements.push(element);
        elements.len() - 1
    }

    /// Adds an animation of one channel.
    pub fn animate(&mut self, node: usize, path: &str, interpolation: &str, times: &[f32], values: &[f32]) -> usize {
        let input = self.accessor(F32, "SCALAR", &floats(times));
        let output = self.accessor(F32, if path == "rotation" { "VEC4" } else { "VEC3" }, &floats(values));
        self.push(
            "animations",
            json!({
                "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
                "samplers": [{"input": input, "output": output, "interpolation": interpolation}]
            }),
        )
    }

    /// The file.
    pub fn bytes(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"][0].get("uri").is_none() && json["buffers"][0]["byteLength"] == 0 {
            json["buffers"][0]["byteLength"] = json!(self.bin.len());
        }
        let mut text = serde_json::to_vec(&json).unwrap();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((12 + 8 + text.len() as u32 + 8 + bin.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &bin)] {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        bytes
    }

    pub fn read(&self) -> Result<Scene, GltfError> {
        from_bytes(&self.bytes(), "test.glb")
    }

    /// The one line with which the file is refused.
    pub fn refusal(&self) -> String {
        let line = self.read().map(|scene| scene.notes).expect_err("the file must be refused").to_string();
        assert!(!line.contains('\n') && line.starts_with("test.glb: ") && line.contains("; "), "{line}");
        line
    }
}
