//! Many experiments, one after the other, each in a folder that contains all of it.

mod conduct;
pub(crate) mod file;
mod folder;
mod manifest;
mod summary;

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_experiment_runner::plan::{PlaceCheck, Plan, Request};
use rsrs_fleet::record::{self, ExperimentRecord};

use crate::error::with_help;
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
    pub fn read(path: &Path, backend: record::Backend) -> anyhow::Result<Self> {
        let (text, experiments) = file::read(path)?;
        let items = experiments
            .into_iter()
            .map(|experiment| Item::read(experiment, backend))
            .collect::<anyhow::Result<Vec<Item>>>()?;
        Ok(Self { text, items })
    }
}

/// An experiment of a campaign with what it is, whenever it is run.
pub struct Item {
    /// As the campaign file has it.
    pub experiment: Experiment,
    /// All that it takes to repeat it, without what differs from run to run and program to program.
    pub identity: ExperimentRecord,
}

impl Item {
    /// An experiment that is to be run.
    ///
    /// # Errors
    ///
    /// If a file is wrong.
    fn read(experiment: Experiment, backend: record::Backend) -> anyhow::Result<Self> {
        let plan = plan(&experiment, backend)
            .with_context(|| format!("experiment {} cannot be run", experiment.folder))?;
        Ok(Self { experiment, identity: identity(&plan.record) })
    }

    /// The plan of a run that starts now.
    ///
    /// # Errors
    ///
    /// If a file is wrong, or has been changed since the campaign was started.
    pub fn plan(&self, bag: PathBuf) -> anyhow::Result<Plan> {
        let mut plan = plan(&self.experiment, self.identity.backend)?;
        if identity(&plan.record) != self.identity {
            return Err(with_help(
                format!("{}: its files were changed meanwhile", self.experiment.folder),
                "change them back, or start another campaign",
            ));
        }
        plan.bag = bag;
        Ok(plan)
    }
}

/// A record without what differs between two runs of the same experiment.
pub fn identity(record: &ExperimentRecord) -> ExperimentRecord {
    let mut identity = record.clone();
    for differs in
        [&mut identity.run_id, &mut identity.provenance.version, &mut identity.provenance.commit]
    {
        differs.clear();
    }
    identity
}

fn plan(experiment: &Experiment, backend: record::Backend) -> anyhow::Result<Plan> {
    let mut plan = Plan::read(&Request {
        experiment: experiment.file.clone(),
        cell: experiment.cell.clone(),
        from: experiment.from.clone(),
        backend,
        bag: None,
        seed: experiment.seed,
        place_check: PlaceCheck::On,
    })?;
    plan.record.replicate = experiment.replicate;
    Ok(plan)
}
