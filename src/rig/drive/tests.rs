//! Drivers, keys, blends and efforts against values worked out by hand, and against any input.

use super::*;
use crate::rig::muscle::{
    Attachment, Combine, Curve, Drive, Driver, Ease, MuscleShape, MuscleSize, MuscleSpec, ShapeCurve, Source,
};
use crate::rig::{Character, Joint, Key, Keyed, Pose};
use glam::{Mat4, Quat, Vec3};
use proptest::prelude::*;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_3, PI};

/// An upper arm turned by a bind of its own, and the lower arm 1 m along it.
fn character() -> Character {
    let upper = Mat4::from_rotation_translation(Quat::from_rotation_z(0.7), Vec3::new(0.1, 1.4, 0.0));
    let lower = upper * Mat4::from_rotation_translation(Quat::from_rotation_x(0.4), Vec3::Y);
    let joint =
        |name: &str, parent, bind: Mat4| Joint { name: name.into(), parent, node: 0, inverse_bind: bind.inverse() };
    Character { joints: vec![joint("upper", None, upper), joint("lower", Some(0), lower)], ..Character::default() }
}

/// The whole arm turned and scaled, and the elbow turned by `turn` in the lower arm's own space.
fn posed(turn: Quat) -> Pose {
    let character = character();
    let bind: Vec<Mat4> = character.joints.iter().map(Joint::bind).collect();
    let body =
        Mat4::from_scale_rotation_translation(Vec3::splat(1.7), Quat::from_rotation_y(2.0), Vec3::new(3.0, 0.0, 1.0));
    let local =
        bind[0].inverse() * bind[1] * Mat4::from_scale_rotation_translation(Vec3::new(1.0, 1.3, 1.0), turn, Vec3::ZERO);
    let upper = body * bind[0];
    let palette = vec![upper * bind[0].inverse(), upper * local * bind[1].inverse()];
    Pose { palette, ..Pose::default() }
}

fn spec(drivers: Vec<(Source, Combine)>) -> MuscleSpec {
    let end = |y| Attachment { bone: "upper".into(), offset: Vec3::Y * y, normal: Vec3::X };
    let mut spec = MuscleSpec::new("biceps", "upper", end(0.1), end(0.5), MuscleSize::Width(0.03));
    spec.active = MuscleShape { eccentricity: 0.8, width: 2.0, ..MuscleShape::ACTIVE };
    let drivers = drivers.into_iter().map(|(source, combine)| Driver { source, combine }).collect();
    spec.drive = Drive { drivers, keys: Combine::Max, attack: 0.0, decay: 0.0 };
    spec
}

fn parameters(spec: &MuscleSpec, pose: &Pose, ratio: f32) -> MuscleParameters {
    let drives = Drives::new(&character(), std::slice::from_ref(spec)).expect("a good muscle");
    drives.parameters(pose, &[ratio]).expect("a good pose")[0]
}

fn constant(value: f32) -> Source {
    Source::Constant(value)
}

fn rest() -> Pose {
    Pose::rest(&character())
}

fn line(from: (f32, f32), to: (f32, f32)) -> Curve {
    Curve { times: vec![from.0, to.0], values: vec![from.1, to.1], ..Curve::default() }
}

#[test]
fn length_ratios_drive_between_their_bounds() {
    let mut muscle = spec(vec![(Source::Length { min: 0.6, max: 1.0, invert: false }, Combine::Max)]);
    let cases = [
        (0.5, 1.0),
        (0.6, 1.0),
        (0.7, 0.75),
        (0.9, 0.25),
        (1.0, 0.0),
        (1.4, 0.0),
        (f32::NAN, 0.0),
        (f32::INFINITY, 0.0),
    ];
    for (ratio, expected) in cases {
        let got = parameters(&muscle, &rest(), ratio).activation;
        assert!((got - expected).abs() < 1e-6, "{ratio}: {got}");
    }
    muscle.drive.drivers[0].source = Source::Length { min: 0.6, max: 1.0, invert: true };
    for (ratio, expected) in [(0.6, 0.0), (0.7, 0.25), (1.0, 1.0), (f32::NAN, 0.0)] {
        let got = parameters(&muscle, &rest(), ratio).activation;
        assert!((got - expected).abs() < 1e-6, "inverted {ratio}: {got}");
    }
    muscle.drive.drivers[0].source = Source::Length { min: 0.8, max: 0.8, invert: false };
    assert_eq!([0.79, 0.81].map(|r| parameters(&muscle, &rest(), r).activation), [1.0, 0.0]);
    // A ratio that the caller leaves out is that of rest.
    let drives =
        Drives::new(&character(), &[spec(vec![(Source::Length { min: 0.0, max: 2.0, invert: false }, Combine::Max)])]);
    assert_eq!(drives.expect("good").parameters(&rest(), &[]).expect("good")[0].activation, 0.5);
}

