//! How often the statistics are wrong, under simulation: campaigns in which the truth is known.

use std::collections::BTreeMap;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_core::diagram::PhaseCounts;
use rsrs_core::diagram::axis::Cell;
use rsrs_core::judge::agreement::Agreement;
use rsrs_core::judge::phase::Phase;
use rsrs_core::statistics::comparison::{
    CellRuns, Comparison, MARGIN, SIGNIFICANCE, Share, Verdict, decide,
};
use rsrs_core::statistics::e_value::{CellEvidence, SimulatedShare};
use rsrs_core::statistics::interval::Interval;
use rsrs_core::statistics::next_experiment::{NextStep, next_step};
use rsrs_core::statistics::pooled::LogEvidence;

const N_CAMPAIGNS: u64 = 1000;

fn cell(speed_m_s: f64) -> Cell {
    format!("speed_m_s={speed_m_s},turn_rate_rad_s=0.75").parse().expect("a cell")
}

fn counted(n_milling: u64, n_dispersed: u64) -> PhaseCounts {
    let mut counts = PhaseCounts::default();
    counts.add_many(Phase::StableMilling, n_milling);
    counts.add_many(Phase::Dispersion, n_dispersed);
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

/// How many of [`N_CAMPAIGNS`] ever ended with each verdict, and how many were undecided to the end.
#[derive(Debug, Default)]
struct Ever {
    violated: u64,
    supported: u64,
    undecided: u64,
}

/// Sweeps behind the campaigns: as many campaigns share one.
const N_SWEEPS: u64 = 20;

impl Looks<'_> {
    fn ever(&self, seed: u64) -> Ever {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut ever = Ever::default();
        for _ in 0..N_SWEEPS {
            let mut swept = self.sweep(&mut random);
            for _ in 0..N_CAMPAIGNS / N_SWEEPS {
                let verdicts = self.campaign(&mut swept, &mut random);
                ever.violated += u64::from(verdicts.contains(&Verdict::Violated));
                ever.supported += u64::from(verdicts.contains(&Verdict::Supported));
                ever.undecided +=
                    u64::from(verdicts.iter().all(|verdict| *verdict == Verdict::Undecided));
            }
        }
        ever
    }

    fn sweep(&self, random: &mut ChaCha8Rng) -> Vec<SweptCell> {
        let mut cell = |truth: &Truth| {
            let mills = |_: &u64| random.random::<f64>() < truth.b_s;
            let hits = (0..self.n_simulated).filter(mills).count() as u64;
            let simulated = SimulatedShare::after(Share { hits, n: self.n_simulated });
            SweptCell { simulated, margin: self.margin, known: BTreeMap::new() }
        };
        self.cells.iter().map(&mut cell).collect()
    }

    fn campaign(&self, swept: &mut [SweptCell], random: &mut ChaCha8Rng) -> Vec<Verdict> {
        let mut real = vec![Share::default(); swept.len()];
        let mut evidence: Vec<CellEvidence> =
            swept.iter_mut().map(|cell| cell.evidence(Share::default())).collect();
        let mut verdicts = Vec::new();
        for run in 0..self.n_runs {
            let cell = run % real.len();
            real[cell].n += 1;
            real[cell].hits += u64::from(random.random::<f64>() < self.cells[cell].b_r);
            evidence[cell] = swept[cell].evidence(real[cell]);
            verdicts.push(decide(LogEvidence::of(&evidence)));
        }
        verdicts
    }
}

/// A simulated cell, and what is known of counts that came up before.
struct SweptCell {
    simulated: SimulatedShare,
    margin: f64,
    known: BTreeMap<(u64, u64), CellEvidence>,
}

impl SweptCell {
    fn evidence(&mut self, real: Share) -> CellEvidence {
        let found = || CellEvidence::of(real, &self.simulated, self.margin);
        self.known.entry((real.n, real.hits)).or_insert_with(found).clone()
    }
}

/// Whether so many errors agree with at most 5 %, as far as this many campaigns can show.
fn assert_rare(n_false: u64, what: &str) {
    let possible = Interval::clopper_pearson(n_false, N_CAMPAIGNS);
    assert!(possible.low <= SIGNIFICANCE, "{n_false} of {N_CAMPAIGNS} {what}, {possible:?}");
}

#[test]
fn equal_robots_are_called_worse_in_at_most_5_of_100_campaigns_with_a_look_after_every_run() {
    let equal = |b_s| Truth { b_s, b_r: b_s };
    for (seed, (cells, n_simulated)) in (1..).zip([
        (vec![equal(0.85)], 1000),
        (vec![equal(0.5)], 1000),
        (vec![equal(0.98)], 1000),
        (vec![equal(0.85)], 16),
        (vec![equal(0.2)], 16),
        ([0.8, 0.85, 0.9].map(equal).to_vec(), 100),
        (vec![equal(0.85); 9], 100),
    ]) {
        let looks = Looks { cells: &cells, n_simulated, n_runs: 100, margin: MARGIN };

        let ever = looks.ever(seed);

        assert_rare(ever.violated, "are called worse");
    }
}

