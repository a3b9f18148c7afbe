//! The verbs about the muscle file: validate, schema, muscles mirror, muscles copy.

use super::{asset, names, printed, refusal, sinew};
use serde_json::Value;
use std::fs;

#[test]
fn the_sample_fits_the_arm_and_is_summed_up() {
    let validate = |extra: &[&str]| {
        let mut command = sinew();
        command.arg("validate").arg(asset("arm.glb")).arg("--muscles").arg(asset("sample.muscles.toml")).args(extra);
        printed(&command.output().expect("runs"))
    };
    let text = validate(&[]);
    assert!(text.contains("3 muscles and 1 bone shapes fit arm") && text.contains("3 fibres"), "{text}");
    let found: Value = serde_json::from_str(&validate(&["--json"])).expect("JSON");
    assert_eq!(found["muscles"][1]["drivers"], serde_json::json!(["length", "angle", "constant"]));
    assert_eq!(found["notes"], serde_json::json!([]));
}

#[test]
fn the_sample_shows_every_key_of_the_schema() {
    let schema: Value =
        serde_json::from_str(&printed(&sinew().arg("schema").output().expect("runs"))).expect("a JSON Schema");
    let sample = fs::read_to_string(asset("sample.muscles.toml")).expect("the sample");
    let unshown = |sample: &str| {
        let tables = schema["$defs"].as_object().expect("definitions").values().chain([&schema]);
        let keys = tables.filter_map(|t| t["properties"].as_object()).flat_map(|p| p.keys());
        let shows = |key: &str| sample.contains(&format!("{key} =")) || sample.contains(&format!("{key}]"));
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
    assert_eq!((changed, copied.lines().count()), (3, mirrored.lines().count()), "two betas and an eccentricity");

    let line = refusal(&copy(&["--from", "flexor", "--to", "biceps"]), 3);
    assert!(line.contains("m.toml") && line.contains("nearest names: flexors"), "{line}");
    assert_eq!(fs::read_to_string(&path).expect("kept"), copied);
    assert_eq!(names(folder.path()), ["m.toml"]);
}
