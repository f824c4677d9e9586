//! Tables of trials: read from a person's files.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::trial::{DrivenTrial, TrialError, driven_trials};

use crate::bag_trials::{self, is_bag};
use crate::failure::explained;

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
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
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

/// Files as one source: all names of a few, the first of many.
pub fn names(paths: &[&PathBuf]) -> String {
    let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    match &names[..] {
        [first, .., last] if names.len() > 3 => {
            format!("{first} to {last} ({} files)", names.len())
        }
        _ => names.join(", "),
    }
}
