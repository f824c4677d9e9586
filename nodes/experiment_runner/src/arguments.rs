//! What the runner is told when it starts as a node.

use std::path::PathBuf;

use rsrs_core::axis::{Cell, CellError};
use rsrs_fleet::record::Backend;
use rsrs_ros::interfaces::InterfaceError;
use rsrs_ros::logging::Level;
use rsrs_ros::ros_args::{Environment, RosArgs, RosArgsError, TopicRules};
use rsrs_ros::session::SessionOptions;

use crate::driver::NODE;
use crate::plan::{PlaceCheck, Request};

/// What the runner is told.
#[derive(Clone, Debug)]
pub struct RunnerArguments {
    /// What to run.
    pub request: Request,
    /// Where.
    pub session: SessionOptions,
    /// From which level on to log.
    pub log_level: Option<Level>,
    /// What was said to ROS 2.
    pub ros: RosArgs,
}

/// Why the runner cannot start.
#[derive(Debug, thiserror::Error)]
pub enum RunnerArgumentsError {
    /// The arguments for ROS 2 are wrong.
    #[error("{0}{help}", help = .0.help().map_or_else(String::new, |help| format!("; {help}")))]
    Ros(#[from] RosArgsError),
    /// No interface is chosen, or it does not exist.
    #[error("{0}; {help}", help = .0.help())]
    Interface(#[from] InterfaceError),
    /// The cell is none.
    #[error("`--cell`: {0}")]
    Cell(#[from] CellError),
    /// An argument that the runner does not have.
    #[error(
        "unexpected argument `{found}`, expected --experiment, --from, --cell, --output, \
         --backend, --interface or --ros-args"
    )]
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
    /// The runner has no namespace.
    #[error(
        "`-r __ns:={namespace}`: the runner is in no namespace; the robots' are in the fleet file"
    )]
    Namespace {
        /// The namespace.
        namespace: String,
    },
    /// A backend that there is not.
    #[error("`--backend {found}`, expected sim or fleet")]
    Backend {
        /// What was given.
        found: String,
    },
    /// Nothing to run.
    #[error("no experiment: give `--experiment FILE`")]
    NoExperiment,
}

impl RunnerArguments {
    /// Understands the arguments of the process.
    ///
    /// # Errors
    ///
    /// [`RunnerArgumentsError`].
    pub fn parse(
        arguments: &[String],
        environment: &Environment,
    ) -> Result<Self, RunnerArgumentsError> {
        let (mut ros, rest) = RosArgs::parse(arguments, environment)?;
        ros.check_rules(&[NODE], TopicRules::Refused)?;
        let (namespace, _) = ros.node("/", NODE);
        if namespace != "/" {
            return Err(RunnerArgumentsError::Namespace { namespace });
        }
        let (mut interface, mut experiment) = (None, None);
        let (mut cell, mut from, mut bag) = (None, None, None);
        let mut backend = Backend::Fleet;
        let mut rest = rest.into_iter();
        while let Some(flag) = rest.next() {
            let mut value =
                || rest.next().ok_or(RunnerArgumentsError::NoValue { flag: flag.clone() });
            match flag.as_str() {
                "--interface" => interface = Some(value()?),
                "--experiment" => experiment = Some(PathBuf::from(value()?)),
                "--cell" => cell = Some(value()?.parse::<Cell>()?),
                "--from" => from = Some(PathBuf::from(value()?)),
                "--output" => bag = Some(PathBuf::from(value()?)),
                "--backend" => {
                    backend = match value()?.as_str() {
                        "sim" => Backend::Simulator,
                        "fleet" => Backend::Fleet,
                        found => {
                            return Err(RunnerArgumentsError::Backend { found: found.to_owned() });
                        }
                    }
                }
                _ => return Err(RunnerArgumentsError::Unexpected { found: flag }),
            }
        }
        let experiment = experiment.ok_or(RunnerArgumentsError::NoExperiment)?;
        Ok(Self {
            request: Request {
                experiment,
                cell,
                from,
                backend,
                bag,
                seed: None,
                place_check: PlaceCheck::On,
            },
            session: ros.network(interface.as_deref(), environment)?,
            log_level: ros.log_level(NODE),
            ros,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(arguments: &[&str]) -> Result<RunnerArguments, RunnerArgumentsError> {
        let arguments: Vec<String> = arguments.iter().map(|text| (*text).to_owned()).collect();
        let environment = Environment::new(&[("RSRS_INTERFACE", "127.0.0.1")], |_| {
            Err(std::io::ErrorKind::NotFound.into())
        });
        RunnerArguments::parse(&arguments, &environment)
    }

    #[test]
    fn a_cell_and_a_backend_are_understood() {
        let cell = "speed_m_s=0.15,turn_rate_rad_s=0.75,robots=9";

        let options =
            parse(&["--experiment", "e.yaml", "--cell", cell, "--backend", "sim"]).unwrap();

        assert_eq!(options.request.cell, Some(cell.parse().unwrap()));
        assert_eq!(options.request.backend, Backend::Simulator);
    }

    #[test]
    fn the_fleet_is_what_runs_unless_the_simulator_is_named() {
        assert_eq!(parse(&["--experiment", "e.yaml"]).unwrap().request.backend, Backend::Fleet);
        assert!(parse(&["--experiment", "e.yaml", "--backend", "gazebo"]).is_err());
    }

    #[test]
    fn names_that_the_runner_could_not_follow_are_refused() {
        for rule in ["__node:=conductor", "__ns:=/lab", "/swarm/lease:=/lease"] {
            let error = parse(&["--experiment", "e.yaml", "--ros-args", "-r", rule]).unwrap_err();

            assert!(error.to_string().starts_with(&format!("`-r {rule}`: ")), "{error}");
        }
    }

    #[test]
    fn nothing_runs_without_an_experiment() {
        assert!(matches!(parse(&[]), Err(RunnerArgumentsError::NoExperiment)));
    }
}
