//! Trajectories as trials: what a stopwatch and a tape would have said.

use super::{DrivenTrial, Names, SpeedTrial, Trials, TurnTrial};

/// Trials that trajectories contain.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduced {
    /// Straight runs; may be none.
    pub speed: Trials<SpeedTrial>,
    /// Turns in place; may be none.
    pub turn: Trials<TurnTrial>,
    /// Robots and trials that are neither: their command changed, or they drove curves.
    pub left_out: Vec<(String, String)>,
}

/// Turns trajectories into straight runs and turns in place.
///
/// A trial under a constant forward command is a straight run: its distance is measured along the
/// heading at its start, its lateral distance beside that. A trial under a constant turning rate
/// without forward speed is a turn in place. A trial's `line` is its position, from 1.
///
/// # Arguments
///
/// * `file` — where the trajectories are from, for reports.
pub fn reduced(file: &str, trials: &[DrivenTrial]) -> Reduced {
    let (mut speed_names, mut turn_names) = (Names::default(), Names::default());
    let (mut speed, mut turn, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    for (trial, line) in trials.iter().zip(1..) {
        let duration_s = trial.duration_s();
        let end = trial.displacement_at(duration_s);
        match trial.constant_command() {
            Some(command) if command.speed_m_s > 0.0 && command.turn_rate_rad_s == 0.0 => {
                speed.push(SpeedTrial {
                    robot: speed_names.position(&trial.robot),
                    line,
                    commanded_m_s: command.speed_m_s,
                    distance_m: end.x_m.max(0.0),
                    duration_s,
                    lateral_m: Some(end.y_m),
                    heading_change_rad: Some(end.heading_rad),
                });
            }
            Some(command) if command.speed_m_s == 0.0 && command.turn_rate_rad_s != 0.0 => {
                turn.push(TurnTrial {
                    robot: turn_names.position(&trial.robot),
                    line,
                    commanded_rad_s: command.turn_rate_rad_s,
                    angle_rad: end.heading_rad,
                    duration_s,
                });
            }
            _ => left_out.push((trial.robot.clone(), trial.trial.clone())),
        }
    }
    let file = || file.to_owned();
    Reduced {
        speed: Trials { file: file(), robots: speed_names.names, rows: speed },
        turn: Trials { file: file(), robots: turn_names.names, rows: turn },
        left_out,
    }
}
