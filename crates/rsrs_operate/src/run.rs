//! Step 4: one experiment over ROS 2, with an operator who watches.

pub mod node_process;
mod not_completed;
pub mod operator;
pub mod own_network;
pub mod place_command;
pub mod side_by_side;
pub mod simulated_fleet;
pub mod start_poses;

use rsrs_experiment_runner::plan::Plan;
use rsrs_experiment_runner::{RunReport, run};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::record::{Backend, EndingKind};
use rsrs_pipeline::recorded_run;
use rsrs_pipeline::recorded_run::gaps::{self, Gap};
use rsrs_pipeline::run_summary::RunSummary;
use rsrs_ros::session::SessionOptions;

pub use self::not_completed::refuse_unfinished;
use self::operator::{Operator, Verbosity};
use crate::run::own_network::OwnNetwork;
use crate::run::simulated_fleet::SimulatedFleet;
use crate::run::start_poses::{start_poses, wanted};

/// Where the robots are, and in which network.
pub enum RunTarget {
    /// In a simulator that is started for it.
    Simulator(OwnNetwork),
    /// On the floor.
    Fleet(SessionOptions),
}

/// Runs a plan: against a simulator that is started for it, or on a fleet, whose robots a program places
/// before if there is one.
pub async fn on_target(
    plan: &Plan,
    target: &RunTarget,
    place_command: Option<&str>,
    operator: &dyn Operator,
) -> anyhow::Result<RunSummary> {
    match target {
        RunTarget::Simulator(network) => {
            let mut fleet = SimulatedFleet::start(network, plan)?;
            let summary = on_simulated_fleet(plan, network, &mut fleet, operator).await;
            fleet.stop().await?;
            summary
        }
        RunTarget::Fleet(network) => {
            if let Some(program) = place_command {
                let wanted = wanted(&start_poses(plan)?, plan.bag.display().to_string());
                place_command::place(program, &wanted, operator).await?;
            }
            watched(plan, network, operator.stop_requested(), operator).await
        }
    }
}

/// Runs a plan against a simulated fleet that is there already. Nodes of a run that was not completed are
/// started anew first: it may be one of them that it was not completed for.
pub async fn on_simulated_fleet(
    plan: &Plan,
    network: &OwnNetwork,
    fleet: &mut SimulatedFleet,
    operator: &dyn Operator,
) -> anyhow::Result<RunSummary> {
    if !fleet.has_completed {
        fleet.restart(network, plan).await?;
    }
    let stop = async {
        tokio::select! {
            reason = operator.stop_requested() => reason,
            reason = fleet.ended() => reason,
        }
    };
    let summary = watched(plan, &network.session, stop, operator).await?;
    fleet.has_completed = summary.ending == EndingKind::Completed;
    Ok(summary)
}

/// Runs a plan, and shows how far it is.
pub async fn watched(
    plan: &Plan,
    network: &SessionOptions,
    stop: impl Future<Output = String>,
    operator: &dyn Operator,
) -> anyhow::Result<RunSummary> {
    let name = plan.bag.file_name().map_or_else(String::new, |name| name.display().to_string());
    let verbosity = match plan.record.backend {
        Backend::Simulator => Verbosity::Quiet,
        Backend::Fleet | Backend::Mixed => Verbosity::Verbose,
    };
    let report = run(plan, network, &mut *operator.watch_run(&name, verbosity), stop).await?;
    let gaps = match &report.bag {
        Some(bag) => gaps::in_bag(&recorded_run::open(&bag.folder)?),
        None => Vec::new(),
    };
    Ok(summary(plan, report, gaps))
}

fn summary(plan: &Plan, report: RunReport, gaps: Vec<Gap>) -> RunSummary {
    let record = &plan.record;
    let simulated_s = plan.steps() as f64 * record.conditions.period_s;
    let ending = report.ending.kind;
    let is_paced = record.time == Time::Lockstep && ending == EndingKind::Completed;
    RunSummary {
        ending,
        reason: report.ending.reason,
        has_started: report.has_started,
        lost_robots: report.ending.lost,
        paused_robots: report.ending.paused,
        n_messages: report.bag.as_ref().map_or(0, |bag| bag.n_messages),
        // A bag that could not be closed is there all the same.
        bag: plan.bag.exists().then(|| plan.bag.clone()),
        n_lost: report.n_lost,
        gaps,
        other_profile: plan.other_profile.clone(),
        not_standing: report.not_standing,
        preflight_s: report.preflight_s,
        parameters_s: report.parameters_s,
        real_time_factor: report
            .stepping_s
            .filter(|stepping_s| is_paced && *stepping_s > 0.0)
            .map(|stepping_s| simulated_s / stepping_s),
        ..RunSummary::new(record)
    }
}
