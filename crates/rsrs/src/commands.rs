//! One file for each subcommand; each has its arguments and one `run`.

pub mod answer;
pub mod bag;
pub mod campaign;
pub mod choose;
pub mod compare;
pub mod completions;
pub mod diagnose;
pub mod diagram;
pub mod diff;
pub mod draw;
pub mod dry_run;
pub mod episode;
pub mod explore;
pub mod film;
pub mod init;
pub mod keystore;
pub mod label;
pub mod measure;
pub mod merge;
pub mod node;
pub mod place;
pub mod plan_experiments;
pub mod replay;
pub mod report;
pub mod run;
pub mod schema;
pub mod stop;
pub mod sweep;
pub mod validate;
pub mod watch;

use std::io::{ErrorKind, Write};
use std::path::Path;

use anyhow::Context;
use clap::ValueEnum;
use rsrs_core::printable::lines;
use serde::Serialize;

use rsrs_render::wording::wrote;
use rsrs_render::words::Words;

/// How a command reports its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people.
    Text,
    /// For programs: `snake_case` keys with units.
    Json,
}

/// Prints a result to standard output in the format asked for.
pub fn report(
    format: Format,
    value: &impl Serialize,
    words: impl Into<Words>,
) -> anyhow::Result<()> {
    match format {
        Format::Text => print_text(words),
        Format::Json => {
            // JSON may hold what a terminal obeys, beyond what it escapes by itself.
            let json = serde_json::to_string_pretty(value).context("result as JSON")?;
            print_verbatim(&lines(&json))
        }
    }
}

/// Prints which file was written, for people.
pub fn report_written(format: Format, path: &Path) -> anyhow::Result<()> {
    match format {
        Format::Text => print_text(wrote(path)),
        Format::Json => Ok(()),
    }
}

/// Prints a line, or some, to standard output; colours only where a terminal shows them, or
/// `--color` asks for them. Whoever closes the pipe has read enough.
pub fn print_text(words: impl Into<Words>) -> anyhow::Result<()> {
    print_verbatim(&words.into().painted())
}

/// Prints a text to standard output as it is.
pub fn print_verbatim(text: &str) -> anyhow::Result<()> {
    match writeln!(anstream::stdout(), "{text}") {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.context("writing to standard output"),
    }
}
