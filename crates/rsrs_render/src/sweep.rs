//! The report on a finished sweep.

use std::path::{Path, PathBuf};

use rsrs_core::diagram::adaptive::Knowledge;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::numerals::counted;
use rsrs_pipeline::compare::prediction::choose_line;
use rsrs_pipeline::execution::Execution;
use rsrs_pipeline::sweep::ablation::{Ablation, of_barren_sweep};
use rsrs_pipeline::sweep::knowledge;
use rsrs_pipeline::sweep::result::SweepResult;
use rsrs_pipeline::sweep::settling::{Unsettled, at_edge};
use serde::Serialize;

use crate::{factors, settling};

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
    unsettled_edge: Vec<Unsettled>,
    /// Which factors make the best cell worse; not there if some cell mills in most runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    factors: Option<Ablation>,
    /// Cells at the edge.
    #[serde(skip)]
    n_edge: usize,
    #[serde(skip)]
    behaviour: Behaviour,
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
    /// Reports a finished sweep, after a look at what it cannot show by itself: whether its edge is settled,
    /// and which factors keep a swarm that nowhere does what is wanted from it.
    pub fn new(
        folder: &Path,
        result: &SweepResult,
        execution: Execution<'_>,
    ) -> anyhow::Result<Self> {
        let sweep = &result.source.sweep;
        let (n_edge, unsettled_edge) = at_edge(result, execution)?;
        let factors = of_barren_sweep(result, execution)?;
        let runs = || result.diagram.cells.iter().map(|entry| PhaseCounts::total(&entry.counts));
        Ok(Self {
            folder: folder.to_path_buf(),
            cells: result.diagram.cells.len(),
            replicates: sweep.replicates,
            runs: runs().sum(),
            phases: result.diagram.majorities(),
            adaptive: endings(result),
            unsettled_edge,
            factors,
            n_edge,
            behaviour: sweep.behaviour.known(),
            duration_s: sweep.duration_s,
            runs_of_a_cell: (runs().min().unwrap_or(0), runs().max().unwrap_or(0)),
        })
    }

    /// That cells at the edge are not settled, where some are.
    pub fn warning(&self) -> Option<String> {
        settling::warning((&self.folder, self.behaviour), self.n_edge, &self.unsettled_edge)
    }
}

/// What came out, where it is, and what comes next.
pub fn text(report: &SweepReport) -> String {
    let SweepReport { cells, replicates, runs, duration_s, runs_of_a_cell: (least, most), .. } =
        report;
    let replicates = match &report.adaptive {
        None => format!("{replicates} replicates of {duration_s} s"),
        Some(Endings { settled, narrow, exhausted }) => format!(
            "{least} to {most} replicates of {duration_s} s, {runs} in all ({settled} cells settled, \
             {narrow} narrow, {exhausted} at the most)"
        ),
    };
    let folder = report.folder.display();
    let mut lines = vec![
        format!("{} × {replicates}: {}", counted(*cells as u64, "cell"), in_words(&report.phases)),
        format!("{folder}/diagram.svg"),
        format!("{folder}/cells.csv"),
        format!("{folder}/replicates.parquet"),
    ];
    lines.extend(report.factors.as_ref().and_then(factors::shown));
    lines.push(format!("next: {}", choose_line(&report.folder)));
    lines.join("\n")
}

/// One shard of a sweep.
#[derive(Clone, Debug, Serialize)]
pub struct ShardReport {
    /// Where it is.
    pub folder: PathBuf,
    /// Which one it is: `1/2`.
    pub shard: String,
    /// Replicates of this shard; `None` where the folder holds the whole sweep.
    pub runs: Option<u64>,
}

/// How many replicates it has, and what comes next.
pub fn of_shard(report: &ShardReport) -> String {
    let folder = report.folder.display();
    match report.runs {
        Some(runs) => format!(
            "shard {}: {}\nnext, with all shards in one place: rsrs merge {folder} … -o DIR",
            report.shard,
            counted(runs, "run")
        ),
        None => format!("{folder} holds the whole sweep; no shard was needed"),
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
