//! The names of the other side.

/// Pairs of patterns that name one side and the other.
///
/// A pattern matches where it stands for itself: `_l` in `biceps_l` and `thigh_l_twist`, not in `triceps_long`; `left` in
/// `left_arm`, not in `cleft`; `Left` also in the middle of `HeroLeftArm`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SideNames {
    pairs: Vec<(String, String)>,
}

impl SideNames {
    /// Names in use, from left to right: `_l`, `.L`, `left`, `Left_` and their like.
    pub fn left_to_right() -> SideNames {
        let pairs = ["_l _r", "_L _R", ".l .r", ".L .R", "-l -r", "-L -R", "l_ r_", "L_ R_", "l. r.", "L. R."];
        let words = ["left right", "Left Right", "LEFT RIGHT"];
        let split = |pair: &&str| pair.split_once(' ').map(|(a, b)| (a.to_owned(), b.to_owned()));
        SideNames { pairs: words.iter().chain(&pairs).filter_map(split).collect() }
    }

    /// The same names the other way.
    pub fn right_to_left() -> SideNames {
        SideNames::left_to_right().reversed()
    }

    /// One pattern and what stands in its place on the other side; an empty pattern matches nothing.
    pub fn pattern(from: &str, to: &str) -> SideNames {
        SideNames { pairs: vec![(from.into(), to.into())] }
    }

    /// The other way round.
    pub fn reversed(&self) -> SideNames {
        SideNames { pairs: self.pairs.iter().map(|(from, to)| (to.clone(), from.clone())).collect() }
    }

    /// The partner's name, where a pattern matches: the first that does is replaced everywhere.
    pub fn partner(&self, name: &str) -> Option<String> {
        self.pairs.iter().find_map(|(from, to)| replaced(name, from, to))
    }

    /// The partner's name, or the same where it belongs to both sides.
    pub fn other(&self, name: &str) -> String {
        self.partner(name).unwrap_or_else(|| name.to_owned())
    }
}

impl Default for SideNames {
    fn default() -> Self {
        SideNames::left_to_right()
    }
}

fn replaced(name: &str, from: &str, to: &str) -> Option<String> {
    if from.is_empty() {
        return None;
    }
    let (mut done, mut rest, mut found) = (String::new(), name, false);
    while let Some(at) = rest.find(from) {
        let (before, after) = (&rest[..at], &rest[at + from.len()..]);
        let whole =
            begins_word(from, done.chars().chain(before.chars()).last()) && ends_word(from, after.chars().next());
        done.push_str(before);
        done.push_str(if whole { to } else { from });
        found |= whole;
        rest = after;
    }
    done.push_str(rest);
    found.then_some(done)
}

/// Whether a pattern that begins with a letter begins a word after `before`.
fn begins_word(pattern: &str, before: Option<char>) -> bool {
    match (pattern.chars().next(), before) {
        (Some(first), Some(before)) if first.is_alphabetic() && before.is_alphabetic() => {
            first.is_uppercase() && before.is_lowercase()
        }
        _ => true,
    }
}

/// Whether a pattern that ends with one single letter ends a word before `after`; longer ones are words by themselves.
fn ends_word(pattern: &str, after: Option<char>) -> bool {
    let single = pattern.chars().rev().take_while(|c| c.is_alphabetic()).count() == 1;
    !(single && after.is_some_and(|c| c.is_alphanumeric()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partners_are_named_by_whole_words() {
        let names = SideNames::left_to_right();
        for (left, right) in [
            ("biceps_l", "biceps_r"),
            ("thigh_l_twist", "thigh_r_twist"),
            ("triceps_long_l", "triceps_long_r"),
            ("UpperArm.L", "UpperArm.R"),
            ("mixamorig:LeftArm", "mixamorig:RightArm"),
            ("heroLeftArm", "heroRightArm"),
            ("lefthand", "righthand"),
            ("l_arm", "r_arm"),
        ] {
            assert_eq!(names.partner(left).as_deref(), Some(right));
            assert_eq!(SideNames::right_to_left().partner(right).as_deref(), Some(left));
            assert_eq!(names.partner(right), None, "{right}");
        }
        for central in ["triceps_long", "cleft", "spine_01", "small_1", "", "pelvis", "_lower"] {
            assert_eq!(names.partner(central), None, "{central}");
            assert_eq!(names.other(central), central);
        }
    }

    #[test]
    fn a_pattern_of_ones_own_stands_alone() {
        let names = SideNames::pattern("Lt", "Rt");
        assert_eq!(names.partner("LtArm").as_deref(), Some("RtArm"));
        assert_eq!(names.partner("arm_l"), None);
        assert_eq!(SideNames::pattern("", "x").partner("arm"), None);
    }
}
