//! Many experiments, one after the other, each in a folder that contains all of it.

mod campaign_runner;

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_experiment_runner::plan::{Plan, Request};
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::{self, ExperimentRecord};
use rsrs_pipeline::campaign::{Experiment, Item, file, is_same};
use rsrs_pipeline::error::with_help;

pub use campaign_runner::{CampaignRunner, OperatorDecision, Placer};

/// What is to be run.
pub struct Campaign {
    /// The text of the campaign file.
    pub text: String,
    /// Its experiments, in order.
    pub items: Vec<Item>,
}

/// Reads a campaign file and all files that it names.
pub fn read(
    path: &Path,
    backend: record::Backend,
    other_profile: OtherProfile,
) -> anyhow::Result<Campaign> {
    let (text, experiments) = file::read(path)?;
    let items = experiments
        .into_iter()
        .map(|experiment| item(experiment, backend, other_profile))
        .collect::<anyhow::Result<Vec<Item>>>()?;
    Ok(Campaign { text, items })
}

/// An experiment that is to be run.
fn item(
    experiment: Experiment,
    backend: record::Backend,
    other_profile: OtherProfile,
) -> anyhow::Result<Item> {
    let plan = plan(&experiment, backend, other_profile)
        .with_context(|| format!("experiment {} cannot be run", experiment.folder))?;
    // It is no run yet.
    let record = ExperimentRecord { run_id: String::new(), ..plan.record };
    let other_profile = plan.other_profile;
    Ok(Item { experiment, record, other_profile, place_check: PlaceCheck::On })
}

/// The plan of a run of an experiment that starts now.
fn plan_now(item: &Item, bag: PathBuf) -> anyhow::Result<Plan> {
    let other = OtherProfile::from(item.other_profile.is_some());
    let mut plan = plan(&item.experiment, item.record.backend, other)?;
    if !is_same(&plan.record, &item.record) {
        return Err(with_help(
            format!("{}: its files were changed meanwhile", item.experiment.folder),
            "change them back, or start another campaign",
        ));
    }
    plan.bag = bag;
    plan.place_check = item.place_check;
    Ok(plan)
}

fn plan(
    experiment: &Experiment,
    backend: record::Backend,
    other_profile: OtherProfile,
) -> anyhow::Result<Plan> {
    let mut plan = Plan::read(&Request {
        experiment: experiment.file.clone(),
        cell: experiment.cell.clone(),
        from: experiment.from.clone(),
        backend,
        bag: None,
        seed: experiment.seed,
        place_check: PlaceCheck::On,
        other_profile,
    })?;
    plan.record.replicate = experiment.replicate;
    plan.record.fixed = experiment.fixed;
    Ok(plan)
}
