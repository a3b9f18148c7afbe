use super::super::*;
use crate::field::compose::JointOperator;
use crate::rig::muscle::{
    Around, BodySide, BoneShape, Collides, Combine, Curve, Drive, Driver, Ease, FibreSet, Keys, MuscleShape,
    MuscleSize, ShapeCurve, Wrap,
};
use glam::Vec3;

pub const GOOD: &str = r#"
[[muscle]]
name = "biceps"
bone = "upperarm"
origin = { bone = "upperarm", offset = [0.0, 0.02, 0.01] }
insertion = { bone = "lowerarm", offset = [0.0, 0.03, 0.0], normal = [1.0, 0.0, 0.0] }
width = 0.02
"#;

pub fn read_text(text: &str) -> MuscleFile {
    parse(text, Path::new("arm.muscles.toml")).expect("a good file")
}

fn failure(text: &str) -> String {
    parse(text, Path::new("arm.muscles.toml")).expect_err("must be refused").to_string()
}

/// The refusal of the good file with one more line, or with its last line replaced.
pub fn with(line: &str) -> String {
    failure(&format!("{GOOD}{line}\n"))
}

#[test]
fn a_minimal_muscle_has_the_defaults() {
    let file = read_text(GOOD);
    let [spec] = &file.muscles[..] else { panic!("one muscle") };
    let end =
        |bone: &str, y, x, normal| crate::rig::Attachment { bone: bone.into(), offset: Vec3::new(0.0, y, x), normal };
    let origin = end("upperarm", 0.02, 0.01, Vec3::Z);
    let insertion = end("lowerarm", 0.03, 0.0, Vec3::X);
    assert_eq!(*spec, MuscleSpec::new("biceps", "upperarm", origin, insertion, MuscleSize::Width(0.02)));
    assert!(file.notes.is_empty() && file.character.is_none() && file.bones.is_empty());
}

