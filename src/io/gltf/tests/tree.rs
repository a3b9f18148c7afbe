//! Nodes, scenes, JSON oddities and what may be required.

use super::builder::Glb;
use crate::clip::ClipChoice;
use crate::error::GltfError;
use crate::io::gltf::{from_bytes, read};
use glam::Vec3;
use serde_json::json;

#[test]
fn loops_and_second_parents_are_refused() {
    let mut glb = Glb::square();
    glb.json["nodes"][2]["children"] = json!([1]);
    assert!(glb.refusal().contains("node 1 `lower`: its parents form a loop"), "{}", glb.refusal());
    let mut glb = Glb::square();
    glb.json["nodes"][2]["children"] = json!([2]);
    assert!(glb.refusal().contains("node 2 `upper`"), "{}", glb.refusal());
    let mut glb = Glb::square();
    glb.json["nodes"][0]["children"] = json!([2]);
    assert!(glb.refusal().contains("node 2 is its child, and a child of node 0 already"), "{}", glb.refusal());
}

#[test]
fn indices_that_point_at_nothing_are_refused_by_element() {
    let huge = 4_294_967_296u64; // becomes 0 where it is cut to 32 bits
    for index in [99, huge, u64::MAX] {
        for (pointer, element) in [
            ("/nodes/1/children/0", "node 1 `lower`"),
            ("/nodes/0/mesh", "node 0 `body`"),
            ("/nodes/0/skin", "node 0 `body`"),
            ("/skins/0/joints/1", "skin 0"),
            ("/skins/0/inverseBindMatrices", "skin 0"),
            ("/meshes/0/primitives/0/attributes/POSITION", "mesh 0 `square`, primitive 0"),
            ("/meshes/0/primitives/0/attributes/JOINTS_0", "JOINTS_0"),
            ("/meshes/0/primitives/0/indices", "primitive 0, indices"),
            ("/accessors/0/bufferView", "POSITION (accessor 0)"),
            ("/bufferViews/0/buffer", "POSITION (accessor 0)"),
            ("/scenes/0/nodes/0", "scene 0"),
            ("/scene", "scene"),
        ] {
            let mut glb = Glb::square();
            *glb.json.pointer_mut(pointer).unwrap() = json!(index);
            match glb.read() {
                Ok(_) => panic!("{pointer} = {index} was read"),
                // A primitive whose positions are nowhere shows nothing.
                Err(GltfError::NoMesh { .. }) if pointer.ends_with("POSITION") => {}
                Err(e) => assert!(e.to_string().contains(element), "{pointer}: {e}"),
            }
        }
    }
}

#[test]
fn only_the_scene_that_is_shown_counts() {
    let mut glb = Glb::square();
    glb.json["nodes"][1]["translation"] = json!([1, 2, 3]);
    let prop = glb.push("nodes", json!({"name": "prop", "mesh": 1, "translation": [0, 0, 1]}));
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1});
    glb.push("meshes", json!({"primitives": [primitive]}));
    assert_eq!(glb.read().unwrap().rigid.len(), 0);
    glb.json["nodes"][2]["children"] = json!([prop]);
    let scene = glb.read().unwrap();
    assert_eq!((scene.rigid.len(), scene.rigid[0].node, scene.rigid[0].triangles.len()), (1, prop as u32, 2));
    assert_eq!(scene.rigid[0].name, "mesh 1");
    // It hangs from the second joint: bound one up, and moved with the first joint in the file's own pose.
    let at = |choice| scene.pose(choice, 0.0).nodes[prop].transform_point3(Vec3::ZERO);
    assert_eq!(at(ClipChoice::Rest), Vec3::new(0.0, 1.0, 1.0));
    assert_eq!(at(ClipChoice::Default), Vec3::new(1.0, 3.0, 4.0));
    assert_eq!(scene.pose(ClipChoice::Default, 0.0).palette[1].transform_point3(Vec3::ZERO), Vec3::new(1.0, 2.0, 3.0));

    glb.json["scenes"] = json!([{"nodes": []}, {"nodes": [0, 1]}]);
    assert!(matches!(glb.read(), Err(GltfError::NoMesh { .. })));
    glb.json["scene"] = json!(1);
    assert!(glb.read().is_ok());
    glb.json.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scene"));
    assert!(glb.read().is_ok());
    glb.json["nodes"][0].as_object_mut().unwrap().remove("skin");
    assert!(matches!(glb.read(), Err(GltfError::NoSkin { .. })));
}

#[test]
fn what_is_not_read_cannot_make_a_file_unreadable() {
    let mut glb = Glb::square();
    glb.json["cameras"] = json!("no camera at all");
    glb.json["extensionsUsed"] = json!(["ACME_anything"]);
    glb.json["extensions"] = json!(17);
    glb.json["extras"] = json!([1, "2"]);
    glb.json["nodes"][0]["camera"] = json!(-4);
    glb.json["nodes"][0]["extensions"] = json!({"MSFT_lod": {"ids": [-1]}});
    glb.json["samplers"] = json!([{"wrapS": 3}]);
    glb.json["accessors"][0]["min"] = json!("nothing");
    glb.attributes()["COLOR_x"] = json!(88);
    glb.attributes()["TANGENT"] = json!("none");
    glb.attributes()["_ID"] = json!(-1);
    glb.json["meshes"][0]["weights"] = json!("none");
    assert_eq!(glb.read().unwrap().notes, Vec::<String>::new());
    // Whole numbers may be written as decimals.
    glb.json["nodes"][0]["mesh"] = json!(0.0);
    glb.json["accessors"][0]["count"] = json!(4.0);
    assert!(glb.read().is_ok());
}

