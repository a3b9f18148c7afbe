//! Bad input: one line that names file, element and remedy, exit 3, and nothing left behind.

use super::{asset, names, refusal, sinew};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// The built-in arm taken apart: its JSON and its binary chunk.
pub fn arm() -> (Value, Vec<u8>) {
    let glb = fs::read(asset("arm.glb")).expect("the arm");
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().expect("four bytes")) as usize;
    let end = 20 + word(12);
    (serde_json::from_slice(&glb[20..end]).expect("JSON"), glb[end + 8..].to_vec())
}

/// Writes a `.gltf` with its buffer beside it.
pub fn write(folder: &Path, mut json: Value, bin: &[u8]) -> PathBuf {
    json["buffers"][0]["uri"] = json!("arm.bin");
    json["buffers"][0]["byteLength"] = json!(bin.len());
    let path = folder.join("arm.gltf");
    fs::write(&path, json.to_string()).expect("written");
    fs::write(folder.join("arm.bin"), bin).expect("written");
    path
}

/// Byte offset of the first value of a vertex attribute.
fn attribute_offset(json: &Value, name: &str) -> usize {
    let accessor = &json["accessors"][number(&json["meshes"][0]["primitives"][0]["attributes"][name])];
    let view = &json["bufferViews"][number(&accessor["bufferView"])];
    number(&accessor["byteOffset"]) + number(&view["byteOffset"])
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap_or(0) as usize
}

/// Bakes and renders a file that is to be refused; checks the line's words and that nothing is left.
#[track_caller]
fn refused(input: &Path, extra: &[&str], words: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    let verbs: [&[&str]; 2] = [&["bake", "--device", "cpu", "--skinning", "linear"], &["bake", "--device", "cpu"]];
    for verb in verbs {
        let out = folder.path().join("out.pc2");
        let output = sinew().args(verb).arg(input).args(extra).arg("-o").arg(&out).output().expect("runs");
        let line = refusal(&output, 3);
        for word in words {
            assert!(line.contains(word), "`{word}` is not in: {line}");
        }
        assert!(names(folder.path()).is_empty(), "left: {:?}", names(folder.path()));
    }
}

#[test]
fn the_arm_taken_apart_is_still_good() {
    let folder = tempfile::tempdir().expect("a folder");
    let (json, bin) = arm();
    let input = write(folder.path(), json, &bin);
    let out = folder.path().join("out.pc2");
    let mut bake = sinew();
    bake.args(["bake", "--device", "cpu", "--skinning", "linear", "--frames", "0"]).arg(&input).arg("-o").arg(&out);
    super::printed(&bake.output().expect("runs"));
    assert!(out.is_file());
    let found: Value = serde_json::from_slice(&bake.arg("--json").output().expect("runs").stdout).expect("JSON");
    assert_eq!((&found["frames"], &found["notes"]), (&json!(1), &json!([])));
}

#[test]
fn damaged_files_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let glb = fs::read(asset("arm.glb")).expect("the arm");
    let cut = folder.path().join("cut.glb");
    for keep in [0, 3, 11, 19, 400, glb.len() / 2, glb.len() - 5] {
        fs::write(&cut, &glb[..keep]).expect("written");
        refused(&cut, &[], &["cut.glb"]);
    }
    let text = folder.path().join("text.gltf");
    fs::write(&text, "{\"asset\": {\"version\": \"2.0\"}, \"meshes\": [").expect("written");
    refused(&text, &[], &["text.gltf", "JSON"]);
    refused(&folder.path().join("nowhere.glb"), &[], &["nowhere.glb", "cannot be read"]);
    refused(folder.path(), &[], &["cannot be read"]);
}

