//! The parameters of a robot: ROS names, with unit and range in their descriptors.

use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_core::robot::wheels::Wheels;
use rsrs_fleet::fleet_file::CmdVel;
use rsrs_fleet::parameters::Number;
use rsrs_fleet::parameters::gate::{
    ACCELERATION_MAX, CMD_VEL_TYPE, DEBOUNCE, DETECTION_THRESHOLD, DRIVER, NODE, NUMBERS,
    PROFILE_DIGEST, SENSOR_TIMEOUT, SPEED_MAX, TURN_ACCELERATION_MAX, TURN_RATE_MAX, WHEEL_BASE,
    WHEEL_SPEED_MAX,
};
use rsrs_fleet::robot::detector::DetectorSettings;
use rsrs_fleet::robot::limits::Limits;
use rsrs_ros::parameters::{
    Descriptor, NodeParameters, ParameterKind, ParameterServer, ParameterValue,
};

use crate::declared::{choice, cmd_vel, number};
use crate::driver::DriverKind;

/// The sensor's timeout of a virtual robot, in seconds.
///
/// Its readings come one by one over the network, which may lose several in a row: at 5 % and 0.13 s,
/// half a second is over in every second run of 100 s of nine robots.
const VIRTUAL_TIMEOUT_S: f64 = 1.0;

/// All parameters of a robot with this driver, with the values that they have where none is given.
fn declared(driver: DriverKind) -> Vec<(Descriptor, ParameterValue)> {
    let debounce = "So many readings in a row must agree before the detection changes.";
    let debounce = Descriptor::new(DEBOUNCE, ParameterKind::Integer, debounce).within(1.0, 100.0);
    let usual = |it: Number| match (it.name, driver) {
        (SENSOR_TIMEOUT, DriverKind::Virtual) => Number { usual: VIRTUAL_TIMEOUT_S, ..it },
        _ => it,
    };
    let mut parameters: Vec<_> = NUMBERS.into_iter().map(|it| number(usual(it))).collect();
    parameters.extend([
        (debounce, ParameterValue::Integer(1)),
        cmd_vel(CMD_VEL_TYPE, "Type of cmd_vel.", CmdVel::default()),
        choice(DRIVER, "What moves the robot.", &DriverKind::words(), driver.name()),
        choice(
            PROFILE_DIGEST,
            "Digest of the profile that the fleet file names.",
            "16 hexadecimal digits; empty without a profile",
            "",
        ),
    ]);
    parameters.extend(driver.parameters());
    parameters
}

/// The names of all parameters that may be given; the driver is not given in this way.
pub fn names(driver: DriverKind) -> Vec<String> {
    let mut names: Vec<String> =
        declared(driver).into_iter().map(|(descriptor, _)| descriptor.name).collect();
    names.retain(|name| name != DRIVER);
    names
}

/// Declares a robot's parameters, with start values by name, all of which are known. Whoever serves
/// them checks type and range.
pub fn declare(
    robot: &str,
    driver: DriverKind,
    given: &BTreeMap<String, ParameterValue>,
) -> NodeParameters {
    let mut parameters = declared(driver);
    for (descriptor, value) in &mut parameters {
        if let Some(start) = given.get(&descriptor.name) {
            value.clone_from(start);
        }
    }
    NodeParameters { namespace: format!("/{robot}"), name: NODE.to_owned(), parameters }
}

/// What a robot is set to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What its wheels may be asked to do.
    pub limits: Limits,
    /// How readings become detections.
    pub detector: DetectorSettings,
}

/// The wheels of a robot, if they have a limit of their own.
fn wheels(base_m: f64, speed_max_m_s: f64) -> Option<Wheels> {
    (base_m > 0.0).then_some(Wheels { base_m, speed_max_m_s })
}

/// Reads what a robot is set to now.
pub fn settings(server: &ParameterServer, node: &str) -> Settings {
    let value = |name| server.double(node, name);
    Settings {
        limits: Limits {
            speed_m_s: value(SPEED_MAX),
            turn_rate_rad_s: value(TURN_RATE_MAX),
            wheels: wheels(value(WHEEL_BASE), value(WHEEL_SPEED_MAX)),
            acceleration_m_s2: value(ACCELERATION_MAX),
            turn_acceleration_rad_s2: value(TURN_ACCELERATION_MAX),
        },
        detector: DetectorSettings {
            threshold_m: value(DETECTION_THRESHOLD),
            debounce: u32::try_from(server.integer(node, DEBOUNCE)).expect("it ends at 100"),
            timeout: Duration::from_secs_f64(value(SENSOR_TIMEOUT)),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_has_a_description_and_every_number_its_range() {
        for driver in DriverKind::ALL {
            for (descriptor, value) in declared(driver) {
                assert!(descriptor.description.ends_with('.'), "{}", descriptor.name);
                let is_number =
                    matches!(value, ParameterValue::Double(_) | ParameterValue::Integer(_));
                assert_eq!(descriptor.range.is_some(), is_number, "{}", descriptor.name);
            }
        }
    }

    #[test]
    fn the_runner_reads_every_parameter_that_a_gate_may_have() {
        let known = rsrs_fleet::parameters::gate::names();
        for driver in DriverKind::ALL {
            for (descriptor, _) in declared(driver) {
                assert!(known.contains(&descriptor.name.as_str()), "{}", descriptor.name);
            }
        }
    }

    #[test]
    fn start_values_replace_the_usual_ones() {
        let given = BTreeMap::from([(SPEED_MAX.to_owned(), ParameterValue::Double(0.2))]);

        let declared = declare("robot_1", DriverKind::Virtual, &given);

        let (_, value) = declared
            .parameters
            .iter()
            .find(|(descriptor, _)| descriptor.name == SPEED_MAX)
            .unwrap();
        assert_eq!(*value, ParameterValue::Double(0.2));
        let timeout = |driver| {
            let (_, value) = super::declared(driver)
                .into_iter()
                .find(|(descriptor, _)| descriptor.name == SENSOR_TIMEOUT)
                .unwrap();
            value
        };
        assert_eq!(timeout(DriverKind::Serial), ParameterValue::Double(0.5));
        assert_eq!(timeout(DriverKind::Virtual), ParameterValue::Double(1.0));
        assert!(!names(DriverKind::Virtual).contains(&"serial.port".to_owned()));
    }
}
