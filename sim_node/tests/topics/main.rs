//! The simulator node as a process, over real DDS in a network of its own.

#[expect(dead_code, reason = "the example that it belongs to measures time, too")]
#[path = "../../examples/scale/fleet_runner.rs"]
mod fleet_runner;

mod fleet;
mod lockstep;
mod manual_control;
mod mixed;
mod real_time;
mod scale;
mod status;
mod viewers;

/// The simulator's node, where it is a process of its own.
#[test]
fn node() {
    rsrs_testing::network::run_node(rsrs_sim_node::main);
}
