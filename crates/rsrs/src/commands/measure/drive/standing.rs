//! Detection trials: a robot stands and senses, another one stands beside it or does not.

use rsrs_experiment_runner::plan::Plan;

use super::trial_nodes::TrialNodes;
use crate::notes::print_note;
use rsrs_pipeline::measure::sensor_readings::{self, Readings};
use rsrs_pipeline::run::RunSummary;

/// Makes one trial, and counts the readings in its bag.
///
/// # Errors
///
/// If it was not completed, or the bag has no readings.
pub async fn stand(
    trial_nodes: &mut TrialNodes<'_>,
    plan: &Plan,
    samples: u64,
) -> anyhow::Result<(Readings, RunSummary)> {
    let summary = trial_nodes.conduct(plan).await?;
    let robot = &plan.robots[0].name;
    let found = sensor_readings::count(&plan.bag, robot, Some(samples))?;
    if found.samples < samples {
        print_note(&format!(
            "{robot}: {} readings came while the trial ran, {samples} were planned",
            found.samples
        ));
    }
    Ok((found, summary))
}
