//! Evidence that may be looked at after every run: e-values of both claims of a comparison.
//!
//! An e-value is a number that is expected to be at most 1 if a hypothesis holds, and the e-values
//! here are nonnegative supermartingales in the runs: by Ville's inequality one of them *ever*
//! reaches 20 with a probability of at most 1/20. So an analyst who looks after each run, stops
//! when it pleases, or goes on after a look errs no more often than stated. The price is that a
//! fixed number of runs would decide with fewer of them.
//!
//! *What simulated robots do* is itself estimated from runs only. Every e-value is the least over all
//! shares `B_s` that they may have ([`crate::statistics::simulated`]), so it is one whatever these are.
//!
//! *Worse.* The hypothesis is `B_r >= B_s` in every cell. The bets are likelihood ratios: real robots have
//! the odds of milling of simulated ones divided by one of [`ODDS_DIVIDED_BY`]. One half of the capital
//! bets that they are worse by as much in all cells; the other half is divided among the cells, so that one
//! that is much worse is found among many that are not. That division is fixed before the first run: the
//! part of a cell that was not run is kept.
//!
//! *As good, but for a margin.* The hypothesis is that `B_r`, averaged over all runs, is less than
//! the average of `B_s - margin`. A gambler bets a share `bet` of what may be bet, `1 / (1 - margin)`, on
//! every run: his capital is multiplied by `1 + bet (x - r)`, `x` being 1 if the run milled and else 0, and
//! `r` what simulated runs show, less the margin. Where the true `B_s` is greater by `d`, it is to be
//! multiplied by `exp(-bet d)`, too: because `1 + y <= exp(y)`, the capital is then expected to be at most
//! `exp(bet (B_r - B_s + margin))`, summed over the runs. With the same bet for all runs this is at most 1
//! if the *average* is that low, however it is spread over the cells. The capital is divided among
//! [`BETS`].
//!
//! *Cells without a claim.* Where the simulated share may be no greater than the margin, nothing can fall short.
//! Such cells are no part of the second claim. That leaves it valid: a cell is left out if few of its simulated
//! runs mill, which is where the bets that `B_s` is less have won.
//!
//! # Source
//!
//! J. Ville, "Étude critique de la notion de collectif", 1939; G. Shafer, "Testing by betting",
//! Journal of the Royal Statistical Society A 184, 2021; I. Waudby-Smith and A. Ramdas, "Estimating
//! means of bounded random variables by betting", Journal of the Royal Statistical Society B 86,
//! 2024; for running averages of means that differ, Y. J. Choe and A. Ramdas, "Comparing sequential
//! forecasters", Operations Research 72, 2024.

use std::f64::consts::{LN_2, SQRT_2};

use crate::statistics::beta;
use crate::statistics::interval::TAIL;
use crate::statistics::share::Share;
use crate::statistics::simulated::{Portfolio, STAKES, Term, log_sum};

/// How much worse real robots are under the alternatives, all of equal weight: their odds of milling
/// are those of simulated ones divided by this.
pub const ODDS_DIVIDED_BY: [f64; 9] = [SQRT_2, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0];

/// Shares of the greatest possible bet, with the part of the capital that is bet so.
///
/// Real robots that nearly always mill are found out soonest by great bets, those that fall short by
/// little less than the margin by small ones.
pub const BETS: [(f64, f64); 5] = [(0.15, 0.1), (0.35, 0.1), (0.6, 0.2), (0.8, 0.3), (1.0, 0.3)];

/// The runs of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestedCell {
    /// Real runs.
    pub real: Share,
    /// Simulated ones.
    pub simulated: Share,
    /// Its part of what is bet on single cells, fixed before the first run; of all cells that may be run
    /// together at most 1.
    pub part: f64,
}

impl TestedCell {
    /// The simulated share, as far as runs show it; never quite 0 or 1.
    pub fn share(&self) -> f64 {
        (self.simulated.hits as f64 + 0.5) / (self.simulated.n as f64 + 1.0)
    }

