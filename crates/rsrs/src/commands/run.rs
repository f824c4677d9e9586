//! `rsrs run`: step 4, one experiment over ROS 2, recorded.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Context;
use rsrs_core::axis::Cell;
use rsrs_experiment_runner::plan::{self, Plan, Request};
use rsrs_experiment_runner::{RunReport, run as conduct};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::message::E_STOP_REASON;
use rsrs_fleet::record::{self, EndingKind};
use rsrs_ros::interfaces;
use rsrs_ros::logging::{self, Level};
use rsrs_ros::session::SessionOptions;
use rsrs_ros::shutdown;
use serde::Serialize;

use crate::commands::{Format, report};
use crate::experiment_bar::{ExperimentBar, Voice};
use crate::failure::{Outcome, with_help};
use crate::own_network::OwnNetwork;
use crate::recorded_run;
use crate::recording_gaps::{self, Gap};
use crate::simulated_fleet::SimulatedFleet;

/// Run one experiment over ROS 2, and record it.
///
/// With the simulator, everything that the run needs is started and ended with it, in a network of
/// its own. With the fleet, the robots' nodes must be running, and `--interface` says on which
/// network; a countdown of 3 s comes before the robots move, and Ctrl-C stops them at any time. Exit code 3 says that the run ended but does not count, or that data was lost.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs run launch_configs/experiments/flockbot_milling.yaml -o milling
  rsrs run launch_configs/experiments/flockbot_milling.yaml --from results/flockbot
  rsrs run milling.yaml --backend fleet --interface wlan0")]
pub struct Arguments {
    /// Experiment file (YAML).
    experiment: PathBuf,
    /// Folder of a sweep: run its chosen cell, or the one of it that `--cell` names.
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
    /// Cell to run, as AXIS=VALUE,…
    #[arg(long)]
    cell: Option<Cell>,
    /// What moves the robots (default: sim).
    #[arg(long, value_enum, default_value = "sim", hide_default_value = true)]
    backend: Backend,
    /// Network interface of the fleet, by name or address (or `RSRS_INTERFACE`).
    #[arg(long, value_name = "NAME|IP")]
    interface: Option<String>,
    /// Seed of the simulated world (default: the experiment file's).
    #[arg(long, value_name = "SEED", value_parser = clap::value_parser!(u64).range(..rsrs_core::sweep_file::SEED_LIMIT))]
    seed: Option<u64>,
    /// Whether to say before a fleet moves where its robots do not stand as wanted (default: on).
    #[arg(long, value_enum, default_value = "on", hide_default_value = true)]
    place_check: PlaceCheck,
    /// Folder of the bag; it must not exist (default: named after the run, in this folder).
    #[arg(short, long, value_name = "BAG")]
    output: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// What moves the robots.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Backend {
    /// The simulator, in a network of its own.
    Sim,
    /// The robots.
    Fleet,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum PlaceCheck {
    /// Say so.
    On,
    /// Do not look, as where nothing tells of poses.
    Off,
}

/// What a run came to.
#[derive(Clone, Debug, Serialize)]
pub struct RunSummary {
    /// Names the run.
    pub run_id: String,
    /// The bag; `None` if none was opened.
    pub bag: Option<PathBuf>,
    /// How the run ended: completed, void, aborted or failed.
    pub ending: &'static str,
    /// Why, if it was not completed.
    pub reason: String,
    /// Messages in the bag.
    pub n_messages: u64,
    /// Messages missing in the bag between two that are in it, on topics that are to lose none.
    pub n_lost: u64,
    /// What did not get into the bag, by topic.
    pub gaps: Vec<Gap>,
    /// Robots that did not say that they stand.
    pub not_standing: Vec<String>,
    /// How long the robots were to move, in seconds.
    pub duration_s: f64,
    /// Time on the wall until all that the run needs was found, in seconds; with the simulator, which
    /// is started for the run, its start is part of it.
    pub preflight_s: Option<f64>,
    /// Time on the wall in which all parameters were set and read back, in seconds.
    pub parameters_s: Option<f64>,
    /// Simulated seconds for each second on the wall; `None` in real time.
    pub real_time_factor: Option<f64>,
}

/// Runs the command.
///
/// # Errors
///
/// If a file is wrong, something is missing at preflight, or the run was not completed.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let plan = Plan::read(&Request {
        experiment: arguments.experiment.clone(),
        cell: arguments.cell.clone(),
        from: arguments.from.clone(),
        backend: match arguments.backend {
            Backend::Sim => record::Backend::Simulator,
            Backend::Fleet => record::Backend::Fleet,
        },
        bag: arguments.output.clone(),
        seed: arguments.seed,
        place_check: match arguments.place_check {
            PlaceCheck::On => plan::PlaceCheck::On,
            PlaceCheck::Off => plan::PlaceCheck::Off,
        },
    })?;
    let summary = match arguments.backend {
        Backend::Sim => {
            // Before the first thread is started.
            let network = OwnNetwork::enter()?;
            logging::init(Level::Warn, std::env::var("RUST_LOG").ok().as_deref());
            say_note(&network.note);
            runtime()?.block_on(simulated(&plan, &network))?
        }
        Backend::Fleet => {
            logging::init(Level::Warn, std::env::var("RUST_LOG").ok().as_deref());
            let network = chosen_network(arguments.interface.as_deref())?;
            runtime()?.block_on(on_fleet(&plan, &network))?
        }
    };
    finish(arguments.format, &summary)
}

