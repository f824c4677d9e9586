//! Statistics of the gap, against numbers from scipy.

use rsrs_core::axis::Cell;
use rsrs_core::comparison::{CellRuns, Comparison, Share, Tally, Verdict, fisher_less, holm};
use rsrs_core::diagram::PhaseCounts;
use rsrs_core::phase::Phase;

fn counts(milling: u64, dispersed: u64) -> PhaseCounts {
    let mut counts = PhaseCounts::default();
    counts.add_many(Phase::StableMilling, milling);
    counts.add_many(Phase::Dispersion, dispersed);
    counts
}

fn runs(real: PhaseCounts, simulated: PhaseCounts) -> CellRuns {
    let cell: Cell = "speed_m_s=0.15,turn_rate_rad_s=0.75".parse().expect("a cell");
    CellRuns { cell, real, simulated }
}

#[test]
fn the_exact_test_is_that_of_scipy() {
    // scipy 1.17: fisher_exact([[k_r, n_r - k_r], [k_s, n_s - k_s]], alternative="less").pvalue
    for (real_hits, real_n, hits, n, expected) in [
        (3, 3, 868, 1000, 1.0),
        (0, 3, 868, 1000, 0.002_391_594_113_434_580_2),
        (1, 3, 868, 1000, 0.048_522_787_234_794_93),
        (5, 10, 868, 1000, 0.006_101_223_557_725_637),
        (9, 10, 12, 16, 0.933_596_837_944_664),
        (0, 5, 0, 16, 1.0),
        (2, 20, 14, 16, 3.163_848_470_796_515e-6),
    ] {
        let found = fisher_less(Share { hits: real_hits, n: real_n }, Share { hits, n });

        assert!((found / expected - 1.0).abs() < 1e-9, "{real_hits}/{real_n}: {found} {expected}");
    }
}

#[test]
fn holm_multiplies_the_smallest_by_most_and_never_reverses_the_order() {
    let corrected = holm(&[0.01, 0.04, 0.03, 0.9]);

    // By hand: 0.01 * 4, then 0.03 * 3, then max(0.04 * 2, 0.09), then 0.9.
    for (found, expected) in corrected.iter().zip([0.04, 0.09, 0.09, 0.9]) {
        assert!((found - expected).abs() < 1e-12, "{corrected:?}");
    }
}

#[test]
fn three_mills_of_three_are_undecided_and_say_how_many_more_would_do() {
    let comparison = Comparison::of(&[runs(counts(3, 0), counts(868, 132))]);

    let cell = &comparison.cells[0];
    assert_eq!(comparison.verdict, Verdict::Undecided);
    // Ten of ten give 0.945, eleven of eleven 0.958: the fourth to the eleventh run.
    assert_eq!(cell.further_runs, Some(8));
    assert!((cell.p_supported - 0.653_031_747_682_258).abs() < 1e-9);
    assert!((cell.real_interval.low - 0.292_401_773_821_286_7).abs() < 1e-9);
}

#[test]
fn no_mill_of_three_violates_the_inequality() {
    let comparison = Comparison::of(&[runs(counts(0, 3), counts(868, 132))]);

    assert_eq!(comparison.verdict, Verdict::Violated);
    assert_eq!(comparison.cells[0].further_runs, None);
}

#[test]
fn the_correction_for_many_cells_can_undo_a_violation() {
    let suspicious = runs(counts(1, 2), counts(868, 132));
    let fine = runs(counts(20, 0), counts(868, 132));

    let alone = Comparison::of(std::slice::from_ref(&suspicious));
    let among_others = Comparison::of(&[fine, suspicious]);

    assert_eq!(alone.cells[0].verdict, Verdict::Violated);
    assert_eq!(among_others.cells[0].verdict, Verdict::Supported);
    assert_eq!(among_others.cells[1].verdict, Verdict::Undecided);
    assert_eq!(among_others.verdict, Verdict::Undecided);
}

#[test]
fn the_tally_counts_run_by_run_against_the_majority() {
    let semi_stable = PhaseCounts::of([Phase::SemiStableMilling; 16]);
    let real = PhaseCounts::of([
        Phase::StableMilling,
        Phase::SemiStableMilling,
        Phase::Unformed,
        Phase::Dispersion,
    ]);
    let colliding = PhaseCounts::of([Phase::CollidingUnstable; 16]);
    let dispersed = PhaseCounts::of([Phase::Dispersion]);

    let comparison = Comparison::of(&[runs(real, semi_stable), runs(dispersed, colliding)]);

    assert_eq!(comparison.tally, Tally { same: 2, easier: 1, harder: 2 });
}

#[test]
fn nothing_compared_decides_nothing() {
    let comparison = Comparison::of(&[]);

    assert_eq!((comparison.verdict, comparison.tally), (Verdict::Undecided, Tally::default()));
}
