//! Tests of kernels against their twins, of the command, and of the repository's own rules: one process, one device.

mod layout;
//! Everything that needs a device, the command, or the sources: one binary, one shared device.
#![allow(clippy::unwrap_used)]

mod repo;
