//! Errors that name what to do next.

use rsrs_core::help::{Help, Helpful};

pub use rsrs_core::help::WithHelp;

/// Makes an error from a message and what to do next.
pub fn with_help(message: impl Into<String>, help: impl Into<String>) -> anyhow::Error {
    Helpful::new(message, help).into()
}

/// Keeps the advice of an error findable by [`help_of`].
pub fn helped(error: impl Help + Send + Sync + 'static) -> anyhow::Error {
    Helpful::from(error).into()
}

/// What to do next, of the outermost error that has such advice.
pub fn help_of(error: &anyhow::Error) -> Option<String> {
    error.chain().find_map(|cause| cause.downcast_ref::<Helpful>()?.help())
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
