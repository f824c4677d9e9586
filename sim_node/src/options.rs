//! What a simulator process is told when it starts.

use rsrs_ros::interfaces::{self, InterfaceError};
use rsrs_ros::logging::Level;
use rsrs_ros::ros_args::{Environment, RosArgs, RosArgsError};
use rsrs_ros::session::SessionOptions;

use crate::parameters::NODE;

/// What a simulator process is told when it starts.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where to speak.
    pub session: SessionOptions,
    /// The robots that it stands in for, in the order of the world.
    pub robots: Vec<String>,
    /// From which level on to log.
    pub log_level: Option<Level>,
    /// What cannot be honoured, to be said once the log is open.
    pub notes: Vec<String>,
}

/// Why a simulator process cannot start.
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
    #[error("no robot: give `--robots robot_1,robot_2`")]
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
            return Err(OptionsError::NoRobot);
        }
        let address =
            interfaces::chosen(interface.as_deref(), environment.variable(interfaces::VARIABLE))?;
        Ok(Self {
            session: SessionOptions { domain_id: ros.domain_id, interfaces: vec![address] },
            robots,
            log_level: ros.log_level(NODE),
            notes: ros.notes.iter().map(ToString::to_string).collect(),
        })
    }
}
