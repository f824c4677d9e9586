//! The world against an independent implementation: milling fractions of its prototype, written
//! before it and in other code, in double precision, with another generator, platform trigonometry
//! and a judge of its own. It is not kept in the repository, so its fractions stand here as numbers.
//!
//! Each fraction was found with thousands of runs and is rounded to 0.01. Ours has 3,000 runs, whose
//! standard error is at most 0.009: 0.03 is more than three of them, so that a test of six cells
//! fails for a difference and not by chance.

use crate::support::{HARSHER, Imperfection, flockbots, quietly};
use rsrs_core::conditions::{Conditions, Placement};
use rsrs_core::judge::phase::Phase;
use rsrs_sim::sweep::Runs;

const MEASURED: Imperfection =
    Imperfection { gain_sd: 0.02, true_positive: 0.98, false_positive: 0.065 };

fn placed(radius_m: f64, conditions: Conditions) -> Conditions {
    Conditions { placement: Placement::DiscFacingOut { radius_m }, ..conditions }
}

#[test]
fn the_milling_fractions_are_those_of_an_independent_implementation() {
    let cases = [
        ("harsher at the best cell", 0.86, flockbots(0.15, 0.75, &HARSHER)),
        ("measured at the best cell", 0.87, flockbots(0.15, 0.75, &MEASURED)),
        ("harsher from 0.75 m", 0.93, placed(0.75, flockbots(0.15, 0.75, &HARSHER))),
        ("harsher from 0.60 m", 0.98, placed(0.60, flockbots(0.15, 0.75, &HARSHER))),
        ("harsher, faster", 0.55, flockbots(0.20, 1.25, &HARSHER)),
        ("measured, faster", 0.79, flockbots(0.20, 1.25, &MEASURED)),
        ("measured, wide gaps", 0.82, flockbots(0.20, 1.00, &MEASURED)),
    ];
    let conditions: Vec<Conditions> = cases.iter().map(|case| case.2.clone()).collect();
    let runs = Runs { seed: 1, replicates: 3000, duration_s: 300.0, n_threads: 2 };

    let counts = quietly(&conditions, runs).counts(cases.len());

    let shares: Vec<(&str, f64, f64)> = cases
        .iter()
        .zip(&counts)
        .map(|(case, counts)| (case.0, case.1, counts.share(Phase::STABLE_MILLING)))
        .collect();
    let is_met = |(_, expected, found): &(&str, f64, f64)| (found - expected).abs() <= 0.03;
    assert!(shares.iter().all(is_met), "case, expected, found: {shares:?}\n{counts:?}");
}
