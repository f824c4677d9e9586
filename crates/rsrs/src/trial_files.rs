//! Tables of trials: read from a person's files.

use std::path::{Path, PathBuf};

use rsrs_core::trial::{DrivenTrial, TrialError, driven_trials};

use crate::bag_trials::{self, is_bag};
use crate::failure::explained;
use crate::files::read_text;

/// Reads one table.
///
/// # Errors
///
/// If the file cannot be read or is not such a table, with file and line.
pub fn table<T>(
    path: &Path,
    parse: impl Fn(&str, &str) -> Result<T, TrialError>,
) -> anyhow::Result<T> {
    let name = path.display().to_string();
    let text = read_text(path)?;
    parse(&name, &text).map_err(|error| {
        let (message, help) = (error.to_string(), error.help());
        explained(error, message, help.as_deref())
    })
}

/// Reads trajectories from all tables and bags, one after the other.
///
/// # Errors
///
/// As [`table`] and [`bag_trials::read`].
pub fn trajectories(paths: &[PathBuf]) -> anyhow::Result<Vec<DrivenTrial>> {
    let mut trials = Vec::new();
    for path in paths {
        if is_bag(path) {
            trials.extend(bag_trials::read(path)?.driven);
        } else {
            trials.extend(table(path, driven_trials)?);
        }
    }
    Ok(trials)
}