    /// Whether something can fall short by the margin: the lower bound of the interval of its simulated share
    /// is greater.
    pub fn claims(&self, margin: f64) -> bool {
        let Share { hits, n } = self.simulated;
        // So many hits are that improbable if the share is the margin.
        hits > 0 && beta::distribution(hits as f64, (n - hits) as f64 + 1.0, margin) < TAIL
    }
}

/// The runs of a cell, and what became there of the bets on either claim.
#[derive(Clone, Debug)]
pub struct CellEvidence {
    /// The runs.
    pub cell: TestedCell,
    worse: Bets,
    as_good: Bets,
}

/// What became of bets in one cell: logarithms, as functions of the simulated share.
#[derive(Clone, Debug)]
struct Bets {
    terms: Vec<Term>,
    /// Where the share is what simulated runs show.
    shown: Vec<f64>,
}

impl Bets {
    fn new(cell: &TestedCell, terms: Vec<Term>) -> Self {
        let shown = terms.iter().map(|term| term.at(cell.share())).collect();
        Self { terms, shown }
    }
}

impl CellEvidence {
    /// Holds real runs against simulated ones, of which they may fall short by `margin`, from 0 to
    /// less than 1, and in the second hypothesis by `further` more.
    pub fn new(cell: TestedCell, margin: f64, further: f64) -> Self {
        let worse = ODDS_DIVIDED_BY.map(|divisor| STAKES.map(|(s, _)| worse(&cell, divisor, s)));
        let as_good = bets(margin).map(|(bet, _)| {
            STAKES.map(|(s, _)| {
                let term = as_good(&cell, bet, s, margin);
                Term { constant: term.constant + bet * cell.real.n as f64 * further, ..term }
            })
        });
        Self {
            cell,
            worse: Bets::new(&cell, worse.as_flattened().to_vec()),
            as_good: Bets::new(&cell, as_good.as_flattened().to_vec()),
        }
    }
}

/// What may be bet on every real run, with the part of the capital that is bet so.
fn bets(margin: f64) -> [(f64, f64); BETS.len()] {
    BETS.map(|(part, capital)| (part / (1.0 - margin), capital))
}

fn worse(cell: &TestedCell, divisor: f64, stake: f64) -> Term {
    // As steep in the share as the evidence in real runs is when it decides.
    let staked = Term::staked(cell.simulated, 10.0 + 25.0 / libm::log(divisor), stake);
    Term {
        constant: staked.constant - cell.real.hits as f64 * libm::log(divisor),
        real: (cell.real.n as f64, 1.0 / divisor - 1.0),
        ..staked
    }
}

fn as_good(cell: &TestedCell, bet: f64, stake: f64, margin: f64) -> Term {
    let staked = Term::staked(cell.simulated, -20.0 / bet, stake);
    let bet_in_all = bet * cell.real.n as f64;
    Term {
        constant: staked.constant + log_won(cell, bet, margin) + bet_in_all * cell.share(),
        slope: -bet_in_all,
        ..staked
    }
}

/// The bets on one claim in several cells, and how the capital is divided among them.
struct Claim<'a> {
    parts: Vec<f64>,
    cells: Vec<(&'a TestedCell, &'a Bets)>,
}

