//! What is wrong with arguments or the environment.

use std::io;
use std::path::PathBuf;

use rsrs_core::help::Help;

use crate::environment::NoText;
use crate::logging::NoSuchLevel;

/// Why arguments or environment are not understood.
#[derive(Debug, thiserror::Error)]
pub enum RosArgsError {
    /// A flag that ROS 2 does not have, or that is not honoured here.
    #[error("unknown flag `{flag}` after --ros-args")]
    UnknownFlag {
        /// The flag.
        flag: String,
    },
    /// A flag at the end.
    #[error("flag `{flag}` needs a value")]
    MissingValue {
        /// The flag.
        flag: String,
    },
    /// A value without `:=`.
    #[error("`{found}` after {flag}, expected {expected}")]
    Assignment {
        /// The flag.
        flag: &'static str,
        /// Its value.
        found: String,
        /// What it should look like.
        expected: &'static str,
    },
    /// A name that ROS 2 does not allow.
    #[error("`{name}` in `{rule}` is no ROS 2 name")]
    Name {
        /// The whole rule.
        rule: String,
        /// The name.
        name: String,
    },
    /// A log level that ROS 2 does not have.
    #[error("--log-level")]
    Level {
        /// Which ones there are.
        #[source]
        source: NoSuchLevel,
    },
    /// A parameter file cannot be read.
    #[error("parameter file `{}` cannot be read", path.display())]
    File {
        /// Where it should be.
        path: PathBuf,
        /// The system's error.
        #[source]
        source: io::Error,
    },
    /// A parameter file is no YAML.
    #[error("parameter file `{}`", path.display())]
    FileSyntax {
        /// Where it is.
        path: PathBuf,
        /// Line, column and reason.
        #[source]
        source: Box<serde_saphyr::Error>,
    },
    /// A parameter file is YAML, but not of the shape `NODE: {ros__parameters: {…}}`.
    #[error("parameter file `{}`: `{at}` {reason}", path.display())]
    FileShape {
        /// Where it is.
        path: PathBuf,
        /// The keys that lead to the place.
        at: String,
        /// What is wrong there.
        reason: String,
    },
    /// The value of a parameter is no YAML.
    #[error("value `{found}` of parameter `{name}`")]
    ValueSyntax {
        /// Name of the parameter.
        name: String,
        /// Its value.
        found: String,
        /// Line, column and reason.
        #[source]
        source: Box<serde_saphyr::Error>,
    },
    /// The value of a parameter is YAML that no parameter can be.
    #[error("value of parameter `{name}` {reason}")]
    Value {
        /// Name of the parameter.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A node cannot have another name.
    #[error(
        "`-r {rule}`: the nodes of this program are called `{nodes}`, by which others find them"
    )]
    FixedNode {
        /// The rule.
        rule: String,
        /// Names of its nodes.
        nodes: String,
    },
    /// A topic cannot have another name.
    #[error("`-r {rule}`: the topics of `{nodes}` have fixed names, by which others find them")]
    FixedTopic {
        /// The rule.
        rule: String,
        /// Names of its nodes.
        nodes: String,
    },
    /// A variable whose value is no text.
    #[error(transparent)]
    NoText(#[from] NoText),
    /// `ROS_DOMAIN_ID` is no domain.
    #[error("ROS_DOMAIN_ID is `{found}`, expected a number from 0 to 232, best below 102")]
    Domain {
        /// Its value.
        found: String,
    },
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE` is no range.
    #[error(
        "ROS_AUTOMATIC_DISCOVERY_RANGE is `{found}`, \
         expected LOCALHOST, SUBNET, OFF or SYSTEM_DEFAULT"
    )]
    DiscoveryRange {
        /// Its value.
        found: String,
    },
}

impl Help for RosArgsError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::UnknownFlag { .. } => {
                "known are -r (--remap), -p (--param), --params-file, --log-level and \
                 --enable/--disable-rosout-logs; `--` ends them"
            }
            Self::FixedNode { .. } => "give the robot another namespace instead",
            Self::FixedTopic { .. } => "give the other program's topic this name instead",
            Self::FileShape { .. } => "see launch_configs for an example",
            _ => return None,
        };
        Some(help.to_owned())
    }
}
