//! Influences and the merging of skins.

use super::builder::{F32, Glb, U8, U16, U32, floats, shorts};
use crate::rig::Character;
use glam::{Mat4, Vec3};
use serde_json::json;

fn shares(character: &Character, vertex: usize) -> Vec<(u32, f32)> {
    character.influences_of(vertex).iter().map(|i| (i.joint, i.weight)).collect()
}

/// The square with `count` joints in a chain under node 1, and no influences.
fn chain(count: usize) -> Glb {
    let mut glb = Glb::square();
    for node in 2..count {
        glb.json["nodes"][node]["children"] = json!([node + 1]);
        glb.push("nodes", json!({"translation": [0, 1, 0]}));
    }
    glb.json["skins"] = json!([{"joints": (1..=count).collect::<Vec<_>>()}]);
    glb.attributes().as_object_mut().unwrap().retain(|key, _| key == "POSITION");
    glb
}

#[test]
fn every_component_type_says_the_same() {
    let joints: [u8; 16] = [0, 1, 0, 0, 1, 0, 0, 0, 2, 1, 0, 0, 0, 0, 0, 0];
    let weights: [f32; 16] = [0.8, 0.2, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.4, 0.6, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    for joint_type in [U8, U16, U32] {
        for (weight_type, full) in [(F32, 1.0f32), (U8, 255.0), (U16, 65535.0)] {
            let mut glb = chain(3);
            let stored: Vec<u8> = match joint_type {
                U8 => joints.to_vec(),
                U16 => shorts(&joints.map(u16::from)),
                _ => joints.iter().flat_map(|&j| u32::from(j).to_le_bytes()).collect(),
            };
            let joints = glb.accessor(joint_type, "VEC4", &stored);
            let scaled = weights.map(|w| w * full);
            let weights = match weight_type {
                F32 => glb.accessor(F32, "VEC4", &floats(&scaled)),
                U8 => glb.normalised(U8, "VEC4", &scaled.map(|w| w as u8)),
                _ => glb.normalised(U16, "VEC4", &shorts(&scaled.map(|w| w as u16))),
            };
            glb.attributes()["JOINTS_0"] = json!(joints);
            glb.attributes()["WEIGHTS_0"] = json!(weights);
            let scene = glb.read().unwrap();
            let expected: [&[(u32, f32)]; 4] = [&[(0, 0.8), (1, 0.2)], &[(1, 1.0)], &[(1, 0.6), (2, 0.4)], &[(0, 1.0)]];
            for (vertex, expected) in expected.iter().enumerate() {
                let got = shares(&scene.character, vertex);
                assert_eq!(got.len(), expected.len());
                for (got, want) in got.iter().zip(*expected) {
                    // 0.8, 0.2, 0.6 and 0.4 are whole numbers of 255ths and 65535ths.
                    assert!(got.0 == want.0 && (got.1 - want.1).abs() < 1e-6, "{got:?} {want:?}");
                }
            }
            assert_eq!(scene.notes, Vec::<String>::new());
        }
    }
}

#[test]
fn several_sets_are_one_list_strongest_first_with_equals_by_joint() {
    let mut glb = chain(12);
    for (set, joints, weights) in [
        (0, [3, 0, 5, 1], [0.05, 0.1, 0.2, 0.05]),
        (1, [2, 4, 3, 0], [0.1, 0.1, 0.05, 0.0]),
        (2, [9, 11, 10, 8], [0.05, 0.25, 0.05, 0.0]),
    ] {
        let joints = glb.accessor(U8, "VEC4", &joints.repeat(4));
        let weights = glb.accessor(F32, "VEC4", &floats(&weights.repeat(4)));
        glb.attributes()[format!("JOINTS_{set}")] = json!(joints);
        glb.attributes()[format!("WEIGHTS_{set}")] = json!(weights);
    }
    let character = glb.read().unwrap().character;
    let expected = [(11, 0.25), (5, 0.2), (0, 0.1), (2, 0.1), (3, 0.1), (4, 0.1), (1, 0.05), (9, 0.05), (10, 0.05)];
    for vertex in 0..4 {
        let got = shares(&character, vertex);
        assert_eq!(got.iter().map(|s| s.0).collect::<Vec<_>>(), expected.map(|s| s.0), "{got:?}");
        for (got, want) in got.iter().zip(expected) {
            assert!((got.1 - want.1).abs() < 1e-6, "{got:?} {want:?}");
        }
    }
}

#[test]
fn sums_that_are_off_are_normalised_and_counted() {
    let mut glb = Glb::square();
    let rows = [[0.5, 0.0, 0.0, 0.0], [1.0005, 0.0, 0.0, 0.0], [1.5, 0.5, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]];
    let weights = glb.accessor(F32, "VEC4", &floats(&rows.concat()));
    glb.attributes()["WEIGHTS_0"] = json!(weights);
    let scene = glb.read().unwrap();
    assert_eq!(shares(&scene.character, 0), [(0, 1.0)]);
    assert_eq!(shares(&scene.character, 1), [(0, 1.0)]);
    assert_eq!(shares(&scene.character, 2), [(1, 0.75), (0, 0.25)]);
    assert_eq!(scene.notes.len(), 1);
    assert!(
        scene.notes[0].contains("the weights of 2 of 4 vertices do not add up to 1 (the worst to 2.0000)"),
        "{:?}",
        scene.notes
    );
}

#[test]
fn joints_named_twice_in_a_vertex_are_one() {
    let mut glb = Glb::square();
    let joints = glb.accessor(U8, "VEC4", &[0, 1, 0, 1].repeat(4));
    let weights = glb.accessor(F32, "VEC4", &floats(&[0.25, 0.25, 0.375, 0.125].repeat(4)));
    glb.attributes()["JOINTS_0"] = json!(joints);
    glb.attributes()["WEIGHTS_0"] = json!(weights);
    assert_eq!(shares(&glb.read().unwrap().character, 2), [(0, 0.625), (1, 0.375)]);
}

#[test]
fn vertices_without_weight_follow_the_first_joint_with_a_note() {
    let mut glb = Glb::square();
    let mut rows = [1.0, 0.0, 0.0, 0.0].repeat(4);
    rows[12] = 0.0;
    let weights = glb.accessor(F32, "VEC4", &floats(&rows));
    glb.attributes()["WEIGHTS_0"] = json!(weights);
    let scene = glb.read().unwrap();
    assert_eq!(shares(&scene.character, 3), [(0, 1.0)]);
    assert!(scene.notes[0].contains("1 of 4 vertices have no weight"), "{:?}", scene.notes);
    let scene = chain(3).read().unwrap();
    assert!(scene.notes[0].contains("4 of 4 vertices have no weight"), "{:?}", scene.notes);
}

#[test]
fn impossible_influences_are_refused_by_vertex() {
    let cases = [
        ([7, 0, 0, 0], [1.0, 0.0, 0.0, 0.0], "primitive 0: vertex 0 uses joint 7, and the skin has 2 joints"),
        ([0, 1, 0, 0], [f32::NAN, 1.0, 0.0, 0.0], "the weight of vertex 0 for joint 0 is not a finite number"),
        ([0, 1, 0, 0], [1.5, -0.5, 0.0, 0.0], "vertex 0 has the negative weight -0.5 for joint 1"),
    ];
    for (joints, weights, expected) in cases {
        let mut glb = Glb::square();
        let joints = glb.accessor(U8, "VEC4", &joints.repeat(4));
        let weights = glb.accessor(F32, "VEC4", &floats(&weights.repeat(4)));
        glb.attributes()["JOINTS_0"] = json!(joints);
        glb.attributes()["WEIGHTS_0"] = json!(weights);
        assert!(glb.refusal().contains(expected), "{}", glb.refusal());
    }
    // Zero weights may name anything: exporters leave it there.
    let mut glb = Glb::square();
    let joints = glb.accessor(U8, "VEC4", &[0, 200, 0, 0].repeat(4));
    glb.attributes()["JOINTS_0"] = json!(joints);
    assert_eq!(shares(&glb.read().unwrap().character, 2), [(0, 1.0)]);
    let mut glb = Glb::square();
    glb.attributes().as_object_mut().unwrap().remove("WEIGHTS_0");
    assert!(glb.refusal().contains("has no WEIGHTS_0"), "{}", glb.refusal());
}

#[test]
fn inverse_bind_matrices_may_be_missing_but_not_too_few_or_broken() {
    let mut glb = Glb::square();
    glb.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    assert!(glb.read().unwrap().character.joints.iter().all(|j| j.inverse_bind == Mat4::IDENTITY));

    let mut glb = Glb::square();
    glb.json["accessors"][4]["count"] = json!(1);
    assert!(glb.refusal().contains("it has 2 joints and 1 inverse bind matrices"), "{}", glb.refusal());

    let mut nan = Mat4::IDENTITY;
    nan.x_axis.x = f32::NAN;
    let flat = Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let mut projective = Mat4::IDENTITY;
    projective.y_axis.w = 0.5;
    for (broken, why) in [(nan, "is not finite"), (flat, "flattens space"), (projective, "row 0 0 0 1")] {
        let mut glb = Glb::square();
        let both = [broken.to_cols_array(), Mat4::IDENTITY.to_cols_array()].concat();
        glb.json["skins"][0]["inverseBindMatrices"] = json!(glb.accessor(F32, "MAT4", &floats(&both)));
        let line = glb.refusal();
        assert!(line.contains("vertex 0 follows joint 0, whose inverse bind matrix") && line.contains(why), "{line}");
        // A joint that moves nothing may have any matrix.
        let joints = glb.accessor(U8, "VEC4", &[1, 0, 0, 0].repeat(4));
        glb.attributes()["JOINTS_0"] = json!(joints);
        let scene = glb.read().unwrap();
        assert!(scene.notes[0].contains("skin 0, joint 0 `lower`: its inverse bind matrix"), "{:?}", scene.notes);
        assert!(scene.character.joints.iter().all(|j| j.bind().is_finite()));
    }
}

#[test]
fn joints_are_put_parents_first_and_influences_follow() {
    let mut glb = Glb::square();
    // The skin lists the child first; binds go with the joints.
    glb.json["skins"][0] = json!({"joints": [2, 1]});
    let character = glb.read().unwrap().character;
    assert_eq!(character.joints.iter().map(|j| (j.node, j.parent)).collect::<Vec<_>>(), [(1, None), (2, Some(0))]);
    assert_eq!(shares(&character, 0), [(1, 1.0)]);
    assert_eq!(shares(&character, 2), [(0, 1.0)]);
}

#[test]
fn skins_that_share_a_joint_share_it_unless_they_bind_it_differently() {
    let mut glb = Glb::square();
    let binds: Vec<f32> =
        [Mat4::IDENTITY, Mat4::from_translation(Vec3::X)].iter().flat_map(Mat4::to_cols_array).collect();
    let other = glb.accessor(F32, "MAT4", &floats(&binds));
    glb.push("skins", json!({"joints": [1, 2], "inverseBindMatrices": other}));
    let second = glb.push("nodes", json!({"mesh": 0, "skin": 1, "translation": [5, 5, 5]}));
    glb.json["scenes"][0]["nodes"] = json!([second, 1, 0]);
    let character = glb.read().unwrap().character;
    // Node 1 is bound alike in both skins, node 2 is not.
    assert_eq!(
        character.joints.iter().map(|j| (j.node, j.parent)).collect::<Vec<_>>(),
        [(1, None), (2, Some(0)), (2, Some(0))]
    );
    assert_eq!(character.vertex_count(), 8);
    assert_eq!(
        character.parts.iter().map(|p| (p.node, p.vertices.clone())).collect::<Vec<_>>(),
        [(0, 0..4), (3, 4..8)]
    );
    assert_eq!(shares(&character, 2), [(1, 1.0)]);
    assert_eq!(shares(&character, 6), [(2, 1.0)]);
    assert_eq!(character.triangles[2..], [[4, 5, 6], [6, 5, 7]]);
    // The skinned node's own transform is ignored.
    assert_eq!(character.positions_rest[4], Vec3::ZERO);
}

#[test]
fn painted_muscle_weights_are_read_part_by_part() {
    let mut glb = Glb::square();
    let weights = glb.accessor(F32, "SCALAR", &floats(&[0.0, 0.25, 1.0005, -0.0005]));
    let bytes = glb.normalised(U8, "SCALAR", &[255, 0, 51, 0]);
    glb.attributes()["_MUSCLE_2"] = json!(weights);
    glb.attributes()["_MUSCLE_0"] = json!(bytes);
    glb.attributes()["_MUSCLE_x"] = json!(weights);
    let painted = glb.read().unwrap().character.painted;
    assert_eq!(painted.iter().map(|p| (p.muscle, p.vertices.clone())).collect::<Vec<_>>(), [(0, 0..4), (2, 0..4)]);
    assert_eq!(
        (&painted[0].weights[..], &painted[1].weights[..]),
        (&[1.0, 0.0, 0.2, 0.0][..], &[0.0, 0.25, 1.0, 0.0][..])
    );
    assert_eq!(Glb::square().read().unwrap().character.painted, []);
    let cases = [
        ([0.0, f32::NAN, 0.0, 0.0].to_vec(), "_MUSCLE_1 of vertex 1 is not a finite number"),
        ([0.0, 0.0, 0.0, 1.5].to_vec(), "_MUSCLE_1 of vertex 3 is 1.5"),
        (vec![0.5; 3], "_MUSCLE_1 has 3 elements and POSITION has 4"),
    ];
    for (weights, expected) in cases {
        let mut glb = Glb::square();
        let weights = glb.accessor(F32, "SCALAR", &floats(&weights));
        glb.attributes()["_MUSCLE_1"] = json!(weights);
        assert!(glb.refusal().contains(expected), "{}", glb.refusal());
    }
}
