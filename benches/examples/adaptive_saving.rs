//! What an adaptive sweep saves on the Flockbot's diagram: 20 × 20 cells of speed and turning rate.
//!
//! Every cell is simulated many times, which is taken for the truth. Then sweeps are drawn from it,
//! adaptive ones and full grids, and compared by how far off they place the boundary of the milling
//! region: where `B_s` falls through one half along each turning rate, on the fast side.
//!
//! `cargo run --release -p rsrs_benches --example adaptive_saving`

#![expect(clippy::print_stdout, reason = "a table for people")]

use std::sync::atomic::AtomicBool;

use rsrs_benches::diagram;
use rsrs_core::diagram::adaptive::{Adaptive, Schedule};
use rsrs_core::digest::mix;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_sim::sweep::{Runs, Watch, sweep};

const SIDE: usize = 20;
const TRUTH: u64 = 1000;
const SWEEPS: u64 = 100;

fn main() {
    let truth = truth();
    let schedule = Schedule::new(Adaptive::default(), 16, &cells(&truth));
    let adaptive: Vec<Vec<PhaseCounts>> =
        (0..SWEEPS).map(|seed| adaptive_sweep(&truth, &schedule, seed)).collect();
    let spent: u64 = adaptive.iter().flatten().map(PhaseCounts::total).sum();
    let per_cell = spent as f64 / (SWEEPS as f64 * (SIDE * SIDE) as f64);
    let error = error(&truth, &adaptive);
    println!("adaptive: {per_cell:6.1} replicates a cell, boundary off by {error:.3} cells (rms)");
    for replicates in [16, 32, 64, 96, 128, 192, 256, 384, 512] {
        let grids: Vec<Vec<PhaseCounts>> =
            (0..SWEEPS).map(|seed| full_grid(&truth, replicates, seed)).collect();
        let error = self::error(&truth, &grids);
        let ratio = replicates as f64 / per_cell;
        println!("full:     {replicates:6} replicates a cell, off by {error:.3}, {ratio:.1} times");
    }
}

/// How 1,000 replicates of each cell end.
fn truth() -> Vec<PhaseCounts> {
    let conditions = diagram(SIDE);
    let n_threads = std::thread::available_parallelism().map_or(1, usize::from);
    let runs = Runs { seed: 1, replicates: TRUTH, duration_s: 300.0, n_threads };
    let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false) };
    sweep(&conditions, runs, watch).expect("the robots fit").counts(conditions.len())
}

/// The cells of the diagram, by their places in it.
fn cells(truth: &[PhaseCounts]) -> Vec<Cell> {
    let cell = |index: usize| {
        let place = [(Axis::Speed, index % SIDE), (Axis::TurnRate, index / SIDE)];
        Cell::new(place.map(|(axis, at)| (axis, at as f64))).expect("the axes are distinct")
    };
    (0..truth.len()).map(cell).collect()
}

/// Draws more replicates of each cell from the truth; a replicate is the same whenever it is drawn.
fn draw(truth: &[PhaseCounts], counts: &mut [PhaseCounts], (more, seed): (&[u64], u64)) {
    for (cell, more) in more.iter().enumerate() {
        let n = counts[cell].total();
        for replicate in n..n + more {
            let mut place = mix(mix(seed << 32 | cell as u64) ^ replicate) % TRUTH;
            let phase = Phase::BUILT_IN.into_iter().find(|phase| {
                let n = truth[cell].get(*phase);
                let is_here = place < n;
                place = place.saturating_sub(n);
                is_here
            });
            counts[cell].add(phase.expect("the counts add up to all"));
        }
    }
}

fn adaptive_sweep(truth: &[PhaseCounts], schedule: &Schedule, seed: u64) -> Vec<PhaseCounts> {
    let mut counts = vec![PhaseCounts::default(); truth.len()];
    loop {
        let more = schedule.next_round(&counts);
        if more.iter().all(|more| *more == 0) {
            return counts;
        }
        draw(truth, &mut counts, (&more, seed));
    }
}

fn full_grid(truth: &[PhaseCounts], replicates: u64, seed: u64) -> Vec<PhaseCounts> {
    let mut counts = vec![PhaseCounts::default(); truth.len()];
    draw(truth, &mut counts, (&vec![replicates; truth.len()], seed));
    counts
}

/// Root mean square of the distances of found boundaries from the true one, in cells; over the
/// turning rates at which the region ends within the diagram.
fn error(truth: &[PhaseCounts], found: &[Vec<PhaseCounts>]) -> f64 {
    let rows: Vec<(usize, f64)> =
        (0..SIDE).filter_map(|turn| Some((turn, boundary(truth, turn)?))).collect();
    let errors: Vec<f64> = found
        .iter()
        .flat_map(|found| rows.iter().map(move |row| (found, *row)))
        .map(|(found, (turn, truth))| (boundary(found, turn).unwrap_or(0.0) - truth).powi(2))
        .collect();
    (errors.iter().sum::<f64>() / errors.len() as f64).sqrt()
}

/// The greatest speed at which half of the runs mill at a turning rate, by linear interpolation.
fn boundary(counts: &[PhaseCounts], turn: usize) -> Option<f64> {
    let share = |speed: usize| counts[turn * SIDE + speed].share(Phase::STABLE_MILLING);
    let last = (0..SIDE - 1).rev().find(|speed| share(*speed) >= 0.5 && share(speed + 1) < 0.5)?;
    Some(last as f64 + (share(last) - 0.5) / (share(last) - share(last + 1)))
}
