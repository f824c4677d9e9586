//! Why a file is not what it should be: no such document, or one with a flaw.

use std::error::Error;

use serde::de::DeserializeOwned;

use super::{DocumentError, parse};
use crate::help::Help;

/// Why a file is not what it should be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError<P> {
    /// The text is no such document.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// It is, and cannot be meant so.
    #[error("{file}:{line}: {problem}")]
    Flaw {
        /// The file.
        file: String,
        /// Line of the part that is wrong, from 1.
        line: u64,
        /// What is wrong there.
        problem: P,
    },
}

impl<P> FileError<P> {
    /// A flaw in a part of a document, which is read once more to find its line, from 1, among the
    /// places of all parts; what has no place is in the first line.
    pub(crate) fn flaw<Lines: DeserializeOwned>(
        (file, text): (&str, &str),
        problem: P,
        line: impl FnOnce(&Lines) -> Option<u64>,
    ) -> Self {
        let lines = parse::<Lines>(file, text).ok();
        let line = lines.as_ref().and_then(line).unwrap_or(1);
        Self::Flaw { file: file.to_owned(), line, problem }
    }
}

impl<P: Help + Error> Help for FileError<P> {
    fn help(&self) -> Option<String> {
        match self {
            Self::Document(error) => error.help(),
            Self::Flaw { problem, .. } => problem.help(),
        }
    }
}
