//! Answers of which several commands print the same, with their tones.

use rsrs_core::comparison::Verdict;
use rsrs_pipeline::compare::report::Report as Comparison;
use rsrs_pipeline::label::{LOOK_AGAIN, Labelled};

use crate::words::{Tone, Words};

/// A comparison: the verdict of every cell, runs to look at again, and the verdict of all.
pub fn comparison(report: &Comparison) -> Words {
    let mut words = Words::new(report);
    for cell in &report.cells {
        for bag in report.bags.iter().filter(|bag| bag.cell == cell.cell) {
            if let Some(warning) = bag.labelled.warning() {
                words = words.tone(Tone::Unclear, warning);
            }
        }
        let verdict = cell.verdict_in_a_word();
        words = words.past("by itself  ").tone(tone_of(cell.verdict), verdict);
    }
    words.past("verdict: ").tone(tone_of(report.verdict), report.verdict_in_a_word())
}

fn tone_of(verdict: Verdict) -> Tone {
    match verdict {
        Verdict::Supported => Tone::Good,
        Verdict::Undecided | Verdict::NoClaim => Tone::Unclear,
        Verdict::Violated => Tone::Bad,
    }
}

/// A label with what it rests on.
pub fn label(labelled: &Labelled) -> Words {
    let words = Words::new(labelled).past(format!("{}: ", labelled.bag.display()));
    toned(labelled, words, labelled.is_borderline().then_some(LOOK_AGAIN))
}

/// The phase of a label behind some other words.
pub fn phase(labelled: &Labelled, before: String) -> Words {
    let words = Words::from(format!("{before}{}", labelled.phase_in_words())).past(before);
    toned(labelled, words, labelled.warning())
}

/// Gives the next phase its tone, and the warning behind it.
fn toned(labelled: &Labelled, words: Words, warning: Option<&'static str>) -> Words {
    let phase = labelled.phase;
    let is_wanted = phase == phase.behaviour().wanted();
    if let Some(warning) = warning {
        return words.tone(Tone::Unclear, phase.to_string()).tone(Tone::Unclear, warning);
    }
    words.tone(Tone::good_if(is_wanted), phase.to_string())
}