#[test]
fn joint_angles_are_those_of_the_joint_itself() {
    let of = |axis, from, to, turn| {
        let source = Source::Angle { joint: "lower".into(), axis, from, to };
        parameters(&spec(vec![(source, Combine::Max)]), &posed(turn), 1.0).activation
    };
    // Rotations in f32, through the matrices of a whole character.
    let near = |got: f32, expected: f32| (got - expected).abs() < 1e-5;
    let flexed = Quat::from_rotation_x(FRAC_PI_3);
    for (what, got, expected) in [
        ("nothing moved", of(None, 0.0, PI, Quat::IDENTITY), 0.0),
        ("the whole turn", of(None, 0.0, FRAC_PI_2, flexed), 2.0 / 3.0),
        ("about the axis", of(Some(Vec3::X * 5.0), 0.0, FRAC_PI_2, flexed), 2.0 / 3.0),
        ("with its sign", of(Some(Vec3::NEG_X), 0.0, FRAC_PI_2, flexed), 0.0),
        ("a range that falls", of(Some(Vec3::NEG_X), 0.0, -FRAC_PI_2, flexed), 2.0 / 3.0),
        ("about another axis", of(Some(Vec3::Y), 0.0, FRAC_PI_2, flexed), 0.0),
        ("the twist of both", of(Some(Vec3::Y), 0.0, FRAC_PI_2, flexed * Quat::from_rotation_y(0.9)), 0.9 / FRAC_PI_2),
        ("the longer way round", of(Some(Vec3::X), 0.0, -PI, Quat::from_rotation_x(1.5 * PI)), 0.5),
    ] {
        assert!(near(got, expected), "{what}: {got} for {expected}");
    }
    assert!(!near(of(None, 0.0, FRAC_PI_2, Quat::from_rotation_x(FRAC_PI_3 + 0.01)), 2.0 / 3.0));
    // The root turns against the scene.
    let source = Source::Angle { joint: "upper".into(), axis: None, from: 0.0, to: 4.0 };
    let root = parameters(&spec(vec![(source, Combine::Max)]), &posed(Quat::IDENTITY), 1.0).activation;
    assert!((root - 0.5).abs() < 1e-5, "{root}");
}

#[test]
fn drivers_join_in_order_and_then_the_key() {
    use Combine::{Add, Max, Multiply};
    let of = |drivers: &[(f32, Combine)]| {
        parameters(&spec(drivers.iter().map(|&(v, c)| (constant(v), c)).collect()), &rest(), 1.0).activation
    };
    assert_eq!(of(&[]), 0.0);
    // The first one starts, however it joins.
    assert_eq!(of(&[(0.5, Multiply)]), 0.5);
    assert_eq!(of(&[(0.25, Max), (0.5, Max)]), 0.5);
    assert_eq!(of(&[(0.25, Max), (0.5, Add)]), 0.75);
    assert_eq!(of(&[(0.25, Max), (0.5, Multiply)]), 0.125);
    assert_eq!(of(&[(0.25, Max), (0.5, Add), (0.5, Multiply)]), 0.375);
    assert_eq!(of(&[(0.25, Max), (0.5, Multiply), (0.5, Add)]), 0.625);
    // Clamped at the end alone: a gain may pass 1 on the way.
    assert_eq!(of(&[(0.125, Max), (4.0, Multiply)]), 0.5);
    assert_eq!((of(&[(0.75, Max), (0.5, Add)]), of(&[(0.25, Max), (-0.5, Add)])), (1.0, 0.0));
    for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(of(&[(0.5, Max), (odd, Max)]), 0.0);
    }

    let mut muscle = spec(vec![(constant(0.25), Max)]);
    muscle.keys.activation = line((0.0, 0.0), (2.0, 1.0));
    let at = |muscle: &MuscleSpec, time| parameters(muscle, &Pose { time, ..rest() }, 1.0).activation;
    assert_eq!([0.25, 1.0, 9.0].map(|time| at(&muscle, time)), [0.25, 0.5, 1.0]);
    muscle.drive.keys = Multiply;
    assert_eq!(at(&muscle, 1.0), 0.125);
    muscle.drive.keys = Add;
    assert_eq!(at(&muscle, 1.0), 0.75);
    muscle.drive.drivers.clear();
    assert_eq!(at(&muscle, 1.0), 0.5);
}

