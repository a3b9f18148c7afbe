//! From JSON text to the `gltf` crate's typed tree, past everything that the crate would refuse without need.

use super::muscle_keys::{self, Lifted};
use super::shape::ROOT;
use super::{Context, label};
use crate::error::{GltfError, one_line};
use gltf::json::{
    self, Accessor, Animation, Asset, Buffer, Image, Material, Mesh, Node, Root, Scene, Skin, Texture, buffer::View,
};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// Extensions that may be required and yet do not change geometry, skinning or node animation, or that are read.
const HARMLESS: &[&str] = &[
    "KHR_mesh_quantization",
    "KHR_animation_pointer",
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_xmp",
    "EXT_lights_",
    "EXT_texture_",
    "MSFT_texture_",
    "MSFT_lod",
    "FB_ngon_encoding",
    "VRM",
    muscle_keys::EXTENSION,
];

/// Members that hold decimal numbers.
const DECIMALS: &[&str] = &["matrix", "translation", "rotation", "scale", "baseColorFactor"];
/// Largest decimal up to which every whole number has a value of its own.
const EXACT: f64 = 9_007_199_254_740_992.0;
/// Members that hold sizes in bytes or elements, which may pass 32 bits.
const SIZES: &[&str] = &["byteLength", "byteOffset", "byteStride", "count"];

/// Parses the JSON text of a file; the channels that key muscles come apart from it.
pub(super) fn root(text: &[u8], cx: &Context) -> Result<(Root, Vec<Lifted>), GltfError> {
    let mut value: Value = serde_json::from_slice(text).map_err(|e| json_error(cx, "JSON", &e))?;
    check_version(&value, cx)?;
    check_extensions(&value, cx)?;
    note_morph_targets(&value, cx);
    let muscle_keys = muscle_keys::lift(&mut value, cx)?;
    ROOT.prune(&mut value);
    lift_channels(&mut value, cx);
    for scene in elements(&mut value, "scenes") {
        scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
    normalise_numbers(&mut value, "");
    let root = Root::deserialize(&value).map_err(|e| locate(&value, &e, cx))?;
    Ok((root, muscle_keys))
}

fn json_error(cx: &Context, element: impl Into<String>, error: &serde_json::Error) -> GltfError {
    GltfError::Json { file: cx.file(), element: element.into(), what: one_line(&error.to_string()) }
}

fn check_version(value: &Value, cx: &Context) -> Result<(), GltfError> {
    let text = |key: &str| value.get("asset").and_then(|a| a.get(key)).and_then(Value::as_str);
    let parse = |version: &str| -> Option<(u32, u32)> {
        let (major, minor) = version.split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    let Some(version) = text("version") else {
        let what = "the version of glTF is missing".into();
        return Err(GltfError::Json { file: cx.file(), element: "asset".into(), what });
    };
    let readable = match text("minVersion") {
        Some(least) => parse(least).is_some_and(|least| (2, 0) >= least) || parse(least).is_none(),
        None => true,
    };
    match parse(version) {
        Some((2, _)) if readable => Ok(()),
        Some((2, _)) => {
            Err(GltfError::Version { file: cx.file(), version: one_line(text("minVersion").unwrap_or_default()) })
        }
        _ => Err(GltfError::Version { file: cx.file(), version: one_line(version) }),
    }
}

fn check_extensions(value: &Value, cx: &Context) -> Result<(), GltfError> {
    let Some(required) = value.get("extensionsRequired").and_then(Value::as_array) else { return Ok(()) };
    for name in required.iter().filter_map(Value::as_str) {
        if !HARMLESS.iter().any(|prefix| name.starts_with(prefix)) {
            return Err(GltfError::Extension { file: cx.file(), extension: one_line(name) });
        }
    }
    Ok(())
}

fn note_morph_targets(value: &Value, cx: &Context) {
    let meshes = value.get("meshes").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    for (index, mesh) in meshes.iter().enumerate() {
        let primitives = mesh.get("primitives").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
        if primitives.iter().any(|p| p.get("targets").is_some()) {
            let name = mesh.get("name").and_then(Value::as_str);
            cx.note(format!("{}: its morph targets are not read", label("mesh", index, name)));
        }
    }
}

/// The objects of a top-level array.
fn elements<'a>(value: &'a mut Value, collection: &str) -> impl Iterator<Item = &'a mut Map<String, Value>> {
    value.get_mut(collection).and_then(Value::as_array_mut).into_iter().flatten().filter_map(Value::as_object_mut)
}

