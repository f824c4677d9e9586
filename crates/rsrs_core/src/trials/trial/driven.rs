//! Trajectories of single robots under known commands, and of what they push, from a tracker or a bag.

use std::collections::BTreeMap;

use super::error::{TrialError, TrialProblem};
use super::table::Table;
use crate::quantity::{MAX_SPEED_M_S, MAX_TURN_RATE_RAD_S};
use crate::robot::controller::Command;
use crate::robot::unicycle::Pose;

/// A tracker sees an object that nobody pushes move no further than this, in metres.
const STAYED_M: f64 = 0.02;

/// Whether an object that was seen at these places, in metres, did not stay at the first of them.
pub fn has_moved(mut places_m: impl Iterator<Item = [f64; 2]>) -> bool {
    let Some([x_m, y_m]) = places_m.next() else { return false };
    places_m.any(|place_m| libm::hypot(place_m[0] - x_m, place_m[1] - y_m) > STAYED_M)
}

/// One robot's pose and the command it had at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenSample {
    /// Time, in seconds.
    pub time_s: f64,
    /// The pose; the heading is continuous, not wrapped.
    pub pose: Pose,
    /// The command that was sent then, and held until the next sample.
    pub command: Command,
    /// Where the object is that the robot is to push, in metres; of all samples of a trial or of none.
    pub object_m: Option<[f64; 2]>,
}

/// One robot driven once.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenTrial {
    /// The robot.
    pub robot: String,
    /// The trial's name, unique for the robot.
    pub trial: String,
    /// For how long it had been driven with its first command before the first sample, in seconds; 0
    /// from a standstill.
    pub going_s: f64,
    /// Samples, ascending in time; 2 or more.
    pub samples: Vec<DrivenSample>,
}

impl DrivenTrial {
    /// Time from the first sample to the last, in seconds.
    pub fn duration_s(&self) -> f64 {
        self.samples[self.samples.len() - 1].time_s - self.samples[0].time_s
    }

    /// The pose at a time after the start, in the frame in which the robot started at the origin,
    /// heading along x; linear between samples, the last held beyond.
    pub fn displacement_at(&self, after_s: f64) -> Pose {
        let start = self.samples[0];
        let time_s = start.time_s + after_s;
        let above = self.samples.partition_point(|sample| sample.time_s <= time_s);
        let low = self.samples[above.max(1) - 1];
        let high = self.samples[above.min(self.samples.len() - 1)];
        let span_s = high.time_s - low.time_s;
        let share = if span_s > 0.0 { (time_s - low.time_s) / span_s } else { 0.0 };
        low.pose.mixed(high.pose, share).relative_to(start.pose)
    }

    /// Where the object was at the start, in the frame of the robot's start, in metres: ahead, left; `None` if there
    /// was none.
    pub fn object_start_m(&self) -> Option<[f64; 2]> {
        let start = self.samples[0];
        let [x_m, y_m] = start.object_m?;
        let object = Pose { x_m, y_m, heading_rad: 0.0 }.relative_to(start.pose);
        Some([object.x_m, object.y_m])
    }

    /// The trial of the object in the place of the robot, heading all the time as the robot did at the start; `None` if
    /// there was none.
    pub fn of_object(&self) -> Option<Self> {
        let heading_rad = self.samples[0].pose.heading_rad;
        let of_object = |sample: &DrivenSample| {
            let [x_m, y_m] = sample.object_m?;
            Some(DrivenSample { pose: Pose { x_m, y_m, heading_rad }, ..*sample })
        };
        let samples: Option<Vec<DrivenSample>> = self.samples.iter().map(of_object).collect();
        Some(Self { samples: samples?, ..self.clone() })
    }

    /// Whether there is an object that did not stay where it was.
    pub fn moves_object(&self) -> bool {
        has_moved(self.samples.iter().filter_map(|sample| sample.object_m))
    }

    /// The command, if it was the same all the time. The last sample's is never driven, and trackers
    /// often write a stop there.
    pub fn constant_command(&self) -> Option<Command> {
        let first = self.samples[0].command;
        let driven = &self.samples[..self.samples.len() - 1];
        driven.iter().all(|sample| sample.command == first).then_some(first)
    }

    /// The command that held at a time after the start.
    pub fn command_at(&self, after_s: f64) -> Command {
        let time_s = self.samples[0].time_s + after_s;
        // A step that falls on a sample takes that sample's command, whatever the rounding.
        let above = self.samples.partition_point(|sample| sample.time_s <= time_s + 1e-9);
        self.samples[above.max(1) - 1].command
    }
}