#[test]
fn a_table_drives_over_time() {
    let curve = line((1.0, 0.0), (3.0, 1.0));
    let table = |curve| Source::Table { file: "a.csv".into(), column: "biceps".into(), curve };
    let muscle = spec(vec![(table(curve), Combine::Max)]);
    let at = |time| parameters(&muscle, &Pose { time, ..rest() }, 1.0).activation;
    assert_eq!([0.0, 1.5, 2.0, 4.0].map(at), [0.0, 0.25, 0.5, 1.0]);
    let unread = Drives::new(&character(), &[spec(vec![(table(Curve::default()), Combine::Max)])]);
    let line = unread.map(drop).expect_err("the table was not read").to_string();
    assert!(line.contains("muscle `biceps`: driver 1: column `biceps` of a.csv is not read"), "{line}");
}

#[test]
fn what_the_pose_keys_wins_over_the_file() {
    let mut muscle = spec(vec![(constant(0.25), Combine::Max)]);
    muscle.keys.activation = line((0.0, 0.5), (1.0, 0.5));
    muscle.keys.stiffness = line((0.0, 0.9), (1.0, 0.9));
    muscle.keys.width = line((0.0, 0.5), (1.0, 0.5));
    muscle.keys.eccentricity = line((0.0, 0.3), (1.0, 0.3));
    let file = parameters(&muscle, &rest(), 1.0);
    assert_eq!((file.activation, file.stiffness, file.eccentricity), (0.5, 0.9, 0.3));
    // Half way from width 1 to 2, times the key.
    assert_eq!(file.width, 0.75);
    let keyed = |muscle: &str, key| Keyed { muscle: muscle.into(), key };
    let mut pose = rest();
    pose.keyed = vec![
        keyed("biceps", Key::Activation(1.0)),
        keyed("triceps", Key::Stiffness(0.0)),
        keyed("biceps", Key::Activation(0.125)),
        keyed("biceps", Key::Width(2.0)),
    ];
    let both = parameters(&muscle, &pose, 1.0);
    // The last of two counts, and is joined with the driver's 0.25; other parameters stay with the file.
    assert_eq!((both.activation, both.width, both.stiffness, both.eccentricity), (0.25, 2.5, 0.9, 0.3));
    pose.activations = vec![0.75];
    assert_eq!(parameters(&muscle, &pose, 1.0).activation, 0.75);
    pose.activations = vec![f32::NAN];
    assert_eq!(parameters(&muscle, &pose, 1.0).activation, 0.0);
    let drives = Drives::new(&character(), &[muscle]).expect("good");
    pose.activations = vec![0.0; 2];
    assert!(drives.parameters(&pose, &[1.0]).unwrap_err().to_string().contains("2 activations and the muscle file 1"));
    pose.palette.pop();
    assert!(drives.parameters(&pose, &[1.0]).unwrap_err().to_string().contains("1 joint matrices"));
    assert_eq!((drives.index_of("biceps"), drives.index_of("triceps"), drives.len()), (Some(0), None, 1));
}

