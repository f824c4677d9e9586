//! The network in which robots are.

use rsrs_ros::interfaces;
use rsrs_ros::ros_args::{Environment, RosArgs};
use rsrs_ros::session::SessionOptions;

use crate::failure::with_help;

/// The network that a person has chosen, by `--interface` or the environment.
///
/// # Errors
///
/// If none is chosen, or there is none of that name or address.
pub fn chosen_network(interface: Option<&str>) -> anyhow::Result<SessionOptions> {
    let variable = std::env::var(interfaces::VARIABLE).ok();
    let address = interfaces::chosen(interface, variable.as_deref())
        .map_err(|error| with_help(error.to_string(), error.help()))?;
    let environment = Environment::of_this_process();
    let (ros, _) = RosArgs::parse(&[], &environment)?;
    Ok(SessionOptions { domain_id: ros.domain_id, interfaces: vec![address] })
}
