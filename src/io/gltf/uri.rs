//! Where a URI of the file points: bytes inside it, or a file in the same folder.

use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;
use std::path::{Component, Path, PathBuf};

/// Exporters disagree about the final `=` and the spare bits before it.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// What a URI stands for.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// The bytes of a data URI.
    Data(Vec<u8>),
    /// A file, relative to the folder of the glTF file and inside it.
    File(PathBuf),
}

/// Reads a URI; the error says what is wrong with it.
pub(super) fn resolve(uri: &str) -> Result<Target, String> {
    match uri.get(..5) {
        Some(scheme) if scheme.eq_ignore_ascii_case("data:") => data(&uri[5..]).map(Target::Data),
        _ => relative(uri).map(Target::File),
    }
}

fn data(rest: &str) -> Result<Vec<u8>, String> {
    let (header, payload) = rest.split_once(',').ok_or("its data URI has no comma before the data")?;
    let mut bytes: Vec<u8> = percent_decode_str(payload).collect();
    let base64 = header.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
    if !base64 {
        return Ok(bytes);
    }
    bytes.retain(|b| !b.is_ascii_whitespace());
    BASE64.decode(&bytes).map_err(|e| format!("its data URI is not base64 ({e})"))
}

fn relative(uri: &str) -> Result<PathBuf, String> {
    let decoded = percent_decode_str(uri).decode_utf8().map_err(|_| "its URI is not UTF-8".to_string())?;
    let shown = crate::error::one_line(&decoded);
    let scheme = decoded.split_once(':').is_some_and(|(before, _)| !before.contains('/'));
    if scheme {
        return Err(format!("its URI `{shown}` has a scheme, and only files beside the glTF file are read"));
    }
    let path = decoded.replace('\\', "/");
    if path.is_empty() || path.contains('\0') {
        return Err(format!("its URI `{shown}` names no file"));
    }
    let mut depth = 0i64;
    for component in Path::new(&path).components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => depth -= 1,
            Component::RootDir | Component::Prefix(_) => depth = i64::MIN,
        }
        if depth < 0 {
            return Err(format!("its URI `{shown}` leaves the folder of the glTF file, which is not followed"));
        }
    }
    Ok(PathBuf::from(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris_decode_with_and_without_padding_and_percent_encoding() {
        let expected = Target::Data(vec![0xfb, 0xff, 0x01, 0x00]);
        for uri in [
            "data:application/octet-stream;base64,+/8BAA==",
            "data:;base64,+/8BAA",
            "DATA:application/gltf-buffer;BASE64,%2B%2F8BAA%3D%3D",
            "data:a/b;base64,+/8B\n  AA==",
            "data:application/octet-stream,%FB%FF%01%00",
        ] {
            assert_eq!(resolve(uri).unwrap(), expected, "{uri}");
        }
        assert!(resolve("data:application/octet-stream;base64,+/8?AA==").is_err());
        assert!(resolve("data:application/octet-stream").is_err());
    }

    #[test]
    fn only_files_inside_the_folder_are_followed() {
        assert_eq!(resolve("a%20b/c.bin").unwrap(), Target::File("a b/c.bin".into()));
        assert_eq!(resolve("a\\c.bin").unwrap(), Target::File("a/c.bin".into()));
        assert_eq!(resolve("a/../c.bin").unwrap(), Target::File("a/../c.bin".into()));
        for uri in [
            "../c.bin",
            "a/../../c.bin",
            "%2e%2e/c.bin",
            "..\\c.bin",
            "/etc/passwd",
            "%2Fetc/passwd",
            "\\\\host\\x",
            "file:///etc/passwd",
            "https://example.org/c.bin",
            "C:\\c.bin",
            "",
            "a\0b",
            "../a/b/c.bin",
        ] {
            assert!(resolve(uri).is_err(), "{uri}");
        }
    }
}
