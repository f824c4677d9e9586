//! A plan of experiments as a person reads it.

use std::path::Path;

use rsrs_core::comparison::Verdict;
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
use crate::comparison::{
    as_often_as_simulated, note_in_words, or_fewer, or_more, too_rarely, verdict_name,
};
use crate::json::with;
use crate::wording::shell::{experiment_beside, free};
use crate::wording::wrote;
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
    if plan.claims_nothing() {
        let words = nothing_claimed(plan.behaviour, plan.margin, &plan.cells);
        return with_note(words, plan.note.as_ref());
    }
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

/// The first of the runs that are planned on the sweep in a folder; none where nothing is claimed.
pub fn next(plan: &PlannedExperiments, folder: &Path) -> Option<String> {
    if plan.claims_nothing() {
        return None;
    }
    let first = plan.cells.iter().find(|cell| cell.is_claimed).or(plan.cells.first());
    let other = first.filter(|cell| !cell.is_chosen);
    let cell = other.map_or_else(String::new, |cell| format!(" --cell {}", cell.cell));
    Some(format!("next: rsrs run {} --from {}{cell}", experiment_beside(folder), quoted(folder)))
}

/// A plan of runs whose number is fixed before the first.
pub fn campaign_text(plan: &PlannedCampaign) -> Words {
    if plan.claims_nothing() {
        let words = nothing_claimed(plan.behaviour, plan.margin, &plan.cells);
        return with_note(words, plan.note.as_ref());
    }
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
            let or_more = or_more(least, test.n_claimed);
            format!("\nsupported if {or_more} {did} (probability {})", percent(*supported))
        }
        None => "\nno number of them supports the claim".to_owned(),
    };
    let up_to = match test.violated_up_to {
        Some(most) => {
            let or_fewer = or_fewer(most, plan.runs);
            format!("violated if {or_fewer} did (probability {})", percent(*violated))
        }
        None => "no number of them violates it".to_owned(),
    };
    with_note(first.below(cells(&plan.cells)).below(from).below(up_to), plan.note.as_ref())
}

/// What becomes of the file that a campaign was to be written into, where nothing is claimed.
pub fn not_written(output: &Path) -> String {
    format!("{} was not written, as nothing is claimed", output.display())
}

/// That a campaign was written into a file, and what comes next.
pub fn after_written(output: &Path) -> String {
    let campaign = free(output.with_extension(""));
    format!("{}\nnext: rsrs campaign {} -o {}", wrote(output), quoted(output), quoted(campaign))
}

/// How a campaign is kept that was not written into a file.
pub const TO_WRITE: &str = "next: the same command with `-o CAMPAIGN.yaml`, before the first run";

/// Why runs in some cells would decide nothing.
fn nothing_claimed(behaviour: Behaviour, margin: f64, planned: &[PlannedRuns]) -> Words {
    let of = if planned.len() == 1 { "this cell" } else { "all of these cells" };
    let without_runs = |cell: &PlannedRuns| PlannedRuns { runs: None, ..cell.clone() };
    let unplanned: Vec<PlannedRuns> = planned.iter().map(without_runs).collect();
    let too_rarely = too_rarely(behaviour.verb().plain, of, margin);
    Words::toned(Tone::Unclear, verdict_name(Verdict::NoClaim))
        .then(format!(": {too_rarely}, and runs there would not show whether they do as well"))
        .below(cells(&unplanned))
}

fn cells(cells: &[PlannedRuns]) -> String {
    let claims = |cell: &PlannedRuns| cell.is_claimed || !cells.iter().any(|it| it.is_claimed);
    let row = |cell: &PlannedRuns| {
        [
            format!("  {}", cell.cell),
            cell.runs.map_or_else(String::new, |runs| counted(runs, "run")),
            format!("B_s {} of {}", percent(cell.b_s), count(cell.n_simulated)),
            format!("as measured {} of {}", percent(cell.b_m), count(cell.n_as_measured)),
            if claims(cell) { "" } else { verdict_name(Verdict::NoClaim) }.to_owned(),
        ]
    };
    format!("\n{}", columns(&cells.iter().map(row).collect::<Vec<[String; 5]>>()))
}

fn with_note(words: Words, note: Option<&Note>) -> Words {
    match note {
        Some(note) => words.below(format!("note: {}", note_in_words(note))),
        None => words,
    }
}

/// What runs decide.
fn claim(behaviour: Behaviour, margin: f64) -> String {
    let less = if margin > 0.0 { format!(" − {margin}") } else { String::new() };
    format!(
        "whether real robots {} (`B_r ≥ B_s{less}`),",
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
    fn planned(turn_rate_rad_s: f64, mills: u64) -> PlannedRuns {
        let b_s = mills as f64 / 1000.0;
        PlannedRuns {
            cell: Cell::new([(Axis::TurnRate, turn_rate_rad_s)]).unwrap(),
            runs: Some(9),
            b_s,
            n_simulated: 1000,
            b_m: b_s,
            n_as_measured: 1000,
            is_chosen: false,
            is_claimed: b_s > 0.2,
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
        let chosen = PlannedRuns { is_chosen: true, ..planned(0.75, 900) };
        let other = planned(0.25, 800);
        let next = |cell| next(&plan(&[cell], Some(9)), Path::new("first try/out")).unwrap();

        let run = "next: rsrs run EXPERIMENT.yaml --from 'first try/out'";
        assert_eq!(next(chosen), run);
        assert_eq!(next(other), format!("{run} --cell turn_rate_rad_s=0.25"));
    }

    #[test]
    fn no_run_is_suggested_where_nothing_is_claimed() {
        let never = planned(0.25, 0);
        let often = PlannedRuns { is_chosen: true, ..planned(0.75, 900) };
        let nothing = plan(std::slice::from_ref(&never), None);

        assert_eq!(next(&nothing, Path::new("out")), None);
        assert_eq!(
            text(&nothing).to_string(),
            "no claim: simulated robots mill too rarely in this cell: perhaps in 10 % of their runs or fewer, \
             so that real ones cannot mill less often by 10 percentage points, and runs there would not show \
             whether they do as well\n\
             \n  turn_rate_rad_s=0.25    B_s 0.0 % of 1,000  as measured 0.0 % of 1,000"
        );
        let both = plan(&[never, often], Some(9));
        let run = "next: rsrs run EXPERIMENT.yaml --from out";
        assert_eq!(next(&both, Path::new("out")).as_deref(), Some(run));
        assert!(text(&both).to_string().contains("as measured 0.0 % of 1,000   no claim\n"));
    }
}
