//! How often the statistics are wrong, under simulation: campaigns in which the truth is known.

use std::io::Write;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_core::comparison::next_experiment::{NextStep, next_step};
use rsrs_core::comparison::{CellRuns, Comparison, MARGIN, SIGNIFICANCE, Verdict, enough};
use rsrs_core::judge::agreement::Agreement;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Cell;
use rsrs_core::statistics::e_value::TestedCell;
use rsrs_core::statistics::interval::Interval;
use rsrs_core::statistics::pooled::{LogEvidence, PooledTest};
use rsrs_core::statistics::share::Share;
use rsrs_testing::environment::{is_long, or_if_long};

const N_CAMPAIGNS: u64 = 1000;

fn cell(speed_m_s: f64) -> Cell {
    format!("speed_m_s={speed_m_s},turn_rate_rad_s=0.75").parse().expect("a cell")
}

/// One of three cells, with real and simulated runs that milled and that did not.
fn cell_runs(speed_m_s: f64, real: [u64; 2], simulated: [u64; 2]) -> CellRuns {
    let [real, simulated] = [real, simulated].map(|[mills, others]| counted(mills, others));
    CellRuns { cell: cell(speed_m_s), real, simulated, part: 1.0 / 3.0 }
}

fn counted(n_milling: u64, n_dispersed: u64) -> PhaseCounts {
    let mut counts = PhaseCounts::default();
    counts.add_many(Phase::STABLE_MILLING, n_milling);
    counts.add_many(Phase::DISPERSION, n_dispersed);
    counts
}

/// How often robots of a cell mill, in truth.
#[derive(Clone, Copy)]
struct Truth {
    b_s: f64,
    b_r: f64,
}

/// Campaigns of so many runs, cell after cell in turn, with a look after every run.
struct Looks<'a> {
    cells: &'a [Truth],
    n_simulated: u64,
    n_runs: usize,
    margin: f64,
}

/// Whether a verdict is reached.
type Reached = fn(&PooledTest, f64) -> bool;

impl Looks<'_> {
    /// In how many campaigns a verdict is ever reached; each has simulated runs of its own.
    fn ever(&self, seed: u64, n_campaigns: u64, reached: Reached) -> u64 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let ends = (0..n_campaigns).map(|_| self.first(&mut random, reached));
        ends.flatten().count() as u64
    }

    /// The number of the first run after which there is a verdict.
    fn first(&self, random: &mut ChaCha8Rng, reached: Reached) -> Option<usize> {
        let mut mills = |share: f64| u64::from(random.random::<f64>() < share);
        let part = 1.0 / self.cells.len() as f64;
        let tested = |truth: &Truth| {
            let hits = (0..self.n_simulated).map(|_| mills(truth.b_s)).sum();
            let simulated = Share { hits, n: self.n_simulated };
            TestedCell { real: Share::default(), simulated, part }
        };
        let tested: Vec<TestedCell> = self.cells.iter().map(tested).collect();
        let mut test = PooledTest::new(&tested, self.margin);
        (0..self.n_runs).find(|run| {
            let cell = run % self.cells.len();
            test.add(cell, Share { hits: mills(self.cells[cell].b_r), n: 1 });
            reached(&test, enough())
        })
    }
}

/// Whether so many errors agree with at most 5 %, as far as this many campaigns can show.
fn assert_rare(n_false: u64, n_campaigns: u64, what: &str) {
    let possible = Interval::clopper_pearson(n_false, n_campaigns);
    assert!(possible.low <= SIGNIFICANCE, "{n_false} of {n_campaigns} {what}, {possible:?}");
}

/// For who runs the long test with `--nocapture`.
fn say(line: &str) {
    writeln!(std::io::stdout(), "{line}").expect("somebody reads");
}

