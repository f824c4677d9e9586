//! `rsrs episode`: one replicate of a sweep as a bag.

use std::path::PathBuf;

use anyhow::Context;
use rsrs_core::axis::Cell;
use rsrs_core::conditions::Conditions;
use rsrs_core::order::Evidence;
use rsrs_core::phase::{Phase, converged_s, label};
use rsrs_core::settling::Settling;
use rsrs_fleet::experiment::{RobotLost, Time};
use rsrs_fleet::record::{Backend, ExperimentRecord, Provenance};
use serde::Serialize;

use crate::commands::{Format, report};
use crate::episode_bag::{self, EpisodeError};
use crate::failure::{Outcome, explained, with_help};
use crate::progress::threads;
use crate::provenance;
use crate::result_folder;
use crate::settling;
use crate::sweep_result::SweepResult;
use crate::wording::counted;

/// Write one replicate of a sweep as a bag: the very run, with all its topics.
///
/// The bag has the topics of a run over ROS 2 in lockstep, so that every tool for bags shows what the
/// sweep has only counted: play it in a viewer, label it, or replay it into the controller.
/// Its label is that replicate's phase in `replicates.parquet`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs episode results/flockbot --cell speed_m_s=0.15,turn_rate_rad_s=0.75 --replicate 3 -o mill
  rsrs label mill")]
pub struct Arguments {
    /// Folder of a sweep.
    folder: PathBuf,
    /// Cell of the sweep, as AXIS=VALUE,…
    #[arg(long)]
    cell: Cell,
    /// Which replicate of the cell, from 0.
    #[arg(long, value_name = "K")]
    replicate: u64,
    /// Folder of the bag; it must not exist.
    #[arg(short, long, value_name = "BAG")]
    output: PathBuf,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// A bag of a simulated run.
#[derive(Serialize)]
struct Summary {
    bag: PathBuf,
    cell: Cell,
    replicate: u64,
    seed: u64,
    phase: Phase,
    evidence: Evidence,
    /// When stable milling began, in seconds; `None` if it did not.
    converged_s: Option<f64>,
    n_robots: usize,
    duration_s: f64,
    n_messages: u64,
    /// Whether the runs of its cell were given enough time; `None` if they are too short to tell.
    settling: Option<Settling>,
}

/// Runs the command.
///
/// # Errors
///
/// If the folder is not a sweep's, the cell or the replicate is not in it, or the bag exists or
/// cannot be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let result = result_folder::read(&arguments.folder)?;
    let (index, (cell, conditions)) = find(&result, arguments)?;
    let record = record(&result, conditions, arguments.replicate);
    let (written, trajectory) =
        episode_bag::write(&arguments.output, &record).map_err(|error| {
            let message = error.to_string();
            let help = match &error {
                EpisodeError::Bag(error) => error.help(),
                EpisodeError::Placement(_) => None,
            };
            explained(error, message, help)
        })?;
    let bodies = record.conditions.bodies();
    let verdict = label(&trajectory, &bodies)
        .context("the sweep has judged this replicate, and now it cannot be judged")?;
    let summary = Summary {
        bag: written.folder,
        cell,
        replicate: record.replicate,
        seed: record.seed,
        phase: verdict.phase,
        evidence: verdict.evidence,
        converged_s: converged_s(&trajectory, &bodies, verdict.phase),
        n_robots: verdict.n_robots,
        duration_s: verdict.duration_s,
        n_messages: written.n_messages,
        settling: settling::of_cell(&result.source, index, threads(None))?,
    };
    report(arguments.format, &summary, &text(&summary))?;
    Ok(Outcome::Done)
}

fn text(summary: &Summary) -> String {
    let bag = summary.bag.display();
    let settling = summary.settling.as_ref();
    let settling =
        settling.map_or_else(String::new, |found| format!("\n  {}", settling::text(found)));
    let converged = summary.converged_s;
    let converged = converged.map_or_else(String::new, |time_s| format!(" from {time_s:.0} s on"));
    format!(
        "{bag}: {}{converged}, replicate {} of {}, seed {} ({}, {:.0} s, {}){settling}\nnext: rsrs label {bag}",
        summary.phase,
        summary.replicate,
        summary.cell,
        summary.seed,
        counted(summary.n_robots as u64, "robot"),
        summary.duration_s,
        counted(summary.n_messages, "message"),
    )
}

fn find(
    result: &SweepResult,
    arguments: &Arguments,
) -> anyhow::Result<(usize, (Cell, Conditions))> {
    let folder = arguments.folder.display();
    let sweep = &result.source.sweep;
    let index = result.diagram.locate(&arguments.cell).with_context(|| folder.to_string())?;
    if arguments.replicate >= sweep.replicates {
        return Err(with_help(
            format!(
                "{folder} has no replicate {} of a cell: it has {}",
                arguments.replicate,
                counted(sweep.replicates, "replicate")
            ),
            format!("they count from 0: `--replicate {}` is the last", sweep.replicates - 1),
        ));
    }
    let mut cells = result.source.cells(&format!("sweep.yaml in {folder}"))?;
    Ok((index, cells.swap_remove(index)))
}

/// The record of a run that never was on any network.
fn record(result: &SweepResult, conditions: Conditions, replicate: u64) -> ExperimentRecord {
    let sweep = &result.source.sweep;
    let program = (env!("CARGO_PKG_VERSION"), provenance::COMMIT);
    ExperimentRecord {
        run_id: run_id(&conditions, sweep.duration_s, (sweep.seed, replicate)),
        robots: (1..=conditions.robots).map(|robot| format!("robot_{robot}")).collect(),
        duration_s: sweep.duration_s,
        seed: sweep.seed,
        replicate,
        robot_lost: RobotLost::Abort,
        backend: Backend::Simulator,
        controller_only: Vec::new(),
        time: Time::Lockstep,
        provenance: Provenance::new(program, &result.source.profile.digest(), &conditions),
        conditions,
    }
}

/// Names a replicate by all that it follows from, so that the same one has the same name wherever it
/// is made, and another has another: that of a sweep with another seed, in another world, or shorter.
fn run_id(conditions: &Conditions, duration_s: f64, (seed, replicate): (u64, u64)) -> String {
    let steps = conditions.steps(duration_s);
    format!("episode_{:016x}_{steps}_steps_seed_{seed}_{replicate}", conditions.digest())
}
