//! Sampling against values worked out by hand.

use super::builder::{F32, Glb, I8, I16, U8, U16, floats, shorts};
use crate::clip::{ClipChoice, Scene};
use crate::error::ClipError;
use glam::{Mat4, Quat, Vec3};
use serde_json::json;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2};

/// Where node 1 is in clip 0.
fn node(scene: &Scene, time: f32) -> Mat4 {
    scene.pose(ClipChoice::Clip(0), time).nodes[1]
}

fn close(a: Mat4, b: Mat4) -> bool {
    // Values are around 1 and rounded to f32 once.
    (a - b).abs_diff_eq(Mat4::ZERO, 1e-6)
}

#[test]
fn translations_step_go_straight_and_clamp() {
    let values = [0.0, 0.0, 0.0, 4.0, 8.0, 0.0, 4.0, 8.0, 2.0];
    for (interpolation, expected) in [("LINEAR", Vec3::new(1.0, 2.0, 0.0)), ("STEP", Vec3::ZERO)] {
        let mut glb = Glb::square();
        glb.animate(1, "translation", interpolation, &[2.0, 4.0, 5.0], &values);
        let scene = glb.read().unwrap();
        let at = |time| node(&scene, time).w_axis.truncate();
        // Times count from the first key.
        assert_eq!(at(0.0), Vec3::ZERO);
        assert_eq!(at(-3.0), Vec3::ZERO);
        assert_eq!(at(0.5), expected);
        assert_eq!(at(2.0), Vec3::new(4.0, 8.0, 0.0));
        assert_eq!(at(3.0), Vec3::new(4.0, 8.0, 2.0));
        assert_eq!(at(99.0), Vec3::new(4.0, 8.0, 2.0));
        assert_eq!(at(f32::NAN), Vec3::ZERO);
        assert_eq!((scene.clips[0].start, scene.clips[0].end, scene.duration(ClipChoice::Clip(0))), (2.0, 5.0, 3.0));
    }
}

#[test]
fn rotations_take_the_shorter_way_at_constant_speed() {
    let quarter = Quat::from_rotation_z(FRAC_PI_2);
    // The same rotation with the other sign would be three quarters of a turn away.
    let values = [Quat::IDENTITY, -quarter].map(|q| q.to_array()).concat();
    let mut glb = Glb::square();
    glb.animate(1, "rotation", "LINEAR", &[0.0, 1.0], &values);
    let scene = glb.read().unwrap();
    for step in 0..=4 {
        let share = step as f32 / 4.0;
        let expected = Mat4::from_rotation_z(FRAC_PI_2 * share);
        assert!(close(node(&scene, share), expected), "{share}: {}", node(&scene, share));
    }
    // Not straight between the components: a chord would be off by more than the tolerance.
    let chord = Mat4::from_quat(Quat::from_vec4((glam::Vec4::W * 0.75 + glam::Vec4::from(quarter) * 0.25).normalize()));
    assert!(!close(node(&scene, 0.25), chord));
}

#[test]
fn cubic_splines_follow_the_specification() {
    // Per key in-tangent, value, out-tangent; two seconds between the keys.
    let values = [[9.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 2.0], [0.0, 3.0, 0.0], [2.0, 0.0, 0.0], [9.0; 3]].concat();
    let mut glb = Glb::square();
    glb.animate(1, "scale", "CUBICSPLINE", &[1.0, 3.0], &values);
    let scene = glb.read().unwrap();
    let at = |time| {
        let m = node(&scene, time);
        Vec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z)
    };
    assert_eq!(at(0.0), Vec3::new(1.0, 0.0, 0.0));
    assert_eq!(at(2.0), Vec3::new(2.0, 0.0, 0.0));
    // Half way: (p0 + p1) / 2 + seconds * (m0 - m1) / 8.
    assert!((at(1.0) - Vec3::new(1.75, -0.75, 0.5)).length() < 1e-6, "{}", at(1.0));
    // A quarter: h00 = 27/32, h10 = 9/64, h01 = 5/32, h11 = -3/64.
    let expected =
        Vec3::new(27.0 / 32.0 + 2.0 * 9.0 / 64.0 + 2.0 * 5.0 / 32.0, -2.0 * 3.0 * 3.0 / 64.0, 2.0 * 2.0 * 9.0 / 64.0);
    assert!((at(0.5) - expected).length() < 1e-6, "{} {expected}", at(0.5));
}

#[test]
fn cubic_rotations_are_normalised_after_interpolation() {
    let (zero, quarter) = ([0.0; 4], [0.0, 0.0, SQRT_2 / 2.0, SQRT_2 / 2.0]);
    let values = [zero, [0.0, 0.0, 0.0, 1.0], zero, zero, quarter, zero].concat();
    let mut glb = Glb::square();
    glb.animate(1, "rotation", "CUBICSPLINE", &[0.0, 1.0], &values);
    // Half way between two unit quaternions with flat tangents lies half the angle.
    assert!(close(node(&glb.read().unwrap(), 0.5), Mat4::from_rotation_z(FRAC_PI_4)));
}

