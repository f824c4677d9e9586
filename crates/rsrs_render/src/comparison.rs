//! The report of a comparison.

mod notes;
mod text;

use std::path::PathBuf;

use rsrs_core::comparison::left_out::Attempts;
use rsrs_core::comparison::next_experiment::NextStep;
use rsrs_core::comparison::{CellComparison, CellRuns, Tally, Verdict};
use rsrs_core::judge::behaviour::{Behaviour, Verb};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Cell;
use rsrs_core::robot::other_profile::ProfilesDiffer;
use rsrs_core::statistics::pooled::Pooled;
use rsrs_fleet::record::{Backend, ExperimentRecord};
use rsrs_pipeline::compare::at_hand::AtHand;
use rsrs_pipeline::compare::fixed::FixedCampaign;
use rsrs_pipeline::compare::not_counted::NotCounted;
use rsrs_pipeline::compare::prediction::Simulated;
use rsrs_pipeline::compare::{Comparison, Runs};
use rsrs_pipeline::label::Labelled;
use rsrs_view::diagram::ExperimentMark;
use serde::Serialize;

pub use notes::{cause_in_words, note_in_words};
pub use text::{
    as_often_as_simulated, evidence, next_in_words, or_fewer, or_more, reason_in_words, text,
    too_rarely, verdict_name,
};

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
    pub fn new(comparison: Comparison) -> Self {
        let notes = notes::of(&comparison);
        let Comparison { attempts, simulated, runs, fixed, .. } = comparison;
        let (counted, runs_of_cells) = (&attempts.counted, &attempts.cells[0]);
        let behaviour = runs_of_cells.first().map(|runs| runs.simulated.behaviour());
        let verb = behaviour.unwrap_or_default().verb();
        let compared = counted.cells.iter().zip(runs_of_cells.iter().zip(&simulated));
        let cell = |(cell, (runs, simulated)): (&CellComparison, (&CellRuns, &Simulated))| {
            let compared = of_cell(cell, runs, *simulated);
            if fixed.is_some() {
                // The test of a design is one for all cells.
                return ComparedCell {
                    verdict: Verdict::Undecided,
                    further_runs: None,
                    ..compared
                };
            }
            ComparedCell { verdict: attempts.verdict_of(&cell.cell), ..compared }
        };
        let further_runs = attempts.deciding().0.further_runs;
        Self {
            verdict: comparison.verdict,
            summary: match &fixed {
                Some(fixed) => text::of_fixed(fixed, verb, &counted.pooled),
                None => text::summary(&attempts, verb),
            },
            pooled: counted.pooled,
            further_runs: further_runs.filter(|_| fixed.is_none()),
            labels: comparison.labels.to_string(),
            cells: compared.map(cell).collect(),
            tally: counted.tally,
            left_out: left_out(&attempts, &runs).filter(|_| fixed.is_none()),
            bags: runs
                .counted
                .into_iter()
                .map(|(cell, run, labelled)| ComparedBag {
                    cell,
                    labelled,
                    other_profile: run.other_profile,
                    record: run.record,
                })
                .collect(),
            not_counted: runs.left_out.into_iter().map(|run| run.not_counted).collect(),
            fixed,
            notes,
            next: comparison.next,
            at_hand: comparison.at_hand,
        }
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
        let kinds = Phase::all().flat_map(|phase| {
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
