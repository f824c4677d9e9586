//! Arguments of the robot node: its robot, its driver, and start values.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use rsrs_core::robot::profile::{ProfileError, RobotProfile};
use rsrs_fleet::fleet_file::{self, FleetFile, FleetFileError, FleetRobot, LeaseHolder};
use rsrs_fleet::parameters::controller::LEASE;
use rsrs_fleet::parameters::gate::{
    DETECTION_THRESHOLD, NODE, SERIAL_BAUD as BAUD, SERIAL_PORT as PORT, usual,
};
use rsrs_fleet::parameters::{Value, of_gate};
use rsrs_ros::environment::Environment;
use rsrs_ros::node_arguments::{NodeArguments, NodeArgumentsError, NodeFlags, Part, Program};
use rsrs_ros::parameters::ParameterValue;
use rsrs_ros::ros_args::TopicRules;

use crate::driver::DriverKind;
use crate::parameters;

/// Arguments of the robot node.
#[derive(Clone, Debug)]
pub struct RobotArguments {
    /// Those of every node.
    pub node: NodeArguments,
    /// The robot.
    pub robot: String,
    /// What moves it.
    pub driver: DriverKind,
    /// Start values of the robot's parameters, by name.
    pub given: BTreeMap<String, ParameterValue>,
    /// Start values of its controller's parameters, by name; `None` if the controller is a process
    /// of its own, or another driver.
    pub controller: Option<BTreeMap<String, ParameterValue>>,
}

/// Why the robot node cannot start.
#[derive(Debug, thiserror::Error)]
pub enum ArgumentsError {
    /// Arguments of every node are wrong.
    #[error(transparent)]
    Node(#[from] NodeArgumentsError),
    /// No driver is given.
    #[error("no driver: give `--driver serial|ros|virtual`, or a fleet file with `--config`")]
    NoDriver,
    /// Another number of robots.
    #[error("{found} robots, expected 1: each robot's hardware has a process of its own")]
    Robots {
        /// Robots named.
        found: usize,
    },
    /// A file cannot be read.
    #[error("`{}` cannot be read: {source}", path.display())]
    Read {
        /// Its path.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// The fleet file is none.
    #[error(transparent)]
    Fleet(#[from] FleetFileError),
    /// The profile is none.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// A profile from which the threshold of a range sensor does not follow.
    #[error(
        "`{}` has a polygon and no cone: set `detection_threshold_m` in the fleet file, or \
         `-p {}:=…`, to the distance in metres with which the robot was measured, {} unless it was set",
        path.display(), DETECTION_THRESHOLD, usual(DETECTION_THRESHOLD)
    )]
    NoDetectionThreshold {
        /// The profile.
        path: PathBuf,
    },
    /// The fleet file has no such robot.
    #[error("`{}` has no robot `{robot}`, expected one of: {}", path.display(), expected.join(", "))]
    NoSuchRobot {
        /// The fleet file.
        path: PathBuf,
        /// The robot.
        robot: String,
        /// The robots that it has.
        expected: Vec<String>,
    },
    /// The controller is to hold the lease, and this program is a gate.
    #[error(
        "/{robot}/{NODE} is the gate in front of the wheels, so its controller holds no lease: leave \
         `-p {LEASE}:={}` out, or start the controller alone",
        LeaseHolder::Controller.key()
    )]
    Lease {
        /// The robot.
        robot: String,
    },
    /// A start value for a parameter that neither the robot nor its controller has.
    #[error("neither /{robot}/{NODE} nor its controller has a parameter `{name}`")]
    UnknownParameter {
        /// The robot.
        robot: String,
        /// The parameter.
        name: String,
    },
}

const NODES: [&str; 2] = [NODE, rsrs_controller_node::NODE];

/// A robot: its sensor, its wheels behind the final gate, and its controller.
#[derive(Clone, Debug, clap::Parser)]
pub struct Flags {
    #[command(flatten)]
    node: NodeFlags,
    /// The fleet file: what moves the robot, and how it was measured.
    #[arg(long, value_name = "FLEET.yaml")]
    config: Option<PathBuf>,
    /// What moves it, without a fleet file.
    #[arg(long, value_name = "serial|ros|virtual")]
    driver: Option<DriverKind>,
    /// The microcontroller's serial line, such as /dev/ttyACM0.
    #[arg(long, value_name = "PATH")]
    port: Option<String>,
    /// Its baud rate.
    #[arg(long, value_name = "N")]
    baud: Option<i64>,
    /// The controller is a process of its own.
    #[arg(long)]
    without_controller: bool,
}