#[test]
fn shapes_blend_by_activation_and_by_key() {
    let mut muscle = spec(vec![(constant(0.25), Combine::Max)]);
    let got = parameters(&muscle, &rest(), 1.0);
    assert_eq!(got.shapes.pairs(), [((3, 3), 0.75), ((4, 7), 0.25)]);
    assert_eq!((got.eccentricity, got.width, got.stiffness), (0.2, 1.25, MuscleSpec::STIFFNESS));
    muscle.keys.shape = ShapeCurve { ease: Ease::Linear, times: vec![0.0, 4.0], shapes: vec![(2, 3), (5, 5)] };
    let at = |muscle: &MuscleSpec, time| parameters(muscle, &Pose { time, ..rest() }, 1.0).shapes;
    assert_eq!(at(&muscle, 1.0).pairs(), [((2, 3), 0.5625), ((5, 5), 0.1875), ((4, 7), 0.25)]);
    // A pair that is approached twice stands once.
    muscle.keys.shape.shapes[1] = (4, 7);
    assert_eq!(at(&muscle, 1.0).pairs(), [((2, 3), 0.5625), ((4, 7), 0.4375)]);
    // Keys between the default shapes: the weights of any time add up to 1.
    muscle.keys.shape.shapes = vec![(3, 3), (4, 7)];
    for step in 0..=400 {
        let blend = at(&muscle, step as f32 * 0.01);
        let sum: f32 = blend.pairs().iter().map(|(_, w)| w).sum();
        assert!((sum - 1.0).abs() <= 2.0 * f32::EPSILON, "{blend:?}");
        // And this is no blend of one pair, whose weight could not be wrong.
        assert!(step == 400 || blend.pairs()[0].1 < 1.0);
    }
    // Exponents that no profile has are taken to the nearest.
    let mut pose = rest();
    pose.keyed =
        vec![Keyed { muscle: "biceps".into(), key: Key::Shape { from: (0, 77), to: (0, 77), share: f32::NAN } }];
    assert_eq!(parameters(&muscle, &pose, 1.0).shapes.pairs(), [((1, 9), 0.75), ((4, 7), 0.25)]);
}

#[test]
fn drivers_that_name_nothing_are_refused_by_muscle() {
    let refused = |source| {
        let drives = Drives::new(&character(), &[spec(vec![(constant(1.0), Combine::Max), (source, Combine::Max)])]);
        drives.map(drop).expect_err("must be refused").to_string()
    };
    let angle = |joint: &str, axis, to| Source::Angle { joint: joint.into(), axis, from: 0.0, to };
    let unknown = refused(angle("lowre", None, 1.0));
    assert!(
        unknown.contains("muscle `biceps`: the driver's joint `lowre`") && unknown.contains("nearest names: lower"),
        "{unknown}"
    );
    assert!(refused(angle("lower", Some(Vec3::ZERO), 1.0)).contains("driver 2: its axis has no direction"));
    assert!(refused(angle("lower", Some(Vec3::NAN), 1.0)).contains("driver 2: its axis has no direction"));
    assert!(refused(angle("lower", None, f32::NAN)).contains("driver 2: its angles must be finite"));
    assert!(refused(Source::Length { min: f32::NAN, max: 1.0, invert: false }).contains("must be finite"));
    let mut muscle = spec(Vec::new());
    muscle.drive.decay = -1.0;
    assert!(Drives::new(&character(), &[muscle]).unwrap_err().to_string().contains("decay is -1 s"));
}

/// The activation at whole seconds/24 of a muscle that swings between 0 and 1, advanced at `fps`.
fn effort_at(fps: u32, attack: f32, decay: f32) -> Vec<f32> {
    let mut muscle = spec(vec![(Source::Length { min: 0.5, max: 1.0, invert: false }, Combine::Max)]);
    (muscle.drive.attack, muscle.drive.decay) = (attack, decay);
    let drives = Drives::new(&character(), &[muscle]).expect("good");
    let mut effort = Effort::new();
    let mut found = Vec::new();
    for frame in 0..=4 * fps {
        let time = frame as f32 / fps as f32;
        let mut pose = Pose { time, ..rest() };
        let ratio = 0.75 + 0.25 * (time * 5.0).sin();
        effort.advance(&drives, &mut pose, &[ratio]).expect("good");
        // 24, 30, 60 and 120 frames meet every sixth of a second.
        if frame * 6 % fps == 0 {
            found.push(pose.activations[0]);
        }
    }
    found
}

