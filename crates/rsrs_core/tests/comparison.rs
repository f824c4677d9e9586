//! Statistics of the gap, against numbers from scipy.

use rsrs_core::comparison::{CellRuns, Comparison, Tally, Verdict};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Cell;
use rsrs_core::statistics::pooled::Pooled;

fn counts(milling: u64, dispersed: u64) -> PhaseCounts {
    let mut counts = PhaseCounts::default();
    counts.add_many(Phase::STABLE_MILLING, milling);
    counts.add_many(Phase::DISPERSION, dispersed);
    counts
}

/// One of nine cells that may be run.
fn runs(real: PhaseCounts, simulated: PhaseCounts) -> CellRuns {
    let cell: Cell = "speed_m_s=0.15,turn_rate_rad_s=0.75".parse().expect("a cell");
    CellRuns { cell, real, simulated, part: 1.0 / 9.0 }
}

#[test]
fn three_mills_of_three_are_undecided_with_how_many_more_would_decide() {
    let comparison = Comparison::new(&[runs(counts(3, 0), counts(868, 132))]);

    let cell = &comparison.cells[0];
    assert_eq!(comparison.verdict, Verdict::Undecided);
    assert_eq!((cell.further_runs, comparison.further_runs), (Some(14), Some(14)));
    let decided = Comparison::new(&[runs(counts(17, 0), counts(868, 132))]);
    let nearly = Comparison::new(&[runs(counts(16, 0), counts(868, 132))]);
    assert_eq!((nearly.verdict, decided.verdict), (Verdict::Undecided, Verdict::Supported));
    assert!((cell.real_interval.low - 0.292_401_773_821_286_7).abs() < 1e-9);
}

#[test]
fn no_mill_of_four_violates_the_inequality() {
    let comparison = Comparison::new(&[runs(counts(0, 4), counts(868, 132))]);

    assert_eq!(comparison.verdict, Verdict::Violated);
    assert_eq!((comparison.cells[0].further_runs, comparison.further_runs), (None, None));
}

#[test]
fn no_mill_in_nine_cells_that_were_run_once_each_violates_the_inequality() {
    let nine = vec![runs(counts(0, 1), counts(850, 150)); 9];
    let one = [runs(counts(0, 9), counts(850, 150))];

    let (in_nine, in_one) = (Comparison::new(&nine), Comparison::new(&one));

    assert_eq!((in_nine.verdict, in_one.verdict), (Verdict::Violated, Verdict::Violated));
    // No cell shows it alone, so none is named.
    assert!(in_nine.cells.iter().all(|cell| cell.verdict == Verdict::Undecided));
}

#[test]
fn it_does_not_matter_for_the_claim_over_how_many_cells_the_mills_are_spread() {
    for n in [9, 27] {
        let spread = vec![runs(counts(n / 9, 0), counts(850, 150)); 9];
        let one = [runs(counts(n, 0), counts(850, 150))];

        let (in_nine, in_one) = (Comparison::new(&spread), Comparison::new(&one));

        assert_eq!(in_nine.verdict, in_one.verdict, "{n} of {n}");
        // The same runs need no second one in each cell.
        let [nine, one] = [&in_nine, &in_one].map(|it| it.pooled.e_supported.expect("a claim"));
        assert!(nine >= 0.2 * one, "{nine} {one}");
    }
    // 0.75^9 = 0.075: no test at 5 % takes nine of nine for more than 0.75.
    let nine = Comparison::new(&vec![runs(counts(1, 0), counts(850, 150)); 9]);
    let wider = Comparison::with_margin(&vec![runs(counts(3, 0), counts(850, 150)); 9], 0.1);
    assert_eq!((nine.verdict, wider.verdict), (Verdict::Undecided, Verdict::Supported));
    assert!(nine.pooled.shortfall_at_most.expect("nine of nine exclude much") <= 0.4);
}

