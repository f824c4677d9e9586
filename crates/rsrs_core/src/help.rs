//! Errors that name what to do next.

use std::error::Error;
use std::fmt;

/// An error for which there may be advice.
pub trait Help: Error {
    /// What to do next, such as a command to type; `None` where the message is all there is.
    fn help(&self) -> Option<String>;

    /// Message and advice on one line.
    fn text_with_help(&self) -> String {
        match self.help() {
            Some(help) => format!("{self}; {help}"),
            None => self.to_string(),
        }
    }
}

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

impl Help for WithHelp {
    fn help(&self) -> Option<String> {
        Some(self.help.clone())
    }
}

/// Any error with its advice, as one type: so the advice is found again behind a `dyn Error`.
///
/// # Example
///
/// ```
/// use std::error::Error;
///
/// use rsrs_core::diagram::sweep_file::SweepFile;
/// use rsrs_core::help::{Help, Helpful};
///
/// let error = SweepFile::parse("sweep.yaml", "format: 1\nrobot: 9\n").unwrap_err();
/// let error: Box<dyn Error> = Helpful::from(error).into();
/// let help = error.downcast_ref::<Helpful>().and_then(Helpful::help);
/// assert!(help.is_some_and(|help| help.starts_with("the keys here are: ")));
/// ```
#[derive(Debug)]
pub struct Helpful(Box<dyn Help + Send + Sync>);

impl<E: Help + Send + Sync + 'static> From<E> for Helpful {
    fn from(error: E) -> Self {
        Self(Box::new(error))
    }
}

impl Helpful {
    /// An error from a message and what to do next.
    pub fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        WithHelp { message: message.into(), help: help.into(), cause: None }.into()
    }

    /// What to do next.
    pub fn help(&self) -> Option<String> {
        self.0.help()
    }
}

impl fmt::Display for Helpful {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(out)
    }
}

impl Error for Helpful {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.0.source()
    }
}
