//! The parameters of the nodes: their names, and what a fleet file and a profile determine of them.
//!
//! Nodes declare them, the runner sets and reads them, and records keep them; each name stands here
//! once.

use std::collections::BTreeMap;
use std::fmt;

use rsrs_core::robot::profile::RobotProfile;
use serde::{Deserialize, Serialize};

use crate::fleet_file::FleetRobot;

/// A parameter that is a number, as a node declares it.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What there is to say beside, from its punctuation on.
    pub more: &'static str,
    /// The least value, and the greatest.
    pub range: [f64; 2],
    /// Its value where nothing else is given.
    pub usual: f64,
    /// Whether it is set at the start and stays.
    pub read_only: bool,
}

impl Number {
    /// A sentence with its unit.
    pub fn description(&self) -> String {
        format!("{}, in {}{}.", self.what, self.unit, self.more)
    }
}

/// The words that a parameter may be, for a sentence: `serial, ros or virtual`.
pub fn one_of(words: &[&str]) -> String {
    match words {
        [all_but_last @ .., last] if !all_but_last.is_empty() => {
            format!("{} or {last}", all_but_last.join(", "))
        }
        _ => words.concat(),
    }
}

/// The parameters of a robot's controller.
pub mod controller {
    use rsrs_core::robot::controller::state_machine::StateMachine;
    use rsrs_core::robot::controller::{Command, Controller, ControllerParameters};

    /// Name of the node in its robot's namespace.
    pub use rsrs_msgs::node_names::CONTROLLER as NODE;

    /// Forward speed where something is detected, in m/s.
    pub const SPEED: &str = "speed";
    /// Turning rate where something is detected, in rad/s.
    pub const TURN_RATE: &str = "turn_rate";
    /// Whether it turns the other way, at the same speed, where nothing is detected.
    pub const MIRRORED: &str = "mirrored";
    /// Forward speed where nothing is detected, in m/s.
    pub const UNDETECTED_SPEED: &str = "undetected_speed";
    /// Turning rate where nothing is detected, in rad/s.
    pub const UNDETECTED_TURN_RATE: &str = "undetected_turn_rate";
    /// Greatest safe speed, in m/s; also the gate's.
    pub const SPEED_MAX: &str = super::gate::SPEED_MAX;
    /// Greatest safe turning rate, in rad/s; also the gate's.
    pub const TURN_RATE_MAX: &str = super::gate::TURN_RATE_MAX;
    /// Whether commands carry the simulator's clock, step by step.
    pub const STAMP_FROM_CLOCK: &str = "stamp_from_clock";
    /// Type of velocity commands; also the gate's.
    pub const CMD_VEL_TYPE: &str = super::gate::CMD_VEL_TYPE;
    /// Whether it turns one way whatever is detected.
    pub const CONSTANT: &str = "constant";
    /// Interval of the robot's detections, in seconds; also the gate's.
    pub const PERIOD: &str = super::gate::PERIOD;
    /// The table of a controller with states, as JSON; empty for two commands over one detection.
    pub const TABLE: &str = "table";
    /// Key of the draws of its transitions, of this run and robot.
    pub const TRANSITION_KEY: &str = "transition_key";
    /// The class of its robot, whose start among the states is that of the table; empty where there are none.
    pub const CLASS: &str = "class";
    /// Who holds the lease: a [`LeaseHolder`](crate::fleet_file::LeaseHolder).
    pub const LEASE: &str = "lease";

    /// The controller that a [`TABLE`] makes, or where it is empty two commands: where something is detected, and
    /// where nothing is, `None` if that is [`MIRRORED`].
    ///
    /// # Errors
    ///
    /// Why the table is none, in words.
    pub fn of_values(
        table: &str,
        detected: Command,
        undetected: Option<Command>,
    ) -> Result<Controller, String> {
        if !table.is_empty() {
            let machine = StateMachine::from_json(table);
            let failed = |error| format!("`{TABLE}` is no table: {error}");
            return machine.map(Controller::Machine).map_err(failed);
        }
        Ok(match undetected {
            Some(undetected) => ControllerParameters::new(detected, undetected).into(),
            None => {
                ControllerParameters::mirrored(detected.speed_m_s, detected.turn_rate_rad_s).into()
            }
        })
    }
}

/// The parameters of the gate in front of a robot's wheels.
pub mod gate {
    use std::f64::consts::PI;

    use rsrs_core::bounds::Bounds;

    use super::Number;

    /// Name of the node in its robot's namespace.
    pub use rsrs_msgs::node_names::GATE as NODE;

