//! The label of one bag, by the one judge.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_bags::Bag;
use rsrs_bags::trajectory::{PoseSource, TrajectoryOptions, read_trajectory};
use rsrs_core::order::Evidence;
use rsrs_core::phase::{Phase, label};
use rsrs_core::trajectory::Bodies;
use serde::Serialize;

use crate::failure::explained;
use crate::recorded_run;

/// What to label a bag by.
#[derive(Clone, Copy, Debug, Default)]
pub struct LabelOptions {
    /// Body and sensing range of the robots; `None` takes what the bag's own record says.
    pub bodies: Option<Bodies>,
    /// Where poses come from; `None` takes the first source that the bag has.
    pub poses: Option<PoseSource>,
}

/// A bag with its label.
#[derive(Clone, Debug, Serialize)]
pub struct Labelled {
    /// The bag.
    pub bag: PathBuf,
    /// What its swarm settled into.
    pub phase: Phase,
    /// The order parameters behind it.
    pub evidence: Evidence,
    /// Number of robots.
    pub n_robots: usize,
    /// Time that was recorded while the swarm was running, in seconds.
    pub duration_s: f64,
    /// Who labelled it.
    pub by: &'static str,
    /// Where the recording breaks off; the judge has seen what came before. Not there for a whole
    /// bag.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damage: Option<String>,
}

/// Labels one bag with the phase that its swarm settled into.
///
/// What the judge must know of the robots comes from the options, else from the record that the
/// bag holds, else it is unknown.
///
/// # Errors
///
/// If the bag or its record cannot be read, or it has no poses, no commands, or too little time;
/// the error names the bag.
pub fn label_bag(path: &Path, options: LabelOptions) -> anyhow::Result<Labelled> {
    let bag = recorded_run::open(path)?;
    let bodies = match options.bodies {
        Some(bodies) => bodies,
        None => recorded_bodies(&bag)?,
    };
    let recorded =
        read_trajectory(&bag, &TrajectoryOptions { poses: options.poses }).map_err(|error| {
            let (message, help) = (format!("{}: {error}", path.display()), error.help());
            explained(error, message, help)
        })?;
    let verdict =
        label(&recorded.trajectory, &bodies).with_context(|| path.display().to_string())?;
    Ok(Labelled {
        bag: path.to_path_buf(),
        phase: verdict.phase,
        evidence: verdict.evidence,
        n_robots: verdict.n_robots,
        duration_s: verdict.duration_s,
        by: "judge",
        damage: recorded_run::break_in(&bag),
    })
}

fn recorded_bodies(bag: &Bag) -> anyhow::Result<Bodies> {
    let unknown = Bodies { radius_m: None, range_m: None };
    Ok(recorded_run::record_in(bag)?.map_or(unknown, |record| record.conditions.bodies()))
}
