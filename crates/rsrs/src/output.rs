//! How much is printed and in which colours: options of all commands.

use std::sync::OnceLock;

use anstream::ColorChoice;
use clap::ValueEnum;
use rsrs_ros::logging;

/// Options that every command has.
#[derive(clap::Args)]
#[command(next_help_heading = "Global options")]
pub struct Output {
    /// When words are coloured: auto, always or never; `auto` is on a terminal, and obeys `NO_COLOR`
    /// and `CLICOLOR_FORCE` (default: auto).
    #[arg(
        long,
        global = true,
        value_name = "WHEN",
        value_enum,
        default_value = "auto",
        hide_default_value = true,
        hide_possible_values = true
    )]
    color: Colour,
    /// Print results, warnings and errors only.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Print what is done, file by file.
    #[arg(short, long, global = true)]
    verbose: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Colour {
    /// On a terminal.
    Auto,
    /// Everywhere.
    Always,
    /// Nowhere.
    Never,
}

/// How much is printed on standard error beside results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// Warnings, errors and questions.
    Needed,
    /// Notes and progress, too.
    Notes,
    /// And every file that is read or written.
    Steps,
}

static DETAIL: OnceLock<Detail> = OnceLock::new();

impl Output {
    /// Applies the options to this process, before the first word is printed.
    pub fn apply(&self) {
        match self.color {
            Colour::Auto => ColorChoice::Auto,
            Colour::Always => ColorChoice::Always,
            Colour::Never => ColorChoice::Never,
        }
        .write_global();
        let detail = match (self.quiet, self.verbose) {
            (true, _) => Detail::Needed,
            (false, true) => Detail::Steps,
            (false, false) => Detail::Notes,
        };
        DETAIL.get_or_init(|| detail);
        if detail == Detail::Steps {
            logging::init_steps();
        }
    }
}

/// How much this process prints.
pub fn detail() -> Detail {
    DETAIL.get().copied().unwrap_or(Detail::Notes)
}