    /// Greatest safe speed, in m/s.
    pub const SPEED_MAX: &str = "speed_max";
    /// Greatest safe turning rate, in rad/s.
    pub const TURN_RATE_MAX: &str = "turn_rate_max";
    /// Distance of the two wheels, in metres; 0 where it is not known.
    pub const WHEEL_BASE: &str = "wheel_base";
    /// Greatest speed of a wheel, in m/s.
    pub const WHEEL_SPEED_MAX: &str = "wheel_speed_max";
    /// Interval of detections, in seconds.
    pub const PERIOD: &str = "period";
    /// Greatest growth of the speed, in m/s².
    pub const ACCELERATION_MAX: &str = "acceleration_max";
    /// Greatest growth of the turning rate, in rad/s².
    pub const TURN_ACCELERATION_MAX: &str = "turn_acceleration_max";
    /// What is at most so far away is detected, in metres.
    pub const DETECTION_THRESHOLD: &str = "detection_threshold";
    /// Age at which a reading of the sensor is too old, in seconds.
    pub const SENSOR_TIMEOUT: &str = "sensor_timeout";
    /// Readings in a row that must agree before the detection changes.
    pub const DEBOUNCE: &str = "debounce";
    /// Type of velocity commands.
    pub const CMD_VEL_TYPE: &str = "cmd_vel_type";
    /// What moves the robot.
    pub const DRIVER: &str = "driver";
    /// Digest of the profile that it was started with; empty without one.
    pub const PROFILE_DIGEST: &str = "profile_digest";

    /// Path of the serial device.
    pub const SERIAL_PORT: &str = "serial.port";
    /// Its baud rate.
    pub const SERIAL_BAUD: &str = "serial.baud";
    /// Type of the messages of a sensor that is a topic.
    pub const ROS_SENSOR_TYPE: &str = "ros.sensor_type";
    /// Topic of that sensor.
    pub const ROS_SENSOR_TOPIC: &str = "ros.sensor_topic";
    /// Half of the sector of a scan that is looked at, in rad.
    pub const ROS_SECTOR: &str = "ros.sector_half_angle";
    /// Type of the commands to the base.
    pub const ROS_CMD_VEL_TYPE: &str = "ros.cmd_vel_type";

    /// The numbers of every robot. The ranges end where the serial line's numbers do; the values are
    /// those of the Flockbot.
    pub const NUMBERS: [Number; 9] = [
        Number {
            name: SPEED_MAX,
            what: "Greatest safe speed",
            unit: "m/s",
            more: "; faster commands are refused",
            range: [0.0, 30.0],
            usual: 0.3,
            read_only: true,
        },
        Number {
            name: TURN_RATE_MAX,
            what: "Greatest safe turning rate",
            unit: "rad/s",
            more: "; faster commands are refused",
            range: [0.0, 30.0],
            usual: 2.5,
            read_only: true,
        },
        Number {
            name: WHEEL_BASE,
            what: "Distance of the two wheels",
            unit: "m",
            more: "; 0 where wheels have no limit of their own",
            range: [0.0, 10.0],
            usual: 0.0,
            read_only: true,
        },
        Number {
            name: WHEEL_SPEED_MAX,
            what: "Greatest speed of a wheel",
            unit: "m/s",
            more: "; commands that ask more of one are refused",
            range: [0.0, 100.0],
            usual: 0.0,
            read_only: true,
        },
        Number {
            name: PERIOD,
            what: "Interval of detections",
            unit: "s",
            more: "",
            range: [Bounds::PERIOD.least, Bounds::PERIOD.most],
            usual: 0.13,
            read_only: true,
        },
        Number {
            name: ACCELERATION_MAX,
            what: "Greatest growth of the speed",
            unit: "m/s²",
            more: "",
            range: [0.01, 100.0],
            usual: 1.0,
            read_only: false,
        },
        Number {
            name: TURN_ACCELERATION_MAX,
            what: "Greatest growth of the turning rate",
            unit: "rad/s²",
            more: "",
            range: [0.1, 1000.0],
            usual: 20.0,
            read_only: false,
        },
        Number {
            name: DETECTION_THRESHOLD,
            what: "What the range sensor measures at most so far away is seen",
            unit: "m",
            more: "",
            range: [0.0, 100.0],
            usual: 0.75,
            read_only: false,
        },
        Number {
            name: SENSOR_TIMEOUT,
            what: "So long after its last reading, the sensor has failed",
            unit: "s",
            more: "",
            range: [0.05, 10.0],
            usual: 0.5,
            read_only: false,
        },
    ];

