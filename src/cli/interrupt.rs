//! Ctrl-C: the frame at hand is finished, and what was half written goes away; a second one ends the command at once.

use crate::failure::Failure;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Exit code of a command that was interrupted: 128 and the signal's number, as shells count.
pub const EXIT_CODE: u8 = 130;

/// Starts to listen. Where that cannot be, the system's own way stays: the command ends at once.
pub fn listen() {
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(EXIT_CODE.into());
        }
    });
}

/// Fails once the user has asked to stop.
pub fn check() -> Result<(), Failure> {
    if ASKED.load(Ordering::Relaxed) { Err(Failure::Interrupted) } else { Ok(()) }
}
