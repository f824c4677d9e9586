//! The robot node and its drivers, against hardware and a fleet that misbehave.

mod drivers;
mod line_fuzz;
mod memory;
mod micro;
mod parameters;
mod rest_of_fleet;
mod safety;
mod serial;
