//! The house rules, held by reading the sources. Every rule has a companion that feeds it a text that breaks it.

mod text;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use text::{calls, crate_paths, has_word, plain_code, without_tests};

/// Which rooms a room may use directly; what its neighbours may use, it may too. Every room may use `error`.
const MAY_USE: &[(&str, &[&str])] = &[
    ("error", &[]),
    ("math", &[]),
    ("field", &["math"]),
    ("rig", &["field", "math"]),
    ("clip", &["rig"]),
    ("skinning", STAGE),
    ("wrap", STAGE),
    ("dynamics", STAGE),
    ("tracking", STAGE),
    ("normals", STAGE),
    ("schedule", &[]),
    ("reference", &["skinning", "wrap", "dynamics", "tracking", "normals", "schedule"]),
    ("kernel", &["schedule", "skinning", "wrap", "dynamics", "tracking", "normals", "rig"]),
    ("gpu", &["kernel"]),
    ("render", &["gpu"]),
    ("io", &["rig", "clip"]),
    ("parity", &["reference", "gpu"]),
    ("figures", &["render", "reference", "skinning", "wrap", "dynamics", "tracking", "normals"]),
    ("extract", &["rig", "field"]),
    ("catalogue", &["rig"]),
];
/// Stages read the schedule's plain options, so that their parameters are derived once for both sides.
const STAGE: &[&str] = &["rig", "field", "math", "schedule"];

/// Macros that stand at the crate's root, with their rooms.
const ROOT_MACROS: &[(&str, &str)] = &[("gpu_struct", "math")];

/// Calls that make a device, submit to it, wait for it or map its memory.
const DEVICE_CALLS: &[&str] =
    &["submit", "poll", "map_async", "get_mapped_range", "request_device", "request_adapter", "enumerate_adapters"];

/// A source file: its path from the repository's root, with `/`, and its text.
type File = (String, String);

fn files(folders: &[&str], extensions: &[&str]) -> Vec<File> {
    fn walk(folder: &Path, extensions: &[&str], found: &mut Vec<File>) {
        let Ok(entries) = fs::read_dir(folder) else { return };
        for entry in entries.map(|e| e.expect("a readable folder")) {
            let path = entry.path();
            if path.is_dir() {
                walk(&path, extensions, found);
            } else if path.extension().is_some_and(|e| extensions.iter().any(|x| e == *x)) {
                let text = fs::read_to_string(&path).expect("a readable source file");
                let name = path.strip_prefix(env!("CARGO_MANIFEST_DIR")).expect("inside the repository");
                found.push((name.to_string_lossy().replace('\\', "/"), text));
            }
        }
    }
    let mut found = Vec::new();
    for folder in folders {
        walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), extensions, &mut found);
    }
    found.sort();
    found
}

/// Files of the library, without comments, strings and unit tests.
fn library() -> Vec<File> {
    let of_library = |path: &str| !path.starts_with("src/cli/") && !is_test_file(path);
    let found: Vec<File> =
        files(&["src"], &["rs"]).into_iter().filter(|(path, _)| of_library(path)).map(product).collect();
    assert!(found.len() > 20, "only {} files under src: is this the repository?", found.len());
    found
}

/// Test modules that stand in files of their own: `tests.rs`, or a folder `tests`.
fn is_test_file(path: &str) -> bool {
    path.ends_with("/tests.rs") || path.contains("/tests/")
}

fn product((path, text): File) -> File {
    (path, without_tests(&plain_code(&text)))
}

/// The room of a file of the library; `None` for the crate's root.
fn room(path: &str) -> Option<&str> {
    let name = path.strip_prefix("src/")?.split('/').next()?;
    let name = name.strip_suffix(".rs").unwrap_or(name);
    (name != "lib").then_some(name)
}

