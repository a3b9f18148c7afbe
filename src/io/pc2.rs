//! Point caches in the PC2 format: a 32-byte header, then every frame's positions as little-endian f32 triples.

use crate::error::OutputError;
use crate::io::atomic::WholeFile;
use glam::Vec3;
use std::path::Path;

/// Writes a PC2 cache frame by frame; the file appears when [`Writer::finish`] succeeds.
#[derive(Debug)]
pub struct Writer {
    file: WholeFile,
    points: usize,
    samples: u32,
    written: u32,
    bytes: Vec<u8>,
}

impl Writer {
    /// Opens a cache of `samples` frames of `points` points each. `start_frame` is the number of the first frame;
    /// frames are one apart.
    ///
    /// # Errors
    /// [`OutputError::TooLarge`] beyond the format's counters, else as [`WholeFile::create`].
    pub fn create(path: &Path, points: usize, start_frame: u32, samples: u32) -> Result<Writer, OutputError> {
        let counter = |what, value: usize| {
            i32::try_from(value).map_err(|_| OutputError::TooLarge { path: path.to_owned(), what, got: value })
        };
        let point_counter = counter("the number of points", points)?;
        let sample_counter = counter("the number of frames", samples as usize)?;
        let mut file = WholeFile::create(path)?;
        file.put(b"POINTCACHE2\0")?;
        file.put(&1i32.to_le_bytes())?;
        file.put(&point_counter.to_le_bytes())?;
        file.put(&(start_frame as f32).to_le_bytes())?;
        file.put(&1f32.to_le_bytes())?;
        file.put(&sample_counter.to_le_bytes())?;
        Ok(Writer { file, points, samples, written: 0, bytes: Vec::with_capacity(points * 12) })
    }

    /// Appends one frame, metres in scene space.
    ///
    /// # Errors
    /// [`OutputError::PointCount`], [`OutputError::FrameCount`], [`OutputError::NotFinite`], [`OutputError::Write`].
    pub fn frame(&mut self, positions: &[Vec3]) -> Result<(), OutputError> {
        let path = || self.file.path().to_owned();
        if positions.len() != self.points {
            return Err(OutputError::PointCount {
                path: path(),
                frame: self.written,
                got: positions.len(),
                expected: self.points,
            });
        }
        if self.written == self.samples {
            return Err(OutputError::FrameCount { path: path(), got: self.written + 1, expected: self.samples });
        }
        if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
            return Err(OutputError::NotFinite { path: path(), frame: self.written, vertex });
        }
        self.bytes.clear();
        self.bytes.extend(positions.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes));
        self.file.put(&self.bytes)?;
        self.written += 1;
        Ok(())
    }

    /// Gives the cache its name.
    ///
    /// # Errors
    /// [`OutputError::FrameCount`] where frames are missing, [`OutputError::Write`].
    pub fn finish(self) -> Result<(), OutputError> {
        if self.written != self.samples {
            return Err(OutputError::FrameCount {
                path: self.file.path().to_owned(),
                got: self.written,
                expected: self.samples,
            });
        }
        self.file.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tiny_cache_has_exactly_these_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tiny.pc2");
        let mut writer = Writer::create(&path, 2, 7, 1).unwrap();
        writer.frame(&[Vec3::new(1.0, -2.0, 0.5), Vec3::ZERO]).unwrap();
        writer.finish().unwrap();
        #[rustfmt::skip]
        let expected: [u8; 56] = [
            b'P', b'O', b'I', b'N', b'T', b'C', b'A', b'C', b'H', b'E', b'2', 0,
            1, 0, 0, 0, // version
            2, 0, 0, 0, // points
            0, 0, 0xe0, 0x40, // first frame 7.0
            0, 0, 0x80, 0x3f, // one frame per sample
            1, 0, 0, 0, // samples
            0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 0, 0, 0, 0x3f,
            0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
        ];
        assert_eq!(std::fs::read(&path).unwrap(), expected);
    }

    #[test]
    fn wrong_counts_and_non_finite_points_are_refused_and_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bad.pc2");
        let mut writer = Writer::create(&path, 1, 0, 2).unwrap();
        assert!(matches!(writer.frame(&[]), Err(OutputError::PointCount { got: 0, expected: 1, .. })));
        let nan = [Vec3::new(0.0, f32::NAN, 0.0)];
        assert!(matches!(writer.frame(&nan), Err(OutputError::NotFinite { vertex: 0, .. })));
        writer.frame(&[Vec3::ONE]).unwrap();
        assert!(matches!(writer.finish(), Err(OutputError::FrameCount { got: 1, expected: 2, .. })));
        let mut writer = Writer::create(&path, 1, 0, 1).unwrap();
        writer.frame(&[Vec3::ONE]).unwrap();
        assert!(matches!(writer.frame(&[Vec3::ONE]), Err(OutputError::FrameCount { got: 2, expected: 1, .. })));
        drop(writer);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn counters_beyond_the_format_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("huge.pc2");
        let error = Writer::create(&path, 1 << 31, 0, 1).unwrap_err();
        assert!(matches!(error, OutputError::TooLarge { got: 0x8000_0000, .. }));
    }
}
