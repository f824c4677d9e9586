//! Trajectories as trials: what a stopwatch and a tape would have measured.

use super::{ArcTrial, DrivenTrial, MovedBy, Names, SpeedTrial, Trials, TurnTrial};

/// Trials that trajectories contain.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduced {
    /// Straight runs; may be none.
    pub speed: Trials<SpeedTrial>,
    /// Turns in place; may be none.
    pub turn: Trials<TurnTrial>,
    /// Turns while driving forward; may be none.
    pub arc: Trials<ArcTrial>,
    /// Robots and trials that are none of these: their command changed, or they drove backwards.
    pub left_out: Vec<(String, String)>,
}

/// Turns trajectories into straight runs, turns in place and turns while driving; reports call them `file`. Of none is it
/// stated what moved the robot: trajectories do not contain that.
///
/// A trial under a constant forward command is a straight run: its distance is measured along the
/// heading at its start, its lateral distance beside that. A trial under a constant turning rate
/// without forward speed is a turn in place, and one with it a turn while driving. A trial's `line` is its position, from 1.
pub fn reduced(file: &str, trials: &[DrivenTrial]) -> Reduced {
    let [mut speed_names, mut turn_names, mut arc_names] = [const { Names::EMPTY }; 3];
    let (mut speed, mut turn, mut arc) = (Vec::new(), Vec::new(), Vec::new());
    let mut left_out = Vec::new();
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
            Some(command) if command.speed_m_s >= 0.0 && command.turn_rate_rad_s != 0.0 => {
                let turned = |robot| TurnTrial {
                    robot,
                    line,
                    commanded_rad_s: command.turn_rate_rad_s,
                    angle_rad: end.heading_rad,
                    duration_s,
                };
                if command.speed_m_s == 0.0 {
                    turn.push(turned(turn_names.position(&trial.robot)));
                } else {
                    let robot = arc_names.position(&trial.robot);
                    let commanded_m_s = command.speed_m_s;
                    arc.push(ArcTrial { robot, line, commanded_m_s, turn: turned(robot) });
                }
            }
            _ => left_out.push((trial.robot.clone(), trial.trial.clone())),
        }
    }
    Reduced {
        speed: all(file, speed_names, speed),
        turn: all(file, turn_names, turn),
        arc: all(file, arc_names, arc),
        left_out,
    }
}

fn all<T>(file: &str, names: Names, rows: Vec<T>) -> Trials<T> {
    let moved_by = MovedBy::all(None, rows.len());
    Trials { file: file.to_owned(), robots: names.names, rows, paused: Vec::new(), moved_by }
}
