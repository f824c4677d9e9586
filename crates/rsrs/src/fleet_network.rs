//! The network in which robots are.

use rsrs_ros::environment::Environment;
use rsrs_ros::network::NetworkError;
use rsrs_ros::ros_args::{OtherMiddleware, RosArgs};
use rsrs_ros::security::Member;
use rsrs_ros::session::SessionOptions;

use crate::failure::bad_arguments;
use crate::notes::print_note;
use rsrs_pipeline::error::helped;

/// Why robots may not be found although they run, where the environment shows it.
pub fn other_middleware() -> Option<OtherMiddleware> {
    OtherMiddleware::of(&Environment::of_this_process())
}

/// The network that a person has chosen, by `--interface` or the environment, in the enclave of
/// `member` where none is named.
///
/// What the environment makes of the choice is printed, such as `ROS_LOCALHOST_ONLY`, which keeps
/// this program on this machine, or whether it is secured.
pub fn chosen_network(interfaces: &[String], member: Member<'_>) -> anyhow::Result<SessionOptions> {
    let environment = Environment::of_this_process();
    let (mut ros, _) = RosArgs::parse(&[], &environment)?;
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
