//! The report of a comparison.

mod text;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rsrs_bags::trajectory::Finding;
use rsrs_core::comparison::left_out::Attempts;
use rsrs_core::comparison::next_experiment::{NextStep, return_to_step_1};
use rsrs_core::comparison::{CellComparison, CellRuns, Comparison, Tally, Verdict};
use rsrs_core::diagram::sweep_file::SEED_LIMIT;
use rsrs_core::judge::behaviour::{Behaviour, Verb};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Cell;
use rsrs_core::robot::other_profile::ProfilesDiffer;
use rsrs_core::statistics::pooled::Pooled;
use rsrs_fleet::experiment::ExperimentFile;
use rsrs_fleet::record::{Backend, ExperimentRecord, OwnProfile};
use rsrs_view::diagram::ExperimentMark;
use serde::Serialize;

pub use text::evidence;

use crate::compare::fixed::FixedCampaign;
use crate::compare::not_counted::{Cause, NotCounted};
use crate::compare::run_matching::Admitted;
use crate::label::Labelled;
use crate::label::human_labels::JUDGE;
use crate::wording::shell::{ANY_EXPERIMENT, experiment_file_beside, quoted};

/// Recorded runs, held against a sweep.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// What follows from all runs together, whatever those that were left out after their start would
    /// have come to.
    pub verdict: Verdict,
    /// What it means, or rests on, in a few words.
    pub summary: String,
    /// All runs of all cells together that count, on which the verdict rests.
    pub pooled: Pooled,
    /// If undecided: further real runs that would support the claim if all of them mill; `null` also if
    /// no number that a laboratory runs would.
    pub further_runs: Option<u64>,
    /// Who labelled the runs.
    pub labels: String,
    /// Cell by cell, in the order of the sweep.
    pub cells: Vec<ComparedCell>,
    /// Run by run, beside the phase that most simulated runs ended in.
    pub tally: Tally,
    /// The runs that count.
    pub bags: Vec<ComparedBag>,
    /// The runs that do not.
    pub not_counted: Vec<NotCounted>,
    /// Where the campaign stands, if its number of runs was fixed before the first: the verdict rests on
    /// its test then, and not on the evidence. Not there else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixed: Option<FixedCampaign>,
    /// Those among them that were left out for a cause after their start; not there if none was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_out: Option<LeftOut>,
    /// Notes for the reader.
    pub notes: Vec<String>,
    /// The experiment that is most informative, or back to the robots.
    pub next: NextStep,
    /// The files by which it is run; the reader has them.
    #[serde(skip)]
    pub at_hand: AtHand,
}

/// The files that the next experiment takes.
#[derive(Clone, Debug)]
pub struct AtHand {
    /// The experiment file, as a word of a command.
    pub experiment: String,
    /// The folder of the sweep, likewise.
    pub sweep: String,
    /// What else the command takes, so that the run is another one than those that there are.
    pub options: String,
}

/// The experiment file beside a sweep, if it is that of the runs; else a name to replace.
fn experiment_of(sweep: &Path, all: &[Admitted]) -> String {
    let is_theirs = |path: &PathBuf| {
        let text = rsrs_files::read_text(path).unwrap_or_default();
        let lasts = |duration_s: f64| {
            all.iter().all(|run| run.record.duration_s.total_cmp(&duration_s).is_eq())
        };
        ExperimentFile::parse("", &text).is_ok_and(|file| lasts(file.duration_s))
    };
    let there = experiment_file_beside(sweep).filter(is_theirs);
    there.map_or_else(|| ANY_EXPERIMENT.to_owned(), quoted)
}

impl AtHand {
    /// Those of a sweep, with the experiment file that lies beside it, if one does.
    ///
    /// # Arguments
    ///
    /// * `all` — the runs that there are.
    ///
    /// # Panics
    ///
    /// Never: there are more numbers than folders.
    pub fn of(sweep: &Path, all: &[Admitted]) -> Self {
        let is_of = |backend| all.iter().any(|run| run.record.backend == backend);
        let mut options = Vec::new();
        if is_of(Backend::Fleet) || is_of(Backend::Mixed) {
            options.push("--backend fleet --interface NAME".to_owned());
        } else if let Some(last) = all.iter().map(|run| run.record.seed).max() {
            // The same seed is the same run.
            options.push(format!("--seed {}", last.saturating_add(1) % SEED_LIMIT));
        }
        let mut names = (1 + all.len()..).map(|number| PathBuf::from(format!("run_{number}")));
        let bag = names.find(|bag| !bag.exists()).expect("there are more numbers than folders");
        options.push(format!("-o {}", quoted(bag)));
        let options = options.join(" ");
        Self { experiment: experiment_of(sweep, all), sweep: quoted(sweep), options }
    }
}

