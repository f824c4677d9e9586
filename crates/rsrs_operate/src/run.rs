//! Step 4: one experiment over ROS 2, with an operator who watches.

pub mod node_process;
pub mod operator;
pub mod own_network;
pub mod place_command;
pub mod side_by_side;
pub mod simulated_fleet;
pub mod start_poses;

use std::collections::BTreeMap;
use std::path::PathBuf;

use rsrs_core::robot::other_profile::ProfilesDiffer;
use rsrs_experiment_runner::plan::Plan;
use rsrs_experiment_runner::{RunReport, run};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::record::{
    Backend, EndingKind, ExperimentRecord, LostRobot, OwnProfile, PausedRobot,
};
use rsrs_pipeline::attempt::Attempt;
use rsrs_pipeline::recorded_run;
use rsrs_pipeline::recorded_run::gaps::{self, Gap};
use rsrs_ros::session::SessionOptions;
use serde::Serialize;

use self::operator::{Operator, Verbosity};
use crate::run::own_network::OwnNetwork;
use crate::run::simulated_fleet::SimulatedFleet;

/// Where the robots are, and in which network.
pub enum RunTarget {
    /// In a simulator that is started for it.
    Simulator(OwnNetwork),
    /// On the floor.
    Fleet(SessionOptions),
}

/// What a run came to.
#[derive(Clone, Debug, Serialize)]
pub struct RunSummary {
    /// Names the run.
    pub run_id: String,
    /// The bag; `None` if none was opened. One without `metadata.yaml` was not closed.
    pub bag: Option<PathBuf>,
    /// How the run ended.
    pub ending: EndingKind,
    /// Why, if it was not completed.
    pub reason: String,
    /// Whether the robots were allowed to move.
    pub has_started: bool,
    /// Robots that were lost on the way, and when.
    pub lost_robots: Vec<LostRobot>,
    /// When robots stood because leases did not reach them, and went on.
    pub paused_robots: Vec<PausedRobot>,
    /// Messages in the bag.
    pub n_messages: u64,
    /// Messages missing in the bag between two that are in it, on topics that are to lose none.
    pub n_lost: u64,
    /// What did not get into the bag, by topic.
    pub gaps: Vec<Gap>,
    /// That the sweep of its cell is of robots with another profile; not there if it is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_profile: Option<ProfilesDiffer>,
    /// Robots with a profile of their own, and in what it differs from the fleet's.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub own_profiles: BTreeMap<String, OwnProfile>,
    /// Robots that did not report that they stand.
    pub not_standing: Vec<String>,
    /// How long the robots were to move, in seconds.
    pub duration_s: f64,
    /// Wall-clock time until all that the run needs was found, in seconds; with the simulator, which
    /// is started for the run, its start is part of it.
    pub preflight_s: Option<f64>,
    /// Wall-clock time in which all parameters were set and read back, in seconds.
    pub parameters_s: Option<f64>,
    /// Simulated seconds for each wall-clock second; `None` in real time.
    pub real_time_factor: Option<f64>,
}

/// What stands before the names of robots that did not report that they stand.
pub const NOT_STANDING: &str = "not confirmed to stand, go and look";

impl RunSummary {
    /// What is to be kept of it, if it gave no result.
    pub fn attempt(&self, record: &ExperimentRecord) -> Attempt {
        Attempt {
            run_id: self.run_id.clone(),
            robots: record.robots.clone(),
            ending: self.ending.key().to_owned(),
            reason: self.reason.clone(),
            has_started: self.has_started,
            lost_robots: self.lost_robots.clone(),
            bag: None,
        }
    }

    /// Robots that did not report that they stand, if there are any: `not confirmed to stand, go and look:
    /// robot_3`.
    pub fn unconfirmed(&self) -> Option<String> {
        let names = self.not_standing.join(", ");
        (!names.is_empty()).then(|| format!("{NOT_STANDING}: {names}"))
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
        run_id: record.run_id.clone(),
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
        own_profiles: record.own_profiles.clone(),
        not_standing: report.not_standing,
        duration_s: record.duration_s,
        preflight_s: report.preflight_s,
        parameters_s: report.parameters_s,
        real_time_factor: report
            .stepping_s
            .filter(|stepping_s| is_paced && *stepping_s > 0.0)
            .map(|stepping_s| simulated_s / stepping_s),
    }
}
