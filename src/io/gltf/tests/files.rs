//! The files of the data folder (`SINEW_DATA`): characters that must be read, and malformed files.

use crate::clip::{ClipChoice, Scene};
use crate::error::GltfError;
use crate::io::gltf::{Context, load, read};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

/// The data folder, or nothing with a word in the output where it is absent.
pub fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("SINEW_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("SINEW_DATA is not set: the files of the data folder are not tested");
    }
    folder
}

/// The glTF files under a folder, sorted.
fn gltf_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(gltf_files(&path));
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// Runs in a thread of its own: a panic or a minute without an answer is a failure.
fn in_time<T: Send + 'static>(path: &Path, work: impl FnOnce() -> T + Send + 'static) -> T {
    let (send, receive) = mpsc::channel();
    std::thread::spawn(move || drop(send.send(work())));
    match receive.recv_timeout(Duration::from_secs(60)) {
        Ok(result) => result,
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("{}: no answer in a minute", path.display()),
        Err(mpsc::RecvTimeoutError::Disconnected) => panic!("{}: the reader panicked", path.display()),
    }
}

/// Reads a file; a refusal must be one line that names it.
fn guarded(path: &Path) -> Result<Scene, GltfError> {
    let owned = path.to_owned();
    let result = in_time(path, move || read(&owned));
    if let Err(e) = &result {
        let (line, name) = (e.to_string(), path.file_name().unwrap().to_string_lossy().into_owned());
        assert!(!line.contains(['\n', '\r']) && line.contains(&name) && line.contains("; "), "{line}");
    }
    result
}

