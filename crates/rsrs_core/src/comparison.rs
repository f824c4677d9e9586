//! Reality against the simulator: does `B_r(E) >= B_s(E)` hold?
//!
//! The inequality is tested, never assumed: a robot that is better in every capability does not
//! by itself mill more often.

pub mod experiment_plan;
pub mod fixed;
pub mod left_out;
pub mod next_experiment;

use serde::{Deserialize, Serialize};

use crate::judge::counts::PhaseCounts;
use crate::judge::phase::Phase;
use crate::quantity::Cell;
use crate::statistics::e_value::TestedCell;
use crate::statistics::interval::Interval;
use crate::statistics::pooled::{LogEvidence, Pooled, PooledTest, e_value};
use crate::statistics::share::Share;

/// What was counted in one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct CellRuns {
    /// The cell.
    pub cell: Cell,
    /// How its real runs ended.
    pub real: PhaseCounts,
    /// How its simulated replicates ended: of a chosen cell those of the confirmation.
    pub simulated: PhaseCounts,
    /// Its part of the error, fixed before the first run, and of what is bet on single cells; of all cells
    /// that may be run together at most 1.
    pub part: f64,
}

impl CellRuns {
    /// The cell as it is tested.
    fn tested(&self) -> TestedCell {
        TestedCell {
            real: Share::milling(&self.real),
            simulated: Share::milling(&self.simulated),
            part: self.part,
        }
    }
}

/// The evidence of the runs on `eq:finalgap`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// In at least one of the cells, reality mills less often than the simulator.
    Violated,
    /// Averaged over the runs, reality mills at least as often as the simulator, or less often by at
    /// most the margin.
    Supported,
    /// The runs do not decide yet.
    Undecided,
    /// Nothing is claimed: simulated robots may mill so seldom that real ones cannot fall short by the margin.
    NoClaim,
}

/// One cell, compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellComparison {
    /// The cell.
    pub cell: Cell,
    /// Real runs that milled.
    pub real: Share,
    /// Interval of `B_r`.
    pub real_interval: Interval,
    /// Simulated replicates that milled.
    pub simulated: Share,
    /// Interval of `B_s`.
    pub simulated_interval: Interval,
    /// Its part of the error.
    pub part: f64,
    /// Evidence that `B_r < B_s` here, however often one looked.
    pub e_violated: f64,
    /// Evidence that `B_r >= B_s - margin` here, however often one looked; `None` if nothing is claimed.
    pub e_supported: Option<f64>,
    /// What follows for this cell; violated only if all cells together are.
    pub verdict: Verdict,
    /// If undecided: how many further real runs would support the inequality here if all of them mill;
    /// `None` also if [`MOST_RUNS`] would not.
    pub further_runs: Option<u64>,
}

/// How real runs went beside the simulator's majority, as the paper counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Real runs that ended as simulated, or equally far from milling.
    pub same: u64,
    /// Real runs that came closer to stable milling than simulated.
    pub easier: u64,
    /// Real runs that came less close.
    pub harder: u64,
}

/// All cells, compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Cell by cell, in the order given.
    pub cells: Vec<CellComparison>,
    /// All runs of all cells together, on which the verdict rests.
    pub pooled: Pooled,
    /// What follows from all runs.
    pub verdict: Verdict,
    /// If undecided: how many further real runs would support the inequality if all of them mill,
    /// those cells run next that were run least; `None` also if [`MOST_RUNS`] would not.
    pub further_runs: Option<u64>,
    /// Run by run.
    pub tally: Tally,
}

/// By how much `B_r` may fall short of `B_s` and still support the inequality, unless asked
/// otherwise.
pub const MARGIN: f64 = 0.1;

/// Bound on the probability of a wrong verdict of either kind, however often one looks.
pub const SIGNIFICANCE: f64 = 0.05;

/// More runs than this are not asked for: they decide nothing in a laboratory.
pub const MOST_RUNS: u64 = 1024;

impl Comparison {
    /// Compares real runs with simulated ones, with the usual [`MARGIN`].
    pub fn new(runs: &[CellRuns]) -> Self {
        Self::with_margin(runs, MARGIN)
    }

