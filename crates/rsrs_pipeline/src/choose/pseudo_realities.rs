//! How the cells of a sweep do with robots as they might be.

use rsrs_core::conditions::Conditions;
use rsrs_core::numerals::rounded;
use rsrs_core::quantity::Cell;
use rsrs_core::robot::pseudo_reality::{PseudoRealities, Varied};
use rsrs_core::statistics::beta_binomial::GroupedShare;
use rsrs_core::statistics::rank_correlation::kendall_tau;
use rsrs_core::statistics::share::Share;
use rsrs_sim::sweep::confirmation_seed;
use serde::Serialize;

use crate::error::helped;
use crate::execution::Execution;
use crate::sweep::result::{SweepResult, World};
use crate::sweep::source::ResolvedSweep;

/// Runs of each profile in each cell, where nothing else is wanted.
pub const REPLICATES: u64 = 8;

/// How many profiles are drawn, and how.
#[derive(Clone, Copy, Debug)]
pub struct Draws {
    /// Profiles; at least 2.
    pub profiles: u64,
    /// Times the width of the intervals of the fit.
    pub widening: f64,
    /// Runs of each profile in each cell; at least 2.
    pub replicates: u64,
}

/// What comes of the cells of a sweep in pseudo-realities.
#[derive(Clone, Debug, Serialize)]
pub struct InPseudoRealities {
    /// Profiles that were drawn.
    pub n_profiles: u64,
    /// Times the width of the intervals of the fit.
    pub widening: f64,
    /// Runs of each profile in each cell.
    pub n_replicates: u64,
    /// The numbers that were drawn, in the units of their keys.
    pub varied: Vec<Varied>,
    /// Kendall's tau of the cells' shares in a profile and in the sweep with robots as measured, averaged over
    /// profiles; of a profile in which all cells are alike, 0. `None` of a sweep of one cell, or of cells that are
    /// alike.
    pub rank_correlation: Option<f64>,
    /// Cell by cell, in the order of the sweep.
    pub cells: Vec<CellInPseudoRealities>,
}

/// What comes of one cell.
#[derive(Clone, Debug, Serialize)]
pub struct CellInPseudoRealities {
    /// The cell.
    pub cell: Cell,
    /// Share of runs that end as wanted, over all profiles.
    pub mean: f64,
    /// Standard deviation of that share between profiles, freed of the chance in the runs of each.
    pub sd: f64,
    /// The share that the worst tenth of profiles does not exceed, of a beta distribution with these two moments.
    pub worst_tenth: f64,
}

impl InPseudoRealities {
    /// What comes of one cell.
    pub fn of_cell(&self, cell: &Cell) -> Option<&CellInPseudoRealities> {
        self.cells.iter().find(|found| found.cell == *cell)
    }
}

/// Whether profiles can be drawn around that of a sweep, which takes no run to find out.
///
/// # Errors
///
/// If the profile has no intervals, or such wide ones are of robots that cannot be, or a class has
/// a profile of its own.
pub fn can_be_drawn(result: &SweepResult, widening: f64) -> anyhow::Result<()> {
    result.source.refuse_profiles_of_classes("pseudo-realities are drawn around one profile")?;
    PseudoRealities::around(&result.source.profile, widening).map(|_| ()).map_err(helped)
}

/// Runs every cell of a sweep with profiles drawn around the intervals of its own: in the place of robots that are
/// deliberately worse, robots that are as good as is known.
pub fn pseudo_realities(
    result: &SweepResult,
    draws: Draws,
    execution: Execution<'_>,
) -> anyhow::Result<InPseudoRealities> {
    let source = &result.source;
    let measured = source.as_measured().unwrap_or_else(|| source.clone());
    let around = PseudoRealities::around(&source.profile, draws.widening).map_err(helped)?;
    let seed = confirmation_seed(confirmation_seed(confirmation_seed(source.sweep.seed)));
    let mut conditions: Vec<Conditions> = Vec::new();
    let mut cells: Vec<Cell> = Vec::new();
    for number in 0..draws.profiles {
        let drawn = ResolvedSweep { profile: around.draw(seed, number), ..measured.clone() };
        let (of_drawn, its_conditions): (Vec<_>, Vec<_>) =
            drawn.cells("sweep.yaml")?.into_iter().unzip();
        conditions.extend(its_conditions);
        cells = of_drawn;
    }
    let (runs, duration_s) = ((seed, draws.replicates), source.sweep.duration_s);
    let swept = execution.simulate("pseudo-realities", &conditions, runs, duration_s)?;
    let counts = swept.counts(conditions.len());
    let shares: Vec<Share> = counts.iter().map(Share::milling).collect();
    let by_profile = || shares.chunks(cells.len());
    let of_cell = |(index, cell): (usize, Cell)| {
        let groups: Vec<Share> = by_profile().map(|profile| profile[index]).collect();
        let grouped = GroupedShare::new(&groups);
        let GroupedShare { mean, sd } = grouped;
        CellInPseudoRealities {
            cell,
            mean: rounded(mean),
            sd: rounded(sd),
            worst_tenth: rounded(grouped.quantile(0.1)),
        }
    };
    let diagram = result.of_world(World::AsMeasured)?;
    let as_measured: Vec<f64> =
        diagram.cells.iter().map(|entry| entry.counts.wanted_share()).collect();
    let tau = |profile: &[Share]| {
        let values: Vec<f64> = profile.iter().map(|share| share.value()).collect();
        kendall_tau(&values, &as_measured).unwrap_or_default()
    };
    let mean_tau = by_profile().map(tau).sum::<f64>() / draws.profiles as f64;
    Ok(InPseudoRealities {
        n_profiles: draws.profiles,
        widening: draws.widening,
        n_replicates: draws.replicates,
        varied: around.varied().to_vec(),
        rank_correlation: kendall_tau(&as_measured, &as_measured).map(|_| rounded(mean_tau)),
        cells: cells.iter().cloned().enumerate().map(of_cell).collect(),
    })
}