#[test]
fn every_key_is_read() {
    let text = r#"
[character]
name = "arm"
[[muscle]]
name = "m"
side = "left"
bone = "a"
origin = { bone = "a", offset = [1, 2, 3] }
insertion = { bone = "b", offset = [4, 5, 6] }
wrap = { kind = "cylinder", bone = "b", radius = 0.015, from = [0, 0, 0], to = [0, 1, 0], side = [0, 0, -1] }
fibres = { count = 5, origin_line = [[1, 0, 0], [2, 0, 0]], insertion_line = [[0, 1, 0]], overlap = true }
segments = 15
alpha = 2
beta = 5
eccentricity = 0.5
rest_width = 1.5
width_scale = 2
active = { alpha = 3, width = 1.25 }
volume = 1e-4
stiffness = 0.7
tendon = 0.2
collision_group = "shoulder"
collides = ["skin", "bones"]
frequency = 9.5
jiggle = 0.5
attack = 0.1
decay = 0.2
drivers = [
  { length = { min = 0.5, max = 1.1, invert = true } },
  { angle = { joint = "b", axis = [1, 0, 0], from = 0.1, to = 2 }, combine = "add" },
  { constant = 0.5, combine = "multiply" },
  { table = { file = "forces.csv", column = "bic" } },
  { table = { file = "forces.csv" } },
]
[muscle.keys]
activation = [[0, 0], [1, 1]]
eccentricity = { ease = "step", points = [[0, 0.5]] }
width = { ease = "cubic", points = [[0, 1, 0, 1], [1, 2, 3, 4]] }
stiffness = { points = [[0, 0.1]] }
shape = { ease = "step", points = [[0, 3, 3], [1, 4, 7]] }
combine = "add"
[[bone]]
bone = "a"
capsule = { from = [0, 0, 0], to = [0, 1, 0], radius = 0.01 }
[[bone]]
bone = "b"
mesh = "Ulna"
"#;
    let file = read_text(text);
    assert_eq!(file.character.as_deref(), Some("arm"));
    let curve = |ease, times: &[f32], values: &[f32]| Curve {
        ease,
        times: times.into(),
        values: values.into(),
        tangents: Vec::new(),
    };
    let table =
        |column: &str| Source::Table { file: "forces.csv".into(), column: column.into(), curve: Curve::default() };
    let driver = |source, combine| Driver { source, combine };
    let end = |bone: &str, x| crate::rig::Attachment {
        bone: bone.into(),
        offset: Vec3::new(x, x + 1.0, x + 2.0),
        normal: Vec3::Z,
    };
    let expected = MuscleSpec {
        side: BodySide::Left,
        wrap: Some(Wrap {
            around: Around::Bone { bone: "b".into(), ends: Some([Vec3::ZERO, Vec3::Y]) },
            radius: 0.015,
            side: Some(Vec3::NEG_Z),
        }),
        fibres: Some(FibreSet {
            count: 5,
            origin_line: vec![Vec3::X, Vec3::X * 2.0],
            insertion_line: vec![Vec3::Y],
            overlap: true,
        }),
        segments: 15,
        rest: MuscleShape { alpha: 2, beta: 5, eccentricity: 0.5, width: 3.0 },
        active: MuscleShape { alpha: 3, beta: 7, eccentricity: 0.5, width: 2.5 },
        stiffness: 0.7,
        tendon: 0.2,
        collision_group: "shoulder".into(),
        collides: Collides { muscles: false, ..Collides::default() },
        frequency: Some(9.5),
        jiggle: 0.5,
        drive: Drive {
            drivers: vec![
                driver(Source::Length { min: 0.5, max: 1.1, invert: true }, Combine::Max),
                driver(Source::Angle { joint: "b".into(), axis: Some(Vec3::X), from: 0.1, to: 2.0 }, Combine::Add),
                driver(Source::Constant(0.5), Combine::Multiply),
                driver(table("bic"), Combine::Max),
                driver(table("m"), Combine::Max),
            ],
            keys: Combine::Add,
            attack: 0.1,
            decay: 0.2,
        },
        keys: Keys {
            activation: curve(Ease::Linear, &[0.0, 1.0], &[0.0, 1.0]),
            eccentricity: curve(Ease::Step, &[0.0], &[0.5]),
            width: Curve { tangents: vec![[0.0, 1.0], [3.0, 4.0]], ..curve(Ease::Cubic, &[0.0, 1.0], &[1.0, 2.0]) },
            stiffness: curve(Ease::Linear, &[0.0], &[0.1]),
            shape: ShapeCurve { ease: Ease::Step, times: vec![0.0, 1.0], shapes: vec![(3, 3), (4, 7)] },
        },
        ..MuscleSpec::new("m", "a", end("a", 1.0), end("b", 4.0), MuscleSize::Volume(1e-4))
    };
    assert_eq!(file.muscles, [expected]);
    let capsule = BoneShape::Capsule { from: Vec3::ZERO, to: Vec3::Y, radius: 0.01 };
    let shapes: Vec<_> = file.bones.iter().map(|b| (b.bone.as_str(), b.shape.clone())).collect();
    assert_eq!(shapes, [("a", capsule), ("b", BoneShape::Mesh("Ulna".into()))]);
}

#[test]
fn an_active_table_has_defaults_of_its_own_and_no_table_means_rest() {
    let flat = |line: &str| read_text(&format!("{GOOD}eccentricity = 0.4\n{line}\n")).muscles.remove(0);
    assert_eq!(flat("").active, flat("").rest);
    assert_eq!(flat("active = {}").active, MuscleShape { eccentricity: 0.4, ..MuscleShape::ACTIVE });
    assert_eq!(flat("width_scale = 1.5").active.width, 1.5);
    assert_eq!(flat("rest_width = 1.5\nactive = {}").active.width, 1.0);
}

