//! What a controller process is told when it starts.

use std::collections::BTreeMap;

use rsrs_ros::interfaces::{self, InterfaceError};
use rsrs_ros::logging::Level;
use rsrs_ros::parameters::ParameterValue;
use rsrs_ros::ros_args::{Environment, RosArgs, RosArgsError};
use rsrs_ros::session::SessionOptions;

use crate::parameters::NODE;

/// What a controller process is told when it starts.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where to speak.
    pub session: SessionOptions,
    /// The robots, with the start values of their parameters.
    pub robots: Vec<(String, BTreeMap<String, ParameterValue>)>,
    /// From which level on to log.
    pub log_level: Option<Level>,
    /// What cannot be honoured, to be said once the log is open.
    pub notes: Vec<String>,
}

/// Why a controller process cannot start.
#[derive(Debug, thiserror::Error)]
pub enum OptionsError {
    /// The arguments for ROS 2 are wrong.
    #[error(transparent)]
    Ros(#[from] RosArgsError),
    /// No interface is chosen, or it does not exist.
    #[error("{0}; {help}", help = .0.help())]
    Interface(#[from] InterfaceError),
    /// An argument that this node does not have.
    #[error("unexpected argument `{found}`, expected --interface, --robots or --ros-args")]
    Unexpected {
        /// The argument.
        found: String,
    },
    /// A flag at the end without its value.
    #[error("`{flag}` needs a value")]
    NoValue {
        /// The flag.
        flag: String,
    },
    /// No robot is named.
    #[error("no robot: give `--robots robot_1,robot_2` or a namespace, `-r __ns:=/robot_1`")]
    NoRobot,
}

impl Options {
    /// Understands the arguments of the process.
    ///
    /// # Errors
    ///
    /// [`OptionsError`].
    pub fn parse(arguments: &[String], environment: &Environment) -> Result<Self, OptionsError> {
        let (ros, rest) = RosArgs::parse(arguments, environment)?;
        let (mut interface, mut robots) = (None, Vec::new());
        let mut rest = rest.into_iter();
        while let Some(flag) = rest.next() {
            let mut value = || rest.next().ok_or(OptionsError::NoValue { flag: flag.clone() });
            match flag.as_str() {
                "--interface" => interface = Some(value()?),
                "--robots" => robots.extend(value()?.split(',').map(str::to_owned)),
                _ => return Err(OptionsError::Unexpected { found: flag }),
            }
        }
        if robots.is_empty() {
            let (namespace, _) = ros.node("/", NODE);
            match namespace.trim_matches('/') {
                "" => return Err(OptionsError::NoRobot),
                robot => robots.push(robot.to_owned()),
            }
        }
        let address =
            interfaces::chosen(interface.as_deref(), environment.variable(interfaces::VARIABLE))?;
        let with_parameters = |robot: String| {
            let parameters = ros.parameters(&format!("/{robot}/{NODE}"));
            (robot, parameters)
        };
        Ok(Self {
            session: SessionOptions { domain_id: ros.domain_id, interfaces: vec![address] },
            robots: robots.into_iter().map(with_parameters).collect(),
            log_level: ros.log_level(NODE),
            notes: ros.notes.iter().map(ToString::to_string).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(arguments: &[&str]) -> Result<Options, OptionsError> {
        let arguments: Vec<String> = arguments.iter().map(|text| (*text).to_owned()).collect();
        let environment = Environment::new(&[("RSRS_INTERFACE", "127.0.0.1")], |_| {
            Err(std::io::ErrorKind::NotFound.into())
        });
        Options::parse(&arguments, &environment)
    }

    #[test]
    fn the_namespace_names_the_robot_and_parameters_reach_it() {
        let options = parse(&["--ros-args", "-r", "__ns:=/robot_3", "-p", "speed:=0.15"]).unwrap();

        assert_eq!(options.robots.len(), 1);
        assert_eq!(options.robots[0].0, "robot_3");
        assert_eq!(options.robots[0].1["speed"], ParameterValue::Double(0.15));
    }

    #[test]
    fn one_process_hosts_many_robots() {
        let options = parse(&["--robots", "robot_1,robot_2"]).unwrap();

        let names: Vec<&str> = options.robots.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["robot_1", "robot_2"]);
    }

    #[test]
    fn a_process_without_a_robot_is_refused() {
        assert!(matches!(parse(&[]), Err(OptionsError::NoRobot)));
    }

    #[test]
    fn an_unknown_argument_is_named() {
        let error = parse(&["--robot", "robot_1"]).unwrap_err();

        assert!(error.to_string().contains("`--robot`"), "{error}");
    }

    #[test]
    fn the_lan_is_not_used_by_accident() {
        let nobody_chose = Environment::new(&[], |_| Err(std::io::ErrorKind::NotFound.into()));
        let arguments = ["--robots".to_owned(), "robot_1".to_owned()];

        let error = Options::parse(&arguments, &nobody_chose).unwrap_err();

        assert!(matches!(error, OptionsError::Interface(InterfaceError::NotChosen { .. })));
    }
}
