use super::*;
use crate::error::{FieldError, HrbfError};
use crate::field::grid;
use crate::rig::{Influence, Joint};
use glam::{Mat4, Vec3};

/// A joint of a drawn skeleton: name, index of its parent, position in metres.
type Drawn<'a> = (&'a str, Option<u32>, [f32; 3]);

/// A character with a closed tube of the given radius around every drawn bone: from a joint to its first child, or
/// `tail` on from where its parent's bone ended. Joints named `_` move no skin.
fn character(skeleton: &[Drawn], radius: f32, tail: f32) -> Character {
    let mut c = Character { name: "drawn".into(), ..Character::default() };
    c.influence_offsets.push(0);
    for (k, &(name, parent, at)) in skeleton.iter().enumerate() {
        let at = Vec3::from(at);
        let inverse_bind = Mat4::from_translation(-at);
        c.joints.push(Joint { name: name.into(), parent, node: k as u32, inverse_bind });
        let child = skeleton.iter().find(|s| s.1 == Some(k as u32)).map(|s| Vec3::from(s.2));
        let above = parent.map_or(at - Vec3::Y, |p| Vec3::from(skeleton[p as usize].2));
        let end = child.unwrap_or(at + (at - above).normalize_or(Vec3::Y) * tail);
        if !name.starts_with('_') {
            tube(&mut c, at, end, radius, k as u32);
        }
    }
    c
}

/// Adds a closed tube with rounded ends around a segment, bound to one joint.
fn tube(c: &mut Character, start: Vec3, end: Vec3, radius: f32, joint: u32) {
    const AROUND: u32 = 12;
    const ALONG: u32 = 11;
    let x = (end - start).normalize_or(Vec3::Y);
    let (y, z) = x.any_orthonormal_pair();
    let base = c.positions_rest.len() as u32;
    for ring in 0..ALONG {
        let t = ring as f32 / (ALONG - 1) as f32;
        let narrow = (1.0 - (2.0 * t - 1.0).abs().powi(6)).max(0.0).sqrt().max(0.02);
        for k in 0..AROUND {
            let (sin, cos) = (std::f32::consts::TAU * k as f32 / AROUND as f32).sin_cos();
            let out = y * cos + z * sin;
            c.positions_rest.push(start.lerp(end, t) + out * radius * narrow);
            c.normals_rest.push((out + x * (2.0 * t - 1.0).powi(5) * 2.0).normalize());
            c.uvs.push(glam::Vec2::ZERO);
            c.influences.push(Influence { joint, weight: 1.0 });
            c.influence_offsets.push(c.influences.len() as u32);
        }
    }
    for ring in 0..ALONG - 1 {
        for k in 0..AROUND {
            let (a, b) = (base + ring * AROUND + k, base + ring * AROUND + (k + 1) % AROUND);
            c.triangles.extend([[a, b, b + AROUND], [a, b + AROUND, a + AROUND]]);
        }
    }
}

/// Names of the groups, sorted, each with its parent's.
fn family(groups: &FieldGroups) -> Vec<String> {
    let mut names: Vec<String> = groups
        .groups
        .iter()
        .map(|g| format!("{}<{}", g.name, g.parent.map_or("", |p| &groups.groups[p as usize].name)))
        .collect();
    names.sort();
    names
}

const HUMAN_FAMILY: [&str; 15] = [
    "calf_l<thigh_l",
    "calf_r<thigh_r",
    "foot_l<calf_l",
    "foot_r<calf_r",
    "forearm_l<upperarm_l",
    "forearm_r<upperarm_r",
    "hand_l<forearm_l",
    "hand_r<forearm_r",
    "head<neck",
    "neck<trunk",
    "thigh_l<trunk",
    "thigh_r<trunk",
    "trunk<",
    "upperarm_l<trunk",
    "upperarm_r<trunk",
];

