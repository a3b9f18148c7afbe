use super::super::*;
use crate::field::compose::JointOperator;
use crate::rig::muscle::{
    Around, Attachment, BodySide, BoneShape, Collides, Combine, Curve, Drive, Driver, Ease, FibreSet, Keys,
    MuscleShape, MuscleSize, ShapeCurve, Wrap,
};
use crate::rig::{Character, GroupSpec, Joint};
use glam::{EulerRot, Mat4, Quat, Vec3};
use proptest::prelude::*;

const SAMPLE: &str = include_str!("../../../../assets/sample.muscles.toml");
const ARM: &str = include_str!("../../../../assets/arm.muscles.toml");

const LEFT: &str = r#"# The file's own remark.
[character]
name = "two"   # of two arms

# The left biceps, and why it is so thin.
[[muscle]]
name      = "biceps_l" # strong
side      = "left"
bone      = "arm_l"
origin    = { bone = "chest", offset = [0.1, 0.2, 0.3], normal = [1, 0, 0] }
insertion = { bone = "arm_l", offset = [0.0400, 0.05, 0.0] } # far
width     = 2e-2
drivers   = [{ angle = { joint = "arm_l", axis = [0, 0, 1], to = 2 } }]

[[muscle]]
name = "belly"
bone = "chest"
origin = { bone = "chest", offset = [0, 0, 0] }
insertion = { bone = "chest", offset = [0, 0.1, 0] }
volume = 1e-4

# Bones.
[[bone]]
bone = "arm_l"
capsule = { from = [0, 0, 0], to = [0, 0.3, 0.01], radius = 0.02 }
"#;

fn document(text: &str) -> Document {
    Document::parse(text, Path::new("m.toml")).expect("a good file")
}

fn joint(name: &str, at: [f32; 3], turn: [f32; 3]) -> Joint {
    let turn = Quat::from_euler(EulerRot::XYZ, turn[0], turn[1], turn[2]);
    let bind = Mat4::from_rotation_translation(turn, at.into());
    Joint { name: name.into(), parent: None, node: 0, inverse_bind: bind.inverse() }
}

/// A chest and two arms whose bind matrices are no mirror images of one another.
fn two_arms() -> Character {
    let joints = vec![
        joint("chest", [0.0, 1.2, 0.05], [0.1, 0.0, 0.0]),
        joint("arm_l", [0.2, 1.4, 0.0], [0.3, -0.7, 1.1]),
        joint("arm_r", [-0.25, 1.3, 0.1], [1.2, 0.4, -0.6]),
    ];
    Character { joints, ..Character::default() }
}

fn scene_point(character: &Character, bone: &str, p: Vec3) -> Vec3 {
    let joint = character.joints.iter().find(|j| j.name == bone).expect("a joint");
    joint.bind().transform_point3(p)
}

fn scene_direction(character: &Character, bone: &str, v: Vec3) -> Vec3 {
    let joint = character.joints.iter().find(|j| j.name == bone).expect("a joint");
    joint.bind().transform_vector3(v).normalize()
}

fn reflected(p: Vec3) -> Vec3 {
    Vec3::new(-p.x, p.y, p.z)
}

#[test]
fn what_is_not_edited_stays_to_the_byte() {
    let crlf = LEFT.replace('\n', "\r\n");
    let marked = format!("\u{feff}{LEFT}");
    for text in [LEFT, SAMPLE, ARM, "", "# nothing", &crlf, &marked, LEFT.trim_end()] {
        assert_eq!(document(text).to_string(), text);
        let Some(name) = document(text).file().expect("good").muscles.first().map(|m| m.name.clone()) else { continue };
        let mut edited = document(text);
        edited.set(&name, "stiffness", "0.5").expect("set");
        edited.set(&name, "stiffness", "0.75").expect("set");
        let changed: Vec<String> = edited.to_string().lines().map(str::to_owned).collect();
        let before: Vec<String> = text.lines().map(str::to_owned).collect();
        let others = |lines: &[String]| lines.iter().filter(|l| !l.contains("stiffness")).cloned().collect::<Vec<_>>();
        assert_eq!(others(&changed), others(&before));
        assert!(edited.to_string().contains("stiffness = 0.75"));
        assert_eq!(edited.to_string().contains('\r'), text.contains('\r'));
        assert_eq!(edited.to_string().starts_with('\u{feff}'), text.starts_with('\u{feff}'));
    }
}

