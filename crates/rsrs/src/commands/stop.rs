//! `rsrs stop`: stops every robot, whatever runs, and waits until each reports it.

use std::path::PathBuf;

use rsrs_core::printable::one_line;
use rsrs_experiment_runner::stop::{Holding, StopReport, command_all, join};
use rsrs_fleet::e_stop::LockCause;
use rsrs_fleet::stopper::{RobotAcknowledgement, StopCommand, StopOutcome};
use rsrs_ros::logging::{self, Level};
use rsrs_ros::security::Member;
use serde::Serialize;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::fleet_network::{InterfaceArguments, chosen_network, other_middleware};
use crate::interrupt::requested;
use crate::notes::print_always;
use rsrs_pipeline::measure::plan_folder::enabled_robots;
use rsrs_render::words::{Tone, Words};
use rsrs_ros::runtime::runtime;

/// Stop every robot; return when all have acknowledged.
///
/// Needs no runner. Robots are found by their statuses and by leases; `--fleet` names those that should
/// be there. The robots stay locked after the command has ended: no run starts before `rsrs stop
/// --release`, and robots that were stopped in a run stand until a new run arms them. No other
/// publisher on the e-stop topic can undo it; a release names those that still hold it. Exit code 3
/// means that a robot has not acknowledged within 7 s (10 s in a secured fleet, which needs the enclave
/// `/stop`: docs/security.md): go and look.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs stop --interface wlan0
  rsrs stop --interface wlan0 --fleet launch_configs/fleets/nine_virtual.yaml
  rsrs stop --interface wlan0 --release")]
pub struct Arguments {
    #[command(flatten)]
    network: InterfaceArguments,
    /// Fleet file (YAML): its enabled robots must acknowledge, seen or not.
    #[arg(long, value_name = "FLEET")]
    fleet: Option<PathBuf>,
    /// Release the lock instead; refused while robots are in a run.
    #[arg(long)]
    release: bool,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// What came of a stop or release.
#[derive(Serialize)]
struct StopSummary {
    /// `stop` or `release`.
    #[serde(rename = "word")]
    command: &'static str,
    /// Whether every known robot has acknowledged, and there is one.
    acknowledged: bool,
    /// How long it took, in seconds.
    took_s: f64,
    /// Who still holds robots after a release.
    holding: Vec<HoldingRow>,
    /// By name.
    robots: Vec<RobotRow>,
}

/// A lock that a release leaves alone.
#[derive(Serialize)]
struct HoldingRow {
    /// The node that holds it, if its name is known.
    node: Option<String>,
    /// The GUID of its publisher.
    publisher: String,
    /// Whether it reported that it is engaged, or fell silent.
    cause: &'static str,
}

#[derive(Serialize)]
struct RobotRow {
    robot: String,
    acknowledged: bool,
    /// From the first message to the acknowledgement, in seconds.
    after_s: Option<f64>,
    /// The state in its last status; `None` if none was received.
    state: Option<String>,
    stop_reason: Option<String>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    logging::init(Level::Warn);
    rsrs_ros::session::start_again_after_deadlock();
    let network = chosen_network(&arguments.network.interface, Member::Stop)?;
    let robots = arguments.fleet.as_deref().map_or_else(|| Ok(Vec::new()), enabled_robots)?;
    let command = if arguments.release { StopCommand::Release } else { StopCommand::Engage };
    let given = runtime()?
        .block_on(async { command_all(join(&network)?, command, &robots, requested()).await })?;
    let summary = summary(command, &given);
    report(arguments.format, &summary, words(command, &summary))?;
    let named = if robots.is_empty() { Named::Nobody } else { Named::ByFleetFile };
    print_ending(command, named, &given);
    Ok(match given.ending {
        StopOutcome::Acknowledged => Outcome::Done,
        StopOutcome::TimedOut | StopOutcome::Interrupted | StopOutcome::InRun => {
            Outcome::NegativeAnswer
        }
    })
}

fn summary(command: StopCommand, report: &StopReport) -> StopSummary {
    StopSummary {
        command: match command {
            StopCommand::Engage => "stop",
            StopCommand::Release => "release",
        },
        acknowledged: report.ending == StopOutcome::Acknowledged,
        took_s: report.took_s,
        holding: match command {
            StopCommand::Engage => Vec::new(),
            StopCommand::Release => report.holding.iter().map(holding_row).collect(),
        },
        robots: report.answers.iter().map(row).collect(),
    }
}

fn holding_row(holding: &Holding) -> HoldingRow {
    HoldingRow {
        node: holding.node.clone(),
        publisher: holding.source.to_string(),
        cause: match holding.cause {
            LockCause::Engaged => "engaged",
            LockCause::Silent => "silent",
        },
    }
}

fn row(answer: &RobotAcknowledgement) -> RobotRow {
    let last = answer.last.as_ref();
    RobotRow {
        robot: answer.robot.clone(),
        acknowledged: answer.acknowledged_after.is_some(),
        after_s: answer.acknowledged_after.map(|after| after.as_secs_f64()),
        state: last.map(|status| status.state.to_string()),
        stop_reason: last.map(|status| status.stop_reason.clone()),
    }
}

/// A table of the robots; those that have not acknowledged catch the eye.
fn words(command: StopCommand, summary: &StopSummary) -> Words {
    if summary.robots.is_empty() {
        return Words::toned(Tone::Bad, "no robot found");
    }
    let longest = summary.robots.iter().map(|row| row.robot.len()).max().unwrap_or(0);
    let width = longest.max("robot".len());
    let head = match command {
        StopCommand::Engage => "stands",
        StopCommand::Release => "released",
    };
    let mut words = Words::from(format!("{:width$}  {head:8}  {:>6}  reports", "robot", "after"));
    for row in &summary.robots {
        let answer = if row.acknowledged { "yes" } else { "NO" };
        let after = row.after_s.map_or_else(|| "-".to_owned(), |after_s| format!("{after_s:.2} s"));
        let reports = match (row.state.as_deref(), row.stop_reason.as_deref()) {
            (Some(state), Some("") | None) => state.to_owned(),
            // "stopped by the runner" is both.
            (Some(state), Some(reason)) if reason.starts_with(state) => reason.to_owned(),
            (Some(state), Some(reason)) => format!("{state}: {reason}"),
            (None, _) => "no status received".to_owned(),
        };
        let gap = " ".repeat("released".len() - answer.len());
        words = words
            .below(format!("{:width$}  ", row.robot))
            .then_toned(Tone::good_if(row.acknowledged), answer)
            .then(format!("{gap}  {after:>6}  {reports}"));
    }
    words
}

/// Who says which robots there are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Named {
    /// Robots were found; there may be others that were not.
    Nobody,
    ByFleetFile,
}

