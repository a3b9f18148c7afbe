//! Regions that must yield their muscle.

use super::super::*;
use std::path::Path;

fn parsed(text: &str) -> Result<MuscleFile, String> {
    parse(text, Path::new("a.muscles.toml")).map_err(|error| error.to_string())
}

#[test]
fn marks_are_read() {
    let file = parsed(
        "[[mark]]\nregion = \"thigh_l\"\ndegrees = [150.0, 210]\nname = \"hamstrings\"\n\n[[mark]]\nregion = \"chest_r\"\ndegrees = [20, 60]\n",
    );
    let marks = file.expect("a good file").marks;
    assert_eq!((marks[0].region.as_str(), marks[0].name.as_deref()), ("thigh_l", Some("hamstrings")));
    assert!(marks[0].holds(-170.0) && marks[0].holds(170.0) && !marks[0].holds(0.0));
    assert_eq!((marks.len(), marks[1].degrees, &marks[1].name), (2, [20.0, 60.0], &None));
    assert!(parsed("").expect("an empty file").marks.is_empty());
}

#[test]
fn mistakes_in_a_mark_name_line_and_column() {
    for (text, start) in [
        ("degrees = [0, 20]", "a.muscles.toml:1:1: key `region`"),
        ("region = \"a\"", "a.muscles.toml:1:1: key `degrees`"),
        ("region = \"\"\ndegrees = [0, 20]", "a.muscles.toml:2:10: mark ``: region is empty"),
        ("region = \"a\"\ndegrees = [20, 0]", "a.muscles.toml:3:11: mark `a`: degrees go from 20 to 0"),
        ("region = \"a\"\ndegrees = [0, nan]", "a.muscles.toml:3:11: mark `a`: degrees go from 0 to NaN"),
        ("region = \"a\"\ndegrees = [0, 400]", "a.muscles.toml:3:11: mark `a`: degrees go"),
        ("region = \"a\"\ndegrees = 3", "a.muscles.toml:3:11: "),
        ("region = \"a\"\ndegree = [0, 3]", "a.muscles.toml:3:1: "),
    ] {
        let refused = parsed(&format!("[[mark]]\n{text}\n")).expect_err("refused");
        println!("{refused}");
        assert!(refused.starts_with(start), "{text}: {refused}");
    }
}
