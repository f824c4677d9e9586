//! `rsrs node`: one binary is the whole fleet.

use crate::failure::Outcome;

/// Run a ROS 2 node until SIGINT or SIGTERM.
///
/// Nodes take `--interface NAME|IP` (or `RSRS_INTERFACE`), `--robots NAME,…`, and `--ros-args` as in
/// ROS 2.
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

// The nodes answer `--help` themselves, as they do when ROS 2 starts them.
#[derive(clap::Subcommand)]
enum Node {
    /// A robot: its sensor, its wheels behind the final gate, and its controller.
    #[command(disable_help_flag = true)]
    Robot(Rest),
    /// Detections in, velocity commands out.
    #[command(disable_help_flag = true)]
    Controller(Rest),
    /// The world behind the topics of a fleet.
    #[command(disable_help_flag = true)]
    Sim(Rest),
    /// One experiment: preflight, parameters, leases and the bag.
    #[command(disable_help_flag = true)]
    Runner(Rest),
}

#[derive(clap::Args)]
struct Rest {
    /// Its arguments: see `--help` of the node.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    arguments: Vec<String>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    if let Some(parent) = arguments.parent {
        rsrs_ros::shutdown::die_with_parent(parent)?;
    }
    // A run is nothing that may begin a second time.
    if !matches!(arguments.node, Node::Runner(_)) {
        rsrs_ros::session::start_again_after_deadlock();
    }
    match &arguments.node {
        Node::Robot(rest) => rsrs_robot_node::main(&rest.arguments)?,
        Node::Controller(rest) => rsrs_controller_node::main(&rest.arguments)?,
        Node::Sim(rest) => rsrs_sim_node::main(&rest.arguments)?,
        Node::Runner(rest) => rsrs_experiment_runner::main(&rest.arguments)?,
    }
    Ok(Outcome::Done)
}