/// Errors of both kinds, in campaigns over a grid of what simulated and real robots do.
#[test]
fn either_verdict_is_wrong_in_at_most_5_of_100_campaigns_whatever_robots_do() {
    let (n_campaigns, shares, few): (u64, &[f64], &[u64]) = if is_long() {
        (2000, &[0.02, 0.12, 0.3, 0.5, 0.7, 0.87, 0.95, 0.98], &[16, 100, 1000])
    } else {
        (100, &[0.02, 0.5, 0.98], &[16, 100])
    };
    let mut seed = 0;
    for n_cells in [1, 9] {
        for &n_simulated in few {
            for &b_s in shares {
                for margin in [0.1, 0.25] {
                    seed += 1;
                    let equal = Truth { b_s, b_r: b_s };
                    let short = Truth { b_s, b_r: b_s - margin };
                    let kinds: [(Truth, Reached, &str); 2] = [
                        (equal, PooledTest::is_violated, "are called worse"),
                        (short, PooledTest::is_supported, "are called as good"),
                    ];
                    for (truth, reached, what) in kinds.iter().filter(|it| it.0.b_r >= 0.0) {
                        let cells = vec![*truth; n_cells];
                        let n_runs = if n_cells == 1 || !is_long() { 90 } else { 180 };
                        let looks = Looks { cells: &cells, n_simulated, n_runs, margin };
                        let n_false = looks.ever(seed, n_campaigns, *reached);
                        say(&format!(
                            "{n_cells} cells of {n_simulated} simulated runs, B_s {b_s}, margin {margin}: \
                             {n_false} of {n_campaigns} {what}"
                        ));
                        assert_rare(n_false, n_campaigns, what);
                    }
                }
            }
        }
    }
}

/// The search for whether evidence is enough ends early, on either side.
#[test]
fn a_verdict_is_reached_where_its_evidence_is_enough_and_not_before() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..200 {
        let n_cells = random.random_range(1..=5);
        let share = |n: u64, random: &mut ChaCha8Rng| Share { hits: random.random_range(0..=n), n };
        let cells: Vec<TestedCell> = (0..n_cells)
            .map(|_| {
                let n_simulated = [16, 100, 1000][random.random_range(0..3)];
                let n_real = random.random_range(1..30);
                TestedCell {
                    real: share(n_real, &mut random),
                    simulated: share(n_simulated, &mut random),
                    part: 1.0 / f64::from(n_cells + 1),
                }
            })
            .collect();
        let test = PooledTest::new(&cells, MARGIN);
        let LogEvidence { less, at_least } = test.log_e();

        for by in [1e-4, 0.1, 1.0, 10.0] {
            assert!(test.is_violated(less - by), "{cells:?}: {less} - {by}");
            assert!(!test.is_violated(less + by), "{cells:?}: {less} + {by}");
            let Some(at_least) = at_least else { continue };
            assert!(test.is_supported(at_least - by), "{cells:?}: {at_least} - {by}");
            assert!(!test.is_supported(at_least + by), "{cells:?}: {at_least} + {by}");
        }
    }
}

#[test]
fn only_the_average_over_the_runs_counts_however_cells_differ() {
    let short = |b_s, by| Truth { b_s, b_r: b_s - by };
    for (seed, cells) in (11..).zip([
        // On average by as much, some much worse and some better: this is what the claim is about.
        vec![short(0.85, 0.3), short(0.85, -0.1)],
        vec![short(0.95, 0.3), short(0.9, 0.1), short(0.7, -0.1)],
    ]) {
        let looks = Looks { cells: &cells, n_simulated: 100, n_runs: 96, margin: MARGIN };

        let n_false = looks.ever(seed, 400, PooledTest::is_supported);

        assert_rare(n_false, 400, "are called as good");
    }
}

#[test]
fn robots_that_mill_half_as_often_are_found_out_in_nine_of_ten_campaigns() {
    let half = |b_s| Truth { b_s, b_r: b_s / 2.0 };
    for (seed, cells) in [(21, vec![half(0.85)]), (22, [0.8, 0.85, 0.9].map(half).to_vec())] {
        let looks = Looks { cells: &cells, n_simulated: 1000, n_runs: 24, margin: MARGIN };

        let n_found = looks.ever(seed, 400, PooledTest::is_violated);

        assert!(n_found >= 360, "{n_found}");
    }
}

