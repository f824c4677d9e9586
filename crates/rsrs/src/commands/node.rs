//! `rsrs node`: one binary is the whole fleet.

use crate::failure::Outcome;

/// Run a ROS 2 node until SIGINT or SIGTERM.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs node robot --interface wlan0 --robots robot_3 --config fleet.yaml
  rsrs node controller --interface wlan0 --ros-args -r __ns:=/robot_3 -p speed:=0.15
  rsrs node sim --interface 127.0.0.1 --robots robot_1,robot_2
  rsrs node runner --interface wlan0 --experiment milling.yaml")]
pub struct Arguments {
    /// Process that starts the node; the node ends with it.
    #[arg(long, value_name = "PID", hide = true)]
    parent: Option<u32>,
    /// Which node.
    #[command(subcommand)]
    node: Node,
}

#[derive(Clone, clap::Subcommand)]
enum Node {
    Robot(rsrs_robot_node::Flags),
    Controller(rsrs_controller_node::Flags),
    Sim(rsrs_sim_node::Flags),
    Runner(rsrs_experiment_runner::Flags),
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    if let Some(parent) = arguments.parent {
        rsrs_ros::shutdown::die_with_parent(parent)?;
    }
    // A run is nothing that may begin a second time.
    if !matches!(arguments.node, Node::Runner(_)) {
        rsrs_ros::session::start_again_after_deadlock();
    }
    match arguments.node.clone() {
        Node::Robot(flags) => rsrs_robot_node::main(flags)?,
        Node::Controller(flags) => rsrs_controller_node::main(flags)?,
        Node::Sim(flags) => rsrs_sim_node::main(flags)?,
        Node::Runner(flags) => rsrs_experiment_runner::main(flags)?,
    }
    Ok(Outcome::Done)
}
