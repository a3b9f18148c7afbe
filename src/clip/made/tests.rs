use super::*;
use crate::clip::{ClipChoice, Scene};
use crate::io::gltf;
use std::path::PathBuf;

const BODIES: [&str; 5] = [
    "humans/mh_male_athletic.glb",
    "humans/mh_male_average_default163.glb",
    "characters/CesiumMan.glb",
    "characters/kaykit_Barbarian.glb",
    "characters/quaternius_robot.glb",
];
const ARMS: [&str; 2] = ["humans/arm_male_athletic_2172.glb", "humans/arm_nohand_dense_2172.glb"];

/// A scene of the data folder; `None`, said aloud, where `SINEW_DATA` is not set.
fn scene(file: &str) -> Option<Scene> {
    let Some(data) = std::env::var_os("SINEW_DATA").map(PathBuf::from) else {
        println!("SINEW_DATA is not set: test clips of {file} are not tested");
        return None;
    };
    Some(gltf::read(&data.join(file)).expect("a character"))
}

fn built_in() -> Scene {
    gltf::from_bytes(include_bytes!("../../../assets/arm.glb"), "arm").expect("the arm")
}

/// A limb's three places in a pose.
fn posed(limb: &LimbRoles, motion: &[DMat4]) -> [DVec3; 3] {
    let at = |joint: u32, place: Vec3| motion[joint as usize].transform_point3(place.as_dvec3());
    [at(limb.upper, limb.places[0]), at(limb.lower, limb.places[1]), at(limb.lower, limb.places[2])]
}

/// Angle between a limb's bones, degrees.
fn bend([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).angle_between(c - b).to_degrees()
}

fn at_half_degrees(clip: TestClip, made: &MadeClips) -> Vec<Vec<DMat4>> {
    let frames = (made.seconds(clip) * 30.0).round() as u32;
    (0..=frames).map(|frame| made.motion(clip, frame as f32 / 30.0)).collect()
}

/// What is wrong with hinges that go from straight to 140 degrees, half a degree a frame, with their ends coming nearer.
fn faults(limbs: &[LimbRoles], frames: &[Vec<DMat4>], toward: Option<DVec3>) -> Vec<String> {
    let mut faults = Vec::new();
    for limb in limbs {
        let mut before = f64::INFINITY;
        for (frame, motion) in frames.iter().enumerate() {
            let places = posed(limb, motion);
            let reach = places[0].distance(places[2]);
            if (bend(places) - 0.5 * frame as f64).abs() > 0.01 {
                faults.push(format!("{:?} frame {frame}: {} degrees", limb.side, bend(places)));
            }
            if reach > before + 1e-9 {
                faults.push(format!("{:?} frame {frame}: the end goes away", limb.side));
            }
            before = reach;
            let [_, middle, end] = places;
            let ahead = toward.map_or(1.0, |toward| (end - middle).dot(toward));
            if frame == frames.len() / 2 && ahead <= 0.0 {
                faults.push(format!("{:?} frame {frame}: {ahead} m to the wrong side", limb.side));
            }
        }
    }
    faults
}

#[test]
fn hinges_close_to_140_degrees_in_half_degrees_on_both_sides() {
    for file in BODIES.iter().chain(&ARMS) {
        let Some(scene) = scene(file) else { return };
        let roles = Roles::find(&scene.character);
        let made = MadeClips::new(&scene.character);
        let elbows = at_half_degrees(TestClip::Elbow, &made);
        assert_eq!(elbows.len(), 281, "{file}");
        assert_eq!(scene.frame_count(ClipChoice::Test(TestClip::Elbow), 30.0), 281);
        let found = faults(&roles.arms, &elbows, None);
        assert!(found.is_empty(), "{file}: {found:?}");
        let Some(axes) = roles.axes else { continue };
        assert_eq!((roles.arms.len(), roles.legs.len()), (2, 2), "{file}");
        let forward = axes.forward.as_dvec3();
        let found = faults(&roles.arms, &elbows, Some(forward));
        assert!(found.is_empty(), "{file}: {found:?}");
        // Behind the knee at 70 degrees, and so is the foot that a file hangs elsewhere.
        let knees = at_half_degrees(TestClip::Knee, &made);
        let found = faults(&roles.legs, &knees, Some(-forward));
        assert!(found.is_empty(), "{file}: {found:?}");
        for leg in &roles.legs {
            let foot = leg.end.expect("a foot") as usize;
            assert_eq!(knees[200][foot], knees[200][leg.lower as usize], "{file}");
        }
        // A hinge whose sign is flipped is seen: nothing else tells an elbow from a knee.
        let mut flipped = made.clone();
        for clip in flipped.clips.iter_mut().flatten() {
            clip.turns.iter_mut().for_each(|turn| turn.axis = -turn.axis);
        }
        for (clip, limbs, toward) in [(TestClip::Elbow, &roles.arms, forward), (TestClip::Knee, &roles.legs, -forward)]
        {
            let found = faults(limbs, &at_half_degrees(clip, &flipped), Some(toward));
            assert_eq!(found.len(), 2, "{file}: both sides are wrong: {found:?}");
        }
    }
}