/// A body whose names follow the given words; `side` writes a side into a limb's name.
fn body(trunk: [&str; 6], arm: [&str; 5], leg: [&str; 4], side: impl Fn(&str, bool) -> String) -> Character {
    let mut names: Vec<(String, Option<u32>, [f32; 3])> = vec![
        (trunk[0].into(), None, [0.0, 0.95, 0.0]),
        (trunk[1].into(), Some(0), [0.0, 1.02, 0.0]),
        (trunk[2].into(), Some(1), [0.0, 1.09, 0.0]),
        (trunk[3].into(), Some(2), [0.0, 1.27, 0.0]),
        (trunk[4].into(), Some(3), [0.0, 1.48, 0.0]),
        (trunk[5].into(), Some(4), [0.0, 1.58, 0.0]),
    ];
    for left in [true, false] {
        let s = if left { 1.0 } else { -1.0 };
        let first = names.len() as u32;
        let limb = |k: usize, x: f32, y: f32| [s * x, y, 0.01 * k as f32];
        names.push((side(arm[0], left), Some(3), limb(0, 0.03, 1.42)));
        names.push((side(arm[1], left), Some(first), limb(1, 0.2, 1.4)));
        names.push((side(arm[2], left), Some(first + 1), limb(2, 0.45, 1.4)));
        names.push((side(arm[3], left), Some(first + 2), limb(3, 0.7, 1.4)));
        names.push((side(arm[4], left), Some(first + 3), limb(4, 0.8, 1.4)));
        names.push((side(leg[0], left), Some(0), limb(0, 0.1, 0.93)));
        names.push((side(leg[1], left), Some(first + 5), limb(1, 0.1, 0.5)));
        names.push((side(leg[2], left), Some(first + 6), limb(2, 0.1, 0.1)));
        names.push((side(leg[3], left), Some(first + 7), [s * 0.1, 0.02, 0.1]));
    }
    let skeleton: Vec<Drawn> = names.iter().map(|(n, p, at)| (n.as_str(), *p, *at)).collect();
    character(&skeleton, 0.04, 0.1)
}

#[test]
fn bodies_of_many_vocabularies_have_the_same_fifteen_groups() {
    let unreal = body(
        ["pelvis", "spine_01", "spine_02", "spine_03", "neck_01", "head"],
        ["clavicle", "upperarm", "lowerarm", "hand", "index_01"],
        ["thigh", "calf", "foot", "ball"],
        |word, left| format!("{word}_{}", if left { "l" } else { "r" }),
    );
    let mixamo = body(
        ["Hips", "Spine", "Spine1", "Spine2", "Neck", "Head"],
        ["Shoulder", "Arm", "ForeArm", "Hand", "HandIndex1"],
        ["UpLeg", "Leg", "Foot", "ToeBase"],
        |word, left| format!("mixamorig:{}{word}", if left { "Left" } else { "Right" }),
    );
    let named_after_joints = body(
        ["Pelvis", "Spine1", "Spine2", "Spine3", "Neck", "Head"],
        ["Collar", "Shoulder", "Elbow", "Wrist", "Hand"],
        ["Hip", "Knee", "Ankle", "Foot"],
        |word, left| format!("{}_{word}", if left { "L" } else { "R" }),
    );
    let chains = body(
        ["torso_joint_1", "torso_joint_2", "torso_joint_3", "torso_joint_4", "neck_joint_1", "neck_joint_2"],
        ["clavicle", "arm_joint", "arm_joint", "arm_joint", "arm_joint"],
        ["leg_joint", "leg_joint", "leg_joint", "leg_joint"],
        |word, left| format!("{word}_{}_7", if left { "L" } else { "R" }),
    );
    for c in [unreal, mixamo, named_after_joints, chains] {
        let groups = FieldGroups::detect(&c);
        assert_eq!(family(&groups), HUMAN_FAMILY, "{}", c.joints[1].name);
        assert!(groups.group_of_joint.iter().all(|&g| g != u32::MAX));
        let spine = |j: usize| groups.groups[groups.group_of_joint[j] as usize].name.as_str();
        assert_eq!([0, 1, 2, 3].map(spine), ["trunk"; 4]);
        for g in &groups.groups {
            assert_eq!(g.passive, ["head", "hand", "foot"].iter().any(|p| g.name.starts_with(p)), "{}", g.name);
        }
    }
}

