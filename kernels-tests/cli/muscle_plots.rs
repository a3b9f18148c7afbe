//! `sinew muscles plot`: pages and a table of what muscles do over a clip.

use super::{asset, names, printed, refusal, sinew_without_adapter};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Output;

fn plot(out: &Path, extra: &[&str]) -> Output {
    let mut command = sinew_without_adapter();
    command.args(["muscles", "plot"]).arg(asset("arm.glb")).arg("--muscles").arg(asset("arm.muscles.toml"));
    command.args(["--clip", "shake", "--device", "cpu"]).args(extra).arg("-o").arg(out).output().expect("runs")
}

/// The table's columns by heading; cells that are empty are NaN.
fn table(folder: &Path) -> (Vec<String>, BTreeMap<String, Vec<f64>>) {
    let mut file = csv::Reader::from_path(folder.join("muscles.csv")).expect("a table");
    let headings = file.headers().expect("headings").clone();
    let (mut muscles, mut columns) = (Vec::new(), BTreeMap::new());
    for record in file.records() {
        let record = record.expect("a record");
        muscles.push(record[0].to_owned());
        for (heading, cell) in headings.iter().zip(&record).skip(1) {
            let value = if cell.is_empty() { f64::NAN } else { cell.parse().expect("a number") };
            columns.entry(heading.to_owned()).or_insert_with(Vec::new).push(value);
        }
    }
    (muscles, columns)
}

#[test]
fn every_muscle_has_a_page_and_every_frame_a_record() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("deep/plots");
    let text = printed(&plot(&out, &["--frames", "6..9"]));
    assert!(text.contains("muscles.csv, clip `shake`, frames 6..9 at 30 fps, xpbd at 12 Hz"), "{text}");
    let (muscles, columns) = table(&out);
    let mut pages = names(&out);
    pages.retain(|name| name.ends_with(".png"));
    let mut distinct = muscles.clone();
    distinct.dedup();
    assert_eq!((pages.len(), names(&out).len()), (distinct.len(), distinct.len() + 1));
    assert!(pages[0] == format!("00_{}.png", distinct[0]) && text.contains(&distinct[0]), "{pages:?}\n{text}");
    assert_eq!(columns["frame"], [6.0, 7.0, 8.0, 9.0].repeat(distinct.len()));
    assert!(columns.values().flatten().all(|v| v.is_finite()));
    for (volume, wanted) in columns["volume_cm3"].iter().zip(&columns["wanted_volume_cm3"]) {
        assert!((volume / wanted - 1.0).abs() < 0.01, "{volume} {wanted}");
    }
    assert!(columns["fastest_particle_m_per_s"].iter().all(|v| *v > 0.01), "a shake moves every muscle");
    assert_ne!(columns["length_m"][0], columns["length_m"][1]);
    let page = image::open(out.join(&pages[0])).expect("a picture").into_rgba8();
    assert!(page.pixels().filter(|p| p.0 != [255; 4]).count() > 5_000, "something is drawn");
    // A frame alone is that frame of the whole.
    let alone = folder.path().join("alone");
    printed(&plot(&alone, &["--dynamics", "xpbd", "--frames", "9"]));
    assert_eq!(table(&alone).1["length_m"][0], columns["length_m"][3]);
}

#[test]
fn raw_stiffness_has_no_balance_to_miss() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("plots");
    printed(&plot(&out, &["--dynamics", "pbd", "--frames", "2"]));
    let (_, columns) = table(&out);
    assert!(columns["elastic_violation_percent"].iter().all(|v| v.is_nan()));
    assert!(columns["length_m"].iter().all(|v| *v > 0.05));
}

#[test]
fn without_motion_or_muscles_there_is_nothing_to_plot() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("plots");
    let line = refusal(&plot(&out, &["--dynamics", "off"]), 2);
    assert!(line.contains("--dynamics is off") && line.contains("leave it out, or give xpbd"), "{line}");
    let mut command = sinew_without_adapter();
    command.args(["muscles", "plot"]).arg(asset("arm.glb")).args(["--device", "cpu", "-o"]);
    let line = refusal(&command.arg(&out).output().expect("runs"), 2);
    assert!(line.contains("--muscles"), "{line}");
    assert!(names(folder.path()).is_empty());
}
