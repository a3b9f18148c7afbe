//! Surfaces: topology, accessors, quantisation, normals, textures.

use super::builder::{F32, Glb, I8, I16, U8, U16, U32, floats, shorts};
use glam::{Vec2, Vec3};
use serde_json::json;

const FIVE: [f32; 15] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.5, 2.0, 0.0];

/// The square's mesh replaced by five points without weights, drawn in `mode`.
fn five(mode: u32, indices: Option<&[u16]>) -> Glb {
    let mut glb = Glb::square();
    let position = glb.accessor(F32, "VEC3", &floats(&FIVE));
    let mut primitive = json!({"attributes": {"POSITION": position}, "mode": mode});
    if let Some(indices) = indices {
        primitive["indices"] = json!(glb.accessor(U16, "SCALAR", &shorts(indices)));
    }
    glb.json["meshes"][0]["primitives"] = json!([primitive]);
    glb
}

fn triangles(glb: &Glb) -> Vec<[u32; 3]> {
    glb.read().unwrap().character.triangles
}

#[test]
fn lists_strips_and_fans_with_and_without_indices() {
    assert_eq!(triangles(&five(4, None)), [[0, 1, 2]]);
    assert_eq!(triangles(&five(4, Some(&[4, 3, 2, 0, 1, 2]))), [[4, 3, 2], [0, 1, 2]]);
    // Every second triangle of a strip is turned, so that all face the same way.
    assert_eq!(triangles(&five(5, None)), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    assert_eq!(triangles(&five(5, Some(&[0, 1, 2, 3]))), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(triangles(&five(6, None)), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
    assert_eq!(triangles(&five(6, Some(&[4, 3, 2, 1]))), [[3, 2, 4], [2, 1, 4]]);
}

#[test]
fn degenerate_indices_and_leftover_corners_are_left_out_and_noted() {
    let scene = five(4, Some(&[0, 1, 2, 2, 2, 3, 0, 1])).read().unwrap();
    assert_eq!(scene.character.triangles, [[0, 1, 2]]);
    assert!(scene.notes.iter().any(|n| n.contains("1 triangles use a vertex twice")), "{:?}", scene.notes);
    assert!(scene.notes.iter().any(|n| n.contains("2 corners are left over")), "{:?}", scene.notes);
}

#[test]
fn points_and_lines_are_skipped_with_a_note() {
    let mut glb = Glb::square();
    let mut lines = glb.json["meshes"][0]["primitives"][0].clone();
    lines["mode"] = json!(1);
    glb.json["meshes"][0]["primitives"].as_array_mut().unwrap().insert(0, lines);
    let scene = glb.read().unwrap();
    assert_eq!((scene.character.vertex_count(), scene.character.triangles.len()), (4, 2));
    assert_eq!(scene.character.parts[0].name, "square #1");
    assert!(scene.notes[0].contains("mesh 0 `square`, primitive 0: Lines are not shown"), "{:?}", scene.notes);
    assert!(five(0, None).refusal().contains("no mesh with triangles"));
}

#[test]
fn an_index_past_the_vertices_is_refused_by_place() {
    let line = five(4, Some(&[0, 1, 9])).refusal();
    assert!(line.contains("mesh 0 `square`, primitive 0: index 2 is 9, and there are 5 vertices"), "{line}");
}

#[test]
fn a_sparse_accessor_replaces_elements_of_its_base_or_of_zeros() {
    for base in [true, false] {
        let mut glb = five(4, None);
        let (indices, values) = (glb.view(&[1, 4]), glb.view(&floats(&[7.0, 8.0, 9.0, -1.0, -2.0, -3.0])));
        let accessor = glb.attributes()["POSITION"].as_u64().unwrap() as usize;
        glb.json["accessors"][accessor]["sparse"] = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values}
        });
        if !base {
            glb.json["accessors"][accessor].as_object_mut().unwrap().remove("bufferView");
        }
        let mut expected: Vec<Vec3> = FIVE.chunks_exact(3).map(Vec3::from_slice).collect();
        if !base {
            expected.fill(Vec3::ZERO);
        }
        (expected[1], expected[4]) = (Vec3::new(7.0, 8.0, 9.0), Vec3::new(-1.0, -2.0, -3.0));
        assert_eq!(glb.read().unwrap().character.positions_rest, expected);

        glb.bin[glb.json["bufferViews"][indices]["byteOffset"].as_u64().unwrap() as usize] = 5;
        assert!(glb.refusal().contains("replaces element 5 of 5"), "{}", glb.refusal());
    }
}

