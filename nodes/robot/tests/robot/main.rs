//! The robot node and its drivers, against hardware and a fleet that misbehave.

mod drivers;
mod floor;
mod line_fuzz;
mod memory;
mod micro;
mod parameters;
mod safety;
mod serial;
