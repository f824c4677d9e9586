//! The default plane in both worlds: swept, or drawn from the truth.

use std::sync::atomic::AtomicBool;

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::choice::{Worlds, rank};
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::digest::mix;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Cell;
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::statistics::interval_kind::IntervalKind;
use rsrs_core::statistics::share::Share;
use rsrs_sim::sweep::{Runs, Watch, confirmation_seed, sweep};

use crate::rules::VIABLE;

/// Replicates of a sweep.
pub const REPLICATES: [u64; 5] = [16, 50, 100, 200, 400];
/// Runs of the truth and of a confirmation.
pub const TRUTH: u64 = 1000;
const DURATION_S: f64 = 300.0;
/// A seed that no sweep has.
const TRUTH_SEED: u64 = 1_000_001;

const SHIPPED: &str = include_str!("../../../../launch_configs/sweeps/flockbot_speed_turn.yaml");

/// Simulates the plane.
pub struct Sweeper {
    cells: Vec<Cell>,
    /// Those of robots made worse, then those of robots as measured.
    conditions: Vec<Conditions>,
    n_threads: usize,
}

/// The counts of both worlds.
pub struct Plane {
    pub worlds: [PhaseDiagram; 2],
}

impl Sweeper {
    /// The plane of the shipped sweep.
    pub fn new() -> Self {
        Self::from_text(SHIPPED)
    }

    /// Fifteen cells around 0.16 m/s and 0.9 rad/s, with another number of robots.
    pub fn with_robots(robots: u32) -> Self {
        let axes = "axes: {speed_m_s: {from: 0.14, to: 0.18, steps: 5}, \
                    turn_rate_rad_s: {from: 0.8, to: 1.0, steps: 3}}\n";
        let (before, rest) = SHIPPED.split_once("axes:").expect("it has axes");
        let (_, after) = rest.split_once("fixed:").expect("something is fixed");
        let after = after.replace("robots: 9", &format!("robots: {robots}"));
        Self::from_text(&format!("{before}{axes}fixed:{after}"))
    }

    fn from_text(text: &str) -> Self {
        let name = "flockbot_speed_turn.yaml";
        let worse = SweepFile::parse(name, text).expect("it is shipped");
        let robot = rsrs_testing::conditions::flockbot();
        let measured = SweepFile { harsher: Harsher::from(HarsherFactors::NONE), ..worse.clone() };
        let resolve =
            |file: &SweepFile| file.resolve(name, &robot).expect("its cells are possible");
        let (cells, mut conditions): (Vec<Cell>, Vec<Conditions>) =
            resolve(&worse).into_iter().unzip();
        conditions.extend(resolve(&measured).into_iter().map(|(_, conditions)| conditions));
        let n_threads = std::thread::available_parallelism().map_or(1, usize::from);
        Self { cells, conditions, n_threads }
    }

    /// Cells of the plane.
    pub fn n_cells(&self) -> usize {
        self.cells.len()
    }

    fn runs(&self, seed: u64, replicates: u64) -> Runs {
        Runs { seed, replicates, duration_s: DURATION_S, n_threads: self.n_threads }
    }

    /// Sweeps the plane.
    pub fn sweep(&self, seed: u64, replicates: u64) -> Plane {
        let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false) };
        let swept = sweep(&self.conditions, self.runs(seed, replicates), watch);
        let counts = swept.expect("the robots fit").counts(self.conditions.len());
        let (worse, measured) = counts.split_at(self.cells.len());
        Plane { worlds: [worse, measured].map(|counts| self.diagram(counts)) }
    }

    /// How 1,000 runs of every cell end.
    pub fn truth(&self) -> Plane {
        self.sweep(TRUTH_SEED, TRUTH)
    }

    /// How often a cell mills in fresh runs, in both worlds.
    pub fn confirm(&self, seed: u64, cell: usize) -> [u64; 2] {
        [cell, cell + self.cells.len()].map(|index| {
            let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false) };
            let runs = self.runs(confirmation_seed(seed), TRUTH);
            let fresh = sweep(&self.conditions[index..=index], runs, watch);
            fresh.expect("the robots fit").counts(1)[0].get(Phase::STABLE_MILLING)
        })
    }

    fn diagram(&self, counts: &[PhaseCounts]) -> PhaseDiagram {
        let entries = self.cells.iter().cloned().zip(counts);
        let cells = entries.map(|(cell, counts)| DiagramCell { cell, counts: *counts }).collect();
        PhaseDiagram { axes: self.cells[0].axes(), cells }
    }

    /// Cells as people read them.
    pub fn names(&self, cells: &[usize]) -> String {
        let name = |cell: &usize| {
            let values: Vec<String> =
                self.cells[*cell].iter().map(|(_, value)| format!("{value:.3}")).collect();
            format!("({})", values.join(", "))
        };
        cells.iter().map(name).collect::<Vec<_>>().join(", ")
    }
}

