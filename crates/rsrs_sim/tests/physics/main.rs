//! The physics of the world, from outside: geometry, tables of an independent implementation, and
//! another group's simulator.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts of robots, steps and runs stand in the tables as numbers"
)]

mod clustering;
mod gathering;
mod measured;
mod mills;
mod neutral;
mod ring;
mod segregation;
mod support;
mod swarms;
mod swarmsim;
mod tables;
mod ternary;
