//! Progress on standard error: for what takes over a second, and only where that is a terminal.

use crate::failure::Failure;
use crate::interrupt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::thread;
use std::time::Duration;

/// A bar that shows after a second and goes away when dropped.
#[derive(Debug)]
pub struct Progress(ProgressBar);

impl Progress {
    /// Work in `steps` steps.
    pub fn steps(what: &'static str, steps: u64) -> Progress {
        Progress::start(
            what,
            ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::hidden()),
            "{msg} {bar:30} {pos}/{len} {eta}",
        )
    }

    /// Work whose end is not known.
    pub fn unknown(what: &'static str) -> Progress {
        Progress::start(
            what,
            ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden()),
            "{spinner} {msg} {elapsed}",
        )
    }

    fn start(what: &'static str, bar: ProgressBar, template: &str) -> Progress {
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = bar.with_style(style).with_message(what);
        let shown = bar.downgrade();
        thread::spawn(move || {
            thread::sleep(Duration::from_secs(1));
            if let Some(bar) = shown.upgrade().filter(|bar| !bar.is_finished()) {
                bar.set_draw_target(ProgressDrawTarget::stderr());
                bar.enable_steady_tick(Duration::from_millis(100));
            }
        });
        Progress(bar)
    }

    /// One step is done; fails where the user has asked to stop before the next.
    pub fn step(&self) -> Result<(), Failure> {
        self.0.inc(1);
        interrupt::check()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