/// Prints on standard error what follows.
fn print_ending(command: StopCommand, named: Named, report: &StopReport) {
    let silent = report.unacknowledged();
    let (n_robots, took_s) = (report.answers.len(), report.took_s);
    print_always(match (report.ending, command) {
        (StopOutcome::Acknowledged, StopCommand::Engage) => {
            let all = all_of(n_robots, named);
            format!("{all} locked; `rsrs stop --release` lets the next run start")
        }
        (StopOutcome::Acknowledged, StopCommand::Release) => {
            format!("{} released, and stand until a run arms them", all_of(n_robots, named))
        }
        (StopOutcome::InRun, _) => "robots are in a run: nothing was published to them".to_owned(),
        (StopOutcome::TimedOut | StopOutcome::Interrupted, _) if n_robots == 0 => format!(
            "no robot found in {took_s:.0} s; is this their interface, and their ROS_DOMAIN_ID? A \
             secured fleet needs ROS_SECURITY_ENABLE and ROS_SECURITY_KEYSTORE{}",
            other_middleware().map_or_else(String::new, |other| format!("\n{other}"))
        ),
        (StopOutcome::TimedOut | StopOutcome::Interrupted, StopCommand::Release)
            if !report.holding.is_empty() =>
        {
            let names = report.holding.iter().map(name_of).collect::<Vec<_>>();
            format!(
                "the e-stop is still held by {}: release it there, or end that program (one that \
                 died is forgotten after half a minute), and type `rsrs stop --release` again",
                names.join(", ")
            )
        }
        (StopOutcome::TimedOut | StopOutcome::Interrupted, _) => format!(
            "not acknowledged within {took_s:.1} s by {} of {n_robots} robots, go and look: {}",
            silent.len(),
            silent.join(", ")
        ),
    });
}

fn name_of(holding: &Holding) -> String {
    match &holding.node {
        Some(node) => one_line(node).into_owned(),
        None => format!("publisher {}", holding.source),
    }
}

fn all_of(n_robots: usize, named: Named) -> String {
    match (n_robots, named) {
        (1, Named::ByFleetFile) => "the one robot is".to_owned(),
        (n, Named::ByFleetFile) => format!("all {n} robots are"),
        (1, Named::Nobody) => {
            "1 robot was found (`--fleet` names those that should be), and is".to_owned()
        }
        (n, Named::Nobody) => {
            format!("{n} robots were found (`--fleet` names those that should be), and all are")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_fleet_file_all_are_those_that_were_found() {
        assert_eq!(all_of(9, Named::ByFleetFile), "all 9 robots are");
        let found = "8 robots were found (`--fleet` names those that should be), and all are";
        assert_eq!(all_of(8, Named::Nobody), found);
    }
}
