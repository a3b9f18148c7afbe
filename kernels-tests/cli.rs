//! The command as a user meets it: a process, its exit code, its one line of error, the files it leaves.

mod bad_input;
mod characters;
mod explain;
mod extract;
mod figures;
mod muscle_meshes;
mod muscle_plots;
mod muscles;
mod outputs;
mod parity;

use assert_cmd::Command;
use std::path::{Path, PathBuf};
use std::process::Output;

/// A file of the repository.
pub fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name)
}

/// The built command, its runtime files kept within the build.
pub fn sinew() -> Command {
    let runtime = Path::new(env!("CARGO_TARGET_TMPDIR")).join("runtime");
    std::fs::create_dir_all(&runtime).expect("a folder for runtime files");
    let mut command = Command::cargo_bin("sinew").expect("the command is built");
    // Mesa says an "error:" of its own where this names no folder of the user's.
    command.env("XDG_RUNTIME_DIR", runtime);
    command
}

/// The command where no Vulkan driver is to be found.
pub fn sinew_without_adapter() -> Command {
    let mut command = sinew();
    for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        command.env(name, "/nonexistent/driver.json");
    }
    command.env_remove("VK_ADD_DRIVER_FILES");
    command
}

/// Whether GPU tests are to be passed over.
pub fn skip_gpu() -> bool {
    std::env::var("SINEW_SKIP_GPU").is_ok_and(|v| v == "1")
}

/// The one line on standard error, after checking that it is the only one.
#[track_caller]
pub fn refusal(output: &Output, code: i32) -> String {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{text}");
    assert_eq!(text.lines().count(), 1, "one line was to be said:\n{text}");
    assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
    text.trim_end().strip_prefix("error: ").unwrap_or_else(|| panic!("no error line: {text}")).to_owned()
}

/// Checks that the run went well with nothing but notes on standard error, and gives what it printed.
#[track_caller]
pub fn printed(output: &Output) -> String {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{errors}");
    assert!(errors.lines().all(|line| line.starts_with("note: ")), "{errors}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Names of everything in a folder, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a readable folder");
    let mut names: Vec<_> = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn wrong_flags_are_usage() {
    let cases: [&[&str]; 23] = [
        &[],
        &["dance"],
        &["bake"],
        &["bake", "in.glb"],
        &["bake", "in.glb", "-o", "out.pc2", "--frames", "5..2"],
        &["bake", "in.glb", "-o", "out.pc2", "--fps", "0"],
        &["bake", "in.glb", "-o", "out.pc2", "--skinning", "magic"],
        &["render", "in.glb", "-o", "out", "--size", "0x4"],
        &["render", "in.glb", "-o", "out", "--threads", "0"],
        &["bake", "in.glb", "-o", "out", "--threads", "1025"],
        &["inspect", "in.glb", "--wobble"],
        &["inspect", "in.glb", "--vertex", "3"],
        &["inspect", "in.glb", "--frame", "3"],
        &["inspect", "in.glb", "--schedule", "--vertex", "3", "--frame", "3"],
        &["inspect", "in.glb", "--clip", "walk"],
        &["bake", "in.glb", "-o", "out", "--frequency", "61"],
        &["bake", "in.glb", "-o", "out", "--dynamics", "off", "--solver", "jacobi"],
        &["parity", "in.glb", "--iterations", "8"],
        &["demo", "--no-contacts", "air"],
        &["validate", "in.glb"],
        &["muscles"],
        &["muscles", "mirror", "m.toml", "in.glb", "--from", "_l", "-o", "out.toml"],
        &["muscles", "copy", "m.toml", "--from", "a", "--to", "b", "--only", "name", "-o", "out.toml"],
    ];
    for case in cases {
        let output = sinew().args(case).output().expect("runs");
        assert_eq!(output.status.code(), Some(2), "{case:?}");
        assert!(!output.stderr.is_empty() && output.stdout.is_empty(), "{case:?}");
    }
    assert_eq!(sinew().arg("--help").output().expect("runs").status.code(), Some(0));
}

#[test]
fn a_reader_that_leaves_is_no_panic() {
    use std::process::{Command, Stdio};
    let command = assert_cmd::cargo::cargo_bin("sinew");
    let mut child = Command::new(command)
        .args(["inspect", "--json"])
        .arg(asset("arm.glb"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("ends");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn without_an_adapter_drawing_is_refused_and_baking_goes_on_the_cpu() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let run = |args: &[&str]| {
        let mut command = sinew_without_adapter();
        command.args(args).arg("-o").arg(&out).output().expect("runs")
    };
    let arm = asset("arm.glb");
    let arm = arm.to_str().expect("a plain path");
    for args in [vec!["render", arm], vec!["render", arm, "--device", "cpu"], vec!["bake", arm], vec!["demo"]] {
        let line = refusal(&run(&args), 4);
        assert!(line.contains("mesa-vulkan-drivers libvulkan1"), "{args:?}: {line}");
        assert!(names(folder.path()).is_empty(), "{args:?} left {:?}", names(folder.path()));
    }
    let parity = sinew_without_adapter().args(["parity", arm]).output().expect("runs");
    assert!(refusal(&parity, 4).contains("mesa-vulkan-drivers"));
    let doctor = sinew_without_adapter().arg("doctor").output().expect("runs");
    assert_eq!(doctor.status.code(), Some(4));
    assert!(String::from_utf8_lossy(&doctor.stdout).contains("missing: no graphics adapter"));

    printed(&run(&["bake", arm, "--device", "cpu", "--frames", "0..1"]));
    assert_eq!(names(&out), ["frame_0000.obj", "frame_0001.obj"]);
    printed(&sinew_without_adapter().args(["inspect", arm]).output().expect("runs"));
}

#[test]
fn a_wrong_device_name_lists_the_right_ones() {
    if skip_gpu() {
        return;
    }
    let output = sinew().args(["parity", "--device", "Voodoo 2"]).arg(asset("arm.glb")).output().expect("runs");
    let line = refusal(&output, 4);
    assert!(line.contains("Voodoo 2") && line.contains("choose among"), "{line}");
}
