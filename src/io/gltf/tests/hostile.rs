//! Files made to hurt: every byte may be wrong.

use super::builder::{F32, Glb, U8, floats};
use crate::clip::ClipChoice;
use crate::error::GltfError;
use crate::io::gltf::from_bytes;
use proptest::prelude::*;
use serde_json::json;

#[test]
fn huge_counts_cost_nothing() {
    for count in [1u64 << 20, 1 << 32, 1 << 40, u64::MAX / 2, u64::MAX] {
        // Backed by a view that is too short.
        let mut glb = Glb::square();
        glb.json["accessors"][0]["count"] = json!(count);
        assert!(glb.read().is_err(), "{count}");
        // Backed by nothing.
        glb.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        assert!(glb.read().is_err(), "{count}");
        // Offsets that wrap round.
        let mut glb = Glb::square();
        glb.json["accessors"][0]["byteOffset"] = json!(u64::MAX - 7);
        assert!(glb.read().is_err());
        let mut glb = Glb::square();
        glb.json["bufferViews"][0]["byteLength"] = json!(count);
        assert!(glb.read().is_err());
        glb.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX - count + 2);
        assert!(glb.read().is_err());
        // A sparse overlay of more elements than its views hold.
        let mut glb = Glb::square();
        let (indices, values) = (glb.view(&[0; 4]), glb.view(&[0; 12]));
        glb.json["accessors"][0]["sparse"] = json!({"count": count,
            "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
        assert!(glb.read().is_err());
    }
}

#[test]
fn the_same_array_a_million_times_is_refused_before_memory_runs_out() {
    let mut glb = Glb::square();
    let zeros = glb.push("accessors", json!({"componentType": F32, "type": "VEC3", "count": 1_000_000}));
    let primitive = json!({"attributes": {"POSITION": zeros}, "indices": 1});
    glb.json["meshes"][0]["primitives"] = json!(vec![primitive; 100]);
    assert!(matches!(glb.read(), Err(GltfError::TooLarge { .. })), "{:?}", glb.read().map(|s| s.notes));
    // Overlapping elements would let a few bytes stand for any count.
    let mut glb = Glb::square();
    glb.json["bufferViews"][0]["byteStride"] = json!(0);
    glb.json["accessors"][0]["count"] = json!(1_000_000_000);
    assert!(glb.read().is_err());
    glb.json["bufferViews"][0]["byteStride"] = json!(4);
    assert!(glb.refusal().contains("numbers where at most") || glb.refusal().contains("stride"), "{}", glb.refusal());
}

#[test]
fn deep_trees_and_deep_json_end() {
    let depth = 200_000;
    let mut glb = Glb::square();
    let first = 3;
    let mut nodes = glb.json["nodes"].as_array().unwrap().clone();
    nodes.extend((0..depth).map(|i| json!({"children": if i + 1 < depth { vec![first + i + 1] } else { vec![] }})));
    nodes[2]["children"] = json!([first]);
    glb.json["nodes"] = json!(nodes);
    glb.json["skins"][0] = json!({"joints": [1, 2, first + depth - 1, first + depth / 2]});
    let joints = glb.read().unwrap().character.joints;
    assert_eq!(joints.iter().map(|j| j.parent).collect::<Vec<_>>(), [None, Some(0), Some(1), Some(2)]);
    let nested = format!("{{\"asset\": {}{}}}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(matches!(from_bytes(nested.as_bytes(), "nested"), Err(GltfError::Json { .. })));
}

#[test]
fn names_cannot_break_lines_or_flood_them() {
    let mut glb = Glb::square();
    let name = format!("a\nb\r\u{2028}\u{1b}[31m{}", "x".repeat(100_000));
    glb.json["meshes"][0]["name"] = json!(name);
    glb.json["nodes"][1]["name"] = json!(name);
    let scene = glb.read().unwrap();
    for text in [&scene.character.parts[0].name, &scene.character.joints[0].name, &scene.nodes[1].name] {
        assert!(text.chars().count() < 200 && !text.contains(|c: char| c.is_control() || c == '\u{2028}'), "{text}");
    }
    glb.attributes()["POSITION"] = json!(1);
    assert!(glb.refusal().len() < 1000);
}

#[test]
fn headers_that_lie_about_lengths() {
    let bytes = Glb::square().bytes();
    for length in [0u32, 1, 11, 12, 19, 20, u32::MAX] {
        for at in [8, 12] {
            let mut bytes = bytes.clone();
            bytes[at..at + 4].copy_from_slice(&length.to_le_bytes());
            assert!(from_bytes(&bytes, "lie.glb").is_err(), "{length} at {at}");
        }
    }
}

/// A file with everything that is read in it.
fn rich() -> Vec<u8> {
    let mut glb = Glb::square();
    let (indices, values) = (glb.view(&[1]), glb.view(&[0; 12]));
    glb.json["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
    glb.animate(1, "rotation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    glb.animate(2, "scale", "CUBICSPLINE", &[0.0, 1.0], &[1.0; 18]);
    glb.json["extensions"] = json!({"SINEW_muscles": {"muscles": [{"name": "biceps"}]}});
    for (parameter, interpolation, kind, values) in
        [("width", "CUBICSPLINE", "SCALAR", &[0.5f32; 6][..]), ("shape", "LINEAR", "VEC2", &[3.0, 3.0, 4.0, 7.0][..])]
    {
        let (input, output) =
            (glb.accessor(F32, "SCALAR", &floats(&[0.0, 1.0])), glb.accessor(F32, kind, &floats(values)));
        let pointer = format!("/extensions/SINEW_muscles/muscles/0/{parameter}");
        let target = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}});
        glb.push(
            "animations",
            json!({"channels": [{"sampler": 0, "target": target}],
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}]}),
        );
    }
    glb.bytes()
}