#[test]
fn a_value_that_is_set_keeps_its_comment() {
    let mut edited = document(LEFT);
    edited.set("biceps_l", "insertion.offset", "[1, 2, 3]").expect("set");
    edited.set("biceps_l", "width", "0.03").expect("set");
    edited.set("biceps_l", "active.beta", "8").expect("set");
    let expected = LEFT
        .replace("[0.0400, 0.05, 0.0]", "[1, 2, 3]")
        .replace("width     = 2e-2", "width     = 0.03")
        .replace("to = 2 } }]\n", "to = 2 } }]\nactive = { beta = 8 }\n");
    assert_eq!(edited.to_string(), expected);
    for (muscle, key, value) in [
        ("nobody", "width", "1"),
        ("biceps_l", "width", "-1"),
        ("biceps_l", "widht", "1"),
        ("biceps_l", "width", "1\nalpha = 2"),
        ("biceps_l", "width.deep", "1"),
    ] {
        assert!(edited.set(muscle, key, value).is_err(), "{key} = {value}");
        assert_eq!(edited.to_string(), expected, "a refused edit is taken back");
    }
}

#[test]
fn settings_are_copied_and_nothing_else() {
    let mut edited = document(LEFT);
    edited.copy("biceps_l", &["belly"], &Settings::ALL).expect("copied");
    let file = edited.file().expect("good");
    let (from, to) = (file.muscle("biceps_l").expect("source"), file.muscle("belly").expect("target"));
    let old = parse(LEFT, Path::new("m.toml")).expect("good");
    let old = old.muscle("belly").expect("target");
    assert_eq!((to.size, &to.drive, &to.keys, to.rest), (from.size, &from.drive, &from.keys, from.rest));
    assert_eq!((&to.origin, &to.insertion, to.side, &to.bone), (&old.origin, &old.insertion, old.side, &old.bone));
    let text = edited.to_string();
    assert!(text.starts_with(&LEFT[..LEFT.find("volume").expect("volume")]) && text.contains("# Bones."), "{text}");
    let mut part = document(LEFT);
    part.copy("biceps_l", &["belly"], &[Settings::Drive]).expect("copied");
    assert_eq!(part.file().expect("good").muscle("belly").map(|m| m.size), Some(MuscleSize::Volume(1e-4)));
    let refused = part.copy("bicep_l", &["belly"], &[Settings::Drive]).expect_err("no such muscle").to_string();
    assert!(refused.contains("nearest names: biceps_l"), "{refused}");
}

