//! `rsrs run`: step 4, one experiment over ROS 2, recorded.

use std::path::{Path, PathBuf};

use rsrs_bags::METADATA;
use rsrs_core::judge::window::Window;
use rsrs_core::numerals::counted;
use rsrs_experiment_runner::plan::{Plan, Request};
use rsrs_experiment_runner::{backends, place_checks};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::message::E_STOP_REASON;
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::{Backend, EndingKind, ExperimentRecord};
use rsrs_ros::session::SessionOptions;

use crate::commands::{Format, report};
use crate::experiment_arguments::ExperimentArguments;
use crate::experiment_bar::TerminalOperator;
use crate::failure::Outcome;
use crate::fleet_network::{InterfaceArguments, enter, other_middleware, refuse_flags_of_a_fleet};
use crate::interrupt::asked_to_stop;
use crate::notes::print_always;
use crate::profile_arguments::ProfileArguments;
use rsrs_files::quoted;
use rsrs_operate::run::own_network::OwnNetwork;
use rsrs_operate::run::place_command;
use rsrs_operate::run::simulated_fleet::SimulatedFleet;
use rsrs_operate::run::start_poses::{start_poses, wanted};
use rsrs_operate::run::{NOT_STANDING, RunSummary, RunTarget, on_simulated_fleet, watched};
use rsrs_pipeline::error::with_help;
use rsrs_render::gaps;
use rsrs_render::words::{Tone, Words};
use rsrs_ros::runtime::runtime;

/// Run one experiment over ROS 2, and record it.
///
/// With the simulator, everything that the run needs is started and ended with it, in a network of its
/// own. With the fleet, the robots' nodes must be running, and `--interface` names their network; a
/// countdown of 3 s comes before the robots move, and Ctrl-C stops them at any time. Exit code 3 means
/// that the run ended but does not count, that a robot is not confirmed to stand, or that data was
/// lost: on a topic that must lose none, or because the recorder did not keep up.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs run launch_configs/experiments/flockbot_milling.yaml -o milling
  rsrs run launch_configs/experiments/flockbot_milling.yaml --from results/flockbot
  rsrs run milling.yaml --backend fleet --interface wlan0
  rsrs run milling.yaml --backend fleet --interface wlan0 --place-command './drive_to_places.py'")]
pub struct Arguments {
    #[command(flatten)]
    setup: ExperimentArguments,
    /// What moves the robots (default: sim).
    #[arg(long, value_parser = backends("The simulator, in a network of its own"), default_value = "sim", hide_default_value = true)]
    backend: Backend,
    #[command(flatten)]
    network: InterfaceArguments,
    /// Seed of the simulated world (default: the experiment file's).
    #[arg(long, value_name = "SEED", value_parser = clap::value_parser!(u64).range(..rsrs_core::diagram::sweep_file::SEED_LIMIT))]
    seed: Option<u64>,
    /// Program that places the robots of a fleet before the run: it gets one line of JSON on its
    /// standard input; another exit code than 0 stops the run (docs/campaigns.md).
    #[arg(long, value_name = "PROGRAM")]
    place_command: Option<String>,
    /// What to do, before a fleet moves, about robots that do not stand where they should (default: on).
    #[arg(long, value_parser = place_checks())]
    place_check: Option<PlaceCheck>,
    #[command(flatten)]
    other: ProfileArguments,
    /// Folder of the bag; it must not exist (default: named after the run, in this folder).
    #[arg(short, long, value_name = "BAG")]
    output: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    refuse_flags_of_a_fleet(
        arguments.backend,
        &arguments.network,
        arguments.place_command.as_deref(),
        arguments.place_check,
    )?;
    let plan = Plan::read(&Request {
        experiment: arguments.setup.experiment.clone(),
        cell: arguments.setup.cell.clone(),
        from: arguments.setup.from.clone(),
        backend: arguments.backend,
        bag: arguments.output.clone(),
        seed: arguments.seed,
        place_check: arguments.place_check.unwrap_or_default(),
        other_profile: arguments.other.profile(),
    })?;
    let place_command = arguments.place_command.as_deref();
    let target = enter(arguments.backend, &arguments.network.interface)?;
    let summary = runtime()?.block_on(async {
        match &target {
            RunTarget::Simulator(network) => simulated(&plan, network).await,
            RunTarget::Fleet(network) => on_fleet(&plan, network, place_command).await,
        }
    })?;
    let same = same_again(&plan.record, arguments.seed);
    finish((arguments.format, same), &plan.record, &summary)
}

