//! All runs of all cells, held against the simulator at once.
//!
//! A campaign of one run in each of nine cells is strong evidence, though no single cell is: if
//! nowhere fewer than 85 % should mill and none of nine does, no correction for many cells may hide
//! it.

use serde::Serialize;

use crate::statistics::e_value::{
    CellEvidence, TestedCell, is_at_least, is_less, log_e_at_least, log_e_less, log_e_share,
};
use crate::statistics::share::Share;

/// The pooled evidence of all runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pooled {
    /// Real runs.
    pub n_real: u64,
    /// Those that milled.
    pub n_milled: u64,
    /// How many would mill if real robots milled as often as simulated ones.
    pub n_expected: f64,
    /// By how much `B_r` may fall short of `B_s`.
    pub margin: f64,
    /// Evidence that in some cell `B_r < B_s`: expected to be at most 1 if in none.
    pub e_violated: f64,
    /// Cells that were run and make a claim: their simulated share is surely greater than the margin.
    pub n_cells_claimed: usize,
    /// Real runs in these.
    pub n_real_claimed: u64,
    /// Evidence that there `B_r`, averaged over the runs, is at least the average of `B_s - margin`; `None` if
    /// nothing is claimed.
    pub e_supported: Option<f64>,
    /// What `B_r`, averaged over these runs, is at least, with 95 % however often one looks; whatever `B_s` is.
    pub b_r_at_least: Option<f64>,
    /// The least margin, in hundredths, with which the claim would be supported now: real robots mill
    /// less often by at most this; `None` if the runs exclude nothing.
    pub shortfall_at_most: Option<f64>,
}

/// The runs of a campaign and what is simulated of their cells, ready to be tested again and again.
#[derive(Clone, Debug)]
pub struct PooledTest {
    cells: Vec<CellEvidence>,
    margin: f64,
}

/// Logarithms of the evidence in some runs, one for each hypothesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogEvidence {
    /// That in some cell `B_r < B_s`.
    pub less: f64,
    /// That all cells together are as good as simulated but for the margin; `None` where nothing is claimed.
    pub at_least: Option<f64>,
}

impl PooledTest {
    /// A campaign so far, in which real robots may fall short by a margin from 0 to less than 1.
    pub fn new(cells: &[TestedCell], margin: f64) -> Self {
        let cells = cells.iter().map(|cell| CellEvidence::new(*cell, margin, 0.0)).collect();
        Self { cells, margin }
    }

    /// The same campaign in one of its cells alone.
    #[must_use]
    pub fn alone(&self, cell: usize) -> Self {
        Self::new(&[TestedCell { part: 1.0, ..self.cells[cell].cell }], self.margin)
    }

    /// Adds real runs of a cell.
    pub fn add(&mut self, cell: usize, further: Share) {
        let cell = &mut self.cells[cell];
        let real = cell.cell.real + further;
        *cell = CellEvidence::new(TestedCell { real, ..cell.cell }, self.margin, 0.0);
    }

    /// The evidence of all runs.
    pub fn log_e(&self) -> LogEvidence {
        let claimed = self.claimed();
        let at_least = (!claimed.is_empty()).then(|| log_e_at_least(&claimed));
        LogEvidence { less: log_e_less(&self.run()), at_least }
    }

    /// Whether so much evidence is there that in some cell `B_r < B_s`.
    pub fn is_violated(&self, enough: f64) -> bool {
        is_less(&self.run(), enough)
    }

    /// Whether so much is there that all cells together are as good as simulated but for the margin.
    pub fn is_supported(&self, enough: f64) -> bool {
        let claimed = self.claimed();
        !claimed.is_empty() && is_at_least(&claimed, enough)
    }

    /// Whether further runs that all mill support the claim, shared out among the cells that make one, those
    /// with the fewest runs first.
    pub fn is_supported_by(&self, further: u64, enough: f64) -> bool {
        let mut cells: Vec<TestedCell> = self.cells.iter().map(|it| it.cell).collect();
        let mut claiming: Vec<&mut TestedCell> =
            cells.iter_mut().filter(|cell| cell.claims(self.margin)).collect();
        for _ in 0..further {
            if let Some(least) = claiming.iter_mut().min_by_key(|cell| cell.real.n) {
                least.real = least.real + Share { hits: 1, n: 1 };
            }
        }
        Self::new(&cells, self.margin).is_supported(enough)
    }

    /// The evidence of the campaign so far; `enough` is the logarithm of what decides.
    pub fn summary(&self, enough: f64) -> Pooled {
        let LogEvidence { less, at_least } = self.log_e();
        let claimed = self.claimed();
        let cells = || self.cells.iter().map(|it| &it.cell);
        Pooled {
            n_real: cells().map(|cell| cell.real.n).sum(),
            n_milled: cells().map(|cell| cell.real.hits).sum(),
            n_expected: cells().map(|cell| cell.real.n as f64 * cell.simulated.value()).sum(),
            margin: self.margin,
            e_violated: e_value(less),
            n_cells_claimed: claimed.len(),
            n_real_claimed: claimed.iter().map(|it| it.cell.real.n).sum(),
            e_supported: at_least.map(e_value),
            b_r_at_least: (!claimed.is_empty()).then(|| self.b_r_at_least(&claimed, enough)),
            shortfall_at_most: if claimed.is_empty() { None } else { self.shortfall(enough) },
        }
    }

    fn run(&self) -> Vec<&CellEvidence> {
        self.cells.iter().filter(|it| it.cell.real.n > 0).collect()
    }

    /// The cells that were run and make a claim.
    fn claimed(&self) -> Vec<&CellEvidence> {
        let mut run = self.run();
        run.retain(|it| it.cell.claims(self.margin));
        run
    }

    /// The greatest share, in thousandths, that the runs of some cells support.
    fn b_r_at_least(&self, claimed: &[&CellEvidence], enough: f64) -> f64 {
        let cells = || claimed.iter().map(|it| &it.cell);
        let n: u64 = cells().map(|cell| cell.real.n).sum();
        let short = |cell: &TestedCell| cell.real.n as f64 * (cell.share() - self.margin);
        let shown = cells().map(short).sum::<f64>() / n as f64;
        let is_too_much = |thousandths: u32| {
            let above = f64::from(thousandths) / 1000.0 - shown;
            log_e_share(claimed, self.margin, above) < enough
        };
        let too_much = first(0, 1000, is_too_much).unwrap_or(1001);
        f64::from(too_much.saturating_sub(1)) / 1000.0
    }

    /// The least shortfall, in hundredths, that the runs exclude.
    fn shortfall(&self, enough: f64) -> Option<f64> {
        let is_supported = |hundredths: u32| {
            let further = f64::from(hundredths) / 100.0 - self.margin;
            let shifted = |it: &&CellEvidence| CellEvidence::new(it.cell, self.margin, further);
            let claimed: Vec<CellEvidence> = self.claimed().iter().map(shifted).collect();
            is_at_least(&claimed.iter().collect::<Vec<_>>(), enough)
        };
        first(0, 99, is_supported).map(|hundredths| f64::from(hundredths) / 100.0)
    }
}

/// The first number from which on a condition holds, up to the last; `None` if it does not hold there.
fn first(mut low: u32, mut high: u32, holds: impl Fn(u32) -> bool) -> Option<u32> {
    if !holds(high) {
        return None;
    }
    while low < high {
        let middle = u32::midpoint(low, high);
        if holds(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    Some(high)
}

/// An e-value from its logarithm; as great as a number of JSON can be.
pub fn e_value(log_e: f64) -> f64 {
    libm::exp(log_e).min(f64::MAX)
}