#[test]
fn wrong_elements_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let (json, bin) = arm();
    let change = |edit: &dyn Fn(&mut Value, &mut Vec<u8>)| {
        let (mut json, mut bin) = (json.clone(), bin.clone());
        edit(&mut json, &mut bin);
        write(folder.path(), json, &bin)
    };
    let huge =
        change(&|json, _| json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(4_000_000_000u64));
    refused(&huge, &[], &["arm.gltf", "mesh 0", "4000000000"]);
    let count = change(&|json, _| json["accessors"][0]["count"] = json!(1u64 << 52));
    refused(&count, &[], &["arm.gltf", "accessor 0"]);
    let nan = change(&|json, bin| {
        let at = attribute_offset(json, "POSITION") + 12 * 5 + 4;
        bin[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    });
    refused(&nan, &[], &["arm.gltf", "mesh 0", "vertex 5", "not a finite number"]);
    let lost = change(&|_, _| {});
    fs::remove_file(folder.path().join("arm.bin")).expect("removed");
    refused(&lost, &[], &["arm.gltf", "buffer 0", "arm.bin"]);
    let skinless = change(&|json, _| {
        for node in json["nodes"].as_array_mut().expect("nodes") {
            node.as_object_mut().expect("a node").remove("skin");
        }
        json.as_object_mut().expect("an object").remove("skins");
    });
    refused(&skinless, &[], &["arm.gltf", "no skinned mesh", "armature"]);
    let meshless = change(&|json, _| {
        for node in json["nodes"].as_array_mut().expect("nodes") {
            let node = node.as_object_mut().expect("a node");
            node.remove("skin");
            node.remove("mesh");
        }
        json.as_object_mut().expect("an object").remove("meshes");
    });
    refused(&meshless, &[], &["arm.gltf", "no mesh"]);
}

#[test]
fn clips_and_frames_that_are_not_there_name_those_that_are() {
    let arm = asset("arm.glb");
    refused(&arm, &["--clip", "moonwalk"], &["arm.glb", "moonwalk", "curl", "shake"]);
    refused(&arm, &["--clip", "7"], &["arm.glb", "7", "curl"]);
    refused(&arm, &["--clip", "curl", "--frames", "0..5000"], &["arm.glb", "0..5000", "curl", "0..60"]);
    refused(&arm, &["--clip", "rest", "--frames", "1"], &["arm.glb", "bind pose", "0..0"]);
}

#[test]
fn muscle_files_name_line_and_column() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.toml");
    let out = folder.path().join("out.pc2");
    let good = "[[muscle]]\nname = \"a\"\nbone = \"upperarm\"\n\
                origin = { bone = \"upperarm\", offset = [0, 0.1, 0] }\n\
                insertion = { bone = \"lowerarm\", offset = [0, 0.1, 0] }\nwidth = 0.02\nalpha = 3\n";
    let run = |text: &str, arguments: &[&str]| {
        fs::write(&path, text).expect("written");
        sinew().args(arguments).arg(asset("arm.glb")).arg("--muscles").arg(&path).output().expect("runs")
    };
    let bake = ["bake", "--device", "cpu", "-o", out.to_str().expect("a plain path")];
    let refused = |from: &str, to: &str, place: &str, words: &[&str]| {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "`{from}` is not in the good file");
        for arguments in [&bake[..], &["validate"], &["validate", "--json"]] {
            let line = refusal(&run(&text, arguments), 3);
            assert!(line.contains(&format!("m.toml:{place}:")), "{place} is not the place: {line}");
            assert!(words.iter().all(|w| line.contains(w)), "{words:?} are not all in: {line}");
            assert_eq!(names(folder.path()), ["m.toml"]);
        }
    };
    super::printed(&run(good, &["validate"]));
    refused("[[muscle]]", "[[muscle]", "1", &[]);
    refused("0.02", "\"wide\"", "6:9", &["muscle `a`: `width` is the text \"wide\"", "must be a number"]);
    refused("width", "widht", "6:1", &["unknown key `widht`", "did you mean `width`"]);
    refused("bone = \"upper", "bone = \"uper", "3:8", &["muscle `a`", "`uperarm`", "nearest names: upperarm"]);
    refused("bone = \"lower", "bone = \"tail", "5:22", &["insertion bone `tailarm`", "nearest names"]);
    refused("alpha = 3", "alpha = 10", "7:9", &["alpha is 10", "1 to 9"]);
    refused("alpha = 3", "beta = 0", "7:8", &["beta is 0", "1 to 9"]);
    let coincident = "bone = \"upperarm\", offset = [0, 0.1, 0.0]";
    refused("bone = \"lowerarm\", offset = [0, 0.1, 0]", coincident, "5:43", &["apart at rest", "move one"]);
    refused("width = 0.02", "volume = -1e-4", "6:10", &["volume is -0.0001", "positive"]);
    refused("width = 0.02", "volume = nan", "6:10", &["volume is NaN"]);
    refused("[0, 0.1, 0]", "[0, nan, 0]", "4:44", &["offset holds NaN"]);
    refused(
        "alpha = 3",
        "drivers = [{ angle = { joint = \"elbow\", to = 1 } }]",
        "7:32",
        &["joint `elbow`", "nearest"],
    );
    refused("[0, 0.1, 0]", "[0, 0.1, 0, 0]", "4:40", &["the list is too long; three numbers are needed"]);
    let shapes = "keys = { shape = [[0, 3, 3, 9]] }";
    refused("alpha = 3", shapes, "7:19", &["the list is too long; three numbers are needed"]);
    let same = "fibres = { count = 3, origin_line = [[0, 0.1, 0]] }";
    refused("alpha = 3", same, "7:37", &["fibres 1 and 2 lie on one another"]);
    refused("alpha = 3", "keys = { width = [[0, 11]] }", "7:23", &["width is 11", "at most 10"]);
    refused("\"a\"", "\"\\u001b[2Ja\"", "2:8", &["control character U+001B"]);
    refused("alpha = 3", "keys = { activation = [[1, 0], [0, 1]] }", "7:33", &["ascend"]);
    refused("width = 0.02", "width = 20", "6:9", &["beside a character"]);
    refused("alpha = 3", "[[bone]]\nbone = \"tail\"\nmesh = \"m\"", "8:8", &["bone `tail`", "not a joint"]);
}

