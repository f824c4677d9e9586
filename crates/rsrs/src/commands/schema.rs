//! `rsrs schema`: every key of every file, and every command.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Command, CommandFactory};
use rsrs_experiment_runner::causes::{of_bags, of_objects_and_readings};
use rsrs_fleet::causes;
use rsrs_pipeline::schema::FileKind;
use rsrs_render::reference::reference;

use crate::commands::{Format, report};
use crate::failure::Outcome;

/// Print what may stand in a file: as JSON Schema for editors, or as a reference for people.
///
/// With `--commands` it is what may be typed, with `--causes` what can go wrong in a run.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs schema sweep > sweep.schema.json
  rsrs schema --reference

An editor with YAML's language server takes the schema from the first line of a file:
  # yaml-language-server: $schema=sweep.schema.json")]
pub struct Arguments {
    /// Kind of file.
    #[arg(required_unless_present_any = ["reference", "commands", "causes"], value_parser = kinds())]
    kind: Option<FileKind>,
    /// All kinds of files and all axes, as Markdown.
    #[arg(long, conflicts_with = "kind")]
    reference: bool,
    /// The help of every command, as Markdown.
    #[arg(long, conflicts_with_all = ["kind", "reference"])]
    commands: bool,
    /// Everything that can go wrong in a run, with what it means and what to do, as Markdown.
    #[arg(long, conflicts_with_all = ["kind", "reference", "commands"])]
    causes: bool,
}

fn kinds() -> impl TypedValueParser<Value = FileKind> {
    let parser = PossibleValuesParser::new(FileKind::ALL.map(|kind| kind.key));
    parser.map(|key| FileKind::from_key(&key).expect("the parser takes no other words"))
}

pub fn run<C: CommandFactory>(arguments: &Arguments) -> anyhow::Result<Outcome> {
    match arguments.kind {
        Some(kind) => report(Format::Json, &kind.schema(), "")?,
        None if arguments.commands => report(Format::Text, &(), page_of_commands(C::command()))?,
        None if arguments.causes => {
            report(Format::Text, &(), causes::page(&[of_objects_and_readings(), of_bags()]))?;
        }
        None => report(Format::Text, &(), reference())?,
    }
    Ok(Outcome::Done)
}

/// Columns of the help on the page, whatever terminal there is.
const WIDTH: usize = 100;

/// The help of a command and of all below it, as on a terminal.
fn page_of_commands(command: Command) -> String {
    let mut command = command.term_width(WIDTH);
    command.build();
    let mut page = "# Commands\n\n\
        This page is what `rsrs schema --commands` prints: the help of every command, as with `--help`. \
        The global options of the first hold for all.\n"
        .to_owned();
    let mut waiting = vec![(command.get_name().to_owned(), &mut command)];
    while let Some((name, command)) = waiting.pop() {
        page.extend(["\n## ", &name, "\n\n```text\n", &help_of(command), "\n```\n"]);
        let below = command.get_subcommands_mut().filter(|below| below.get_name() != "help");
        let mut below: Vec<_> =
            below.map(|below| (format!("{name} {}", below.get_name()), below)).collect();
        below.reverse();
        for (_, command) in &mut below {
            hide_global_options(command);
        }
        waiting.append(&mut below);
    }
    page
}

/// Leaves out what the help of the first command has.
fn hide_global_options(command: &mut Command) {
    let shown = std::mem::take(command);
    *command = shown.mut_args(|option| {
        let is_global = option.is_global_set();
        if is_global { option.hide(true) } else { option }
    });
}

fn help_of(command: &mut Command) -> String {
    let help = command.render_long_help().to_string();
    let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
    lines.join("\n").trim().to_owned()
}
