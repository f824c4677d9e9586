//! Stopping every robot of a network, whatever runs, and releasing them.

use rsrs_experiment_runner::stop::{self, Holding, StopReport, join};
use rsrs_fleet::e_stop::LockCause;
use rsrs_fleet::stopper::{RobotAcknowledgement, StopCommand, StopOutcome};
use rsrs_render::stop::{HoldingRow, RobotRow, StopSummary};
use rsrs_ros::session::SessionOptions;

/// Gives the command to all robots of a network, to these and to others that are found, until each has
/// acknowledged it, the time is up, or `interrupt` completes.
pub async fn command_all(
    network: &SessionOptions,
    command: StopCommand,
    robots: &[String],
    interrupt: impl Future<Output = ()>,
) -> anyhow::Result<StopSummary> {
    let report = stop::command_all(join(network)?, command, robots, interrupt).await?;
    Ok(summary(command, &report))
}

/// What came of a command, as people and programs get it.
pub(crate) fn summary(command: StopCommand, report: &StopReport) -> StopSummary {
    StopSummary {
        command,
        acknowledged: report.ending == StopOutcome::Acknowledged,
        ending: report.ending,
        took_s: report.took_s,
        holding: match command {
            StopCommand::Engage => Vec::new(),
            StopCommand::Release => report.holding.iter().map(holding_row).collect(),
        },
        robots: report.answers.iter().map(robot_row).collect(),
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

fn robot_row(answer: &RobotAcknowledgement) -> RobotRow {
    let last = answer.last.as_ref();
    RobotRow {
        robot: answer.robot.clone(),
        acknowledged: answer.acknowledged_after.is_some(),
        after_s: answer.acknowledged_after.map(|after| after.as_secs_f64()),
        state: last.map(|status| status.state.to_string()),
        stop_reason: last.map(|status| status.stop_reason.clone()),
    }
}
