//! `rsrs node`: one binary is the whole fleet.

use clap::ValueEnum;

use crate::failure::Outcome;

/// Run a ROS 2 node until SIGINT or SIGTERM.
///
/// Nodes take `--interface NAME|IP` (or `RSRS_INTERFACE`), `--robots NAME,…`, and `--ros-args` as in
/// ROS 2.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs node controller --interface wlan0 --ros-args -r __ns:=/robot_3 -p speed:=0.15
  rsrs node sim --interface 127.0.0.1 --robots robot_1,robot_2")]
pub struct Arguments {
    /// Which node.
    #[arg(value_enum)]
    node: Node,
    /// Its arguments.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    arguments: Vec<String>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Node {
    /// Detections in, velocity commands out.
    Controller,
    /// The world behind the topics of a fleet, in lockstep.
    Sim,
}

/// Runs the command.
///
/// # Errors
///
/// If the arguments are wrong, no interface is chosen, or the network cannot be used.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    match arguments.node {
        Node::Controller => rsrs_controller_node::main(&arguments.arguments)?,
        Node::Sim => rsrs_sim_node::main(&arguments.arguments)?,
    }
    Ok(Outcome::Done)
}