/// Runs a plan against a simulator that is started for it.
///
/// # Errors
///
/// If a process cannot be started or the network cannot be used.
async fn simulated(plan: &Plan, network: &OwnNetwork) -> anyhow::Result<RunSummary> {
    let mut fleet = SimulatedFleet::start(network, &plan.record.robots)?;
    let summary = on_simulated_fleet(plan, network, &mut fleet).await;
    fleet.stop().await?;
    summary
}

/// Runs a plan against a simulated fleet that is there already.
///
/// # Errors
///
/// If the network cannot be used.
pub async fn on_simulated_fleet(
    plan: &Plan,
    network: &OwnNetwork,
    fleet: &mut SimulatedFleet,
) -> anyhow::Result<RunSummary> {
    let stop = async {
        tokio::select! {
            reason = asked_to_stop() => reason,
            reason = fleet.ended() => reason,
        }
    };
    watched(plan, &network.session, stop).await
}

async fn on_fleet(plan: &Plan, network: &SessionOptions) -> anyhow::Result<RunSummary> {
    watched(plan, network, asked_to_stop()).await
}

/// Runs a plan, and shows how far it is.
///
/// # Errors
///
/// If the network cannot be used.
pub async fn watched(
    plan: &Plan,
    network: &SessionOptions,
    stop: impl Future<Output = String>,
) -> anyhow::Result<RunSummary> {
    let name = plan.bag.file_name().map_or_else(String::new, |name| name.display().to_string());
    let voice = match plan.record.backend {
        record::Backend::Simulator => Voice::Quiet,
        record::Backend::Fleet | record::Backend::Mixed => Voice::Aloud,
    };
    let bar = ExperimentBar::new(&name, voice);
    let report = conduct(plan, network, &mut |progress| bar.show(&progress), stop).await?;
    let gaps = match &report.bag {
        Some(bag) => recording_gaps::in_bag(&recorded_run::open(&bag.folder)?),
        None => Vec::new(),
    };
    Ok(summary(plan, report, gaps))
}

/// Waits until somebody asks this process to stop, and says how.
pub async fn asked_to_stop() -> String {
    match shutdown::requested().await {
        Ok(shutdown::Request::Interrupt) => "interrupted".to_owned(),
        Ok(shutdown::Request::Terminate) => "asked to terminate".to_owned(),
        Err(error) => format!("signals cannot be heard: {error}"),
    }
}

