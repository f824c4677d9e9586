//! The laws of many runs.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::support::{HARSHER, flockbots, quietly};
use rsrs_core::conditions::Conditions;
use rsrs_core::judge::phase;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_sim::sweep::{Progress, Runs, SweepError, Watch, confirmation_seed, sweep};

const RUNS: Runs = Runs { seed: 7, replicates: 20, duration_s: 60.0, n_threads: 1 };

fn cells() -> Vec<Conditions> {
    [0.10, 0.15, 0.20].map(|speed_m_s| flockbots(speed_m_s, 0.75, &HARSHER)).to_vec()
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let one = quietly(&cells(), RUNS);
    let two = quietly(&cells(), Runs { n_threads: 2, ..RUNS });
    let many = quietly(&cells(), Runs { n_threads: 64, ..RUNS });

    assert_eq!(one.outcomes.len(), 60);
    assert_eq!(one, two);
    assert_eq!(one, many);
}

#[test]
fn a_sweep_gives_every_replicate_the_label_of_its_run() {
    let cells = cells();
    let swept = quietly(&cells, Runs { n_threads: 2, ..RUNS });

    for (index, row) in swept.outcomes.iter().enumerate() {
        assert_eq!((row.cell, row.replicate), (index / 20, index as u64 % 20));
        let seed = Seed { seed: RUNS.seed, replicate: row.replicate };
        let conditions = &cells[row.cell];
        let run = run_episode(conditions, seed, RUNS.duration_s).expect("the robots fit");
        let verdict = phase::label(&run, &conditions.bodies()).expect("long enough");
        assert_eq!((row.phase, row.evidence), (verdict.phase, verdict.evidence), "{index}");
    }
}

#[test]
fn a_cell_keeps_its_outcomes_when_the_grid_around_it_changes() {
    let whole = quietly(&cells(), RUNS);
    let alone = quietly(&cells()[2..], RUNS);

    let evidence = |cell, outcome: &rsrs_sim::sweep::ReplicateOutcome| {
        (outcome.cell == cell).then_some((outcome.replicate, outcome.evidence))
    };
    let within: Vec<_> = whole.outcomes.iter().filter_map(|row| evidence(2, row)).collect();
    let by_itself: Vec<_> = alone.outcomes.iter().filter_map(|row| evidence(0, row)).collect();
    assert_eq!(within, by_itself);
}

#[test]
fn a_confirmation_runs_on_fresh_seeds() {
    let cell = &cells()[1..2];

    let swept = quietly(cell, RUNS);
    let confirmed = quietly(cell, Runs { seed: confirmation_seed(RUNS.seed), ..RUNS });

    let radius = |row: &rsrs_sim::sweep::ReplicateOutcome| row.evidence.mean_radius_m.to_bits();
    let seen: Vec<u64> = swept.outcomes.iter().map(radius).collect();
    assert_eq!(confirmed.outcomes.len(), 20);
    assert!(confirmed.outcomes.iter().all(|row| !seen.contains(&radius(row))));
}

#[test]
fn progress_is_reported_for_every_replicate() {
    let reported: Mutex<Vec<Progress>> = Mutex::default();
    let progress = |progress| reported.lock().expect("no panic").push(progress);
    let watch = Watch { progress: &progress, cancel: &AtomicBool::new(false) };

    sweep(&cells(), Runs { n_threads: 2, ..RUNS }, watch).expect("the robots fit");

    let mut done: Vec<usize> =
        reported.lock().expect("no panic").iter().map(|row| row.done).collect();
    done.sort_unstable();
    assert_eq!(done, (1..=60).collect::<Vec<_>>());
    assert!(reported.lock().expect("no panic").iter().all(|row| row.total == 60));
}

#[test]
fn a_sweep_that_is_called_off_keeps_its_whole_cells_only() {
    let cancel = AtomicBool::new(false);
    let progress = |progress: Progress| cancel.store(progress.done >= 30, Ordering::Relaxed);
    let watch = Watch { progress: &progress, cancel: &cancel };

    let swept = sweep(&cells(), RUNS, watch).expect("the robots fit");

    assert!(swept.is_cancelled);
    assert_eq!(swept.outcomes, quietly(&cells()[..1], RUNS).outcomes);
}

#[test]
fn a_cell_that_cannot_be_placed_is_named() {
    let mut cells = cells();
    cells[1].robots = 500;
    let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false) };

    let error = sweep(&cells, Runs { n_threads: 2, ..RUNS }, watch).unwrap_err();

    assert!(matches!(error, SweepError::Placement { cell: 1, .. }), "{error}");
}

#[test]
fn runs_too_short_to_judge_and_runs_of_nobody_are_refused() {
    let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false) };
    let no_robots = [Conditions { robots: 0, ..flockbots(0.15, 0.75, &HARSHER) }];

    let short = sweep(&cells(), Runs { duration_s: 30.0, ..RUNS }, watch).unwrap_err();
    let error = sweep(&no_robots, RUNS, watch).unwrap_err();

    assert_eq!(short.to_string(), "cell number 0: 29.9 s recorded, expected at least 60 s");
    assert_eq!(error.to_string(), "cell number 0: no robots, expected at least 1");
}
