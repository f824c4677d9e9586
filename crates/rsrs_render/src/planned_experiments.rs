//! A plan of experiments as a person reads it.

use std::path::Path;

use rsrs_core::comparison::experiment_plan::Decided;
use rsrs_core::comparison::fixed::FixedPlan;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::numerals::{count, counted, percent};
use rsrs_files::quoted;
use rsrs_pipeline::compare::prediction::Note;
use rsrs_pipeline::plan_experiments::fixed::PlannedCampaign;
use rsrs_pipeline::plan_experiments::{PlannedExperiments, PlannedRuns};
use serde::Serialize;

use crate::columns::columns;
use crate::comparison::{as_often_as_simulated, note_in_words};
use crate::json::with;
use crate::wording::shell::experiment_beside;
use crate::words::{Tone, Words};

/// So many lines of the table show how the probability grows.
const LINES: usize = 8;

/// A plan as JSON, with its note.
pub fn json<T: Serialize>(plan: &T, note: Option<&Note>) -> impl Serialize {
    with(plan, "notes", note.map(note_in_words).into_iter().collect::<Vec<String>>())
}

/// A plan with a look after every run.
///
/// # Panics
///
/// Never: at least one run is planned.
pub fn text(plan: &PlannedExperiments) -> Words {
    let last = plan.by_runs.last().expect("at least one run is planned");
    let (claim, decided) = (claim(plan.behaviour, plan.margin), percent(last.decided));
    let first = match plan.runs {
        Some(runs) => Words::from(format!(
            "{} decide {claim} with a probability of {decided}, if the robots are as measured",
            counted(runs, "run")
        )),
        None => Words::toned(Tone::Bad, "not even").then(format!(
            " {} decide {claim} with a probability of {}, if the robots are as measured: it is {decided}",
            counted(last.runs, "run"),
            percent(plan.wanted)
        )),
    };
    let mut rows = vec![["runs", "decided", "supported", "violated"].map(str::to_owned)];
    rows.extend(shown(plan).iter().map(row));
    let words =
        first.below(cells(&plan.cells)).below(format!("\n{}", columns(&rows))).below(format!(
            "\ncompare after every run, and stop as soon as it is decided: on average after {:.0}",
            plan.mean_runs
        ));
    with_note(words, plan.note.as_ref())
}

/// The first of the runs that are planned on the sweep in a folder.
pub fn next(plan: &PlannedExperiments, folder: &Path) -> String {
    let other = plan.cells.first().filter(|cell| !cell.is_chosen);
    let cell = other.map_or_else(String::new, |cell| format!(" --cell {}", cell.cell));
    format!("next: rsrs run {} --from {}{cell}", experiment_beside(folder), quoted(folder))
}

/// A plan of runs whose number is fixed before the first.
pub fn campaign_text(plan: &PlannedCampaign) -> Words {
    let FixedPlan { test, decided, supported, violated, .. } = &plan.plan;
    let claim = format!(
        "{}, their number fixed before the first, decide {} with a probability of",
        counted(plan.runs, "run"),
        claim(plan.behaviour, plan.margin)
    );
    let (if_measured, decided) = ("if the robots are as measured", percent(*decided));
    let first = if plan.is_enough() {
        Words::from(format!("{claim} {decided}, {if_measured}"))
    } else {
        let wanted = percent(plan.wanted);
        let rest = format!(" {claim} {wanted}: it is {decided}, {if_measured}");
        Words::toned(Tone::Bad, "not even").then(rest)
    };
    let did = plan.behaviour.verb().did;
    let from = match test.supported_from {
        Some(least) => {
            format!("\nsupported if {least} or more {did} (probability {})", percent(*supported))
        }
        None => "\nno number of them supports the claim".to_owned(),
    };
    let up_to = match test.violated_up_to {
        Some(most) => {
            format!("violated if {most} or fewer did (probability {})", percent(*violated))
        }
        None => "no number of them violates it".to_owned(),
    };
    with_note(first.below(cells(&plan.cells)).below(from).below(up_to), plan.note.as_ref())
}

fn cells(cells: &[PlannedRuns]) -> String {
    let row = |cell: &PlannedRuns| {
        [
            format!("  {}", cell.cell),
            cell.runs.map_or_else(String::new, |runs| counted(runs, "run")),
            format!("B_s {} of {}", percent(cell.b_s), count(cell.n_simulated)),
            format!("as measured {} of {}", percent(cell.b_m), count(cell.n_as_measured)),
        ]
    };
    format!("\n{}", columns(&cells.iter().map(row).collect::<Vec<[String; 4]>>()))
}

fn with_note(words: Words, note: Option<&Note>) -> Words {
    match note {
        Some(note) => words.below(format!("note: {}", note_in_words(note))),
        None => words,
    }
}

/// What runs decide.
fn claim(behaviour: Behaviour, margin: f64) -> String {
    format!(
        "whether real robots {} (`B_r ≥ B_s − {margin}`),",
        as_often_as_simulated(behaviour.verb().plain, margin)
    )
}

/// Some of the numbers of runs, evenly spaced, the last one among them.
fn shown(plan: &PlannedExperiments) -> Vec<Decided> {
    let step = plan.by_runs.len().div_ceil(LINES);
    let mut shown: Vec<Decided> = plan.by_runs.iter().rev().step_by(step).copied().collect();
    shown.reverse();
    shown
}

fn row(decided: &Decided) -> [String; 4] {
    let Decided { runs, decided, supported, violated } = decided;
    [count(*runs), percent(*decided), percent(*supported), percent(*violated)]
}

#[cfg(test)]
mod tests {
    use rsrs_core::quantity::{Axis, Cell};

    use super::*;

    /// A cell, in which simulated robots do as is wanted in so many of 1,000 runs.
    fn planned(turn_rate_rad_s: f64, mills: u64, is_chosen: bool) -> PlannedRuns {
        let b_s = mills as f64 / 1000.0;
        PlannedRuns {
            cell: Cell::new([(Axis::TurnRate, turn_rate_rad_s)]).unwrap(),
            runs: Some(9),
            b_s,
            n_simulated: 1000,
            b_m: b_s,
            n_as_measured: 1000,
            is_chosen,
        }
    }

    fn plan(cells: &[PlannedRuns], runs: Option<u64>) -> PlannedExperiments {
        PlannedExperiments {
            behaviour: Behaviour::MILLING,
            runs,
            wanted: 0.8,
            margin: 0.1,
            cells: cells.to_vec(),
            mean_runs: 7.0,
            by_runs: vec![Decided { runs: 9, decided: 0.85, supported: 0.85, violated: 0.0 }],
            note: None,
        }
    }

    #[test]
    fn the_run_that_comes_next_is_in_the_cell_that_was_planned() {
        let (chosen, other) = (planned(0.75, 900, true), planned(0.25, 800, false));
        let next = |cell| next(&plan(&[cell], Some(9)), Path::new("first try/out"));

        let run = "next: rsrs run EXPERIMENT.yaml --from 'first try/out'";
        assert_eq!(next(chosen), run);
        assert_eq!(next(other), format!("{run} --cell turn_rate_rad_s=0.25"));
    }
}