#[test]
fn attack_and_decay_hardly_depend_on_the_frame_rate() {
    // Straight targets between frames of 1/24 s miss a swing of 5 rad/s by (5/24)^2 / 8 of its height 0.5, which is 0.0027.
    const TOLERANCE: f32 = 0.006;
    let apart = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let finest = effort_at(240, 0.5, 0.8);
    assert_eq!(finest.len(), 25);
    for fps in [24, 30, 60, 120] {
        let found = effort_at(fps, 0.5, 0.8);
        assert!(apart(&found, &finest) < TOLERANCE, "{fps}: {}", apart(&found, &finest));
        // The limits are at work: without them, or a little slower, the result is another one.
        assert!(apart(&effort_at(fps, 0.0, 0.0), &finest) > 0.1);
        assert!(apart(&effort_at(fps, 0.5, 0.9), &finest) > 2.0 * TOLERANCE);
    }
}

#[test]
fn an_effort_rises_and_falls_no_faster_than_it_may() {
    let limited = |attack, decay| {
        let mut muscle = spec(Vec::new());
        (muscle.drive.attack, muscle.drive.decay) = (attack, decay);
        Drives::new(&character(), &[muscle]).expect("good")
    };
    let go = |drives: &Drives, effort: &mut Effort, time: f32, target: f32| {
        let mut pose = Pose { time, activations: vec![target], ..rest() };
        effort.advance(drives, &mut pose, &[1.0]).expect("good");
        pose.activations[0]
    };
    let drives = limited(2.0, 4.0);
    let mut effort = Effort::new();
    // The first call starts where it is asked to.
    assert_eq!(go(&drives, &mut effort, 0.0, 1.0), 1.0);
    // At once down: straight to 0 in half a second, but no more than 1/8 of the way.
    assert!((go(&drives, &mut effort, 0.5, 0.0) - 0.875).abs() < 1e-5);
    let checkpoint = effort.clone();
    // Down until the target is met after 0.875 / 2.25 s, then up at a half a second: to 5/6.
    assert!((go(&drives, &mut effort, 1.0, 1.0) - 5.0 / 6.0).abs() < 2e-3);
    // The same moment again changes nothing.
    let same = go(&drives, &mut effort, 1.0, 0.0);
    assert!((same - 5.0 / 6.0).abs() < 2e-3, "{same}");
    // Backwards, over a second on, and a time that is none start anew.
    for time in [0.9, 2.2, f32::NAN, 5.0] {
        assert_eq!(go(&drives, &mut effort, time, 0.3), 0.3, "{time}");
    }
    assert!(go(&drives, &mut effort, 5.9, 1.0) < 0.8);
    effort.reset();
    assert_eq!(go(&drives, &mut effort, 6.0, 0.1), 0.1);
    // A checkpoint goes on as the first did.
    let mut again = checkpoint.clone();
    assert!((go(&drives, &mut again, 1.0, 1.0) - same).abs() < 1e-6);
    // Steps between whole 1/240 s are not lost.
    let mut often = Effort::new();
    go(&drives, &mut often, 0.0, 0.0);
    let mut last = 0.0;
    for step in 1..=1000 {
        last = go(&drives, &mut often, step as f32 / 1000.0, 1.0);
    }
    assert!((last - 0.5).abs() < 1e-3, "{last}");
    // Without limits nothing is lost, not even to rounding; with one of them the other way is free.
    let (free, slow_rise) = (limited(0.0, 0.0), limited(1.0, 0.0));
    let (mut a, mut b) = (Effort::new(), Effort::new());
    for (frame, target) in [0.1f32, 0.7, 0.33333334, 1.0, 0.0].into_iter().enumerate() {
        assert_eq!(go(&free, &mut a, frame as f32 / 30.0, target), target);
        let got = go(&slow_rise, &mut b, frame as f32 / 30.0, target);
        assert!(got <= target + 1e-6 && (frame != 3 || got < 0.5), "{got}");
    }
}

