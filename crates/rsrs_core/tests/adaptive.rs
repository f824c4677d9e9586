//! Adaptive sweeps by simulation: intervals that hold whenever one stops, and what is saved.
//!
//! Runs are drawn from diagrams whose truth is known, with a generator of this file's own, so that
//! a thousand sweeps take a second.

use std::collections::HashMap;

use rsrs_core::diagram::adaptive::{Adaptive, Knowledge, Schedule, is_settled};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::statistics::interval::Interval;
use rsrs_core::statistics::sequence::{ERROR, interval};

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// The share of sequences of so many runs that miss the truth at any time.
fn ever_missed(
    truth: f64,
    n_sequences: u64,
    n_runs: u64,
    bounds: impl Fn(u64, u64) -> Interval,
) -> f64 {
    let mut known = HashMap::new();
    let misses = (0..n_sequences).filter(|sequence| {
        let mut random = generator(*sequence);
        let mut hits = 0;
        (1..=n_runs).any(|n| {
            hits += u64::from(random.random::<f64>() < truth);
            !known.entry((hits, n)).or_insert_with(|| bounds(hits, n)).contains(truth)
        })
    });
    misses.count() as f64 / n_sequences as f64
}

#[test]
fn a_confidence_sequence_misses_the_truth_in_less_than_5_percent_at_any_time() {
    for truth in [0.02, 0.3, 0.5, 0.86] {
        let missed = ever_missed(truth, 1000, 400, |hits, n| interval(hits, n, ERROR));

        // It would be 5 % if the sequences were continued for ever and no evidence were overshot.
        assert!(missed <= ERROR, "{truth}: {missed}");
    }
}

#[test]
fn intervals_for_a_fixed_number_of_runs_do_not_bear_to_be_looked_at_all_the_time() {
    let missed = ever_missed(0.5, 100, 300, Interval::clopper_pearson);

    assert!(missed > 0.15, "the positive control: {missed}");
}

#[test]
fn a_cell_is_settled_wrongly_in_less_than_5_percent_of_the_worst_cases() {
    // Two phases that are almost as frequent: the harder to distinguish, the more often one may
    // err.
    let wrong = (0..500).filter(|sequence| {
        let mut random = generator(1000 + *sequence);
        let mut counts = PhaseCounts::default();
        for _ in 0..500 {
            let phase = match random.random::<f64>() {
                share if share < 0.36 => Phase::SEMI_STABLE_MILLING,
                share if share < 0.70 => Phase::DISPERSION,
                _ => Phase::COLLIDING_UNSTABLE,
            };
            counts.add(phase);
            if is_settled(&counts) {
                return counts.majority() != Some(Phase::SEMI_STABLE_MILLING);
            }
        }
        false
    });

    let wrong = wrong.count();

    assert!(wrong <= 25, "{wrong} of 500");
}

/// Cells on each axis of the diagrams.
const SIDE: usize = 20;

/// A diagram whose milling region ends along a wave, over about two cells; beyond it, robots
/// disperse or collide.
fn share(speed: usize, turn: usize) -> f64 {
    let boundary = 9.5 + 3.0 * libm::sin(turn as f64 / 3.0);
    1.0 / (1.0 + libm::exp((speed as f64 - boundary) / 0.7))
}

fn cells() -> Vec<Cell> {
    let cell = |index: usize| {
        let (speed, turn) = (index / SIDE, index % SIDE);
        Cell::new([(Axis::Speed, speed as f64), (Axis::TurnRate, turn as f64)]).expect("distinct")
    };
    (0..SIDE * SIDE).map(cell).collect()
}

/// Replicates of a cell: the same ones however they are asked for.
fn simulate(random: &mut [ChaCha8Rng], counts: &mut [PhaseCounts], more: &[u64]) {
    for (cell, more) in more.iter().enumerate() {
        let truth = share(cell / SIDE, cell % SIDE);
        for _ in 0..*more {
            let mills = random[cell].random::<f64>() < truth;
            let other =
                if cell % SIDE < 10 { Phase::DISPERSION } else { Phase::COLLIDING_UNSTABLE };
            counts[cell].add(if mills { Phase::STABLE_MILLING } else { other });
        }
    }
}

fn random(sweep: u64) -> Vec<ChaCha8Rng> {
    (0..SIDE * SIDE).map(|cell| generator((sweep << 32) + cell as u64)).collect()
}

fn adaptive_sweep(sweep: u64) -> (Schedule, Vec<PhaseCounts>) {
    let schedule = Schedule::new(Adaptive::default(), 16, &cells());
    let mut random = random(sweep);
    let mut counts = vec![PhaseCounts::default(); SIDE * SIDE];
    loop {
        let more = schedule.next_round(&counts);
        if more.iter().all(|more| *more == 0) {
            return (schedule, counts);
        }
        simulate(&mut random, &mut counts, &more);
    }
}

