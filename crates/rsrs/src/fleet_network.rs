//! The network in which robots are.

use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::Backend;
use rsrs_ros::environment::Environment;
use rsrs_ros::logging::{self, Level};
use rsrs_ros::network::NetworkError;
use rsrs_ros::ros_args::{OtherMiddleware, RosArgs};
use rsrs_ros::security::Member;
use rsrs_ros::session::SessionOptions;

use crate::failure::bad_arguments;
use crate::notes::print_note;
use rsrs_operate::run::RunTarget;
use rsrs_operate::run::own_network::OwnNetwork;
use rsrs_pipeline::error::{helped, with_help};
use rsrs_render::own_network;

/// Where the robots are, as a person names it.
#[derive(clap::Args)]
pub struct InterfaceArguments {
    /// Network interface of the fleet, by name or address, more than once for several (or
    /// `RSRS_INTERFACE`, with commas between them).
    #[arg(long, value_name = "NAME|IP")]
    pub interface: Vec<String>,
}

/// Why robots may not be found although they run, where the environment shows it.
pub fn other_middleware() -> Option<OtherMiddleware> {
    OtherMiddleware::new(&Environment::of_this_process())
}

/// Refuses flags that say something of a fleet where the robots are simulated: who has forgotten
/// `--backend fleet` would take the run for one of the fleet.
pub fn refuse_flags_of_a_fleet(
    backend: Backend,
    network: &InterfaceArguments,
    place_command: Option<&str>,
    place_check: Option<PlaceCheck>,
) -> anyhow::Result<()> {
    let flags = [
        ("--interface", !network.interface.is_empty()),
        ("--place-command", place_command.is_some()),
        ("--place-check", place_check.is_some()),
    ];
    let given = flags.iter().find(|(_, is_given)| *is_given && backend == Backend::Simulator);
    given.map_or(Ok(()), |(flag, _)| {
        Err(bad_arguments(with_help(
            format!("`{flag}` is for a fleet, and these robots are simulated"),
            "for the fleet: `--backend fleet --interface NAME`; else leave it out",
        )))
    })
}

/// Enters the network of the robots of a run; to be called before the first thread is started.
pub fn enter(backend: Backend, interfaces: &[String]) -> anyhow::Result<RunTarget> {
    logging::init(Level::Warn);
    Ok(match backend {
        Backend::Simulator => {
            let network = OwnNetwork::enter()?;
            print_note(own_network::text(&network.isolation));
            RunTarget::Simulator(network)
        }
        Backend::Fleet | Backend::Mixed => {
            RunTarget::Fleet(chosen_network(interfaces, Member::Runner)?)
        }
    })
}

/// The network that a person has chosen, by `--interface` or the environment, in the enclave of
/// `member` where none is named.
///
/// What the environment makes of the choice is printed, such as `ROS_LOCALHOST_ONLY`, which keeps
/// this program on this machine, or whether it is secured.
pub fn chosen_network(interfaces: &[String], member: Member<'_>) -> anyhow::Result<SessionOptions> {
    let environment = Environment::of_this_process();
    let mut ros = RosArgs::parse(&[], &environment)?;
    let network = ros.network(interfaces, &environment, member).map_err(|error| {
        let is_typed = matches!(error, NetworkError::Interface(_));
        let error = helped(error);
        if is_typed { bad_arguments(error) } else { error }
    })?;
    for note in &ros.notes {
        print_note(note.to_string());
    }
    Ok(network)
}