#[test]
fn wrong_types_are_refused_by_element() {
    for (pointer, value, expected) in [
        ("/nodes/1", json!({"children": 4}), "nodes[1]: "),
        ("/nodes", json!({"0": {}}), "nodes: an array is needed"),
        ("/bufferViews/0", json!({"buffer": 0, "byteLength": 4, "byteStride": -1}), "bufferViews[0]: "),
        ("/accessors/1", json!({"count": -3, "type": "SCALAR", "componentType": 5121}), "accessors[1]: "),
        ("/accessors/0/type", json!("VEC9"), "POSITION (accessor 0): its type is unknown"),
        ("/accessors/0/type", json!("VEC2"), "it is Vec2 where [Vec3] is needed"),
        ("/accessors/0/componentType", json!(5130), "its componentType is unknown"),
        ("/skins/0/joints", json!([]), "skin 0: it has no joints"),
        ("/nodes/1", json!({"translation": [1e300, 0, 0], "children": [2]}), "its transform is not a finite number"),
    ] {
        let mut glb = Glb::square();
        *glb.json.pointer_mut(pointer).unwrap() = value;
        assert!(glb.refusal().contains(expected), "{expected}: {}", glb.refusal());
    }
}

#[test]
fn versions_and_required_extensions() {
    for (version, least, read) in [
        ("2.0", None, true),
        ("2.7", Some("2.0"), true),
        ("2.1", Some("2.1"), false),
        ("1.0", None, false),
        ("2", None, false),
    ] {
        let mut glb = Glb::square();
        glb.json["asset"] = json!({"version": version, "minVersion": least});
        assert_eq!(!matches!(glb.read(), Err(GltfError::Version { .. })), read, "{version} {least:?}");
    }
    for (name, read) in [
        ("KHR_mesh_quantization", true),
        ("KHR_materials_unlit", true),
        ("KHR_texture_transform", true),
        ("SINEW_muscles", true),
        ("KHR_draco_mesh_compression", false),
        ("EXT_meshopt_compression", false),
        ("ACME_curves\nand more", false),
    ] {
        let mut glb = Glb::square();
        glb.json["extensionsRequired"] = json!([name]);
        match read {
            true => assert!(glb.read().is_ok(), "{name}"),
            false => assert!(glb.refusal().contains("requires the extension"), "{}", glb.refusal()),
        }
    }
}

#[test]
fn a_file_cut_anywhere_is_refused_in_one_line() {
    let bytes = Glb::square().bytes();
    for length in 0..bytes.len() {
        let line = from_bytes(&bytes[..length], "cut.glb").expect_err("a cut file was read").to_string();
        assert!(line.starts_with("cut.glb: ") && !line.contains('\n'), "{length}: {line}");
    }
    let line = from_bytes(&bytes[..bytes.len() - 5], "cut.glb").unwrap_err().to_string();
    assert!(line.contains("its header promises"), "{line}");
}

#[test]
fn buffers_beside_the_file_are_read_and_nothing_outside_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("model");
    std::fs::create_dir_all(inside.join("sub dir")).unwrap();
    let mut glb = Glb::square();
    for path in ["secret.bin", "model/own.bin", "model/sub dir/own.bin"] {
        std::fs::write(folder.path().join(path), &glb.bin).unwrap();
    }
    let absolute = folder.path().join("secret.bin").display().to_string();
    let outcomes = [
        ("own.bin", true),
        ("sub%20dir/own.bin", true),
        ("sub%20dir/../own.bin", true),
        ("../secret.bin", false),
        ("%2E%2E/secret.bin", false),
        (absolute.as_str(), false),
        ("sub%20dir", false),
        ("absent.bin", false),
    ];
    for (uri, readable) in outcomes {
        glb.json["buffers"][0] = json!({"byteLength": glb.bin.len(), "uri": uri});
        let path = inside.join("model.gltf");
        std::fs::write(&path, serde_json::to_vec(&glb.json).unwrap()).unwrap();
        match read(&path) {
            Ok(scene) => assert!(readable && scene.character.name == "model", "{uri}"),
            Err(e) => assert!(!readable && matches!(e, GltfError::Buffer { .. }), "{e}"),
        }
        // From memory there is no folder.
        assert!(from_bytes(&serde_json::to_vec(&glb.json).unwrap(), "memory").is_err());
    }
    glb.json["buffers"][0] = json!({"byteLength": glb.bin.len() + 1, "uri": "own.bin"});
    let path = inside.join("short.gltf");
    std::fs::write(&path, serde_json::to_vec(&glb.json).unwrap()).unwrap();
    let line = read(&path).unwrap_err().to_string();
    assert!(line.contains("buffer 0: it declares") && !line.contains('\n'), "{line}");
    assert!(matches!(read(&inside), Err(GltfError::Unreadable { .. })));
    assert!(matches!(read(&inside.join("absent.glb")), Err(GltfError::Unreadable { .. })));
}
