use std::io;
use std::path::PathBuf;

/// Why a file could not be written. Nothing of it is left behind.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The folder, or a file in it, could not be made.
    #[error("{}: cannot be created: {source}; give -o a path in a folder that can be written", path.display())]
    Create {
        /// What was asked for.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The output path names something that a file cannot replace.
    #[error("{}: is a folder; give -o a file name", path.display())]
    IsFolder {
        /// What was asked for.
        path: PathBuf,
    },
    /// The output path names a file where a folder is needed.
    #[error("{}: is a file; give -o a folder for the frames", path.display())]
    NotAFolder {
        /// What was asked for.
        path: PathBuf,
    },
    /// A write failed, for instance because the disk is full.
    #[error("{}: cannot be written: {source}; nothing of it was kept", path.display())]
    Write {
        /// What was asked for.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A frame of a cache has another number of points than its header.
    #[error("{}: frame {frame} has {got} points, the cache was opened for {expected}", path.display())]
    PointCount {
        /// The cache.
        path: PathBuf,
        /// Frames written before this one.
        frame: u32,
        /// Points in the frame.
        got: usize,
        /// Points in the header.
        expected: usize,
    },
    /// A cache was closed with another number of frames than its header, or given one more.
    #[error("{}: {got} frames were given, the cache was opened for {expected}", path.display())]
    FrameCount {
        /// The cache.
        path: PathBuf,
        /// Frames given.
        got: u32,
        /// Frames in the header.
        expected: u32,
    },
    /// More points or frames than the format's 32-bit signed counters hold.
    #[error("{}: {what} is {got}, a PC2 cache holds at most 2147483647", path.display())]
    TooLarge {
        /// The cache.
        path: PathBuf,
        /// Which counter.
        what: &'static str,
        /// Its value.
        got: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("{}: frame {frame}, vertex {vertex} is not finite", path.display())]
    NotFinite {
        /// The output.
        path: PathBuf,
        /// Number of the frame.
        frame: u32,
        /// Index of the first such vertex.
        vertex: usize,
    },
    /// A picture's bytes do not match its size, or the encoder refused it.
    #[error("{}: cannot be encoded: {detail}", path.display())]
    Encode {
        /// The picture.
        path: PathBuf,
        /// What the encoder said.
        detail: String,
    },
}

impl OutputError {
    /// The same error about another path: for a file that is written elsewhere before it gets its name.
    pub(crate) fn at(mut self, named: PathBuf) -> OutputError {
        match &mut self {
            OutputError::Create { path, .. }
            | OutputError::IsFolder { path }
            | OutputError::NotAFolder { path }
            | OutputError::Write { path, .. }
            | OutputError::PointCount { path, .. }
            | OutputError::FrameCount { path, .. }
            | OutputError::TooLarge { path, .. }
            | OutputError::NotFinite { path, .. }
            | OutputError::Encode { path, .. } => *path = named,
        }
        self
    }
}
