//! Keys of muscles through `KHR_animation_pointer` and `SINEW_muscles`.

use super::builder::{F32, Glb, U8, floats};
use crate::clip::{ClipChoice, MuscleTrack, Scene};
use crate::rig::muscle::Ease;
use crate::rig::{Key, Keyed};
use serde_json::{Value, json};

/// A square whose extension names two muscles.
fn square() -> Glb {
    let mut glb = Glb::square();
    glb.json["extensions"] = json!({"SINEW_muscles": {"muscles": [{"name": "biceps_l"}, {"name": "triceps_l"}]}});
    glb.json["extensionsUsed"] = json!(["KHR_animation_pointer", "SINEW_muscles"]);
    glb.json["extensionsRequired"] = json!(["KHR_animation_pointer", "SINEW_muscles"]);
    glb
}

fn channel(sampler: usize, pointer: &str) -> Value {
    json!({"sampler": sampler, "target": {"path": "pointer",
        "extensions": {"KHR_animation_pointer": {"pointer": format!("/extensions/SINEW_muscles/{pointer}")}}}})
}

fn sampler(glb: &mut Glb, interpolation: &str, kind: &str, times: &[f32], values: &[f32]) -> Value {
    let input = glb.accessor(F32, "SCALAR", &floats(times));
    let output = glb.accessor(F32, kind, &floats(values));
    json!({"input": input, "output": output, "interpolation": interpolation})
}

/// Adds an animation of one muscle channel.
fn key(glb: &mut Glb, pointer: &str, interpolation: &str, times: &[f32], values: &[f32]) -> usize {
    let kind = if pointer.ends_with("shape") { "VEC2" } else { "SCALAR" };
    let sampler = sampler(glb, interpolation, kind, times, values);
    glb.push("animations", json!({"channels": [channel(0, pointer)], "samplers": [sampler]}))
}

fn keyed(scene: &Scene, time: f32) -> Vec<(String, Key)> {
    scene.pose(ClipChoice::Clip(0), time).keyed.into_iter().map(|Keyed { muscle, key }| (muscle, key)).collect()
}

