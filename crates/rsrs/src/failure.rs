//! How a command ends: its exit code, and what a person reads when it fails.

use std::fmt;

use rsrs_core::comparison::Verdict;
use rsrs_pipeline::error::{help_of, texts, with_help};
use rsrs_render::comparison::Report;

use crate::notes::print_always;

/// How a command that did not fail ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done: exit code 0.
    Done,
    /// Done, and the answer is no, or data is lost: exit code 3.
    NegativeAnswer,
}

impl From<Verdict> for Outcome {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Violated => Self::NegativeAnswer,
            Verdict::Supported | Verdict::Undecided | Verdict::NoClaim => Self::Done,
        }
    }
}

impl From<&Report> for Outcome {
    fn from(report: &Report) -> Self {
        if report.has_lost_evidence() { Self::NegativeAnswer } else { report.verdict.into() }
    }
}

/// The exit code of arguments that cannot be.
pub const BAD_ARGUMENTS: u8 = 2;

/// An error in what was typed, which the parser of arguments cannot see.
#[derive(Debug)]
struct BadArguments(anyhow::Error);

impl fmt::Display for BadArguments {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(out)
    }
}

impl std::error::Error for BadArguments {}

/// Marks an error as one in what was typed.
pub fn bad_arguments(error: anyhow::Error) -> anyhow::Error {
    BadArguments(error).into()
}

/// Names the option with which something refused was given: an argument that was typed wrong.
pub fn check_flag(flag: &str, checked: anyhow::Result<()>) -> anyhow::Result<()> {
    checked.map_err(|error| {
        let message = format!("{flag}: {error}");
        bad_arguments(match help_of(&error) {
            Some(help) => with_help(message, help),
            None => anyhow::anyhow!(message),
        })
    })
}

/// Reports an error, and picks its exit code.
pub fn report_error(error: anyhow::Error) -> u8 {
    match error.downcast() {
        Ok(BadArguments(error)) => {
            print_error(&error);
            BAD_ARGUMENTS
        }
        Err(error) => {
            print_error(&error);
            1
        }
    }
}

/// Prints an error once, with its causes and the help that it carries.
fn print_error(error: &anyhow::Error) {
    let mut text = format!("error: {}\n", texts(error).join("\n  because "));
    if let Some(help) = help_of(error) {
        text.extend(["help: ", &help, "\n"]);
    }
    print_always(text);
}
