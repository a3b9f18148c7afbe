//! Tests that need a device or the command. One process, one device, one test on it at a time.

mod render;
mod support;
fn main() {}