impl Plane {
    /// Runs of a cell that milled, of all, made worse and as measured.
    pub fn milling(&self, cell: usize) -> [Share; 2] {
        [0, 1].map(|world| Share::milling(&self.worlds[world].cells[cell].counts))
    }

    /// The shares of mills of a cell, made worse and as measured.
    pub fn shares(&self, cell: usize) -> [f64; 2] {
        [0, 1].map(|world| self.worlds[world].cells[cell].counts.share(Phase::STABLE_MILLING))
    }

    /// The smaller of both.
    pub fn least(&self, cell: usize) -> f64 {
        let [worse, measured] = self.shares(cell);
        worse.min(measured)
    }

    /// Counts of mills of a cell in so many runs drawn from this plane, in both worlds.
    pub fn hits(&self, cell: usize, draw: u64, n: u64) -> [u64; 2] {
        let [worse, measured] = self.shares(cell);
        [(0_u64, worse), (1, measured)].map(|(world, share)| {
            let key = mix(mix(mix(draw) ^ cell as u64) ^ (world << 32) ^ n);
            let is_hit = |run: &u64| {
                let uniform = (mix(key ^ *run) >> 11) as f64 / (1_u64 << 53) as f64;
                uniform < share
            };
            (0..n).filter(is_hit).count() as u64
        })
    }

    /// A sweep of so many replicates drawn from this plane.
    pub fn drawn(&self, draw: u64, replicates: u64) -> Self {
        let mut worlds = self.worlds.clone();
        for cell in 0..worlds[0].cells.len() {
            let hits = self.hits(cell, 2 * draw, replicates);
            for (world, hits) in worlds.iter_mut().zip(hits) {
                let mut counts = PhaseCounts::default();
                counts.add_many(Phase::STABLE_MILLING, hits);
                counts.add_many(Phase::UNFORMED, replicates - hits);
                world.cells[cell].counts = counts;
            }
        }
        Self { worlds }
    }

    /// The cells that lie deepest where at least the viable share mills in both worlds.
    pub fn deepest(&self) -> Vec<usize> {
        let worlds = Worlds { simulated: &self.worlds[0], as_measured: Some(&self.worlds[1]) };
        let ranked = rank(worlds, IntervalKind::ClopperPearson, VIABLE);
        let viable = || ranked.iter().filter(|candidate| self.least(candidate.index) >= VIABLE);
        let most = viable().map(|candidate| candidate.depth).fold(0.0, f64::max);
        viable().filter(|it| it.depth >= most).map(|it| it.index).collect()
    }

    /// Where a cell lies, in grid steps.
    pub fn place(&self, cell: usize) -> [usize; 2] {
        let diagram = &self.worlds[0];
        [0, 1].map(|axis| {
            let axis = diagram.axes[axis];
            let value = diagram.cells[cell].cell.get(axis).expect("the axis is swept");
            diagram.values(axis).partition_point(|other| *other < value)
        })
    }

    /// How far a cell is from the nearest of others, in grid steps.
    pub fn nearest(&self, cell: usize, others: &[usize]) -> f64 {
        let here = self.place(cell);
        let distance = |other: &usize| {
            let there = self.place(*other);
            let square = |axis: usize| (here[axis] as f64 - there[axis] as f64).powi(2);
            (square(0) + square(1)).sqrt()
        };
        others.iter().map(distance).fold(f64::INFINITY, f64::min)
    }
}
