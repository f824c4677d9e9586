//! How many real runs decide, if nobody looks before the last of them.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::comparison::fixed::{FixedPlan, PlannedCell, plan};
use rsrs_core::judge::behaviour::Behaviour;
use serde::Serialize;

use crate::compare::prediction::Note;

use super::{PlanOptions, PlannedRuns, Subject};

/// A campaign of a number of runs that is fixed before the first.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedCampaign {
    /// What is compared; in the sweep, and not written again.
    #[serde(skip)]
    pub behaviour: Behaviour,
    /// Runs in all cells together.
    pub runs: u64,
    /// The probability of a decision that was wanted.
    pub wanted: f64,
    /// By how much real robots may mill less often.
    pub margin: f64,
    /// The cells.
    pub cells: Vec<PlannedRuns>,
    /// What decides, and how probable it is.
    #[serde(flatten)]
    pub plan: FixedPlan,
    /// What a reader must not overlook; as JSON it is written as a sentence, by `rsrs_render`.
    #[serde(skip)]
    pub note: Option<Note>,
}

impl PlannedCampaign {
    /// Whether so many runs decide with the wanted probability.
    pub fn is_enough(&self) -> bool {
        self.plan.decided >= self.wanted
    }

    /// Whether no run of the cells decides, because nothing is claimed in any of them.
    pub fn claims_nothing(&self) -> bool {
        !self.is_enough() && self.cells.iter().all(|cell| !cell.is_claimed)
    }

    /// The campaign file that will lie at `place`, for an experiment file and the folder of a
    /// sweep; its paths are relative to that, as far as they can be.
    pub fn file(&self, place: &Path, experiment: &Path, sweep: &Path) -> anyhow::Result<String> {
        let named = |path: &Path| Ok::<_, anyhow::Error>(quoted(&beside(place, path)?));
        let (experiment, sweep) = (named(experiment)?, named(sweep)?);
        let entry = |(number, PlannedRuns { cell, runs, .. }): (u64, &PlannedRuns)| {
            let values: Vec<String> =
                cell.iter().map(|(axis, value)| format!("{axis}: {value}")).collect();
            let (values, runs) = (values.join(", "), runs.unwrap_or_default());
            format!(
                "  - experiment: {experiment}\n    name: cell_{number}\n    from: {sweep}\n    \
                 cells: [{{{values}}}]\n    repetitions: {runs}\n"
            )
        };
        let entries: String = (1..).zip(&self.cells).map(entry).collect();
        Ok(format!(
            "# Written before the first run: `rsrs compare` gives its verdict at this number of runs, once.\n\
             fixed: {{runs: {}, margin: {}}}\nexperiments:\n{entries}",
            self.runs, self.margin
        ))
    }
}

/// A path as a file beside it names it.
fn beside(place: &Path, path: &Path) -> anyhow::Result<PathBuf> {
    let whole = |path: &Path| {
        std::path::absolute(path).with_context(|| format!("cannot find {}", path.display()))
    };
    let (place, path) = (whole(place)?, whole(path)?);
    let inside = place.parent().and_then(|folder| path.strip_prefix(folder).ok());
    Ok(inside.unwrap_or(&path).to_path_buf())
}

/// A path as a string of YAML.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', "''"))
}

/// Plans the least number of runs that decides at once, if real robots mill as often as those as
/// measured in the sweep of a folder.
pub fn plan_campaign(folder: &Path, options: &PlanOptions) -> anyhow::Result<PlannedCampaign> {
    let subject = Subject::read(folder, options)?;
    let cells = subject.cells.iter().map(|(_, cell)| PlannedCell {
        simulated: cell.simulated,
        expected: cell.as_measured.value(),
    });
    let plan = plan(&cells.collect::<Vec<_>>(), options.margin, options.wanted);
    Ok(PlannedCampaign {
        behaviour: subject.behaviour,
        runs: plan.runs.iter().sum(),
        wanted: options.wanted,
        margin: options.margin,
        cells: subject.rows(|position| plan.runs.get(position).copied()),
        plan,
        note: subject.note,
    })
}
