//! A choice as a person reads it, and other starts and numbers of robots.

use std::path::Path;

use rsrs_core::diagram::choice::{Choice, DenserStart, Margin, OtherNumber};
use rsrs_core::diagram::folder::CHOICE;
use rsrs_core::judge::behaviour::Verb;
use rsrs_core::numerals::{count, counted, percent, percents};
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::harsher::tidy;

use rsrs_files::quoted;
use rsrs_pipeline::choose::extension::Extension;
use rsrs_pipeline::choose::pseudo_realities::InPseudoRealities;
use rsrs_pipeline::choose::with_factors::ChosenWithFactors;
use rsrs_pipeline::choose::{BestSwept, Chosen, NoViableCell};
use rsrs_pipeline::sweep::ablation::Ablation;
use serde::Serialize;

use crate::factors;
use crate::settling;
use crate::wording::shell::{experiment_beside, free_beside, sweep_beside};
use crate::wording::wrote;
use crate::words::{Tone, Words};

/// An answer of `rsrs choose` as JSON: the choice, or why there is none, and what else is known of the cell.
#[derive(Serialize)]
pub struct ChosenJson<'a> {
    #[serde(flatten)]
    answer: AnswerJson<'a>,
    /// What every factor does in that cell; `null` if none changes a robot.
    factors: Option<&'a Ablation>,
    /// What comes of all cells in pseudo-realities, where they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pseudo_realities: Option<&'a InPseudoRealities>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum AnswerJson<'a> {
    Viable(&'a Choice),
    NoViableCell(NoViableCellJson<'a>),
}

impl<'a> From<&'a ChosenWithFactors> for ChosenJson<'a> {
    fn from(found: &'a ChosenWithFactors) -> Self {
        let answer = match &found.chosen {
            Chosen::Viable(choice) => AnswerJson::Viable(choice),
            Chosen::NoViableCell(none) => AnswerJson::NoViableCell(none.into()),
        };
        let (factors, pseudo_realities) = (found.factors.as_ref(), found.pseudo_realities.as_ref());
        Self { answer, factors, pseudo_realities }
    }
}

/// What there was where nothing is viable, as JSON.
#[derive(Serialize)]
pub struct NoViableCellJson<'a> {
    /// Always `None`: where a choice has its cell, there is none.
    cell: Option<Cell>,
    reason: String,
    best: &'a Choice,
    best_swept: &'a BestSwept,
}

impl<'a> From<&'a NoViableCell> for NoViableCellJson<'a> {
    fn from(none: &'a NoViableCell) -> Self {
        let (best, best_swept) = (&none.best, &none.best_swept);
        Self { cell: None, reason: reason(none), best, best_swept }
    }
}

/// What came of choosing from the sweep in a `folder` a cell of which a share of `wanted` is wanted, what the
/// factors do in it, and what comes next; `output` is the file into which a choice was to be written.
pub fn text(found: &ChosenWithFactors, folder: &Path, wanted: f64, output: Option<&Path>) -> Words {
    let (first, next) = match &found.chosen {
        Chosen::Viable(choice) => {
            let wider = wider(folder, &found.extensions);
            let next = match output {
                Some(path) => format!("{}\n{}", wrote(path), after_choice(folder)),
                None => to_keep(folder),
            };
            (wider.into_iter().fold(viable(choice, wanted), Words::below), next)
        }
        Chosen::NoViableCell(none) => (none_viable(none), after_none_viable(folder, output)),
    };
    let factors = found.factors.iter().map(factors::text);
    let in_pseudo_realities =
        found.pseudo_realities.iter().map(|pseudo| in_pseudo_realities(pseudo, found.cell()));
    factors.chain(in_pseudo_realities).chain([next]).fold(first, Words::below)
}