#[test]
fn a_shape_joined_from_its_own_parts_is_whole() {
    for activation in (0..200).map(|i| i as f32 / 200.0) {
        let mut muscle = spec(vec![(Source::Constant(activation), Combine::Max)]);
        (muscle.active.alpha, muscle.active.beta) = (9, 9);
        muscle.keys.shape = ShapeCurve { ease: Ease::Linear, times: vec![0.0, 1.0], shapes: vec![(9, 9), (9, 9)] };
        let drives = Drives::new(&character(), &[muscle]).expect("joints are there");
        for time in (0..200).map(|i| i as f32 / 200.0) {
            let got = drives.parameters(&Pose { time, ..rest() }, &[1.0]).expect("a pose of two joints")[0];
            assert!(got.shapes.pairs().iter().all(|(_, w)| *w <= 1.0), "{got:?}");
        }
    }
}

fn any_source() -> impl Strategy<Value = Source> {
    let ranges = (-4.0f32..4.0, -4.0f32..4.0, any::<bool>());
    prop_oneof![
        ranges.prop_map(|(min, max, invert)| Source::Length { min, max, invert }),
        any::<f32>().prop_map(Source::Constant),
        (prop::option::of(0..3usize), -4.0f32..4.0, -4.0f32..4.0).prop_map(|(axis, from, to)| Source::Angle {
            joint: "lower".into(),
            axis: axis.map(|i| Vec3::AXES[i]),
            from,
            to
        }),
        (any::<[f32; 2]>(), any::<[f32; 2]>()).prop_map(|(a, b)| Source::Table {
            file: "t".into(),
            column: "c".into(),
            curve: line((a[0], b[0]), (a[1], b[1]))
        }),
    ]
}

fn any_combine() -> impl Strategy<Value = Combine> {
    prop_oneof![Just(Combine::Max), Just(Combine::Add), Just(Combine::Multiply)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_input_stays_in_range(
        drivers in prop::collection::vec((any_source(), any_combine()), 0..5),
        keys in any_combine(),
        values in any::<[f32; 10]>(),
        pairs in any::<[(u32, u32); 4]>(),
        matrices in any::<[[f32; 16]; 2]>(),
        finite in any::<bool>(),
        time in any::<f32>(),
        ratio in any::<f32>(),
    ) {
        let mut muscle = spec(drivers);
        muscle.drive.keys = keys;
        let curve = |i: usize| Curve { ease: Ease::Cubic, ..line((values[i], values[i + 1]), (values[i + 2], values[i + 3])) };
        muscle.keys.activation = curve(0);
        muscle.keys.width = curve(2);
        muscle.keys.eccentricity = curve(4);
        muscle.keys.stiffness = curve(6);
        muscle.rest.eccentricity = values[8];
        muscle.rest.width = values[9];
        (muscle.rest.alpha, muscle.rest.beta) = pairs[0];
        (muscle.active.alpha, muscle.active.beta) = pairs[1];
        muscle.keys.shape = ShapeCurve { ease: Ease::Linear, times: vec![values[0], values[1]], shapes: vec![pairs[2], pairs[3]] };
        let mut pose = if finite { posed(Quat::from_rotation_x(values[0] % 10.0)) } else { rest() };
        if !finite {
            pose.palette = matrices.iter().map(Mat4::from_cols_array).collect();
        }
        pose.time = time;
        let drives = Drives::new(&character(), &[muscle]).expect("a muscle whose joints are there");
        let got = drives.parameters(&pose, &[ratio]).expect("a pose of two joints")[0];
        prop_assert!((0.0..=1.0).contains(&got.activation), "{:?}", got);
        prop_assert!((0.0..=0.99).contains(&got.eccentricity), "{:?}", got);
        prop_assert!((0.0..=10.0).contains(&got.width), "{:?}", got);
        prop_assert!((0.0..=1.0).contains(&got.stiffness), "{:?}", got);
        let pairs = got.shapes.pairs();
        prop_assert!(!pairs.is_empty());
        prop_assert!(pairs.iter().all(|((a, b), w)| (1..=9).contains(a) && (1..=9).contains(b) && *w > 0.0 && *w <= 1.0));
        let sum: f32 = pairs.iter().map(|(_, w)| w).sum();
        prop_assert!((sum - 1.0).abs() < 1e-6, "{:?}", got);
        let mut effort = Effort::new();
        for at in [time, time + 0.3, ratio] {
            pose.time = at;
            pose.activations.clear();
            effort.advance(&drives, &mut pose, &[ratio]).expect("good");
            prop_assert!((0.0..=1.0).contains(&pose.activations[0]));
        }
    }
}