#[test]
fn mistakes_name_line_and_column() {
    let starts =
        |message: String, start: &str| assert!(message.starts_with(&format!("arm.muscles.toml:{start}")), "{message}");
    starts(failure(&GOOD.replace("width", "widht")), "7:1: unknown key `widht`; did you mean `width`?");
    starts(
        failure(&GOOD.replace("0.02\n", "\"wide\"\n")),
        "7:9: muscle `biceps`: `width` is the text \"wide\", and must be a number",
    );
    starts(failure(&GOOD.replace("width = 0.02", "")), "3:8: muscle `biceps`: it needs `width`");
    starts(with("volume = 1e-4"), "8:10: muscle `biceps`: it has both");
    starts(failure(&format!("{GOOD}{GOOD}")), "10:8: muscle `biceps` stands twice");
    starts(failure("[[muscle]"), "1:");
    starts(failure(&GOOD.replace("bone = \"upperarm\"\n", "")), "2:1: muscle `biceps`: key `bone` is missing");
    for (text, start) in [
        ("alpha = 0", "8:9: muscle `biceps`: alpha is 0, and must be a whole number from 1 to 9"),
        ("beta = 10", "8:8: muscle `biceps`: beta is 10"),
        ("alpha = -3", "8:9: muscle `biceps`: `alpha` is -3, and must be a whole number from 1 to 9"),
        ("alpha = 3.5", "8:9: muscle `biceps`: `alpha` is 3.5, and must be a whole number from 1 to 9"),
        ("eccentricity = 1", "8:16: muscle `biceps`: eccentricity is 1, and must be in 0 to 0.99"),
        ("eccentricity = nan", "8:16: muscle `biceps`: eccentricity is NaN"),
        ("segments = 2", "8:12: muscle `biceps`: segments is 2"),
        ("segments = 64", "8:12: "),
        ("side = \"lift\"", "8:8: unknown value `lift`; did you mean `left`?"),
        ("active = { beta = 12 }", "8:19: muscle `biceps`: active.beta is 12"),
        ("active = { bta = 2 }", "8:12: unknown key `bta`; did you mean `beta`?"),
        ("stiffness = 2", "8:13: "),
        ("tendon = 0.5", "8:10: "),
        ("collides = [\"bone\"]", "8:13: unknown value `bone`; did you mean `bones`?"),
        (
            "collides = \"bones\"",
            "8:12: muscle `biceps`: `collides` is the text \"bones\", and must be a list, [\"bones\",",
        ),
        ("collides = [1]", "8:13: muscle `biceps`: an item of `collides` must be \"bones\", \"muscles\" or \"skin\""),
        ("frequency = 0.5", "8:13: muscle `biceps`: frequency is 0.5, and must be in 1 to 60"),
        ("frequency = nan", "8:13: muscle `biceps`: frequency is NaN"),
        ("frequency = \"12 Hz\"", "8:13: muscle `biceps`: `frequency` is the text \"12 Hz\", and must be a number"),
        ("jiggle = 1.5", "8:10: muscle `biceps`: jiggle is 1.5, and must be in 0 to 1"),
        ("attack = -1", "8:10: muscle `biceps`: attack is -1"),
        ("width_scale = 0", "8:15: muscle `biceps`: width_scale is 0, and must be over 0 and at most 10"),
        ("width_scale = 10.5", "8:15: muscle `biceps`: width_scale is 10.5"),
        ("width_scale = 5\nrest_width = 4", "8:15: muscle `biceps`: width_scale times rest_width is 20"),
        ("width_scale = 5\nactive = { width = 4 }", "8:15: muscle `biceps`: width_scale times active.width is 20"),
        ("rest_width = inf", "8:14: muscle `biceps`: rest_width is inf, and must be over 0 and at most 10"),
        ("keys = { width = [[0, 1], [1, 10.5]] }", "8:31: muscle `biceps`: width is 10.5, and must be over 0 and at"),
        ("fibres = { count = 1, origin_line = [[0, 0, 1]] }", "8:20: muscle `biceps`: count is 1"),
        ("fibres = { count = 33, origin_line = [[0, 0, 1]] }", "8:20: "),
        ("fibres = { count = 3 }", "8:20: muscle `biceps`: all fibres are the same"),
        ("fibres = { count = 3, origin_line = [[0, 0, 0], [1, nan, 0]] }", "8:53: "),
        ("keys = { activation = [[1, 0], [0.5, 1]] }", "8:33: muscle `biceps`: the key at 0.5 s follows one at 1 s"),
        ("keys = { activation = { points = [[1, 0], [1, 1]] } }", "8:44: "),
        ("keys = { activation = [[0, 2]] }", "8:28: muscle `biceps`: activation is 2"),
        ("keys = { activation = [[0]] }", "8:24: muscle `biceps`: a key of 1 numbers"),
        ("keys = { activation = [[0, 1, 2, 3]] }", "8:24: muscle `biceps`: slopes are read of cubic"),
        (
            "keys = { activation = 1 }",
            "8:23: muscle `biceps`: `activation` is 1, and must be a list of keys, or a table",
        ),
        ("keys = { activation = [[0, \"x\"]] }", "8:28: muscle `biceps`: an item of `activation` is the text \"x\""),
        ("keys = { activation = { poins = [] } }", "8:25: unknown key `poins`; did you mean `points`?"),
        ("keys = { shape = [[0, 3, 0]] }", "8:26: muscle `biceps`: shape is 0"),
        (
            "keys = { shape = [[0, 3]] }",
            "8:19: muscle `biceps`: an item of `shape` is a list of 2, and must be [seconds",
        ),
        ("drivers = [{}]", "8:12: muscle `biceps`: a driver is one of"),
        ("drivers = [{ constant = nan }]", "8:25: "),
        ("drivers = [{ length = { min = 1.2 } }]", "8:23: muscle `biceps`: min is 1.2 and max 1"),
        ("drivers = [{ angle = { joint = \"a\", to = 0 } }]", "8:42: "),
        ("drivers = [{ angle = { joint = \"a\", to = 1, axis = [0, 0, 0] } }]", "8:52: "),
        ("drivers = [{ constant = 1, combine = \"mux\" }]", "8:38: unknown value `mux`; did you mean `max`?"),
        ("[[bone]]\nbone = \"a\"", "9:8: bone `a`: it needs `capsule` or `mesh`"),
        ("[[bone]]\nbone = \"a\"\ncapsule = { from = [0,0,0], to = [0,0,0], radius = 0 }", "10:52: "),
        ("nonsense", "8:"),
    ] {
        starts(with(text), start);
        assert!(!with(text).contains('\n'));
    }
    let size = |line: &str| failure(&GOOD.replace("width = 0.02", line));
    starts(size("width = -0.02"), "7:9: muscle `biceps`: width is -0.02, and must be a positive");
    starts(size("volume = -1e-4"), "7:10: muscle `biceps`: volume is -0.0001, and must be a positive");
    starts(size("volume = 0"), "7:10: ");
    starts(size("volume = nan"), "7:10: muscle `biceps`: volume is NaN");
    starts(size("width = inf"), "7:9: ");
    starts(size("width = 1e300"), "7:9: muscle `biceps`: width is inf");
    starts(failure(&GOOD.replace("0.02, 0.01", "0.02, -inf")), "5:52: muscle `biceps`: offset holds -inf");
    starts(failure(&GOOD.replace("[1.0, 0.0, 0.0]", "[0, 0, 0]")), "6:70: muscle `biceps`: normal has no direction");
    starts(
        failure(&GOOD.replace("[1.0, 0.0, 0.0]", "[0, 0]")),
        "6:70: muscle `biceps`: `normal` is a list of 2, and must be three numbers",
    );
    starts(failure(&GOOD.replace("biceps", "")), "3:8: ");
}

