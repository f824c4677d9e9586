//! Errors that name what to do next.

use std::error::Error;

use rsrs_core::conditions::start_file::StartFileError;
use rsrs_core::robot::profile::BeyondLimits;
use rsrs_experiment_runner::plan::SweptCellError;
use rsrs_fleet::experiment::ExperimentError;
use rsrs_fleet::fleet_file::FleetFileError;

/// An error with the command to type next.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct WithHelp {
    /// What went wrong: found and expected.
    pub message: String,
    /// What to do next.
    pub help: String,
    /// What caused it, where there is more.
    #[source]
    pub cause: Option<Box<dyn Error + Send + Sync>>,
}

/// Makes an error with what to do next.
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

/// The command to type next, where an error has one.
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

/// An error with its causes, each once.
pub fn texts(error: &anyhow::Error) -> Vec<String> {
    let mut texts = vec![error.to_string()];
    let mut printed = error.to_string();
    for cause in error.chain().skip(1) {
        let cause = cause.to_string();
        // Some errors print their cause themselves.
        if !printed.contains(&cause) {
            texts.push(cause.clone());
        }
        printed = cause;
    }
    texts
}

/// An error with its causes on one line, as one of several.
pub fn in_one_line(error: &anyhow::Error) -> String {
    texts(error).join(": ")
}
