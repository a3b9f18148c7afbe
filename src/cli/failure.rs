//! What ends the command early, and with which exit code.

use crate::interrupt;
use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;

/// Why the command did not end with 0.
#[derive(Debug)]
pub enum Failure {
    /// Something was compared and found wanting; the result has been printed. Exit code 1.
    #[cfg(feature = "gpu")]
    Findings(String),
    /// Flags that do not go together. Exit code 2.
    Usage(String),
    /// A file, a clip, a frame range or an output is wrong. Exit code 3.
    Input(String),
    /// There is no adapter, or it cannot do what is needed. Exit code 4.
    Device(String),
    /// The user stopped it. Exit code 130.
    Interrupted,
}

impl Failure {
    /// A file or an output is wrong.
    pub fn input(error: impl Display) -> Failure {
        Failure::Input(error.to_string())
    }

    /// The device is missing or failed.
    #[cfg(feature = "gpu")]
    pub fn device(error: impl Display) -> Failure {
        Failure::Device(error.to_string())
    }

    /// Prints the one line and gives the exit code.
    pub fn report(&self) -> ExitCode {
        let (code, text) = match self {
            #[cfg(feature = "gpu")]
            Failure::Findings(text) => (1, text.as_str()),
            Failure::Usage(text) => (2, text.as_str()),
            Failure::Input(text) => (3, text.as_str()),
            Failure::Device(text) => (4, text.as_str()),
            Failure::Interrupted => (interrupt::EXIT_CODE, "interrupted; nothing half-written is left"),
        };
        // Where standard error is closed there is nobody left to tell.
        let _ = writeln!(std::io::stderr(), "error: {}", one_line(text));
        ExitCode::from(code)
    }
}

/// Text with every run of blanks and line ends as one blank.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_of_several_lines_becomes_one() {
        assert_eq!(one_line("a.toml:\n  expected `=`\r\n\tat line 3\n"), "a.toml: expected `=` at line 3");
    }
}