#[test]
fn mistakes_of_form_are_told_in_the_files_own_words() {
    let starts =
        |message: String, start: &str| assert!(message.starts_with(&format!("arm.muscles.toml:{start}")), "{message}");
    for (text, start) in [
        ("alpha = 3\nalpha = 4", "9:1: key `alpha` stands twice; keep one"),
        ("active = 3", "8:10: muscle `biceps`: `active` is 3, and must be a table, { key = value, .. }"),
        ("active = [1]", "8:10: muscle `biceps`: `active` is a list of 1, and must be a table"),
        ("side = 3", "8:8: muscle `biceps`: `side` must be \"left\", \"right\" or \"centre\""),
        ("drivers = { constant = 1 }", "8:11: muscle `biceps`: `drivers` is a table, and must be a list of drivers"),
        ("drivers = [3]", "8:12: muscle `biceps`: an item of `drivers` is 3, and must be a table"),
        ("drivers = [{ table = \"x\" }]", "8:22: muscle `biceps`: `table` is the text \"x\", and must be a table"),
        ("collision_group = true", "8:19: muscle `biceps`: `collision_group` is true, and must be text in quotes"),
        ("keys = { width = [3] }", "8:19: muscle `biceps`: an item of `width` is 3, and must be a key, [seconds"),
        ("keys = { width = { points = [3] } }", "8:30: muscle `biceps`: an item of `width` is 3"),
        ("fibres = { count = 2, origin_line = [1] }", "8:38: muscle `biceps`: an item of `origin_line` is 1, and must"),
        ("[[bone]]\nbone = \"a\"\ncapsule = 3", "10:11: bone `a`: `capsule` is 3, and must be a table"),
        ("[bone]\nbone = \"a\"", "8:1: write [[bone]], in double brackets, for each bone"),
        ("[[character]]", "8:1: write [character], in single brackets; a file has one"),
        ("[muscle]", "8:2: `muscle` stands here in another form than before; write [[muscle]]"),
    ] {
        starts(with(text), start);
    }
    starts(failure("[muscle]\nname = \"a\""), "1:1: write [[muscle]], in double brackets, for each muscle");
    starts(failure("bone = \"a\""), "1:8: key `bone` stands outside of all tables; write [[muscle]]");
    let second = GOOD.replace("biceps", "other").replace("0.02\n", "\"wide\"\n");
    starts(failure(&format!("{GOOD}{second}")), "14:9: muscle `other`: `width` is the text");
    let end = GOOD.replace(", offset = [0.0, 0.02, 0.01]", "");
    starts(failure(&end), "5:10: muscle `biceps`: key `offset` of `origin` is missing");
}