/// How a cell does with robots as they might be.
fn in_pseudo_realities(found: &InPseudoRealities, cell: &Cell) -> String {
    let InPseudoRealities { n_profiles, widening, n_replicates, varied, .. } = found;
    let mut lines = vec![format!(
        "with {} drawn around the intervals of the fit, {widening} times as wide ({} drawn, {n_replicates} runs each):",
        counted(*n_profiles, "profile"),
        counted(varied.len() as u64, "number"),
    )];
    lines.extend(found.of_cell(cell).map(|of_cell| {
        format!(
            "  {} of runs end as wanted at {cell}, at most {} in the worst tenth of profiles",
            percent(of_cell.mean),
            percent(of_cell.worst_tenth)
        )
    }));
    lines.extend(found.rank_correlation.map(|tau| {
        format!("  Kendall's tau of the cells' order with that of the sweep as measured: {tau:.2}, on average")
    }));
    lines.join("\n")
}

/// Why no cell is viable.
pub fn reason(none: &NoViableCell) -> String {
    let NoViableCell { wanted, n_candidates, best, .. } = none;
    let verb = best.behaviour().verb();
    let measured = best.as_measured.map_or_else(String::new, |measured| {
        format!("; as measured {}, lower bound {}", percent(measured.share), percent(measured.low))
    });
    let of = if *n_candidates == 0 {
        format!("in no cell could robots {} in {} of runs; the best", verb.plain, percent(*wanted))
    } else {
        format!("the best of {}", counted(*n_candidates as u64, "candidate"))
    };
    format!(
        "{of}, {}, {} in {} of {} fresh runs, lower bound {}{measured}; wanted {}",
        best.cell,
        verb.does,
        percent(best.b_s),
        count(best.n_replicates),
        percent(best.b_s_low),
        percent(*wanted)
    )
}

/// Why no cell is viable, and what other starts and numbers would give.
pub fn none_viable(none: &NoViableCell) -> Words {
    let first = Words::toned(Tone::Bad, "no viable cell").then(format!(": {}", reason(none)));
    let others = indented(alternatives(&none.best, none.wanted));
    others.into_iter().fold(first, Words::below)
}

/// What becomes of the file that a choice was to be written into, and what comes next where no cell is viable.
fn after_none_viable(folder: &Path, output: Option<&Path>) -> String {
    let unwritten = output.map(|path| {
        let path = path.display();
        format!("{path} was not written, as no cell is viable; a smaller `--viable` asks for less")
    });
    let next = format!("next: rsrs diagnose {}   # what would have to be changed", quoted(folder));
    unwritten.into_iter().chain([next]).collect::<Vec<_>>().join("\n")
}

/// How a choice is kept that was not written into a file.
fn to_keep(folder: &Path) -> String {
    let kept = quoted(folder.join(CHOICE));
    let folder = quoted(folder);
    format!("next: rsrs choose {folder} -o {kept}   # keeps it, for run and diagram")
}

/// What follows from a choice that was written into a file.
fn after_choice(folder: &Path) -> String {
    let experiment = experiment_beside(folder);
    let folder = quoted(folder);
    format!("next: rsrs plan-experiments {folder}\nthen: rsrs run {experiment} --from {folder}")
}

/// A viable cell, of which a share of `wanted` was wanted: how often its runs show it, and how far it may drift.
pub fn viable(choice: &Choice, wanted: f64) -> Words {
    let (worlds, made) = match choice.as_measured {
        Some(_) => ("made worse and as measured", "made worse"),
        None => ("as measured", "as measured"),
    };
    let margins = choice.margin.iter().map(|(axis, margin)| drift(choice, *axis, *margin));
    let first = Words::toned(Tone::Good, "viable").then(format!(
        ": {} (surely {:.0} % of its runs or more {}, {worlds})",
        choice.cell,
        100.0 * wanted,
        choice.behaviour().verb().plain
    ));
    let mut lines = vec![format!("  {made}, it {}", in_fresh_runs(choice))];
    lines.extend(tried(choice));
    lines.extend(as_measured(choice).map(|text| format!("  {text}")));
    lines.extend(choice.settling.map(|settling| format!("  {}", settling::text(&settling))));
    let did = choice.behaviour().verb().did;
    let converged =
        |time_s: f64| format!("  half of the runs that {did} had come to it by {time_s:.0} s");
    lines.extend(choice.converged_s.map(converged));
    lines.extend(indented(alternatives(choice, wanted)));
    lines.extend(by_circliness(choice));
    lines.extend(margins);
    if choice.margin.values().any(|margin| margin.low > 0.0 || margin.high > 0.0) {
        lines.push(
            "  (by the runs of the sweep, from swept value to swept value; the margins of `rsrs answer` \
             are of finer values and runs of their own, and may be wider or narrower)"
                .to_owned(),
        );
    }
    lines.into_iter().fold(first, Words::below)
}

