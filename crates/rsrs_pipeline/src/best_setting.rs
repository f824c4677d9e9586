//! The setting in which a robot mills most often: which speed and turning rate, how many robots, and
//! how they are placed.

pub mod grid;
pub mod search;
mod settings;

use std::path::Path;

use anyhow::Context;
use rsrs_core::diagram::axis::Axis;
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_core::robot::harsher::Harsher;
use rsrs_core::robot::other_profile::{OtherProfile, ProfilesDiffer};
use rsrs_core::robot::profile::RobotProfile;

use crate::error::with_help;
use crate::execution::Execution;
use crate::sweep::folder;
use crate::sweep::source::{ResolvedSweep, read_profile};
use crate::wording::shell::quoted;
use grid::Grid;
use search::Search;

/// A robot, how it is made worse, and the settings in which it is given its chance.
pub struct Subject {
    /// The robot as measured.
    pub profile: RobotProfile,
    /// How it is made worse.
    pub harsher: Harsher,
    /// The settings.
    pub grid: Grid,
    /// That these are of a sweep of robots with another profile, on which somebody insists.
    pub other_profile: Option<ProfilesDiffer>,
}

impl Subject {
    /// Reads a robot from a profile, a sweep file or the folder of a sweep.
    ///
    /// # Arguments
    ///
    /// * `sweep`, `other_profile` — a sweep file or folder whose settings are tried instead, and what to do
    ///   if it is of robots with another profile.
    /// * `built_in` — the settings of a robot for which none are given.
    ///
    /// # Errors
    ///
    /// If a file is not what it should be, or a setting is beyond the robot's limits.
    pub fn read(
        path: &Path,
        (sweep, other_profile): (Option<&Path>, OtherProfile),
        built_in: fn(&RobotProfile) -> Grid,
    ) -> anyhow::Result<Self> {
        let of_path =
            if path.is_dir() { Some(folder::read(path)?.source) } else { sweep_at(path)? };
        let of_option = sweep.map(source_of).transpose()?;
        let (profile, source) = if let Some(source) = of_path {
            (source.profile.clone(), of_option.unwrap_or(source))
        } else {
            let profile = read_profile(path)?;
            let Some(source) = of_option else {
                let grid = built_in(&profile);
                return Ok(Self {
                    profile,
                    harsher: Harsher::default(),
                    grid,
                    other_profile: None,
                });
            };
            (profile, source)
        };
        let other_profile =
            other_profile.admit(&source.profile.digest(), &profile.digest()).map_err(|differ| {
                let help = ProfilesDiffer::help(&quoted(path));
                with_help(format!("{}: {differ}", sweep.unwrap_or(path).display()), help)
            })?;
        let (grid, capabilities) = Grid::of_sweep(&source.sweep);
        let profile = profile.with_capabilities(&capabilities)?;
        for cell in &grid.cells {
            let settings = grid.settings.with_cell(cell);
            let value = |wanted: Axis| {
                let mut values = settings.values.iter().rev();
                values.find(|(axis, _)| *axis == wanted).map_or(0.0, |(_, value)| *value)
            };
            let command = ControllerParameters::mirrored(value(Axis::Speed), value(Axis::TurnRate));
            profile.check_limits(command).with_context(|| format!("cell `{cell}`"))?;
        }
        Ok(Self { profile, harsher: source.sweep.harsher, grid, other_profile })
    }

    /// Looks for its best setting.
    ///
    /// # Arguments
    ///
    /// * `wanted`, `confirm`, `execution` — those of [`Search`].
    pub fn search<'a>(&'a self, wanted: f64, confirm: u64, execution: Execution<'a>) -> Search<'a> {
        let Self { profile, harsher, grid, .. } = self;
        Search { measured: profile, harsher: *harsher, grid, wanted, confirm, execution }
    }
}

fn source_of(path: &Path) -> anyhow::Result<ResolvedSweep> {
    if path.is_dir() { Ok(folder::read(path)?.source) } else { ResolvedSweep::read_either(path) }
}

/// The sweep that a file holds; `None` if it is none, as a profile is.
fn sweep_at(path: &Path) -> anyhow::Result<Option<ResolvedSweep>> {
    let text = crate::files::read_text(path)?;
    let is_sweep = |line: &str| line.starts_with("profile:") || line.starts_with("sweep:");
    if text.lines().any(is_sweep) {
        return ResolvedSweep::read_either(path).map(Some);
    }
    Ok(None)
}

/// The error that no setting can be simulated.
pub fn nowhere(path: &Path, search: &Search<'_>) -> anyhow::Error {
    let why = search.grid.cells.first().and_then(|cell| search.why_not(cell));
    with_help(
        format!(
            "{}: in none of {} settings can these robots be simulated{}",
            path.display(),
            search.grid.cells.len(),
            why.map_or_else(String::new, |why| format!(": {why}"))
        ),
        "name settings in which they can with `--sweep SWEEP`",
    )
}
