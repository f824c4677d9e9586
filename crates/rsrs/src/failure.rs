//! How a command ends: its exit code, and what a person reads when it fails.

use std::error::Error;
use std::io::Write;

use rsrs_core::profile::BeyondLimits;
use rsrs_core::start_file::StartFileError;
use rsrs_experiment_runner::plan::SweptCellError;
use rsrs_fleet::experiment::ExperimentError;
use rsrs_fleet::fleet_file::FleetFileError;

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
    /// What caused it, where there is more to say.
    #[source]
    pub cause: Option<Box<dyn Error + Send + Sync>>,
}

/// Makes an error that says what to do next.
pub fn with_help(message: impl Into<String>, help: impl Into<String>) -> anyhow::Error {
    WithHelp { message: message.into(), help: help.into(), cause: None }.into()
}

/// Puts a message in front of an error, and what to do next behind it, where there is something.
pub fn explained(
    error: impl Error + Send + Sync + 'static,
    message: String,
    help: Option<&str>,
) -> anyhow::Error {
    match help {
        Some(help) => {
            WithHelp { message, help: help.to_owned(), cause: Some(Box::new(error)) }.into()
        }
        None => anyhow::Error::new(error).context(message),
    }
}

/// The command to type next, where an error knows it.
pub fn help_of(error: &anyhow::Error) -> Option<String> {
    error.chain().find_map(|cause| {
        let with_help = cause.downcast_ref().map(|with_help: &WithHelp| with_help.help.clone());
        let fleet = || cause.downcast_ref::<FleetFileError>()?.help();
        let experiment = || cause.downcast_ref::<ExperimentError>()?.help();
        let swept = || Some(cause.downcast_ref::<SweptCellError>()?.help());
        let limits = || Some(cause.downcast_ref::<BeyondLimits>()?.help());
        let starts = || cause.downcast_ref::<StartFileError>()?.help();
        with_help.or_else(starts).or_else(fleet).or_else(experiment).or_else(swept).or_else(limits)
    })
}

/// An error with its causes, each said once.
fn texts(error: &anyhow::Error) -> Vec<String> {
    let mut texts = vec![error.to_string()];
    let mut said = error.to_string();
    for cause in error.chain().skip(1) {
        let cause = cause.to_string();
        // Some errors print their cause themselves.
        if !said.contains(&cause) {
            texts.push(cause.clone());
        }
        said = cause;
    }
    texts
}

/// An error with its causes on one line, as one of several.
pub fn in_one_line(error: &anyhow::Error) -> String {
    texts(error).join(": ")
}

/// Says an error once, with its causes and the help that it carries.
pub fn print_error(error: &anyhow::Error) {
    let mut text = format!("error: {}\n", texts(error).join("\n  because "));
    if let Some(help) = help_of(error) {
        text.extend(["help: ", &help, "\n"]);
    }
    // Nobody is left to tell when standard error is gone.
    drop(std::io::stderr().write_all(text.as_bytes()));
}