/// `mills in 97.3 % of 1,000 fresh runs (95 % interval 96.1 to 98.2 %)`.
pub fn in_fresh_runs(choice: &Choice) -> String {
    format!(
        "{} in {} of {} fresh runs (95 % interval {})",
        choice.behaviour().verb().does,
        percent(choice.b_s),
        count(choice.n_replicates),
        percents(choice.b_s_low, choice.b_s_high)
    )
}

/// How far a value may drift, and what is known beyond.
fn drift(choice: &Choice, axis: Axis, margin: Margin) -> String {
    let Margin { low, high } = margin;
    let edge = choice.edge.get(&axis).copied().unwrap_or_default();
    let value = choice.cell.get(axis).unwrap_or_default();
    let ends = [(edge.low, "below", value - low), (edge.high, "above", value + high)];
    let ends = ends.into_iter().filter(|(is_end, _, _)| *is_end);
    let ends: Vec<String> = ends.map(|(_, side, end)| format!("{side} {}", tidy(end))).collect();
    let edges = format!("; edge of the sweep: nothing was swept {}", ends.join(" and "));
    let edges = if ends.is_empty() { "" } else { &edges };
    if low != 0.0 || high != 0.0 {
        let low = if low == 0.0 { "0".to_owned() } else { format!("-{low}") };
        let drift = format!("{low} to +{high} {}", axis.unit());
        return format!("  {axis} may drift by {}{edges}", drift.trim_end());
    }
    let way = match (edge.low, edge.high) {
        (false, false) => {
            return format!(
                "  {axis} may not drift: the next values that were swept are not surely viable"
            );
        }
        (true, true) => {
            return format!(
                "  how far {axis} may drift is unknown: no value beside {value} was swept"
            );
        }
        (true, false) => "upward",
        (false, true) => "downward",
    };
    format!("  {axis} may not drift {way}: the next value is not surely viable{edges}")
}

/// How many cells came before this one and did not hold.
fn tried(choice: &Choice) -> Option<String> {
    let n_before = choice.candidates_tried?.checked_sub(1).filter(|n| *n > 0)?;
    Some(format!("  {} ranked before it did not hold", counted(n_before, "cell")))
}

/// Lines below another one.
pub fn indented(lines: Vec<String>) -> Vec<String> {
    lines.into_iter().map(|line| format!("  {line}")).collect()
}

/// How `B_s` moves with the circliness from which a mill is called stable.
fn by_circliness(choice: &Choice) -> Option<String> {
    let [lower, stable, higher] = choice.by_circliness.as_slice() else { return None };
    Some(format!(
        "  a mill is stable from a circliness of {} on (0: a filled disc, 1: a thin ring); from {} on it \
         would be {}, from {} on {}",
        stable.stable_circliness,
        lower.stable_circliness,
        percent(lower.b_s),
        higher.stable_circliness,
        percent(higher.b_s)
    ))
}

/// The sweep that would have the chosen cell inside, if it lies at the edge of this one.
fn wider(folder: &Path, found: &[Extension]) -> Vec<String> {
    let (possible, ends): (Vec<&Extension>, Vec<&Extension>) =
        found.iter().partition(|extension| !extension.values.is_empty());
    let is_end = |Extension { axis, end, .. }: &&Extension| {
        format!("  {axis} {end} is as far as these robots can go")
    };
    let mut lines: Vec<String> = ends.iter().map(is_end).collect();
    if !possible.is_empty() {
        let (sweep, next) = (sweep_beside(folder), quoted(free_beside(folder)));
        lines.push(format!(
            "the cell lies at the edge of the sweep; to see beyond it, put into {sweep}"
        ));
        lines.extend(possible.iter().map(|Extension { axis, values, .. }| {
            let values: Vec<String> = values.iter().map(ToString::to_string).collect();
            format!("  {axis}: [{}]", values.join(", "))
        }));
        lines.push(format!("and run: rsrs sweep {sweep} -o {next}"));
    }
    lines
}

