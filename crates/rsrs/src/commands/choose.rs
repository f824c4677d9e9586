//! `rsrs choose`: the most robust milling cell, confirmed.

use std::path::PathBuf;

use anyhow::Context;
use rsrs_core::choice::{Choice, VIABLE_B_S_LOW, rank};
use rsrs_core::comparison::Share;
use rsrs_core::phase::Phase;
use rsrs_sim::sweep::Runs;
use serde::Serialize;

use crate::commands::sweep::watched;
use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::progress::threads;
use crate::result_folder::{self, SweepResult, write_file};

/// Choose the milling cell that may drift furthest, and confirm it on fresh seeds.
///
/// Cells are ranked by their depth inside the region where the lower bound of `B_s` is at least 0.5.
/// The winner looks better than it is, so only fresh runs feed its `B_s`. Exit code 3 says that no
/// cell is viable.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of a sweep.
    folder: PathBuf,
    /// Fresh runs that confirm the winner (default: 1000).
    #[arg(long, value_name = "N", default_value_t = 1000, hide_default_value = true,
          value_parser = clap::value_parser!(u64).range(1..))]
    confirm: u64,
    /// Least confirmed lower bound of `B_s` of a viable cell (default: 0.8).
    #[arg(long, value_name = "SHARE", default_value_t = VIABLE_B_S_LOW, hide_default_value = true)]
    viable: f64,
    /// Write the choice into this file too.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Threads (default: as many as the machine runs at once).
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// What there was where nothing is viable.
#[derive(Serialize)]
struct NoViableCell {
    cell: Option<rsrs_core::axis::Cell>,
    reason: String,
    best: Option<Choice>,
}

/// Runs the command.
///
/// # Errors
///
/// If the folder is not a sweep's or the choice cannot be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let result = result_folder::read(&arguments.folder)?;
    let Some(candidate) = rank(&result.diagram).into_iter().next() else {
        let reason = best_swept(&result);
        let text = format!("no viable cell: {reason}");
        report(arguments.format, &NoViableCell { cell: None, reason, best: None }, &text)?;
        return Ok(Outcome::NegativeAnswer);
    };
    let choice = Choice::new(&candidate, confirm(arguments, &result, candidate.index)?);
    if !choice.is_viable(arguments.viable) {
        let reason = format!(
            "the best, {}, mills in {:.1} % of fresh runs, lower bound {:.1} %, wanted {:.1} %",
            choice.cell,
            100.0 * choice.b_s,
            100.0 * choice.b_s_low,
            100.0 * arguments.viable
        );
        let text = format!("no viable cell: {reason}");
        let best = Some(choice);
        report(arguments.format, &NoViableCell { cell: None, reason, best }, &text)?;
        return Ok(Outcome::NegativeAnswer);
    }
    if let Some(path) = &arguments.output {
        let json = serde_json::to_string_pretty(&choice).context("the choice as JSON")?;
        write_file(path, format!("{json}\n").as_bytes())?;
    }
    report(arguments.format, &choice, &text(&choice))?;
    Ok(Outcome::Done)
}

fn confirm(arguments: &Arguments, result: &SweepResult, index: usize) -> anyhow::Result<Share> {
    let sweep = &result.source.sweep;
    let cells = result.source.cells("sweep.yaml")?;
    let runs = Runs {
        seed: sweep.seed,
        replicates: arguments.confirm,
        duration_s: sweep.duration_s,
        n_threads: threads(arguments.threads),
    };
    let swept =
        watched("confirming", |watch| rsrs_sim::sweep::confirm(&cells[index].1, runs, watch))?;
    Ok(Share::milling(&swept.counts(1)[0]))
}

fn best_swept(result: &SweepResult) -> String {
    let share = |entry: &rsrs_core::diagram::DiagramCell| entry.counts.share(Phase::StableMilling);
    let best = result.diagram.cells.iter().max_by(|one, other| share(one).total_cmp(&share(other)));
    match best {
        Some(entry) => format!(
            "no cell's B_s has a lower bound of 0.5; the best, {}, mills in {:.0} % of {} runs",
            entry.cell,
            100.0 * share(entry),
            entry.counts.total()
        ),
        None => "the sweep has no cells".to_owned(),
    }
}

fn text(choice: &Choice) -> String {
    let margins: Vec<String> = choice
        .margin
        .iter()
        .map(|(axis, margin)| {
            format!("  {axis} may drift by -{} to +{} {}", margin.low, margin.high, axis.unit())
        })
        .collect();
    format!(
        "{}\n  mills in {:.1} % of {} fresh runs (95 % interval {:.1} to {:.1} %)\n{}",
        choice.cell,
        100.0 * choice.b_s,
        choice.n_replicates,
        100.0 * choice.b_s_low,
        100.0 * choice.b_s_high,
        margins.join("\n")
    )
}
