//! What the verbs write and print.

use super::{asset, names, printed, refusal, sinew, skip_gpu};
use std::fs;

fn arm_with_muscles(verb: &[&str]) -> assert_cmd::Command {
    let mut command = sinew();
    command.args(verb).arg(asset("arm.glb")).arg("--muscles").arg(asset("arm.muscles.toml"));
    command
}

#[test]
fn two_bakes_have_the_same_bytes_on_either_side() {
    let folder = tempfile::tempdir().expect("a folder");
    let devices: &[&str] = if skip_gpu() { &["cpu"] } else { &["auto", "cpu"] };
    for device in devices {
        let bake = |name: &str, frames: &str| {
            let out = folder.path().join(name);
            let mut command = arm_with_muscles(&["bake", "--device", device, "--frames", frames]);
            printed(&command.arg("-o").arg(&out).output().expect("runs"));
            fs::read(out).expect("a cache")
        };
        let first = bake("a.pc2", "20..29");
        assert_eq!(first.len(), 32 + 10 * 12 * vertices(), "{device}");
        assert!(first == bake("b.pc2", "20..29"), "{device}: two runs differ");
        assert!(first != bake("c.pc2", "21..30"), "{device}: other frames have the same bytes");
    }
}

#[test]
fn a_frame_alone_is_that_frame_of_the_whole_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let devices: &[&str] = if skip_gpu() { &["cpu"] } else { &["cpu", "auto"] };
    for device in devices {
        let bake = |frames: &str, extra: &[&str]| {
            let out = folder.path().join("a.pc2");
            let mut command = arm_with_muscles(&["bake", "--device", device, "--clip", "shake", "--frames", frames]);
            printed(&command.args(extra).arg("-o").arg(&out).output().expect("runs"));
            let bytes = fs::read(out).expect("a cache");
            bytes[bytes.len() - 12 * vertices()..].to_vec()
        };
        let moving = ["--dynamics", "xpbd"];
        let whole = bake("0..20", &moving);
        assert!(bake("20", &moving) == whole, "{device}: alone");
        assert!(bake("13..20", &moving) == whole, "{device}: cut");
        let others: [&[&str]; 5] = [
            &["--dynamics", "off"],
            &["--dynamics", "xpbd", "--frequency", "6"],
            &["--dynamics", "pbd"],
            &["--dynamics", "xpbd", "--no-contacts", "bones"],
            &["--dynamics", "xpbd", "--iterations", "2x1", "--solver", "jacobi"],
        ];
        for other in others {
            assert!(bake("20", other) != whole, "{device}: {other:?} changes nothing");
        }
    }
}

/// Vertices of the arm, as `inspect` counts them.
fn vertices() -> usize {
    let output = sinew().args(["inspect", "--json"]).arg(asset("arm.glb")).output().expect("runs");
    let found: serde_json::Value = serde_json::from_str(&printed(&output)).expect("JSON");
    found["vertices"].as_u64().expect("a number") as usize
}