#[test]
fn robots_that_mill_more_often_support_the_claim_in_most_campaigns() {
    for (seed, b_r, n_runs) in [(31, 0.99, 32), (32, 0.95, 80)] {
        let cells = [Truth { b_s: 0.9, b_r }];
        let looks = Looks { cells: &cells, n_simulated: 1000, n_runs, margin: MARGIN };

        let n_supported = looks.ever(seed, 400, PooledTest::is_supported);

        assert!(n_supported >= 340, "{b_r}: {n_supported}");
    }
}

#[test]
fn what_is_not_known_of_simulated_robots_costs_few_runs() {
    for (seed, n_cells, n_simulated, margin, most_runs, n_campaigns) in [
        (41, 1, 1000, 0.25, 28.0, 100),
        (42, 1, 1000, 0.1, 170.0, 100),
        (43, 9, 100, 0.1, 220.0, 30),
    ] {
        let n_campaigns = or_if_long(n_campaigns, 1000);
        let cells = vec![Truth { b_s: 0.87, b_r: 0.87 }; n_cells];
        let looks = Looks { cells: &cells, n_simulated, n_runs: 1000, margin };
        let mut random = ChaCha8Rng::seed_from_u64(seed);

        let decided: Reached = |test, enough| test.is_supported(enough) || test.is_violated(enough);
        let runs = |_| looks.first(&mut random, decided).map_or(looks.n_runs, |run| run + 1);
        let mean = (0..n_campaigns).map(runs).sum::<usize>() as f64 / f64::from(n_campaigns);

        say(&format!(
            "{n_cells} cells of {n_simulated} simulated runs, margin {margin}: {mean} runs"
        ));
        assert!(mean <= most_runs, "{n_cells} cells, margin {margin}: {mean}");
    }
}

#[test]
fn the_interval_of_kappa_covers_the_truth_in_95_of_100_campaigns() {
    // Two judges who agree on a share of the runs and else draw a phase each.
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let draw =
        |random: &mut ChaCha8Rng| Phase::BUILT_IN[random.random_range(0..Phase::BUILT_IN.len())];
    let truth = 0.6;
    let covers = |_: &u64| {
        let labels: Vec<(Phase, Phase)> = (0..200)
            .map(|_| {
                let one = draw(&mut random);
                let same = random.random::<f64>() < truth;
                (one, if same { one } else { draw(&mut random) })
            })
            .collect();
        let agreement = Agreement::new(&labels).expect("there are labels");
        let interval = agreement.kappa_interval.expect("the judges use several phases");
        interval.low <= truth && truth <= interval.high
    };

    let n_covered = (0..N_CAMPAIGNS).filter(covers).count() as u64;

    let coverage = Interval::clopper_pearson(n_covered, N_CAMPAIGNS);
    assert!(coverage.low <= 0.95 && 0.95 <= coverage.high, "{n_covered} covered, {coverage:?}");
}

/// Nothing is known of robots as measured.
fn unknown(_: &Cell) -> Share {
    Share::default()
}

#[test]
fn a_violated_cell_sends_back_to_step_1() {
    let runs = [cell_runs(0.1, [5, 0], [900, 100]), cell_runs(0.2, [0, 8], [900, 100])];

    let next = next_step(&Comparison::new(&runs), &runs, &[], &unknown);

    let NextStep::ReturnToStep1 { cell: worst, b_r, b_s, e_violated } = next else {
        panic!("expected step 1, found {next:?}")
    };
    assert_eq!((worst, b_r, b_s), (cell(0.2), 0.0, 0.9));
    assert!(e_violated > 20.0);
}

#[test]
fn the_cell_of_which_least_is_known_is_run_next_and_the_runs_decide_it() {
    let runs = [
        // Four more mills would do here, and one more run is weak evidence on the second cell.
        cell_runs(0.1, [8, 0], [900, 100]),
        cell_runs(0.2, [1, 1], [900, 100]),
    ];
    let comparison = Comparison::new(&runs);
    assert!(comparison.cells.iter().all(|cell| cell.verdict == Verdict::Undecided));

    let next = next_step(&comparison, &runs, &[], &unknown);

    let NextStep::Run(experiment) = next else { panic!("expected a run, found {next:?}") };
    assert!(experiment.information_bits > 0.0 && experiment.information_bits < 1.0);
    let n = experiment.runs.expect("a laboratory can decide it");
    assert!((1..200).contains(&n), "{experiment:?}");
    // As many runs as are asked for, that go as the others did, leave less to be known.
    let chosen = runs.iter().find(|runs| runs.cell == experiment.cell).expect("a cell of these");
    assert_eq!(experiment.n_real, chosen.real.total());
}

