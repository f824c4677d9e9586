//! The steps from a measured robot to a verdict: one module for each arrow of the method, each one
//! function from files to files.
//!
//! [`measure`] makes trials and fits a profile to them, [`validate`] asks whether real robots stay in
//! the simulated reach, [`sweep`] simulates a phase diagram, [`choose`] confirms its most robust cell,
//! [`diagnose`] names what to change where there is none,
//! [`campaign`] reads and keeps what experiments over ROS 2 leave, [`label`] names the phase of a bag,
//! [`compare`] tests `B_r(E) ≥ B_s(E)`; [`episode`] and [`replay`] go back to single runs.
//!
//! A step parses no arguments, prints and draws nothing and needs no middleware: what people read of its
//! result, and pictures, are made by `rsrs_render`; what touches robots is `rsrs_operate`. Who watches
//! simulations is an [`execution::Observer`], of which one does nothing. Errors are `anyhow`'s, and [`error::help_of`] is the command to type next.
//!
//! # Examples
//!
//! `cargo run --release -p rsrs_pipeline --example sweep_and_choose -- SWEEP.yaml FOLDER` goes from a sweep file
//! to a chosen cell.
//!
//! From a sweep file to a labelled episode, in memory:
//!
//! ```
//! use std::path::Path;
//!
//! use rsrs_core::judge::phase::{Phase, label};
//! use rsrs_pipeline::sweep::source::ResolvedSweep;
//! use rsrs_sim::draw::Seed;
//! use rsrs_sim::episode::run_episode;
//!
//! # fn main() -> anyhow::Result<()> {
//! let sweep = Path::new("../../launch_configs/sweeps/flockbot_speed_turn.yaml");
//! let source = ResolvedSweep::read(sweep)?;
//! let wanted = "speed_m_s=0.15,turn_rate_rad_s=0.75".parse()?;
//! let cells = source.cells("the sweep")?;
//! let (_, conditions) =
//!     cells.iter().find(|(cell, _)| *cell == wanted).expect("the sweep has this cell");
//!
//! let seed = Seed { seed: source.sweep.seed, replicate: 0 };
//! let trajectory = run_episode(conditions, seed, source.sweep.duration_s)?;
//! let verdict = label(&trajectory, &conditions.bodies())?;
//!
//! assert_eq!(verdict.phase, Phase::STABLE_MILLING);
//! # Ok(())
//! # }
//! ```

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
pub mod schema;
pub mod swarm;
pub mod sweep;
pub mod validate;
