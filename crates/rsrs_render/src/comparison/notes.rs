//! What a reader of a comparison must not overlook.

use std::collections::BTreeMap;

use rsrs_bags::trajectory::Finding;
use rsrs_core::numerals::{counted, percent};
use rsrs_core::quantity::Cell;
use rsrs_fleet::record::{Backend, ExperimentRecord, OwnProfile};
use rsrs_pipeline::compare::not_counted::NotCountedCause;
use rsrs_pipeline::compare::prediction::{Note, choose_line};
use rsrs_pipeline::compare::run_matching::Admitted;
use rsrs_pipeline::compare::{Comparison, Runs};
use rsrs_pipeline::label::Labelled;

/// A run that counts, with its cell and label.
type Counted = (Cell, Admitted, Labelled);

/// What is to be known of a comparison.
pub fn of(comparison: &Comparison) -> Vec<String> {
    let runs = &comparison.runs;
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
    for cause in NotCountedCause::ALL {
        let n = runs.left_out.iter().filter(|run| run.not_counted.cause == cause).count();
        if let (1.., Some(option)) = (n, option(cause)) {
            let cause = cause_in_words(cause);
            notes.push(format!("{}: {cause}; {option}", counted(n as u64, "run")));
        }
    }
    notes.extend(comparison.note.as_ref().map(note_in_words));
    notes
}

/// That some robots are not what the sweep has them for, which is made from the profiles of the fleet and of classes.
fn own_profiles(runs: &Runs) -> Option<String> {
    let all = runs.counted.iter().map(|(_, run, _)| other_than_swept(&run.record));
    let with: Vec<_> = all.filter(|own| !own.is_empty()).collect();
    let mut robots: BTreeMap<&String, &OwnProfile> = BTreeMap::new();
    robots.extend(with.iter().flatten());
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

/// Robots with a profile of their own that is not that of their class.
fn other_than_swept(record: &ExperimentRecord) -> BTreeMap<&String, &OwnProfile> {
    let world = &record.conditions.world;
    let classes = world.robots_with_profiles(record.robots.len());
    let of_classes: Vec<&String> = classes.map(|(place, _, _)| &record.robots[place]).collect();
    record.own_profiles.iter().filter(|(robot, _)| !of_classes.contains(robot)).collect()
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

/// That robots or objects did not start where the record of their run places them, which belongs to the experiment.
fn misplaced(deviations: &[String]) -> Option<String> {
    let (first, others) = deviations.split_first()?;
    let more = match others.len() {
        0 => String::new(),
        n => format!(", and {n} more (`rsrs label` lists them)"),
    };
    Some(format!("did not start as its experiment has it: {first}{more}"))
}

/// What a reader of what rests on a prediction must not overlook.
pub fn note_in_words(note: &Note) -> String {
    match note {
        Note::NothingChosen(folder) => format!(
            "{} has no choice.json; a cell that was picked from this sweep looks better \
             than it is, until `{}` confirms it",
            folder.display(),
            choose_line(folder)
        ),
        Note::WorseIsBetter { choice, measured } => {
            let mill = choice.behaviour().verb().plain;
            format!(
                "in the chosen cell, simulated robots as measured {mill} in {} of {} runs, and made \
                 worse in {}: being worse helps there, and that fewer real ones {mill} needs no other \
                 reason",
                percent(measured.share),
                measured.n_replicates,
                percent(choice.b_s)
            )
        }
    }
}

/// Why a run does not count, in front of its reason.
pub fn cause_in_words(cause: NotCountedCause) -> &'static str {
    match cause {
        NotCountedCause::Void => "void",
        NotCountedCause::Aborted => "aborted",
        NotCountedCause::Failed => "failed",
        NotCountedCause::RobotLost => "went on without a robot",
        NotCountedCause::Incomplete => "not whole",
        NotCountedCause::MadeAgain => "made again",
        NotCountedCause::Implausible => "implausible",
        NotCountedCause::NotLabelled => "not labelled",
    }
}

/// What can be done about it, beside leaving the run out; `None` if that is all.
fn option(cause: NotCountedCause) -> Option<&'static str> {
    match cause {
        NotCountedCause::RobotLost => Some("`--with-lost-robots` counts such runs, too"),
        NotCountedCause::Implausible => Some("`--with-implausible` counts such runs, too"),
        NotCountedCause::Void
        | NotCountedCause::Aborted
        | NotCountedCause::Failed
        | NotCountedCause::Incomplete
        | NotCountedCause::MadeAgain
        | NotCountedCause::NotLabelled => None,
    }
}
