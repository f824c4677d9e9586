//! How a command ends: its exit code, and what a person reads when it fails.

use rsrs_core::comparison::Verdict;
use rsrs_pipeline::compare::report::Report;
use rsrs_pipeline::error::{help_of, texts};

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

/// Prints an error once, with its causes and the help that it carries.
pub fn print_error(error: &anyhow::Error) {
    let mut text = format!("error: {}\n", texts(error).join("\n  because "));
    if let Some(help) = help_of(error) {
        text.extend(["help: ", &help, "\n"]);
    }
    print_always(text);
}
