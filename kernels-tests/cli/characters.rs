//! The command on other people's characters: `SINEW_DATA`.

use super::{names, printed, refusal, sinew, skip_gpu};
use crate::support::data;
use std::fs;
use std::path::{Path, PathBuf};

fn glb_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).expect("a readable folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "glb" || e == "gltf") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Positions of the only frame of a cache.
fn cached(path: &Path) -> Vec<[f32; 3]> {
    let bytes = fs::read(path).expect("a cache");
    let numbers: Vec<f32> =
        bytes[32..].chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four bytes"))).collect();
    numbers.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()
}

fn farthest(ours: &[[f32; 3]], theirs: &[f32]) -> f32 {
    assert_eq!(ours.len() * 3, theirs.len(), "another number of vertices");
    let differences = ours.iter().flatten().zip(theirs).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, |worst, d| if d.is_nan() { f32::INFINITY } else { worst.max(d) })
}

/// Seconds from the file's time 0 to a clip's first key.
fn clip_start(file: &Path, clip: &str) -> f64 {
    let output = sinew().args(["inspect", "--json"]).arg(file).output().expect("runs");
    let found: serde_json::Value = serde_json::from_str(&printed(&output)).expect("JSON");
    let clips = found["clips"].as_array().expect("clips");
    let index = clips.iter().position(|c| c["name"] == clip).or_else(|| clip.parse().ok()).expect("the clip");
    clips[index]["start_seconds"].as_f64().expect("a number")
}

#[test]
fn linear_skinning_equals_blenders() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let (mut compared, mut others) = (0, 0);
    for entry in fs::read_dir(data.join("reference")).expect("reference data") {
        let npz = entry.expect("an entry").path();
        let name = npz.file_name().expect("a name").to_string_lossy().into_owned();
        let Some(character) = name.strip_suffix("_blender_lbs.npz") else { continue };
        let file = ["humans", "characters"].map(|f| data.join(f).join(format!("{character}.glb")));
        let file = file.iter().find(|f| f.is_file()).expect("the character");
        let mut archive = zip::ZipArchive::new(fs::File::open(&npz).expect("a file")).expect("an archive");
        let keys: Vec<String> =
            archive.file_names().filter_map(|f| f.strip_suffix(".npy")).map(str::to_owned).collect();
        assert!(!keys.is_empty(), "{name} is empty");
        for key in keys {
            let (clip, seconds) = key.split_once('|').expect("clip|seconds");
            // The key counts from the file's time 0, frames from the clip's start.
            let frame = (seconds.parse::<f64>().expect("seconds") - clip_start(file, clip)) * 24.0;
            assert!((frame - frame.round()).abs() < 1e-3, "{name} {key} is no whole frame");
            let frame = frame.round() as u32;
            let bake = |frame: u32| {
                let out = folder.path().join("out.pc2");
                let arguments = ["bake", "--skinning", "linear", "--device", "cpu", "--fps", "24", "--clip", clip];
                let mut command = sinew();
                command.args(arguments);
                command.arg("--frames").arg(frame.to_string()).arg(file).arg("-o").arg(&out);
                printed(&command.output().expect("runs"));
                cached(&out)
            };
            let array = npyz::NpyFile::new(archive.by_name(&format!("{key}.npy")).expect("there")).expect("readable");
            let order = array.order();
            let mut theirs: Vec<f32> = array.into_vec().expect("floats");
            if order == npyz::Order::Fortran {
                let rows = theirs.len() / 3;
                theirs = (0..theirs.len()).map(|i| theirs[i % 3 * rows + i / 3]).collect();
            }
            let worst = farthest(&bake(frame), &theirs);
            // Blender evaluates in f32 as well; 2e-5 m is what its own rounding of matrices and curves comes to.
            assert!(worst <= 2e-5, "{name} {key}: {worst} m");
            others += usize::from(farthest(&bake(frame - 1), &theirs) > 2e-5);
            compared += 1;
        }
    }
    assert!(compared > 20, "only {compared} poses were compared");
    // Some clips stand still for a while; elsewhere the frame before must not fit.
    assert!(others * 10 > compared * 9, "the frame before differs in {others} of {compared} only");
}

#[test]
fn every_character_is_drawn_or_refused_in_one_line() {
    let Some(data) = data() else { return };
    if skip_gpu() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let files: Vec<_> = ["humans", "characters"].iter().flat_map(|f| glb_files(&data.join(f))).collect();
    assert!(files.len() > 5, "{files:?}");
    for file in files {
        let out = folder.path().join("out");
        let output = sinew()
            .args(["render", "--size", "96x128", "--frames", "0", "-o"])
            .arg(&out)
            .arg(&file)
            .output()
            .expect("runs");
        if output.status.success() {
            printed(&output);
            assert_eq!(names(&out), ["frame_0000.png"], "{}", file.display());
            let picture = image::open(out.join("frame_0000.png")).expect("a picture").into_rgba8();
            let corner = *picture.get_pixel(0, 0);
            let drawn = picture.pixels().filter(|p| p.0[0].abs_diff(corner.0[0]) > 24).count();
            assert!(drawn > 200, "{}: {drawn} pixels stand out", file.display());
            fs::remove_dir_all(&out).expect("removed");
        } else {
            let line = refusal(&output, 3);
            assert!(line.contains(&*file.file_name().expect("a name").to_string_lossy()), "{line}");
            eprintln!("refused: {line}");
            assert!(!out.exists(), "{}", file.display());
        }
    }
}

#[test]
fn damaged_characters_are_baked_or_refused_in_one_line() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let files = glb_files(&data.join("malformed"));
    assert!(files.len() > 70, "{} files", files.len());
    let mut refused = 0;
    for file in files {
        let out = folder.path().join("out.pc2");
        let command = ["bake", "--skinning", "linear", "--device", "cpu", "--frames", "0", "-o"];
        let output = sinew().args(command).arg(&out).arg(&file).output().expect("runs");
        if output.status.success() {
            printed(&output);
            fs::remove_file(&out).expect("a cache");
        } else {
            refusal(&output, 3);
            refused += 1;
        }
        assert!(names(folder.path()).is_empty(), "{} left {:?}", file.display(), names(folder.path()));
    }
    assert!(refused > 50, "only {refused} files were refused");
}

#[test]
fn the_smallest_characters_have_their_own_number_of_vertices_on_the_gpu() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    for (file, vertices) in [("quad_skin.glb", 4), ("SimpleSkin.gltf", 10)] {
        let out = folder.path().join("out.pc2");
        let mut command = sinew();
        command.args(["bake", "--frames", "0", "-o"]).arg(&out).arg(data.join("characters").join(file));
        printed(&command.output().expect("runs"));
        assert_eq!(cached(&out).len(), vertices, "{file}");
    }
}
