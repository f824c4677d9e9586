//! The files by which the next experiment is run.

use std::path::{Path, PathBuf};

use rsrs_core::diagram::sweep_file::SEED_LIMIT;
use rsrs_fleet::experiment::ExperimentFile;
use rsrs_fleet::record::Backend;

use super::run_matching::Admitted;
use crate::files::experiment_file_beside;

/// What the next experiment takes.
#[derive(Clone, Debug)]
pub struct AtHand {
    /// The experiment file; `None` if that of the runs is not known.
    pub experiment: Option<PathBuf>,
    /// The folder of the sweep.
    pub sweep: PathBuf,
    /// Whether runs were on the floor.
    pub is_on_floor: bool,
    /// The next seed in the simulator, as the same one is the same run; `None` if there is no run.
    pub seed: Option<u64>,
    /// A folder for the bag that is not there yet.
    pub bag: PathBuf,
}

impl AtHand {
    /// That of a sweep, with the experiment file that lies beside it, if one does and has the
    /// duration of all runs.
    ///
    /// # Panics
    ///
    /// Never: there are more numbers than folders.
    pub fn new(sweep: &Path, all: &[Admitted]) -> Self {
        let is_theirs = |path: &PathBuf| {
            let text = rsrs_files::read_text(path).unwrap_or_default();
            let lasts = |duration_s: f64| {
                all.iter().all(|run| run.record.duration_s.total_cmp(&duration_s).is_eq())
            };
            ExperimentFile::parse("", &text).is_ok_and(|file| lasts(file.duration_s))
        };
        let last = all.iter().map(|run| run.record.seed).max();
        let mut names = (1 + all.len()..).map(|number| PathBuf::from(format!("run_{number}")));
        Self {
            experiment: experiment_file_beside(sweep).filter(is_theirs),
            sweep: sweep.to_path_buf(),
            is_on_floor: all.iter().any(|run| run.record.backend != Backend::Simulator),
            seed: last.map(|last| last.saturating_add(1) % SEED_LIMIT),
            bag: names.find(|bag| !bag.exists()).expect("there are more numbers than folders"),
        }
    }
}