#[test]
fn rotations_of_every_component_type() {
    // 90 degrees about z by glTF's formulas: 0.7071 is 90/127, 180/255, 23170/32767 and 46341/65535.
    type Store = fn(&mut Glb) -> usize;
    let stores: [(Store, f32); 4] = [
        (|g| g.normalised(I8, "VEC4", &[0, 0, 90, 90]), 1e-2),
        (|g| g.normalised(U8, "VEC4", &[0, 0, 180, 180]), 1e-2),
        (|g| g.normalised(I16, "VEC4", &shorts(&[0, 0, 23170, 23170])), 1e-4),
        (|g| g.normalised(U16, "VEC4", &shorts(&[0, 0, 46341, 46341])), 1e-4),
    ];
    for (store, tolerance) in stores {
        let mut glb = Glb::square();
        glb.animate(1, "rotation", "LINEAR", &[0.0], &[0.0, 0.0, 0.0, 1.0]);
        glb.json["animations"][0]["samplers"][0]["output"] = json!(store(&mut glb));
        let got = node(&glb.read().unwrap(), 0.0);
        assert!(got.abs_diff_eq(Mat4::from_rotation_z(FRAC_PI_2), tolerance), "{got}");
    }
}

#[test]
fn children_follow_and_palettes_include_the_bind() {
    let mut glb = Glb::square();
    glb.animate(2, "rotation", "STEP", &[0.0], &Quat::from_rotation_z(FRAC_PI_2).to_array());
    let scene = glb.read().unwrap();
    let palette = scene.pose(ClipChoice::Clip(0), 0.0).palette;
    assert_eq!(palette[0], Mat4::IDENTITY);
    // Vertex (1, 1, 0) turns about the upper joint at (0, 1, 0).
    let moved = palette[1].transform_point3(Vec3::new(1.0, 1.0, 0.0));
    assert!((moved - Vec3::new(0.0, 2.0, 0.0)).length() < 1e-6, "{moved}");
    let rest = scene.pose(ClipChoice::Rest, 0.0);
    assert_eq!(rest.palette, [Mat4::IDENTITY; 2]);
    assert_eq!(rest.nodes[2], Mat4::from_translation(Vec3::Y));
}

