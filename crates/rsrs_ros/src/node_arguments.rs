//! Arguments of a node's process: where it publishes, and for which robots.

use rsrs_core::help::Help;

use crate::environment::Environment;
use crate::logging::Level;
use crate::network::NetworkError;
use crate::ros_args::{RosArgs, RosArgsError, TopicRules};
use crate::runtime::runtime;
use crate::security::{Member, PermissiveStrategy};
use crate::session::SessionOptions;

/// Arguments of a node of ours.
#[derive(Clone, Debug)]
pub struct NodeArguments {
    /// Which network to join.
    pub session: SessionOptions,
    /// The robots that it stands for, in the order given.
    pub robots: Vec<String>,
    /// From which level on to log.
    pub log_level: Option<Level>,
    /// Arguments for ROS 2, such as start values of parameters.
    pub ros: RosArgs,
}

/// Why a node cannot start.
#[derive(Debug, thiserror::Error)]
pub enum NodeArgumentsError {
    /// The arguments for ROS 2 are wrong.
    #[error("{}", .0.text_with_help())]
    Ros(#[from] RosArgsError),
    /// The namespace and `--robots` name different robots.
    #[error(
        "namespace `{namespace}` beside `--robots {robots}`: leave one out, or give both the same robot"
    )]
    Namespace {
        /// The namespace.
        namespace: String,
        /// The robots.
        robots: String,
    },
    /// No interface is chosen or it does not exist, or what is to be secured cannot be.
    #[error("{}", .0.text_with_help())]
    Network(#[from] NetworkError),
    /// No robot is named.
    #[error("no robot: give `--robots robot_1,robot_2` or a namespace, `-r __ns:=/robot_1`")]
    NoRobot,
}

/// What a node's program is.
#[derive(Clone, Copy, Debug)]
pub struct Program<'a> {
    /// Names of its nodes for each robot; parameters and log levels are those of the first.
    pub nodes: &'a [&'a str],
    /// Whether its topics can have other names.
    pub topics: TopicRules,
    /// What it is for its robots.
    pub part: Part,
}

/// What a program is for its robots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Their gates or their controllers.
    Robot,
    /// The world in which they are.
    Simulator,
}

/// Flags of whoever joins a network.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "\
ROS_DOMAIN_ID, ROS_SECURITY_ENABLE, ROS_SECURITY_KEYSTORE, ROS_SECURITY_STRATEGY, \
ROS_SECURITY_ENCLAVE_OVERRIDE and -e NAME (--enclave) mean what they mean in ROS 2 (docs/security.md), and so \
does ROS_AUTOMATIC_DISCOVERY_RANGE except OFF, which is not supported; LOCALHOST stays on the loopback \
interface, whatever interface is chosen.")]
pub struct NetworkFlags {
    /// Network interface to use, more than once for several (or `RSRS_INTERFACE`, with commas between
    /// them); there is no default, so that nothing is published on a LAN by accident.
    #[arg(long, value_name = "NAME|IP")]
    pub interface: Vec<String>,
    /// As in ROS 2, up to `--` or the end: -r NAME:=NAME, -p NAME:=VALUE, --params-file FILE, --log-level
    /// LEVEL, --disable-rosout-logs, -e NAME; nodes keep their names.
    #[arg(
        long,
        value_name = "ARGUMENTS",
        num_args = 0..,
        allow_hyphen_values = true,
        value_terminator = "--"
    )]
    pub ros_args: Vec<String>,
}

/// Flags that all nodes of robots have.
#[derive(Clone, Debug, clap::Args)]
pub struct NodeFlags {
    #[command(flatten)]
    network: NetworkFlags,
    /// Robots that the process stands for; without it the namespace (`-r __ns:=/robot_1`) names one.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    robots: Vec<String>,
    /// Run although `ROS_SECURITY_STRATEGY` is not Enforce: without its enclave, a robot obeys anybody.
    #[arg(long)]
    permissive_security: bool,
}

/// Runs a program that has the flags of all nodes and no others.
///
/// # Errors
///
/// If the arguments are wrong, no interface is chosen, or `serve` fails.
pub fn run<S: Future<Output = anyhow::Result<()>>>(
    program: Program<'_>,
    flags: NodeFlags,
    serve: impl FnOnce(NodeArguments) -> S,
) -> anyhow::Result<()> {
    let options = NodeArguments::new(flags, &Environment::of_this_process(), program)?;
    options.ros.start_logging(options.log_level);
    runtime()?.block_on(serve(options))
}

