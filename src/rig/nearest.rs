//! Names that look like a name that is not known.

/// The `count` names that look most like `name`, nearest first.
pub(in crate::rig) fn nearest<'a>(name: &str, among: impl Iterator<Item = &'a str>, count: usize) -> Vec<&'a str> {
    let mut names: Vec<(usize, &str)> = among.map(|other| (distance(name, other), other)).collect();
    names.sort_by_key(|(distance, _)| *distance);
    names.into_iter().take(count).map(|(_, name)| name).collect()
}

/// Characters of a name that are compared: a name without end costs no more than these.
const COMPARED: usize = 64;

/// Edits that turn one name into another, case aside (Levenshtein's distance).
fn distance(a: &str, b: &str) -> usize {
    let letters = |s: &str| s.chars().take(COMPARED).flat_map(char::to_lowercase).collect::<Vec<char>>();
    let (a, b) = (letters(a), letters(b));
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_comes_first() {
        let names = ["width", "volume", "side"];
        assert_eq!(nearest("widht", names.into_iter(), 1), ["width"]);
        assert_eq!(nearest("Volumes", names.into_iter(), 2)[0], "volume");
        assert_eq!(nearest(&"x".repeat(1 << 20), names.into_iter(), 3).len(), 3);
        assert!(nearest("a", std::iter::empty(), 1).is_empty());
    }

    #[test]
    fn distance_counts_edits() {
        assert_eq!(distance("upperarm_l", "upperarm_l"), 0);
        assert_eq!(distance("UpperArm_l", "upperarm_r"), 1);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("kitten", "sitting"), 3);
    }
}
