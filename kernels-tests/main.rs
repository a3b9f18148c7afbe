//! Everything that needs a device, the command, or the sources: one binary, one shared device.
#![allow(clippy::unwrap_used)]

mod repo;