impl<'a> Claim<'a> {
    /// That real robots are worse.
    fn worse(cells: &[&'a CellEvidence]) -> Self {
        let parts =
            ODDS_DIVIDED_BY.map(|_| STAKES.map(|(_, part)| part / ODDS_DIVIDED_BY.len() as f64));
        let cells = cells.iter().map(|it| (&it.cell, &it.worse)).collect();
        Self { parts: parts.as_flattened().to_vec(), cells }
    }

    /// That they are as good, but for a margin.
    fn as_good(cells: &[&'a CellEvidence]) -> Self {
        let parts = BETS.map(|(_, capital)| STAKES.map(|(_, part)| capital * part));
        let cells = cells.iter().map(|it| (&it.cell, &it.as_good)).collect();
        Self { parts: parts.as_flattened().to_vec(), cells }
    }

    /// The logarithm of the least capital over all simulated shares.
    fn least(&self) -> f64 {
        let (portfolio, shares) = self.portfolio();
        portfolio.least(&shares)
    }

    /// Whether that is so much; that it is not can most often be seen where the shares are what simulated runs show.
    fn is_at_least(&self, enough: f64) -> bool {
        self.as_shown() >= enough && {
            let (portfolio, shares) = self.portfolio();
            portfolio.is_at_least(&shares, enough)
        }
    }

    /// The logarithm of the capital at the shares that simulated runs show, which takes no search.
    fn as_shown(&self) -> f64 {
        let of_bet = |(bet, part): (usize, &f64)| {
            libm::log(*part) + self.cells.iter().map(|(_, bets)| bets.shown[bet]).sum::<f64>()
        };
        log_sum(&self.parts.iter().enumerate().map(of_bet).collect::<Vec<f64>>())
    }

    fn portfolio(&self) -> (Portfolio, Vec<f64>) {
        let terms = self.cells.iter().map(|(_, bets)| bets.terms.clone()).collect();
        let shares = self.cells.iter().map(|(cell, _)| cell.share()).collect();
        (Portfolio::new(&self.parts, terms), shares)
    }
}

/// What the half of the capital becomes that bets on single cells, the rest of it last: logarithms, by what
/// becomes of a claim's bets in one cell.
fn log_in_single_cells(cells: &[&CellEvidence], of_one: impl Fn(Claim<'_>) -> f64) -> Vec<f64> {
    let kept = 1.0 - cells.iter().map(|it| it.cell.part).sum::<f64>();
    let in_one = cells.iter().map(|it| libm::log(it.cell.part) + of_one(Claim::worse(&[it])));
    in_one.chain([libm::log(kept.max(0.0))]).collect()
}

/// The logarithm of the e-value against `B_r >= B_s` in every one of these cells, of which each was run.
pub fn log_e_less(cells: &[&CellEvidence]) -> f64 {
    let mut logs = log_in_single_cells(cells, |claim| claim.least());
    logs.insert(cells.len(), Claim::worse(cells).least());
    log_sum(&logs) - LN_2
}

/// Whether it is so much.
pub fn is_less(cells: &[&CellEvidence], enough: f64) -> bool {
    let in_all = Claim::worse(cells);
    let shown = log_in_single_cells(cells, |claim| claim.as_shown());
    if log_sum(&[log_sum(&shown), in_all.as_shown()]) - LN_2 < enough {
        return false;
    }
    let in_single = log_sum(&log_in_single_cells(cells, |claim| claim.least()));
    // What is lacking has to be in the other half.
    let lacking = libm::exp(enough + LN_2) - libm::exp(in_single);
    lacking <= 0.0 || in_all.is_at_least(libm::log(lacking))
}

/// The logarithm of the e-value against `B_r` being less, averaged over all runs of these cells, than the
/// average of `B_s - margin`.
pub fn log_e_at_least(cells: &[&CellEvidence]) -> f64 {
    Claim::as_good(cells).least()
}

/// Whether it is so much.
pub fn is_at_least(cells: &[&CellEvidence], enough: f64) -> bool {
    Claim::as_good(cells).is_at_least(enough)
}

/// The logarithm of what a gambler has who bets against what simulated runs show, less the margin.
fn log_won(cell: &TestedCell, bet: f64, margin: f64) -> f64 {
    let short = (cell.share() - margin).max(0.0);
    let (hits, misses) = (cell.real.hits as f64, (cell.real.n - cell.real.hits) as f64);
    let of = |n: f64, factor: f64| if n > 0.0 { n * libm::log(factor.max(1e-300)) } else { 0.0 };
    of(hits, 1.0 + bet * (1.0 - short)) + of(misses, 1.0 - bet * short)
}

/// The logarithm of the evidence that `B_r`, averaged over the runs, exceeds what simulated runs show on
/// average, less the margin, by `above` or more: by the same bets on real runs, and none on what is
/// simulated.
pub fn log_e_share(cells: &[&CellEvidence], margin: f64, above: f64) -> f64 {
    let n: u64 = cells.iter().map(|it| it.cell.real.n).sum();
    let of_bet = |(bet, capital): (f64, f64)| {
        let won: f64 = cells.iter().map(|it| log_won(&it.cell, bet, margin)).sum();
        libm::log(capital) + won - bet * n as f64 * above
    };
    log_sum(&bets(margin).map(of_bet))
}