/// Runs a plan against a simulator that is started for it.
async fn simulated(plan: &Plan, network: &OwnNetwork) -> anyhow::Result<RunSummary> {
    let mut fleet = SimulatedFleet::start(network, plan)?;
    let summary = on_simulated_fleet(plan, network, &mut fleet, &TerminalOperator).await;
    fleet.stop().await?;
    summary
}

/// Runs a plan on the fleet, whose robots a program places if there is one.
async fn on_fleet(
    plan: &Plan,
    network: &SessionOptions,
    place_command: Option<&str>,
) -> anyhow::Result<RunSummary> {
    if let Some(program) = place_command {
        let wanted = wanted(&start_poses(plan)?, plan.bag.display().to_string());
        place_command::place(program, &wanted, &TerminalOperator).await?;
    }
    watched(plan, network, asked_to_stop(), &TerminalOperator).await
}

/// That another such run is the same one again: in lockstep, of one seed.
fn same_again(record: &ExperimentRecord, given: Option<u64>) -> Option<String> {
    let is_same = record.backend == Backend::Simulator && record.time == Time::Lockstep;
    let seed = record.seed;
    (is_same && given.is_none()).then(|| {
        format!(
            "note: without `--seed` such a run is always this one, of seed {seed}; the next one is \
             another with `--seed {}`",
            seed + 1
        )
    })
}

fn finish(
    (format, same): (Format, Option<String>),
    record: &ExperimentRecord,
    summary: &RunSummary,
) -> anyhow::Result<Outcome> {
    if !summary.not_standing.is_empty() {
        let names = summary.not_standing.join(", ");
        print_always(Words::toned(Tone::Bad, NOT_STANDING).then(format!(": {names}")));
    }
    if let EndingKind::Aborted | EndingKind::Failed = summary.ending {
        let kept = summary.bag.as_ref();
        let kept = kept.map(|bag| {
            let recover = if bag.join(METADATA).exists() {
                String::new()
            } else {
                format!(", not closed: `rsrs bag recover {}`", quoted(bag))
            };
            format!("what was recorded is in {}{recover}", bag.display())
        });
        let release = "when the floor is safe, `rsrs stop --release` lets the next run start";
        let release = (summary.reason == E_STOP_REASON).then(|| release.to_owned());
        // Nothing was recorded of a run for which something was not found.
        let middleware = other_middleware().filter(|_| kept.is_none());
        let middleware = middleware.map(|other| other.to_string());
        let help: Vec<String> = kept.into_iter().chain(release).chain(middleware).collect();
        let message =
            format!("run {}: {}", summary.ending.key(), summary.reason.replace("; ", "\n  "));
        return Err(if help.is_empty() {
            anyhow::anyhow!(message)
        } else {
            with_help(message, help.join("\n"))
        });
    }
    let judged = record.conditions.behaviour.window();
    report(format, summary, text((summary, judged), same))?;
    Ok(outcome(record, summary))
}

/// What the exit code states of a run that was completed or is void.
fn outcome(record: &ExperimentRecord, summary: &RunSummary) -> Outcome {
    let is_completed = summary.ending == EndingKind::Completed;
    let counts = is_completed && record.counts_without(&summary.lost_robots);
    // What a best-effort topic loses on its way is listed, and was to be expected.
    let has_overflowed = summary.gaps.iter().any(|gap| gap.n_overflowed > 0);
    let has_lost = summary.n_lost > 0 || has_overflowed;
    // Whatever comes next, such as a program that places the robots, would be among moving ones.
    let stands = summary.not_standing.is_empty();
    if counts && !has_lost && stands { Outcome::Done } else { Outcome::NegativeAnswer }
}

/// What to look at: a run that is too short for a label can be drawn.
fn next(bag: &Path, duration_s: f64, judged: Window) -> String {
    let least_s = judged.least_s();
    if duration_s >= least_s {
        return format!("next: rsrs label {}", quoted(bag));
    }
    let picture = quoted(bag.with_extension("svg"));
    let why = format!("a label takes {least_s:.0} s or more");
    format!("next: rsrs draw {} -o {picture}   # {why}", quoted(bag))
}

