//! The simulator node as a process, over real DDS in a network of its own.

#[path = "../../../nodes/ros/tests/support/mod.rs"]
mod support;

mod by_hand;
mod fleet;
mod lockstep;
mod mixed;
mod real_time;
mod status;
mod viewers;
