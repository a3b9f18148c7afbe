//! The verbs about the muscle file: validate, schema, muscles mirror, muscles copy.

use super::bad_input::{arm, write};
use super::{asset, names, printed, refusal, sinew};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

#[test]
fn the_sample_fits_the_arm_and_is_summed_up() {
    let validate = |extra: &[&str]| {
        let mut command = sinew();
        command.arg("validate").arg(asset("arm.glb")).arg("--muscles").arg(asset("sample.muscles.toml")).args(extra);
        printed(&command.output().expect("runs"))
    };
    let text = validate(&[]);
    assert!(text.contains("3 muscles and 1 bone shape fit arm") && text.contains("3 fibres"), "{text}");
    let found: Value = serde_json::from_str(&validate(&["--json"])).expect("JSON");
    assert_eq!(found["muscles"][1]["drivers"], serde_json::json!(["length", "angle", "constant"]));
    assert_eq!(found["notes"], serde_json::json!([]));
}

#[test]
fn what_comes_to_nothing_is_noted() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.toml");
    let text = fs::read_to_string(asset("arm.muscles.toml")).expect("the arm's muscles");
    // The arm with a clip that keys the width of a muscle of this name, by the times of its first sampler.
    let keyed = |muscle: &str| {
        let (mut gltf, bin) = arm();
        gltf["extensions"] = json!({"SINEW_muscles": {"muscles": [{ "name": muscle }]}});
        gltf["extensionsUsed"] = json!(["SINEW_muscles", "KHR_animation_pointer"]);
        let clip = &mut gltf["animations"][0];
        let times = clip["samplers"][0]["input"].clone();
        let samplers = clip["samplers"].as_array_mut().expect("samplers");
        samplers.push(json!({ "input": times, "output": times }));
        let pointer = json!({"pointer": "/extensions/SINEW_muscles/muscles/0/width"});
        let target = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": pointer}});
        let channel = json!({ "sampler": samplers.len() - 1, "target": target });
        clip["channels"].as_array_mut().expect("channels").push(channel);
        write(folder.path(), gltf, &bin)
    };
    let notes = |muscle: &str, text: &str| {
        fs::write(&path, text).expect("written");
        let mut command = sinew();
        let output = command.arg("validate").arg(keyed(muscle)).arg("--muscles").arg(&path).output().expect("runs");
        printed(&output);
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let one = |notes: String, words: &[&str]| {
        assert_eq!(notes.lines().count(), 1, "{notes}");
        assert!(notes.starts_with("note: ") && words.iter().all(|w| notes.contains(w)), "{words:?}: {notes}");
    };
    assert_eq!(notes("biceps", &text), "");
    let unknown = ["clip `curl` keys muscle `bicesp`, which the muscle file lacks", "nearest names: biceps"];
    one(notes("bicesp", &text), &unknown);
    let mut bake = sinew();
    bake.args(["bake", "--device", "cpu", "--skinning", "linear", "--frames", "0", "-o"]);
    let output = bake.arg(folder.path().join("out.pc2")).arg(keyed("bicesp")).output().expect("runs");
    one(String::from_utf8_lossy(&output.stderr).into_owned(), &["keys muscle `bicesp`", "without --muscles FILE"]);

    let other = text.replace("name = \"arm\"", "name = \"leg\"");
    one(notes("biceps", &other), &["m.toml:19:8: ", "for character `leg`, and this one is `arm`"]);
    let hand = text.replacen("bone = \"upperarm\"", "bone = \"hand\"", 1);
    let line = 1 + hand.lines().position(|line| line == "bone = \"hand\"").expect("a changed line");
    one(notes("biceps", &hand), &[&format!("m.toml:{line}:8: muscle `biceps`: bone `hand`"), "moves none of it"]);
}

#[test]
fn the_sample_shows_every_key_of_the_schema() {
    let schema: Value =
        serde_json::from_str(&printed(&sinew().arg("schema").output().expect("runs"))).expect("a JSON Schema");
    let sample = fs::read_to_string(asset("sample.muscles.toml")).expect("the sample");
    let unshown = |sample: &str| {
        let tables = schema["$defs"].as_object().expect("definitions").values().chain([&schema]);
        let keys = tables.filter_map(|t| t["properties"].as_object()).flat_map(|p| p.keys());
        let shows = |key: &str| {
            sample.contains(&format!("{key} ="))
                || sample.contains(&format!("{key}]"))
                || sample.contains(&format!("[{key}."))
        };
        keys.filter(|key| !shows(key)).cloned().collect::<Vec<_>>()
    };
    assert_eq!(unshown(&sample), Vec::<String>::new());
    assert_eq!(unshown(&sample.replace("tendon =", "")), ["tendon"]);
}

#[test]
fn muscles_are_mirrored_and_copied_in_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.toml");
    let arm = fs::read_to_string(asset("arm.muscles.toml")).expect("the arm's muscles");
    fs::write(&path, &arm).expect("written");
    let mut mirror = sinew();
    mirror.args(["muscles", "mirror"]).arg(&path).arg(asset("arm.glb"));
    mirror.args(["--from", "triceps", "--to", "other", "--json", "-o"]).arg(&path);
    let done: Value = serde_json::from_str(&printed(&mirror.output().expect("runs"))).expect("JSON");
    assert_eq!(done["added"], serde_json::json!(["other_long", "other_lateral"]));
    let mirrored = fs::read_to_string(&path).expect("written");
    assert!(mirrored.starts_with(&arm) && mirrored.contains("side = \"right\""), "{mirrored}");

    let copy = |extra: &[&str]| {
        let mut copy = sinew();
        copy.args(["muscles", "copy"]).arg(&path).args(extra).arg("-o").arg(&path).output().expect("runs")
    };
    printed(&copy(&["--from", "flexors", "--to", "biceps,brachialis", "--only", "shape"]));
    let copied = fs::read_to_string(&path).expect("written");
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let changed = lines(&mirrored).into_iter().zip(lines(&copied)).filter(|(a, b)| a != b).count();
    assert_eq!(
        (changed, copied.lines().count()),
        (5, mirrored.lines().count()),
        "two betas, an eccentricity, two active"
    );

    let line = refusal(&copy(&["--from", "flexor", "--to", "biceps"]), 3);
    assert!(line.contains("m.toml") && line.contains("nearest names: flexors"), "{line}");
    assert_eq!(fs::read_to_string(&path).expect("kept"), copied);
    assert_eq!(names(folder.path()), ["m.toml"]);
}