#[test]
fn unknown_names_leave_it_to_the_structure() {
    let tentacle: Vec<Drawn> = [("b0", None), ("b1", Some(0)), ("b2", Some(1)), ("stub", Some(2))]
        .iter()
        .enumerate()
        .map(|(k, &(name, parent))| (name, parent, [0.3 * k as f32, 1.0, 0.0]))
        .collect();
    let groups = FieldGroups::detect(&character(&tentacle, 0.02, 0.01));
    assert_eq!(family(&groups), ["b0<", "b1<b0", "b2<b1"], "the stub is too short to bend");
    assert_eq!(groups.group_of_joint, [0, 1, 2, 2]);
    assert!(groups.groups.iter().all(|g| !g.passive && g.part.is_none()));
}

#[test]
fn bunches_of_small_leaves_join_what_they_grow_from() {
    let mut skeleton: Vec<Drawn> = vec![("stem", None, [0.0; 3]), ("crown", Some(0), [0.0, 1.0, 0.0])];
    let petals: [[f32; 3]; 4] = [[0.1, 1.3, 0.0], [-0.1, 1.3, 0.0], [0.0, 1.3, 0.1], [0.0, 1.3, -0.1]];
    skeleton.extend(petals.map(|at| ("petal", Some(1), at)));
    let groups = FieldGroups::detect(&character(&skeleton, 0.05, 0.1));
    assert_eq!(family(&groups), ["crown<stem", "stem<"]);
    // Two leaves alone are no bunch.
    let groups = FieldGroups::detect(&character(&skeleton[..4], 0.05, 0.1));
    assert_eq!(groups.groups.len(), 4);
    let mut names: Vec<&str> = groups.groups.iter().map(|g| g.name.as_str()).collect();
    names.dedup();
    assert_eq!(names.len(), 4, "names are unique: {names:?}");
}

#[test]
fn handles_and_unused_joints_belong_to_no_group() {
    let skeleton: Vec<Drawn> = vec![
        ("_root", None, [0.0; 3]),
        ("upperarm_l", Some(0), [0.0, 1.0, 0.0]),
        ("lowerarm_l", Some(1), [0.3, 1.0, 0.0]),
        ("hand_l", Some(2), [0.6, 1.0, 0.0]),
        ("_IK-hand", Some(0), [0.6, 1.0, 0.0]),
    ];
    let groups = FieldGroups::detect(&character(&skeleton, 0.04, 0.1));
    assert_eq!(family(&groups), ["forearm_l<upperarm_l", "hand_l<forearm_l", "upperarm_l<"]);
    assert_eq!(groups.group_of_joint, [u32::MAX, 0, 1, 2, u32::MAX]);
    assert!(groups.groups[2].passive);
}

#[test]
fn skins_too_small_for_a_field_have_no_group() {
    for joints in [2, 3, 10] {
        let mut c = character(&[], 0.1, 0.1);
        for k in 0..joints {
            let parent = (k > 0).then(|| k - 1);
            c.joints.push(Joint { name: format!("joint_{k}"), parent, node: k, inverse_bind: Mat4::IDENTITY });
        }
        for v in 0..10_u32 {
            c.positions_rest.push(Vec3::new((v % 2) as f32, (v / 2) as f32, 0.0));
            c.normals_rest.push(Vec3::Z);
            c.influences.push(Influence { joint: v % joints, weight: 1.0 });
            c.influence_offsets.push(c.influences.len() as u32);
            if v >= 2 {
                c.triangles.push([v - 2, v - 1, v]);
            }
        }
        let groups = FieldGroups::detect(&c);
        assert!(groups.groups.is_empty() && groups.owner.iter().all(|&o| o == u32::MAX));
        assert_eq!(build_fields(&c, &groups, &FieldOptions::default()), Ok(Fields::default()));
    }
    let empty = Character::default();
    assert_eq!(FieldGroups::detect(&empty), FieldGroups::default());
}

