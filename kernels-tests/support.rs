//! The one device that every test of this process shares.

use sinew::gpu::{DeviceChoice, Headless};
use std::io::Write;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// The shared device, for one test at a time; `None` where `SINEW_SKIP_GPU=1` excuses a machine without one.
///
/// Software adapters are preferred, so that a test means the same on every machine; `SINEW_TEST_DEVICE` names another
/// (`auto` takes the best there is).
///
/// # Panics
/// Without an adapter: a test that did not run is not a test that passed.
pub fn headless() -> Option<MutexGuard<'static, Headless>> {
    static SHARED: OnceLock<Option<Mutex<Headless>>> = OnceLock::new();
    let shared = SHARED.get_or_init(|| {
        if std::env::var("SINEW_SKIP_GPU").is_ok_and(|v| v == "1") {
            announce("SINEW_SKIP_GPU=1: tests on a device are skipped");
            return None;
        }
        let opened = match std::env::var("SINEW_TEST_DEVICE") {
            Ok(name) if name == "auto" => Headless::new(&DeviceChoice::Auto),
            Ok(name) => Headless::new(&DeviceChoice::Named(name)),
            Err(_) => Headless::new(&DeviceChoice::Software).or_else(|_| Headless::new(&DeviceChoice::Auto)),
        };
        let headless = opened.unwrap_or_else(|e| panic!("{e} (or set SINEW_SKIP_GPU=1)"));
        announce(&format!("tests run on {} ({})", headless.info.name, headless.info.driver_info));
        Some(Mutex::new(headless))
    });
    shared.as_ref().map(|m| m.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Writes past the capture of test output: the line matters most when everything passes.
fn announce(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