#[test]
fn robots_at_the_edge_of_the_margin_are_called_as_good_in_at_most_5_of_100_campaigns() {
    let short = |b_s, by| Truth { b_s, b_r: b_s - by };
    for (seed, (cells, n_simulated, margin)) in (11..).zip([
        (vec![short(0.85, 0.1)], 1000, 0.1),
        (vec![short(0.97, 0.1)], 1000, 0.1),
        (vec![short(0.97, 0.2)], 1000, 0.2),
        (vec![short(0.6, 0.1)], 16, 0.1),
        (vec![short(0.11, 0.1)], 100, 0.1),
        // On average by as much, some much worse and some better: this is what the claim is about.
        (vec![short(0.85, 0.3), short(0.85, -0.1)], 1000, 0.1),
        (vec![short(0.85, 0.1); 9], 100, 0.1),
        (vec![short(0.95, 0.3), short(0.9, 0.1), short(0.7, -0.1)], 100, 0.1),
    ]) {
        let looks = Looks { cells: &cells, n_simulated, n_runs: 96, margin };

        let ever = looks.ever(seed);

        assert_rare(ever.supported, "are called as good");
    }
}

#[test]
fn robots_that_mill_half_as_often_are_found_out_in_nine_of_ten_campaigns() {
    let half = |b_s| Truth { b_s, b_r: b_s / 2.0 };
    for (seed, cells) in [(21, vec![half(0.85)]), (22, [0.8, 0.85, 0.9].map(half).to_vec())] {
        let looks = Looks { cells: &cells, n_simulated: 1000, n_runs: 20, margin: MARGIN };

        let ever = looks.ever(seed);

        assert!(ever.violated >= N_CAMPAIGNS * 9 / 10, "{ever:?}");
    }
}

#[test]
fn robots_that_mill_more_often_support_the_claim_in_most_campaigns() {
    for (seed, b_r, n_runs) in [(31, 0.99, 30), (32, 0.95, 64)] {
        let cells = [Truth { b_s: 0.9, b_r }];
        let looks = Looks { cells: &cells, n_simulated: 1000, n_runs, margin: MARGIN };

        let ever = looks.ever(seed);

        assert!(ever.supported * 20 >= N_CAMPAIGNS * 17, "{b_r}: {ever:?}");
    }
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

/// Nothing is known of robots as measured.
fn unknown(_: &Cell) -> Share {
    Share::default()
}

#[test]
fn a_violated_cell_sends_back_to_step_1() {
    let runs = [
        CellRuns { cell: cell(0.1), real: counted(5, 0), simulated: counted(900, 100) },
        CellRuns { cell: cell(0.2), real: counted(0, 8), simulated: counted(900, 100) },
    ];

    let next = next_step(&Comparison::of(&runs), &runs, &[], &unknown);

    let NextStep::ReturnToStep1 { cell: worst, b_r, b_s, p_corrected } = next else {
        panic!("expected step 1, found {next:?}")
    };
    assert_eq!((worst, b_r, b_s), (cell(0.2), 0.0, 0.9));
    assert!(p_corrected < SIGNIFICANCE);
}

#[test]
fn the_cell_of_which_least_is_known_is_run_next_and_the_runs_decide_it() {
    let runs = [
        // Four more mills would do here, and one more run is weak evidence on the second cell.
        CellRuns { cell: cell(0.1), real: counted(8, 0), simulated: counted(900, 100) },
        CellRuns { cell: cell(0.2), real: counted(1, 1), simulated: counted(900, 100) },
    ];
    let comparison = Comparison::of(&runs);
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
fn when_all_is_supported_a_cell_that_was_not_run_is_next_and_a_certain_one_is_not() {
    let runs = [CellRuns { cell: cell(0.1), real: counted(40, 0), simulated: counted(900, 100) }];
    // Where no simulated robot mills, real ones cannot mill less often.
    let never = CellRuns { cell: cell(0.3), real: counted(0, 0), simulated: counted(0, 1000) };
    let often = CellRuns { cell: cell(0.2), real: counted(0, 0), simulated: counted(700, 300) };
    let comparison = Comparison::of(&runs);
    assert_eq!(comparison.verdict, Verdict::Supported);

    let next = next_step(&comparison, &runs, &[never.clone(), often], &unknown);
    let nothing = next_step(&comparison, &runs, &[never], &unknown);

    let NextStep::Run(experiment) = next else { panic!("expected a run, found {next:?}") };
    assert_eq!((experiment.cell, experiment.n_real), (cell(0.2), 0));
    assert_eq!(nothing, NextStep::Nothing);
}