/// One cell, compared.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedCell {
    /// The cell.
    pub cell: Cell,
    /// What follows from its runs alone, corrected for the number of cells; violated only if all cells
    /// together are.
    pub verdict: Verdict,
    /// Number of real runs.
    pub n_real: u64,
    /// Share of real runs in stable milling.
    pub b_r: f64,
    /// Lower bound of its 95 % interval.
    pub b_r_low: f64,
    /// Upper bound.
    pub b_r_high: f64,
    /// How real runs ended.
    pub real: PhaseCounts,
    /// Number of simulated runs.
    pub n_simulated: u64,
    /// Share of simulated runs in stable milling.
    pub b_s: f64,
    /// Lower bound of its 95 % interval.
    pub b_s_low: f64,
    /// Upper bound.
    pub b_s_high: f64,
    /// How simulated runs ended.
    pub simulated: PhaseCounts,
    /// Whether the simulated runs are fresh ones, which did not choose the cell.
    pub is_confirmed: bool,
    /// Its part of the error, fixed before the first run: by itself it is decided from 20 over that on.
    pub part: f64,
    /// Evidence that `B_r < B_s`, however often one looked.
    pub e_violated: f64,
    /// Evidence that `B_r >= B_s - margin`, however often one looked; `null` if nothing is claimed, because the
    /// simulated share may be no greater than the margin.
    pub e_supported: Option<f64>,
    /// If undecided: further real runs that would support the claim if all of them mill.
    pub further_runs: Option<u64>,
}

/// One run that counts.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedBag {
    /// Its cell.
    pub cell: Cell,
    /// Its label.
    #[serde(flatten)]
    pub labelled: Labelled,
    /// That its robots have another profile than those of the sweep; not there if they do not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_profile: Option<ProfilesDiffer>,
    /// How it was set up; in its bag, and not written again.
    #[serde(skip)]
    pub record: ExperimentRecord,
}

impl ComparedBag {
    /// Its name: that of its bag.
    pub fn name(&self) -> String {
        self.labelled.bag.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// Simulated runs of one cell.
#[derive(Clone, Copy, Debug)]
pub struct Simulated {
    /// How they ended.
    pub phases: PhaseCounts,
    /// Whether they are fresh ones, which did not choose the cell.
    pub is_confirmed: bool,
}

/// The runs of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Runs {
    /// Those that count, with cell and label.
    pub counted: Vec<(Cell, Admitted, Labelled)>,
    /// Those that do not.
    pub left_out: Vec<LeftOutRun>,
}

/// A run that does not count, with the index of its cell in the diagram.
#[derive(Clone, Debug)]
pub struct LeftOutRun {
    /// The index.
    pub cell: usize,
    /// Which run it is of those whose number was fixed.
    pub number: Option<u64>,
    /// The run.
    pub not_counted: NotCounted,
}

impl Runs {
    /// Adds a run that does not count.
    pub fn leave_out(&mut self, cell: &Cell, run: Admitted, (cause, reason): (Cause, String)) {
        let not_counted = NotCounted {
            cell: cell.clone(),
            cause,
            ending: run.ending.as_ref().map_or("unknown", |ending| ending.kind.key()),
            reason,
            lost_robots: run.lost().to_vec(),
            after_start: run.has_started,
            bag: run.bag,
        };
        let number = run.record.fixed.map(|fixed| fixed.number);
        self.left_out.push(LeftOutRun { cell: run.cell, number, not_counted });
    }
}

/// Runs that were left out for a cause after their start, and what the verdict would be with them.
#[derive(Clone, Debug, Serialize)]
pub struct LeftOut {
    /// Their bags.
    pub bags: Vec<PathBuf>,
    /// The verdict without them.
    pub verdict_without: Verdict,
    /// The verdict if each of them is counted as not milling.
    pub verdict_if_none_milled: Verdict,
    /// The verdict if each of them is counted as milling.
    pub verdict_if_all_milled: Verdict,
}

impl Report {
    /// Makes the report of a comparison.
    ///
    /// # Arguments
    ///
    /// * `attempts` — the statistics, with what they rest on.
    /// * `simulated` — the simulated runs of each cell that was compared.
    /// * `runs` — the runs behind it.
    /// * `next` — what to do next, and the files that it takes.
    pub fn new(
        attempts: &Attempts,
        simulated: &[Simulated],
        runs: Runs,
        (next, at_hand): (NextStep, AtHand),
    ) -> Self {
        let (comparison, cells) = (&attempts.counted, &attempts.cells[0]);
        let compared = comparison.cells.iter().zip(cells.iter().zip(simulated));
        let of_cell = |cell: &CellComparison, runs: &CellRuns, simulated: Simulated| ComparedCell {
            verdict: attempts.verdict_of(&cell.cell),
            ..of_cell(cell, runs, simulated)
        };
        let left_out = left_out(attempts, &runs);
        let notes = notes(&runs);
        let simulated_phases = cells.first().map(|runs| runs.simulated.behaviour());
        let behaviour = simulated_phases.unwrap_or_default();
        let not_counted = runs.left_out.into_iter().map(|run| run.not_counted);
        let bags = runs.counted.into_iter().map(|(cell, run, labelled)| ComparedBag {
            cell,
            labelled,
            other_profile: run.other_profile,
            record: run.record,
        });
        Self {
            verdict: attempts.verdict(),
            summary: summary(attempts, behaviour.verb()),
            pooled: comparison.pooled,
            further_runs: attempts.deciding().0.further_runs,
            labels: JUDGE.to_owned(),
            cells: compared
                .map(|(cell, (runs, simulated))| of_cell(cell, runs, *simulated))
                .collect(),
            tally: comparison.tally,
            bags: bags.collect(),
            not_counted: not_counted.collect(),
            fixed: None,
            left_out,
            notes,
            next,
            at_hand,
        }
    }