fn arm() -> Character {
    let skeleton: Vec<Drawn> = vec![
        ("upperarm_l", None, [0.0, 1.0, 0.0]),
        ("lowerarm_l", Some(0), [0.3, 1.0, 0.0]),
        ("hand_l", Some(1), [0.6, 0.95, 0.0]),
    ];
    character(&skeleton, 0.05, 0.12)
}

#[test]
fn fields_follow_the_skin_and_repeat_to_the_byte() {
    let c = arm();
    let groups = FieldGroups::detect(&c);
    let fields = build_fields(&c, &groups, &FieldOptions::default()).unwrap();
    assert_eq!((fields.grids.len(), fields.fits.len()), (3, 3));
    assert_eq!(fields, build_fields(&c, &groups, &FieldOptions::default()).unwrap());
    let other = build_fields(&c, &groups, &FieldOptions { seed: 2, ..FieldOptions::default() }).unwrap();
    assert_ne!(fields.nodes, other.nodes);
    assert!(fields.nodes.iter().all(|n| n.is_finite()));
    for (g, (grid, fit)) in fields.grids.iter().zip(&fields.fits).enumerate() {
        assert_eq!((grid.joint, grid.muscle_begin, grid.muscle_end), (groups.groups[g].joint, 0, 0));
        // The skin of a tube of radius 5 cm, sampled by 50 points: within a tenth of the support.
        assert!(fit.median_distance < 0.1 * fit.support_radius, "{fit:?}");
        // The median radius itself: the tube is narrower at its ends.
        assert!(fit.support_radius > 0.85 * 0.05 && fit.support_radius < 1.05 * 0.05, "{fit:?}");
        assert!((40..=60).contains(&fit.samples), "{fit:?}");
        let axis = c.joints[g].bind().transform_point3(Vec3::ZERO) + Vec3::X * 0.06;
        let (d, _) = grid::sample(grid, &fields.nodes, axis).unwrap();
        assert!(d < -0.3 * fit.support_radius, "inside is negative: {d}");
    }
    // A skin blown up after the fit no longer lies on the field: the measure notices.
    let mut blown = c.clone();
    for (p, n) in blown.positions_rest.iter_mut().zip(&c.normals_rest) {
        *p += *n * 0.01;
    }
    let (sum, count) = (0..c.vertex_count()).filter(|&v| groups.owner[v] == 1).fold((0.0, 0), |(sum, count), v| {
        let d = grid::sample(&fields.grids[1], &fields.nodes, blown.positions_rest[v]).map_or(0.0, |s| s.0);
        (sum + d.abs(), count + 1)
    });
    assert!(sum / count as f32 > 0.1 * fields.fits[1].support_radius);
}

#[test]
fn options_out_of_range_and_bad_normals_are_refused() {
    let c = arm();
    let groups = FieldGroups::detect(&c);
    let wrong = |options| build_fields(&c, &groups, &options).unwrap_err();
    let default = FieldOptions::default();
    let error = wrong(FieldOptions { samples: Some(3), ..default });
    assert_eq!(error, FieldError::Option { option: "samples", given: 3, least: 8, most: 400 });
    let error = wrong(FieldOptions { grid_resolution: 1000, ..default });
    assert_eq!(error.to_string(), "field option `grid_resolution` is 1000, allowed are 8 to 256");
    // A skin without a single usable normal has nothing to sample.
    let mut numb = c.clone();
    numb.normals_rest.fill(Vec3::ZERO);
    let error = build_fields(&numb, &groups, &default).unwrap_err();
    assert!(
        matches!(&error, FieldError::Fit { group, source: HrbfError::TooFewSamples { .. }, .. } if group == "upperarm_l")
    );
    assert!(error.to_string().starts_with("field group `upperarm_l` (132 vertices) cannot be fitted: "), "{error}");
}