#[test]
fn a_partner_is_added_and_later_brought_in_line() {
    let character = two_arms();
    let mut edited = document(LEFT);
    let done = edited.mirror(&character, &SideNames::default()).expect("mirrored");
    assert_eq!((&done.added[..], &done.alone[..]), (&["biceps_r".to_owned()][..], &["belly".to_owned()][..]));
    assert_eq!(done.bones, ["arm_r"]);
    let text = edited.to_string();
    let file = edited.file().expect("good");
    let (left, right) = (file.muscle("biceps_l").expect("left"), file.muscle("biceps_r").expect("right"));
    assert_eq!((right.side, right.bone.as_str(), right.size), (BodySide::Right, "arm_r", left.size));
    assert_eq!(right.origin.bone, "chest");
    // Half a turn about z by two is half a turn about -z in the mirror, which is z turned the other way.
    let axis = |spec: &MuscleSpec| match &spec.drive.drivers[0].source {
        Source::Angle { joint, axis, .. } => scene_direction(&character, joint, axis.expect("an axis")),
        other => panic!("{other:?}"),
    };
    assert!(axis(right).distance(-reflected(axis(left))) < 1e-5);
    // The source is as it was, remarks and all, and stands before what is new.
    let head = &LEFT[..LEFT.find("# Bones.").expect("bones")];
    assert!(text.starts_with(head.trim_end()), "{text}");
    assert_eq!(text.matches("# strong").count(), 1, "remarks of the left side are not the right side's:\n{text}");
    assert!(text.contains("name      = \"biceps_r\""), "{text}");

    let remarked = text.replace("name      = \"biceps_r\"", "name      = \"biceps_r\" # mine").replace("2e-2", "0.05");
    let mut again = document(&remarked);
    let done = again.mirror(&character, &SideNames::default()).expect("mirrored");
    assert_eq!((done.added.len(), &done.updated[..]), (0, &["biceps_r".to_owned()][..]));
    assert_eq!(again.to_string(), remarked, "what is in line stays to the byte");
    again.set("biceps_l", "width", "0.04").expect("set");
    again.set("biceps_l", "origin.offset", "[0.1, 0.1, 0.1]").expect("set");
    again.mirror(&character, &SideNames::default()).expect("mirrored");
    let file = again.file().expect("good");
    assert_eq!(file.muscle("biceps_r").map(|m| m.size), Some(MuscleSize::Width(0.04)));
    assert!(again.to_string().contains("\"biceps_r\" # mine"));
}

#[test]
fn a_side_that_the_character_lacks_is_located() {
    let mut character = two_arms();
    character.joints.truncate(2);
    let mut edited = document(LEFT);
    let refused = edited.mirror(&character, &SideNames::default()).expect_err("no right arm").to_string();
    assert!(refused.starts_with("m.toml:9:13: muscle `biceps_l`: bone `arm_r` is not a joint"), "{refused}");
    assert_eq!(edited.to_string(), LEFT);
}

fn vector() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-0.5f32..0.5).prop_map(Vec3::from)
}

fn direction() -> impl Strategy<Value = Vec3> {
    vector().prop_filter_map("a direction", |v| v.try_normalize())
}

fn curve(range: std::ops::Range<f32>) -> impl Strategy<Value = Curve> {
    let ease = prop_oneof![Just(Ease::Linear), Just(Ease::Step), Just(Ease::Cubic)];
    (ease, prop::collection::vec(range, 0..4), any::<bool>()).prop_map(|(ease, values, slopes)| {
        let slopes = slopes && ease == Ease::Cubic;
        Curve {
            // A curve without keys says nothing, so it has no ease to keep.
            ease: if values.is_empty() { Ease::Linear } else { ease },
            times: (0..values.len()).map(|i| i as f32 * 0.7 - 0.1).collect(),
            tangents: values.iter().filter(|_| slopes).map(|&v| [v, -v]).collect(),
            values,
        }
    })
}

fn shape() -> impl Strategy<Value = MuscleShape> {
    (1u32..=9, 1u32..=9, 0.0f32..0.99, 0.5f32..2.0).prop_map(|(alpha, beta, eccentricity, width)| MuscleShape {
        alpha,
        beta,
        eccentricity,
        width,
    })
}

fn driver() -> impl Strategy<Value = Driver> {
    let source = prop_oneof![
        (0.1f32..0.9, any::<bool>()).prop_map(|(min, invert)| Source::Length { min, max: 1.1, invert }),
        (prop::option::of(direction()), 0.1f32..3.0).prop_map(|(axis, to)| Source::Angle {
            joint: "arm_l".into(),
            axis,
            from: 0.0,
            to
        }),
        (-2.0f32..2.0).prop_map(Source::Constant),
        "[a-z]{1,8}(_l)?".prop_map(|column| Source::Table { file: "f.csv".into(), column, curve: Curve::default() }),
    ];
    let combine = prop_oneof![Just(Combine::Max), Just(Combine::Add), Just(Combine::Multiply)];
    (source, combine).prop_map(|(source, combine)| Driver { source, combine })
}

