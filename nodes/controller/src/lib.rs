//! The controller node: detection in, velocity command out.
//!
//! One process hosts the controllers of one robot or of many: each is a node `/<robot>/controller`
//! with its own parameters, all on one participant; [`serve`] hosts them on somebody else's. What a controller does is decided by
//! [`rsrs_fleet::controller`]; here samples and timers become its events.

mod driver;
mod parameters;
mod sight;

pub use driver::{Hosting, serve};
pub use parameters::{LEASE, LEASE_CONTROLLER, LEASE_GATE, NAMES, NODE};

use anyhow::Context;
use rsrs_ros::node_arguments::{self, NodeArguments};
use rsrs_ros::ros_args::{Environment, TopicRules};

/// The node of each robot, whose topics may have other names.
const NODES: (&[&str], TopicRules) = (&[NODE], TopicRules::Followed);

/// What the node says of itself.
const HELP: &str = "\
Decides what a robot does: detections in, velocity commands out.

Usage: controller_node [--robots NAME,...] [--interface NAME|IP] [--ros-args ...]

  --robots NAME,...     whose controllers to be; without it the namespace (-r __ns:=/robot_1) names one
  -p lease:=controller  (behind --ros-args) for robots that have no gate of ours in front of their
                        wheels: the controller holds the lease, and sends zero when it ends
";

/// Runs the node until SIGINT or SIGTERM.
///
/// # Arguments
///
/// * `arguments` — those of the process, without its name: `[--interface NAME|IP]
///   [--robots NAME,…] [--ros-args …]`. Without `--robots` the namespace (`-r __ns:=/robot_1`) names
///   the one robot.
///
/// # Errors
///
/// If the arguments are wrong, no interface is chosen, or the network cannot be used.
pub fn main(arguments: &[String]) -> anyhow::Result<()> {
    if node_arguments::has_helped(arguments, HELP)? {
        return Ok(());
    }
    let options = NodeArguments::parse(arguments, &Environment::of_this_process(), NODES)?;
    options.ros.start_logging(options.log_level);
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .context("starting the runtime")?
        .block_on(driver::run(options))
}
