//! What whoever stands beside the robots is informed of while something goes on, in words.

use std::path::Path;

use rsrs_core::numerals::count;
use rsrs_core::trials::trial::Trial;
use rsrs_fleet::record::PausedRobot;
use rsrs_pipeline::attempt::Attempt;
use rsrs_pipeline::campaign::Manifest;
use rsrs_pipeline::label::Settledness;

use crate::driven_trials::{description, pause};
use crate::gaps;
use crate::label::marked;
use crate::run_summary::unconfirmed;

/// Something that whoever stands beside the robots is informed of.
#[derive(Clone, Copy, Debug)]
pub enum OperatorEvent<'a> {
    /// A campaign goes on.
    CampaignContinued {
        /// Experiments that are finished already.
        n_finished: usize,
        /// All of them.
        n_experiments: usize,
    },
    /// An experiment has a bag that was complete already.
    BagAdopted {
        /// Its name.
        experiment: &'a str,
        /// What is known of it.
        manifest: &'a Manifest,
        /// How sure its label is.
        settledness: Settledness,
    },
    /// An experiment is run that has a run without a result.
    RunAgain {
        /// Its name.
        experiment: &'a str,
        /// The run before.
        before: &'a Attempt,
    },
    /// A run gave no result, and is made again at once.
    TriedAgain {
        /// Name of the experiment.
        experiment: &'a str,
        /// The run.
        attempt: &'a Attempt,
        /// Which try comes now, from 1.
        next: u32,
        /// Tries in all, at most.
        most: u32,
    },
    /// A run gave no result, and is not made again now.
    WithoutResult {
        /// Name of the experiment.
        experiment: &'a str,
        /// The run.
        attempt: &'a Attempt,
    },
    /// An experiment has its result.
    ExperimentFinished {
        /// Its name.
        experiment: &'a str,
        /// What came of it.
        manifest: &'a Manifest,
        /// How sure its label is.
        settledness: Settledness,
        /// When robots stood because leases did not reach them.
        paused_robots: &'a [PausedRobot],
    },
    /// The trial of a row of a table comes next.
    RowBegun {
        /// Name of the row.
        row: &'a str,
        /// Rows without a result, this one included.
        n_left: usize,
        /// Rows that were without one at the beginning.
        n_rows: usize,
        /// The robot that is measured.
        robot: &'a str,
        /// What it does.
        trial: &'a Trial,
    },
    /// Commands paused in the trial of a row.
    RowPaused {
        /// The table.
        table: &'a Path,
        /// Line of the table, from 1.
        line: usize,
        /// For how long, in seconds.
        paused_s: f64,
        /// Whether the trial is made again at once.
        is_made_again: bool,
    },
    /// A robot that stood gave fewer readings than were planned.
    FewReadings {
        /// The robot.
        robot: &'a str,
        /// Readings that came.
        samples: u64,
        /// Readings that were planned.
        planned: u64,
    },
    /// A robot without a profile is driven.
    NoProfile {
        /// The robot.
        robot: &'a str,
        /// The profile that its fleet file names, which is not there.
        profile: Option<&'a str>,
        /// Its limits, in m/s and rad/s.
        limits: [f64; 2],
    },
    /// Robots did not report that they stand.
    Unconfirmed {
        /// Their names.
        robots: &'a [String],
    },
    /// Topics of a bag by which robots are steered are not published.
    GuardedLeftOut {
        /// Their names.
        topics: &'a [String],
    },
    /// Topics that a bag holds otherwise than ROS 2 sends them are not published.
    ForeignLeftOut {
        /// Their names.
        topics: &'a [String],
    },
    /// A topic of a bag is not published, because another program publishes it now.
    LivingLeftOut {
        /// Its name.
        topic: &'a str,
        /// The node of that program, if it is known.
        node: Option<&'a str>,
    },
    /// The recorded time is not published, because robots are live.
    TimeLeftOut,
}

