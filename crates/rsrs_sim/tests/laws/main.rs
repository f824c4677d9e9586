//! The laws of the simulator, from outside.

mod acceptance;
mod arenas;
mod batch;
mod blocks;
mod classes;
mod contact;
mod controlled;
mod controllers;
mod failures;
mod few;
mod golden;
mod kinds;
mod objects;
mod plausibility;
mod sensors;
mod support;
mod sweep;
mod world;
mod worlds;