fn allowed(room: &str) -> Option<BTreeSet<&'static str>> {
    let table: BTreeMap<_, _> = MAY_USE.iter().copied().collect();
    let mut open = vec![*table.get_key_value(room)?.0];
    let mut closed = BTreeSet::from(["error"]);
    while let Some(next) = open.pop() {
        if closed.insert(next) || next == room {
            open.extend(table[next].iter().filter(|n| !closed.contains(*n)));
        }
    }
    Some(closed)
}

fn import_violations(files: &[File]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, code) in files {
        let Some(own) = room(path) else { continue };
        let Some(allowed) = allowed(own) else {
            found.push(format!("{path}: `{own}` is no room of the import table"));
            continue;
        };
        for used in crate_paths(path, code) {
            let used = ROOT_MACROS.iter().find(|(name, _)| *name == used).map_or(used.as_str(), |(_, room)| room);
            if !MAY_USE.iter().any(|(room, _)| *room == used) {
                found.push(format!("{path}: `crate::{used}` is no room; use the room it lives in"));
            } else if !allowed.contains(used) {
                found.push(format!("{path}: `{own}` may not use `{used}`"));
            }
        }
    }
    found
}

fn wgpu_violations(files: &[File]) -> Vec<String> {
    let may = ["kernel", "gpu", "render"];
    let outside = files.iter().filter(|(path, _)| room(path).is_some_and(|r| !may.contains(&r)));
    outside.filter(|(_, code)| has_word(code, "wgpu")).map(|(path, _)| format!("{path} mentions wgpu")).collect()
}

fn device_violations(files: &[File]) -> Vec<String> {
    let may = |path: &str| {
        ["src/gpu/headless", "src/gpu/readback", "src/render/", "src/render.rs"].iter().any(|p| path.starts_with(p))
    };
    call_violations(files.iter().filter(|(path, _)| !may(path)), DEVICE_CALLS)
}

fn panic_violations(files: &[File]) -> Vec<String> {
    let mut found = call_violations(files.iter(), &["unwrap", "expect", "unwrap_err", "expect_err"]);
    found.extend(macro_violations(files, &["panic", "todo", "unimplemented"]));
    found
}

fn print_violations(files: &[File]) -> Vec<String> {
    macro_violations(files, &["print", "println", "eprint", "eprintln", "dbg"])
}

fn call_violations<'a>(files: impl Iterator<Item = &'a File>, names: &[&str]) -> Vec<String> {
    files
        .flat_map(|(path, code)| {
            names.iter().filter(|name| calls(code, name)).map(move |name| format!("{path} calls `.{name}(`"))
        })
        .collect()
}

fn macro_violations(files: &[File], names: &[&str]) -> Vec<String> {
    files
        .iter()
        .flat_map(|(path, code)| {
            names
                .iter()
                .filter(|name| has_word(code, &format!("{name}!")))
                .map(move |name| format!("{path} uses `{name}!`"))
        })
        .collect()
}

fn mark_violations(files: &[File]) -> Vec<String> {
    let marks = [concat!("TO", "DO"), concat!("FIX", "ME"), concat!("XX", "X"), concat!("keep in ", "sync")];
    files
        .iter()
        .flat_map(|(path, text)| {
            marks.iter().filter(|mark| text.contains(*mark)).map(move |mark| format!("{path} has `{mark}`"))
        })
        .collect()
}

fn size_violations(files: &[File]) -> Vec<String> {
    let most = |path: &str| match path {
        p if p.starts_with("shaders/shared/") => 150,
        p if p.starts_with("shaders/") => 200,
        _ => 500,
    };
    files
        .iter()
        .map(|(path, text)| (path, text.lines().count(), most(path)))
        .filter(|(_, lines, most)| lines > most)
        .map(|(path, lines, most)| format!("{path} has {lines} lines, {most} are allowed"))
        .collect()
}

