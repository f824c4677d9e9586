//! Errors of the Rust crates as one Python exception.

use std::fmt::Display;
use std::path::Path;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rsrs_core::help::Help;
use rsrs_pipeline::error::{help_of, texts};

pyo3::create_exception!(
    rsrs,
    RsrsError,
    PyValueError,
    "What is wrong with what was given, and what to do about it.\n\n\
     The text is that of the command line; the line after `help:`, where there is one, is the way on."
);

/// What was given, and cannot be used.
pub fn refused(problem: impl Display) -> PyErr {
    RsrsError::new_err(problem.to_string())
}

/// The same with what to do about it.
pub fn refused_with_help(problem: impl Display, help: Option<String>) -> PyErr {
    match help {
        Some(help) => refused(format!("{problem}\nhelp: {help}")),
        None => refused(problem),
    }
}

/// An error of the pipeline with its causes.
pub fn raised(error: anyhow::Error) -> PyErr {
    refused_with_help(texts(&error).join(": "), help_of(&error))
}

/// An error of a pure crate with its causes.
pub fn helped(error: &(impl Help + 'static)) -> PyErr {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(next) = cause {
        let next_text = next.to_string();
        if !text.contains(&next_text) {
            text += &format!(": {next_text}");
        }
        cause = next.source();
    }
    refused_with_help(text, error.help())
}

/// A mistake of ours, which is no `ValueError`.
pub fn our_mistake(what: impl Display) -> PyErr {
    PyRuntimeError::new_err(format!("a mistake in rsrs, not in what it was given: {what}"))
}

/// The text of a panic.
pub fn panicked(payload: &(dyn std::any::Any + Send)) -> PyErr {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    our_mistake(text.unwrap_or_else(|| "no text".to_owned()))
}

/// A path as it is named in errors.
pub fn named(path: &Path) -> String {
    path.display().to_string()
}
