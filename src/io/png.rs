//! Pictures as PNG files.

use crate::error::OutputError;
use crate::io::atomic::WholeFile;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::path::Path;

/// Writes an 8-bit sRGB RGBA picture, rows from the top, whole or not at all.
///
/// # Errors
/// [`OutputError::Encode`] where `rgba` is not `width * height * 4` bytes, else as [`WholeFile`].
pub fn write(path: &Path, width: u32, height: u32, rgba: &[u8]) -> Result<(), OutputError> {
    let expected = width as usize * height as usize * 4;
    if rgba.len() != expected || rgba.is_empty() {
        let detail = format!("{width} x {height} pixels need {expected} bytes and at least one, not {}", rgba.len());
        return Err(OutputError::Encode { path: path.to_owned(), detail });
    }
    let mut file = WholeFile::create(path)?;
    PngEncoder::new(&mut file).write_image(rgba, width, height, ExtendedColorType::Rgba8).map_err(
        |error| match error {
            image::ImageError::IoError(source) => OutputError::Write { path: path.to_owned(), source },
            other => OutputError::Encode { path: path.to_owned(), detail: other.to_string() },
        },
    )?;
    file.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_back_pixel_for_pixel_and_the_same_bytes_twice() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.png"), folder.path().join("b.png"));
        let rgba: Vec<u8> = (0..3 * 2 * 4).map(|i| (i * 10) as u8).collect();
        write(&a, 3, 2, &rgba).unwrap();
        write(&b, 3, 2, &rgba).unwrap();
        let read = image::open(&a).unwrap().into_rgba8();
        assert_eq!(read.dimensions(), (3, 2));
        assert_eq!(read.as_raw(), &rgba);
        assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
    }

    #[test]
    fn a_wrong_size_is_refused_and_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        assert!(matches!(write(&path, 2, 2, &[0; 15]), Err(OutputError::Encode { .. })));
        assert!(matches!(write(&path, 0, 0, &[]), Err(OutputError::Encode { .. })));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
