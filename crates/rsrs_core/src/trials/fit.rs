//! Step 1 of the method: from trials to a measured robot, with how sure every number is.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::help::Help;
use crate::statistics::variance::{Estimate, MeanSquare, mean, sd, squared_deviations};
use crate::trials::trial::{
    ArcTrial, DetectionTrial, DrivenTrial, MovedBy, PeriodTrial, SpeedTrial, Trials, TurnTrial,
};

pub use caution::Caution;
pub use contour::{BearingReach, RELIABLE};
pub use detection_rate::{Rate, SensorPoint};
pub use drift::{Drift, DriftSource};
pub use inscribed::inscribed;
pub use likelihood::Likelihood;
pub use motion::{CommandGain, Outlier, Population};
pub use profile::Unmeasured;
pub use report::{SensorFit, SpeedFit, TurnFit};
pub use sensor::{SensorMap, sensor_map};
pub use steps::{StepNoise, step_noise};
pub use yaw_lag::{YawLag, yaw_lag};

mod caution;
mod contour;
mod detection_rate;
mod drift;
mod held_out;
mod inscribed;
mod likelihood;
mod motion;
mod profile;
mod report;
mod sensor;
mod steps;
mod yaw_lag;

use motion::Observation;

pub(crate) use inscribed::contains as polygon_contains;

/// The tables of step 1.
#[derive(Clone, Copy, Debug)]
pub struct Tables<'a> {
    /// Straight runs.
    pub speed: &'a Trials<SpeedTrial>,
    /// Turns in place.
    pub turn: &'a Trials<TurnTrial>,
    /// Turns while driving, if they were measured.
    pub arc: Option<&'a Trials<ArcTrial>>,
    /// Detections.
    pub detection: &'a Trials<DetectionTrial>,
    /// Control periods, if they were measured.
    pub period: Option<&'a Trials<PeriodTrial>>,
    /// Trajectories, if there are any: they show single steps. Straight runs and turns in them count
    /// only if they are also in `speed` and `turn`; [`crate::trials::trial::reduced`] makes those tables.
    pub driven: &'a [DrivenTrial],
    /// Trajectories whose robot stood when they began, if there are any: they show how its turning
    /// rate follows a command that has changed.
    pub from_rest: &'a [DrivenTrial],
    /// What moved the robots of all of these.
    pub moved_by: MovedBy,
}

/// A kind of robot as it was measured.
///
/// It serialises to the report of `rsrs measure fit --format json`; `details` are for pictures,
/// texts and the profile, and serialise on their own.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// Every robot at every commanded speed, by robot and then by command.
    pub speed: Vec<SpeedFit>,
    /// Every robot at every commanded turning rate, by robot and then by command.
    pub turn: Vec<TurnFit>,
    /// The sensor.
    pub sensor: SensorFit,
    /// Control period, in seconds; `None` if it was not measured.
    pub period_s: Option<f64>,
    /// What the report leaves out.
    #[serde(skip)]
    pub details: Details,
}

/// What the report leaves out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Details {
    /// Names of the tables.
    pub files: Files,
    /// What moved the robots of the trials.
    pub moved_by: MovedBy,
    /// How robots follow commanded speeds.
    pub speed: Population,
    /// How robots follow commanded turning rates in place.
    pub turn: Population,
    /// How robots follow commanded turning rates while they drive, if that was measured.
    pub arc: Option<Population>,
    /// With which time constant the turning rate follows its command, if trajectories show it.
    pub yaw_lag: Option<YawLag>,
    /// Bias, heading noise and gusts, if straight runs give their end points.
    pub drift: Option<Drift>,
    /// Noise from step to step, if trajectories show it.
    pub steps: Option<StepNoise>,
    /// The sensor, place by place, with its measured polygon.
    pub sensor: SensorMap,
    /// The control period, if it was measured.
    pub period: Option<PeriodFit>,
    /// What makes some numbers less sure than they look.
    pub cautions: Vec<Caution>,
}

/// Names of the tables that were fitted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Files {
    /// Straight runs.
    pub speed: String,
    /// Turns in place.
    pub turn: String,
    /// Turns while driving.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arc: Option<String>,
    /// Detections.
    pub detection: String,
    /// Control periods.
    pub period: Option<String>,
}

/// Why trials do not make a measured robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// A table without trials of its kind, as trajectories can leave it.
    #[error("{file}: no {kind}, expected 1 or more")]
    NoTrials {
        /// The table.
        file: String,
        /// What is missing.
        kind: &'static str,
    },
    /// Nothing was measured without a neighbour.
    #[error(
        "{file}: no row has an empty distance_m, expected readings without a neighbour (false positives)"
    )]
    NoFalsePositives {
        /// The table.
        file: String,
    },
    /// No region in which detections are reliable.
    #[error(
        "{file}: no region with detections in 80 % of the readings: {n_places} places, the best with {:.0} %; expected some at two or more bearings",
        best * 100.0
    )]
    NoRegion {
        /// The table.
        file: String,
        /// Places that were tried.
        n_places: usize,
        /// Largest share of detections found.
        best: f64,
    },
}