#[test]
fn one_cell_that_is_much_worse_is_found_among_eight_that_are_not() {
    let mut cells = vec![runs(counts(20, 0), counts(868, 132)); 8];
    cells.push(runs(counts(0, 8), counts(868, 132)));

    let comparison = Comparison::new(&cells);

    assert_eq!(comparison.verdict, Verdict::Violated);
    assert_eq!(comparison.cells[8].verdict, Verdict::Violated);
    assert!(comparison.cells[..8].iter().all(|cell| cell.verdict != Verdict::Violated));
}

#[test]
fn the_correction_for_many_cells_can_undo_a_violation() {
    let suspicious = runs(counts(2, 3), counts(868, 132));
    let fine = runs(counts(40, 0), counts(868, 132));

    let among_others = Comparison::new(&[fine, suspicious]);

    assert_ne!(among_others.cells[1].verdict, Verdict::Violated);
    assert_eq!(among_others.cells[0].verdict, Verdict::Supported);
    assert_ne!(among_others.verdict, Verdict::Violated);
}

#[test]
fn where_hardly_a_simulated_robot_mills_nothing_is_claimed_and_nothing_supported() {
    let never = || runs(counts(1, 0), counts(0, 100));
    let often = || runs(counts(30, 0), counts(868, 132));

    let alone = Comparison::new(&[never()]);
    let beside = Comparison::new(&[never(), often()]);

    assert_eq!(alone.verdict, Verdict::NoClaim);
    assert_eq!((alone.pooled.e_supported, alone.further_runs), (None, None));
    assert_eq!(beside.verdict, Verdict::Supported);
    let verdicts: Vec<Verdict> = beside.cells.iter().map(|cell| cell.verdict).collect();
    assert_eq!(verdicts, [Verdict::NoClaim, Verdict::Supported]);
    let Pooled { n_cells_claimed, n_real_claimed, n_real, .. } = beside.pooled;
    assert_eq!((n_cells_claimed, n_real_claimed, n_real), (1, 30, 31));
}

#[test]
fn the_share_that_is_supported_is_stated_whether_or_not_there_is_a_verdict() {
    let few = Comparison::with_margin(&[runs(counts(6, 0), counts(868, 132))], 0.25);
    let enough = Comparison::with_margin(&[runs(counts(14, 1), counts(868, 132))], 0.25);

    assert_eq!((few.verdict, enough.verdict), (Verdict::Undecided, Verdict::Supported));
    let [few, enough] = [few, enough].map(|it| it.pooled.b_r_at_least.expect("a claim"));
    assert!(few < 0.618 && (0.618..0.7).contains(&enough), "{few} {enough}");
}

#[test]
fn the_tally_counts_run_by_run_against_the_majority() {
    let semi_stable = PhaseCounts::new([Phase::SEMI_STABLE_MILLING; 16]);
    let real = PhaseCounts::new([
        Phase::STABLE_MILLING,
        Phase::SEMI_STABLE_MILLING,
        Phase::UNFORMED,
        Phase::DISPERSION,
    ]);
    let colliding = PhaseCounts::new([Phase::COLLIDING_UNSTABLE; 16]);
    let dispersed = PhaseCounts::new([Phase::DISPERSION]);

    let comparison = Comparison::new(&[runs(real, semi_stable), runs(dispersed, colliding)]);

    assert_eq!(comparison.tally, Tally { same: 2, easier: 1, harder: 2 });
}

#[test]
fn where_every_simulated_run_mills_real_ones_decide_too() {
    let all = counts(16, 0);

    assert_eq!(Comparison::new(&[runs(counts(0, 9), all)]).verdict, Verdict::Violated);
    assert_eq!(Comparison::new(&[runs(counts(60, 0), all)]).verdict, Verdict::Supported);
}

#[test]
fn nothing_compared_decides_nothing() {
    let comparison = Comparison::new(&[]);

    assert_eq!((comparison.verdict, comparison.tally), (Verdict::Undecided, Tally::default()));
}
