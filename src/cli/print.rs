//! Standard output.

use crate::failure::{Failure, one_line};
use serde::Serialize;
use std::io::{self, ErrorKind, Write};

/// Prints `text` and a line end. A reader that has gone away ends the command quietly.
pub fn line(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush());
    match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => std::process::exit(0),
        other => other.map_err(|error| Failure::Input(format!("standard output: {error}"))),
    }
}

/// Prints a result: as indented JSON where that was asked for, else as the text.
pub fn result<R: Serialize>(json: bool, result: &R, text: impl FnOnce(&R) -> String) -> Result<(), Failure> {
    if json {
        line(&serde_json::to_string_pretty(result).map_err(Failure::input)?)
    } else {
        line(text(result).trim_end())
    }
}

#[derive(Serialize)]
struct Noted<'a, R> {
    #[serde(flatten)]
    result: &'a R,
    notes: &'a [String],
}

/// As [`result`], with what was odd but accepted: a field `notes` in JSON, else lines on standard error.
pub fn noted<R: Serialize>(
    json: bool,
    result: &R,
    notes: &[String],
    text: impl FnOnce(&R) -> String,
) -> Result<(), Failure> {
    if !json {
        let mut errors = io::stderr().lock();
        for note in notes {
            // Where standard error is closed there is nobody left to tell.
            let _ = writeln!(errors, "note: {}", one_line(note));
        }
    }
    self::result(json, &Noted { result, notes }, |noted| text(noted.result))
}