/// A straight chain of tubes, 50 vertices a joint.
fn chain(joints: u32, spacing: f32) -> Character {
    let mut c = character(&[], 0.1, 0.1);
    for k in 0..joints {
        let at = Vec3::X * (spacing * k as f32);
        let inverse_bind = Mat4::from_translation(-at);
        c.joints.push(Joint { name: format!("b{k}"), parent: k.checked_sub(1), node: k, inverse_bind });
        let base = c.positions_rest.len() as u32;
        for v in 0..50 {
            let (sin, cos) = ((v % 10) as f32 * std::f32::consts::TAU / 10.0).sin_cos();
            let along = Vec3::X * (spacing * (v / 10) as f32 / 5.0);
            c.positions_rest.push(at + along + Vec3::new(0.0, cos, sin) * 0.1);
            c.normals_rest.push(Vec3::new(0.0, cos, sin));
            c.influences.push(Influence { joint: k, weight: 1.0 });
            c.influence_offsets.push(c.influences.len() as u32);
            if v >= 10 {
                c.triangles.extend([[base + v - 10, base + v - 9, base + v], [base + v - 9, base + v, base + v - 1]]);
            }
        }
    }
    c
}

#[test]
fn long_chains_are_grouped_quickly() {
    let c = chain(400, 0.1);
    let start = std::time::Instant::now();
    let groups = FieldGroups::detect(&c);
    // Work in proportion to joints times vertices per merge would take the better part of a minute.
    assert!(start.elapsed().as_secs_f32() < 2.0, "{:?}", start.elapsed());
    // Bones of 4 % of the length and more: at most 25 groups, each a run of joints that hangs on the one before it.
    assert!((8..=25).contains(&groups.groups.len()), "{}", groups.groups.len());
    for (g, group) in groups.groups.iter().enumerate() {
        assert_eq!(group.parent, (g as u32).checked_sub(1));
        assert!(group.joints.windows(2).all(|pair| pair[1] == pair[0] + 1));
    }
    assert_eq!(groups.groups.iter().map(|g| g.joints.len()).sum::<usize>(), 400);
    assert!((0..c.vertex_count()).all(|v| groups.owner[v] == groups.group_of_joint[v / 50]));
}

#[test]
fn too_many_groups_and_nodes_are_bounded() {
    // Roots of their own have no bone to be too short, and the smallest go to linear skinning.
    let mut c = chain(100, 0.1);
    c.joints.iter_mut().for_each(|j| j.parent = None);
    let groups = FieldGroups::detect(&c);
    assert_eq!(groups.groups.len(), structure::MOST_GROUPS);
    let options = FieldOptions { grid_resolution: 256, ..FieldOptions::default() };
    let error = build_fields(&c, &groups, &options).unwrap_err();
    assert_eq!(error, FieldError::TooManyNodes { nodes: 64 << 24, most: 1 << 28 });
    assert!(error.to_string().contains("1073741824 nodes, at most 268435456"), "{error}");
}

fn spec(name: &str, joints: &[&str]) -> GroupSpec {
    GroupSpec { name: name.into(), joints: joints.iter().map(|j| (*j).into()).collect(), ..GroupSpec::default() }
}

/// An arm whose hand has a finger of three joints.
fn arm_with_finger() -> Character {
    let skeleton: Vec<Drawn> = vec![
        ("upperarm_l", None, [0.0, 1.0, 0.0]),
        ("lowerarm_l", Some(0), [0.3, 1.0, 0.0]),
        ("hand_l", Some(1), [0.6, 1.0, 0.0]),
        ("index_01_l", Some(2), [0.7, 1.0, 0.0]),
        ("index_02_l", Some(3), [0.75, 1.0, 0.0]),
        ("index_03_l", Some(4), [0.8, 1.0, 0.0]),
    ];
    character(&skeleton, 0.02, 0.05)
}

