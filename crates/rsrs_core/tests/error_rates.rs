//! How often the statistics are wrong, under simulation: campaigns in which the truth is known.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_core::agreement::Agreement;
use rsrs_core::axis::Cell;
use rsrs_core::comparison::{CellRuns, Comparison, SIGNIFICANCE, Verdict};
use rsrs_core::diagram::PhaseCounts;
use rsrs_core::interval::Interval;
use rsrs_core::next_experiment::{NextStep, next_step};
use rsrs_core::phase::Phase;

const N_CAMPAIGNS: u64 = 1000;
const N_CELLS: u32 = 3;
const N_REAL: u32 = 10;

fn cell(speed_m_s: f64) -> Cell {
    format!("speed_m_s={speed_m_s},turn_rate_rad_s=0.75").parse().expect("a cell")
}

fn drawn(random: &mut ChaCha8Rng, n: u32, share: f64) -> PhaseCounts {
    PhaseCounts::of((0..n).map(|_| {
        let mills = random.random::<f64>() < share;
        if mills { Phase::StableMilling } else { Phase::Dispersion }
    }))
}

fn counted(n_milling: u64, n_dispersed: u64) -> PhaseCounts {
    let mut counts = PhaseCounts::default();
    counts.add_many(Phase::StableMilling, n_milling);
    counts.add_many(Phase::Dispersion, n_dispersed);
    counts
}

/// Campaigns whose verdict is `violated`, if real robots mill less often by `worse`.
fn n_violated(worse: f64) -> u64 {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let campaign = |_: &u64| {
        let runs: Vec<CellRuns> = (1..=N_CELLS)
            .map(|number| {
                let b_s = 0.5 + 0.45 * random.random::<f64>();
                CellRuns {
                    cell: cell(0.05 * f64::from(number)),
                    real: drawn(&mut random, N_REAL, b_s - worse),
                    simulated: drawn(&mut random, 200, b_s),
                }
            })
            .collect();
        Comparison::of(&runs).verdict == Verdict::Violated
    };
    (0..N_CAMPAIGNS).filter(campaign).count() as u64
}

#[test]
fn equal_robots_are_called_worse_in_at_most_5_of_100_campaigns() {
    let n_false = n_violated(0.0);

    // With so many false alarms the true rate might still be the stated one, at most.
    let possible = Interval::clopper_pearson(n_false, N_CAMPAIGNS);
    assert!(possible.low <= SIGNIFICANCE, "{n_false} false alarms, {possible:?}");
    // The exact test is conservative; this many are expected.
    assert!((n_false as f64) <= SIGNIFICANCE * N_CAMPAIGNS as f64, "{n_false} false alarms");
}

#[test]
fn robots_that_mill_half_as_often_are_found_out_in_three_of_four_campaigns() {
    let n_found = n_violated(0.45);

    let power = Interval::clopper_pearson(n_found, N_CAMPAIGNS);
    assert!(power.low >= 0.75, "{n_found} found, {power:?}");
}

#[test]
fn the_interval_of_kappa_covers_the_truth_in_95_of_100_campaigns() {
    // Two judges who agree on a share of the runs and else draw a phase each.
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let draw = |random: &mut ChaCha8Rng| Phase::ALL[random.random_range(0..Phase::ALL.len())];
    let truth = 0.6;
    let covers = |_: &u64| {
        let labels: Vec<(Phase, Phase)> = (0..200)
            .map(|_| {
                let one = draw(&mut random);
                let same = random.random::<f64>() < truth;
                (one, if same { one } else { draw(&mut random) })
            })
            .collect();
        let agreement = Agreement::of(&labels).expect("there are labels");
        let interval = agreement.kappa_interval.expect("the judges use several phases");
        interval.low <= truth && truth <= interval.high
    };

    let n_covered = (0..N_CAMPAIGNS).filter(covers).count() as u64;

    let coverage = Interval::clopper_pearson(n_covered, N_CAMPAIGNS);
    assert!(coverage.low <= 0.95 && 0.95 <= coverage.high, "{n_covered} covered, {coverage:?}");
}

#[test]
fn a_violated_cell_sends_back_to_step_1() {
    let runs = [
        CellRuns { cell: cell(0.1), real: counted(5, 0), simulated: counted(900, 100) },
        CellRuns { cell: cell(0.2), real: counted(0, 8), simulated: counted(900, 100) },
    ];

    let next = next_step(&Comparison::of(&runs), &runs, &[]);

    let NextStep::ReturnToStep1 { cell: worst, b_r, b_s, p_corrected } = next else {
        panic!("expected step 1, found {next:?}")
    };
    assert_eq!((worst, b_r, b_s), (cell(0.2), 0.0, 0.9));
    assert!(p_corrected < SIGNIFICANCE);
}

#[test]
fn the_cell_of_which_least_is_known_is_run_next_and_the_runs_decide_it() {
    let runs = [
        // Four more mills would do here, and one more run tells little of the second cell.
        CellRuns { cell: cell(0.1), real: counted(8, 0), simulated: counted(900, 100) },
        CellRuns { cell: cell(0.2), real: counted(1, 1), simulated: counted(900, 100) },
    ];
    let comparison = Comparison::of(&runs);
    assert!(comparison.cells.iter().all(|cell| cell.verdict == Verdict::Undecided));

    let next = next_step(&comparison, &runs, &[]);

    let NextStep::Run(experiment) = next else { panic!("expected a run, found {next:?}") };
    assert!(experiment.information_bits > 0.0 && experiment.information_bits < 1.0);
    let n = experiment.runs.expect("a laboratory can decide it");
    assert!((1..200).contains(&n), "{experiment:?}");
    // As many runs as are asked for, that go as the others did, leave less to be known.
    let chosen = runs.iter().find(|runs| runs.cell == experiment.cell).expect("a cell of these");
    assert_eq!(experiment.n_real, chosen.real.total());
}

#[test]
fn when_all_is_supported_a_cell_that_was_not_run_is_next_and_a_certain_one_is_not() {
    let runs = [CellRuns { cell: cell(0.1), real: counted(40, 0), simulated: counted(900, 100) }];
    // Where no simulated robot mills, real ones cannot mill less often.
    let never = CellRuns { cell: cell(0.3), real: counted(0, 0), simulated: counted(0, 1000) };
    let often = CellRuns { cell: cell(0.2), real: counted(0, 0), simulated: counted(700, 300) };
    let comparison = Comparison::of(&runs);
    assert_eq!(comparison.verdict, Verdict::Supported);

    let next = next_step(&comparison, &runs, &[never.clone(), often]);
    let nothing = next_step(&comparison, &runs, &[never]);

    let NextStep::Run(experiment) = next else { panic!("expected a run, found {next:?}") };
    assert_eq!((experiment.cell, experiment.n_real), (cell(0.2), 0));
    assert_eq!(nothing, NextStep::Nothing);
}
