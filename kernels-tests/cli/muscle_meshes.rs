//! `bake --muscle-meshes`: closed meshes of constant volume, read back from the files.

use super::{asset, names, printed, refusal, sinew, skip_gpu};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::Path;

/// One object of an OBJ file.
#[derive(Clone, Default)]
struct Mesh {
    positions: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

impl Mesh {
    fn volume(&self) -> f64 {
        let base = self.positions[0];
        let corner = |i: usize| self.positions[i] - base;
        self.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
    }

    /// Whether each edge is shared by two triangles that run along it in opposite directions.
    fn is_closed(&self) -> bool {
        let mut edges = HashMap::new();
        for t in &self.triangles {
            (0..3).for_each(|k| *edges.entry((t[k], t[(k + 1) % 3])).or_insert(0) += 1);
        }
        !edges.is_empty() && edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
    }

    fn length(&self) -> f64 {
        self.positions[self.positions.len() - 2].distance(self.positions[self.positions.len() - 1])
    }
}

/// Objects by name; corners must stay within their object.
fn read(path: &Path) -> BTreeMap<String, Mesh> {
    let text = fs::read_to_string(path).expect("an OBJ file");
    let mut found: BTreeMap<String, Mesh> = BTreeMap::new();
    let (mut name, mut first, mut count) = (String::new(), 0, 0);
    for line in text.lines() {
        let mut words = line.split(' ');
        match words.next() {
            Some("o") => {
                name = words.next().expect("a name").to_owned();
                first = count;
                assert!(found.insert(name.clone(), Mesh::default()).is_none(), "{name} stands twice");
            }
            Some("v") => {
                let p: Vec<f64> = words.map(|w| w.parse().expect("a number")).collect();
                found.get_mut(&name).expect("an object").positions.push(DVec3::new(p[0], p[1], p[2]));
                count += 1;
            }
            Some("f") => {
                let corner = |w: &str| w.split('/').next().and_then(|i| i.parse::<usize>().ok()).expect("a corner");
                let t: Vec<usize> = words.map(|w| corner(w) - 1 - first).collect();
                found.get_mut(&name).expect("an object").triangles.push([t[0], t[1], t[2]]);
            }
            word => assert_eq!(word, Some("vn"), "{line}"),
        }
    }
    found
}

/// Largest change of a muscle's volume against its first frame, as a share, and of its length.
fn changes(frames: &[BTreeMap<String, Mesh>]) -> (f64, f64) {
    let ratio = |of: fn(&Mesh) -> f64| {
        let changes =
            frames.iter().flat_map(|f| f.iter().map(move |(name, m)| (of(m) / of(&frames[0][name]) - 1.0).abs()));
        changes.fold(0.0, f64::max)
    };
    (ratio(Mesh::volume), ratio(Mesh::length))
}

fn bake(out: &Path, meshes: &Path, extra: &[&str]) -> std::process::Output {
    let mut command = sinew();
    command.arg("bake").arg(asset("arm.glb")).args(extra).arg("-o").arg(out).arg("--muscle-meshes").arg(meshes);
    command.output().expect("runs")
}

fn muscles() -> String {
    asset("arm.muscles.toml").to_str().expect("a plain path").to_owned()
}

#[test]
fn muscles_are_closed_and_keep_their_volume_over_the_curl() {
    let folder = tempfile::tempdir().expect("a folder");
    let (out, meshes) = (folder.path().join("arm.pc2"), folder.path().join("m"));
    let extra = ["--device", "cpu", "--fps", "10", "--json", "--muscles", &muscles()];
    let found: serde_json::Value = serde_json::from_str(&printed(&bake(&out, &meshes, &extra))).expect("JSON");
    let written = &found["muscle_meshes"];
    assert!(out.is_file());
    let files = names(&meshes);
    assert_eq!(files.len() as u64, found["frames"].as_u64().expect("a number"));
    assert!(files.len() > 10, "{files:?}");
    assert_eq!(
        (&written["first_file"], &written["last_file"]),
        (&files[0].as_str().into(), &files[files.len() - 1].as_str().into())
    );
    assert_eq!(files[0], "muscles_0000.obj");

    let frames: Vec<_> = files.iter().map(|name| read(&meshes.join(name))).collect();
    let objects = written["objects"].as_array().expect("names");
    assert!(objects.len() == 7 && objects.iter().all(|o| frames[0].contains_key(o.as_str().expect("a name"))));
    for (name, mesh) in frames.iter().flatten() {
        assert!(mesh.is_closed(), "{name} is open");
        assert_eq!(written["vertices"].as_u64(), Some(mesh.positions.len() as u64), "{name}");
        assert!(mesh.triangles == frames[0][name].triangles, "{name} has other corners in another frame");
    }
    let (volume, length) = changes(&frames);
    assert!(volume < 0.01, "a volume changes by {volume}");
    assert!(length > 0.1, "no muscle changes its length: {length}");

    let mut open = frames[0]["biceps"].clone();
    open.triangles.pop();
    assert!(!open.is_closed(), "a hole must be seen");
    let mut wider = frames.clone();
    wider[5].get_mut("biceps").expect("the biceps").positions.iter_mut().for_each(|p| p.z *= 1.02);
    assert!(changes(&wider).0 > 0.01, "a biceps 2 % thicker must be seen");
}

#[test]
fn a_blunt_end_that_activation_sharpens_keeps_the_corners() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("blunt.muscles.toml");
    let text = fs::read_to_string(asset("arm.muscles.toml")).expect("the muscles");
    let shapes = "alpha = 1\nactive = { alpha = 4, beta = 4 }\nkeys = { activation = [[0, 0], [0.5, 0.5], [1, 1]] }\ndrivers = []\n";
    fs::write(&path, text.replacen("active = { alpha = 4, beta = 4 }\n", "", 1).replacen("alpha = 3\n", shapes, 1))
        .expect("written");
    let meshes = folder.path().join("m");
    let extra = ["--device", "cpu", "--frames", "0..30", "--muscles", path.to_str().expect("a plain path")];
    printed(&bake(&folder.path().join("a.pc2"), &meshes, &extra));
    let biceps: Vec<Mesh> =
        names(&meshes).iter().map(|name| read(&meshes.join(name)).remove("biceps").expect("the biceps")).collect();
    assert!(biceps.iter().all(|m| m.is_closed() && m.triangles == biceps[0].triangles));
    // The cap of the blunt end goes beyond the end of the axis, that of a pointed one does not.
    let beyond = |m: &Mesh| m.positions[m.positions.len() - 2].distance(m.positions[m.positions.len() - 3]);
    assert!(beyond(&biceps[0]) > 0.0 && biceps[0].length() > biceps[30].length());
}