#[test]
fn stride_and_offsets_are_honoured() {
    let mut glb = five(4, None);
    // Position and normal of a vertex side by side.
    let interleaved: Vec<f32> = FIVE.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 0.0, 0.0, 2.0]).collect();
    let view = glb.view(&floats(&interleaved));
    glb.json["bufferViews"][view]["byteStride"] = json!(24);
    let accessor = |offset: u32| json!({"bufferView": view, "byteOffset": offset, "componentType": F32, "type": "VEC3", "count": 5});
    let (position, normal) = (glb.push("accessors", accessor(0)), glb.push("accessors", accessor(12)));
    *glb.attributes() = json!({"POSITION": position, "NORMAL": normal});
    let character = glb.read().unwrap().character;
    assert_eq!(character.positions_rest[3], Vec3::new(1.0, 1.0, 0.0));
    assert!(character.normals_rest.iter().all(|n| *n == Vec3::Z), "{:?}", character.normals_rest);
    // One element more than the view holds.
    glb.json["accessors"][position]["count"] = json!(6);
    assert!(glb.refusal().contains("6 elements end at byte 132 of a view of 120 bytes"), "{}", glb.refusal());
}

#[test]
fn quantised_attributes_of_every_type_are_dequantised() {
    let corners = |scale: f32| -> Vec<f32> { FIVE.iter().map(|v| v * scale).collect() };
    type Store = fn(&mut Glb, &[f32]) -> usize;
    let stores: [(Store, f32, f32); 5] = [
        (|g, v| g.accessor(I8, "VEC3", &v.iter().map(|&v| v as i8 as u8).collect::<Vec<_>>()), 10.0, 10.0),
        (
            |g, v| g.accessor(I16, "VEC3", &shorts(&v.iter().map(|&v| v as i16 as u16).collect::<Vec<_>>())),
            100.0,
            100.0,
        ),
        (|g, v| g.accessor(U16, "VEC3", &shorts(&v.iter().map(|&v| v as u16).collect::<Vec<_>>())), 1000.0, 1000.0),
        (|g, v| g.normalised(U8, "VEC3", &v.iter().map(|&v| v as u8).collect::<Vec<_>>()), 100.0, 100.0 / 255.0),
        (
            |g, v| g.normalised(I16, "VEC3", &shorts(&v.iter().map(|&v| v as i16 as u16).collect::<Vec<_>>())),
            16000.0,
            16000.0 / 32767.0,
        ),
    ];
    for (store, stored, read) in stores {
        let mut glb = five(4, None);
        glb.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        glb.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        let position = store(&mut glb, &corners(stored));
        let normal = glb.normalised(I8, "VEC3", &[0, 0, 127].repeat(5));
        let uv = glb.normalised(U16, "VEC2", &shorts(&[65535, 0, 0, 65535, 13107, 52428, 0, 0, 0, 0]));
        *glb.attributes() = json!({"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv});
        let character = glb.read().unwrap().character;
        for (got, want) in character.positions_rest.iter().zip(corners(read).chunks_exact(3)) {
            // One rounding of a division.
            assert!((*got - Vec3::from_slice(want)).abs().max_element() <= 1e-6 * read * 2.0, "{got} {want:?}");
        }
        assert_eq!(character.normals_rest[0], Vec3::Z);
        assert_eq!(character.uvs[..3], [Vec2::X, Vec2::Y, Vec2::new(0.2, 0.8)]);
    }
    // Signed integers reach -1 twice.
    let mut glb = five(4, None);
    let position = glb.normalised(I8, "VEC3", &[0x80, 0x81, 0x7f].repeat(5));
    *glb.attributes() = json!({"POSITION": position});
    assert_eq!(glb.read().unwrap().character.positions_rest[0], Vec3::new(-1.0, -1.0, 1.0));
}

#[test]
fn missing_normals_are_area_weighted_across_seams() {
    // A roof of two triangles that share an edge by position only, the second twice as large as the first.
    let corners = [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0], // faces +y with area 1/2
        [0.0, 0.0, 0.0],
        [0.0, 2.0, 0.0],
        [0.0, 0.0, 1.0], // faces +x with area 1
    ];
    let mut glb = five(4, None);
    let position = glb.accessor(F32, "VEC3", &floats(&corners.concat()));
    *glb.attributes() = json!({"POSITION": position});
    let normals = glb.read().unwrap().character.normals_rest;
    let shared = Vec3::new(2.0, 1.0, 0.0).normalize();
    for (vertex, expected) in [(0, shared), (1, shared), (2, Vec3::Y), (3, shared), (4, Vec3::X), (5, shared)] {
        assert!((normals[vertex] - expected).length() < 1e-6, "{vertex}: {}", normals[vertex]);
    }
}

#[test]
fn normals_without_a_direction_are_replaced_and_noted() {
    let mut glb = five(4, None);
    let normal = glb.accessor(
        F32,
        "VEC3",
        &floats(&[[0.0, 3.0, 4.0], [0.0; 3], [f32::NAN, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]].concat()),
    );
    glb.attributes()["NORMAL"] = json!(normal);
    let scene = glb.read().unwrap();
    let expected = [Vec3::new(0.0, 0.6, 0.8), Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Z];
    for (got, want) in scene.character.normals_rest.iter().zip(expected) {
        assert!((*got - want).length() < 1e-6, "{got} {want}");
    }
    assert!(scene.notes.iter().any(|n| n.contains("2 normals have no direction")), "{:?}", scene.notes);
}

#[test]
fn numbers_that_are_not_finite_are_refused_by_vertex() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut glb = five(4, None);
        let mut corners = FIVE;
        corners[3 * 3 + 1] = bad;
        let position = glb.accessor(F32, "VEC3", &floats(&corners));
        *glb.attributes() = json!({"POSITION": position});
        let line = glb.refusal();
        assert!(
            line.contains("mesh 0 `square`, primitive 0: the position of vertex 3 is not a finite number"),
            "{line}"
        );
    }
}

