//! Many experiments, one after the other, each in a folder that contains all of it.

mod attempts;
mod conduct;
pub(crate) mod file;
mod folder;
mod manifest;
mod summary;

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::robot::other_profile::{OtherProfile, ProfilesDiffer};
use rsrs_experiment_runner::plan::{PlaceCheck, Plan, Request};
use rsrs_fleet::record::{self, ExperimentRecord};

use crate::error::with_help;
pub use attempts::attempts_in;
pub use conduct::{Conductor, OperatorDecision, Placer, RunTarget};
pub use file::Experiment;
pub use folder::CampaignFolder;
pub use summary::Summary;

/// What is to be run.
pub struct Campaign {
    /// The text of the campaign file.
    pub text: String,
    /// Its experiments, in order.
    pub items: Vec<Item>,
}

impl Campaign {
    /// Reads a campaign file and all files that it names.
    ///
    /// # Errors
    ///
    /// If a file cannot be read or is wrong.
    pub fn read(
        path: &Path,
        backend: record::Backend,
        other_profile: OtherProfile,
    ) -> anyhow::Result<Self> {
        let (text, experiments) = file::read(path)?;
        let items = experiments
            .into_iter()
            .map(|experiment| Item::read(experiment, backend, other_profile))
            .collect::<anyhow::Result<Vec<Item>>>()?;
        Ok(Self { text, items })
    }
}

/// An experiment of a campaign with what it is, whenever it is run.
pub struct Item {
    /// As the campaign file has it.
    pub experiment: Experiment,
    /// All that it takes to run it, with the robots that the fleet file has now.
    pub record: ExperimentRecord,
    /// That the sweep of its cell is of robots with another profile, on which somebody insists.
    pub other_profile: Option<ProfilesDiffer>,
    /// What is done about robots that do not stand where they should start.
    pub place_check: PlaceCheck,
}

impl Item {
    /// An experiment that is to be run.
    ///
    /// # Errors
    ///
    /// If a file is wrong.
    fn read(
        experiment: Experiment,
        backend: record::Backend,
        other_profile: OtherProfile,
    ) -> anyhow::Result<Self> {
        let plan = plan(&experiment, backend, other_profile)
            .with_context(|| format!("experiment {} cannot be run", experiment.folder))?;
        // It is no run yet.
        let record = ExperimentRecord { run_id: String::new(), ..plan.record };
        let other_profile = plan.other_profile;
        Ok(Self { experiment, record, other_profile, place_check: PlaceCheck::On })
    }

    /// The plan of a run that starts now.
    ///
    /// # Errors
    ///
    /// If a file is wrong, or has been changed since the campaign was started.
    pub fn plan(&self, bag: PathBuf) -> anyhow::Result<Plan> {
        let insists = self.other_profile.is_some();
        let other = if insists { OtherProfile::Insisted } else { OtherProfile::Refused };
        let mut plan = plan(&self.experiment, self.record.backend, other)?;
        if !is_same(&plan.record, &self.record) {
            return Err(with_help(
                format!("{}: its files were changed meanwhile", self.experiment.folder),
                "change them back, or start another campaign",
            ));
        }
        plan.bag = bag;
        plan.place_check = self.place_check;
        Ok(plan)
    }
}

/// Whether two records are of the same experiment.
///
/// The names of robots are no part of it: one that breaks is replaced by another of the same profile. Nor
/// is the program, or what a later version of it records besides.
pub fn is_same(one: &ExperimentRecord, other: &ExperimentRecord) -> bool {
    let setup = |record: &ExperimentRecord| {
        let ExperimentRecord { seed, replicate, robot_lost, backend, time, .. } = record;
        (*seed, *replicate, *robot_lost, *backend, *time)
    };
    setup(one) == setup(other)
        && one.robots.len() == other.robots.len()
        && one.conditions == other.conditions
        && one.duration_s.to_bits() == other.duration_s.to_bits()
        && one.provenance.profile_digest == other.provenance.profile_digest
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
    Ok(plan)
}