/// Reads trajectories, in the order of robots and then of trials:
/// `robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s[,object_x_m,object_y_m]`.
///
/// Rows may stand in any order; each trial is sorted by time and its heading made continuous. One that is driven
/// begins with its first command: a recording often begins before the robot does. The last two columns are where the
/// object is that the robot is to push; they are empty in all rows of a trial without one.
pub fn driven_trials(file: &str, text: &str) -> Result<Vec<DrivenTrial>, TrialError> {
    let required = [
        "robot",
        "trial",
        "time_s",
        "x_m",
        "y_m",
        "heading_rad",
        "commanded_m_s",
        "commanded_rad_s",
    ];
    let mut table = Table::open(file, text, &required, &OBJECT)?;
    let mut trials: BTreeMap<(String, String), Vec<(u64, DrivenSample)>> = BTreeMap::new();
    while let Some(row) = table.next_row()? {
        let pose = Pose { x_m: row.number(3)?, y_m: row.number(4)?, heading_rad: row.number(5)? };
        row.below(3, pose.x_m, MAX_PLACE_M, "mm")?;
        row.below(4, pose.y_m, MAX_PLACE_M, "mm")?;
        let command = Command { speed_m_s: row.number(6)?, turn_rate_rad_s: row.number(7)? };
        row.below(6, command.speed_m_s, MAX_SPEED_M_S, "mm/s")?;
        row.below(7, command.turn_rate_rad_s, MAX_TURN_RATE_RAD_S, "degrees per second")?;
        let object_m = match [row.optional(8)?, row.optional(9)?] {
            [None, None] => None,
            [Some(x_m), Some(y_m)] => Some([x_m, y_m]),
            [x_m, _] => {
                let column = OBJECT[usize::from(x_m.is_some())];
                return Err(row.refuse(TrialProblem::HalfPlace { column }));
            }
        };
        for (column, place_m) in (8..).zip(object_m.into_iter().flatten()) {
            row.below(column, place_m, MAX_PLACE_M, "mm")?;
        }
        let sample = DrivenSample { time_s: row.number(2)?, pose, command, object_m };
        let key = (row.name(0)?.to_owned(), row.name(1)?.to_owned());
        let line = row.line;
        let samples = trials.entry(key).or_default();
        // A first heading is at most once around; later ones may count turns.
        if samples.is_empty() {
            row.below(5, pose.heading_rad, 6.3, "degrees")?;
        }
        samples.push((line, sample));
    }
    if trials.is_empty() {
        return Err(table.refuse(TrialProblem::NoRows));
    }
    let in_order = |((robot, trial), samples)| in_order(file, robot, trial, samples);
    trials.into_iter().map(in_order).collect()
}

/// The columns of the place of an object.
const OBJECT: [&str; 2] = ["object_x_m", "object_y_m"];

/// No arena is larger.
const MAX_PLACE_M: f64 = 500.0;

fn in_order(
    file: &str,
    robot: String,
    trial: String,
    mut samples: Vec<(u64, DrivenSample)>,
) -> Result<DrivenTrial, TrialError> {
    samples.sort_by(|left, right| left.1.time_s.total_cmp(&right.1.time_s));
    let refuse = |line, problem| Err(TrialError { file: file.to_owned(), line, problem });
    if let Some(pair) = samples.windows(2).find(|pair| pair[0].1.time_s >= pair[1].1.time_s) {
        let time_s = pair[1].1.time_s;
        return refuse(pair[1].0, TrialProblem::TimeTwice { robot, trial, time_s });
    }
    if samples.len() < 2 {
        return refuse(samples[0].0, TrialProblem::OneSample { robot, trial });
    }
    let has_object = |(_, sample): &&(u64, DrivenSample)| sample.object_m.is_some();
    let first = samples[0].1.object_m.is_some();
    if let Some((line, _)) = samples.iter().find(|sample| has_object(sample) != first) {
        return refuse(*line, TrialProblem::ObjectAtTimes { robot, trial });
    }
    let mut samples: Vec<DrivenSample> = samples.into_iter().map(|(_, sample)| sample).collect();
    for index in 1..samples.len() {
        let before = samples[index - 1].pose.heading_rad;
        let heading = &mut samples[index].pose.heading_rad;
        // The nearest heading that looks the same.
        *heading -= ((*heading - before) / std::f64::consts::TAU).round() * std::f64::consts::TAU;
    }
    let begins = samples.iter().position(|sample| sample.command != Command::STOP);
    // A command of the last sample is never driven.
    samples.drain(..begins.filter(|first| first + 1 < samples.len()).unwrap_or(0));
    Ok(DrivenTrial { robot, trial, going_s: 0.0, samples })
}
