//! A pose that is held, with muscles in motion: skin and folds come to rest.

use crate::support::data;
use glam::{Vec4, Vec4Swizzles};
use sinew::{
    clip::Scene,
    dynamics::settle,
    reference::{Motion, Reference},
    rig::{BuildOptions, Pose, Rig, Role, muscle_file},
    schedule::{DynamicsOptions, FrameOptions, TrackOptions, Tracking},
};
use std::path::Path;

const FPS: f32 = 30.0;

/// A human with some of its fixture's muscles, at rest where the dynamics let them.
fn character(name: &str, chosen: impl Fn(&str) -> bool) -> Option<(Scene, Rig)> {
    let scene = sinew::io::gltf::read(&data()?.join(format!("humans/{name}.glb"))).expect("the character");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("kernels-tests/fixtures/{name}.muscles.toml"));
    let mut specs = muscle_file::read(&path).expect("the fixture").muscles;
    specs.retain(|spec| chosen(&spec.name));
    assert!(specs.len() >= 3);
    let mut rig = Rig::build(scene.character.clone(), &specs, &BuildOptions::default()).expect("a rig");
    settle(&mut rig, &DynamicsOptions::default());
    Some((scene, rig))
}

/// What a frame of a held pose moves, metres: the skin at most, and the vertices that press against skin.
struct Moved {
    skin: f32,
    fold: f32,
}

/// What is played: a clip between two moments, seconds, at a speed, and then for a second at another.
struct Play<'a> {
    clip: &'a str,
    from: f32,
    to: f32,
    speed: f32,
    creep: f32,
}

/// What every frame of the second part moves against the one before, and how many vertices are in folds at its end.
fn moved(scene: &Scene, rig: &Rig, play: &Play, options: &FrameOptions) -> (Vec<Moved>, usize) {
    let reference = Reference::new(rig);
    let clip = scene.choose_clip(Some(play.clip)).expect("the clip");
    let mut motion = Motion::new(rig, options);
    let under_way = ((play.to - play.from) / play.speed * FPS).ceil() as u32;
    let mut last: Vec<Vec4> = Vec::new();
    let (mut moved, mut in_folds) = (Vec::new(), 0);
    for frame in 0..=under_way + FPS as u32 {
        let on = play.creep * frame.saturating_sub(under_way) as f32 / FPS;
        let at = (play.from + play.speed * frame as f32 / FPS).min(play.to) + on;
        let pose = Pose { time: frame as f32 / FPS, ..scene.pose(clip, at) };
        let trace = reference.next(&mut motion, &pose, options).expect("a frame");
        if frame > under_way {
            let mut most = Moved { skin: 0.0, fold: 0.0 };
            in_folds = 0;
            for (v, target) in rig.targets.vertices.iter().enumerate() {
                let way = (trace.positions()[v] - last[v]).xyz().length();
                most.skin = most.skin.max(way);
                if target.role == Role::Active as u32 && trace.tracks[v].contact > 0.0 {
                    most.fold = most.fold.max(way);
                    in_folds += 1;
                }
            }
            moved.push(most);
        }
        last.clear();
        last.extend_from_slice(trace.positions());
    }
    (moved, in_folds)
}

#[test]
fn after_half_a_second_nothing_moves() {
    let arm = |name: &str| name.ends_with("_l");
    let limbs = |name: &str| {
        ["biceps_l", "brachialis_l", "triceps_long_l", "rectus_femoris_l", "gluteus_l", "gastrocnemius_medial_l"]
            .contains(&name)
    };
    let held = |clip, from, to, speed| Play { clip, from, to, speed, creep: 0.0 };
    type Case<'a> = (&'a str, &'a dyn Fn(&str) -> bool, Play<'a>);
    let cases: [Case; 4] = [
        ("arm_nohand_dense_2172", &arm, held("test:elbow", 1.0, 8.0, 10.0)),
        ("arm_nohand_dense_2172", &arm, held("test:elbow", 1.0, 4.0, 10.0)),
        ("arm_male_athletic_2172", &arm, held("test:elbow", 1.0, 8.6, 10.0)),
        ("mh_male_athletic", &limbs, held("run_on_spot", 0.55, 0.7, 1.0)),
    ];
    let most = |moved: &[Moved]| moved.iter().map(|m| m.skin).fold(0.0, f32::max);
    for (name, chosen, play) in cases {
        let Some((scene, rig)) = character(name, chosen) else { return };
        let both = [TrackOptions::default(), TrackOptions::single_pose()].into_iter();
        for track in both.filter(|t| t.mode == Tracking::History || name == "arm_male_athletic_2172") {
            let options = FrameOptions { track, dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() };
            let (by_frame, in_folds) = moved(&scene, &rig, &play, &options);
            let (early, late) = by_frame.split_at(by_frame.len() / 2);
            println!(
                "{name}, {} to {} s, {:?}: at most {:.3} mm a frame in the first half second, {:.4} mm after it, \
                 {:.4} mm of {in_folds} vertices in folds",
                play.clip,
                play.to,
                track.mode,
                1e3 * most(early),
                1e3 * most(late),
                1e3 * late.iter().map(|m| m.fold).fold(0.0, f32::max)
            );
            assert!(most(late) < 1e-4, "{name}, {}: {} m a frame", play.clip, most(late));
            assert!(most(early) > most(late), "{name}: muscles swing out");
            if name == "arm_male_athletic_2172" {
                // The elbow closes on by 1.5 degrees a second.
                let creeping = moved(&scene, &rig, &Play { to: 8.0, creep: 0.1, ..play }, &options).0;
                let most = most(&creeping[creeping.len() / 2..]);
                assert!(most > 1e-4, "a pose that is not held is seen: {most} m a frame");
            }
        }
    }
}
