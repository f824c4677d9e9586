#![doc = include_str!("../README.md")]
//! # Modules
//!
//! A room for each step, in reading order:
//!
//! - [`robot`]: what it is, how it is made worse and whether it is, and what it does with what it sees;
//! - [`quantity`]: what of it, and of an experiment, a sweep can vary: one table;
//! - [`world`]: what is in the arena besides robots;
//! - [`trials`]: how it is measured, and whether the simulator agrees with the trials;
//! - [`conditions`]: everything that an outcome may depend on, the paper's `E`;
//! - [`judge`]: what a swarm did, which phase that is, how sure that is and which judges agree;
//! - [`exploration`]: what a search for controllers follows from;
//! - [`diagram`]: the cells that a sweep file spans, how often each ended in each phase, what geometry
//!   expects of them, and which of them to run;
//! - [`tracker`]: how a tracker publishes where robots are, and what that is on the floor;
//! - [`comparison`]: reality against the simulator, and how many runs that takes;
//! - [`capability`]: whether simulated robots are at most as capable as the measured ones;
//! - [`statistics`]: how sure shares and spreads are.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts and steps are floats only where values of any axis are; they are checked before"
)]
#![expect(
    clippy::missing_panics_doc,
    reason = "the texts of `expect` are invariants; what can happen is documented"
)]
#![expect(
    clippy::result_large_err,
    reason = "errors of documents are made once and printed; boxes would hide their fields"
)]

pub mod capability;
pub mod comparison;
pub mod conditions;
pub mod diagram;
pub mod exploration;
pub mod judge;
pub mod natural_order;
pub mod quantity;
pub mod robot;
pub mod statistics;
pub mod tracker;
pub mod trials;
pub mod world;

pub mod bounds;
pub mod digest;
pub mod document;
pub mod draw;
pub mod help;
pub mod numerals;
pub mod out_of_range;
pub mod plane;
pub mod printable;
pub mod program;
