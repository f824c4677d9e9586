//! `rsrs choose`: the most robust cell, confirmed.

use std::path::PathBuf;

use rsrs_core::diagram::choice::VIABLE_B_S_LOW;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::setting_arguments::SettingArguments;
use rsrs_pipeline::choose::Chosen;
use rsrs_pipeline::choose::pseudo_realities::{Draws, REPLICATES};
use rsrs_pipeline::choose::with_factors::choose_with_factors;
use rsrs_render::choice::{ChosenJson, text};

/// Choose the cell that may drift furthest while robots do what is wanted, and confirm it on fresh seeds.
///
/// What counts is the share of runs that end as wanted, in stable milling or what else the sweep is judged
/// for, smoothed over neighbouring cells, in the world in which it is smaller (robots made worse, or as
/// measured). Cells without a surely failing neighbour come first, then those deepest inside the region
/// where this share is viable.
///
/// In this order, cells are confirmed in both worlds until one is viable. Only these fresh runs count for
/// its `B_s`, because the best of many swept cells looks better than it is.
///
/// The output also states what a denser start and other numbers of robots would give, and which of the
/// factors that make robots worse matters in that cell: each alone, and all but each.
///
/// With `--pseudo-realities`, every cell is also run with profiles drawn around the intervals that
/// `rsrs measure fit` states, and not made worse. How often such robots do what is wanted, on average
/// and in the worst tenth of profiles, is shown beside `B_s` and decides nothing.
///
/// Exit code 3 means that no cell is viable; `rsrs diagnose FOLDER` finds what to change about the robots.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs choose results/flockbot
  rsrs choose results/flockbot --viable 0.9 -o results/flockbot/choice.json
  rsrs choose results/flockbot --pseudo-realities 100 --format json")]
pub struct Arguments {
    /// Folder of a sweep.
    folder: PathBuf,
    /// Least confirmed lower bound of `B_s` of a viable cell, in both worlds (default: 0.8).
    #[arg(long, value_name = "SHARE", default_value_t = VIABLE_B_S_LOW, hide_default_value = true,
          value_parser = crate::numbers::number("a share from 0 to 1", |share| (0.0..=1.0).contains(&share)))]
    viable: f64,
    /// Write the choice into this file too.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    setting: SettingArguments,
    /// Run the cells with this many profiles drawn around the intervals of the robots' own, too.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=10_000))]
    pseudo_realities: Option<u64>,
    /// How many times as wide as those intervals the draws are (default: 2).
    #[arg(long, value_name = "FACTOR", default_value_t = 2.0, hide_default_value = true,
          requires = "pseudo_realities",
          value_parser = crate::numbers::number("a factor above 0, such as 2", |factor| factor > 0.0))]
    widening: f64,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let options = arguments.setting.options(arguments.viable)?;
    let draws = arguments.pseudo_realities.map(|profiles| Draws {
        profiles,
        widening: arguments.widening,
        replicates: REPLICATES,
    });
    let (folder, output) = (&arguments.folder, arguments.output.as_deref());
    let found = choose_with_factors(folder, options, draws, output)?;
    let words = text(&found, folder, arguments.viable, output);
    report(arguments.format, &ChosenJson::from(&found), words)?;
    Ok(match found.chosen {
        Chosen::Viable(_) => Outcome::Done,
        Chosen::NoViableCell(_) => Outcome::NegativeAnswer,
    })
}
