//! The robot node: a sensor's readings to detections, velocity commands to wheels.
//!
//! One process on each robot is the node `/<robot>/robot`, which owns the hardware behind the final
//! gate ([`rsrs_fleet::robot`]), and the node `/<robot>/controller`
//! ([`rsrs_controller_node`]), both on one participant. The hardware is behind one trait
//! ([`driver::Driver`]); which of its implementors is used is set on the command line or in the
//! fleet file.
//!
//! Wheels stop when commands are stale or beyond the limits, the lease has run out, the e-stop is
//! on, or the driver fails; and when this process dies or its machine is unplugged, because the
//! microcontroller (or the foreign base driver) has a timeout of its own.

mod arguments;
mod declared;
mod diagnostics;
pub mod driver;
mod further_readings;
mod listening;
mod node;
mod parameters;
mod publishers;

pub use arguments::{ArgumentsError, Flags, RobotArguments};
pub use rsrs_fleet::parameters::gate::NODE;

use rsrs_ros::environment::Environment;
use rsrs_ros::runtime::runtime;

/// Runs the node until SIGINT or SIGTERM; the wheels stop first.
///
/// Hardware that does not answer is no error: the node logs it and keeps trying.
pub fn main(flags: Flags) -> anyhow::Result<()> {
    let options = RobotArguments::new(flags, &Environment::of_this_process())?;
    options.node.ros.start_logging(options.node.log_level);
    runtime()?.block_on(node::run(options))
}