#[test]
fn every_parameter_is_read_and_sampled() {
    let mut glb = square();
    // A channel of a node from 2 s to 3 s, among channels of muscles from 1 s to 5 s.
    glb.animate(1, "translation", "LINEAR", &[2.0, 3.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let samplers = [
        sampler(&mut glb, "LINEAR", "SCALAR", &[1.0, 3.0], &[0.0, 1.0]),
        sampler(&mut glb, "STEP", "SCALAR", &[1.0, 3.0], &[0.25, 0.75]),
        sampler(&mut glb, "LINEAR", "SCALAR", &[1.0, 5.0], &[1.0, 3.0]),
        sampler(&mut glb, "LINEAR", "VEC2", &[1.0, 3.0], &[3.0, 3.0, 4.0, 7.0]),
    ];
    let animation = &mut glb.json["animations"][0];
    animation["samplers"].as_array_mut().unwrap().extend(samplers);
    let pointers = ["0/activation", "1/eccentricity", "1/width", "0/stiffness", "0/shape"];
    let channels: Vec<Value> = pointers
        .iter()
        .zip([1, 2, 3, 2, 4])
        .map(|(pointer, sampler)| channel(sampler, &format!("muscles/{pointer}")))
        .collect();
    let all = animation["channels"].as_array_mut().unwrap();
    all.splice(0..0, channels);
    let other = json!({"sampler": 0, "target": {"path": "pointer",
        "extensions": {"KHR_animation_pointer": {"pointer": "/extensions/SINEW_muscles_of_others/0/activation"}}}});
    all.push(other);
    // Exporters write indices as decimals.
    all[0]["sampler"] = json!(1.0);
    let scene = glb.read().expect("good");
    let clip = &scene.clips[0];
    assert_eq!((clip.channels.len(), clip.muscle_channels.len(), clip.start, clip.end), (1, 5, 1.0, 5.0));
    let (left, right) = ("biceps_l".to_owned(), "triceps_l".to_owned());
    let expected = [
        (left.clone(), Key::Activation(0.25)),
        (right.clone(), Key::Eccentricity(0.25)),
        (right, Key::Width(1.25)),
        (left.clone(), Key::Stiffness(0.25)),
        (left, Key::Shape { from: (3, 3), to: (4, 7), share: 0.25 }),
    ];
    // Times count from the clip's start, for nodes and muscles alike.
    assert_eq!(keyed(&scene, 0.5), expected);
    assert_ne!(keyed(&scene, 0.6), expected);
    assert_eq!(scene.pose(ClipChoice::Clip(0), 1.5).nodes[1].w_axis.x, 0.5);
    assert_eq!(keyed(&scene, f32::NAN), keyed(&scene, 0.0));
    // Only the pointer to another extension is passed over.
    assert!(scene.notes.len() == 1 && scene.notes[0].contains("1 of its 2 channels do not move"), "{:?}", scene.notes);
    assert!(scene.pose(ClipChoice::Rest, 0.5).keyed.is_empty());
    assert!(scene.pose(ClipChoice::Default, 0.5).keyed.is_empty());
}

#[test]
fn cubic_splines_follow_appendix_c() {
    // Per key in-tangent, value, out-tangent; two seconds between the keys. Tangents may be of any size.
    let mut glb = square();
    key(&mut glb, "muscles/0/width", "CUBICSPLINE", &[1.0, 3.0], &[90.0, 0.5, 20.0, -40.0, 1.5, 90.0]);
    let scene = glb.read().expect("good");
    let at = |time| match keyed(&scene, time)[..] {
        [(_, Key::Width(width))] => width,
        ref other => panic!("{other:?}"),
    };
    let formula = |t: f32| {
        let (t2, t3, seconds) = (t * t, t * t * t, 2.0);
        (2.0 * t3 - 3.0 * t2 + 1.0) * 0.5
            + seconds * (t3 - 2.0 * t2 + t) * 20.0
            + (-2.0 * t3 + 3.0 * t2) * 1.5
            + seconds * (t3 - t2) * -40.0
    };
    for step in 0..=16 {
        let t = step as f32 / 16.0;
        // Values up to 17, in f32 here.
        assert!((at(2.0 * t) - formula(t)).abs() < 1e-5, "{t}: {} {}", at(2.0 * t), formula(t));
    }
    assert!((at(1.0) - formula(0.45)).abs() > 1e-2);
    let MuscleTrack::Width(curve) = &scene.clips[0].muscle_channels[0].track else { panic!("a width") };
    assert_eq!(
        (curve.ease, &curve.values[..], &curve.tangents[..]),
        (Ease::Cubic, &[0.5, 1.5][..], &[[90.0, 20.0], [-40.0, 90.0]][..])
    );

    let mut glb = square();
    let values = [0.5, 0.5, 3.0, 3.0, 0.5, 0.5, 0.5, 0.5, 5.0, 5.0, 0.5, 0.5];
    key(&mut glb, "muscles/0/shape", "CUBICSPLINE", &[0.0, 1.0], &values);
    let scene = glb.read().expect("good");
    assert_eq!(keyed(&scene, 0.25)[0].1, Key::Shape { from: (3, 3), to: (5, 5), share: 0.25 });
    assert!(scene.notes[0].contains("tangents are not read"), "{:?}", scene.notes);
}

#[test]
fn a_clip_of_muscles_alone_moves() {
    let mut glb = square();
    glb.push("animations", json!({"name": "nothing", "channels": [], "samplers": []}));
    key(&mut glb, "muscles/1/activation", "LINEAR", &[0.5, 2.5], &[0.0, 1.0]);
    let scene = glb.read().expect("good");
    assert_eq!(scene.choose_clip(None), Ok(ClipChoice::Clip(1)));
    assert_eq!((scene.clips[1].start, scene.duration(ClipChoice::Clip(1))), (0.5, 2.0));
    assert_eq!(scene.frame_count(ClipChoice::Clip(1), 30.0), 61);
    assert_eq!(scene.pose(ClipChoice::Clip(1), 1.0).keyed[0].key, Key::Activation(0.5));
    assert!(scene.clips[0].is_empty() && scene.pose(ClipChoice::Clip(0), 1.0).keyed.is_empty());
    // Normalised integers are numbers too.
    let bytes = glb.normalised(U8, "SCALAR", &[0, 255]);
    glb.json["animations"][1]["samplers"][0]["output"] = json!(bytes);
    assert_eq!(glb.read().expect("good").pose(ClipChoice::Clip(1), 1.0).keyed[0].key, Key::Activation(0.5));
    // Channels without keys are left out and said.
    let none = glb.accessor(F32, "SCALAR", &[]);
    glb.json["animations"][1]["samplers"][0]["input"] = json!(none);
    let scene = glb.read().expect("good");
    assert!(scene.clips[1].is_empty() && scene.notes[0].contains("no keys"), "{:?}", scene.notes);
}

#[test]
fn bad_pointers_are_refused_by_animation_and_channel() {
    for (pointer, expected) in [
        ("muscles/2/activation", "refers to muscle 2 of 2"),
        ("muscles/99999999999999999999/activation", "names no parameter of a muscle"),
        ("muscles/-1/activation", "names no parameter of a muscle"),
        ("muscles/0/force", "`/extensions/SINEW_muscles/muscles/0/force` names no parameter of a muscle; point at"),
        ("muscles/0", "names no parameter of a muscle"),
        ("muscles/0/shape/alpha", "names no parameter of a muscle"),
        ("bones/0/shape", "names no parameter of a muscle"),
        ("\nmuscles", "names no parameter of a muscle"),
    ] {
        let mut glb = square();
        glb.animate(1, "scale", "STEP", &[0.0], &[1.0; 3]);
        let index = key(&mut glb, pointer, "LINEAR", &[0.0, 1.0], &[0.5, 0.5]);
        glb.json["animations"][index]["name"] = json!("curl");
        let line = glb.refusal();
        assert!(line.contains("animation 1 `curl`, channel 0: ") && line.contains(expected), "{pointer}: {line}");
    }
    let mut glb = square();
    key(&mut glb, "muscles/0/activation", "LINEAR", &[0.0], &[0.5]);
    let good = glb.clone();
    assert!(good.read().is_ok());
    type Damage = fn(&mut Glb);
    let damages: [(Damage, &str); 7] = [
        (|g| g.json["extensions"]["SINEW_muscles"]["muscles"][0] = json!({}), "muscle 0 of SINEW_muscles has no name"),
        (
            |g| g.json["extensions"]["SINEW_muscles"]["muscles"][0] = json!("biceps"),
            "muscle 0 of SINEW_muscles has no name",
        ),
        (|g| g.json["extensions"] = json!([1]), "refers to muscle 0 of 0"),
        (|g| g.json["animations"][0]["channels"][0]["sampler"] = json!(3), "refers to sampler 3 of 1"),
        (|g| g.json["animations"][0]["channels"][0]["sampler"] = json!("a"), "it has no sampler"),
        (|g| g.json["animations"][0]["samplers"] = json!([]), "refers to sampler 0 of 0"),
        (|g| g.json["animations"][0]["samplers"][0]["interpolation"] = json!("WAVY"), "its interpolation is unknown"),
    ];
    for (damage, expected) in damages {
        let mut glb = good.clone();
        damage(&mut glb);
        assert!(
            glb.refusal().contains("animation 0, channel 0") && glb.refusal().contains(expected),
            "{}",
            glb.refusal()
        );
    }
}

#[test]
fn bad_keys_are_refused_by_animation_and_channel() {
    type Case = (&'static str, &'static str, &'static [f32], &'static [f32], &'static str);
    let cases: [Case; 12] = [
        ("activation", "LINEAR", &[0.0, 1.0], &[0.5, 1.5], "key 1 is 1.5, and activation must be in 0 to 1; "),
        ("activation", "STEP", &[0.0], &[-0.1], "key 0 is -0.1, and activation must be in 0 to 1; "),
        ("stiffness", "LINEAR", &[0.0], &[2.0], "stiffness must be in 0 to 1"),
        ("eccentricity", "LINEAR", &[0.0], &[1.0], "key 0 is 1, and eccentricity must be in 0 to 0.99"),
        ("width", "CUBICSPLINE", &[0.0], &[0.0, 11.0, 0.0], "key 0 is 11, and width must be in 0 to 10"),
        ("shape", "LINEAR", &[0.0], &[3.0, 10.0], "key 0 is [3.0, 10.0], and shape must be in 1 to 9 in whole numbers"),
        ("shape", "STEP", &[0.0], &[2.5, 3.0], "in whole numbers"),
        ("activation", "LINEAR", &[0.0, 1.0], &[0.5, f32::NAN], "value 1 is not a finite number"),
        ("width", "CUBICSPLINE", &[0.0], &[f32::INFINITY, 1.0, 0.0], "value 0 is not a finite number"),
        ("activation", "LINEAR", &[0.0, 1.0], &[0.5], "it has 2 keys and 1 values, 1 a key are needed"),
        ("activation", "CUBICSPLINE", &[0.0], &[0.5], "it has 1 keys and 1 values, 3 a key are needed"),
        ("activation", "LINEAR", &[1.0, 0.5], &[0.5, 0.5], "key 1 at 0.5 s comes before key 0 at 1 s"),
    ];
    for (parameter, interpolation, times, values, expected) in cases {
        let mut glb = square();
        key(&mut glb, &format!("muscles/0/{parameter}"), interpolation, times, values);
        let line = glb.refusal();
        assert!(line.contains("animation 0, channel 0: ") && line.contains(expected), "{parameter}: {line}");
    }
    // One number a key where two are needed, and the other way round.
    for (parameter, kind) in [("shape", "SCALAR"), ("activation", "VEC2")] {
        let mut glb = square();
        let sampler = sampler(&mut glb, "LINEAR", kind, &[0.0], &[3.0, 3.0]);
        let channels = [channel(0, &format!("muscles/0/{parameter}"))];
        glb.push("animations", json!({"channels": channels, "samplers": [sampler]}));
        assert!(glb.refusal().contains("animation 0, channel 0, values (accessor 6): it is"), "{}", glb.refusal());
    }
}