/// Every kernel stem stands in four places: its WGSL, its description, its twin, its test.
fn four_place_violations(files: &[File]) -> Vec<String> {
    let text_of = |path: &str| files.iter().find(|(p, _)| p == path).map(|(_, text)| text.as_str());
    let stem = |path: &str| {
        let shader = path.strip_prefix("shaders/kernels/").and_then(|p| p.strip_suffix(".wgsl"));
        shader.map(str::to_owned)
    };
    let described = files.iter().filter(|(path, text)| path.starts_with("src/kernel/") && text.contains("twin: \""));
    let mut stems: BTreeSet<String> = files.iter().filter_map(|(path, _)| stem(path)).collect();
    stems.extend(described.filter_map(|(p, _)| Some(p.strip_prefix("src/kernel/")?.strip_suffix(".rs")?.to_owned())));
    let mut found = Vec::new();
    for stem in stems {
        let places = [
            format!("shaders/kernels/{stem}.wgsl"),
            format!("src/kernel/{stem}.rs"),
            format!("kernels-tests/{stem}.rs"),
        ];
        found.extend(places.iter().filter(|p| text_of(p).is_none()).map(|p| format!("{stem}: {p} is missing")));
        if let Some(text) = text_of(&places[2])
            && !text.contains("#[test]")
        {
            found.push(format!("{stem}: {} holds no test", places[2]));
        }
        if let Some(text) = text_of(&places[1]) {
            let twin = text.split_once("twin: \"").and_then(|(_, rest)| rest.split_once('"')).map(|(twin, _)| twin);
            if !twin.is_some_and(|twin| twin_stands(files, twin)) {
                found.push(format!("{stem}: the twin {} is no function of its room", twin.unwrap_or("(none)")));
            }
        }
    }
    found
}

/// Whether the function `room::..::name` is declared in that room.
fn twin_stands(files: &[File], twin: &str) -> bool {
    let Some((modules, name)) = twin.rsplit_once("::") else { return false };
    let own = modules.split("::").next().unwrap_or(modules);
    files.iter().filter(|(path, _)| path.starts_with("src/") && room(path) == Some(own)).any(|(_, text)| {
        [format!("pub fn {name}("), format!("pub fn {name}<")].iter().any(|f| text.contains(f.as_str()))
    })
}

#[track_caller]
fn none(violations: Vec<String>) {
    assert!(violations.is_empty(), "\n{}", violations.join("\n"));
}

#[track_caller]
fn caught(rule: fn(&[File]) -> Vec<String>, path: &str, text: &str) {
    let file = (path.to_owned(), text.to_owned());
    assert_eq!(rule(&[file]).len(), 1, "{path} was to be found wanting once:\n{text}");
}

#[test]
fn rooms_use_only_what_the_table_allows() {
    none(import_violations(&library()));
}

#[test]
fn a_forbidden_import_is_caught() {
    caught(import_violations, "src/skinning.rs", "use crate::tracking::march;");
    caught(import_violations, "src/dynamics/solve.rs", "fn f() { crate::wrap::shape(); }");
    caught(import_violations, "src/field/hrbf.rs", "use crate::{math::acos, rig::Rig};");
    caught(import_violations, "src/math.rs", "use super::field::Sample;");
    caught(import_violations, "src/io/gltf/read.rs", "use super::super::super::render::Picture;");
    caught(import_violations, "src/error/rig.rs", "use crate::rig::Rig;");
    caught(import_violations, "src/newroom.rs", "");
    caught(import_violations, "src/rig/build.rs", "use crate::Rig;");
    none(import_violations(&[
        ("src/kernel/march.rs".into(), "use super::normals; use crate::{tracking, error::RigError, math};".into()),
        ("src/render/sheet.rs".into(), "use crate::schedule::Step; use crate::gpu_struct;".into()),
    ]));
}

#[test]
fn wgpu_stays_in_three_rooms() {
    none(wgpu_violations(&library()));
}

#[test]
fn a_stray_wgpu_is_caught() {
    caught(wgpu_violations, "src/parity.rs", "fn f(device: &wgpu::Device) {}");
    none(wgpu_violations(&[("src/gpu/instance.rs".into(), "use wgpu;".into())]));
}

