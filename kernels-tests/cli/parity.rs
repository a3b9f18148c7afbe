//! `sinew parity`.

use super::{asset, printed, sinew, skip_gpu};
use crate::support::data;
use serde_json::Value;
use std::path::Path;

/// What parity finds of a character with its muscles.
#[track_caller]
fn parity(character: &Path, muscles: Option<&Path>, extra: &[&str]) -> Value {
    let mut command = sinew();
    command.args(["parity", "--json"]).arg(character).args(extra);
    if let Some(muscles) = muscles {
        command.arg("--muscles").arg(muscles);
    }
    serde_json::from_str(&printed(&command.output().expect("runs"))).expect("JSON")
}

/// The tolerance that particles are held against: it is wider where muscles press on one another.
fn of_particles(found: &Value) -> f64 {
    let stages = found["stages"].as_array().expect("stages");
    let particles = stages.iter().find(|s| s["stage"] == "particles").expect("particles");
    particles["tolerance"]["absolute"].as_f64().expect("a number")
}

/// The tolerance in single precision.
fn is(found: f64, tolerance: sinew::parity::Tolerance) -> bool {
    found as f32 == tolerance.absolute
}

#[test]
fn parity_of_the_arm_is_in_tolerance() {
    if skip_gpu() {
        return;
    }
    let found = parity(&asset("arm.glb"), Some(&asset("arm.muscles.toml")), &["--frames", "25..30"]);
    let stages = found["stages"].as_array().expect("stages");
    let named: Vec<_> = stages.iter().filter_map(|s| s["stage"].as_str()).collect();
    let all = ["skinned", "muscles", "muscle axes", "particles", "tracked", "output positions", "output normals"];
    assert_eq!(named, all);
    assert!(stages.iter().all(|s| s["pass"] == true), "{found}");
    assert_eq!(found["frames"].as_array().map(Vec::len), Some(6));
    assert!(is(of_particles(&found), sinew::parity::PARTICLES), "these muscles do not press on one another: {found}");
}

#[test]
fn parity_of_muscles_that_press_on_one_another_holds_for_frames_far_apart() {
    if skip_gpu() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.toml");
    let text = std::fs::read_to_string(asset("arm.muscles.toml")).expect("the arm's muscles");
    let crowded = text.replace("[[muscle]]\n", "[[muscle]]\ncollision_group = \"arm\"\n");
    std::fs::write(&path, crowded).expect("written");
    // Ten frames of sixty: what is between them drifts on two sides that go on by themselves.
    for clip in ["curl", "shake"] {
        let found = parity(&asset("arm.glb"), Some(&path), &["--clip", clip]);
        assert_eq!((&found["pass"], found["frames"].as_array().map(Vec::len)), (&true.into(), Some(10)), "{found}");
        assert!(is(of_particles(&found), sinew::parity::TOUCHING), "no muscle presses on another: {found}");
    }
}

#[test]
fn parity_of_a_human_arm_is_in_tolerance_in_every_frame() {
    let Some(data) = data() else { return };
    if skip_gpu() {
        return;
    }
    let file = "arm_nohand_dense_2172";
    let muscles = format!("kernels-tests/fixtures/{file}.muscles.toml");
    let muscles = Path::new(env!("CARGO_MANIFEST_DIR")).join(muscles);
    // Within a frame of these a muscle gives way on one side that does not on the other.
    for extra in [&["--clip", "biceps_curl", "--frames", "0..59"] as &[&str], &["--clip", "arm_shake"], &[]] {
        let found = parity(&data.join(format!("humans/{file}.glb")), Some(&muscles), extra);
        assert!(found["pass"] == true && is(of_particles(&found), sinew::parity::TOUCHING), "{extra:?}: {found}");
    }
}

#[test]
fn parity_of_a_human_is_in_tolerance() {
    let Some(data) = data() else { return };
    if skip_gpu() {
        return;
    }
    let found = parity(&data.join("humans/mh_male_athletic.glb"), None, &["--clip", "walk"]);
    assert_eq!(found["frames"].as_array().map(Vec::len), Some(10));
    assert_eq!(found["pass"], true, "{found}");
}
