//! `sinew inspect --vertex` and `--schedule`, and the crease view.

use super::{asset, names, printed, refusal, sinew, sinew_without_adapter, skip_gpu};
use serde_json::Value;

fn inspect(extra: &[&str]) -> std::process::Output {
    let mut command = sinew_without_adapter();
    command.arg("inspect").arg(asset("arm.glb")).arg("--muscles").arg(asset("arm.muscles.toml"));
    command.args(extra).output().expect("runs")
}

fn json(extra: &[&str]) -> Value {
    serde_json::from_str(&printed(&inspect(&[extra, &["--json"]].concat()))).expect("JSON")
}

#[test]
fn a_vertex_is_explained() {
    let of = |vertex: u32| json(&["--clip", "curl", "--frame", "12", "--vertex", &vertex.to_string()]);
    let (mut active, mut passive) = (None, None);
    for vertex in [400, 900, 1300, 0, 700] {
        let found = of(vertex);
        let is_active = found["role"] == "active";
        if is_active {
            active = Some(found)
        } else {
            passive = Some(found)
        }
        if active.is_some() && passive.is_some() {
            break;
        }
    }
    let found = active.expect("an active vertex");
    assert!(found["owner"].is_string() && found["passes"].as_u64() > Some(0), "{found}");
    let off = |moment: &str| found[moment]["off"].as_f64().expect("a number").abs();
    assert!(off("ended") < 0.02, "{found}");
    let groups = found["ended"]["groups"].as_array().expect("groups");
    assert!(groups.iter().any(|g| g["name"] == found["owner"] && g["value"].as_f64() > Some(0.0)), "{found}");
    assert!(!found["neighbours"].as_array().expect("neighbours").is_empty());
    let passive = passive.map(|found| found["why"].as_str().map(str::to_owned));
    assert!(passive.is_none_or(|why| why.is_some_and(|why| why.len() > 10)));
    let text = printed(&inspect(&["--clip", "curl", "--frame", "12", "--vertex", "900"]));
    for word in ["vertex 900", "clip `curl`, frame 12", "sub-poses", "weights", "neighbours"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn a_vertex_or_a_frame_that_there_is_not_is_refused() {
    let line = refusal(&inspect(&["--frame", "3", "--vertex", "999999"]), 3);
    assert!(line.contains("arm.glb") && line.contains("--vertex 999999") && line.contains("numbered 0 to"), "{line}");
    for what in [&["--vertex", "3"][..], &["--schedule"]] {
        let line = refusal(&inspect(&[&["--frame", "9999"], what].concat()), 3);
        assert!(line.contains("--frame 9999") && line.contains("clip `curl`"), "{line}");
    }
}

#[test]
fn a_schedule_is_printed_in_the_frames_order() {
    let found = json(&["--schedule", "--frame", "2"]);
    let steps = found["steps"].as_array().expect("steps");
    assert_eq!(found["dispatches"].as_u64(), Some(steps.len() as u64));
    let of = |kernel: &str| steps.iter().filter(|step| step["kernel"] == kernel).count() as u64;
    let sub_poses = found["sub_poses"].as_u64().expect("a number");
    assert_eq!((of("track_carry"), of("track_march")), (sub_poses, 5 * sub_poses + 6));
    assert_eq!(steps.last().expect("a step")["kernel"], "normals");
    let text = printed(&inspect(&["--schedule", "--frame", "2"]));
    let places: Vec<_> =
        ["8 x {", "muscle_shape", "track_carry", "5 x {", "4 x track_slide", "6 x track_march", "normals"]
            .iter()
            .map(|word| text.find(word).unwrap_or_else(|| panic!("{word}: {text}")))
            .collect();
    assert!(places.is_sorted(), "{places:?}: {text}");
    let still = json(&["--schedule", "--clip", "rest", "--dynamics", "off"]);
    assert_ne!(still["dispatches"], found["dispatches"]);
}

#[test]
fn a_pose_by_itself_is_chosen_shown_and_explained() {
    let text = printed(&inspect(&["--schedule", "--frame", "20", "--tracking", "single"]));
    let places: Vec<_> =
        ["skin_dual_quaternion", "track_start", "12 x {", "2 x track_average", "6 x track_march", "normals"]
            .iter()
            .map(|word| text.find(word).unwrap_or_else(|| panic!("{word}: {text}")))
            .collect();
    assert!(places.is_sorted() && !text.contains("track_carry") && !text.contains("joint_step"), "{text}");
    let moving = printed(&inspect(&["--schedule", "--frame", "20", "--tracking", "single", "--dynamics", "xpbd"]));
    assert!(moving.contains("joint_step") && moving.contains("track_average"), "{moving}");
    let explained = |v: &&str| json(&["--vertex", v, "--frame", "20", "--tracking", "single"]);
    let found = ["400", "900", "1300"].iter().map(explained).find(|found| found["role"] == "active").expect("active");
    // Who has arrived sits out the last passes, but for the first of them.
    let passes = found["passes"].as_u64().expect("a number");
    assert!(found["sub_poses"] == 1 && (13..=18).contains(&passes), "{found}");
    let mut bake = sinew();
    bake.args(["bake", "-o", "none.pc2", "--tracking", "single", "--skinning", "linear"]).arg(asset("arm.glb"));
    let line = refusal(&bake.output().expect("runs"), 2);
    assert!(line.contains("--tracking single") && line.contains("--skinning implicit"), "{line}");
}

#[test]
fn groups_tell_what_drives_them() {
    let found = json(&[]);
    let groups = found["groups"].as_array().expect("groups");
    assert!(groups.iter().all(|g| g["driver"].is_string() && g["support_radius_metres"].as_f64() > Some(0.0)));
    let active: u64 = groups.iter().filter_map(|g| g["active_vertices"].as_u64()).sum();
    assert_eq!(found["active_vertices"].as_u64(), Some(active));
    assert!(groups.iter().any(|g| g["folds"].as_array().is_some_and(|folds| !folds.is_empty())), "{found}");
}

#[test]
fn creases_are_measured_and_drawn() {
    if skip_gpu() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let render = |frame: &str, skinning: &str| -> (Value, image::RgbaImage) {
        let mut command = sinew();
        command.args(["render", "--view", "crease", "--size", "160x120", "--json", "--skinning", skinning]);
        let output = command.args(["--frames", frame]).arg("-o").arg(&out).arg(asset("arm.glb")).output();
        let found = serde_json::from_str(&printed(&output.expect("runs"))).expect("JSON");
        let name = names(&out).pop().expect("a picture");
        let picture = image::open(out.join(name)).expect("a picture").into_rgba8();
        std::fs::remove_dir_all(&out).expect("removed");
        (found, picture)
    };
    let colored = |picture: &image::RgbaImage| {
        picture.pixels().filter(|p| i32::from(p.0[0]).abs_diff(i32::from(p.0[2])) > 25).count()
    };
    let (bent, picture) = render("30", "linear");
    let notes = bent["notes"].to_string();
    assert!(notes.contains("in full from 60 degrees"), "{notes}");
    let p995 = |found: &Value| found["crease"]["p995_degrees"].as_f64().expect("a number");
    let (start, plain) = render("0", "linear");
    assert!(p995(&bent) > 10.0 && p995(&start) < p995(&bent), "{bent} {start}");
    assert!(colored(&picture) > 10 && colored(&plain) < colored(&picture), "{} {}", colored(&plain), colored(&picture));
}