/// The network that a person has chosen, by `--interface` or the environment.
///
/// # Errors
///
/// If none is chosen, or there is none of that name or address.
pub fn chosen_network(interface: Option<&str>) -> anyhow::Result<SessionOptions> {
    let variable = std::env::var(interfaces::VARIABLE).ok();
    let address = interfaces::chosen(interface, variable.as_deref())
        .map_err(|error| with_help(error.to_string(), error.help()))?;
    let environment = rsrs_ros::ros_args::Environment::of_this_process();
    let (ros, _) = rsrs_ros::ros_args::RosArgs::parse(&[], &environment)?;
    Ok(SessionOptions { domain_id: ros.domain_id, interfaces: vec![address] })
}

/// A runtime on this thread, by whose end the nodes notice that of this process.
///
/// # Errors
///
/// If the system has no resources for it.
pub fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .context("starting the runtime")
}

fn summary(plan: &Plan, report: RunReport, gaps: Vec<Gap>) -> RunSummary {
    let record = &plan.record;
    let simulated_s = plan.steps() as f64 * record.conditions.period_s;
    let is_paced = record.time == Time::Lockstep && report.ending.kind == EndingKind::Completed;
    RunSummary {
        run_id: record.run_id.clone(),
        ending: report.ending.kind.key(),
        reason: report.ending.reason,
        n_messages: report.bag.as_ref().map_or(0, |bag| bag.n_messages),
        bag: report.bag.map(|bag| bag.folder),
        n_lost: report.n_lost,
        gaps,
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

/// Says on standard error what a person may want to know while it runs.
pub fn say_note(note: &str) {
    // Nobody is left to tell when standard error is gone.
    drop(writeln!(std::io::stderr(), "{note}"));
}

fn finish(format: Format, summary: &RunSummary) -> anyhow::Result<Outcome> {
    if !summary.not_standing.is_empty() {
        say_note(&format!(
            "not confirmed to stand, go and look: {}",
            summary.not_standing.join(", ")
        ));
    }
    let is_void = summary.ending == EndingKind::Void.key();
    if summary.ending != EndingKind::Completed.key() && !is_void {
        let kept = summary.bag.as_ref();
        let kept = kept.map(|bag| format!("what was recorded is in {}", bag.display()));
        let release = "when the floor is safe, `rsrs stop --release` lets the next run start";
        let release = (summary.reason == E_STOP_REASON).then(|| release.to_owned());
        let help: Vec<String> = kept.into_iter().chain(release).collect();
        let message = format!("run {}: {}", summary.ending, summary.reason.replace("; ", "\n  "));
        return Err(if help.is_empty() {
            anyhow::anyhow!(message)
        } else {
            with_help(message, help.join("\n"))
        });
    }
    report(format, summary, &text(summary))?;
    let whole = !is_void && summary.n_lost == 0;
    Ok(if whole { Outcome::Done } else { Outcome::NegativeAnswer })
}

fn text(summary: &RunSummary) -> String {
    let bag = summary.bag.as_ref().map_or_else(String::new, |bag| bag.display().to_string());
    let pace = summary
        .real_time_factor
        .map_or_else(String::new, |factor| format!(", {factor:.0} times real time"));
    let (duration_s, n_messages) = (summary.duration_s, summary.n_messages);
    let mut lines = vec![format!("{bag}: {duration_s} s, {n_messages} messages{pace}")];
    if summary.ending != EndingKind::Completed.key() {
        lines.push(format!("{}: {}", summary.ending, summary.reason));
    }
    if summary.n_lost > 0 {
        lines.push(format!("{} messages were lost on the way to the bag", summary.n_lost));
    }
    lines.extend(recording_gaps::lines(&summary.gaps));
    lines.push(format!("next: rsrs label {bag}"));
    lines.join("\n")
}