#[test]
fn what_a_terminal_obeys_is_refused_and_not_repeated() {
    let bad = "\\u001b[31mred\\u0007";
    for text in [
        GOOD.replace("biceps", bad),
        GOOD.replace("\"upperarm\", offset", &format!("\"{bad}\", offset")),
        format!("{GOOD}collision_group = \"{bad}\"\n"),
        format!("{GOOD}drivers = [{{ table = {{ file = \"{bad}\" }} }}]\n"),
        format!("{GOOD}\"{bad}\" = 3\n"),
        format!("{GOOD}side = \"{bad}\"\n"),
        format!("{GOOD}[[bone]]\nbone = \"{bad}\"\nmesh = \"m\"\n"),
        format!("{GOOD}[[bone]]\nbone = \"b\"\nmesh = \"{bad}\"\n"),
        format!("{GOOD}[character]\nname = \"{bad}\"\n"),
        GOOD.replace("biceps", "\\u202Especi"),
    ] {
        let message = failure(&text);
        assert!(!message.contains(crate::error::is_unprintable), "{message:?}");
    }
    let message = failure(&GOOD.replace("biceps", bad));
    assert!(message.starts_with("arm.muscles.toml:3:8: muscle `") && message.contains("U+001B"), "{message}");
    read_text(&GOOD.replace("biceps", "muscle \u{e9}\u{4e0a}"));
}

#[test]
fn tables_that_cannot_be_read_are_located() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.toml");
    std::fs::write(folder.path().join("bad.csv"), "time,biceps\n0,x\n").expect("written");
    std::fs::write(folder.path().join("good.csv"), "time,biceps\n0,1\n").expect("written");
    let refused = |table: &str| {
        let text = format!("{GOOD}drivers = [{{ constant = 0 }}, {{ table = {table} }}]\n");
        std::fs::write(&path, text).expect("written");
        super::super::read(&path).map(drop).map_err(|e| e.to_string())
    };
    assert_eq!(refused("{ file = \"good.csv\" }"), Ok(()));
    let bad = refused("{ file = \"bad.csv\" }").expect_err("no number");
    assert!(bad.contains("m.toml:8:49: muscle `biceps`: ") && bad.contains("bad.csv:2: column 2: `x`"), "{bad}");
    let column = refused("{ file = \"good.csv\", column = \"bicep\" }").expect_err("no column");
    assert!(column.contains("m.toml:8:70: muscle `biceps`: ") && column.contains("no column `bicep`"), "{column}");
    assert!(refused("{ file = \"../a.csv\" }").expect_err("outside").contains("m.toml:8:49: muscle `biceps`: "));
}

#[test]
fn blunt_ends_are_noted_with_their_place() {
    let file = read_text(&format!("{GOOD}alpha = 1\nactive = {{ beta = 1 }}\n"));
    let start = "arm.muscles.toml:8:9: muscle `biceps`: alpha of 1 makes a blunt, rounded end at the origin";
    assert_eq!(file.notes[0], start);
    assert!(file.notes[1].starts_with("arm.muscles.toml:9:19: muscle `biceps`: beta of 1"), "{:?}", file.notes);
    assert_eq!(read_text(&format!("{GOOD}alpha = 1\n")).notes.len(), 1, "the same shape when active is said once");
    assert!(read_text(&format!("{GOOD}alpha = 2\n")).notes.is_empty());
}

