//! Bags as they are written, damaged, converted and read: by us and by others.

mod bad_input;
mod clocks;
mod crash;
mod definitions;
mod foreign;
mod fuzz;
mod integrity;
mod packing;
mod recording;
mod recovery;
mod round_trip;
mod tools;
mod trackers;
mod trajectories;
mod trajectory_repair;
mod variations;
mod versions;