impl Help for FitError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::NoTrials { .. } => "`rsrs measure plan` lists the trials worth running",
            Self::NoFalsePositives { .. } => {
                "add rows like `robot_1,,,2000,130`: readings with no \
                                              other robot near, with both places left empty"
            }
            Self::NoRegion { .. } => {
                "`rsrs measure plan` proposes distances and bearings; try \
                                      closer ones, on both sides of the sensor's axis"
            }
        };
        Some(help.to_owned())
    }
}

/// Fits a measured robot to trials. What these cannot measure is taken from `unmeasured`: the
/// body's size, and times if they were not measured.
///
/// There have to be a straight run and a turn; detections need false positives and a reliable
/// region.
///
/// # Source
///
/// §IV step 1; `eq:theta^a1`, `eq:theta^a2`, `fig:sim_sensing`.
pub fn fit(tables: Tables, unmeasured: &Unmeasured) -> Result<Fit, FitError> {
    for (file, kind, n_trials) in [
        (&tables.speed.file, "straight runs", tables.speed.rows.len()),
        (&tables.turn.file, "turns in place", tables.turn.rows.len()),
    ] {
        if n_trials == 0 {
            return Err(FitError::NoTrials { file: file.clone(), kind });
        }
    }
    let speed = speed_observations(tables.speed);
    let turn = turn_observations(tables.turn);
    let sensor = sensor_map(tables.detection, unmeasured.radius_m)?;
    let period = tables.period.map(period_fit);
    let period_s = period.map_or(unmeasured.period_s, |period| period.period_s.value);
    let gust_time_constant_s = unmeasured.gust_time_constant_s;
    let mut details = Details {
        files: Files {
            speed: tables.speed.file.clone(),
            turn: tables.turn.file.clone(),
            arc: tables.arc.map(|arc| arc.file.clone()),
            detection: tables.detection.file.clone(),
            period: tables.period.map(|period| period.file.clone()),
        },
        moved_by: tables.moved_by,
        speed: motion::population(&speed),
        turn: motion::population(&turn),
        arc: tables.arc.map(|arc| motion::population(&arc_observations(arc))),
        yaw_lag: yaw_lag(tables.from_rest, period_s),
        drift: drift::drift(tables.speed, drift::Times { period_s, gust_time_constant_s }),
        steps: step_noise(tables.driven, period_s),
        sensor,
        period,
        cautions: Vec::new(),
    };
    let speed = motion::robot_gains(&speed, &tables.speed.robots);
    let turn = motion::robot_gains(&turn, &tables.turn.robots);
    details.cautions = caution::cautions(tables, &details, &speed, &turn);
    Ok(Fit {
        speed: speed.iter().map(|gain| report::speed_fit(gain, &tables.speed.robots)).collect(),
        turn: turn.iter().map(|gain| report::turn_fit(gain, &tables.turn.robots)).collect(),
        sensor: SensorFit::new(&details.sensor),
        period_s: period.map(|period| period.period_s.value),
        details,
    })
}

fn speed_observations(trials: &Trials<SpeedTrial>) -> Vec<Observation> {
    let observation = |trial: &SpeedTrial| Observation {
        robot: trial.robot,
        line: trial.line,
        command: trial.commanded_m_s,
        gain: trial.distance_m / trial.duration_s / trial.commanded_m_s,
    };
    trials.rows.iter().map(observation).collect()
}

fn turn_observations(trials: &Trials<TurnTrial>) -> Vec<Observation> {
    trials.rows.iter().map(turn_observation).collect()
}

fn arc_observations(trials: &Trials<ArcTrial>) -> Vec<Observation> {
    trials.rows.iter().map(|trial| turn_observation(&trial.turn)).collect()
}

fn turn_observation(trial: &TurnTrial) -> Observation {
    Observation {
        robot: trial.robot,
        line: trial.line,
        command: trial.commanded_rad_s,
        gain: trial.angle_rad / trial.duration_s / trial.commanded_rad_s,
    }
}

/// The control period of a kind of robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PeriodFit {
    /// Mean over robots, in seconds, with Student's interval over robots; for one robot, or for one
    /// reading of each, over the readings.
    pub period_s: Estimate,
    /// Standard deviation of one robot's period from reading to reading, in seconds; `None` if no
    /// robot was read twice.
    pub jitter_s: Option<Estimate>,
    /// Longest reading, in seconds.
    pub longest_s: f64,
}

/// Mean period and jitter.
///
/// # Panics
///
/// If there is no reading: a parsed table has one.
fn period_fit(trials: &Trials<PeriodTrial>) -> PeriodFit {
    let mut robots: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for trial in &trials.rows {
        robots.entry(trial.robot).or_default().push(trial.period_s);
    }
    let all: Vec<f64> = trials.rows.iter().map(|trial| trial.period_s).collect();
    let means: Vec<f64> = robots.values().map(|periods_s| mean(periods_s)).collect();
    let df = (all.len() - robots.len()) as f64;
    let squares: f64 = robots.values().map(|periods_s| squared_deviations(periods_s)).sum();
    let jitter = MeanSquare { weight: 1.0, value: squares / df, df };
    PeriodFit {
        period_s: Estimate::of_mean(if sd(&means).is_some() { &means } else { &all }),
        jitter_s: (df > 0.0).then(|| Estimate::of_variance(&[jitter]).sd(1.0)),
        longest_s: all.iter().copied().fold(0.0, f64::max),
    }
}