impl NodeArguments {
    /// What a process does as its flags and ROS 2 have it. Without `--robots` the namespace names the
    /// one robot.
    ///
    /// # Panics
    ///
    /// If the program has no nodes.
    pub fn new(
        flags: NodeFlags,
        environment: &Environment,
        program: Program<'_>,
    ) -> Result<Self, NodeArgumentsError> {
        let Program { nodes, topics, part } = program;
        let NodeFlags { network, mut robots, permissive_security } = flags;
        let mut ros = RosArgs::parse(&network.ros_args, environment)?;
        ros.check_rules(nodes, topics)?;
        let node = *nodes.first().expect("every program has a node");
        let (namespace, _) = ros.node("/", node);
        match namespace.trim_matches('/') {
            "" if robots.is_empty() => return Err(NodeArgumentsError::NoRobot),
            "" => {}
            robot if robots.is_empty() => robots.push(robot.to_owned()),
            robot if robots == [robot] => {}
            _ => {
                let robots = robots.join(",");
                return Err(NodeArgumentsError::Namespace { namespace, robots });
            }
        }
        let permissive = if permissive_security {
            PermissiveStrategy::Allowed
        } else {
            PermissiveStrategy::Refused
        };
        let member = match part {
            Part::Robot => Member::Robots(&robots, permissive),
            Part::Simulator => Member::Simulator,
        };
        Ok(Self {
            session: ros.network(&network.interface, environment, member)?,
            robots,
            log_level: ros.log_level(node),
            ros,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use clap::Parser;

    use super::*;
    use crate::interfaces::InterfaceError;
    use crate::parameters::ParameterValue;

    fn parse(arguments: &[&str]) -> Result<NodeArguments, NodeArgumentsError> {
        understood(arguments, &[("RSRS_INTERFACE", "127.0.0.1")])
    }

    #[derive(Debug, Parser)]
    struct Flags {
        #[command(flatten)]
        node: NodeFlags,
    }

    fn flags(arguments: &[&str]) -> Result<NodeFlags, clap::Error> {
        let line = ["node"].iter().chain(arguments);
        Flags::try_parse_from(line).map(|Flags { node }| node)
    }

    fn understood(
        arguments: &[&str],
        variables: &[(&str, &str)],
    ) -> Result<NodeArguments, NodeArgumentsError> {
        let environment = Environment::new(variables, |_| Err(io::ErrorKind::NotFound.into()));
        let program =
            Program { nodes: &["controller"], topics: TopicRules::Followed, part: Part::Robot };
        NodeArguments::new(flags(arguments).unwrap(), &environment, program)
    }

    #[test]
    fn the_namespace_names_the_robot_and_parameters_reach_it() {
        let options = parse(&["--ros-args", "-r", "__ns:=/robot_3", "-p", "speed:=0.15"]).unwrap();

        assert_eq!(options.robots, ["robot_3"]);
        let parameters = options.ros.parameters("/robot_3/controller");
        assert_eq!(parameters["speed"], ParameterValue::Double(0.15));
        let several = parse(&["--robots", "robot_1,robot_2"]).unwrap();
        assert_eq!(several.robots, ["robot_1", "robot_2"]);
    }

    #[test]
    fn what_cannot_be_followed_is_refused_and_not_ignored() {
        for (rule, expected) in [
            ("__node:=brain", "`-r __node:=brain`: the nodes of this program are called"),
            ("__ns:=/robot_2", "namespace `/robot_2` beside `--robots robot_1`"),
        ] {
            let error = parse(&["--robots", "robot_1", "--ros-args", "-r", rule]).unwrap_err();

            assert!(error.to_string().starts_with(expected), "{error}");
        }
        assert!(matches!(parse(&[]), Err(NodeArgumentsError::NoRobot)));
        assert!(flags(&["--robot", "robot_1"]).is_err());
        let same = ["__node:=controller", "__ns:=/robot_1", "cmd_vel:=/base/cmd_vel"];
        for rule in same {
            parse(&["--robots", "robot_1", "--ros-args", "-r", rule]).unwrap();
        }
    }

    #[test]
    fn what_is_meant_for_ros_is_no_flag_of_the_node() {
        let line = [
            "--ros-args",
            "-h",
            "-r",
            "a:=b",
            "--robots",
            "--",
            "--robots",
            "robot_1",
            "--ros-args",
            "-p",
        ];

        let NodeFlags { network, robots, .. } = flags(&line).unwrap();

        assert_eq!(network.ros_args, ["-h", "-r", "a:=b", "--robots", "-p"]);
        assert_eq!(robots, ["robot_1"]);
        let help = flags(&["--robots", "robot_1", "-h"]).unwrap_err();
        assert_eq!(help.kind(), clap::error::ErrorKind::DisplayHelp);
    }

    #[test]
    fn the_lan_is_not_used_by_accident() {
        let error = understood(&["--robots", "robot_1"], &[]).unwrap_err();

        let is_none_chosen = |error: &NodeArgumentsError| {
            let NodeArgumentsError::Network(error) = error else { return false };
            matches!(error, NetworkError::Interface(InterfaceError::NotChosen { .. }))
        };
        assert!(is_none_chosen(&error), "{error}");
    }
}