#[test]
fn files_beyond_measure_are_refused() {
    assert!(failure(&"#".repeat(MAX_BYTES as usize + 1)).contains("over 4 MiB"));
    parse(&"#".repeat(MAX_BYTES as usize), Path::new("x")).expect("as large as may be");
    let many: String = (0..=MAX_MUSCLES).map(|i| format!("[[bone]]\nbone = \"b{i}\"\nmesh = \"m\"\n")).collect();
    assert!(failure(&many).starts_with("arm.muscles.toml:12290:8: 4097 bones"), "{}", failure(&many));
    assert!(failure(&format!("a = {}", "[".repeat(100_000))).starts_with("arm.muscles.toml:1:"));
    assert!(failure(&GOOD.replace("biceps", &"x".repeat(300))).contains("300 bytes long"));
}

#[test]
fn files_that_are_no_text_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.toml");
    std::fs::write(&path, b"# fine\n# \xff\n").expect("written");
    assert!(read(&path).expect_err("not text").to_string().contains("m.toml:2:3: not UTF-8"));
    assert!(matches!(read(folder.path()), Err(MuscleFileError::Read { .. })));
    assert!(matches!(read(&folder.path().join("none")), Err(MuscleFileError::Read { .. })));
}

#[test]
fn later_errors_are_located() {
    let file = read_text(&format!("{GOOD}{}", GOOD.replace("biceps", "other")));
    let at = |key: &str| {
        let error = MuscleError::Value { muscle: "other".into(), key: key.into(), what: "wrong".into() };
        file.locate(&error).to_string()
    };
    assert_eq!(at("insertion.offset"), "arm.muscles.toml:13:43: muscle `other`: wrong");
    assert_eq!(at("alpha"), "arm.muscles.toml:10:8: muscle `other`: wrong");
    let bone = |role| {
        let (muscle, bone) = ("other".into(), "x".into());
        file.locate(&MuscleError::UnknownBone { muscle, role, bone, nearest: String::new() }).to_string()
    };
    assert!(bone("field").starts_with("arm.muscles.toml:11:8:"));
    assert!(bone("origin").starts_with("arm.muscles.toml:12:19:"));
    let stranger = MuscleError::NoField { muscle: "nobody".into(), bone: "x".into() };
    assert!(MuscleFile::default().locate(&stranger).to_string().contains("nobody"));
}

#[test]
fn lists_that_are_too_long_are_refused() {
    let with = |line: &str| {
        let text = format!(
            "[[muscle]]\nname = \"m\"\nbone = \"b\"\norigin = {{ bone = \"b\", offset = [0, 0, 0] }}\n\
             insertion = {{ bone = \"b\", offset = [0, 0.1, 0] }}\nwidth = 0.02\n{line}\n"
        );
        super::super::parse(&text, std::path::Path::new("m.toml")).map(drop).map_err(|e| e.to_string())
    };
    assert!(with("keys = { shape = [[0, 3, 3]] }").is_ok());
    for line in ["keys = { shape = [[0, 3, 3, 9]] }", "fibres = { count = 2, origin_line = [[0, 0, 0, 0.1]] }"] {
        let refused = with(line).expect_err("too long");
        assert!(refused.starts_with("m.toml:7:") && refused.contains("three numbers"), "{refused}");
    }
}

#[test]
fn a_list_of_collisions_leaves_out_what_it_does_not_name() {
    let of = |line: &str| read_text(&format!("{GOOD}{line}\n")).muscles[0].collides;
    assert_eq!(of(""), Collides::default());
    assert_eq!(of("collides = []"), Collides { bones: false, muscles: false, skin: false });
    assert_eq!(of("collides = [\"muscles\", \"muscles\"]"), Collides { bones: false, muscles: true, skin: false });
}

#[test]
fn joints_are_read_by_name() {
    let text = "joints.b = { operator = \"union\" }\n[joints.\"arm.L\"]\noperator = \"test-elbow\" # folds\n";
    let spec = |joint: &str, operator| JointSpec { joint: joint.into(), operator };
    let expected = [spec("arm.L", JointOperator::TestElbow), spec("b", JointOperator::Union)];
    assert_eq!(read_text(text).joints, expected);
    assert!(read_text(GOOD).joints.is_empty());
    for operator in JointOperator::ALL {
        let file = read_text(&format!("[joints.a]\noperator = \"{}\"\n", operator.name()));
        assert_eq!(file.joints, [spec("a", operator)]);
    }
}