#[test]
fn weights_go_into_the_character_and_come_back_as_they_were() {
    let folder = tempfile::tempdir().expect("a folder");
    let painted = folder.path().join("painted.glb");
    let run = |input: &Path, verb: &[&str], out: &Path| {
        let mut command = sinew();
        command.args(verb).arg(input).arg("--muscles").arg(asset("arm.muscles.toml"));
        command.args(["--dynamics", "off"]).arg("-o").arg(out).output().expect("runs")
    };
    for skinning in ["hybrid", "weighted"] {
        let weights = ["muscles", "weights", "--skinning", skinning, "--json"];
        let done = printed(&run(&asset("arm.glb"), &weights, &painted));
        let done: Value = serde_json::from_str(&done).expect("JSON");
        assert_eq!(done["muscles"][0]["attribute"], "_MUSCLE_0");
        assert!(done["muscles"][0]["vertices"].as_u64() > Some(50), "{done}");
        let baked = |input: &Path, name: &str| {
            let out = folder.path().join(name);
            let bake = ["bake", "--skinning", skinning, "--device", "cpu", "--clip", "curl", "--frames", "20..22"];
            printed(&run(input, &bake, &out));
            fs::read(out).expect("a cache")
        };
        let (found, read) = (baked(&asset("arm.glb"), "a.pc2"), baked(&painted, "b.pc2"));
        assert!(found == read, "{skinning}: weights as found, and as written and read");
        // Painted for another muscle file.
        let mut other = fs::read(&painted).expect("painted");
        let at = other.windows(11).position(|bytes| bytes == b"\"_MUSCLE_0\"").expect("the attribute");
        other[at + 9] = b'9';
        fs::write(&painted, other).expect("written");
        let mut refused = sinew();
        refused.args(["bake", "--skinning", skinning, "--device", "cpu", "--frames", "0", "--dynamics", "off"]);
        refused
            .arg(&painted)
            .arg("--muscles")
            .arg(asset("arm.muscles.toml"))
            .arg("-o")
            .arg(folder.path().join("c.pc2"));
        let line = refusal(&refused.output().expect("runs"), 3);
        assert!(line.contains("`_MUSCLE_9`"), "{line}");
        // Written anew, in place.
        printed(&run(&asset("arm.glb"), &weights, &painted));
        printed(&run(&painted, &weights, &painted));
        assert!(baked(&painted, "b.pc2") == found, "{skinning}: written twice");
    }
    let none = run(&asset("arm.glb"), &["muscles", "weights", "--skinning", "linear"], &painted);
    assert!(refusal(&none, 2).contains("weighted or hybrid"));
}

#[test]
fn bones_take_their_shape_from_the_file_or_the_skeleton() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.toml");
    let arm = fs::read_to_string(asset("arm.muscles.toml")).expect("the arm's muscles");
    let inspect = |bones: &str| {
        fs::write(&path, format!("{arm}{bones}")).expect("written");
        let mut command = sinew();
        command.args(["inspect", "--json"]).arg(asset("arm.glb")).arg("--muscles").arg(&path).output().expect("runs")
    };
    let bones = |text: &str| {
        let found: Value = serde_json::from_str(&printed(&inspect(text))).expect("JSON");
        found["bones"].as_array().expect("bones").clone()
    };
    let own = bones("");
    assert_eq!(own[0]["joint"], "upperarm");
    assert!(own.len() >= 2 && own.iter().all(|b| b["shape"] == "capsule" && b["given"] == false), "{own:?}");
    let radius = own[0]["radius_metres"].as_f64().expect("a radius");
    assert!((0.007..0.02).contains(&radius), "{radius}");

    let given = "\n[[bone]]\nbone = \"upperarm\"\nmesh = \"arm\"\n[[bone]]\nbone = \"lowerarm\"\n\
                 capsule = { from = [0, 0, 0], to = [0, 0.2, 0], radius = 0.01 }\n";
    let shapes = bones(given);
    assert_eq!(shapes.len(), own.len());
    assert!(shapes[0]["shape"] == "mesh" && shapes[0]["triangles"].as_u64() > Some(100), "{shapes:?}");
    assert_eq!(
        (&shapes[1]["given"], shapes[1]["radius_metres"].as_f64().map(|r| r as f32)),
        (&true.into(), Some(0.01))
    );

    let line = |text: &str| arm.lines().count() + text.lines().count();
    let wrong = given.replace("mesh = \"arm\"", "mesh = \"amr\"");
    let refused = refusal(&inspect(&wrong), 3);
    let place = format!("m.toml:{}:8: bone `upperarm`: mesh `amr`", line("\n\n\n") + 1);
    assert!(refused.contains(&place) && refused.contains("nearest names: arm"), "{refused}");
    let refused = refusal(&inspect(&given.replace("\"lowerarm\"", "\"lowrarm\"")), 3);
    assert!(refused.contains("bone `lowrarm`") && refused.contains("nearest names: lowerarm"), "{refused}");
}