#[test]
fn the_library_leaves_submitting_to_its_caller() {
    none(device_violations(&library()));
}

#[test]
fn a_submitting_library_is_caught() {
    for call in DEVICE_CALLS {
        caught(device_violations, "src/gpu/instance.rs", &format!("fn f() {{ x.{call}(y); }}"));
    }
    none(device_violations(&[("src/gpu/readback.rs".into(), "fn f() { queue.submit([]); }".into())]));
}

#[test]
fn the_library_neither_panics_nor_prints() {
    none(panic_violations(&library()));
    none(print_violations(&library()));
    let command: Vec<File> = files(&["src/cli"], &["rs"]).into_iter().map(product).collect();
    none(panic_violations(&command));
}

#[test]
fn only_test_files_are_left_out() {
    assert!(is_test_file("src/io/gltf/tests/mesh.rs") && is_test_file("src/rig/groups/tests.rs"));
    assert!(!is_test_file("src/io/gltf/mesh.rs") && !is_test_file("src/rig/latest.rs"));
}

#[test]
fn panics_and_prints_are_caught() {
    caught(panic_violations, "src/clip.rs", "fn f() { a.unwrap(); }");
    caught(panic_violations, "src/clip.rs", "fn f() { a\n    .expect(\"\"); }");
    caught(panic_violations, "src/clip.rs", "fn f() { panic!(); }");
    caught(print_violations, "src/clip.rs", "fn f() { println!(); }");
    let tests_only = "fn f() {}\n#[cfg(test)]\nmod tests { fn g() { a.unwrap(); println!(); } }\n";
    let product = product(("src/clip.rs".into(), tests_only.into()));
    none(panic_violations(std::slice::from_ref(&product)));
    none(print_violations(&[product]));
}

#[test]
fn no_marks_are_left() {
    none(mark_violations(&everything()));
}

#[test]
fn a_mark_is_caught() {
    caught(mark_violations, "src/clip.rs", concat!("// TO", "DO: later"));
    caught(mark_violations, "shaders/kernels/march.wgsl", concat!("// keep in ", "sync with march.rs"));
}

#[test]
fn files_are_rooms_not_halls() {
    none(size_violations(&everything()));
}

#[test]
fn a_hall_is_caught() {
    caught(size_violations, "src/clip.rs", &"\n".repeat(501));
    caught(size_violations, "kernels-tests/repo.rs", &"\n".repeat(501));
    caught(size_violations, "shaders/kernels/march.wgsl", &"\n".repeat(201));
    caught(size_violations, "shaders/shared/field.wgsl", &"\n".repeat(151));
    none(size_violations(&[("shaders/shared/field.wgsl".into(), "\n".repeat(150))]));
}

fn everything() -> Vec<File> {
    files(&["src", "shaders", "kernels-tests", "benches", "assets"], &["rs", "wgsl"])
}

#[test]
fn every_kernel_stands_in_four_places() {
    let files = everything();
    assert!(files.iter().filter(|(path, _)| path.starts_with("shaders/kernels/")).count() >= 6);
    none(four_place_violations(&files));
}

#[test]
fn a_missing_place_is_caught() {
    let whole = [
        ("shaders/kernels/skin.wgsl", ""),
        ("src/kernel/skin.rs", "twin: \"skinning::linear\","),
        ("kernels-tests/skin.rs", "#[test]"),
        ("src/skinning.rs", "pub fn linear(input: &SkinInput) {}"),
    ];
    let files = |skip: usize| -> Vec<File> {
        let kept = whole.iter().enumerate().filter(|(i, _)| *i != skip);
        kept.map(|(_, (path, text))| (path.to_string(), text.to_string())).collect()
    };
    none(four_place_violations(&files(4)));
    for (missing, (path, _)) in whole.iter().enumerate() {
        assert_eq!(four_place_violations(&files(missing)).len(), 1, "without {path}");
    }
    let mut untested = files(4);
    untested[2].1.clear();
    assert_eq!(four_place_violations(&untested).len(), 1);
}
