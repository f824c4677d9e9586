//! How often a changed robot mills in its best setting, and whether fresh runs confirm it.

use rsrs_core::conditions::{ClassChanges, Conditions, Placement, Settings};
use rsrs_core::diagram::choice::tail;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::statistics::interval::Interval;
use rsrs_core::statistics::share::Share;
use rsrs_sim::sweep::{Runs, Swept, check, confirmation_seed};

use super::SearchOptions;
use crate::sweep::result::{SweepResult, World};
use crate::sweep::source::ResolvedSweep;

/// Other values on some capabilities and on the limits, which are those of speed and turning rate.
pub type Changes = Vec<(Axis, f64)>;

/// Looks for the setting in which a changed robot mills most often.
pub struct Search<'a> {
    /// The robot, and how it is made worse.
    pub source: &'a ResolvedSweep,
    /// In which settings.
    pub cells: Vec<Cell>,
    /// What is the same in all of them.
    pub settings: Settings,
    /// What is wanted, and how.
    pub options: SearchOptions<'a>,
}

/// A setting, and how often robots mill in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// The setting.
    pub cell: Cell,
    /// Runs that milled, of all.
    pub share: Share,
}

/// A setting that fresh runs confirm.
#[derive(Clone, Debug, PartialEq)]
pub struct Confirmed {
    /// The setting.
    pub cell: Cell,
    /// Share of mills, in the world in which they are rarer.
    pub b_s: f64,
    /// Its lower bound; those of all attempts hold together at 95 %.
    pub b_s_low: f64,
    /// Fresh runs in each world.
    pub n_replicates: u64,
}

/// A round of successive halving: the best cells of the round before are run more often.
#[derive(Clone, Copy, Debug)]
struct HalvingRound {
    /// Cells that are left.
    n_cells: usize,
    /// Runs of each of them.
    replicates: u64,
}

const fn round(n_cells: usize, replicates: u64) -> HalvingRound {
    HalvingRound { n_cells, replicates }
}

/// All settings.
const WIDE: &[HalvingRound] = &[round(usize::MAX, 4), round(40, 12), round(12, 24), round(4, 100)];
/// Settings that were good for some robot or other.
const PROMISING: &[HalvingRound] = &[round(usize::MAX, 8), round(10, 24), round(4, 100)];
/// Settings that were good for nearly the same robot.
const NARROW: &[HalvingRound] = &[round(usize::MAX, 12), round(5, 40), round(2, 120)];
/// After so many rounds it is seen whether more are worth it.
const FIRST_LOOK: usize = 2;
/// A share that is so much below what is wanted then is not looked at more closely.
const FAR: f64 = 0.3;
/// What a share seen in some hundred runs must exceed what is wanted by, so that fresh runs confirm it.
const MARGIN: f64 = 0.035;
/// Settings of each end that are tried between them.
const KEPT: usize = 8;
/// Values that are confirmed until one holds.
pub const ATTEMPTS: u32 = 4;

impl<'a> Search<'a> {
    /// Looks among the settings of a sweep.
    pub fn new(result: &'a SweepResult, options: SearchOptions<'a>) -> anyhow::Result<Self> {
        let source = &result.source;
        let cells: Vec<Cell> =
            result.diagram.cells.iter().map(|entry| entry.cell.clone()).collect();
        let mut settings = source.sweep.settings();
        // A disc that follows from the range of the sensor stays where it is while that changes.
        let is_disc = |axis: &Axis| *axis == Axis::PlacementRadius;
        let is_given = result.diagram.axes.iter().any(is_disc)
            || settings.values.iter().any(|(axis, _)| is_disc(axis))
            || settings.placement.is_some();
        if let Placement::DiscFacingOut { radius_m } = source.conditions_of(0)?.placement
            && !is_given
        {
            settings.values.push((Axis::PlacementRadius, radius_m));
        }
        Ok(Self { source, cells, settings, options })
    }

    /// Tries all settings with a changed robot, and returns them, the best first; none if there is
    /// no such robot, or it fits in none of them.
    pub fn best(&self, changes: &Changes, doing: &str) -> anyhow::Result<Vec<Tried>> {
        let cells = with_settings(&self.cells, changes);
        self.tried(changes, &cells, (WIDE, doing))
    }

    /// Tries settings that are [`promising`] with a changed robot.
    pub fn best_of(
        &self,
        changes: &Changes,
        cells: &[Cell],
        doing: &str,
    ) -> anyhow::Result<Vec<Tried>> {
        let cells = with_settings(cells, changes);
        self.tried(changes, &cells, (PROMISING, doing))
    }

    /// Tries the settings that were best for nearly the same robot.
    pub fn again(
        &self,
        changes: &Changes,
        tried: &[Tried],
        doing: &str,
    ) -> anyhow::Result<Vec<Tried>> {
        let cells: Vec<Cell> =
            tried.iter().take(2 * KEPT).map(|tried| tried.cell.clone()).collect();
        self.tried(changes, &cells, (NARROW, doing))
    }