/// Reads, samples, and checks what every caller relies on.
fn survive(bytes: &[u8]) {
    let scene = match from_bytes(bytes, "fuzz.glb") {
        Ok(scene) => scene,
        Err(e) => {
            let line = e.to_string();
            assert!(!line.contains(['\n', '\r']) && line.starts_with("fuzz.glb: "), "{line}");
            return;
        }
    };
    let character = &scene.character;
    let vertices = character.vertex_count();
    assert_eq!(character.influence_offsets.len(), vertices + 1);
    assert!(character.triangles.iter().flatten().all(|&c| (c as usize) < vertices));
    assert!(character.influences.iter().all(|i| (i.joint as usize) < character.joints.len()));
    for clip in 0..scene.clips.len() {
        let choice = ClipChoice::Clip(clip);
        assert_eq!(scene.pose(choice, scene.duration(choice) * 0.4).palette.len(), character.joints.len());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bytes_never_panic(flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12)) {
        let mut bytes = rich();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        survive(&bytes);
    }

    #[test]
    fn digits_that_change_never_panic(changes in prop::collection::vec((any::<prop::sample::Index>(), 0u8..10), 1..6)) {
        // Digits keep the JSON well-formed, so that these reach past the parser.
        let mut bytes = rich();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let digits: Vec<usize> = (20..20 + length).filter(|&at| bytes[at].is_ascii_digit()).collect();
        for (at, digit) in changes {
            bytes[digits[at.index(digits.len())]] = b'0' + digit;
        }
        survive(&bytes);
    }

    #[test]
    fn cuts_and_insertions_never_panic(
        cut in any::<prop::sample::Index>(), gone in 0usize..40, new in prop::collection::vec(any::<u8>(), 0..40),
    ) {
        let mut bytes = rich();
        let at = cut.index(bytes.len());
        let end = (at + gone).min(bytes.len());
        bytes.splice(at..end, new);
        survive(&bytes);
    }

    #[test]
    fn noise_never_panics(noise in prop::collection::vec(any::<u8>(), 0..200)) {
        survive(&noise);
        survive(&[b"glTF\x02\0\0\0".as_slice(), &noise].concat());
    }
}

#[test]
fn the_rich_file_itself_is_read() {
    let scene = from_bytes(&rich(), "rich.glb").unwrap();
    assert_eq!((scene.clips.len(), scene.character.vertex_count()), (4, 4));
}
