//! Tables of trials: read from a person's files.

use std::path::{Path, PathBuf};

use rsrs_core::trials::trial::{DrivenTrial, MovedBy, TrialBackend, TrialError, driven_trials};

use crate::error::helped;
use crate::files::read_text;
use crate::measure::bag_trials::{self, is_bag};

/// Reads one table.
pub fn table<T>(
    path: &Path,
    parse: impl Fn(&str, &str) -> Result<T, TrialError>,
) -> anyhow::Result<T> {
    let name = path.display().to_string();
    let text = read_text(path)?;
    parse(&name, &text).map_err(helped)
}

/// Trajectories of all tables and bags.
#[derive(Clone, Debug, Default)]
pub struct Trajectories {
    /// While the robots were going.
    pub driven: Vec<DrivenTrial>,
    /// From their standstills.
    pub from_rest: Vec<DrivenTrial>,
    /// What moved the robots.
    pub moved_by: MovedBy,
    /// Bags in which the simulator moved them.
    pub simulated: Vec<PathBuf>,
}

/// Reads trajectories from all tables and bags, one after the other. Of bags with several classes
/// of robots, `class` selects whose trials are wanted; who drove in a table is not known.
pub fn trajectories(paths: &[PathBuf], class: Option<&str>) -> anyhow::Result<Trajectories> {
    let mut found = Trajectories::default();
    for path in paths {
        if is_bag(path) {
            let trials = bag_trials::read(path, class)?;
            found.moved_by = found.moved_by + MovedBy::all(trials.backend, trials.driven.len());
            if trials.backend == Some(TrialBackend::Simulator) {
                found.simulated.push(path.clone());
            }
            found.driven.extend(trials.driven);
            found.from_rest.extend(trials.from_rest);
        } else {
            let trials = table(path, driven_trials)?;
            found.moved_by = found.moved_by + MovedBy::all(None, trials.len());
            found.from_rest.extend(trials.iter().cloned());
            found.driven.extend(trials);
        }
    }
    Ok(found)
}
