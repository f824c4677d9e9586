//! How a command ends: its exit code, and what a person reads when it fails.

use std::io::Write;

/// How a command that did not fail ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done: exit code 0.
    Done,
    /// Done, and the answer is no: exit code 3.
    NegativeAnswer,
}

/// An error with the command to type next.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct WithHelp {
    /// What went wrong: found and expected.
    pub message: String,
    /// What to do next.
    pub help: String,
}

/// Makes an error that says what to do next.
pub fn with_help(message: impl Into<String>, help: impl Into<String>) -> anyhow::Error {
    WithHelp { message: message.into(), help: help.into() }.into()
}

/// Says an error once, with its causes and the help that it carries.
pub fn say(error: &anyhow::Error) {
    let mut text = format!("error: {error}\n");
    let mut said = error.to_string();
    for cause in error.chain().skip(1) {
        let cause = cause.to_string();
        // Some errors print their cause themselves.
        if !said.contains(&cause) {
            text.extend(["  because ", &cause, "\n"]);
        }
        said = cause;
    }
    if let Some(help) = error.chain().find_map(|cause| cause.downcast_ref::<WithHelp>()) {
        text.extend(["help: ", &help.help, "\n"]);
    }
    // Nobody is left to tell when standard error is gone.
    drop(std::io::stderr().write_all(text.as_bytes()));
}
