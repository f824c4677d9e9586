//! What makes some numbers of a fit less sure than they look.

use serde::Serialize;

use super::motion::{Population, RobotGain};
use super::sensor::SensorMap;
use super::{Details, Tables};

/// What makes a number less sure than it looks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, thiserror::Error)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Caution {
    /// One robot gives no spread between robots.
    #[error("{file}: one robot only, so nothing is known of how robots differ")]
    OneRobot {
        /// The table.
        file: String,
    },
    /// No repetitions anywhere.
    #[error(
        "{file}: no robot repeated a command, so differences between robots include those between trials"
    )]
    NoRepetitions {
        /// The table.
        file: String,
    },
    /// A trial that was not repeated has no interval.
    #[error("{file}: {robot} has one trial at {command}, so its gain has no interval")]
    OneTrial {
        /// The table.
        file: String,
        /// The robot.
        robot: String,
        /// The command with its unit.
        command: String,
    },
    /// The gain at other commands is a guess.
    #[error("{file}: one command only ({command}); its gain is held at all others")]
    OneCommand {
        /// The table.
        file: String,
        /// The command with its unit.
        command: String,
    },
    /// Some robots miss some commands.
    #[error(
        "{file}: not every robot has every command; the interval of the spread between robots is wider for it"
    )]
    Incomplete {
        /// The table.
        file: String,
    },
    /// A trial that is not like the others.
    #[error(
        "{file}:{line}: {robot} has a gain of {gain} at {command}, its mean is {mean_gain}; the trial counts, look at it"
    )]
    Outlier {
        /// The table.
        file: String,
        /// The line.
        line: u64,
        /// The robot.
        robot: String,
        /// The command with its unit.
        command: String,
        /// The gain, three decimals.
        gain: String,
        /// The mean gain of the robot at the command, three decimals.
        mean_gain: String,
    },
    /// A sensor that also works elsewhere.
    #[error(
        "{file}: detections are also reliable at a bearing of {bearing_rad} rad, apart from the polygon, which leaves them out"
    )]
    LeftOut {
        /// The table.
        file: String,
        /// The bearing, in radians, two decimals.
        bearing_rad: String,
    },
    /// A sensor that may work beyond the bearings that were tried.
    #[error(
        "{file}: detections are reliable at the outermost bearing tried, {bearing_rad} rad, where the \
         polygon ends; the sensor may see beyond it: try wider bearings"
    )]
    Outermost {
        /// The table.
        file: String,
        /// The bearing, in radians, two decimals.
        bearing_rad: String,
    },
    /// A sensor that may work beyond the distances that were tried.
    #[error(
        "{file}: detections are reliable at the farthest distance tried, {distance_m} m, where the \
         polygon ends; the sensor may reach beyond it: try longer distances"
    )]
    Farthest {
        /// The table.
        file: String,
        /// The distance, in metres, three decimals.
        distance_m: String,
    },
}

/// One kind of command, for its cautions.
struct Kind<'a> {
    file: &'a str,
    names: &'a [String],
    unit: &'static str,
    population: &'a Population,
    gains: &'a [RobotGain],
}

/// Where the polygon ends because nothing was tried beyond.
fn beyond(file: &str, sensor: &SensorMap) -> Vec<Caution> {
    let file = || file.to_owned();
    let outermost = sensor.outermost_rad.iter().map(|bearing_rad| Caution::Outermost {
        file: file(),
        bearing_rad: format!("{bearing_rad:.2}"),
    });
    let open = sensor.reach.iter().filter(|reach| reach.high_m.is_none());
    let farthest = open.map(|reach| reach.low_m).reduce(f64::max);
    let farthest = farthest.map(|distance_m| Caution::Farthest {
        file: file(),
        distance_m: format!("{distance_m:.3}"),
    });
    outermost.chain(farthest).collect()
}

/// All cautions, speeds first.
pub(super) fn cautions(
    tables: Tables,
    details: &Details,
    speed: &[RobotGain],
    turn: &[RobotGain],
) -> Vec<Caution> {
    let mut cautions = Kind {
        file: &tables.speed.file,
        names: &tables.speed.robots,
        unit: "m/s",
        population: &details.speed,
        gains: speed,
    }
    .cautions();
    let turn = Kind {
        file: &tables.turn.file,
        names: &tables.turn.robots,
        unit: "rad/s",
        population: &details.turn,
        gains: turn,
    };
    cautions.extend(turn.cautions());
    cautions.extend(details.sensor.left_out_rad.iter().map(|bearing_rad| Caution::LeftOut {
        file: tables.detection.file.clone(),
        bearing_rad: format!("{bearing_rad:.2}"),
    }));
    cautions.extend(beyond(&tables.detection.file, &details.sensor));
    cautions
}

impl Kind<'_> {
    fn cautions(&self) -> Vec<Caution> {
        let file = || self.file.to_owned();
        let command = |command: f64| format!("{command} {}", self.unit);
        let mut cautions = Vec::new();
        if self.population.n_robots == 1 {
            cautions.push(Caution::OneRobot { file: file() });
        }
        if let [only] = self.population.by_command.as_slice() {
            let command = command(only.command);
            cautions.push(Caution::OneCommand { file: file(), command });
        }
        if !self.population.is_complete {
            cautions.push(Caution::Incomplete { file: file() });
        }
        if self.population.trial_sd.is_none() {
            cautions.push(Caution::NoRepetitions { file: file() });
        } else {
            let lone = self.gains.iter().filter(|gain| gain.gains.len() == 1);
            cautions.extend(lone.map(|gain| Caution::OneTrial {
                file: file(),
                robot: self.names[gain.robot].clone(),
                command: command(gain.command),
            }));
        }
        cautions.extend(self.population.outliers.iter().map(|outlier| Caution::Outlier {
            file: file(),
            line: outlier.line,
            robot: self.names[outlier.robot].clone(),
            command: command(outlier.command),
            gain: format!("{:.3}", outlier.gain),
            mean_gain: format!("{:.3}", outlier.mean_gain),
        }));
        cautions
    }
}