/// Takes out the channels that do not move a node: pointers into the JSON (`KHR_animation_pointer`), morph weights,
/// unknown paths, and channels without a node, which glTF says to ignore.
fn lift_channels(value: &mut Value, cx: &Context) {
    for (index, animation) in elements(value, "animations").enumerate() {
        let name = animation.get("name").and_then(Value::as_str).map(str::to_owned);
        for member in ["channels", "samplers"] {
            animation.entry(member).or_insert_with(|| Value::Array(Vec::new()));
        }
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else { continue };
        let before = channels.len();
        channels.retain(|channel| {
            let target = channel.get("target");
            let path = target.and_then(|t| t.get("path")).and_then(Value::as_str);
            let moves_a_node = matches!(path, Some("translation" | "rotation" | "scale"));
            moves_a_node && target.is_some_and(|t| t.get("node").is_some())
        });
        match before - channels.len() {
            0 => {}
            n => cx.note(format!(
                "{}: {n} of its {before} channels do not move a node and are not read",
                label("animation", index, name.as_deref())
            )),
        }
    }
}

/// Whole numbers written as decimals become integers, and integers that are indices are kept from wrapping round when
/// the crate cuts them to 32 bits.
fn normalise_numbers(value: &mut Value, key: &str) {
    match value {
        Value::Object(object) => object.iter_mut().for_each(|(key, value)| normalise_numbers(value, key)),
        Value::Array(items) => items.iter_mut().for_each(|item| normalise_numbers(item, key)),
        Value::Number(number) if !DECIMALS.contains(&key) => {
            let whole = number.as_f64().filter(|d| number.is_f64() && d.fract() == 0.0 && (0.0..=EXACT).contains(d));
            if let Some(whole) = whole {
                *value = Value::from(whole as u64);
            }
            if !SIZES.contains(&key) && value.as_u64().is_some_and(|n| n > u64::from(u32::MAX)) {
                *value = Value::from(u32::MAX);
            }
        }
        _ => {}
    }
}

/// Finds the element that the crate's parser, which gives no path, complained about.
fn locate(value: &Value, error: &serde_json::Error, cx: &Context) -> GltfError {
    type Parse = fn(&Value) -> Option<json::Error>;
    fn parse<T: DeserializeOwned>(value: &Value) -> Option<json::Error> {
        T::deserialize(value).err()
    }
    let collections: [(&str, Parse); 12] = [
        ("accessors", parse::<Accessor>),
        ("animations", parse::<Animation>),
        ("buffers", parse::<Buffer>),
        ("bufferViews", parse::<View>),
        ("images", parse::<Image>),
        ("materials", parse::<Material>),
        ("meshes", parse::<Mesh>),
        ("nodes", parse::<Node>),
        ("scenes", parse::<Scene>),
        ("skins", parse::<Skin>),
        ("textures", parse::<Texture>),
        ("asset", parse::<Asset>),
    ];
    for (name, parse) in collections {
        match value.get(name) {
            Some(Value::Array(items)) => {
                for (index, item) in items.iter().enumerate() {
                    if let Some(error) = parse(item) {
                        return json_error(cx, format!("{name}[{index}]"), &error);
                    }
                }
            }
            Some(other) if name != "asset" => {
                let what = format!("an array is needed and `{}` was found", one_line(&other.to_string()));
                return GltfError::Json { file: cx.file(), element: name.into(), what };
            }
            Some(asset) => {
                if let Some(error) = parse(asset) {
                    return json_error(cx, name, &error);
                }
            }
            None => {}
        }
    }
    let element = if value.get("scene").is_some_and(|scene| !scene.is_u64()) { "scene" } else { "JSON" };
    json_error(cx, element, error)
}