fn wrap() -> impl Strategy<Value = Wrap> {
    let ends = prop::option::of([vector(), vector()].prop_filter("a length", |[from, to]| from.distance(*to) > 1e-3));
    let around = prop_oneof![
        Just(Around::Joint("chest".into())),
        ends.prop_map(|ends| Around::Bone { bone: "arm_l".into(), ends })
    ];
    (around, 1e-3f32..0.1, prop::option::of(vector())).prop_map(|(around, radius, side)| Wrap { around, radius, side })
}

prop_compose! {
    fn spec()(
        ends in [(vector(), direction()), (vector(), direction())],
        line in prop::collection::vec(vector(), 0..4),
        (rest, active, same) in (shape(), shape(), any::<bool>()),
        drivers in prop::collection::vec(driver(), 0..4),
        (activation, width) in (curve(0.0..1.0), curve(0.1..3.0)),
        (size, by_volume, segments, tendon) in (1e-6f32..0.1, any::<bool>(), 3u32..=63, 0.0f32..0.45),
        (attack, group, overlap) in (0.0f32..2.0, "[a-z]{0,5}", any::<bool>()),
        (bones, muscles, skin) in (any::<bool>(), any::<bool>(), any::<bool>()),
        (frequency, jiggle) in (prop::option::of(1.0f32..60.0), 0.0f32..1.0),
        wrap in prop::option::of(wrap()),
    ) -> MuscleSpec {
        let end = |bone: &str, (offset, normal)| Attachment { bone: bone.into(), offset, normal };
        let [origin, insertion] = ends;
        let size = if by_volume { MuscleSize::Volume(size) } else { MuscleSize::Width(size) };
        let fibres = (!line.is_empty()).then(|| {
            FibreSet { count: 2 + line.len() as u32, origin_line: line.clone(), insertion_line: line, overlap }
        });
        let shape = ShapeCurve { ease: Ease::Step, times: vec![0.25], shapes: vec![(rest.alpha, rest.beta)] };
        MuscleSpec {
            side: BodySide::Left,
            wrap,
            fibres,
            segments,
            rest,
            active: if same { rest } else { active },
            tendon,
            collision_group: group,
            collides: Collides { bones, muscles, skin },
            frequency,
            jiggle,
            drive: Drive { drivers, attack, ..Drive::default() },
            keys: Keys { activation, width, shape, ..Keys::default() },
            ..MuscleSpec::new("x_l", "arm_l", end("chest", origin), end("arm_l", insertion), size)
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_added_reads_back(spec in spec()) {
        let mut edited = document(LEFT);
        edited.add(&spec).expect("added");
        let file = edited.file().expect("good");
        let read = file.muscle("x_l").expect("the muscle");
        // A width factor is written relative to the scale of both, which may cost the last bit.
        let close = |a: MuscleShape, b: MuscleShape| (a.width / b.width - 1.0).abs() < 1e-6 && MuscleShape { width: b.width, ..a } == b;
        prop_assert!(close(read.rest, spec.rest) && close(read.active, spec.active));
        prop_assert_eq!(&MuscleSpec { rest: spec.rest, active: spec.active, ..read.clone() }, &spec);
        prop_assert!(edited.to_string().starts_with(LEFT.split("# Bones.").next().expect("text").trim_end()));
        prop_assert!(edited.add(&spec).is_err(), "twice the same name");
    }

    #[test]
    fn mirrored_points_are_reflections_and_twice_is_the_start(spec in spec()) {
        let character = two_arms();
        let names = SideNames::default();
        let mut edited = document("");
        edited.add(&spec).expect("added");
        edited.mirror(&character, &names).expect("mirrored");
        let file = edited.file().expect("good");
        let (left, right) = (file.muscle("x_l").expect("left").clone(), file.muscle("x_r").expect("right").clone());
        let mut pairs = Vec::new();
        for (a, b) in [(&left.origin, &right.origin), (&left.insertion, &right.insertion)] {
            pairs.push((scene_point(&character, &a.bone, a.offset), scene_point(&character, &b.bone, b.offset)));
            pairs.push((scene_direction(&character, &a.bone, a.normal), scene_direction(&character, &b.bone, b.normal)));
        }
        let lines = |m: &MuscleSpec| m.fibres.as_ref().map_or(Vec::new(), |f| {
            let origin = f.origin_line.iter().map(|&p| scene_point(&character, &m.origin.bone, p));
            origin.chain(f.insertion_line.iter().map(|&p| scene_point(&character, &m.insertion.bone, p))).collect()
        });
        pairs.extend(lines(&left).into_iter().zip(lines(&right)));
        let wrap_points = |m: &MuscleSpec| m.wrap.as_ref().map_or(Vec::new(), |wrap| {
            let ends = if let Around::Bone { ends: Some(ends), .. } = wrap.around { ends.to_vec() } else { Vec::new() };
            ends.into_iter().chain(wrap.side).map(|p| scene_point(&character, wrap.around.name(), p)).collect()
        });
        pairs.extend(wrap_points(&left).into_iter().zip(wrap_points(&right)));
        let obstacle = |m: &MuscleSpec| m.wrap.as_ref().map(|wrap| (names.other(wrap.around.name()), wrap.radius));
        let same = right.wrap.as_ref().map(|wrap| (wrap.around.name().to_owned(), wrap.radius));
        prop_assert_eq!(obstacle(&left), same);
        for (a, b) in &pairs {
            prop_assert!(reflected(*a).distance(*b) < 1e-5, "{a} {b}");
        }
        // The companion: unreflected points are far off, unless they lie in the plane.
        prop_assert!(pairs.iter().any(|(a, b)| a.x.abs() < 1e-3 || a.distance(*b) > 1e-3));

        // The start is forgotten but for its right half, which is mirrored back.
        let mut back = document("");
        back.add(&right).expect("added");
        back.mirror(&character, &names.reversed()).expect("mirrored");
        let file = back.file().expect("good");
        let again = file.muscle("x_l").expect("left");
        let near = |a: Vec3, b: Vec3| a.distance(b) < 1e-5;
        for (a, b) in [(&left.origin, &again.origin), (&left.insertion, &again.insertion)] {
            prop_assert!(near(a.offset, b.offset) && near(a.normal, b.normal) && a.bone == b.bone, "{a:?} {b:?}");
        }
        prop_assert_eq!((again.side, again.size, &again.keys), (left.side, left.size, &left.keys));
        for (a, b) in left.drive.drivers.iter().zip(&again.drive.drivers) {
            match (&a.source, &b.source) {
                (Source::Angle { axis: Some(a), .. }, Source::Angle { axis: Some(b), .. }) => prop_assert!(near(*a, *b)),
                (a, b) => prop_assert_eq!(a, b),
            }
        }
    }
}

#[test]
fn capsules_are_reflected() {
    let character = two_arms();
    let mut edited = document(LEFT);
    edited.mirror(&character, &SideNames::default()).expect("mirrored");
    let file = edited.file().expect("good");
    let ends = |i: usize| match &file.bones[i].shape {
        BoneShape::Capsule { from, to, .. } => [from, to].map(|p| scene_point(&character, &file.bones[i].bone, *p)),
        BoneShape::Mesh(name) => panic!("{name}"),
    };
    for (left, right) in ends(0).into_iter().zip(ends(1)) {
        assert!(reflected(left).distance(right) < 1e-5);
    }
    assert!(ends(0).iter().zip(ends(1)).any(|(left, right)| left.distance(right) > 0.1), "not all lie in the plane");
}

#[test]
fn joints_are_set_in_place_and_mirrored() {
    let joints = "[joints.arm_l] # the shoulder\noperator = \"finger\"   # for now\n";
    let text = format!("{LEFT}\n{joints}");
    assert_eq!(document(&text).to_string(), text);
    let mut edited = document(&text);
    edited.set_joint("arm_l", JointOperator::Bulge).expect("set");
    assert_eq!(edited.to_string(), text.replace("finger", "bulge"), "comments stay");
    edited.set_joint("chest", JointOperator::Union).expect("set");
    let added = edited.to_string();
    assert!(added.ends_with("\n[joints.chest]\noperator = \"union\"\n"), "{added}");
    assert!(edited.set_joint("", JointOperator::Union).is_err());
    assert_eq!(edited.to_string(), added, "a refused edit is taken back");

    let done = edited.mirror(&two_arms(), &SideNames::left_to_right()).expect("mirrored");
    assert_eq!(done.joints, ["arm_r"]);
    let file = edited.file().expect("good");
    let operators: Vec<_> = file.joints.iter().map(|j| (j.joint.as_str(), j.operator)).collect();
    let (bulge, union) = (JointOperator::Bulge, JointOperator::Union);
    assert_eq!(operators, [("arm_l", bulge), ("arm_r", bulge), ("chest", union)]);
    let mut fresh = document(LEFT);
    fresh.set_joint("arm_l", JointOperator::Blend).expect("set");
    assert_eq!(fresh.to_string(), format!("{LEFT}\n[joints.arm_l]\noperator = \"blend\"\n"));
    let mut inline = document("joints = { a = { operator = \"union\" } }\n");
    inline.set_joint("b", JointOperator::Blend).expect("set");
    assert_eq!(inline.file().expect("good").joints.len(), 2, "{inline}");
}

#[test]
fn groups_are_set_in_place_kept_and_mirrored() {
    let groups = "[groups.\"fore.arm_l\"] # the cuff\njoints   = [\"arm_l\"]   # alone\nseparate = true\n";
    let text = format!("{LEFT}\n{groups}");
    let mut edited = document(&text);
    assert_eq!(edited.to_string(), text);
    edited.set("biceps_l", "stiffness", "0.5").expect("set");
    assert!(edited.to_string().ends_with(groups), "{edited}");

    let given = |name: &str, joint: &str| GroupSpec {
        name: name.into(),
        joints: vec![joint.into()],
        separate: true,
        passive: None,
    };
    let mut edited = document(&text);
    let read = edited.file().expect("good").groups;
    assert_eq!(read, [given("fore.arm_l", "arm_l")]);
    edited.set_group(&read[0]).expect("set");
    assert_eq!(edited.to_string(), text, "what is the same stays as it is written");
    edited.set_group(&GroupSpec { passive: Some(true), ..read[0].clone() }).expect("set");
    assert_eq!(edited.to_string(), format!("{text}passive = true\n"), "comments stay");
    let done = edited.mirror(&two_arms(), &SideNames::left_to_right()).expect("mirrored");
    assert_eq!(done.groups, ["fore.arm_r"]);
    let other = GroupSpec { passive: Some(true), ..given("fore.arm_r", "arm_r") };
    assert_eq!(edited.file().expect("good").groups[1], other);
    assert!(edited.set_group(&given("", "arm_l")).is_err() && edited.set_group(&given("x", "")).is_err());
    let mut fresh = document(LEFT);
    fresh.set_group(&GroupSpec { separate: false, ..given("arm", "arm_l") }).expect("set");
    assert_eq!(fresh.to_string(), format!("{LEFT}\n[groups.arm]\njoints = [\"arm_l\"]\n"));
}