    /// The number of a robot whose base driver is somebody else's, and whose sensor scans.
    pub const SECTOR: Number = Number {
        name: ROS_SECTOR,
        what: "Half of the sector of a scan that is looked at, about straight ahead",
        unit: "rad",
        more: "",
        range: [0.0, PI],
        usual: 0.2,
        read_only: true,
    };

    /// Those that are no numbers with a unit.
    const OTHERS: [&str; 9] = [
        DEBOUNCE,
        CMD_VEL_TYPE,
        DRIVER,
        PROFILE_DIGEST,
        SERIAL_PORT,
        SERIAL_BAUD,
        ROS_SENSOR_TYPE,
        ROS_SENSOR_TOPIC,
        ROS_CMD_VEL_TYPE,
    ];

    /// The number with this name; `None` if there is none.
    pub fn number(name: &str) -> Option<Number> {
        NUMBERS.into_iter().chain([SECTOR]).find(|number| number.name == name)
    }

    /// The usual value of a number.
    ///
    /// # Panics
    ///
    /// If there is no such number.
    pub fn usual(name: &str) -> f64 {
        number(name).expect("it is a name of this table").usual
    }

    /// The names of all parameters; those of other drivers than its own are not there.
    pub fn names() -> Vec<&'static str> {
        NUMBERS.iter().chain([&SECTOR]).map(|number| number.name).chain(OTHERS).collect()
    }
}

/// The parameters of the simulator.
pub mod simulator {
    pub use rsrs_msgs::node_names::{SIMULATOR as NODE, SIMULATOR_FULL_NAME as FULL_NAME};

    /// The conditions of an experiment, as JSON.
    pub const CONDITIONS: &str = "conditions";
    /// Seed of the world.
    pub const SEED: &str = "seed";
    /// Which replicate of the cell it is.
    pub const REPLICATE: &str = "replicate";
    /// Steps of the run.
    pub const STEPS: &str = "steps";
    /// The pace: a [`Time`](crate::experiment::Time).
    pub const TIME: &str = "time";
    /// Names of the robots, in the order of the world's rows.
    pub const ROBOTS: &str = "robots";
    /// Where poses of real robots come from: a [`PoseSource`](rsrs_core::robot::pose_source::PoseSource) of each robot.
    pub const TRACKED_BY: &str = "tracked_by";
    /// Whether robot nodes stand in front of its robots' wheels.
    pub const HARDWARE_ONLY: &str = "hardware_only";
}

/// The value of a parameter, as records keep it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// A truth value.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// A number; finite.
    Double(f64),
    /// A text.
    Text(String),
}

impl Value {
    /// Whether two values are the same, but for the last digits of a number that was written and read.
    fn agrees_with(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Double(one), Self::Double(two)) => {
                (one - two).abs() <= ROUNDING * one.abs().max(two.abs())
            }
            _ => self == other,
        }
    }
}

/// Relative difference below which numbers were the same before they were written; dimensionless.
const ROUNDING: f64 = 1e-9;

impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(value) => write!(formatter, "{value}"),
            Self::Integer(value) => write!(formatter, "{value}"),
            Self::Double(value) => write!(formatter, "{value}"),
            Self::Text(value) => write!(formatter, "`{value}`"),
        }
    }
}

/// Values of parameters, by name.
pub type GateSettings = BTreeMap<String, Value>;

/// What a fleet file, and the profile that it names, determine of a robot's gate.
///
/// A robot that was not measured yet has no profile, and its limits are those that its node was
/// started with. A profile without a cone determines no threshold: then the fleet file does.
pub fn of_gate(robot: &FleetRobot, profile: Option<&RobotProfile>) -> GateSettings {
    let mut settings = GateSettings::new();
    let mut set = |name: &str, value| drop(settings.insert(name.to_owned(), value));
    let mut threshold_m = robot.detection_threshold_m;
    if let Some(profile) = profile {
        set(gate::SPEED_MAX, Value::Double(profile.actuation.speed.limits_m_s[1]));
        set(gate::TURN_RATE_MAX, Value::Double(profile.actuation.turn.limits_rad_s[1]));
        if let Some(wheels) = profile.actuation.wheels {
            set(gate::WHEEL_BASE, Value::Double(wheels.base_m));
            set(gate::WHEEL_SPEED_MAX, Value::Double(wheels.speed_max_m_s));
        }
        set(gate::PERIOD, Value::Double(profile.computation.period_s));
        set(gate::PROFILE_DIGEST, Value::Text(profile.digest()));
        threshold_m = threshold_m.or(profile.sensing.cone.map(|cone| cone.range_m));
    }
    if let Some(threshold_m) = threshold_m {
        set(gate::DETECTION_THRESHOLD, Value::Double(threshold_m));
    }
    set(gate::CMD_VEL_TYPE, Value::Text(robot.cmd_vel.key().to_owned()));
    settings
}