impl RobotArguments {
    /// What is set closer to the robot goes first: `-p` and parameter files, then flags, then the
    /// fleet file, then the profile that it names.
    pub fn new(flags: Flags, environment: &Environment) -> Result<Self, ArgumentsError> {
        let topics = TopicRules::Followed;
        let program = Program { nodes: &NODES, topics, part: Part::Robot };
        let node = NodeArguments::new(flags.node, environment, program)?;
        let [robot] = &node.robots[..] else {
            return Err(ArgumentsError::Robots { found: node.robots.len() });
        };
        let robot = robot.clone();

        let mut values = BTreeMap::new();
        let mut described = None;
        if let Some(path) = &flags.config {
            described = Some(take_robot(&robot_of(path, &robot)?, path, &mut values)?);
        }
        let driver = described.as_ref().map(|described| described.driver);
        let driver = flags.driver.or(driver).ok_or(ArgumentsError::NoDriver)?;
        values.extend(flags.port.map(|port| (PORT.to_owned(), ParameterValue::String(port))));
        values.extend(flags.baud.map(|baud| (BAUD.to_owned(), ParameterValue::Integer(baud))));
        if driver != DriverKind::Serial {
            values.retain(|name, _| ![PORT, BAUD].contains(&name.as_str()));
        }

        let names_of_controller = rsrs_controller_node::names();
        let of_controller = |name: &String| names_of_controller.contains(name);
        let known = parameters::names(driver);
        let is_known = |name: &String| known.contains(name);
        let mut given = values.clone();
        given.extend(node.ros.parameters(&format!("/{robot}/{NODE}")));
        if let Some(name) = given.keys().find(|name| !is_known(name) && !of_controller(name)) {
            return Err(ArgumentsError::UnknownParameter { robot, name: name.clone() });
        }
        given.retain(|name, _| is_known(name));
        let without_threshold = described.and_then(|described| described.without_threshold);
        let reads_range = driver != DriverKind::Virtual;
        let has_threshold = given.contains_key(DETECTION_THRESHOLD);
        if let Some(path) = without_threshold.filter(|_| reads_range && !has_threshold) {
            return Err(ArgumentsError::NoDetectionThreshold { path });
        }
        let mut controller = values;
        controller.retain(|name, _| of_controller(name));
        let node_of_controller = format!("/{robot}/{}", rsrs_controller_node::NODE);
        let mut to_controller = node.ros.parameters(&node_of_controller);
        // A value for all nodes may be meant for the robot alone.
        to_controller.retain(|name, _| of_controller(name) || !is_known(name));
        controller.extend(to_controller);
        let holds_lease = ParameterValue::String(LeaseHolder::Controller.key().to_owned());
        if controller.get(LEASE) == Some(&holds_lease) {
            return Err(ArgumentsError::Lease { robot });
        }
        let controller = (!flags.without_controller).then_some(controller);
        Ok(Self { node, robot, driver, given, controller })
    }
}

fn read(path: &Path) -> Result<String, ArgumentsError> {
    rsrs_files::read_text(path)
        .map_err(|source| ArgumentsError::Read { path: path.to_owned(), source })
}

fn robot_of(path: &Path, robot: &str) -> Result<FleetRobot, ArgumentsError> {
    let fleet = FleetFile::parse(&path.display().to_string(), &read(path)?)?;
    let expected = fleet.robots.iter().map(|described| described.name.clone()).collect();
    fleet.robots.into_iter().find(|described| described.name == robot).ok_or_else(|| {
        ArgumentsError::NoSuchRobot { path: path.to_owned(), robot: robot.to_owned(), expected }
    })
}

/// What a fleet file has of a robot beside start values.
struct Described {
    driver: DriverKind,
    /// A profile from which the threshold of the sensor does not follow, where the fleet file does not
    /// have it either.
    without_threshold: Option<PathBuf>,
}

/// Takes start values from a robot's place in the fleet file, and from the profile named there.
fn take_robot(
    described: &FleetRobot,
    fleet_file: &Path,
    values: &mut BTreeMap<String, ParameterValue>,
) -> Result<Described, ArgumentsError> {
    let mut profile = None;
    // A robot that was not measured yet takes its limits from the command line, or the usual ones.
    if let Some(name) = &described.profile {
        let path = fleet_file.parent().unwrap_or(Path::new("")).join(name);
        let text = read(&path)?;
        profile = Some((RobotProfile::parse(&path.display().to_string(), &text)?, path));
    }
    let determined = of_gate(described, profile.as_ref().map(|(profile, _)| profile));
    let has_threshold = determined.contains_key(DETECTION_THRESHOLD);
    values.extend(determined.into_iter().map(|(name, value)| (name, start_value(value))));
    let without_threshold = profile.map(|(_, path)| path).filter(|_| !has_threshold);
    let driver = match &described.driver {
        fleet_file::Driver::Serial { port, baud } => {
            values.insert(PORT.to_owned(), ParameterValue::String(port.clone()));
            values.insert(BAUD.to_owned(), ParameterValue::Integer(i64::from(*baud)));
            DriverKind::Serial
        }
        fleet_file::Driver::Ros => DriverKind::Ros,
        fleet_file::Driver::Virtual => DriverKind::Virtual,
    };
    Ok(Described { driver, without_threshold })
}

