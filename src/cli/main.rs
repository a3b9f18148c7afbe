//! The `sinew` command: reads a rigged character, deforms it, and writes pictures and caches.
//!
//! Results go to standard output, progress and one `error:` line to standard error. Exit codes: 0 ok, 1 findings,
//! 2 wrong usage of flags, 3 bad input or output, 4 no device.

mod args;
mod bake;
#[cfg(feature = "gpu")]
mod compare;
#[cfg(feature = "gpu")]
mod crease;
mod deform;
mod demo;
#[cfg(feature = "gpu")]
mod device;
mod doctor;
mod explain;
mod extract;
mod extract_report;
mod failure;
mod figures;
mod inspect;
mod interrupt;
mod load;
mod loft_meshes;
mod muscle_meshes;
mod muscle_plots;
mod muscle_weights;
mod muscles;
mod parity;
mod playback;
mod print;
mod progress;
mod render;
mod schema;
#[cfg(feature = "gpu")]
mod studio;
mod validate;

use args::{Args, Verb};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let args = Args::parse();
    interrupt::listen();
    let done = match &args.verb {
        Verb::Demo(demo) => demo::run(demo),
        Verb::Inspect(inspect) => inspect::run(inspect),
        Verb::Render(render) => render::run(render),
        Verb::Bake(bake) => bake::run(bake),
        Verb::Parity(parity) => parity::run(parity),
        Verb::Validate(validate) => validate::run(validate),
        Verb::Extract(extract) => extract::run(extract),
        Verb::Muscles(muscles) => muscles::run(muscles),
        Verb::Schema => schema::run(),
        Verb::Figures(figures) => figures::run(figures),
        Verb::Doctor(doctor) => doctor::run(doctor),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