/// What robots as measured do in the chosen cell, if that was asked.
pub fn as_measured(choice: &Choice) -> Option<String> {
    let measured = choice.as_measured?;
    let share = format!(
        "as measured, not made worse, it {} in {} of {} ({})",
        choice.behaviour().verb().does,
        percent(measured.share),
        count(measured.n_replicates),
        percents(measured.low, measured.high)
    );
    let warning = ": being worse helps here, so expect less of it on the floor than simulated";
    Some(if choice.worse_is_better() { share + warning } else { share })
}

/// From such a share on, the others still do what is wanted of them now and then.
const NOW_AND_THEN: f64 = 0.1;

fn losing_one(less: &OtherNumber, wanted: f64, verb: Verb) -> String {
    if less.b_s < NOW_AND_THEN {
        return "losing one robot ends it".to_owned();
    }
    format!(
        "after the loss of one robot the others {} in {} only, less than the {} that are wanted",
        verb.plain,
        percent(less.b_s),
        percent(wanted)
    )
}

/// What other starts and numbers would give.
pub fn alternatives(choice: &Choice, wanted: f64) -> Vec<String> {
    let lines = [start(choice, wanted), numbers(choice), spare(choice, wanted)];
    lines.into_iter().flatten().collect()
}

/// The same without other numbers, where these are a question of their own.
pub fn start_and_spare(choice: &Choice, wanted: f64) -> Vec<String> {
    [start(choice, wanted), spare(choice, wanted)].into_iter().flatten().collect()
}

fn start(choice: &Choice, wanted: f64) -> Option<String> {
    let is_of_help =
        |start: &&DenserStart| !choice.is_viable(wanted) && start.b_s_low > choice.least().1;
    let start = choice.denser_start.as_ref().filter(is_of_help)?;
    let is_viable = start.b_s_low >= wanted;
    Some(format!(
        "from a denser start, with `placement_radius_m: {}` (now {:.2}) B_s is {} in {} fresh runs, lower \
         bound {}{}",
        start.placement_radius_m,
        start.now_m,
        percent(start.b_s),
        count(start.n_replicates),
        percent(start.b_s_low),
        if is_viable { "; place the robots so, and sweep again" } else { "" }
    ))
}

fn numbers(choice: &Choice) -> Option<String> {
    let verb = choice.behaviour().verb();
    let number =
        |other: &OtherNumber| format!("{} {} in {}", other.robots, verb.plain, percent(other.b_s));
    let first = choice.other_numbers.first()?;
    let numbers: Vec<String> = choice.other_numbers.iter().map(number).collect();
    let runs = count(first.n_replicates);
    Some(format!("other numbers of robots, in {runs} runs: {}", numbers.join(", ")))
}

fn spare(choice: &Choice, wanted: f64) -> Option<String> {
    // Who does not do it with all of them has not got one to spare.
    if !choice.is_viable(wanted) {
        return None;
    }
    let less = choice.other_numbers.iter().find(|other| Some(other.robots + 1) == choice.robots);
    let is_a_loss = |less: &&OtherNumber| less.b_s_high < wanted.min(choice.least().1);
    let less = less.filter(is_a_loss)?;
    let losing = losing_one(less, wanted, choice.behaviour().verb());
    Some(format!("{losing}; have a spare one at hand"))
}

#[cfg(test)]
mod tests {
    use rsrs_core::judge::behaviour::Behaviour;

    use super::*;

    #[test]
    fn the_loss_of_a_robot_is_worded_by_what_the_others_still_do() {
        let less = |b_s: f64| OtherNumber {
            robots: 5,
            b_s,
            b_s_low: b_s,
            b_s_high: b_s,
            n_replicates: 200,
        };
        let verb = Behaviour::MILLING.verb();

        assert_eq!(losing_one(&less(0.02), 0.8, verb), "losing one robot ends it");
        assert_eq!(
            losing_one(&less(0.41), 0.8, verb),
            "after the loss of one robot the others mill in 41.0 % only, less than the 80.0 % that are \
             wanted"
        );
    }
}
