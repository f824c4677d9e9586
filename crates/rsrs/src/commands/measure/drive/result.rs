//! What a trial came to: a row of the table that `rsrs measure fit` reads.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_bags::trajectory::{Keep, RecordedTrajectory, TrajectoryError, read_trajectory};
use rsrs_core::controller::ControllerParameters;
use rsrs_core::trial::{DrivenTrial, Neighbour, reduced};
use rsrs_experiment_runner::plan::{Plan, Trial};
use serde::Serialize;

use super::table_file::{self, TableLock};
use crate::bag_trials;
use crate::failure::with_help;
use crate::files::read_text;
use crate::recorded_run;
use crate::sensor_readings::Readings;

/// What one trial came to.
#[derive(Clone, Debug, Serialize)]
pub struct TrialResult {
    /// Where it was recorded.
    pub bag: PathBuf,
    /// The robot.
    pub robot: String,
    /// Where the numbers come from.
    pub source: Source,
    /// What was measured.
    #[serde(flatten)]
    pub motion: Motion,
}

/// Where the numbers of a trial come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The recorded poses.
    Poses,
    /// Tape and stopwatch, by who drove it.
    Operator,
    /// What its sensor said in the bag.
    Detections,
}

/// What a robot did under one command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Motion {
    /// A straight run.
    Straight {
        /// Commanded speed, in metres per second.
        commanded_m_s: f64,
        /// Distance along the line, in metres.
        distance_m: f64,
        /// Time taken, in seconds.
        duration_s: f64,
        /// Where it ended beside the line, in metres; left is positive.
        lateral_m: Option<f64>,
        /// How much its heading changed, in radians; counterclockwise is positive.
        heading_change_rad: Option<f64>,
    },
    /// A turn in place.
    Turn {
        /// Commanded turning rate, in radians per second.
        commanded_rad_s: f64,
        /// Angle turned, in radians.
        angle_rad: f64,
        /// Time taken, in seconds.
        duration_s: f64,
    },
    /// None: it stood and sensed.
    Standing {
        /// Distance of the neighbour's centre, in metres; `None` if it was alone.
        distance_m: Option<f64>,
        /// Bearing of the neighbour's centre, in radians, left is positive; `None` if it was alone.
        bearing_rad: Option<f64>,
        /// Readings taken.
        samples: u64,
        /// Readings that said "detected".
        detections: u64,
    },
    /// A curve: a trajectory for `rsrs validate`, and no row of a table.
    Curve {
        /// Commanded speed, in metres per second.
        commanded_m_s: f64,
        /// Commanded turning rate, in radians per second.
        commanded_rad_s: f64,
    },
}

/// Headers of the tables of straight runs, of turns and of detections.
pub const HEADERS: [&str; 3] = [
    "robot,commanded_m_s,distance_m,duration_s,lateral_m,heading_change_rad",
    "robot,commanded_rad_s,angle_rad,duration_s",
    "robot,distance_m,bearing_rad,samples,detections",
];

/// Refuses, before anything moves, a table to which the result could not be added.
///
/// # Errors
///
/// If the trial is a curve, or the table is of another kind.
pub fn check_table(path: &Path, trial: &Trial) -> anyhow::Result<()> {
    let command = trial.command();
    let header = match (trial, command.speed_m_s > 0.0, command.turn_rate_rad_s > 0.0) {
        (Trial::Stand { .. }, ..) => HEADERS[2],
        (_, true, false) => HEADERS[0],
        (_, false, _) => HEADERS[1],
        (_, true, true) => {
            return Err(with_help(
                "a curve is no row of a table of straight runs or turns",
                "leave out `--table`; `rsrs validate --trajectories BAG` takes the bag",
            ));
        }
    };
    // Another process may fill it in for hours; that is said before anything moves.
    let _lock = TableLock::take(path, table_file::PATIENCE)?;
    if !path.exists() {
        return Ok(());
    }
    let text = read_text(path)?;
    let found = text.lines().next().unwrap_or("");
    if found != header {
        bail!("{}: the header is `{found}`, expected `{header}`", path.display());
    }
    Ok(())
}

impl TrialResult {
    /// Reads the result out of the recorded poses.
    ///
    /// # Returns
    ///
    /// `None` if the bag has no poses.
    ///
    /// # Errors
    ///
    /// If the bag cannot be read, or its poses are no drive.
    pub fn of_bag(bag: &Path, plan: &Plan) -> anyhow::Result<Option<Self>> {
        let opened = recorded_run::open(bag)?;
        let options = recorded_run::trajectory_options(Some(&plan.record), None, Keep::All);
        let recorded = read_trajectory(&opened, &options);
        if is_unseen(&recorded) {
            return Ok(None);
        }
        let driven = bag_trials::read(bag)?.driven;
        let [trial] = &driven[..] else {
            bail!("{}: {} drives, expected 1", bag.display(), driven.len());
        };
        let robot = plan.robots[0].name.clone();
        let motion = motion(trial, plan.record.conditions.controller);
        Ok(Some(Self { bag: bag.to_owned(), robot, source: Source::Poses, motion }))
    }

