//! What came of stopping every robot, or of releasing them, in words.

use rsrs_core::printable::one_line;
use rsrs_fleet::stopper::{StopCommand, StopOutcome};
use serde::Serialize;

use crate::words::{Tone, Words};

/// What came of a stop or release.
#[derive(Clone, Debug, Serialize)]
pub struct StopSummary {
    /// `stop` or `release`.
    #[serde(rename = "word")]
    pub command: StopCommand,
    /// Whether every known robot has acknowledged, and there is one.
    pub acknowledged: bool,
    /// How it ended.
    #[serde(skip)]
    pub ending: StopOutcome,
    /// How long it took, in seconds.
    pub took_s: f64,
    /// Who still holds robots after a release.
    pub holding: Vec<HoldingRow>,
    /// By name.
    pub robots: Vec<RobotRow>,
}

/// A lock that a release leaves alone.
#[derive(Clone, Debug, Serialize)]
pub struct HoldingRow {
    /// The node that holds it, if its name is known.
    pub node: Option<String>,
    /// The GUID of its publisher.
    pub publisher: String,
    /// Whether it reported that it is engaged, or fell silent.
    pub cause: &'static str,
}

/// What came of it for one robot.
#[derive(Clone, Debug, Serialize)]
pub struct RobotRow {
    /// Its name.
    pub robot: String,
    /// Whether it has acknowledged.
    pub acknowledged: bool,
    /// From the first message to the acknowledgement, in seconds.
    pub after_s: Option<f64>,
    /// The state in its last status; `None` if none was received.
    pub state: Option<String>,
    /// Why it stands, in its last status.
    pub stop_reason: Option<String>,
}

impl StopSummary {
    fn unacknowledged(&self) -> Vec<&str> {
        let silent = self.robots.iter().filter(|row| !row.acknowledged);
        silent.map(|row| row.robot.as_str()).collect()
    }
}

/// A table of the robots; those that have not acknowledged catch the eye.
pub fn table(summary: &StopSummary) -> Words {
    if summary.robots.is_empty() {
        return Words::toned(Tone::Bad, "no robot found");
    }
    let longest = summary.robots.iter().map(|row| row.robot.len()).max().unwrap_or(0);
    let width = longest.max("robot".len());
    let head = match summary.command {
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Named {
    /// Robots were found; there may be others that were not.
    Nobody,
    /// A fleet file.
    ByFleetFile,
}

/// What follows, with what may have kept robots from being found.
pub fn next(summary: &StopSummary, named: Named, other_middleware: Option<&str>) -> String {
    let silent = summary.unacknowledged();
    let (n_robots, took_s) = (summary.robots.len(), summary.took_s);
    match (summary.ending, summary.command) {
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
            other_middleware.map_or_else(String::new, |other| format!("\n{other}"))
        ),
        (StopOutcome::TimedOut | StopOutcome::Interrupted, StopCommand::Release)
            if !summary.holding.is_empty() =>
        {
            let names = summary.holding.iter().map(name_of).collect::<Vec<_>>();
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
    }
}

/// What came of a stop, on one line.
pub fn in_short(summary: &StopSummary) -> String {
    let silent = summary.unacknowledged();
    let longest_s = summary.robots.iter().filter_map(|row| row.after_s).fold(0.0, f64::max);
    match (summary.robots.len(), &silent[..]) {
        (0, _) => "NO robot was found to stop: is this their interface and domain?".to_owned(),
        (n, []) => {
            format!("{n} of {n} robots stand ({longest_s:.2} s); next: rsrs stop --release")
        }
        (n, silent) => format!(
            "NOT acknowledged by {} of {n}, go and look: {}",
            silent.len(),
            silent.join(", ")
        ),
    }
}

/// That a stop which was ordered did not go out, and why.
pub fn not_published(why: &str) -> String {
    format!("the stop was NOT published: {why}")
}

/// That robots cannot be stopped from here, and why.
pub fn not_possible(why: &str) -> String {
    format!("NOT stopped: {why}")
}

/// While robots have still to acknowledge a stop.
pub const UNDER_WAY: &str = "STOPPING all robots: waiting for their acknowledgements";

fn name_of(holding: &HoldingRow) -> String {
    match &holding.node {
        Some(node) => one_line(node).into_owned(),
        None => format!("publisher {}", holding.publisher),
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
