//! The part of the glTF schema that is read. The rest is dropped before it is parsed, so that an odd camera, a
//! vendor's extension or an unknown attribute cannot make a character unreadable.

use serde_json::Value;

/// What is kept of an object, or of every object of an array.
pub(super) enum Shape {
    /// As it is.
    All,
    /// These members.
    Members(&'static [(&'static str, Shape)]),
    /// The members that a test picks by name.
    Named(fn(&str) -> bool),
}

use Shape::{All, Members, Named};

impl Shape {
    /// Drops what the shape does not name.
    pub(super) fn prune(&self, value: &mut Value) {
        match (self, value) {
            (All, _) => {}
            (_, Value::Array(items)) => items.iter_mut().for_each(|item| self.prune(item)),
            (Members(members), Value::Object(object)) => {
                object.retain(|key, value| match members.iter().find(|(name, _)| name == key) {
                    Some((_, shape)) => {
                        shape.prune(value);
                        true
                    }
                    None => false,
                });
            }
            (Named(keep), Value::Object(object)) => object.retain(|key, _| keep(key)),
            _ => {}
        }
    }
}

/// Vertex attributes that are read.
fn attribute(name: &str) -> bool {
    let numbered = |prefix: &str| {
        let digits = name.strip_prefix(prefix).unwrap_or_default();
        digits.parse::<u32>().is_ok_and(|n| n.to_string() == digits)
    };
    matches!(name, "POSITION" | "NORMAL" | "TEXCOORD_0")
        || numbered("JOINTS_")
        || numbered("WEIGHTS_")
        || numbered(super::painted::PREFIX)
}

/// The whole file.
pub(super) static ROOT: Shape = Members(&[
    ("asset", Members(&[("version", All), ("minVersion", All)])),
    ("scene", All),
    ("scenes", Members(&[("name", All), ("nodes", All)])),
    (
        "nodes",
        Members(&[
            ("name", All),
            ("children", All),
            ("matrix", All),
            ("translation", All),
            ("rotation", All),
            ("scale", All),
            ("mesh", All),
            ("skin", All),
        ]),
    ),
    (
        "meshes",
        Members(&[
            ("name", All),
            (
                "primitives",
                Members(&[("attributes", Named(attribute)), ("indices", All), ("material", All), ("mode", All)]),
            ),
        ]),
    ),
    ("skins", Members(&[("name", All), ("joints", All), ("inverseBindMatrices", All)])),
    (
        "accessors",
        Members(&[
            ("name", All),
            ("bufferView", All),
            ("byteOffset", All),
            ("componentType", All),
            ("normalized", All),
            ("count", All),
            ("type", All),
            (
                "sparse",
                Members(&[
                    ("count", All),
                    ("indices", Members(&[("bufferView", All), ("byteOffset", All), ("componentType", All)])),
                    ("values", Members(&[("bufferView", All), ("byteOffset", All)])),
                ]),
            ),
        ]),
    ),
    (
        "bufferViews",
        Members(&[("name", All), ("buffer", All), ("byteOffset", All), ("byteLength", All), ("byteStride", All)]),
    ),
    ("buffers", Members(&[("name", All), ("uri", All), ("byteLength", All)])),
    (
        "materials",
        Members(&[
            ("name", All),
            ("doubleSided", All),
            (
                "pbrMetallicRoughness",
                Members(&[
                    ("baseColorFactor", All),
                    ("baseColorTexture", Members(&[("index", All), ("texCoord", All)])),
                ]),
            ),
        ]),
    ),
    ("textures", Members(&[("name", All), ("source", All)])),
    ("images", Members(&[("name", All), ("uri", All), ("bufferView", All), ("mimeType", All)])),
    (
        "animations",
        Members(&[
            ("name", All),
            ("channels", Members(&[("sampler", All), ("target", Members(&[("node", All), ("path", All)]))])),
            ("samplers", Members(&[("input", All), ("output", All), ("interpolation", All)])),
        ]),
    ),
]);
