use super::*;
use crate::io::gltf;
use crate::rig::groups::{BodyPart, FieldGroups};
use glam::{Mat4, Quat};
use std::path::PathBuf;

/// A character of the data folder; `None`, said aloud, where `SINEW_DATA` is not set.
fn character(file: &str) -> Option<Character> {
    let Some(data) = std::env::var_os("SINEW_DATA").map(PathBuf::from) else {
        println!("SINEW_DATA is not set: roles of {file} are not tested");
        return None;
    };
    Some(gltf::read(&data.join(file)).expect("a character").character)
}

const BODIES: [&str; 6] = [
    "humans/mh_male_athletic.glb",
    "humans/mh_male_athletic_cc1.glb",
    "humans/mh_male_average_default163.glb",
    "characters/CesiumMan.glb",
    "characters/kaykit_Barbarian.glb",
    "characters/quaternius_robot.glb",
];
const ARMS: [&str; 2] = ["humans/arm_male_athletic_2172.glb", "humans/arm_nohand_dense_2172.glb"];

/// How many joints of limbs are not what their names say.
fn misread(c: &Character, roles: &Roles) -> usize {
    let groups = FieldGroups::detect(c);
    let said = |j: u32| {
        let group = &groups.groups[*groups.group_of_joint.get(j as usize)? as usize];
        Some((group.part?, group.name.ends_with("_l")))
    };
    let arm = [BodyPart::UpperArm, BodyPart::Forearm, BodyPart::Hand];
    let leg = [BodyPart::Thigh, BodyPart::Calf, BodyPart::Foot];
    let limbs = roles.arms.iter().map(|l| (l, arm)).chain(roles.legs.iter().map(|l| (l, leg)));
    limbs
        .flat_map(|(limb, parts)| {
            let left = limb.side == Some(Side::Left);
            let joints = [Some(limb.upper), Some(limb.lower), limb.end];
            joints.into_iter().zip(parts).map(move |(joint, part)| (joint, part, left))
        })
        .filter(|&(joint, part, left)| joint.and_then(said) != Some((part, left)))
        .count()
}

#[test]
fn limbs_are_what_their_names_say_without_reading_them() {
    for file in BODIES {
        let Some(c) = character(file) else { return };
        let roles = Roles::find(&c);
        assert_eq!((roles.arms.len(), roles.legs.len()), (2, 2), "{file}");
        assert_eq!(misread(&c, &roles), 0, "{file}: {roles:?}");
        let mut nameless = c.clone();
        nameless.joints.iter_mut().for_each(|joint| joint.name = "joint".into());
        assert_eq!(Roles::find(&nameless), roles, "{file}");
        // The other way round every limb is on the wrong side.
        let sides = |limb: &LimbRoles| LimbRoles {
            side: limb.side.map(|s| if s == Side::Left { Side::Right } else { Side::Left }),
            ..limb.clone()
        };
        let swapped = Roles { arms: roles.arms.iter().map(sides).collect(), ..roles.clone() };
        assert_eq!(misread(&c, &swapped), 6, "{file}");
    }
}

#[test]
fn fingers_are_chains_without_the_thumb() {
    for (file, fingers, first) in [
        ("humans/mh_male_athletic.glb", 4, ["index_01_l", "index_02_l", "index_03_l"].as_slice()),
        ("humans/mh_male_average_default163.glb", 4, &["finger2-1.L", "finger2-2.L", "finger2-3.L"]),
        ("characters/quaternius_robot.glb", 3, &["Index.L", "Index2.L"]),
    ] {
        let Some(c) = character(file) else { return };
        let roles = Roles::find(&c);
        let name = |j: u32| c.joints[j as usize].name.as_str();
        for arm in &roles.arms {
            assert_eq!(arm.digits.len(), fingers, "{file}");
            let thumb = arm.thumb.as_ref().map(|thumb| name(thumb[0])).expect("a thumb");
            assert!(["thumb_01", "finger1-1", "Thumb"].iter().any(|t| thumb.starts_with(t)), "{thumb}");
        }
        let digits: Vec<Vec<&str>> =
            roles.arms[0].digits.iter().map(|digit| digit.iter().map(|&j| name(j)).collect()).collect();
        assert!(digits.iter().any(|digit| digit == first), "{digits:?}");
    }
    let Some(c) = character("characters/kaykit_Barbarian.glb") else { return };
    assert!(Roles::find(&c).arms.iter().all(|arm| arm.digits.is_empty()), "a mitten has none");
}

#[test]
fn any_axis_may_be_up() {
    let Some(c) = character(BODIES[0]) else { return };
    let roles = Roles::find(&c);
    let axes = roles.axes.expect("axes");
    assert!(axes.up.dot(Vec3::Y) > 0.99 && axes.forward.dot(Vec3::Z) > 0.99 && axes.left.dot(Vec3::X) > 0.99);
    for turn in [
        Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
        Quat::from_rotation_z(-2.0),
        Quat::from_euler(Default::default(), 1.0, 2.0, 3.0),
    ] {
        let mut turned = c.clone();
        turned.positions_rest.iter_mut().for_each(|p| *p = turn * *p);
        turned.joints.iter_mut().for_each(|j| j.inverse_bind *= Mat4::from_quat(turn.inverse()));
        let found = Roles::find(&turned);
        let there = found.axes.expect("axes");
        assert!(there.up.distance(turn * axes.up) < 1e-3 && there.forward.distance(turn * axes.forward) < 1e-3);
        for (a, b) in found.arms.iter().zip(&roles.arms).chain(found.legs.iter().zip(&roles.legs)) {
            assert_eq!((a.side, a.upper, a.lower, a.end), (b.side, b.upper, b.lower, b.end));
        }
    }
}

#[test]
fn an_arm_alone_is_an_arm_without_a_side_or_a_front() {
    for file in ARMS {
        let Some(c) = character(file) else { return };
        let roles = Roles::find(&c);
        let name = |j: u32| c.joints[j as usize].name.as_str();
        assert!(roles.axes.is_none() && roles.legs.is_empty() && roles.arms.len() == 1, "{file}");
        let arm = &roles.arms[0];
        assert_eq!([arm.upper, arm.lower, arm.end.expect("a hand")].map(name), ["upperarm_l", "lowerarm_l", "hand_l"]);
        assert!(arm.side.is_none() && arm.elbow(None).is_some(), "it is bent at rest");
        let straight = LimbRoles { places: [0.0, 1.0, 2.0].map(|x| Vec3::X * x), ..arm.clone() };
        assert!(straight.elbow(None).is_none(), "a straight one tells nothing");
    }
}

#[test]
fn skeletons_without_limbs_have_none() {
    assert_eq!(Roles::find(&Character::default()), Roles::default());
    for file in ["characters/SimpleSkin.gltf", "characters/quad_skin.glb", "characters/unassigned-skeleton.gltf"] {
        let Some(c) = character(file) else { return };
        let roles = Roles::find(&c);
        assert!(roles.legs.is_empty() && roles.axes.is_none(), "{file}: {roles:?}");
    }
}