fn start_value(value: Value) -> ParameterValue {
    match value {
        Value::Bool(value) => ParameterValue::Bool(value),
        Value::Integer(value) => ParameterValue::Integer(value),
        Value::Double(value) => ParameterValue::Double(value),
        Value::Text(value) => ParameterValue::String(value),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use clap::Parser;

    use super::*;

    fn parse(arguments: &[&str]) -> Result<RobotArguments, ArgumentsError> {
        let flags = Flags::try_parse_from(["robot"].iter().chain(arguments)).unwrap();
        let environment = Environment::new(&[("RSRS_INTERFACE", "127.0.0.1")], |_| {
            Err(io::ErrorKind::NotFound.into())
        });
        RobotArguments::new(flags, &environment)
    }

    #[test]
    fn each_node_takes_its_own_parameters_and_both_take_what_both_have() {
        let line = ["--robots", "robot_1", "--driver", "serial", "--port", "/dev/ttyUSB0"];
        let ros = ["--ros-args", "-p", "speed:=0.1", "-p", "debounce:=3", "-p", "speed_max:=0.2"];

        let parsed = parse(&[&line[..], &ros[..]].concat()).unwrap();

        let names =
            |values: &BTreeMap<String, ParameterValue>| values.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&parsed.given), ["debounce", "serial.port", "speed_max"]);
        assert_eq!(names(&parsed.controller.unwrap()), ["speed", "speed_max"]);
    }

    #[test]
    fn the_fleet_file_gives_what_the_flags_do_not() {
        let folder = tempfile::tempdir().unwrap();
        let profile = rsrs_testing::conditions::FLOCKBOT;
        fs::write(folder.path().join("p.yaml"), profile).unwrap();
        let fleet = "fileversion: 1\nall: {profile: p.yaml, cmd_vel: twist}\nrobots:\n  \
            robot_1: {enabled: true, driver: {kind: serial, port: /dev/ttyACM3, baud: 57600}}\n";
        let path = folder.path().join("fleet.yaml");
        fs::write(&path, fleet).unwrap();
        let path = path.display().to_string();

        let parsed = parse(&["--robots", "robot_1", "--config", &path, "--baud", "9600"]).unwrap();

        assert_eq!(parsed.driver, DriverKind::Serial);
        assert_eq!(parsed.given["serial.port"], ParameterValue::String("/dev/ttyACM3".to_owned()));
        assert_eq!(parsed.given["serial.baud"], ParameterValue::Integer(9600));
        assert_eq!(parsed.given["speed_max"], ParameterValue::Double(0.3));
        let controller = parsed.controller.unwrap();
        assert_eq!(controller["cmd_vel_type"], ParameterValue::String("twist".to_owned()));

        let error = parse(&["--robots", "robot_9", "--config", &path]).unwrap_err();
        assert!(error.to_string().contains("no robot `robot_9`, expected one of: robot_1"));
    }

    #[test]
    fn the_threshold_of_a_range_sensor_is_given_where_the_profile_has_no_cone() {
        let folder = tempfile::tempdir().unwrap();
        let profile = include_str!("../../../launch_configs/profiles/lta.yaml");
        fs::write(folder.path().join("p.yaml"), profile).unwrap();
        let path = folder.path().join("fleet.yaml");
        let parse_with = |of_all: &str, arguments: &[&str]| {
            let fleet = format!(
                "fileversion: 1\nall: {{profile: p.yaml, driver: {{kind: ros}}{of_all}}}\nrobots:\n  \
                 robot_1: {{enabled: true}}\n"
            );
            fs::write(&path, fleet).unwrap();
            let path = path.display().to_string();
            parse(&[&["--robots", "robot_1", "--config", &path], arguments].concat())
        };
        let parameter = ["--ros-args", "-p", "detection_threshold:=1.2"];

        let refused = parse_with("", &[]).unwrap_err().to_string();
        let by_fleet = parse_with(", detection_threshold_m: 1.1", &[]).unwrap();
        let by_parameter = parse_with(", detection_threshold_m: 1.1", &parameter).unwrap();

        assert!(refused.contains("has a polygon and no cone: set `detection_threshold_m`"));
        assert_eq!(by_fleet.given["detection_threshold"], ParameterValue::Double(1.1));
        assert_eq!(by_parameter.given["detection_threshold"], ParameterValue::Double(1.2));
        assert!(parse_with("", &["--driver", "virtual"]).is_ok());
    }

    #[test]
    fn what_nobody_has_is_refused_by_name() {
        for (arguments, expected) in [
            (&["--robots", "a"][..], "no driver: give"),
            (&["--robots", "a,b", "--driver", "ros"], "2 robots, expected 1"),
            (
                &["--robots", "a", "--driver", "ros", "--ros-args", "-p", "sped:=1.0"],
                "neither /a/robot nor its controller has a parameter `sped`",
            ),
            (
                &["--robots", "a", "--driver", "ros", "--ros-args", "-p", "lease:=controller"],
                "/a/robot is the gate in front of the wheels",
            ),
        ] {
            let error = parse(arguments).unwrap_err().to_string();

            assert!(error.contains(expected), "{error}");
        }
        let driver = Flags::try_parse_from(["robot", "--driver", "usb"]).unwrap_err().to_string();
        assert!(driver.contains("driver `usb`, expected serial, ros"), "{driver}");
    }
}