#[test]
fn either_machine_writes_the_same_muscles() {
    if skip_gpu() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let run = |device: &str, frames: &str| {
        let meshes = folder.path().join(format!("{device}{frames}")).join("arm.obj");
        let extra = ["--device", device, "--frames", frames, "--muscles", &muscles()];
        printed(&bake(&folder.path().join("a.pc2"), &meshes, &extra));
        read(&meshes.with_file_name(format!("arm_00{frames}.obj")))
    };
    let farthest = |a: &BTreeMap<String, Mesh>, b: &BTreeMap<String, Mesh>| {
        let points = |m: &BTreeMap<String, Mesh>| m.values().flat_map(|m| m.positions.clone()).collect::<Vec<_>>();
        points(a).iter().zip(points(b)).map(|(p, q)| p.distance(q)).fold(0.0, f64::max)
    };
    let cpu = run("cpu", "25");
    let apart = farthest(&run("auto", "25"), &cpu);
    assert!(apart < 1e-5, "{apart} m");
    assert!(farthest(&run("cpu", "26"), &cpu) > 1e-4, "another frame must be seen");
}

#[test]
fn what_has_no_muscles_to_write_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out/frames");
    let refused = |meshes: &str, extra: &[&str], word: &str| {
        let meshes = folder.path().join("out").join(meshes);
        let output = bake(&out, &meshes, &[&["--device", "cpu", "--frames", "0"], extra].concat());
        let line = refusal(&output, 3);
        assert!(line.contains("--muscle-meshes") && line.contains(word), "{line}");
        assert!(names(folder.path()).is_empty(), "{:?}", names(folder.path()));
    };
    let muscles = muscles();
    refused("m", &[], "--muscles");
    refused("m", &["--muscles", &muscles, "--skinning", "linear"], "--skinning implicit");
    refused("m", &["--muscles", &muscles, "--skinning", "dual-quaternion"], "--skinning implicit");
    refused("m.abc", &["--muscles", &muscles], "NAME.obj");
    refused("frames/frame.obj", &["--muscles", &muscles], "frame_0000.obj");
    // The same command with nothing wrong is not refused.
    let good = ["--device", "cpu", "--frames", "0", "--muscles", &muscles];
    printed(&bake(&out, &out, &good));
    assert_eq!(names(&out), ["frame_0000.obj", "muscles_0000.obj"]);
}
