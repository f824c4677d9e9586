//! The controller node: detection in, velocity command out.
//!
//! One process hosts the controllers of one robot or of many: each is a node `/<robot>/controller`
//! with its own parameters, all on one participant; [`serve`] hosts them on that of the caller.
//! What a controller does is decided by [`rsrs_fleet::controller`]; here samples and timers become
//! its events.

mod event_loop;
mod parameters;
mod virtual_detection;

pub use event_loop::{Hosting, serve};
pub use parameters::names;
pub use rsrs_fleet::parameters::controller::NODE;

use rsrs_ros::node_arguments::{AFTER_HELP, NodeFlags, Part, Program, run};
use rsrs_ros::ros_args::TopicRules;

/// Decides what a robot does: detections in, velocity commands out.
///
/// For robots that have no gate of ours in front of their wheels, `-p lease:=controller` (behind
/// `--ros-args`): the controller holds the lease, and publishes zero when it ends.
#[derive(clap::Parser)]
#[command(name = "controller_node", max_term_width = 100, after_help = AFTER_HELP)]
struct Flags {
    #[command(flatten)]
    node: NodeFlags,
}

/// Runs the node until SIGINT or SIGTERM, by the arguments of the process, without its name:
/// `[--interface NAME|IP] [--robots NAME,…] [--ros-args …]`.
///
/// Without `--robots` the namespace (`-r __ns:=/robot_1`) names the one robot.
pub fn main(arguments: &[String]) -> anyhow::Result<()> {
    let program = Program { nodes: &[NODE], topics: TopicRules::Followed, part: Part::Robot };
    run(program, arguments, |Flags { node }| node, event_loop::run)
}
