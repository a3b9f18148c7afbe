//! Typed errors: what failed, in which file and element, and what to do about it.

mod output;

pub use output::OutputError;