/// An event in words.
pub fn text(event: &OperatorEvent<'_>) -> String {
    match *event {
        OperatorEvent::CampaignContinued { n_finished, n_experiments } => {
            format!("{n_finished} of {n_experiments} are finished")
        }
        OperatorEvent::BagAdopted { experiment, manifest, settledness } => {
            let outcome = outcome(manifest, settledness);
            format!("{experiment}: its bag was complete already{outcome}")
        }
        OperatorEvent::RunAgain { experiment, before } => {
            format!("{experiment}: run again; before, {}", without_result(before))
        }
        OperatorEvent::TriedAgain { experiment, attempt, next, most } => {
            let what = without_result(attempt);
            format!("{experiment}: {what}; tried again, {next} of {most}")
        }
        OperatorEvent::WithoutResult { experiment, attempt } => {
            format!("{experiment}: {}", without_result(attempt))
        }
        OperatorEvent::ExperimentFinished { experiment, manifest, settledness, paused_robots } => {
            let outcome = outcome(manifest, settledness);
            let first = format!("{experiment}: {}{outcome}", manifest.ending);
            let lost = manifest.lost_robots.iter().map(ToString::to_string);
            let paused = paused_robots.iter().map(ToString::to_string);
            let below = lost.chain(gaps::lines(&manifest.gaps)).chain(paused);
            below.fold(first, |text, line| format!("{text}\n  {line}"))
        }
        OperatorEvent::RowBegun { row, n_left, n_rows, robot, trial } => {
            let what = description(robot, trial);
            format!("{row}, {n_left} of {n_rows} rows left: {what}")
        }
        OperatorEvent::RowPaused { table, line, paused_s, is_made_again } => {
            let next = if is_made_again { "; it is made again" } else { "" };
            format!("{}:{line}: {}{next}", table.display(), pause(paused_s))
        }
        OperatorEvent::FewReadings { robot, samples, planned } => {
            format!("{robot}: {samples} readings came while the trial ran, {planned} were planned")
        }
        OperatorEvent::NoProfile { robot, profile, limits: [most_m_s, most_rad_s] } => {
            let missing = match profile {
                Some(profile) => format!("the profile `{profile}` of {robot} is not there yet"),
                None => format!("{robot} has no profile yet"),
            };
            format!(
                "{missing}; its limits are those of the trials, {most_m_s} m/s and {most_rad_s} rad/s"
            )
        }
        OperatorEvent::Unconfirmed { robots } => unconfirmed(robots).to_string(),
        OperatorEvent::GuardedLeftOut { topics } => {
            left_out(topics, "robots are steered by them; `--topics` takes them by name")
        }
        OperatorEvent::ForeignLeftOut { topics } => {
            left_out(topics, "the bag does not hold them as ROS 2 sends them")
        }
        OperatorEvent::LivingLeftOut { topic, node } => {
            let node = node.unwrap_or("a program without a name");
            format!("left out {topic}: {node} publishes it now; `--topics` takes it by name")
        }
        OperatorEvent::TimeLeftOut => {
            "the time is not published: there are robots on this network".to_owned()
        }
    }
}

/// That notes of a run were not shown.
pub fn not_shown(n_notes: u64) -> String {
    format!(
        "{n_notes} notes are not shown, because nothing read them in time; the bag has them, on /rosout"
    )
}

/// A run that gave no result, with where its recording is.
pub fn without_result(attempt: &Attempt) -> String {
    let kept = attempt.bag.as_ref().map(|bag| format!(" (kept as {bag})"));
    format!("{attempt}{}", kept.unwrap_or_default())
}

/// What came of an experiment, behind its name.
fn outcome(manifest: &Manifest, settledness: Settledness) -> String {
    match manifest.phase {
        Some(phase) => format!(", {}", marked(phase.to_string(), settledness)),
        None => format!(", not judged: {}", manifest.not_judged),
    }
}

fn left_out(topics: &[String], why: &str) -> String {
    format!("left out {} ({why}): {}", count(topics.len() as u64), topics.join(", "))
}