#[test]
fn mistakes_at_joints_name_line_and_column() {
    for (text, start) in [
        (
            "[joints.a]\noperator = \"elbo\"",
            "2:12: unknown value `elbo`; did you mean `elbow`? Known are union, blend,",
        ),
        ("[joints.a]\noperater = \"elbow\"", "2:1: unknown key `operater`; did you mean `operator`?"),
        ("[joints.a]\noperator = 3", "2:12: `operator` must be the name of an operator in quotes"),
        ("[joints.a]", "1:1: key `operator` of `a` is missing"),
        ("joints = 3", "1:10: `joints` is 3, and must be a table, [joints.NAME]"),
        ("joints.a = 3", "1:12: `a` is 3, and must be a table"),
        ("[joints.a]\noperator = \"union\"\n[joints.a]\n", "3:"),
        ("x = 1\n[joints.\"\"]\noperator = \"union\"", "1:1: unknown key `x`"),
        ("[joints.\"\"]\noperator = \"union\"", "1:"),
    ] {
        let message = failure(text);
        assert!(message.starts_with(&format!("arm.muscles.toml:{start}")), "{message}");
    }
    let character = crate::rig::Character {
        joints: vec![crate::rig::Joint {
            name: "arm.L".into(),
            parent: None,
            node: 0,
            inverse_bind: glam::Mat4::IDENTITY,
        }],
        ..Default::default()
    };
    let checked = |name: &str| read_text(&format!("\n[joints.\"{name}\"]\noperator = \"union\"\n")).check(&character);
    assert!(checked("arm.L").is_ok());
    let message = checked("arm.l2").expect_err("no such joint").to_string();
    assert!(message.starts_with("arm.muscles.toml:2:") && message.contains("nearest names: arm.L"), "{message}");
}

#[test]
fn groups_are_read_by_name_and_mistakes_name_line_and_column() {
    let text =
        "[groups.\"arm.L\"]\njoints = [\"a\", \"b\"]\nseparate = true\n[groups.b]\njoints = [\"c\"]\npassive = false\n";
    let found = read_text(text).groups;
    let names: Vec<&str> = found.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["arm.L", "b"]);
    assert!(found[0].joints == ["a", "b"] && found[0].separate && found[0].passive.is_none());
    assert!(found[1].joints == ["c"] && !found[1].separate && found[1].passive == Some(false));
    assert!(read_text(GOOD).groups.is_empty());
    for (text, start) in [
        ("[groups.a]\njoint = []", "2:1: unknown key `joint`; did you mean `joints`?"),
        ("[groups.a]", "1:1: key `joints` of `a` is missing"),
        ("[groups.a]\njoints = \"b\"", "2:10: `joints` is the text \"b\", and must be a list of joints' names"),
        ("[groups.a]\njoints = [3]", "2:11: an item of `joints` is 3, and must be text in quotes"),
        ("[groups.a]\njoints = [\"b\"]\nseparate = 1", "3:12: `separate` is 1, and must be true or false"),
        ("groups = 3", "1:10: `groups` is 3, and must be a table, [groups.NAME]"),
        ("[groups.a]\njoints = [\"\"]", "2:11: group `a`: "),
        ("[groups.\"\"]\njoints = [\"b\"]", "1:"),
    ] {
        let message = failure(text);
        assert!(message.starts_with(&format!("arm.muscles.toml:{start}")), "{message}");
    }
    let joint =
        |name: &str| crate::rig::Joint { name: name.into(), parent: None, node: 0, inverse_bind: glam::Mat4::IDENTITY };
    let character = crate::rig::Character { joints: vec![joint("arm"), joint("hand")], ..Default::default() };
    for (text, start) in [
        ("[groups.\"a.b\"]\njoints = [\"arm\", \"hnd\"]", "2:18: group `a.b`: `hnd` is not a joint"),
        (
            "[groups.a]\njoints = [\"arm\"]\n[groups.b]\njoints = [\"arm\"]",
            "4:11: group `b`: joint `arm` stands in group `a`",
        ),
        ("[groups.a]\njoints = []", "2:10: group `a`: it has no joints"),
        ("\n[groups.a]\njoints = [\"arm\"]", "2:1: group `a`: a moves too little skin"),
    ] {
        let message = read_text(text).check(&character).expect_err("does not fit").to_string();
        assert!(message.starts_with(&format!("arm.muscles.toml:{start}")), "{message}");
    }
}