#[test]
fn a_node_beyond_all_measure_ends_the_run_in_order() {
    // Its vertices' squared distances from the muscles are infinite.
    let folder = tempfile::tempdir().expect("a folder");
    let (mut json, bin) = arm();
    for node in 1..json["nodes"].as_array().expect("nodes").len() {
        let own = json["nodes"][node]["translation"].clone();
        json["nodes"][node]["translation"] = json!([3e21, 0.0, 0.0]);
        let input = write(folder.path(), json.clone(), &bin);
        let out = folder.path().join("out.pc2");
        let mut bake = sinew();
        bake.args(["bake", "--device", "cpu", "--clip", "default"]).arg(&input).arg("-o").arg(&out);
        bake.arg("--muscles").arg(asset("arm.muscles.toml"));
        super::printed(&bake.output().expect("runs"));
        assert!(out.is_file());
        json["nodes"][node]["translation"] = own;
    }
    json["nodes"][1]["translation"] = json!([1e39, 0.0, 0.0]);
    let beyond = write(folder.path(), json, &bin);
    refused(&beyond, &["--clip", "default"], &["arm.gltf"]);
}

#[test]
fn outputs_that_cannot_be_written_are_named_and_leave_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("file"), "theirs").expect("written");
    fs::create_dir(folder.path().join("folder.pc2")).expect("made");
    let outputs =
        [("file/out.pc2", "out.pc2"), ("folder.pc2", "is a folder"), ("file", "is a file"), ("a.abc", ".abc")];
    for (out, word) in outputs {
        let path = folder.path().join(out);
        let command = ["bake", "--device", "cpu", "--skinning", "linear", "--frames", "0"];
        let output = sinew().args(command).arg(asset("arm.glb")).arg("-o").arg(&path).output().expect("runs");
        let line = refusal(&output, 3);
        assert!(line.contains(word) && line.contains(out), "{line}");
    }
    assert_eq!(names(folder.path()), ["file", "folder.pc2"]);
    assert_eq!(fs::read(folder.path().join("file")).expect("kept"), b"theirs");
}

#[test]
fn a_sequence_that_fails_halfway_takes_its_files_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("walk");
    fs::create_dir_all(out.join("frame_0003.obj")).expect("an obstacle");
    let command = ["bake", "--device", "cpu", "--skinning", "linear", "--frames", "0..5"];
    let output = sinew().args(command).arg(asset("arm.glb")).arg("-o").arg(&out).output().expect("runs");
    assert!(refusal(&output, 3).contains("frame_0003.obj"));
    assert_eq!(names(&out), ["frame_0003.obj"]);
}

#[test]
fn weighted_skinning_needs_muscles() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut bake = sinew();
    bake.args(["bake", "--device", "cpu", "--skinning", "weighted", "--frames", "0"]).arg(asset("arm.glb"));
    bake.arg("-o").arg(folder.path().join("out.pc2"));
    let line = refusal(&bake.output().expect("runs"), 3);
    assert!(line.contains("needs muscles") && line.contains("give a muscle file"), "{line}");
    assert!(names(folder.path()).is_empty());
    let baked = bake.arg("--muscles").arg(asset("arm.muscles.toml")).output().expect("runs");
    assert!(baked.status.success() && !names(folder.path()).is_empty(), "{baked:?}");
}