fn text((summary, judged): (&RunSummary, Window), same: Option<String>) -> Words {
    let bag = summary.bag.as_ref().map_or_else(String::new, |bag| bag.display().to_string());
    let pace = summary
        .real_time_factor
        .map_or_else(String::new, |factor| format!(", {factor:.0} times real time"));
    let (duration_s, messages) = (summary.duration_s, counted(summary.n_messages, "message"));
    let mut words = Words::from(format!("{bag}: {duration_s} s, {messages}{pace}"));
    if summary.ending != EndingKind::Completed {
        let ending = Words::toned(Tone::Bad, summary.ending.key());
        words = words.below(ending.then(format!(": {}", summary.reason)));
    }
    let mut lines: Vec<String> = Vec::new();
    lines.extend(summary.other_profile.iter().map(|differ| format!("note: {differ}")));
    lines.extend(summary.own_profiles.iter().map(|(robot, own)| format!("{robot}: {own}")));
    lines.extend(summary.lost_robots.iter().map(ToString::to_string));
    lines.extend(summary.paused_robots.iter().map(ToString::to_string));
    if summary.n_lost > 0 {
        let lost = counted(summary.n_lost, "message");
        lines.push(format!("{lost} lost on the way to the bag"));
    }
    lines.extend(gaps::lines(&summary.gaps));
    lines.extend(same);
    lines.extend(summary.bag.as_ref().map(|bag| next(bag, summary.duration_s, judged)));
    lines.into_iter().fold(words, Words::below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rsrs_fleet::experiment::RobotLost;
    use rsrs_fleet::record::LostRobot;
    use rsrs_testing::conditions::flockbot_conditions;
    use rsrs_testing::record::fleet_record;

    fn record(robot_lost: RobotLost) -> ExperimentRecord {
        ExperimentRecord { robot_lost, ..fleet_record("0", flockbot_conditions()) }
    }

    fn completed() -> RunSummary {
        RunSummary {
            run_id: "run".to_owned(),
            bag: None,
            ending: EndingKind::Completed,
            reason: String::new(),
            has_started: true,
            lost_robots: Vec::new(),
            paused_robots: Vec::new(),
            n_messages: 1,
            n_lost: 0,
            gaps: Vec::new(),
            other_profile: None,
            own_profiles: std::collections::BTreeMap::new(),
            not_standing: Vec::new(),
            duration_s: 300.0,
            preflight_s: None,
            parameters_s: None,
            real_time_factor: None,
        }
    }

    #[test]
    fn that_a_run_without_a_seed_would_be_the_same_again_is_said_in_the_simulator() {
        let fleet = record(RobotLost::Note);
        let simulated = ExperimentRecord {
            backend: Backend::Simulator,
            time: Time::Lockstep,
            seed: 4,
            ..fleet.clone()
        };

        let said = same_again(&simulated, None).expect("it would be the same");
        assert!(said.ends_with("`--seed 5`"), "{said}");
        assert_eq!(same_again(&simulated, Some(4)), None);
        assert_eq!(same_again(&fleet, None), None);
    }

    #[test]
    fn a_robot_that_is_not_confirmed_to_stand_or_a_run_that_does_not_count_is_no_success() {
        let lost = |after_s: f64| {
            let (robot, reason) = ("robot_1".to_owned(), "silent".to_owned());
            vec![LostRobot { robot, after_s, reason }]
        };
        let moving = RunSummary { not_standing: vec!["robot_1".to_owned()], ..completed() };
        let void = RunSummary { ending: EndingKind::Void, ..completed() };
        let without = |after_s| RunSummary { lost_robots: lost(after_s), ..completed() };
        for (summary, rule, is_done) in [
            (completed(), RobotLost::Abort, true),
            (moving, RobotLost::Abort, false),
            (void, RobotLost::Abort, false),
            (without(250.0), RobotLost::Note, false),
            (without(250.0), RobotLost::AbortUntilJudged, true),
        ] {
            let outcome = outcome(&record(rule), &summary);

            assert_eq!(matches!(outcome, Outcome::Done), is_done, "{summary:?}");
        }
    }

    #[test]
    fn messages_are_counted_as_those_of_a_bag_are() {
        let printed = |n_messages| {
            let summary = RunSummary { n_messages, ..completed() };
            text((&summary, Window::default()), None).to_string()
        };

        assert_eq!(printed(71_384), ": 300 s, 71,384 messages");
        assert_eq!(printed(1), ": 300 s, 1 message");
    }
}
