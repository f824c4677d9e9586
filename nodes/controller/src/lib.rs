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

use rsrs_ros::node_arguments::{NodeFlags, Part, Program, run};
use rsrs_ros::ros_args::TopicRules;

/// Detections in, velocity commands out.
///
/// For robots that have no gate of ours in front of their wheels, `-p lease:=controller` (behind
/// `--ros-args`): the controller holds the lease, and publishes zero when it ends.
#[derive(Clone, Debug, clap::Parser)]
pub struct Flags {
    #[command(flatten)]
    node: NodeFlags,
}

/// Runs the node until SIGINT or SIGTERM.
pub fn main(flags: Flags) -> anyhow::Result<()> {
    let program = Program { nodes: &[NODE], topics: TopicRules::Followed, part: Part::Robot };
    run(program, flags.node, event_loop::run)
}
