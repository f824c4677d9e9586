//! The report on a finished sweep.

use std::fmt;
use std::path::{Path, PathBuf};

use rsrs_core::diagram::adaptive::Knowledge;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use serde::Serialize;

use rsrs_pipeline::sweep::ablation::Ablation;
use rsrs_pipeline::sweep::knowledge;
use rsrs_pipeline::sweep::result::SweepResult;
use rsrs_pipeline::sweep::settling::Unsettled;
use rsrs_pipeline::wording::shell::quoted;

/// A finished sweep.
#[derive(Clone, Debug, Serialize)]
pub struct SweepReport {
    folder: PathBuf,
    cells: usize,
    /// Of each cell; of an adaptive sweep, those it begins with.
    replicates: u64,
    /// Replicates of all cells.
    runs: u64,
    phases: Vec<(Phase, usize)>,
    /// How cells ended, of an adaptive sweep.
    #[serde(skip_serializing_if = "Option::is_none")]
    adaptive: Option<Endings>,
    /// Cells at the edge of the milling region whose runs were not given enough time.
    pub unsettled_edge: Vec<Unsettled>,
    /// Which factors make the best cell worse; not there if some cell mills in most runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub factors: Option<Ablation>,
    /// Of each run, in seconds.
    #[serde(skip)]
    duration_s: f64,
    /// The fewest and the most replicates of a cell.
    #[serde(skip)]
    runs_of_a_cell: (u64, u64),
}

/// How many cells of an adaptive sweep ended how.
#[derive(Clone, Copy, Debug, Serialize)]
struct Endings {
    settled: usize,
    narrow: usize,
    exhausted: usize,
}

impl SweepReport {
    /// Reports a finished sweep.
    ///
    /// # Arguments
    ///
    /// * `folder` — where it is.
    pub fn of(folder: &Path, result: &SweepResult) -> Self {
        let sweep = &result.source.sweep;
        let runs = || result.diagram.cells.iter().map(|entry| PhaseCounts::total(&entry.counts));
        Self {
            folder: folder.to_path_buf(),
            cells: result.diagram.cells.len(),
            replicates: sweep.replicates,
            runs: runs().sum(),
            phases: result.diagram.majorities(),
            adaptive: endings(result),
            unsettled_edge: Vec::new(),
            factors: None,
            duration_s: sweep.duration_s,
            runs_of_a_cell: (runs().min().unwrap_or(0), runs().max().unwrap_or(0)),
        }
    }
}

impl fmt::Display for SweepReport {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} cells × ", self.cells)?;
        match &self.adaptive {
            None => write!(out, "{} replicates of {} s", self.replicates, self.duration_s)?,
            Some(Endings { settled, narrow, exhausted }) => write!(
                out,
                "{} to {} replicates of {} s, {} in all ({settled} cells settled, {narrow} narrow, \
                 {exhausted} at the most)",
                self.runs_of_a_cell.0, self.runs_of_a_cell.1, self.duration_s, self.runs
            )?,
        }
        let folder = self.folder.display();
        let next = format!(
            "rsrs choose {} -o {}",
            quoted(&self.folder),
            quoted(self.folder.join("choice.json"))
        );
        let factors = self.factors.as_ref().map(|factors| format!("{}\n", factors.in_words()));
        write!(
            out,
            ": {}\n{folder}/diagram.svg\n{folder}/cells.csv\n{folder}/replicates.parquet\n\
             {}next: {next}",
            in_words(&self.phases),
            factors.unwrap_or_default()
        )
    }
}

/// How many cells have which phase: `54 stable milling, 3 dispersion`.
pub fn in_words(phases: &[(Phase, usize)]) -> String {
    let found = phases.iter().filter(|(_, n)| *n > 0);
    let words: Vec<String> = found.map(|(phase, n)| format!("{n} {phase}")).collect();
    words.join(", ")
}

fn endings(result: &SweepResult) -> Option<Endings> {
    let knowledge = knowledge(result)?;
    let n = |sought| knowledge.iter().filter(|found| **found == sought).count();
    Some(Endings {
        settled: n(Knowledge::Settled),
        narrow: n(Knowledge::Narrow),
        exhausted: n(Knowledge::Exhausted),
    })
}
