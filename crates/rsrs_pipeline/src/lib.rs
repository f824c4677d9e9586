#![doc = include_str!("../README.md")]
//! # Modules
//!
//! [`measure`] makes trials and fits a profile to them, [`validate`] asks whether real robots stay in
//! the simulated reach, [`sweep`] simulates a phase diagram, [`choose`] confirms its most robust cell,
//! [`diagnose`] names what to change where there is none,
//! [`campaign`] reads and keeps what experiments over ROS 2 leave, [`label`] names the phase of a bag,
//! [`compare`] tests `B_r(E) ≥ B_s(E)`; [`episode`] and [`replay`] go back to single runs.
//!
//! Who watches simulations is an [`execution::Observer`], of which one does nothing. Errors are `anyhow`'s,
//! and [`error::help_of`] is the command to type next.

pub mod answer;
pub mod attempt;
mod best_setting;
pub mod campaign;
pub mod choose;
pub mod compare;
pub mod diagnose;
pub mod diff;
pub mod episode;
pub mod error;
pub mod execution;
pub mod explore;
pub mod files;
pub mod init;
pub mod label;
pub mod measure;
pub mod plan_experiments;
pub mod provenance;
pub mod recorded_run;
pub mod replay;
pub mod run_summary;
pub mod schema;
pub mod swarm;
pub mod sweep;
pub mod validate;
