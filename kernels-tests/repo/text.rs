//! Just enough reading of Rust to hold rules about it.

/// Rust text with comments gone and the contents of strings and characters blanked; lines stay where they are.
pub fn plain_code(text: &str) -> String {
    let source: Vec<char> = text.chars().collect();
    let mut code = String::with_capacity(text.len());
    let mut at = 0;
    while at < source.len() {
        let end = skip(&source, at);
        if end == at {
            code.push(source[at]);
            at += 1;
        } else {
            code.push('"');
            code.extend(source[at..end].iter().filter(|c| **c == '\n'));
            code.push('"');
            at = end;
        }
    }
    code
}

/// Where the comment, string or character that begins at `at` ends; `at` itself where none begins.
fn skip(source: &[char], at: usize) -> usize {
    let next = source.get(at + 1);
    match source[at] {
        '/' if next == Some(&'/') => find(source, at, |i| source[i] == '\n'),
        '/' if next == Some(&'*') => block_comment(source, at),
        '"' => quoted(source, at),
        'r' if !source[..at].last().is_some_and(|c| c.is_alphanumeric() || *c == '_') => raw(source, at),
        // A lifetime has no closing quote two characters on.
        '\'' if next == Some(&'\\') => find(source, at + 3, |i| source[i] == '\'') + 1,
        '\'' if source.get(at + 2) == Some(&'\'') => at + 3,
        _ => at,
    }
}

fn find(source: &[char], from: usize, stop: impl Fn(usize) -> bool) -> usize {
    (from..source.len()).find(|&i| stop(i)).unwrap_or(source.len())
}

fn block_comment(source: &[char], at: usize) -> usize {
    let (mut depth, mut i) = (0, at);
    while i + 1 < source.len() {
        match (source[i], source[i + 1]) {
            ('/', '*') => (depth, i) = (depth + 1, i + 2),
            ('*', '/') => (depth, i) = (depth - 1, i + 2),
            _ => i += 1,
        }
        if depth == 0 {
            return i;
        }
    }
    source.len()
}

fn quoted(source: &[char], at: usize) -> usize {
    let mut i = at + 1;
    while i < source.len() && source[i] != '"' {
        i += if source[i] == '\\' { 2 } else { 1 };
    }
    (i + 1).min(source.len())
}

fn raw(source: &[char], at: usize) -> usize {
    let open = find(source, at + 1, |i| source[i] != '#');
    if source.get(open) != Some(&'"') {
        return at;
    }
    let hashes = open - at - 1;
    let closes = |i: usize| source[i] == '"' && (1..=hashes).all(|h| source.get(i + h) == Some(&'#'));
    (find(source, open + 1, closes) + hashes + 1).min(source.len())
}

/// Plain code without the modules and functions marked `#[cfg(test)]` or `#[cfg(all(test, ..))]`.
pub fn without_tests(code: &str) -> String {
    let mut kept = String::new();
    let mut rest = code;
    while let Some(at) = ["#[cfg(test)]", "#[cfg(all(test,"].iter().filter_map(|mark| rest.find(mark)).min() {
        kept.push_str(&rest[..at]);
        let body = rest[at..].find(['{', ';']).map_or(rest.len(), |b| at + b);
        let mut depth = 0usize;
        let end = rest[body..].char_indices().find(|(_, c)| {
            match c {
                '{' => depth += 1,
                '}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            depth == 0
        });
        rest = end.map_or("", |(e, _)| &rest[body + e + 1..]);
    }
    kept + rest
}

/// What stands right after the crate's root in every path of a library file: `crate::NAME`, `crate::{NAME, ..}`, and
/// `super::` chains that reach the root.
pub fn crate_paths(path: &str, code: &str) -> Vec<String> {
    let inner = path.trim_start_matches("src/").trim_end_matches(".rs");
    let depth = inner.split('/').filter(|m| *m != "mod").count();
    let climb = "super::".repeat(depth);
    let mut found = Vec::new();
    for (root, deeper) in [("crate::", ""), (climb.as_str(), "super::")] {
        let mut from = 0;
        while let Some(at) = code[from..].find(root).map(|at| at + from) {
            let before = code[..at].trim_end_matches('$');
            let whole = !before.ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
            from = at + root.len();
            if whole && (deeper.is_empty() || !code[from..].starts_with(deeper)) {
                found.extend(heads(&code[from..]));
            }
        }
    }
    found
}

/// The first names of a path or of a braced group of paths.
fn heads(rest: &str) -> Vec<String> {
    let Some(group) = rest.strip_prefix('{') else {
        return identifier(rest).into_iter().collect();
    };
    let (mut depth, mut start, mut names) = (0usize, 0, Vec::new());
    for (i, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                names.extend(identifier(group[start..i].trim_start()));
                start = i + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    names
}

fn identifier(text: &str) -> Option<String> {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    (end > 0).then(|| text[..end].to_owned())
}

/// Whether the method `name` is called.
pub fn calls(code: &str, name: &str) -> bool {
    code.split('.').skip(1).any(|after| {
        after.trim_start().strip_prefix(name).is_some_and(|rest| rest.starts_with('(') || rest.starts_with("::<"))
    })
}

/// Whether `word` stands in the text by itself.
pub fn has_word(code: &str, word: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word).any(|(at, _)| {
        let goes_on = word.ends_with(part) && code[at + word.len()..].starts_with(part);
        let began_before = code[..at].ends_with(part);
        !(goes_on || began_before)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_strings_are_no_code() {
        let text =
            "a // x.unwrap()\nb /* c /* d */ e */ f \"g \\\" h\" r#\"i \" j\"# '\"' '\\'' 'k' fn l<'m>(r: R) {}\n";
        let code = plain_code(text);
        for gone in ["unwrap", "c", "d", "e", "g", "h", "i", "j", "k"] {
            assert!(!has_word(&code, gone), "{gone} in {code}");
        }
        for kept in ["a", "b", "f", "fn", "l", "m", "R"] {
            assert!(has_word(&code, kept), "{kept} not in {code}");
        }
        assert_eq!(code.lines().count(), text.lines().count());
    }

    #[test]
    fn test_modules_are_cut_and_what_follows_stays() {
        let code = "fn a() {}\n#[cfg(test)]\nmod tests { fn b() { {} } }\nfn c() {}\n#[cfg(test)]\nuse d;\nfn e() {}\n#[cfg(all(test, x))]\nmod f {}";
        let kept = without_tests(code);
        assert!(["a", "c", "e"].iter().all(|w| has_word(&kept, w)), "{kept}");
        assert!(["b", "d", "f", "tests"].iter().all(|w| !has_word(&kept, w)), "{kept}");
    }

    #[test]
    fn paths_from_the_root_are_found() {
        let code = "use crate::{math::{a, b}, rig::{self, Rig}, field}; $crate::io::x(); mycrate::no(); super::super::clip::y();";
        assert_eq!(crate_paths("src/gpu/rig.rs", code), ["math", "rig", "field", "io", "clip"]);
        assert_eq!(crate_paths("src/gpu/mod.rs", "use super::kernel;"), ["kernel"]);
        assert_eq!(crate_paths("src/gpu/instance.rs", "use super::kernels;"), [""; 0]);
    }

    #[test]
    fn words_and_calls_stand_alone() {
        assert!(
            calls("a\n  .unwrap()", "unwrap") && !calls("a.unwrap_or(b)", "unwrap") && !calls("unwrap(a)", "unwrap")
        );
        assert!(has_word("x println!()", "println!") && !has_word("eprintln!()", "println!"));
    }
}