    /// Compares real runs with simulated ones, cell by cell; real robots may fall short by a margin from
    /// 0 to less than 1.
    ///
    /// The verdict rests on all runs together. It is `violated` if they would be improbable did real
    /// robots mill at least as often as simulated ones in every cell; then those cells are named that
    /// show it alone, corrected for their number. It is `supported` if they would be improbable did real
    /// robots, averaged over the runs, mill less often by more than the margin. Either is wrong
    /// with a probability of at most [`SIGNIFICANCE`], whatever number of runs one looked at before.
    ///
    /// # Source
    ///
    /// `eq:finalgap`; the tally of the caption of `fig:phase_plot2`; [`crate::statistics::e_value`].
    pub fn with_margin(runs: &[CellRuns], margin: f64) -> Self {
        let test = PooledTest::new(&runs.iter().map(CellRuns::tested).collect::<Vec<_>>(), margin);
        let verdict = if runs.is_empty() { Verdict::Undecided } else { decide(test.log_e()) };
        // What all runs show, they show of a single cell.
        let part = |runs_of: &CellRuns| if runs.len() == 1 { 1.0 } else { runs_of.part };
        let cells = runs
            .iter()
            .enumerate()
            .map(|(index, runs)| compare_cell(runs, &test.alone(index), part(runs), verdict));
        let further = |n: u64| test.is_supported_by(n, enough());
        Self {
            cells: cells.collect(),
            pooled: test.summary(enough()),
            verdict,
            further_runs: (verdict == Verdict::Undecided && !runs.is_empty())
                .then(|| runs_until(further))
                .flatten(),
            tally: tally(runs),
        }
    }
}

/// The logarithm of the evidence that decides.
pub fn enough() -> f64 {
    -libm::log(SIGNIFICANCE)
}

/// What follows from evidence.
pub fn decide(LogEvidence { less, at_least }: LogEvidence) -> Verdict {
    match at_least {
        _ if less >= enough() => Verdict::Violated,
        None => Verdict::NoClaim,
        Some(log_e) if log_e >= enough() => Verdict::Supported,
        Some(_) => Verdict::Undecided,
    }
}

/// What runs decide, as [`decide`] has it of all of their evidence, most often without a search for the least;
/// undecided where nothing is claimed, too.
pub fn decided(test: &PooledTest) -> Verdict {
    if test.is_violated(enough()) {
        Verdict::Violated
    } else if test.is_supported(enough()) {
        Verdict::Supported
    } else {
        Verdict::Undecided
    }
}

/// A cell by itself. With its part of the error: that of all of them together is [`SIGNIFICANCE`] then.
fn compare_cell(runs: &CellRuns, alone: &PooledTest, part: f64, of_all: Verdict) -> CellComparison {
    let (real, simulated) = (Share::milling(&runs.real), Share::milling(&runs.simulated));
    let LogEvidence { less, at_least } = alone.log_e();
    let with_part = |log_e: f64| log_e + libm::log(part);
    let verdict =
        match decide(LogEvidence { less: with_part(less), at_least: at_least.map(with_part) }) {
            Verdict::Violated if of_all != Verdict::Violated => Verdict::Undecided,
            verdict => verdict,
        };
    let needed = enough() - libm::log(part);
    let if_all_mill = |n: u64| alone.is_supported_by(n, needed);
    CellComparison {
        cell: runs.cell.clone(),
        real,
        real_interval: real.interval(),
        simulated,
        simulated_interval: simulated.interval(),
        part: runs.part,
        e_violated: e_value(less),
        e_supported: at_least.map(e_value),
        verdict,
        further_runs: (verdict == Verdict::Undecided).then(|| runs_until(if_all_mill)).flatten(),
    }
}

/// The least number of runs, of at most [`MOST_RUNS`], from which on a condition holds.
pub(crate) fn runs_until(is_enough: impl Fn(u64) -> bool) -> Option<u64> {
    let mut enough = 1;
    while !is_enough(enough) {
        enough *= 2;
        if enough > MOST_RUNS {
            return None;
        }
    }
    let mut too_few = enough / 2;
    while enough - too_few > 1 {
        let middle = too_few + (enough - too_few) / 2;
        if is_enough(middle) {
            enough = middle;
        } else {
            too_few = middle;
        }
    }
    Some(enough)
}

fn tally(runs: &[CellRuns]) -> Tally {
    let mut tally = Tally::default();
    for cell in runs {
        let Some(expected) = cell.simulated.majority() else {
            continue;
        };
        for phase in expected.behaviour().phases().iter().copied() {
            let n = cell.real.get(phase);
            match distance_from_wanted(phase).cmp(&distance_from_wanted(expected)) {
                std::cmp::Ordering::Less => tally.easier += n,
                std::cmp::Ordering::Equal => tally.same += n,
                std::cmp::Ordering::Greater => tally.harder += n,
            }
        }
    }
    tally
}

/// Phases after the third are as far from the wanted one as each other: robots that have lost each other, and
/// robots that block each other.
fn distance_from_wanted(phase: Phase) -> usize {
    phase.place().min(3)
}
