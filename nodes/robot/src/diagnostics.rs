//! The robot's health, for ROS's monitors.

use rsrs_fleet::message::RobotState;
use rsrs_fleet::robot::StandReason;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use rsrs_msgs::std_msgs::Header;

/// What the health of a robot is made of.
pub struct Health<'a> {
    /// Its name.
    pub robot: &'a str,
    /// Which driver it has.
    pub driver: &'static str,
    /// What is wrong with sensor or wheels.
    pub fault: Option<&'a str>,
    /// What the driver reports.
    pub values: Vec<(&'static str, String)>,
    /// Why the robot stands, if it does.
    pub standing: Option<StandReason>,
    /// What it does.
    pub state: RobotState,
    /// Velocity commands that were refused so far.
    pub refused: u64,
}

/// Puts a robot's health into a message: one entry for the hardware, one for the gate.
pub fn message(health: Health<'_>, stamp: Time) -> DiagnosticArray {
    let value = |(key, value): (&str, String)| KeyValue { key: key.to_owned(), value };
    let hardware = DiagnosticStatus {
        level: if health.fault.is_some() { DiagnosticStatus::ERROR } else { DiagnosticStatus::OK },
        name: format!("{}: {} driver", health.robot, health.driver),
        message: health.fault.unwrap_or("sensor and wheels work").to_owned(),
        hardware_id: health.robot.to_owned(),
        values: health.values.into_iter().map(value).collect(),
    };
    let level = match health.state {
        RobotState::Fault => DiagnosticStatus::ERROR,
        RobotState::Stopped => DiagnosticStatus::WARN,
        RobotState::Idle | RobotState::Armed | RobotState::Moving => DiagnosticStatus::OK,
    };
    let gate = DiagnosticStatus {
        level,
        name: format!("{}: gate", health.robot),
        message: health.standing.map_or_else(|| "may move".to_owned(), |reason| reason.to_string()),
        hardware_id: health.robot.to_owned(),
        values: vec![
            value(("state", health.state.to_string())),
            value(("commands_refused", health.refused.to_string())),
        ],
    };
    let header = Header { stamp, frame_id: String::new() };
    DiagnosticArray { header, status: vec![hardware, gate] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_driver_is_an_error_of_hardware_and_gate() {
        let health = Health {
            robot: "robot_1",
            driver: "serial",
            fault: Some("microcontroller restarted"),
            values: vec![("lines_garbled", "3".to_owned())],
            standing: Some(StandReason::Fault("microcontroller restarted".to_owned())),
            state: RobotState::Fault,
            refused: 0,
        };

        let status = message(health, Time::default()).status;

        assert_eq!(status[0].name, "robot_1: serial driver");
        assert_eq!(status[0].values[0].key, "lines_garbled");
        assert_eq!(status[1].message, "hardware fault: microcontroller restarted");
        assert!(status.iter().all(|entry| entry.level == DiagnosticStatus::ERROR));
    }
}
