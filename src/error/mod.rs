//! Typed errors: what failed, in which file and element, and what to do about it.

mod field;

pub use field::{FieldError, HrbfError};