/// What every reader of a scene relies on.
fn check(scene: &Scene) {
    let character = &scene.character;
    let vertices = character.vertex_count();
    assert!(vertices > 0 && !character.materials.is_empty());
    assert_eq!([character.normals_rest.len(), character.uvs.len()], [vertices; 2]);
    assert!(character.normals_rest.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
    assert!(character.triangles.iter().flatten().all(|&c| (c as usize) < vertices));
    for vertex in 0..vertices {
        let shares = character.influences_of(vertex);
        assert!((shares.iter().map(|s| s.weight).sum::<f32>() - 1.0).abs() < 1e-5);
        assert!(shares.windows(2).all(|w| w[0].weight >= w[1].weight));
        assert!(shares.iter().all(|s| s.weight > 0.0 && (s.joint as usize) < character.joints.len()));
    }
    for (index, joint) in character.joints.iter().enumerate() {
        assert!(joint.parent.is_none_or(|p| (p as usize) < index));
    }
    let covered: usize = character.parts.iter().map(|p| p.vertices.len()).sum();
    assert_eq!(covered, vertices);
    let choices = [ClipChoice::Rest, ClipChoice::Default];
    for choice in choices.into_iter().chain((0..scene.clips.len()).map(ClipChoice::Clip)) {
        let pose = scene.pose(choice, scene.duration(choice) * 0.5);
        assert!(pose.palette.iter().chain(&pose.nodes).all(|m| m.is_finite()));
    }
}

#[test]
fn every_human_and_character_is_read() {
    let Some(data) = data() else { return };
    // Vertices, joints, clips and rigid parts, as the data's own list has them.
    let expected = [
        ("CesiumMan", 3273, 19, 1, 0),
        ("SimpleSkin", 10, 2, 1, 0),
        ("kaykit_Barbarian", 3342, 41, 76, 7),
        ("quad_skin", 4, 10, 0, 0),
        ("quaternius_robot", 7218, 43, 14, 0),
        ("unassigned-skeleton", 10, 3, 1, 0),
        ("arm_male_athletic_2172", 2172, 3, 2, 0),
        ("arm_nohand_dense_2172", 2172, 3, 2, 0),
        ("mh_male_athletic", 14517, 53, 5, 0),
        ("mh_male_athletic_cc1", 55784, 53, 2, 0),
        ("mh_male_average_default163", 14517, 163, 4, 0),
    ];
    let mut files = gltf_files(&data.join("humans"));
    files.extend(gltf_files(&data.join("characters")));
    for path in files {
        let scene = guarded(&path).unwrap_or_else(|e| panic!("{e}"));
        check(&scene);
        let c = &scene.character;
        let found = (c.vertex_count(), c.joints.len(), scene.clips.len(), scene.rigid.len());
        println!("{}: {found:?}, {} triangles, {} parts, {:?}", c.name, c.triangles.len(), c.parts.len(), scene.notes);
        if let Some(&(_, vertices, joints, clips, rigid)) = expected.iter().find(|e| e.0 == c.name) {
            assert_eq!(found, (vertices, joints, clips, rigid), "{}", c.name);
        }
    }
}

#[test]
fn malformed_files_are_read_or_refused_in_one_line() {
    let Some(data) = data() else { return };
    let table = std::fs::read_to_string(data.join("malformed/expected.csv")).unwrap();
    let files = gltf_files(&data.join("malformed"));
    assert!(files.len() > 70, "{}", files.len());
    let mut valid = 0;
    for path in &files {
        let name = path.strip_prefix(data.join("malformed")).unwrap().display().to_string();
        let row = table.lines().find(|row| row.starts_with(&format!("{name},"))).unwrap();
        let verdict = row.split(',').nth(4).unwrap();
        let result = guarded(path);
        match &result {
            Ok(scene) => println!("read    [{verdict}] {name} {:?}", scene.notes),
            Err(e) => println!("refused [{verdict}] {e}"),
        }
        if let Ok(scene) = &result {
            check(scene);
        }
        if verdict == "valid" {
            valid += 1;
            let allowed = match &result {
                Ok(_) | Err(GltfError::NoMesh { .. } | GltfError::NoSkin { .. }) => true,
                // It asks for glTF 2.1, which does not exist.
                Err(GltfError::Version { .. }) => name.ends_with("min_version_valid.gltf"),
                Err(_) => false,
            };
            assert!(allowed, "{name} is valid and was refused");
        }
    }
    assert!(valid > 10, "{valid}");
}

/// The file's JSON with a scene in which every mesh is skinned and every accessor stands in every place once, or nothing
/// where the file has no JSON text.
fn everything_used(bytes: &[u8]) -> Option<Value> {
    let mut value: Value = serde_json::from_slice(bytes).ok()?;
    let length = |value: &Value, key: &str| value.get(key).and_then(Value::as_array).map_or(0, Vec::len);
    let (nodes, meshes, accessors) = (length(&value, "nodes"), length(&value, "meshes"), length(&value, "accessors"));
    let append = |value: &mut Value, key: &str, new: Vec<Value>| match value.get_mut(key).and_then(Value::as_array_mut)
    {
        Some(array) => array.extend(new),
        None => value[key] = json!(new),
    };
    let primitives: Vec<Value> = (0..accessors)
        .flat_map(|a| {
            ["POSITION", "NORMAL", "TEXCOORD_0", "JOINTS_0", "WEIGHTS_0", "indices"].map(|place| {
                let mut primitive = json!({"attributes": {"POSITION": a}});
                match place {
                    "indices" => primitive["indices"] = json!(a),
                    _ => primitive["attributes"][place] = json!(a),
                }
                primitive
            })
        })
        .collect();
    append(&mut value, "meshes", primitives.into_iter().map(|p| json!({"primitives": [p]})).collect());
    append(&mut value, "skins", vec![json!({"joints": [nodes]})]);
    let skin = length(&value, "skins") - 1;
    let carriers = (0..length(&value, "meshes")).map(|mesh| json!({"mesh": mesh, "skin": skin}));
    append(&mut value, "nodes", std::iter::once(json!({})).chain(carriers).collect());
    let first = nodes + 1;
    value["scene"] = json!(0);
    value["scenes"] = json!([{"nodes": (nodes..first + meshes).collect::<Vec<_>>()}]);
    Some(value)
}

#[test]
fn malformed_accessors_are_survived_wherever_they_are_used() {
    let Some(data) = data() else { return };
    let mut tried = 0;
    for path in gltf_files(&data.join("malformed")) {
        let Some(mut value) = std::fs::read(&path).ok().and_then(|bytes| everything_used(&bytes)) else { continue };
        let (first, last) = (value["scenes"][0]["nodes"][0].as_u64(), value["nodes"].as_array().map_or(0, Vec::len));
        let Some(first) = first.filter(|_| value["asset"].is_object()) else { continue };
        // The file's own meshes at once, then one stand-in at a time: the first fault would hide the others.
        let alone = (first + 1..last as u64).map(|node| json!([first, node]));
        for nodes in std::iter::once(value["scenes"][0]["nodes"].clone()).chain(alone) {
            value["scenes"][0]["nodes"] = nodes;
            let text = serde_json::to_vec(&value).unwrap();
            let folder = path.parent().map(Path::to_owned);
            match in_time(&path, move || load(&text, folder.as_deref(), &Context::new("used".into()), "used")) {
                Ok(scene) => check(&scene),
                Err(e) => assert!(!e.to_string().contains(['\n', '\r']), "{e}"),
            }
            tried += 1;
        }
    }
    println!("{tried} uses of malformed elements");
    assert!(tried > 300, "{tried}");
}

#[test]
fn hostile_files_are_refused() {
    let Some(data) = data() else { return };
    let files = gltf_files(&data.join("malformed/tinygltf__security"));
    assert!(!files.is_empty());
    for path in files {
        let error = guarded(&path).map(|s| s.notes).expect_err("a hostile file was read");
        println!("{error}");
    }
}
