//! What a trial came to: a row of the table that `rsrs measure fit` reads.

use std::path::{Path, PathBuf};

use anyhow::bail;
use rsrs_bags::trajectory::{Needed, RecordedTrajectory, TrajectoryError};
use rsrs_core::trials::trial::{DrivenTrial, Neighbour, Trial, TrialBackend, TrialKind, reduced};
use rsrs_experiment_runner::plan::Plan;
use rsrs_fleet::experiment::Time;
use rsrs_fleet::fleet_file::Driver;
use rsrs_pipeline::error::{in_one_line, with_help};
use rsrs_pipeline::measure::bag_trials;
use rsrs_pipeline::measure::command_rhythm;
use rsrs_pipeline::measure::sensor_readings::Readings;
use rsrs_pipeline::recorded_run::{self, PosesOfRun};
use serde::Serialize;

use super::trial_table::{TrialTable, kind_of};

/// What one trial came to.
#[derive(Clone, Debug, Serialize)]
pub struct TrialResult {
    /// Where it was recorded.
    pub bag: PathBuf,
    /// The robot.
    pub robot: String,
    /// What moved the robot.
    pub backend: TrialBackend,
    /// Where the numbers come from.
    pub source: Source,
    /// What was measured.
    #[serde(flatten)]
    pub motion: Motion,
    /// The longest pause between two commands, in seconds, if it was so long that the robot may have
    /// stopped: then the trial gives no gain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paused_s: Option<f64>,
    /// Times from one detection to the next, in seconds.
    #[serde(skip)]
    pub periods_s: Vec<f64>,
}

/// Where the numbers of a trial come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The recorded poses.
    Poses,
    /// Tape and stopwatch, by who drove it.
    Operator,
    /// Its sensor's readings in the bag.
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
    StaticSensorTrial {
        /// Distance of the neighbour's centre, in metres; `None` if it was alone.
        distance_m: Option<f64>,
        /// Bearing of the neighbour's centre, in radians, left is positive; `None` if it was alone.
        bearing_rad: Option<f64>,
        /// Readings taken.
        samples: u64,
        /// Readings "detected".
        detections: u64,
    },
    /// A turn while driving.
    Curve {
        /// Commanded speed, in metres per second.
        commanded_m_s: f64,
        /// Commanded turning rate, in radians per second.
        commanded_rad_s: f64,
        /// Angle turned, in radians.
        angle_rad: f64,
        /// Time taken, in seconds.
        duration_s: f64,
    },
}

/// What moves the robot of a trial: a virtual robot of a fleet is the simulator's, too.
pub fn backend(plan: &Plan) -> TrialBackend {
    let robot = &plan.robots[0];
    if plan.is_virtual(robot) || robot.driver == Driver::Virtual {
        TrialBackend::Simulator
    } else {
        TrialBackend::Fleet
    }
}

/// Refuses, before anything moves, a table to which the result could not be added.
pub fn check_table(path: &Path, trial: &Trial, plan: &Plan) -> anyhow::Result<()> {
    TrialTable::open_for(path, kind_of(trial))?.check_mixture(backend(plan))
}

impl TrialResult {
    /// Reads the result out of the recorded poses; `None` if the bag has no poses.
    pub fn of_bag(bag: &Path, plan: &Plan) -> anyhow::Result<Option<Self>> {
        let opened = recorded_run::open(bag)?;
        let poses = PosesOfRun::new(&opened, Some(&plan.record), None)?;
        let recorded = poses.read(&opened, Some(&plan.record), Needed::AllOfIt);
        if is_unseen(&recorded) {
            return Ok(None);
        }
        let driven = bag_trials::read(bag, None).map_err(|error| unmeasured(&error))?.driven;
        let longest =
            driven.iter().max_by(|left, right| left.duration_s().total_cmp(&right.duration_s()));
        let Some(trial) = longest else {
            bail!("{}: no drive, expected 1", bag.display());
        };
        let Some(motion) = motion(trial) else {
            bail!("{}: its commands changed, expected one command", bag.display());
        };
        let mut found = Self::of_motion(plan, Source::Poses, motion);
        found.read_rhythm(plan.record.time)?;
        // Commands to stand between two drives are a pause, too.
        let stood_s = driven.windows(2).map(|pair| {
            pair[1].samples[0].time_s - pair[0].samples[pair[0].samples.len() - 1].time_s
        });
        found.paused_s = stood_s.chain(found.paused_s).reduce(f64::max);
        Ok(Some(found))
    }

    /// A result that nothing else is known of.
    pub fn of_motion(plan: &Plan, source: Source, motion: Motion) -> Self {
        let robot = plan.robots[0].name.clone();
        let (bag, backend) = (plan.bag.clone(), backend(plan));
        Self { bag, robot, backend, source, motion, paused_s: None, periods_s: Vec::new() }
    }

    /// Looks into the bag whether commands paused; in lockstep none can.
    pub fn read_rhythm(&mut self, time: Time) -> anyhow::Result<()> {
        let rhythm = command_rhythm::read(&self.bag, &self.robot)?;
        self.paused_s = rhythm.paused_s.filter(|_| time == Time::RealTime);
        self.periods_s = rhythm.periods_s;
        Ok(())
    }

