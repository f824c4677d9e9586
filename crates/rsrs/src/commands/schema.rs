//! `rsrs schema`: every key of every file.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use rsrs_pipeline::schema::{FileKind, reference};

use crate::commands::{Format, report};
use crate::failure::Outcome;

/// Print what may stand in a file: as JSON Schema for editors, or as a reference for people.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs schema sweep > sweep.schema.json
  rsrs schema --reference

An editor with YAML's language server takes the schema from the first line of a file:
  # yaml-language-server: $schema=sweep.schema.json")]
pub struct Arguments {
    /// Kind of file.
    #[arg(required_unless_present = "reference", value_parser = kinds())]
    kind: Option<FileKind>,
    /// All kinds of files and all axes, as Markdown.
    #[arg(long, conflicts_with = "kind")]
    reference: bool,
}

fn kinds() -> impl TypedValueParser<Value = FileKind> {
    let parser = PossibleValuesParser::new(FileKind::ALL.map(FileKind::key));
    parser.map(|key| FileKind::from_key(&key).expect("the parser takes no other words"))
}

/// Runs the command.
///
/// # Errors
///
/// If the schema cannot be written as JSON.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    match arguments.kind {
        Some(kind) => report(Format::Json, &kind.schema(), "")?,
        None => report(Format::Text, &(), reference().trim_end())?,
    }
    Ok(Outcome::Done)
}