#[test]
fn inspect_counts_what_is_there() {
    let found: serde_json::Value =
        serde_json::from_str(&printed(&arm_with_muscles(&["inspect", "--json"]).output().expect("runs")))
            .expect("JSON");
    assert_eq!(found["character"], "arm");
    let clips: Vec<_> = found["clips"].as_array().expect("clips").iter().map(|c| c["name"].clone()).collect();
    assert_eq!(clips, ["curl", "shake"]);
    let count = |key: &str| found[key].as_u64().expect("a number");
    assert_eq!(count("active_vertices") + count("following_vertices"), count("vertices"));
    assert!(count("active_vertices") * 2 > count("vertices"));
    let muscles = found["muscles"].as_array().expect("muscles");
    assert!(!muscles.is_empty() && muscles.iter().all(|m| m["volume_cubic_metres"].as_f64().is_some_and(|v| v > 0.0)));
    let weighted = |m: &serde_json::Value| m["weighted_vertices"].as_u64().is_some_and(|n| n > 10);
    assert!(muscles.iter().all(|m| weighted(m) && m["painted"] == false), "{muscles:?}");
    let joined = |g: &serde_json::Value| g["joined"].as_array().map_or(0, Vec::len);
    let groups =
        |found: &serde_json::Value| found["groups"].as_array().expect("groups").iter().map(joined).sum::<usize>();
    assert_eq!(groups(&found), 0);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("joined.muscles.toml");
    fs::write(&file, "[joints.lowerarm]\noperator = \"blend\"\n").expect("a file");
    let mut inspect = sinew();
    inspect.args(["inspect", "--json"]).arg(asset("arm.glb")).arg("--muscles").arg(&file);
    let with_joint = serde_json::from_str(&printed(&inspect.output().expect("runs"))).expect("JSON");
    assert_eq!(groups(&with_joint), 2, "both sides of the elbow name it");
    let text = printed(&arm_with_muscles(&["inspect"]).output().expect("runs"));
    for part in ["joints:", "field groups:", "muscles:", "clips:", "materials:"] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn an_obj_sequence_takes_its_names_from_the_output() {
    let folder = tempfile::tempdir().expect("a folder");
    let bake = |out: &std::path::Path| {
        let command = ["bake", "--device", "cpu", "--skinning", "dual-quaternion", "--frames", "9..10"];
        printed(&sinew().args(command).arg(asset("arm.glb")).arg("-o").arg(out).output().expect("runs"));
    };
    bake(&folder.path().join("deep/er"));
    assert_eq!(names(&folder.path().join("deep/er")), ["frame_0009.obj", "frame_0010.obj"]);
    bake(&folder.path().join("curl.obj"));
    assert_eq!(names(folder.path()), ["curl_0009.obj", "curl_0010.obj", "deep"]);
    let text = fs::read_to_string(folder.path().join("curl_0009.obj")).expect("an OBJ file");
    let lines = |start: &str| text.lines().filter(|l| l.starts_with(start)).count();
    assert_eq!([lines("v "), lines("vn "), lines("vt ")], [vertices(); 3]);
    assert!(lines("f ") > 0 && lines("g ") > 0);
}

#[test]
fn render_draws_the_same_with_either_deformer() {
    if skip_gpu() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let shoot = |name: &str, extra: &[&str]| {
        let out = folder.path().join(name);
        let mut command = arm_with_muscles(&["render", "--size", "96x128", "--frames", "28..30", "--sheet"]);
        printed(&command.args(extra).arg("-o").arg(&out).output().expect("runs"));
        assert_eq!(names(&out), ["frame_0028.png", "frame_0029.png", "frame_0030.png", "sheet.png"]);
        image::open(out.join("frame_0029.png")).expect("a picture").into_rgba8()
    };
    let gpu = shoot("gpu", &[]);
    assert_eq!(gpu.dimensions(), (96, 128));
    // Positions agree to 1e-5 of the height, a thousandth of a pixel: hardly an edge sample may differ.
    let differing = |other: &image::RgbaImage| gpu.pixels().zip(other.pixels()).filter(|(a, b)| a != b).count();
    assert!(differing(&shoot("cpu", &["--device", "cpu"])) < 96 * 128 / 100);
    for other in [
        ["--view", "xray"],
        ["--view", "muscles"],
        ["--camera", "front"],
        ["--azimuth", "-70"],
        ["--skinning", "linear"],
    ] {
        assert!(differing(&shoot(&other.join(""), &other)) > 50, "{other:?} changes nothing");
    }
}

#[test]
fn the_demo_bends_the_arm() {
    if skip_gpu() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("demo");
    let output = sinew().args(["demo", "--size", "96x72", "-o"]).arg(&out).output().expect("runs");
    let text = printed(&output);
    assert!(text.contains("biceps") && text.contains("xray.png"), "{text}");
    let names = names(&out);
    assert_eq!(names.len(), 62, "{names:?}");
    let picture = |name: &str| image::open(out.join(name)).expect("a picture").into_rgba8();
    assert_eq!(picture("frame_0000.png").dimensions(), (96, 72));
    assert!(picture("frame_0000.png") != picture("frame_0030.png"), "the arm does not move");
}

#[test]
fn doctor_names_the_adapter() {
    if skip_gpu() {
        return;
    }
    let output = sinew().args(["doctor", "--json"]).output().expect("runs");
    let found: serde_json::Value = serde_json::from_str(&printed(&output)).expect("JSON");
    assert!(!found["adapters"].as_array().expect("adapters").is_empty());
    assert!(found["limits"]["buffer_bytes"].as_u64().is_some_and(|b| b >= 1 << 27));
    assert_eq!(found["missing"].as_array().map(Vec::len), Some(0));
}

#[test]
fn muscles_are_drawn_under_any_skinning_and_asked_for_where_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let draw = |name: &str, extra: &[&str]| {
        let out = folder.path().join(name);
        let mut command = sinew();
        command.args(["render", "--size", "96x128", "--frames", "30"]).arg(asset("arm.glb")).args(extra);
        (command.arg("-o").arg(&out).output().expect("runs"), out.join("frame_0030.png"))
    };
    let muscles = asset("arm.muscles.toml");
    let muscles = muscles.to_str().expect("a plain path");
    for view in ["xray", "muscles"] {
        let (output, _) = draw("none", &["--view", view]);
        assert!(refusal(&output, 2).contains("needs --muscles"));
        assert!(names(folder.path()).is_empty());
    }
    if skip_gpu() {
        return;
    }
    let picture = |name: &str, skinning: &str, view: &str| {
        let (output, path) = draw(name, &["--muscles", muscles, "--view", view, "--skinning", skinning]);
        printed(&output);
        image::open(path).expect("a picture").into_rgba8()
    };
    let skin = picture("skin", "linear", "skin");
    for view in ["xray", "muscles"] {
        assert!(picture(view, "linear", view) != skin, "{view} draws no muscles");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_bake_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    for out in ["out.pc2", "frames"] {
        // Nineteen thousand frames take a minute; the signal comes after a moment.
        let out = folder.path().join(out);
        let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("sinew"))
            .args(["bake", "--device", "cpu", "--fps", "10000", "--frames", "0..19000", "-o"])
            .arg(&out)
            .arg("assets/arm.glb")
            .stderr(std::process::Stdio::piped())
            .spawn()
            .expect("starts");
        std::thread::sleep(std::time::Duration::from_millis(1500));
        assert!(child.try_wait().expect("a state").is_none(), "it ended before it was interrupted");
        let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
        assert!(killed.success());
        let ended = child.wait_with_output().expect("ends");
        assert_eq!(ended.status.code(), Some(130), "{}", String::from_utf8_lossy(&ended.stderr));
        let left: Vec<_> = std::fs::read_dir(folder.path()).expect("the folder").flatten().collect();
        assert!(left.is_empty(), "{left:?}");
    }
}