#[test]
fn given_groups_take_the_place_of_found_ones() {
    let c = arm_with_finger();
    let found = ["forearm_l<upperarm_l", "hand_l<forearm_l", "upperarm_l<"];
    assert_eq!(family(&FieldGroups::detect(&c)), found);
    assert_eq!(FieldGroups::detect_beside(&c, &[]).expect("none given"), FieldGroups::detect(&c));

    // Fingers of their own, the fingertip with the last one named; they do not follow linear skinning, the hand does.
    let fingers = GroupSpec { separate: true, ..spec("index", &["index_01_l", "index_02_l"]) };
    let groups = FieldGroups::detect_beside(&c, std::slice::from_ref(&fingers)).expect("good");
    let own = ["forearm_l<upperarm_l", "hand_l<forearm_l", "index_01_l<hand_l", "index_02_l<index_01_l", "upperarm_l<"];
    assert_eq!(family(&groups), own);
    assert_eq!(groups.group_of_joint, [0, 1, 2, 3, 4, 4]);
    assert_eq!(groups.groups.iter().map(|g| g.passive).collect::<Vec<_>>(), [false, false, true, false, false]);
    let fields = build_fields(&c, &groups, &FieldOptions::default()).expect("fields");
    assert_eq!(fields.grids.len(), 5);
    let folds = |groups: &FieldGroups| build_fields(&c, groups, &FieldOptions::default()).expect("fields").folds.len();
    assert_eq!((folds(&groups), folds(&FieldGroups::detect(&c))), (2, 1), "the finger folds");
    let follows = GroupSpec { passive: Some(true), ..fingers };
    let groups = FieldGroups::detect_beside(&c, &[follows]).expect("good");
    assert!(groups.groups[3].passive && groups.groups[4].passive);

    // One group of two limbs, under a name of its own; what comes after hangs on it.
    let groups = FieldGroups::detect_beside(&c, &[spec("arm", &["upperarm_l", "lowerarm_l"])]).expect("good");
    assert_eq!(family(&groups), ["arm<", "hand_l<arm"]);
    assert_eq!((groups.groups[0].part, groups.groups[0].joints.len()), (None, 2));
    // One limb renamed is that limb still.
    let groups = FieldGroups::detect_beside(&c, &[spec("upper", &["upperarm_l"])]).expect("good");
    assert_eq!(family(&groups), ["forearm_l<upper", "hand_l<forearm_l", "upper<"]);
    assert_eq!(groups.groups[0].part, Some(BodyPart::UpperArm));
    assert_eq!(folds(&groups), 1);
    // A given name stays and the found one gives way.
    let groups = FieldGroups::detect_beside(&c, &[spec("hand_l", &["lowerarm_l"])]).expect("good");
    assert!(family(&groups).iter().any(|f| f.starts_with("hand_l<upperarm_l")), "{:?}", family(&groups));
}

#[test]
fn given_groups_that_do_not_fit_are_refused_by_name() {
    let c = arm_with_finger();
    let refused = |specs: &[GroupSpec]| FieldGroups::detect_beside(&c, specs).expect_err("does not fit").to_string();
    let unknown = refused(&[spec("a", &["hand_l", "indx_01_l"])]);
    assert!(
        unknown.starts_with("group `a`: `indx_01_l` is not a joint") && unknown.contains("index_01_l"),
        "{unknown}"
    );
    let twice = refused(&[spec("a", &["hand_l"]), spec("b", &["index_01_l", "hand_l"])]);
    assert!(twice.starts_with("group `b`: joint `hand_l` stands in group `a` already"), "{twice}");
    assert!(refused(&[spec("a", &["hand_l", "hand_l"])]).contains("stands in group `a` already"));
    assert!(refused(&[spec("a", &[])]).starts_with("group `a`: it has no joints"));
    let mut bare = c.clone();
    let last = bare.joints.len() as u32;
    let joint = bare.joints[5].clone();
    bare.joints.push(Joint { name: "nail".into(), parent: Some(last - 1), ..joint });
    let error = FieldGroups::detect_beside(&bare, &[spec("a", &["nail"])]).expect_err("no skin").to_string();
    assert!(error.starts_with("group `a`: a moves too little skin"), "{error}");
}
