//! `sinew extract`: what it finds in people's characters, and that it refuses the rest in one line.

use super::{asset, printed, sinew_without_adapter};
use crate::support::data;
use glam::Vec3;
use sinew::rig::{Attachment, Character, MuscleSpec, muscle_file};
use std::path::{Path, PathBuf};
use std::process::Output;

fn extract(file: &Path, out: &Path) -> Output {
    sinew_without_adapter().arg("extract").arg(file).arg("-o").arg(out).output().expect("runs")
}

fn place_rest(character: &Character, end: &Attachment) -> Vec3 {
    let joint = character.joints.iter().find(|joint| joint.name == end.bone).expect("a joint");
    joint.bind().transform_point3(end.offset)
}

/// Muscles of a side without a partner on the other: of the same name but for its side, the middle of the axis within `reach`
/// metres of where a mirror has it.
fn alone<'a>(character: &Character, muscles: &'a [MuscleSpec], reach: f32) -> Vec<&'a str> {
    let middle = |m: &MuscleSpec| (place_rest(character, &m.origin) + place_rest(character, &m.insertion)) * 0.5;
    let stem = |name: &str| name.trim_end_matches("_l").trim_end_matches("_r").to_owned();
    let partner = |a: &MuscleSpec, b: &MuscleSpec| {
        let apart = (middle(a) * Vec3::new(-1.0, 1.0, 1.0)).distance(middle(b));
        a.side != b.side && stem(&a.name) == stem(&b.name) && apart < reach
    };
    muscles.iter().filter(|a| !muscles.iter().any(|b| partner(a, b))).map(|m| &m.name[..]).collect()
}

#[test]
fn an_athlete_has_his_limbs_muscles_on_both_sides() {
    let Some(data) = data() else { return };
    let file = data.join("humans/mh_male_athletic.glb");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("athlete.muscles.toml");
    let text = printed(&extract(&file, &out));
    assert!(text.contains("muscles, in") && text.contains("biceps_l"), "{text}");
    let muscles = muscle_file::read(&out).expect("a muscle file").muscles;
    let scene = sinew::io::gltf::read(&file).expect("a human");
    for name in ["biceps", "triceps_long", "triceps_lateral", "quadriceps", "gastrocnemius", "tibialis_anterior"] {
        for side in ["l", "r"] {
            assert!(muscles.iter().any(|m| m.name == format!("{name}_{side}")), "{name}_{side}: {text}");
        }
    }
    let alone_within = |reach| alone(&scene.character, &muscles, reach);
    assert!(10 * alone_within(0.012).len() <= muscles.len(), "{:?} of {}", alone_within(0.012), muscles.len());
    assert!(alone_within(1e-6).len() == muscles.len(), "no hand-made mesh is a mirror's to the micrometre");
    let rig = sinew::rig::Rig::build(
        scene.character,
        &muscles,
        &sinew::rig::BuildOptions { fields: false, ..Default::default() },
    );
    rig.map(drop).expect("the muscles fit the character");
}

#[test]
fn extracting_again_keeps_what_was_edited() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("arm.muscles.toml");
    printed(&extract(&asset("arm.glb"), &out));
    let text = std::fs::read_to_string(&out).expect("a file");
    let first = &muscle_file::read(&out).expect("a good file").muscles;
    let (edited, lost) = (&first[0].name, &first[1].name);
    let mut document = muscle_file::Document::parse(&text, &out).expect("a good file");
    document.set(edited, "width", "0.0654321").expect("an edit");
    let at = document.to_string().find(&format!("[[muscle]]\nname = \"{lost}\"")).expect("the second muscle");
    let mut text = document.to_string();
    let end = text[at + 10..].find("[[muscle]]").map_or(text.len(), |more| at + 10 + more);
    text.replace_range(at..end, "# By hand.\n");
    std::fs::write(&out, &text).expect("written");
    let told = printed(&extract(&asset("arm.glb"), &out));
    let again = std::fs::read_to_string(&out).expect("a file");
    assert!(again.contains("0.0654321") && again.contains("# By hand.") && again.contains(lost), "{again}");
    assert_eq!(told.matches("keeps its own").count(), first.len() - 1, "{told}");
    assert_eq!(muscle_file::read(&out).expect("a good file").muscles.len(), first.len());
    std::fs::remove_file(&out).expect("there");
    printed(&extract(&asset("arm.glb"), &out));
    assert!(!std::fs::read_to_string(&out).expect("a file").contains("0.0654321"), "a fresh file has no edits");
}

#[test]
fn every_character_has_muscles_or_is_refused_in_one_line() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let mut files: Vec<PathBuf> = vec![asset("arm.glb")];
    for folder in ["humans", "characters"] {
        let entries = std::fs::read_dir(data.join(folder)).expect("the data");
        files
            .extend(entries.map(|e| e.expect("an entry").path()).filter(|p| p.extension().is_some_and(|e| e == "glb")));
    }
    files.sort();
    let mut found = 0;
    for file in &files {
        let out = folder.path().join("out.muscles.toml");
        let output = extract(file, &out);
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        match output.status.code() {
            Some(0) => {
                found += usize::from(!muscle_file::read(&out).expect("a good file").muscles.is_empty());
                std::fs::remove_file(&out).expect("written");
            }
            Some(3) => {
                assert!(errors.lines().count() == 1 && errors.starts_with("error: ") && !out.exists(), "{errors}")
            }
            code => panic!("{}: {code:?} {errors}", file.display()),
        }
        println!(
            "{}: {:?} {}",
            file.display(),
            output.status.code(),
            String::from_utf8_lossy(&output.stdout).lines().next().unwrap_or(&errors)
        );
    }
    assert!(found >= 6, "{found} of {} characters have muscles", files.len());
}
