//! `rsrs choose`: the most robust milling cell, confirmed.

use std::path::PathBuf;

use rsrs_core::choice::{Choice, VIABLE_B_S_LOW};

use crate::choosing::{CONFIRM, Chosen, Options, as_measured, choose, write};
use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::progress::threads;

/// Choose the milling cell that may drift furthest, and confirm it on fresh seeds.
///
/// Cells are ranked by their depth inside the region where the lower bound of `B_s` is at least 0.5.
/// The winner looks better than it is, so only fresh runs feed its `B_s`. The same cell is run with
/// the robots as measured, too: being worse helps in some cells, and there fewer real robots mill.
/// Exit code 3 says that no cell is viable.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of a sweep.
    folder: PathBuf,
    /// Fresh runs that confirm the winner (default: 1000).
    #[arg(long, value_name = "N", default_value_t = CONFIRM, hide_default_value = true,
          value_parser = clap::value_parser!(u64).range(1..))]
    confirm: u64,
    /// Least confirmed lower bound of `B_s` of a viable cell (default: 0.8).
    #[arg(long, value_name = "SHARE", default_value_t = VIABLE_B_S_LOW, hide_default_value = true,
          value_parser = share)]
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

/// A share from 0 to 1, from the command line.
fn share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if (0.0..=1.0).contains(&share) {
        Ok(share)
    } else {
        Err("expected a share from 0 to 1".into())
    }
}

/// Runs the command.
///
/// # Errors
///
/// If the folder is not a sweep's or the choice cannot be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let options = Options {
        confirm: arguments.confirm,
        viable: arguments.viable,
        n_threads: threads(arguments.threads),
    };
    match choose(&arguments.folder, options)? {
        Chosen::Viable(choice) => {
            if let Some(path) = &arguments.output {
                write(path, &choice)?;
            }
            report(arguments.format, &choice, &text(&choice))?;
            Ok(Outcome::Done)
        }
        Chosen::NoViableCell(none) => {
            report(arguments.format, &none, &format!("no viable cell: {}", none.reason))?;
            Ok(Outcome::NegativeAnswer)
        }
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
    let mut lines = vec![
        choice.cell.to_string(),
        format!(
            "  mills in {:.1} % of {} fresh runs (95 % interval {:.1} to {:.1} %)",
            100.0 * choice.b_s,
            choice.n_replicates,
            100.0 * choice.b_s_low,
            100.0 * choice.b_s_high
        ),
    ];
    lines.extend(as_measured(choice).map(|text| format!("  {text}")));
    lines.extend(by_circliness(choice));
    lines.extend(margins);
    lines.join("\n")
}

/// How `B_s` moves with the circliness from which a mill is called stable.
fn by_circliness(choice: &Choice) -> Option<String> {
    let [lower, stable, higher] = choice.by_circliness.as_slice() else { return None };
    Some(format!(
        "  stable is a circliness of {} or more; from {} on it would be {:.1} %, from {} on {:.1} %",
        stable.stable_circliness,
        lower.stable_circliness,
        100.0 * lower.b_s,
        higher.stable_circliness,
        100.0 * higher.b_s
    ))
}