    /// The result of a trial in which the robot stood.
    pub fn of_readings(plan: &Plan, neighbour: Option<Neighbour>, found: Readings) -> Self {
        let Readings { samples, detections } = found;
        Self {
            bag: plan.bag.clone(),
            robot: plan.robots[0].name.clone(),
            source: Source::Detections,
            motion: Motion::Standing {
                distance_m: neighbour.map(|neighbour| neighbour.distance_m),
                bearing_rad: neighbour.map(|neighbour| neighbour.bearing_rad),
                samples,
                detections,
            },
        }
    }

    /// The row of the table; `None` for a curve.
    pub fn row(&self) -> Option<String> {
        let robot = &self.robot;
        // Adding 0 makes a positive zero of a negative one.
        let tidy = |number: f64| format!("{:.5}", (number * 1e5).round() / 1e5 + 0.0);
        let optional = |number: Option<f64>| number.map(tidy).unwrap_or_default();
        match self.motion {
            Motion::Straight {
                commanded_m_s,
                distance_m,
                duration_s,
                lateral_m,
                heading_change_rad,
            } => Some(format!(
                "{robot},{commanded_m_s},{distance_m:.5},{duration_s:.3},{},{}",
                optional(lateral_m),
                optional(heading_change_rad)
            )),
            Motion::Turn { commanded_rad_s, angle_rad, duration_s } => {
                Some(format!("{robot},{commanded_rad_s},{angle_rad:.5},{duration_s:.3}"))
            }
            Motion::Standing { distance_m, bearing_rad, samples, detections } => {
                let written = |number: Option<f64>| number.map(|number| number.to_string());
                let (distance, bearing) = (written(distance_m), written(bearing_rad));
                let place =
                    format!("{},{}", distance.unwrap_or_default(), bearing.unwrap_or_default());
                Some(format!("{robot},{place},{samples},{detections}"))
            }
            Motion::Curve { .. } => None,
        }
    }

    fn header(&self) -> &'static str {
        match self.motion {
            Motion::Straight { .. } | Motion::Curve { .. } => HEADERS[0],
            Motion::Turn { .. } => HEADERS[1],
            Motion::Standing { .. } => HEADERS[2],
        }
    }

    /// Adds the row to a table.
    ///
    /// # Errors
    ///
    /// If the table cannot be read or written.
    pub fn append_to(&self, path: &Path) -> anyhow::Result<()> {
        let Some(row) = self.row() else { return Ok(()) };
        let lost = || format!("the row of this trial is not in the table: `{row}`");
        let lock = TableLock::take(path, table_file::PATIENCE).with_context(lost)?;
        let mut text =
            if path.exists() { read_text(path)? } else { format!("{}\n", self.header()) };
        if !text.ends_with('\n') {
            text.push('\n');
        }
        writeln!(text, "{row}").expect("a string takes any text");
        lock.replace(&text).with_context(lost)
    }

    /// The result for people: where it is, and the row with its header.
    pub fn text(&self) -> String {
        let bag = self.bag.display();
        match self.row() {
            Some(row) => format!("{bag}:\n{}\n{row}", self.header()),
            None => format!("{bag}: a curve\nnext: rsrs validate SWEEP --trajectories {bag}"),
        }
    }
}

/// Whether there are no poses of the robot, so that only who stood beside it can say what it did.
fn is_unseen(recorded: &Result<RecordedTrajectory, TrajectoryError>) -> bool {
    use TrajectoryError::{NoPoses, SilentPoses};
    matches!(recorded, Err(NoPoses { .. } | SilentPoses { .. }))
}

/// What the poses show, measured as [`reduced`] does.
fn motion(trial: &DrivenTrial, command: ControllerParameters) -> Motion {
    let reduced = reduced("", std::slice::from_ref(trial));
    match (reduced.speed.rows.first(), reduced.turn.rows.first()) {
        (Some(run), _) => Motion::Straight {
            commanded_m_s: run.commanded_m_s,
            distance_m: run.distance_m,
            duration_s: run.duration_s,
            lateral_m: run.lateral_m,
            heading_change_rad: run.heading_change_rad,
        },
        (None, Some(turn)) => Motion::Turn {
            commanded_rad_s: turn.commanded_rad_s,
            angle_rad: turn.angle_rad,
            duration_s: turn.duration_s,
        },
        (None, None) => Motion::Curve {
            commanded_m_s: command.speed_m_s,
            commanded_rad_s: command.turn_rate_rad_s,
        },
    }
}