#[test]
fn where_nothing_is_claimed_the_chosen_cell_is_next_though_another_is_more_informative() {
    let runs = [cell_runs(0.1, [3, 2], [0, 1000])];
    let chosen = CellRuns { part: 0.5, ..cell_runs(0.2, [0, 0], [990, 10]) };
    let other = CellRuns { part: 0.01, ..cell_runs(0.3, [0, 0], [700, 300]) };
    let never = CellRuns { part: 0.5, ..cell_runs(0.4, [0, 0], [0, 1000]) };
    let comparison = Comparison::new(&runs);
    assert_eq!(comparison.verdict, Verdict::NoClaim);

    let next = next_step(&comparison, &runs, &[other.clone(), never.clone(), chosen], &unknown);
    let alike = CellRuns { part: 0.01, ..cell_runs(0.5, [0, 0], [95, 5]) };
    let without_choice = next_step(&comparison, &runs, &[other, alike], &unknown);
    let nothing = next_step(&comparison, &runs, &[never], &unknown);

    let NextStep::Run(experiment) = next else { panic!("expected a run, found {next:?}") };
    assert_eq!((experiment.cell, experiment.n_real), (cell(0.2), 0));
    let NextStep::Run(often) = without_choice else { panic!("expected a run") };
    assert_eq!(often.cell, cell(0.5), "where simulated robots do it most often");
    assert_eq!(nothing, NextStep::Nothing);
}

#[test]
fn when_all_is_supported_a_cell_that_was_not_run_is_next_and_a_certain_one_is_not() {
    let runs = [cell_runs(0.1, [40, 0], [900, 100])];
    // Where no simulated robot mills, real ones cannot mill less often.
    let never = cell_runs(0.3, [0, 0], [0, 1000]);
    let often = cell_runs(0.2, [0, 0], [700, 300]);
    let comparison = Comparison::new(&runs);
    assert_eq!(comparison.verdict, Verdict::Supported);

    let next = next_step(&comparison, &runs, &[never.clone(), often], &unknown);
    let nothing = next_step(&comparison, &runs, &[never], &unknown);

    let NextStep::Run(experiment) = next else { panic!("expected a run, found {next:?}") };
    assert_eq!((experiment.cell, experiment.n_real), (cell(0.2), 0));
    assert_eq!(nothing, NextStep::Nothing);
}

#[test]
fn without_runs_the_cell_that_decides_soonest_is_next_and_not_the_least_known_one() {
    let often = CellRuns { part: 0.01, ..cell_runs(0.1, [0, 0], [997, 3]) };
    let chosen = CellRuns { part: 0.5, ..cell_runs(0.2, [0, 0], [970, 30]) };
    let half = CellRuns { part: 0.01, ..cell_runs(0.3, [0, 0], [500, 500]) };
    let never = CellRuns { part: 0.01, ..cell_runs(0.4, [0, 0], [0, 1000]) };
    let of_cell = |runs: &CellRuns| Share::milling(&runs.simulated);
    let cells = [half.clone(), often, chosen, never.clone()];
    let as_simulated =
        |cell: &Cell| cells.iter().find(|runs| runs.cell == *cell).map(of_cell).unwrap_or_default();
    let without_runs =
        |others: &[CellRuns]| next_step(&Comparison::new(&[]), &[], others, &as_simulated);
    let found = |others: &[CellRuns]| match without_runs(others) {
        NextStep::Run(experiment) => (experiment.cell, experiment.runs.expect("it decides")),
        other => panic!("expected a run, found {other:?}"),
    };

    let (first, runs) = found(&cells);
    let alone = cells[..3].iter().map(|cell| found(std::slice::from_ref(cell)).1);

    assert_eq!(Some(runs), alone.min());
    assert_ne!(first, half.cell);
    assert_eq!(without_runs(&[never]), NextStep::Nothing);
}
