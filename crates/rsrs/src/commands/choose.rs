//! `rsrs choose`: the most robust cell, confirmed.

use std::path::PathBuf;

use rsrs_core::diagram::choice::VIABLE_B_S_LOW;
use rsrs_core::quantity::Cell;
use serde::Serialize;

use crate::commands::{Format, print_text, report, report_written};
use crate::failure::Outcome;
use crate::setting_arguments::SettingArguments;
use rsrs_pipeline::choose::extension::extensions;
use rsrs_pipeline::choose::pseudo_realities::{
    Draws, InPseudoRealities, can_be_drawn, pseudo_realities,
};
use rsrs_pipeline::choose::{Chosen, choose, write};
use rsrs_pipeline::sweep::ablation::{Ablation, REPLICATES, ablate};
use rsrs_pipeline::sweep::folder;
use rsrs_render::choice::{
    NoViableCellJson, after_choice, after_none_viable, in_pseudo_realities, none_viable, to_keep,
    viable, wider,
};
use rsrs_render::factors;
use rsrs_render::words::Words;

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

/// Runs of each profile in each cell.
const RUNS_OF_EACH_PROFILE: u64 = 8;

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let options = arguments.setting.options(arguments.viable)?;
    if arguments.pseudo_realities.is_some() {
        // Before minutes of runs, not after them.
        can_be_drawn(&folder::read(&arguments.folder)?, arguments.widening)?;
    }
    match choose(&arguments.folder, options)? {
        Chosen::Viable(choice) => {
            if let Some(path) = &arguments.output {
                write(path, &choice)?;
            }
            let words = viable(&choice, arguments.viable);
            let extensions = extensions(&folder::read(&arguments.folder)?, &choice);
            let wider = wider(&arguments.folder, &extensions);
            let words = wider.into_iter().fold(words, Words::below);
            report_with_factors(arguments, &choice, &choice.cell, words)?;
            report_next(arguments)?;
            Ok(Outcome::Done)
        }
        Chosen::NoViableCell(none) => {
            let answer = NoViableCellJson::from(&none);
            report_with_factors(arguments, &answer, &none.best.cell, none_viable(&none))?;
            if arguments.format == Format::Text {
                print_text(after_none_viable(&arguments.folder, arguments.output.as_deref()))?;
            }
            Ok(Outcome::NegativeAnswer)
        }
    }
}

/// An answer, and which factors make the robots of its cell worse.
#[derive(Serialize)]
struct WithFactors<'a, T> {
    #[serde(flatten)]
    answer: &'a T,
    /// What every factor does in that cell; `null` if none changes a robot.
    factors: Option<Ablation>,
    /// What comes of all cells in pseudo-realities, where they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pseudo_realities: Option<InPseudoRealities>,
}

fn report_with_factors<T: Serialize>(
    arguments: &Arguments,
    answer: &T,
    cell: &Cell,
    words: Words,
) -> anyhow::Result<()> {
    let result = folder::read(&arguments.folder)?;
    let replicates = REPLICATES.min(arguments.setting.confirm);
    let execution = arguments.setting.threads.execution()?;
    let factors = ablate(&result.source, cell, replicates, execution)?;
    let draws = arguments.pseudo_realities.map(|profiles| Draws {
        profiles,
        widening: arguments.widening,
        replicates: RUNS_OF_EACH_PROFILE,
    });
    let result = result.of_robots(arguments.setting.robots)?;
    let pseudo_realities =
        draws.map(|draws| pseudo_realities(&result, draws, execution)).transpose()?;
    let words = match &factors {
        Some(factors) => words.below(factors::text(factors)),
        None => words,
    };
    let words = match &pseudo_realities {
        Some(found) => words.below(in_pseudo_realities(found, cell)),
        None => words,
    };
    report(arguments.format, &WithFactors { answer, factors, pseudo_realities }, words)
}

/// Where the choice was written, and what follows from it.
fn report_next(arguments: &Arguments) -> anyhow::Result<()> {
    if arguments.format == Format::Json {
        return Ok(());
    }
    let Some(path) = &arguments.output else {
        return print_text(to_keep(&arguments.folder));
    };
    report_written(Format::Text, path)?;
    print_text(after_choice(&arguments.folder))
}