#[test]
fn pointers_weights_and_unknown_paths_are_lifted_out() {
    let mut glb = Glb::square();
    let moves = glb.animate(1, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    let pointer = json!({"sampler": 0, "target": {"path": "pointer",
        "extensions": {"KHR_animation_pointer": {"pointer": "/materials/0/pbrMetallicRoughness/baseColorFactor"}}}});
    let weights = json!({"sampler": 0, "target": {"node": 0, "path": "weights"}});
    let unknown = json!({"sampler": 0, "target": {"node": 0, "path": "colour"}});
    let nowhere = json!({"sampler": 0, "target": {"path": "rotation"}});
    let channels = glb.json["animations"][moves]["channels"].as_array_mut().unwrap();
    channels.extend([pointer.clone(), weights, unknown, nowhere]);
    let only = json!({"name": "blink", "channels": [pointer], "samplers": [{"input": 5, "output": 6}]});
    glb.json["animations"].as_array_mut().unwrap().insert(0, only);
    glb.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    glb.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    let scene = glb.read().unwrap();
    assert_eq!(
        scene.clips.iter().map(|c| (c.name.as_str(), c.channels.len())).collect::<Vec<_>>(),
        [("blink", 0), ("#1", 1)]
    );
    assert!(scene.notes[0].contains("animation 0 `blink`: 1 of its 1 channels"), "{:?}", scene.notes);
    assert!(scene.notes[1].contains("4 of its 5 channels"), "{:?}", scene.notes);
    assert_eq!(scene.choose_clip(None), Ok(ClipChoice::Clip(1)));
    assert_eq!(scene.pose(ClipChoice::Clip(1), 0.5).nodes[1].w_axis.x, 1.0);
    assert_eq!(scene.pose(ClipChoice::Clip(0), 0.5), {
        let mut p = scene.pose(ClipChoice::Default, 0.5);
        p.time = 0.5;
        p
    });
}

#[test]
fn broken_keys_are_refused_by_animation_and_channel() {
    let straight = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    let cases: [(&str, &[f32], &[f32], &str); 6] = [
        ("translation", &[1.0, 0.5], &straight, "key 1 at 0.5 s comes before key 0 at 1 s"),
        ("translation", &[0.0, f32::NAN], &straight, "the time of key 1 is not a finite number"),
        ("scale", &[0.0, 1.0], &[0.0, 0.0, 0.0, f32::INFINITY, 0.0, 0.0], "value 1 is not a finite number"),
        ("scale", &[0.0, 1.0, 2.0], &straight, "it has 3 keys and 2 values, 1 a key are needed"),
        ("rotation", &[0.0], &[0.0; 4], "value 0 is the zero quaternion"),
        ("rotation", &[0.0], &[0.0, f32::NAN, 0.0, 1.0], "value 0 is not a finite number"),
    ];
    for (path, times, values, expected) in cases {
        let mut glb = Glb::square();
        let index = glb.animate(1, path, "LINEAR", times, values);
        glb.json["animations"][index]["name"] = json!("wave\nit");
        let line = glb.refusal();
        assert!(line.contains("animation 0 `wave it`, channel 0: ") && line.contains(expected), "{line}");
    }
    let mut glb = Glb::square();
    glb.animate(77, "scale", "LINEAR", &[0.0], &[1.0; 3]);
    assert!(glb.refusal().contains("animation 0, channel 0: refers to node 77 of 3"), "{}", glb.refusal());
    glb.json["animations"][0]["channels"][0] = json!({"sampler": 3, "target": {"node": 1, "path": "scale"}});
    assert!(glb.refusal().contains("refers to sampler 3 of 1"), "{}", glb.refusal());
}

#[test]
fn equal_key_times_jump_and_matrices_are_taken_apart() {
    let mut glb = Glb::square();
    glb.animate(1, "translation", "LINEAR", &[0.0, 1.0, 1.0, 2.0], &[[0.0; 3], [1.0; 3], [5.0; 3], [6.0; 3]].concat());
    let scene = glb.read().unwrap();
    let at = |time| node(&scene, time).w_axis.x;
    assert_eq!((at(0.5), at(1.0), at(1.5)), (0.5, 5.0, 5.5));

    let mut glb = Glb::square();
    let matrix = Mat4::from_scale_rotation_translation(Vec3::splat(2.0), Quat::from_rotation_z(FRAC_PI_2), Vec3::X);
    glb.json["nodes"][1] = json!({"matrix": matrix.to_cols_array(), "children": [2]});
    assert!(close(glb.read().unwrap().pose(ClipChoice::Default, 0.0).nodes[1], matrix));
    glb.animate(1, "translation", "LINEAR", &[0.0], &[0.0, 7.0, 0.0]);
    let scene = glb.read().unwrap();
    assert!(close(node(&scene, 0.0), Mat4::from_translation(Vec3::new(-1.0, 7.0, 0.0)) * matrix));
    assert!(scene.notes[0].contains("the matrix is taken apart"), "{:?}", scene.notes);
}

#[test]
fn motions_are_chosen_by_keyword_name_and_index() {
    let mut glb = Glb::square();
    assert_eq!(glb.read().unwrap().choose_clip(None), Ok(ClipChoice::Default));
    for (name, seconds) in [("walk", 1.0), ("0", 0.5), ("rest", 2.0)] {
        let index = glb.animate(1, "scale", "STEP", &[0.0, seconds], &[1.0; 6]);
        glb.json["animations"][index]["name"] = json!(name);
    }
    let scene = glb.read().unwrap();
    assert_eq!(scene.choose_clip(None), Ok(ClipChoice::Clip(0)));
    assert_eq!(scene.choose_clip(Some("walk")), Ok(ClipChoice::Clip(0)));
    // A name is stronger than an index, a keyword than a name.
    assert_eq!(scene.choose_clip(Some("0")), Ok(ClipChoice::Clip(1)));
    assert_eq!(scene.choose_clip(Some("2")), Ok(ClipChoice::Clip(2)));
    assert_eq!(scene.choose_clip(Some("rest")), Ok(ClipChoice::Rest));
    assert_eq!(scene.choose_clip(Some("default")), Ok(ClipChoice::Default));
    let error = scene.choose_clip(Some("run\n")).unwrap_err();
    assert!(matches!(error, ClipError::Unknown { .. }));
    assert_eq!(
        error.to_string(),
        "test.glb: there is no clip `run `; choose rest, default, 0 `walk`, 1 `0`, 2 `rest`, test:elbow"
    );
    assert!(scene.choose_clip(Some("3")).is_err());
}

#[test]
fn frames_include_the_last_one() {
    let mut glb = Glb::square();
    glb.animate(1, "scale", "STEP", &[0.25, 1.85], &[1.0; 6]);
    let scene = glb.read().unwrap();
    let frames = |fps| scene.frame_count(ClipChoice::Clip(0), fps);
    // 1.6 s is 48 frames of 1/30 s, and 1.85 - 0.25 is a little less in f32.
    assert_eq!((frames(30.0), frames(10.0), frames(1.0)), (49, 17, 2));
    assert_eq!((frames(0.0), frames(f32::NAN), frames(-1.0), frames(f32::INFINITY)), (1, 1, 1, u32::MAX));
    assert_eq!(scene.frame_count(ClipChoice::Rest, 30.0), 1);
    assert_eq!(scene.frame_count(ClipChoice::Default, 30.0), 1);
    assert_eq!(scene.duration(ClipChoice::Clip(9)), 0.0);
    let input = glb.accessor(F32, "SCALAR", &floats(&[]));
    glb.json["animations"][0]["samplers"][0]["input"] = json!(input);
    let scene = glb.read().unwrap();
    assert!(scene.clips[0].channels.is_empty() && scene.notes[0].contains("no keys"), "{:?}", scene.notes);
}
