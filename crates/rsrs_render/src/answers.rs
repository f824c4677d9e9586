//! The five answers as a person reads them.

use std::collections::BTreeMap;

use rsrs_core::judge::behaviour::Verb;
use rsrs_core::numerals::{count, percent};
use rsrs_core::quantity::Axis;
use rsrs_pipeline::answer::{Answers, Quantity, Range};
use serde::Serialize;

use crate::choice::start_and_spare;
use crate::json::with;
use crate::why_a_range_ends::sentence;
use crate::wording::quantity::{named, of_cell, quantity, span};
use crate::words::{Tone, Words};

/// The answers as JSON.
pub fn json(answers: &Answers) -> impl Serialize {
    with(answers, "questions", questions(answers))
}

/// The questions as JSON, with the reason of each range.
pub fn questions(answers: &Answers) -> Vec<impl Serialize> {
    let questions = answers.questions.iter().map(|answer| {
        let quantities = answer.quantities.iter();
        let quantities = quantities.map(|quantity| with(quantity, "reason", sentence(quantity)));
        let question = BTreeMap::from([("question", answer.question)]);
        with(question, "quantities", quantities.collect::<Vec<_>>())
    });
    questions.collect()
}

/// All of it.
pub fn text(answers: &Answers) -> Words {
    let best = &answers.best;
    let verb = best.behaviour.verb();
    let (verdict, with) = if best.viable {
        (format!("they {}", verb.plain), " with")
    } else {
        (format!("they do not {}", verb.plain), "; most often with")
    };
    let first = Words::from(format!("{}: ", best.robot))
        .then_toned(Tone::good_if(best.viable), verdict)
        .then(format!(
            "{with} {},\nin {} of {} fresh runs of {} s (lower bound {}; wanted {}){}",
            of_cell(&best.cell),
            percent(best.b_s),
            count(best.n_replicates),
            answers.duration_s,
            percent(best.b_s_low),
            percent(best.wanted),
            if best.viable { "" } else { "; `rsrs diagnose` names what to change" }
        ));
    let mut lines = Vec::new();
    if let Some(differ) = &answers.other_profile {
        lines.push(format!("note: the settings are those of another sweep: {differ}"));
    }
    // Other numbers of robots are the first question.
    lines.extend(start_and_spare(&best.choice, best.wanted));
    for (number, answer) in (1..).zip(&answers.questions) {
        lines.push(format!("\n{number}. {}", answer.question));
        if answer.quantities.is_empty() {
            lines.push("   as the file of the controller has it".to_owned());
        }
        for quantity in &answer.quantities {
            lines.push(format!("   {}", range(quantity, verb)));
            lines.push(format!("     {}", sentence(quantity)));
        }
    }
    let fixed = of_cell(&answers.fixed);
    let fixed = if fixed.is_empty() { fixed } else { format!(" ({fixed})") };
    lines.push(format!(
        "\nA range ends before the first value with which fewer than {} of the runs {}, made worse or \
         as measured, all else as recommended{fixed}; what chance has put out of order is pooled. \
         A margin is from what is recommended to the end of its range, by runs of its own; how far a value \
         may drift by `rsrs choose` goes from swept value to swept value.",
        percent(best.wanted),
        verb.plain
    ));
    if !answers.decided_factors.is_empty() {
        let factor = |(factor, value): &(&str, f64)| format!("{factor}: {value}");
        let factors: Vec<String> = answers.decided_factors.iter().map(factor).collect();
        lines.push(format!(
            "Robots with each value are made worse by {} of the sweep, whatever the value is; all other \
             factors follow from it.",
            factors.join(", ")
        ));
    }
    lines.into_iter().fold(first, Words::below)
}

fn range(quantity: &Quantity, verb: Verb) -> String {
    let has = named(quantity.axis, quantity.recommended);
    let range = match &quantity.range {
        None => format!("{} too rarely", verb.does),
        Some(range) => mills_from(range, quantity.axis, verb),
    };
    format!("{has}: {range}")
}

/// `mills from 5 to 9 robots (margin 3 below, 1 above)`.
fn mills_from(range: &Range, axis: Axis, verb: Verb) -> String {
    let Range { low, high, margin, .. } = range;
    let end = |is_end: bool, margin: f64, side: &str| {
        is_end.then(|| format!("{} {side}", quantity(axis, margin)))
    };
    let below = end(range.ends_below, margin.low, "below");
    let above = end(range.ends_above, margin.high, "above");
    let margins: Vec<String> = below.into_iter().chain(above).collect();
    let tried = match (range.ends_below, range.ends_above) {
        (true, true) => String::new(),
        (true, false) => format!("; more than {} was not tried", quantity(axis, *high)),
        (false, true) => format!("; less than {} was not tried", quantity(axis, *low)),
        (false, false) => "; nothing else was tried".to_owned(),
    };
    let margin = if margins.is_empty() {
        String::new()
    } else {
        format!(" (margin {})", margins.join(", "))
    };
    format!("{} from {}{margin}{tried}", verb.does, span(axis, *low, *high))
}
