//! The laws of the simulator, from outside.

mod acceptance;
mod batch;
mod support;
mod sweep;
mod theory;
mod world;
