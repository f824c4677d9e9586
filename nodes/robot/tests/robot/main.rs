//! The robot node and its drivers, against hardware and a fleet that misbehave.

mod drivers;
mod line_fuzz;
mod memory;
mod micro;
mod parameters;
mod rest_of_fleet;
mod safety;
mod serial;

/// The robot's node, where it is a process of its own.
#[test]
fn node() {
    rsrs_testing::network::run_node(rsrs_robot_node::main);
}
