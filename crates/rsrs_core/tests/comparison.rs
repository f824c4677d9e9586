//! Statistics of the gap, against numbers from scipy.

use rsrs_core::diagram::PhaseCounts;
use rsrs_core::diagram::axis::Cell;
use rsrs_core::judge::phase::Phase;
use rsrs_core::statistics::comparison::{
    CellRuns, Comparison, Share, Tally, Verdict, fisher_less, holm,
};

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
fn three_mills_of_three_are_undecided_with_how_many_more_would_decide() {
    let comparison = Comparison::of(&[runs(counts(3, 0), counts(868, 132))]);

    let cell = &comparison.cells[0];
    assert_eq!(comparison.verdict, Verdict::Undecided);
    assert_eq!((cell.further_runs, comparison.further_runs), (Some(13), Some(13)));
    let decided = Comparison::of(&[runs(counts(16, 0), counts(868, 132))]);
    let nearly = Comparison::of(&[runs(counts(15, 0), counts(868, 132))]);
    assert_eq!((nearly.verdict, decided.verdict), (Verdict::Undecided, Verdict::Supported));
    assert!((cell.p_supported - 0.653_031_747_682_258).abs() < 1e-9);
    assert!((cell.real_interval.low - 0.292_401_773_821_286_7).abs() < 1e-9);
}

#[test]
fn no_mill_of_four_violates_the_inequality() {
    let comparison = Comparison::of(&[runs(counts(0, 4), counts(868, 132))]);

    assert_eq!(comparison.verdict, Verdict::Violated);
    assert_eq!((comparison.cells[0].further_runs, comparison.further_runs), (None, None));
}

#[test]
fn no_mill_in_nine_cells_that_were_run_once_each_violates_the_inequality() {
    let nine = vec![runs(counts(0, 1), counts(850, 150)); 9];
    let one = [runs(counts(0, 9), counts(850, 150))];

    let (in_nine, in_one) = (Comparison::of(&nine), Comparison::of(&one));

    assert_eq!((in_nine.verdict, in_one.verdict), (Verdict::Violated, Verdict::Violated));
    // No cell shows it alone, so none is named.
    assert!(in_nine.cells.iter().all(|cell| cell.verdict == Verdict::Undecided));
    assert!(in_nine.pooled.p_value < 1e-6, "{:?}", in_nine.pooled);
}

#[test]
fn it_does_not_matter_for_the_claim_over_how_many_cells_the_mills_are_spread() {
    for n in [9, 18] {
        let spread = vec![runs(counts(n / 9, 0), counts(850, 150)); 9];
        let one = [runs(counts(n, 0), counts(850, 150))];

        let (in_nine, in_one) = (Comparison::of(&spread), Comparison::of(&one));

        assert_eq!(in_nine.verdict, in_one.verdict, "{n} of {n}");
        // The same runs need no second one in each cell; they support the claim a little better,
        // because the errors of nine simulated shares average out.
        assert!(in_nine.pooled.e_supported >= in_one.pooled.e_supported);
        assert!(in_nine.further_runs <= in_one.further_runs);
    }
    // 0.75^9 = 0.075: no test at 5 % takes nine of nine for more than 0.75.
    let nine = Comparison::of(&vec![runs(counts(1, 0), counts(850, 150)); 9]);
    let wider = Comparison::with_margin(&vec![runs(counts(2, 0), counts(850, 150)); 9], 0.1);
    assert_eq!((nine.verdict, wider.verdict), (Verdict::Undecided, Verdict::Supported));
    assert!(nine.pooled.shortfall_at_most.expect("nine of nine exclude much") <= 0.25);
}

#[test]
fn one_cell_that_is_much_worse_is_found_among_eight_that_are_not() {
    let mut cells = vec![runs(counts(20, 0), counts(868, 132)); 8];
    cells.push(runs(counts(0, 8), counts(868, 132)));

    let comparison = Comparison::of(&cells);

    assert_eq!(comparison.verdict, Verdict::Violated);
    assert_eq!(comparison.cells[8].verdict, Verdict::Violated);
    assert!(comparison.cells[..8].iter().all(|cell| cell.verdict != Verdict::Violated));
}

#[test]
fn the_correction_for_many_cells_can_undo_a_violation() {
    let suspicious = runs(counts(2, 3), counts(868, 132));
    let fine = runs(counts(40, 0), counts(868, 132));

    let alone = Comparison::of(std::slice::from_ref(&suspicious));
    let among_others = Comparison::of(&[fine, suspicious]);

    assert!(alone.cells[0].p_corrected < 0.05, "{:?}", alone.cells[0]);
    assert!(alone.cells[0].p_violated < among_others.cells[1].p_violated);
    assert_ne!(among_others.cells[1].verdict, Verdict::Violated);
    assert_eq!(among_others.cells[0].verdict, Verdict::Supported);
    assert_ne!(among_others.verdict, Verdict::Violated);
}

#[test]
fn where_hardly_a_simulated_robot_mills_there_is_nothing_to_fall_short_of() {
    let comparison = Comparison::of(&[runs(counts(0, 3), counts(0, 100))]);

    assert_eq!(comparison.verdict, Verdict::Supported);
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
fn where_every_simulated_run_mills_real_ones_decide_too() {
    let all = counts(16, 0);

    assert_eq!(Comparison::of(&[runs(counts(0, 9), all)]).verdict, Verdict::Violated);
    assert_eq!(Comparison::of(&[runs(counts(60, 0), all)]).verdict, Verdict::Supported);
}

#[test]
fn nothing_compared_decides_nothing() {
    let comparison = Comparison::of(&[]);

    assert_eq!((comparison.verdict, comparison.tally), (Verdict::Undecided, Tally::default()));
}
