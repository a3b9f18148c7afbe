//! What a muscle lies round.

use super::super::*;
use super::read::{GOOD, read_text, with};

#[test]
fn mistakes_in_a_wrap_name_line_and_column() {
    for (text, start) in [
        ("wrap = { kind = \"sphere\", radius = 0.02 }", "8:8: muscle `biceps`: a sphere needs `joint`"),
        ("wrap = { kind = \"cylinder\", radius = 0.02 }", "8:8: muscle `biceps`: a cylinder needs `bone`"),
        ("wrap = { kind = \"cube\", radius = 0.02 }", "8:17: unknown value `cube`; did you mean"),
        ("wrap = { joint = \"a\", radius = 0.02 }", "8:8: muscle `biceps`: key `kind` of `wrap` is missing"),
        (
            "wrap = { kind = \"sphere\", joint = \"a\", bone = \"b\", radius = 0.02 }",
            "8:47: muscle `biceps`: a sphere is",
        ),
        (
            "wrap = { kind = \"cylinder\", joint = \"a\", bone = \"b\", radius = 0.02 }",
            "8:37: muscle `biceps`: a cylinder",
        ),
        ("wrap = { kind = \"sphere\", joint = \"\", radius = 0.02 }", "8:35: muscle `biceps`: joint is empty"),
        (
            "wrap = { kind = \"sphere\", joint = \"a\", radius = 0 }",
            "8:49: muscle `biceps`: radius is 0, and must be a",
        ),
        (
            "wrap = { kind = \"sphere\", joint = \"a\", radius = 1, side = [0, inf, 0] }",
            "8:63: muscle `biceps`: side holds",
        ),
        (
            "wrap = { kind = \"sphere\", joint = \"a\", radius = 1, from = [0, 0, 0] }",
            "8:59: muscle `biceps`: a wrap has both",
        ),
        (
            "wrap = { kind = \"sphere\", joint = \"a\", radius = 1, from = [0, 0, 0], to = [0, 1, 0] }",
            "8:59: muscle `biceps`: a sphere has no ends",
        ),
        (
            "wrap = { kind = \"cylinder\", bone = \"a\", radius = 1, from = [0, 0, 0], to = [0, 0, 0] }",
            "8:76: muscle `biceps`: from and to are the same point",
        ),
    ] {
        let message = with(text);
        assert!(message.starts_with(&format!("arm.muscles.toml:{start}")), "{text}: {message}");
    }
}

#[test]
fn what_a_muscle_lies_round_is_looked_for_in_the_character() {
    let joint =
        |name: &str| crate::rig::Joint { name: name.into(), parent: None, node: 0, inverse_bind: glam::Mat4::IDENTITY };
    let character = Character { joints: ["upperarm", "lowerarm"].map(joint).into(), ..Character::default() };
    let checked = |wrap: &str| read_text(&format!("{GOOD}wrap = {{ {wrap}, radius = 0.02 }}\n")).check(&character);
    checked("kind = \"sphere\", joint = \"lowerarm\"").expect("a joint of the character");
    checked("kind = \"cylinder\", bone = \"upperarm\"").expect("a bone of the character");
    for (wrap, message) in [
        (
            "kind = \"sphere\", joint = \"lowerram\"",
            "8:35: muscle `biceps`: the wrap's joint `lowerram` is not a joint",
        ),
        ("kind = \"cylinder\", bone = \"uperarm\"", "8:36: muscle `biceps`: the wrap's bone `uperarm` is not a joint"),
    ] {
        let error = checked(wrap).expect_err("must be refused").to_string();
        assert!(error.starts_with(&format!("arm.muscles.toml:{message}")), "{error}");
        assert!(error.contains("nearest names: "), "{error}");
    }
}

#[test]
fn a_wrap_stays_as_it_stands_when_other_keys_change() {
    let wrap = "wrap = { radius = 2e-2, kind = \"cylinder\", bone = \"lowerarm\" } # over the ulna\n";
    let other = GOOD.replace("biceps", "other");
    let text = format!("{GOOD}{wrap}{other}stiffness = 0.7\n");
    let mut document = Document::parse(&text, Path::new("arm.muscles.toml")).expect("a good file");
    document.copy("other", &["biceps"], &[Settings::Physics]).expect("copied");
    assert!(document.to_string().contains(wrap), "{document}");
    let file = document.file().expect("good");
    assert!(file.muscles[0].stiffness == 0.7 && file.muscles[0].wrap.is_some());
    assert!(file.muscles[1].wrap.is_none(), "wraps are not copied");
}