    /// Whether the settings leave room for a change: of a limit only where that is what is commanded, so
    /// not with another controller than the mirrored one.
    pub fn may_change(&self, axis: Axis) -> bool {
        let cell = self.cells.first();
        let is_set = |axis: Axis| cell.is_some_and(|cell| cell.get(axis).is_some());
        let is_mirrored =
            ![Axis::UndetectedSpeed, Axis::UndetectedTurnRate].into_iter().any(|axis| {
                is_set(axis) || self.settings.values.iter().any(|(other, _)| *other == axis)
            });
        axis.is_capability() || (is_set(axis) && is_mirrored)
    }

    /// Whether the best of some settings is likely to be confirmed.
    pub fn suffices(&self, tried: &[Tried]) -> bool {
        tried
            .first()
            .is_some_and(|best| best.share.value() >= (self.options.wanted + MARGIN).min(0.995))
    }

    /// Finds the smallest change that reaches what is wanted, and how it was confirmed; `None` if
    /// fresh runs confirm none.
    ///
    /// `at` gives the changes for a share of the way, from 0, where they do not suffice, to 1,
    /// where they do; `ends` are the settings that were tried at both.
    pub fn smallest(
        &self,
        at: &dyn Fn(f64) -> Changes,
        ends: [&[Tried]; 2],
        doing: &str,
    ) -> anyhow::Result<Option<(Changes, Confirmed)>> {
        let cells = first_of_each(&ends, KEPT);
        let (mut fails, mut holds) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = f64::midpoint(fails, holds);
            // Whole numbers have nothing between them.
            if at(middle) == at(holds) {
                holds = middle;
                continue;
            }
            let changes = at(middle);
            let cells = with_settings(&cells, &changes);
            let tried = self.tried(&changes, &cells, (NARROW, doing))?;
            if self.suffices(&tried) { holds = middle } else { fails = middle }
        }
        for attempt in 0..ATTEMPTS {
            // A value that fresh runs do not confirm is followed by one nearer to the good end.
            let further = f64::from(attempt) / f64::from(ATTEMPTS - 1);
            let changes = at(holds + (1.0 - holds) * further * further);
            let cells = with_settings(&cells, &changes);
            let tried = self.tried(&changes, &cells, (NARROW, doing))?;
            let Some(best) = tried.first() else { continue };
            let confirmed = self.confirmed(&changes, &best.cell, attempt)?;
            if confirmed.b_s_low >= self.options.wanted {
                return Ok(Some((changes, confirmed)));
            }
        }
        Ok(None)
    }

    /// Runs a changed robot in one setting on fresh seeds, made worse and as measured; each
    /// attempt, from 0, has seeds of its own.
    pub fn confirmed(
        &self,
        changes: &Changes,
        cell: &Cell,
        attempt: u32,
    ) -> anyhow::Result<Confirmed> {
        let mut conditions = Vec::new();
        for robots in [World::Harsher, World::AsMeasured] {
            let world = self.conditions((changes, robots), cell)?;
            if !conditions.contains(&world) {
                conditions.push(world);
            }
        }
        let seed = (0..=attempt).fold(self.source.sweep.seed, |seed, _| confirmation_seed(seed));
        let shares = self.shares(&conditions, (seed, self.options.confirm), "confirming")?;
        let tail = tail(u64::from(attempt) + 1);
        let low = |share: &Share| Interval::with_tails(share.hits, share.n, tail).low;
        let rarer = shares.iter().min_by(|one, other| low(one).total_cmp(&low(other)));
        let rarer = rarer.expect("there is at least one world");
        Ok(Confirmed {
            cell: cell.clone(),
            b_s: rarer.value(),
            b_s_low: low(rarer),
            n_replicates: rarer.n,
        })
    }

    /// Runs some settings in rounds, more and more often where mills are frequent.
    fn tried(
        &self,
        changes: &Changes,
        cells: &[Cell],
        (rounds, doing): (&[HalvingRound], &str),
    ) -> anyhow::Result<Vec<Tried>> {
        let mut tried: Vec<(Tried, Conditions)> = Vec::new();
        for cell in cells {
            // A robot that is none, or that finds no place, mills nowhere.
            let Ok(conditions) = self.conditions((changes, World::Harsher), cell) else {
                continue;
            };
            if self.is_possible(&conditions) {
                let cell = cell.clone();
                tried.push((Tried { cell, share: Share::default() }, conditions));
            }
        }
        for (number, HalvingRound { n_cells, replicates }) in rounds.iter().enumerate() {
            let best = tried.first().map_or(0.0, |(best, _)| best.share.value());
            if number >= FIRST_LOOK && best < self.options.wanted - FAR {
                break;
            }
            let n_kept = tried.len().min(*n_cells);
            let conditions: Vec<Conditions> =
                tried[..n_kept].iter().map(|(_, conditions)| conditions.clone()).collect();
            let seed = self.source.sweep.seed ^ number as u64;
            let shares = self.shares(&conditions, (seed, *replicates), doing)?;
            for ((tried, _), share) in tried.iter_mut().zip(shares) {
                tried.share = tried.share + share;
            }
            // Those that were run most often come first.
            tried[..n_kept]
                .sort_by(|(one, _), (other, _)| other.share.value().total_cmp(&one.share.value()));
        }
        Ok(tried.into_iter().map(|(tried, _)| tried).collect())
    }

    /// The conditions of a changed robot in a setting.
    pub fn conditions(
        &self,
        (changes, robots): (&Changes, World),
        cell: &Cell,
    ) -> anyhow::Result<Conditions> {
        let capabilities: Changes =
            changes.iter().copied().filter(|(axis, _)| axis.is_capability()).collect();
        let (measured, harsher) = (&self.source.profile, self.source.sweep.harsher);
        let harsher = (robots == World::Harsher).then_some(harsher);
        let robot =
            ClassChanges { capabilities: capabilities.clone(), harsher }.simulated(measured)?;
        let harsher = harsher.map(|harsher| harsher.decided(measured));
        let class_changes = ClassChanges { capabilities, harsher };
        let settings = Settings { class_changes, ..self.settings.with_cell(cell) };
        let conditions = Conditions::resolve(&robot, &settings)?;
        // Limits may be among the changes; wheels are what they are.
        measured.check_wheels(&conditions.controller)?;
        Ok(conditions)
    }

    /// The conditions of a changed robot in a setting, made worse and as measured; `None` if there
    /// is no such robot, or it cannot be simulated there.
    pub fn in_both_worlds(&self, changes: &Changes, cell: &Cell) -> Option<[Conditions; 2]> {
        let of = |robots| {
            let conditions = self.conditions((changes, robots), cell).ok()?;
            self.is_possible(&conditions).then_some(conditions)
        };
        Some([of(World::Harsher)?, of(World::AsMeasured)?])
    }

    /// Whether robots find a place under some conditions, and their runs can be judged.
    pub fn is_possible(&self, conditions: &Conditions) -> bool {
        let SweepFile { seed, duration_s, .. } = self.source.sweep;
        let runs = Runs { seed, replicates: 1, duration_s, n_threads: 1 };
        check(std::slice::from_ref(conditions), runs).is_ok()
    }

    /// How so many runs under each of some conditions end.
    pub fn counts(
        &self,
        conditions: &[Conditions],
        runs: (u64, u64),
        doing: &str,
    ) -> anyhow::Result<Vec<PhaseCounts>> {
        Ok(self.simulate(conditions, runs, doing)?.counts(conditions.len()))
    }

    /// What so many runs under each of some conditions come to.
    pub fn simulate(
        &self,
        conditions: &[Conditions],
        runs: (u64, u64),
        doing: &str,
    ) -> anyhow::Result<Swept> {
        let duration_s = self.source.sweep.duration_s;
        self.options.execution.simulate(doing, conditions, runs, duration_s)
    }

    fn shares(
        &self,
        conditions: &[Conditions],
        runs: (u64, u64),
        doing: &str,
    ) -> anyhow::Result<Vec<Share>> {
        Ok(self.counts(conditions, runs, doing)?.iter().map(Share::milling).collect())
    }
}

/// The way is halved so often.
const BISECTIONS: u32 = 5;

/// Settings of each robot that are promising for others.
const MOST_PROMISING: usize = 20;

/// Settings that were good for one robot or another.
pub fn promising(robots: &[&[Tried]]) -> Vec<Cell> {
    first_of_each(robots, MOST_PROMISING)
}

fn first_of_each(robots: &[&[Tried]], n: usize) -> Vec<Cell> {
    let mut cells: Vec<Cell> = Vec::new();
    for tried in robots.iter().flat_map(|tried| tried.iter().take(n)) {
        if !cells.contains(&tried.cell) {
            cells.push(tried.cell.clone());
        }
    }
    cells
}

/// Cells with the settings that are among some changes, each once.
fn with_settings(cells: &[Cell], changes: &Changes) -> Vec<Cell> {
    let mut changed: Vec<Cell> = Vec::new();
    for cell in cells {
        let value = |(axis, value)| {
            let change = changes.iter().find(|(other, _)| *other == axis);
            (axis, change.map_or(value, |(_, value)| *value))
        };
        let cell = Cell::new(cell.iter().map(value)).expect("the axes are those of a cell");
        if !changed.contains(&cell) {
            changed.push(cell);
        }
    }
    changed
}
