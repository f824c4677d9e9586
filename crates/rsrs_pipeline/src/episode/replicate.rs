//! One replicate of a sweep, run again.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::settling::Settling;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::{Phase, converged_s, label_with};
use rsrs_core::numerals::counted;
use rsrs_core::quantity::Cell;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_fleet::experiment::{RobotLost, Time};
use rsrs_fleet::record::{Backend, ExperimentRecord, RecordProvenance};
use serde::Serialize;

use super::write;
use crate::error::{helped, with_help};
use crate::execution::Execution;
use crate::sweep::folder;
use crate::sweep::result::SweepResult;
use crate::sweep::settling;

/// One replicate of a sweep, run again into a bag.
#[derive(Clone, Debug, Serialize)]
pub struct Episode {
    /// The bag.
    pub bag: PathBuf,
    /// The cell.
    pub cell: Cell,
    /// Which replicate of the cell, from 0.
    pub replicate: u64,
    /// The seed of the sweep.
    pub seed: u64,
    /// What its swarm settled into.
    pub phase: Phase,
    /// Its order parameters.
    pub evidence: OrderParameters,
    /// When stable milling began, in seconds; `None` if it did not.
    pub converged_s: Option<f64>,
    /// Number of robots.
    pub n_robots: usize,
    /// How long it ran, in simulated seconds.
    pub duration_s: f64,
    /// Messages in the bag.
    pub n_messages: u64,
    /// Whether the runs of its cell were given enough time; `None` if they are too short or too few for that.
    pub settling: Option<Settling>,
}

/// Runs one replicate, from 0, of a cell of the sweep in `folder` again, and writes it as a bag
/// into a folder that must not exist.
pub fn replay(
    folder: &Path,
    cell: &Cell,
    replicate: u64,
    bag: &Path,
    execution: Execution<'_>,
) -> anyhow::Result<Episode> {
    let result = folder::read(folder)?;
    let (index, (cell, conditions)) = find(folder, &result, cell, replicate)?;
    let record = record(&result, conditions, replicate);
    // Before the bag is there, so that who ends it early finds none.
    let settling = settling::of_cell_as_swept(&result.source, index, execution)?;
    let (written, trajectory) = write(bag, &record).map_err(helped)?;
    let bodies = record.conditions.bodies();
    let verdict = label_with(&trajectory, &bodies, &record.conditions.behaviour.rules())
        .context("the sweep has judged this replicate, and now it cannot be judged")?;
    Ok(Episode {
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
        settling,
    })
}

/// The cell of a sweep that has one alone.
pub fn only_cell(folder: &Path) -> anyhow::Result<Option<Cell>> {
    let result = folder::read(folder)?;
    Ok(match result.diagram.cells.as_slice() {
        [only] => Some(only.cell.clone()),
        _ => None,
    })
}

fn find(
    folder: &Path,
    result: &SweepResult,
    cell: &Cell,
    replicate: u64,
) -> anyhow::Result<(usize, (Cell, Conditions))> {
    let folder = folder.display();
    let sweep = &result.source.sweep;
    let index = result.diagram.locate(cell).with_context(|| folder.to_string())?;
    if replicate >= sweep.replicates {
        return Err(with_help(
            format!(
                "{folder} has no replicate {} of a cell: it has {}",
                replicate,
                counted(sweep.replicates, "replicate")
            ),
            format!("they count from 0: `--replicate {}` is the last", sweep.replicates - 1),
        ));
    }
    let mut cells = result.source.cells(&format!("sweep.yaml in {folder}"))?;
    Ok((index, cells.swap_remove(index)))
}

/// The record of a run of a sweep that never was on any network.
fn record(result: &SweepResult, conditions: Conditions, replicate: u64) -> ExperimentRecord {
    let SweepFile { duration_s, seed, .. } = result.source.sweep;
    let run_id = run_id(&conditions, duration_s, seed, replicate);
    let profile_digest = result.source.profile.digest();
    let run = (Time::Lockstep, duration_s, seed);
    ExperimentRecord { replicate, ..simulated_record(run_id, conditions, run, &profile_digest) }
}

/// The record of a simulated run of the first replicate, all of whose robots are of one profile: how its time
/// passed, how long it was, in seconds, and its seed.
pub fn simulated_record(
    run_id: String,
    conditions: Conditions,
    (time, duration_s, seed): (Time, f64, u64),
    profile_digest: &str,
) -> ExperimentRecord {
    ExperimentRecord {
        run_id,
        robots: (1..=conditions.robots).map(|robot| format!("robot_{robot}")).collect(),
        duration_s,
        seed,
        replicate: 0,
        robot_lost: RobotLost::Abort,
        backend: Backend::Simulator,
        controller_only: Vec::new(),
        gates: std::collections::BTreeMap::new(),
        own_profiles: std::collections::BTreeMap::new(),
        fixed: None,
        pose_source: Some(PoseSource::Odom),
        tracker: None,
        time,
        provenance: RecordProvenance::new(profile_digest, &conditions),
        conditions,
    }
}

/// Names a replicate by all that it follows from, so that the same one has the same name wherever it
/// is made, and another has another: that of a sweep with another seed, in another world, or shorter.
fn run_id(conditions: &Conditions, duration_s: f64, seed: u64, replicate: u64) -> String {
    let steps = conditions.steps(duration_s);
    format!("episode_{:016x}_{steps}_steps_seed_{seed}_{replicate}", conditions.digest())
}
