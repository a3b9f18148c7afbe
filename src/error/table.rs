//! Why a table of activation cannot be read.

use thiserror::Error;

/// Why a table over time was refused. Every message is one line that names the file, the place and what to do.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum TableError {
    /// The file cannot be opened or read, or its path is not followed.
    #[error("{file}: the table cannot be read: {reason}; check the path, which is relative to the muscle file")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system said, or why the path is not followed.
        reason: String,
    },
    /// More than is read.
    #[error("{file}: the table has more than {most} {unit}; shorten it, or write fewer rows a second")]
    TooLarge {
        /// The file.
        file: String,
        /// What is counted.
        unit: &'static str,
        /// How many are read at most.
        most: u64,
    },
    /// Not what a table holds.
    #[error("{file}:{line}: column {column}: {what}; {remedy}")]
    Cell {
        /// The file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        what: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// A muscle asks for a column that the table does not have.
    #[error("{file}: the table has no column `{column}`; nearest names: {nearest}")]
    Column {
        /// The file.
        file: String,
        /// The column asked for.
        column: String,
        /// Columns that look like it.
        nearest: String,
    },
}