/// Where along each row the share falls through one half, by linear interpolation.
fn boundary(share: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let crossing = |turn: usize| {
        let last = (0..SIDE).rev().find(|speed| share(*speed, turn) >= 0.5).unwrap_or(0);
        let (inside, outside) = (share(last, turn), share((last + 1).min(SIDE - 1), turn));
        if inside > outside {
            last as f64 + (inside - 0.5) / (inside - outside)
        } else {
            last as f64
        }
    };
    (0..SIDE).map(crossing).collect()
}

/// Squared error of the boundary, in cells, mean over rows.
fn squared_error(counts: &[PhaseCounts]) -> f64 {
    let truth = boundary(share);
    let found = boundary(|speed, turn| counts[speed * SIDE + turn].share(Phase::STABLE_MILLING));
    let errors = truth.iter().zip(&found).map(|(truth, found)| (truth - found).powi(2));
    errors.sum::<f64>() / SIDE as f64
}

#[test]
fn an_adaptive_sweep_finds_the_boundary_with_a_fifth_of_the_replicates() {
    const SWEEPS: u64 = 40;
    const N_CELLS: usize = SIDE * SIDE;
    let mean = |numbers: &mut dyn Iterator<Item = f64>| numbers.sum::<f64>() / SWEEPS as f64;

    let sweeps: Vec<_> = (0..SWEEPS).map(|sweep| adaptive_sweep(sweep).1).collect();
    let spent = |counts: &Vec<PhaseCounts>| {
        counts.iter().map(PhaseCounts::total).sum::<u64>() as f64 / N_CELLS as f64
    };
    let replicates_per_cell = mean(&mut sweeps.iter().map(spent));
    let adaptive = mean(&mut sweeps.iter().map(|counts| squared_error(counts)));

    let none = vec![PhaseCounts::default(); N_CELLS];
    let mut grids: Vec<_> = (0..SWEEPS).map(|sweep| (random(sweep), none.clone())).collect();
    let is_as_good = |replicates: &u64| {
        for (random, counts) in &mut grids {
            let more = replicates - counts[0].total();
            simulate(random, counts, &[more; N_CELLS]);
        }
        mean(&mut grids.iter().map(|(_, counts)| squared_error(counts))) <= adaptive
    };
    let equal = (16..400).step_by(8).find(is_as_good);
    let equal = equal.expect("a full grid of 400 replicates is as good") as f64;
    let saving = equal / replicates_per_cell;
    assert!(saving >= 5.0, "{saving:.2}: {replicates_per_cell:.1} per cell as good as {equal}");
}

#[test]
fn at_its_end_every_cell_is_settled_narrow_or_exhausted() {
    let (schedule, counts) = adaptive_sweep(7);
    assert_eq!(schedule.next_round(&vec![PhaseCounts::default(); 400]), vec![16; 400]);

    for cell in 0..counts.len() {
        let knowledge = schedule.knowledge(&counts, cell);
        let n = counts[cell].total();
        assert_ne!(knowledge, Knowledge::Open, "cell {cell}");
        assert!((16..=1000).contains(&n) && n % 16 == 0 || n == 1000, "cell {cell}: {n}");
    }
    let far = &counts[0];
    assert_eq!(far.total(), 16, "far from the boundary nothing is spent: {far:?}");
}

#[test]
fn an_interval_at_the_end_of_an_adaptive_sweep_misses_the_truth_in_less_than_5_percent() {
    let mut missed = 0;
    for sweep in 0..20 {
        let (_, counts) = adaptive_sweep(100 + sweep);
        for (cell, counts) in counts.iter().enumerate() {
            let bounds = interval(counts.get(Phase::STABLE_MILLING), counts.total(), ERROR);
            missed += usize::from(!bounds.contains(share(cell / SIDE, cell % SIDE)));
        }
    }

    assert!(missed <= 20 * SIDE * SIDE / 20, "{missed} of {}", 20 * SIDE * SIDE);
}

#[test]
fn no_cell_gets_more_than_it_may() {
    let cells = &cells()[..2];
    let adaptive = Adaptive { width: 0.01, most_replicates: 50 };
    let schedule = Schedule::new(adaptive, 3, cells);
    let mut counts = vec![PhaseCounts::default(); 2];
    loop {
        let more = schedule.next_round(&counts);
        if more == [0, 0] {
            break;
        }
        for (counts, more) in counts.iter_mut().zip(more) {
            counts.add_many(Phase::STABLE_MILLING, more / 2);
            counts.add_many(Phase::UNFORMED, more - more / 2);
        }
    }

    assert!(counts.iter().all(|counts| counts.total() == 50), "{counts:?}");
    assert_eq!(schedule.knowledge(&counts, 0), Knowledge::Exhausted);
}