#[test]
fn arms_are_raised_sideways_from_rest() {
    for file in BODIES {
        let Some(scene) = scene(file) else { return };
        let (roles, made) = (Roles::find(&scene.character), MadeClips::new(&scene.character));
        let axes = roles.axes.expect("axes");
        let seconds = made.seconds(TestClip::Shoulder);
        assert!(made.motion(TestClip::Shoulder, 0.0).iter().all(|m| m.abs_diff_eq(DMat4::IDENTITY, 1e-9)), "{file}");
        let raised = made.motion(TestClip::Shoulder, seconds);
        for arm in &roles.arms {
            let [shoulder, elbow, _] = posed(arm, &raised);
            let up = (elbow - shoulder).normalize().dot(axes.up.as_dvec3());
            assert!(up > 0.9, "{file}: {up}");
            let half = posed(arm, &made.motion(TestClip::Shoulder, 0.5 * seconds));
            let out = (half[1] - half[0]).dot(axes.left.as_dvec3());
            assert!(out * if arm.side == Some(Side::Left) { 1.0 } else { -1.0 } > 0.0, "{file}: outward on the way");
        }
    }
}

#[test]
fn a_squat_goes_down_on_flat_feet_and_comes_up_again() {
    for file in BODIES {
        let Some(scene) = scene(file) else { return };
        let (roles, made) = (Roles::find(&scene.character), MadeClips::new(&scene.character));
        let axes = roles.axes.expect("axes");
        let at = |time: f32| made.motion(TestClip::Squat, time);
        let deepest = at(0.5 * SQUAT_SECONDS);
        for time in [0.0, SQUAT_SECONDS] {
            assert!(at(time).iter().all(|m| m.abs_diff_eq(DMat4::IDENTITY, 1e-6)), "{file} at {time} s");
        }
        for leg in &roles.legs {
            let [hip, knee, ankle] = posed(leg, &deepest);
            let thigh = leg.places[0].distance(leg.places[1]);
            let sunk = (leg.places[0].as_dvec3() - hip).dot(axes.up.as_dvec3()) / f64::from(thigh);
            assert!(sunk > 0.5, "{file}: the hips sink by {sunk} of the thigh");
            assert!((knee - hip).dot(axes.forward.as_dvec3()) > 0.5 * f64::from(thigh), "{file}: knees go forward");
            assert!(ankle.distance(leg.places[2].as_dvec3()) < 0.02 * f64::from(thigh), "{file}: feet stand");
            let foot = deepest[leg.end.expect("a foot") as usize];
            assert!((foot.transform_vector3(axes.up.as_dvec3()) - axes.up.as_dvec3()).length() < 1e-6, "{file}: flat");
        }
    }
}

#[test]
fn fingertips_curl_into_the_palm() {
    for file in [BODIES[0], BODIES[1], BODIES[4]] {
        let Some(scene) = scene(file) else { return };
        let (roles, made) = (Roles::find(&scene.character), MadeClips::new(&scene.character));
        let mut flipped = made.clone();
        for clip in flipped.clips.iter_mut().flatten() {
            clip.turns.iter_mut().for_each(|turn| turn.axis = -turn.axis);
        }
        let place = |j: u32| scene.character.joints[j as usize].bind().w_axis.truncate().as_dvec3();
        for arm in &roles.arms {
            let thumb = place(*arm.thumb.as_ref().expect("a thumb").last().expect("joints"));
            for digit in &arm.digits {
                let last = digit[digit.len() - 1];
                let from_thumb = |made: &MadeClips, share: f32| {
                    let motion = made.motion(TestClip::Finger, share * made.seconds(TestClip::Finger));
                    motion[last as usize].transform_point3(place(last)).distance(thumb)
                };
                // The thumb lies on the palm's side: curled the other way the fingertip is farther from it.
                for share in [0.25, 0.5, 1.0] {
                    let [palm, back] = [&made, &flipped].map(|made| from_thumb(made, share));
                    assert!(palm < back, "{file}: {:?} at {share}: {palm} {back}", arm.side);
                }
            }
        }
    }
}

#[test]
fn what_a_skeleton_lacks_is_named() {
    let arm = built_in();
    assert_eq!(arm.choose_clip(Some("test:elbow")), Ok(ClipChoice::Test(TestClip::Elbow)));
    for (name, missing) in
        [("test:knee", NO_LEG), ("test:squat", NO_BODY), ("test:shoulder", NO_BODY), ("test:finger", NO_FINGER)]
    {
        let error = arm.choose_clip(Some(name)).expect_err("an arm has none");
        assert!(matches!(&error, ClipError::Limb { clip, .. } if *clip == name), "{error}");
        assert!(error.to_string().contains(missing), "{error}");
    }
    let error = arm.choose_clip(Some("test:elbo")).expect_err("unknown").to_string();
    assert!(error.contains("test:elbow") && !error.contains("test:knee"), "{error}");
}

#[test]
fn the_nodes_of_joints_move_along() {
    let arm = built_in();
    let pose = arm.pose(ClipChoice::Test(TestClip::Elbow), 5.0);
    for (joint, moved) in arm.character.joints.iter().zip(&pose.palette) {
        assert!(pose.nodes[joint.node as usize].abs_diff_eq(*moved * joint.bind(), 1e-5));
    }
    assert!(pose.palette.iter().any(|m| !m.abs_diff_eq(glam::Mat4::IDENTITY, 0.1)));
    let nan = arm.pose(ClipChoice::Test(TestClip::Elbow), f32::NAN);
    assert!(nan.palette.iter().all(|m| m.is_finite()));
}
