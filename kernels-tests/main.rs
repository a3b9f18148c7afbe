//! Tests of kernels against their twins, of the command, and of the repository's own rules: one process, one device.
#![allow(clippy::unwrap_used)]

mod layout;
mod repo;
fn main() {}