    /// Lets the verdict rest on the test of a design: it is given once, and there is none before, nor one
    /// for a cell by itself.
    ///
    /// # Arguments
    ///
    /// * `counted` — the runs that count.
    pub fn rest_on(&mut self, fixed: FixedCampaign, counted: &Comparison) {
        self.verdict = fixed.verdict;
        self.summary = text::of_fixed(&fixed, self.verb(), &self.pooled);
        self.further_runs = None;
        self.left_out = None;
        for cell in &mut self.cells {
            (cell.verdict, cell.further_runs) = (Verdict::Undecided, None);
        }
        self.next = if fixed.verdict == Verdict::Violated {
            return_to_step_1(counted)
        } else {
            NextStep::Nothing
        };
        self.fixed = Some(fixed);
    }

    /// The behaviour that is compared.
    pub fn behaviour(&self) -> Behaviour {
        self.cells.first().map_or(Behaviour::default(), |cell| cell.simulated.behaviour())
    }

    /// Whether a run that should count cannot be looked at.
    pub fn has_lost_evidence(&self) -> bool {
        self.not_counted.iter().any(|run| run.cause.is_lost_evidence())
    }

    fn verb(&self) -> Verb {
        self.behaviour().verb()
    }

    /// The real runs as marks on a phase diagram.
    pub fn marks(&self) -> Vec<ExperimentMark> {
        let kind = |run: &ComparedBag| {
            let is_simulated = run.record.backend != Backend::Fleet;
            (run.labelled.phase, !run.labelled.is_borderline(), is_simulated)
        };
        let mark = |cell: &ComparedCell, its: (Phase, bool, bool)| {
            let is_here = |run: &&ComparedBag| run.cell == cell.cell && kind(run) == its;
            let names: Vec<String> =
                self.bags.iter().filter(is_here).map(ComparedBag::name).collect();
            let (cell, n) = (cell.cell.clone(), names.len() as u64);
            let (phase, is_settled, is_simulated) = its;
            (n > 0).then_some(ExperimentMark { cell, phase, is_settled, is_simulated, n, names })
        };
        let each = [true, false];
        let kinds = Phase::ALL.into_iter().flat_map(|phase| {
            each.into_iter().flat_map(move |is_settled| {
                each.map(|is_simulated| (phase, is_settled, is_simulated))
            })
        });
        let kinds: Vec<_> = kinds.collect();
        let of_cell = |cell| kinds.iter().filter_map(move |kind| mark(cell, *kind));
        self.cells.iter().flat_map(of_cell).collect()
    }
}

fn of_cell(cell: &CellComparison, runs: &CellRuns, simulated: Simulated) -> ComparedCell {
    ComparedCell {
        cell: cell.cell.clone(),
        verdict: cell.verdict,
        n_real: cell.real.n,
        b_r: cell.real.value(),
        b_r_low: cell.real_interval.low,
        b_r_high: cell.real_interval.high,
        real: runs.real,
        n_simulated: cell.simulated.n,
        b_s: cell.simulated.value(),
        b_s_low: cell.simulated_interval.low,
        b_s_high: cell.simulated_interval.high,
        simulated: runs.simulated,
        is_confirmed: simulated.is_confirmed,
        part: cell.part,
        e_violated: cell.e_violated,
        e_supported: cell.e_supported,
        further_runs: cell.further_runs,
    }
}

/// The runs that were left out for a cause after their start, with the verdict in each case.
fn left_out(attempts: &Attempts, runs: &Runs) -> Option<LeftOut> {
    let after_start = runs.left_out.iter().filter(|run| run.not_counted.after_start);
    let bags: Vec<PathBuf> = after_start.map(|run| run.not_counted.bag.clone()).collect();
    (!bags.is_empty()).then_some(LeftOut {
        bags,
        verdict_without: attempts.counted.verdict,
        verdict_if_none_milled: attempts.if_none.verdict,
        verdict_if_all_milled: attempts.if_all.verdict,
    })
}

/// Over how many runs and cells a claim is.
fn runs_that_claim(pooled: &Pooled) -> String {
    let Pooled { n_real_claimed, n_cells_claimed, .. } = pooled;
    format!("{} in {}", counted(*n_real_claimed, "run"), counted(*n_cells_claimed as u64, "cell"))
}

/// What is violated.
fn less_often(mill: &str) -> String {
    format!("real robots {mill} less often than simulated ones")
}

/// What is supported.
fn as_often(pooled: &Pooled, mill: &str) -> String {
    format!(
        "averaged over {}, real robots {mill} as often as simulated ones, or at most {:.0} percentage \
         points less often",
        runs_that_claim(pooled),
        100.0 * pooled.margin
    )
}

/// The share that runs support.
fn supported_share(pooled: &Pooled) -> String {
    let share = pooled.b_r_at_least.unwrap_or_default();
    format!("B_r >= {share:.2}, at 95 %")
}

fn summary(attempts: &Attempts, verb: Verb) -> String {
    let mill = verb.plain;
    let comparison = &attempts.counted;
    if attempts.verdict() != comparison.verdict {
        let word = text::word(comparison.verdict);
        return format!(
            "{word} by the runs that count alone, which does not stand whatever those came to that \
             were left out after their start"
        );
    }
    let n_cells = comparison.cells.len();
    match comparison.verdict {
        Verdict::Violated if n_cells > 1 => {
            let is_named = |cell: &&CellComparison| cell.verdict == Verdict::Violated;
            let named = comparison.cells.iter().filter(is_named).count();
            let where_ = match named {
                0 => "no single one of which shows it alone".to_owned(),
                n => format!("and {n} of them by themselves"),
            };
            format!(
                "real robots {mill} less often than simulated ones in these {n_cells} cells together, \
                 {where_}"
            )
        }
        Verdict::Violated => less_often(mill),
        Verdict::Supported => {
            let share = supported_share(&comparison.pooled);
            format!("{}: {share}", as_often(&comparison.pooled, mill))
        }
        Verdict::NoClaim => {
            let cells = if n_cells == 1 { "the cell" } else { "all of the cells" };
            let cells = format!("{cells} that {} run", if n_cells == 1 { "was" } else { "were" });
            let margin = 100.0 * comparison.pooled.margin;
            format!(
                "simulated robots {mill} too rarely in {cells}: perhaps in {margin:.0} % of their runs or \
                 fewer, so that real ones cannot {mill} less often by {margin:.0} percentage points, and \
                 further runs there would not show whether they do as well"
            )
        }
        Verdict::Undecided if n_cells == 0 => "no run counts".to_owned(),
        Verdict::Undecided => match comparison.further_runs {
            Some(n) => format!(
                "the runs do not decide yet; {} would support the claim if every one of them {}",
                counted(n, "further real run"),
                verb.does
            ),
            None => "the runs do not decide yet".to_owned(),
        },
    }
}

/// A run that counts, with its cell and label.
type Counted = (Cell, Admitted, Labelled);

fn notes(runs: &Runs) -> Vec<String> {
    let counted_runs = counted(runs.counted.len() as u64, "run");
    let in_some = |holds: &dyn Fn(&Counted) -> bool, what: &str| {
        let n = runs.counted.iter().filter(|run| holds(run)).count();
        (n > 0).then(|| format!("in {n} of {counted_runs} {what}"))
    };
    let is_guessed = |(_, _, labelled): &Counted| {
        labelled.findings.iter().any(|finding| matches!(finding, Finding::Unstated { .. }))
    };
    let mut notes: Vec<String> = [
        in_some(
            &|(_, run, _)| run.record.backend == Backend::Simulator,
            "the simulator stood in for real robots",
        ),
        in_some(
            &|(_, run, _)| !run.record.controller_only.is_empty(),
            "the lease of some robots was their controller's only",
        ),
        in_some(
            &is_guessed,
            "nothing states which poses count, and there are several: `rsrs label` names those that \
             were taken, `--poses` takes others",
        ),
    ]
    .into_iter()
    .flatten()
    .collect();
    let of_others = || runs.counted.iter().filter_map(|(_, run, _)| run.other_profile.as_ref());
    if let Some(differ) = of_others().next() {
        let n_others = of_others().count();
        notes.push(format!(
            "in {n_others} of {counted_runs} the robots are not those that were swept \
             (`--other-profile`): {differ}"
        ));
    }
    notes.extend(own_profiles(runs));
    notes.extend(pauses(runs));
    notes.extend(runs.counted.iter().flat_map(of_one_run));
    for cause in Cause::ALL {
        let n = runs.left_out.iter().filter(|run| run.not_counted.cause == cause).count();
        if let (1.., Some(option)) = (n, cause.option()) {
            notes.push(format!("{}: {cause}; {option}", counted(n as u64, "run")));
        }
    }
    notes
}

/// That some robots are not what the sweep has them all for, which is made from the fleet's profile.
fn own_profiles(runs: &Runs) -> Option<String> {
    let all = runs.counted.iter().map(|(_, run, _)| &run.record.own_profiles);
    let with: Vec<_> = all.filter(|own| !own.is_empty()).collect();
    let mut robots: BTreeMap<&String, &OwnProfile> = BTreeMap::new();
    robots.extend(with.iter().copied().flatten());
    let robots: Vec<String> =
        robots.iter().map(|(robot, own)| format!("{robot} ({own})")).collect();
    (!with.is_empty()).then(|| {
        format!(
            "in {} of {} robots had a profile of their own, and the sweep is of the fleet's: {}",
            with.len(),
            counted(runs.counted.len() as u64, "run"),
            robots.join("; ")
        )
    })
}

/// That robots stood for a moment.
fn pauses(runs: &Runs) -> Option<String> {
    let of_run = runs.counted.iter().map(|(_, run, _)| run.paused());
    let paused: Vec<_> = of_run.filter(|pauses| !pauses.is_empty()).collect();
    let pauses = || paused.iter().flat_map(|pauses| pauses.iter());
    let stood_s: f64 = pauses().map(|pause| pause.stood_s).sum();
    (!paused.is_empty()).then(|| {
        format!(
            "in {} of {} robots stood for a moment, as leases did not reach them: {} of at most \
             {stood_s:.1} s in all",
            paused.len(),
            counted(runs.counted.len() as u64, "run"),
            counted(pauses().count() as u64, "pause"),
        )
    })
}

/// What is to be known of a run that counts.
fn of_one_run((_, run, labelled): &Counted) -> Vec<String> {
    let bag = labelled.bag.display();
    let counts_though = |found: Vec<String>| {
        (!found.is_empty()).then(|| format!("{bag} counts, though {}", found.join("; ")))
    };
    let lost = counts_though(run.lost().iter().map(ToString::to_string).collect());
    let start = misplaced(&labelled.misplaced).map(|text| format!("{bag} {text}"));
    let implausible = labelled.implausible.iter().map(|found| found.text.clone());
    [lost, start, counts_though(implausible.collect())].into_iter().flatten().collect()
}

/// That robots did not start where the record of their run places them, which belongs to the experiment.
fn misplaced(deviations: &[String]) -> Option<String> {
    let (first, others) = deviations.split_first()?;
    let more = match others.len() {
        0 => String::new(),
        n => format!(", and {n} more (`rsrs label` lists them)"),
    };
    Some(format!("did not start as its experiment places robots: {first}{more}"))
}

fn counted(n: u64, what: &str) -> String {
    if n == 1 { format!("{n} {what}") } else { format!("{n} {what}s") }
}
