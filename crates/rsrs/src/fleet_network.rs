//! The network in which robots are.

use rsrs_ros::ros_args::{Environment, RosArgs};
use rsrs_ros::session::SessionOptions;

use crate::notes::print_note;
use rsrs_pipeline::error::helped;

/// The network that a person has chosen, by `--interface` or the environment.
///
/// What the environment makes of the choice is printed, such as `ROS_LOCALHOST_ONLY`, which keeps
/// this program on this machine.
///
/// # Errors
///
/// If none is chosen, or there is none of that name or address.
pub fn chosen_network(interface: Option<&str>) -> anyhow::Result<SessionOptions> {
    let environment = Environment::of_this_process();
    let (mut ros, _) = RosArgs::parse(&[], &environment)?;
    let network = ros.network(interface, &environment).map_err(helped)?;
    for note in &ros.notes {
        print_note(&note.to_string());
    }
    Ok(network)
}