#[test]
fn attributes_must_go_with_the_positions() {
    let mut glb = five(4, None);
    glb.attributes()["NORMAL"] = json!(glb.clone().attributes()["POSITION"]);
    let short = glb.accessor(F32, "VEC2", &floats(&[0.0; 8]));
    glb.attributes()["TEXCOORD_0"] = json!(short);
    assert!(glb.refusal().contains("TEXCOORD_0 has 4 elements and POSITION has 5"), "{}", glb.refusal());
    let mut glb = five(4, None);
    let wide = glb.accessor(U32, "VEC3", &[0; 60]);
    glb.attributes()["POSITION"] = json!(wide);
    assert!(glb.refusal().contains("32-bit integers cannot be used here"));
}

/// A PNG of `width` x `height` red pixels.
fn png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let picture = image::RgbImage::from_pixel(width, height, image::Rgb([255, 0, 0]));
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn textured(image: &[u8]) -> Glb {
    let mut glb = five(4, None);
    let view = glb.view(image);
    glb.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    glb.json["textures"] = json!([{"source": 0, "sampler": 77}]);
    glb.json["materials"] = json!([{"name": "skin", "doubleSided": true, "normalTexture": {"index": 99},
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 0.25, 1], "baseColorTexture": {"index": 0}}}]);
    glb.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    glb
}

#[test]
fn base_colours_and_textures_are_read() {
    let character = textured(&png(3, 2)).read().unwrap().character;
    let material = &character.materials[character.parts[0].material as usize];
    assert_eq!((material.name.as_str(), material.base_color), ("skin", [0.5, 1.0, 0.25, 1.0]));
    assert_eq!((material.texture, material.double_sided), (Some(0), true));
    let image = &character.images[0];
    assert_eq!((image.width, image.height, &image.rgba[..4]), (3, 2, &[255, 0, 0, 255][..]));
}

/// The checksum of a PNG chunk.
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { 0xEDB8_8320 ^ (crc >> 1) } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), |crc, _| step(crc)))
}

#[test]
fn a_texture_that_cannot_be_read_is_noted_and_left_out() {
    let mut truncated = png(64, 64);
    truncated.truncate(60);
    // A header that promises 100,000 x 100,000 pixels, with the checksum that goes with it.
    let mut bomb = png(3, 2);
    bomb[16..24].copy_from_slice(&[0, 1, 134, 160, 0, 1, 134, 160]);
    let checksum = crc(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&checksum.to_be_bytes());
    let scene = textured(&bomb).read().unwrap();
    let by_size = |note: &String| note.starts_with("image 0: 100000 x 100000 pixels are more than");
    assert!(scene.notes.iter().any(by_size), "{:?}", scene.notes);
    for bytes in [truncated, bomb, b"no picture".to_vec(), png(8193, 1)] {
        let scene = textured(&bytes).read().unwrap();
        assert_eq!(scene.character.materials[0].texture, None);
        assert!(scene.character.images.is_empty());
        assert!(scene.notes.iter().any(|n| n.starts_with("image 0: ")), "{:?}", scene.notes);
    }
}