    /// The result of a trial in which the robot stood.
    pub fn of_readings(plan: &Plan, neighbour: Option<Neighbour>, found: Readings) -> Self {
        let Readings { samples, detections } = found;
        let motion = Motion::StaticSensorTrial {
            distance_m: neighbour.map(|neighbour| neighbour.distance_m),
            bearing_rad: neighbour.map(|neighbour| neighbour.bearing_rad),
            samples,
            detections,
        };
        Self::of_motion(plan, Source::Detections, motion)
    }

    /// The row of the table: what was to be done, and what came of it.
    fn row(&self) -> Vec<String> {
        let written = |number: Option<f64>| number.map(|it| it.to_string()).unwrap_or_default();
        let asked = match self.motion {
            Motion::Straight { commanded_m_s, .. } => vec![commanded_m_s.to_string()],
            Motion::Turn { commanded_rad_s, .. } => vec![commanded_rad_s.to_string()],
            Motion::Curve { commanded_m_s, commanded_rad_s, .. } => {
                vec![commanded_m_s.to_string(), commanded_rad_s.to_string()]
            }
            Motion::StaticSensorTrial { distance_m, bearing_rad, .. } => {
                vec![written(distance_m), written(bearing_rad)]
            }
        };
        std::iter::once(self.robot.clone()).chain(asked).chain(self.found()).collect()
    }

    /// The fields of the row with the result of the trial.
    pub fn found(&self) -> Vec<String> {
        // Adding 0 makes a positive zero of a negative one.
        let tidy = |number: f64| format!("{:.5}", (number * 1e5).round() / 1e5 + 0.0);
        let optional = |number: Option<f64>| number.map(tidy).unwrap_or_default();
        let paused = self.paused_s.map(|paused_s| format!("{paused_s:.3}")).unwrap_or_default();
        let backend = self.backend.key().to_owned();
        match self.motion {
            Motion::Straight { distance_m, duration_s, lateral_m, heading_change_rad, .. } => vec![
                format!("{distance_m:.5}"),
                format!("{duration_s:.3}"),
                optional(lateral_m),
                optional(heading_change_rad),
                paused,
                backend,
            ],
            Motion::Turn { angle_rad, duration_s, .. }
            | Motion::Curve { angle_rad, duration_s, .. } => {
                vec![format!("{angle_rad:.5}"), format!("{duration_s:.3}"), paused, backend]
            }
            Motion::StaticSensorTrial { samples, detections, .. } => {
                vec![samples.to_string(), detections.to_string(), backend]
            }
        }
    }

    fn kind(&self) -> TrialKind {
        match self.motion {
            Motion::Straight { .. } => TrialKind::Speed,
            Motion::Curve { .. } => TrialKind::Arc,
            Motion::Turn { .. } => TrialKind::Turn,
            Motion::StaticSensorTrial { .. } => TrialKind::Detection,
        }
    }

    /// Adds the row to a table.
    pub fn append_to(&self, path: &Path) -> anyhow::Result<()> {
        TrialTable::open_for(path, self.kind())?.append(&self.row())
    }

    /// The row with its header, as a table of its own.
    pub fn table(&self) -> String {
        format!("{}\n{}", self.kind().header(), self.row().join(","))
    }
}

/// A trial that was driven and not seen well enough; what can be done about the bag of an experiment
/// does not help.
fn unmeasured(error: &anyhow::Error) -> anyhow::Error {
    with_help(
        in_one_line(error),
        "the trial was driven, and nothing was filled in: the same command makes it again; find out \
         why poses stayed away, a busy computer or a tracker that lost the robot",
    )
}

/// Whether there are no poses of the robot, so that only the operator can report what it did.
fn is_unseen(recorded: &Result<RecordedTrajectory, TrajectoryError>) -> bool {
    use TrajectoryError::{NoPoses, SilentPoses};
    matches!(recorded, Err(NoPoses { .. } | SilentPoses { .. }))
}

/// What the poses show, measured as [`reduced`] does; `None` if the command changed.
fn motion(trial: &DrivenTrial) -> Option<Motion> {
    let reduced = reduced("", std::slice::from_ref(trial));
    let straight = reduced.speed.rows.first().map(|run| Motion::Straight {
        commanded_m_s: run.commanded_m_s,
        distance_m: run.distance_m,
        duration_s: run.duration_s,
        lateral_m: run.lateral_m,
        heading_change_rad: run.heading_change_rad,
    });
    let turn = reduced.turn.rows.first().map(|turn| Motion::Turn {
        commanded_rad_s: turn.commanded_rad_s,
        angle_rad: turn.angle_rad,
        duration_s: turn.duration_s,
    });
    let arc = reduced.arc.rows.first().map(|arc| Motion::Curve {
        commanded_m_s: arc.commanded_m_s,
        commanded_rad_s: arc.turn.commanded_rad_s,
        angle_rad: arc.turn.angle_rad,
        duration_s: arc.turn.duration_s,
    });
    straight.or(turn).or(arc)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rsrs_pipeline::error::help_of;

    #[test]
    fn a_trial_that_was_not_seen_is_to_be_made_again() {
        let unread = with_help("bag: 26 % of the poses are missing", "judge the run by eye");

        let error = unmeasured(&unread);

        assert_eq!(error.to_string(), "bag: 26 % of the poses are missing");
        let help = help_of(&error).unwrap();
        assert!(help.contains("the same command makes it again"), "{help}");
        assert!(!help.contains("judge"), "{help}");
    }
}
