//! Arguments of the runner as a node.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use rsrs_core::quantity::Cell;
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_core::trials::trial::TrialBackend;
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::Backend;
use rsrs_ros::environment::Environment;
use rsrs_ros::logging::Level;
use rsrs_ros::node_arguments::{NetworkFlags, NodeArgumentsError};
use rsrs_ros::ros_args::{RosArgs, TopicRules};
use rsrs_ros::security::Member;
use rsrs_ros::session::SessionOptions;

use crate::NODE;
use crate::plan::Request;

/// Arguments of the runner.
#[derive(Clone, Debug)]
pub struct RunnerArguments {
    /// What to run.
    pub request: Request,
    /// Where.
    pub session: SessionOptions,
    /// From which level on to log.
    pub log_level: Option<Level>,
    /// Arguments for ROS 2.
    pub ros: RosArgs,
}

/// Why the runner cannot start.
#[derive(Debug, thiserror::Error)]
pub enum RunnerArgumentsError {
    /// The arguments are wrong.
    #[error(transparent)]
    Node(#[from] NodeArgumentsError),
    /// The runner has no namespace.
    #[error(
        "`-r __ns:={namespace}`: the runner is in no namespace; the robots' are in the fleet file"
    )]
    Namespace {
        /// The namespace.
        namespace: String,
    },
}

/// One experiment: preflight, parameters, leases and the bag.
#[derive(Clone, Debug, clap::Parser)]
pub struct Flags {
    /// The experiment file.
    #[arg(long, value_name = "FILE")]
    experiment: PathBuf,
    /// The bag to record; named by date without it.
    #[arg(long, value_name = "BAG")]
    output: Option<PathBuf>,
    /// The sweep whose chosen cell is run.
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
    /// The cell to run, such as `speed_m_s=0.15,turn_rate_rad_s=0.75,robots=9`.
    #[arg(long)]
    cell: Option<Cell>,
    /// What moves the robots.
    #[arg(long, value_parser = backends("The simulator"), default_value = "fleet")]
    backend: Backend,
    #[command(flatten)]
    network: NetworkFlags,
}

/// What `--backend` may be, and what that of the simulator is; the words are those of tables of trials.
pub fn backends(simulator: &'static str) -> impl TypedValueParser<Value = Backend> {
    choice(TrialBackend::ALL.map(|backend| {
        let help = match backend {
            TrialBackend::Simulator => simulator,
            TrialBackend::Fleet => "The robots",
        };
        (backend.into(), backend.key(), help)
    }))
}

/// What `--place-check` may be.
pub fn place_checks() -> impl TypedValueParser<Value = PlaceCheck> {
    let rows = [
        (PlaceCheck::On, "Report them, and let the robots move all the same"),
        (PlaceCheck::Require, "Neither arm nor move any robot"),
        (PlaceCheck::Off, "Do not compare them with the poses that robots should start from"),
    ];
    choice(rows.map(|(check, help)| (check, check.key(), help)))
}

fn choice<T: Copy + Send + Sync + 'static, const N: usize>(
    rows: [(T, &'static str, &'static str); N],
) -> impl TypedValueParser<Value = T> {
    let words = rows.map(|(_, word, help)| PossibleValue::new(word).help(help));
    PossibleValuesParser::new(words).map(move |found| {
        let (value, ..) = rows.iter().find(|row| row.1 == found).expect("it is one of the words");
        *value
    })
}

impl RunnerArguments {
    /// What a process does as its flags and ROS 2 have it.
    pub fn new(flags: Flags, environment: &Environment) -> Result<Self, RunnerArgumentsError> {
        let mut ros = RosArgs::parse(&flags.network.ros_args, environment)
            .map_err(NodeArgumentsError::from)?;
        ros.check_rules(&[NODE], TopicRules::Refused).map_err(NodeArgumentsError::from)?;
        let (namespace, _) = ros.node("/", NODE);
        if namespace != "/" {
            return Err(RunnerArgumentsError::Namespace { namespace });
        }
        let network = ros.network(&flags.network.interface, environment, Member::Runner);
        Ok(Self {
            request: Request {
                experiment: flags.experiment,
                cell: flags.cell,
                from: flags.from,
                backend: flags.backend,
                bag: flags.output,
                seed: None,
                place_check: PlaceCheck::On,
                other_profile: OtherProfile::Refused,
            },
            session: network.map_err(NodeArgumentsError::from)?,
            log_level: ros.log_level(NODE),
            ros,
        })
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    fn parse(arguments: &[&str]) -> Result<RunnerArguments, RunnerArgumentsError> {
        let flags = Flags::try_parse_from(["runner"].iter().chain(arguments)).unwrap();
        let environment = Environment::new(&[("RSRS_INTERFACE", "127.0.0.1")], |_| {
            Err(std::io::ErrorKind::NotFound.into())
        });
        RunnerArguments::new(flags, &environment)
    }

    #[test]
    fn a_cell_and_a_backend_are_understood() {
        let cell = "speed_m_s=0.15,turn_rate_rad_s=0.75,robots=9";

        let options =
            parse(&["--experiment", "e.yaml", "--cell", cell, "--backend", "sim"]).unwrap();

        assert_eq!(options.request.cell, Some(cell.parse().unwrap()));
        assert_eq!(options.request.backend, Backend::Simulator);
        assert_eq!(parse(&["--experiment", "e.yaml"]).unwrap().request.backend, Backend::Fleet);
        let gazebo = ["runner", "--experiment", "e.yaml", "--backend", "gazebo"];
        assert!(Flags::try_parse_from(gazebo).is_err());
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
        let error = Flags::try_parse_from(["runner"]).unwrap_err().to_string();
        assert!(error.contains("--experiment <FILE>"), "{error}");
    }
}