/// A parameter of a gate that is not as the fleet file and the profile determine it.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// Its name.
    pub parameter: String,
    /// What the gate has.
    pub found: Value,
    /// What is determined.
    pub expected: Value,
}

impl fmt::Display for Deviation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { parameter, found, expected } = self;
        let unit = gate::number(parameter).map(|it| format!(" {}", it.unit)).unwrap_or_default();
        write!(formatter, "`{parameter}` is {found}{unit}, expected {expected}{unit}")
    }
}

/// Compares what a gate has with what is determined. What either lacks is not compared: a gate of
/// another version may have fewer parameters.
pub fn deviations(expected: &GateSettings, found: &GateSettings) -> Vec<Deviation> {
    let compared = expected.iter().filter_map(|(parameter, expected)| {
        let found = found.get(parameter)?;
        // It was started without a profile, and its limits are compared one by one.
        let is_unknown = parameter == gate::PROFILE_DIGEST && *found == Value::Text(String::new());
        (!is_unknown && !found.agrees_with(expected)).then(|| Deviation {
            parameter: parameter.clone(),
            found: found.clone(),
            expected: expected.clone(),
        })
    });
    compared.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Time;
    use crate::fleet_file::{CmdVel, FleetFile, LeaseHolder};

    use rsrs_testing::conditions::flockbot;

    fn expected(of_robot: &str) -> GateSettings {
        let fleet = format!(
            "fileversion: 1\nall: {{profile: p.yaml, driver: {{kind: ros}}}}\nrobots:\n  \
             robot_1: {{enabled: true{of_robot}}}\n"
        );
        let fleet = FleetFile::parse("fleet.yaml", &fleet).unwrap();
        of_gate(&fleet.robots[0], Some(&flockbot()))
    }

    #[test]
    fn words_are_what_files_have() {
        assert_eq!(one_of(&["serial", "ros", "virtual"]), "serial, ros or virtual");
        assert_eq!(one_of(&["gate", "controller"]), "gate or controller");
        for time in Time::ALL {
            assert_eq!(serde_json::to_value(time).unwrap(), time.key());
            assert_eq!(Time::from_key(time.key()), Some(time));
        }
        for holder in LeaseHolder::ALL {
            assert_eq!(serde_json::from_value::<LeaseHolder>(holder.key().into()).unwrap(), holder);
        }
        for cmd_vel in CmdVel::ALL {
            assert_eq!(serde_json::from_value::<CmdVel>(cmd_vel.key().into()).unwrap(), cmd_vel);
        }
    }

    #[test]
    fn the_fleet_file_goes_before_the_profile_it_names() {
        let of_profile = expected("");
        let of_fleet = expected(", detection_threshold_m: 0.6, cmd_vel: twist");

        assert_eq!(of_profile[gate::DETECTION_THRESHOLD], Value::Double(0.75));
        assert_eq!(of_fleet[gate::DETECTION_THRESHOLD], Value::Double(0.6));
        assert_eq!(of_fleet[gate::CMD_VEL_TYPE], Value::Text("twist".to_owned()));
        assert_eq!(of_profile[gate::PERIOD], Value::Double(0.13));
    }

    #[test]
    fn what_a_gate_lacks_and_the_last_digit_of_a_number_are_no_deviations() {
        let expected = expected("");
        let mut found = expected.clone();
        found.insert(gate::PERIOD.to_owned(), Value::Double(0.13 * (1.0 + 1e-12)));
        found.insert(gate::PROFILE_DIGEST.to_owned(), Value::Text(String::new()));
        found.remove(gate::SPEED_MAX);
        assert_eq!(deviations(&expected, &found), []);

        found.insert(gate::DETECTION_THRESHOLD.to_owned(), Value::Double(0.6));
        let texts: Vec<_> = deviations(&expected, &found).iter().map(ToString::to_string).collect();

        assert_eq!(texts, ["`detection_threshold` is 0.6 m, expected 0.75 m"]);
    }

    #[test]
    fn values_of_records_keep_their_types() {
        let settings = GateSettings::from([
            ("a".to_owned(), Value::Bool(true)),
            ("b".to_owned(), Value::Integer(3)),
            ("c".to_owned(), Value::Double(3.0)),
            ("d".to_owned(), Value::Text("3".to_owned())),
        ]);

        let text = serde_json::to_string(&settings).unwrap();

        assert_eq!(serde_json::from_str::<GateSettings>(&text).unwrap(), settings);
    }
}
