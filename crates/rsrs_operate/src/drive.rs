//! Trials over ROS 2 under the lease, recorded: a robot moves by one constant command, or stands and
//! senses.

mod filling;
mod period_table;
pub mod placement;
pub mod result;
mod table_file;
mod trial_nodes;
mod trial_table;

use std::path::{Path, PathBuf};
use std::pin::Pin;

use rsrs_core::trials::trial::Trial;
use rsrs_experiment_runner::plan::{Plan, TrialRequest, Unmeasured};
use rsrs_fleet::record::Backend;
use rsrs_pipeline::measure::sensor_readings;
use rsrs_pipeline::run_summary::RunSummary;
use rsrs_render::operator_event::OperatorEvent;

use crate::run::RunTarget;
use crate::run::operator::Operator;
pub use filling::{fill_plan, fill_table};
use result::{Motion, Source, TrialResult};
use rsrs_ros::runtime::runtime;
use trial_nodes::TrialNodes;

/// Detections come this often where nothing else is given, in seconds: those of the Flockbot.
const USUAL_PERIOD_S: f64 = 0.13;

/// Whoever places robots for trials, and measures what no tracker does.
pub trait TrialOperator {
    /// Who watches the runs.
    fn operator(&self) -> &dyn Operator;

    /// Has all stand where a trial needs it.
    fn ready<'a>(&'a self, robot: &'a str, trial: &'a Trial) -> OperatorFuture<'a, Ready>;

    /// Measures what the robot did in a trial without poses.
    fn measure<'a>(&'a self, plan: &'a Plan) -> OperatorFuture<'a, Motion>;
}

/// An operator's answer; an error if there is none.
pub type OperatorFuture<'a, T> = Pin<Box<dyn Future<Output = anyhow::Result<T>> + 'a>>;

/// What an operator wants before a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ready {
    /// All stands where it should.
    Go,
    /// Not this trial.
    Skip,
    /// No further trials.
    End,
}

/// Under what trials are driven.
#[derive(Clone, Debug)]
pub struct DriveOptions {
    /// The fleet file.
    pub fleet: PathBuf,
    /// What moves the robots.
    pub backend: Backend,
    /// Where bags go: of one trial its folder, of tables the folder of all of them; `None` for a name
    /// that follows from the rest.
    pub output: Option<PathBuf>,
    /// Seed of the simulator.
    pub seed: u64,
    /// Control period of robots that were not measured yet, in seconds.
    pub period_s: Option<f64>,
}

impl DriveOptions {
    fn request(&self, robot: &str, trial: Trial) -> TrialRequest {
        TrialRequest {
            fleet: self.fleet.clone(),
            robot: robot.to_owned(),
            trial,
            backend: self.backend,
            bag: self.output.clone(),
            seed: self.seed,
            unmeasured: Unmeasured {
                limits: None,
                period_s: self.period_s.unwrap_or(USUAL_PERIOD_S),
            },
        }
    }
}

/// One trial of one robot.
#[derive(Clone, Copy, Debug)]
pub struct SingleTrial<'a> {
    /// Name of the robot.
    pub robot: &'a str,
    /// What it does.
    pub trial: Trial,
    /// Gets a row with the result.
    pub table: Option<&'a Path>,
    /// Whether the operator is asked before the trial.
    pub asks: bool,
}

/// Makes one trial; `None` if the operator does not want it.
///
/// `enter` enters the network, before the first thread is started.
pub fn drive(
    options: &DriveOptions,
    single: SingleTrial<'_>,
    enter: impl FnOnce() -> anyhow::Result<RunTarget>,
    operator: &dyn TrialOperator,
) -> anyhow::Result<Option<(TrialResult, RunSummary)>> {
    let SingleTrial { robot, trial, table, asks } = single;
    let plan = Plan::of_trial(&options.request(robot, trial))?;
    if let Some(table) = table {
        result::check_table(table, &trial, &plan)?;
    }
    let target = enter()?;
    let runtime = runtime()?;
    if asks && runtime.block_on(operator.ready(robot, &trial))? != Ready::Go {
        return Ok(None);
    }
    let (found, summary) = runtime.block_on(async {
        let mut trial_nodes = TrialNodes::start(&target, &plan, operator.operator())?;
        let made = made(&mut trial_nodes, &plan, trial, operator).await;
        trial_nodes.stop().await?;
        made
    })?;
    if let Some(table) = table {
        found.append_to(table)?;
    }
    Ok(Some((found, summary)))
}

async fn made(
    trial_nodes: &mut TrialNodes<'_>,
    plan: &Plan,
    trial: Trial,
    operator: &dyn TrialOperator,
) -> anyhow::Result<(TrialResult, RunSummary)> {
    let summary = trial_nodes.run(plan).await?;
    if let Trial::Stand { neighbour, samples } = trial {
        let robot = &plan.robots[0].name;
        let found = sensor_readings::count(&plan.bag, robot, Some(samples))?;
        if found.samples < samples {
            operator.operator().inform(&OperatorEvent::FewReadings {
                robot,
                samples: found.samples,
                planned: samples,
            });
        }
        return Ok((TrialResult::of_readings(plan, neighbour, found), summary));
    }
    if let Some(found) = TrialResult::of_bag(&plan.bag, plan)? {
        return Ok((found, summary));
    }
    let motion = operator.measure(plan).await?;
    let mut found = TrialResult::of_motion(plan, Source::Operator, motion);
    found.read_rhythm(plan.record.time)?;
    Ok((found, summary))
}
