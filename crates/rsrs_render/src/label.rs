//! Labels as a person reads them.

use std::path::Path;

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::certainty::Certainty;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::order::Parameter;
use rsrs_core::judge::phase::JudgeError;
use rsrs_fleet::record::Backend;
use rsrs_pipeline::label::human_labels::HumanLabel;
use rsrs_pipeline::label::{Labelled, NoLabel, RunPart, Settledness};

use crate::words::{Tone, Words};

/// What stands behind a phase that is near another one, everywhere.
const LOOK_AGAIN: &str = "not settled: look again";

/// What stands behind the phase of a run whose poses or motions cannot be those that were commanded.
const IMPLAUSIBLE: &str = "implausible: look again";

/// What stands behind a phase, if a person should look at the run.
pub fn warning(settledness: Settledness) -> Option<&'static str> {
    if settledness.is_implausible {
        return Some(IMPLAUSIBLE);
    }
    settledness.is_borderline().then_some(LOOK_AGAIN)
}

/// A phase, with a warning where a person should look at the run.
pub fn marked(phase: impl Into<Words>, settledness: Settledness) -> Words {
    match warning(settledness) {
        Some(warning) => phase.into().then(" (").then_toned(Tone::Unclear, warning).then(")"),
        None => phase.into(),
    }
}

/// The phase of a label, with a warning where a person should look at the run.
pub fn phase_of(label: &Labelled) -> Words {
    marked(label.phase.to_string(), label.settledness())
}

/// The same, where the phase has a tone, too.
pub fn toned_phase_of(label: &Labelled) -> Words {
    marked(toned(label), label.settledness())
}

fn toned(label: &Labelled) -> Words {
    let phase = label.phase;
    let tone = match warning(label.settledness()) {
        Some(_) => Tone::Unclear,
        None => Tone::good_if(phase == phase.behaviour().wanted()),
    };
    Words::toned(tone, phase.to_string())
}

/// What a person saw, who that is, and when it was.
pub fn human(label: &HumanLabel) -> String {
    let HumanLabel { phase, by, time, note } = label;
    let note = note.as_ref().map_or_else(String::new, |note| format!(" ({note})"));
    format!("{phase} by {by}, {time}{note}")
}

/// That a person's label was added to a bag, in a file that has so many now.
pub fn added(label: &HumanLabel, bag: &Path, n_labels: usize, file: &Path) -> String {
    let HumanLabel { phase, by, .. } = label;
    format!("{}: {phase} by {by}, label {n_labels} in {}", bag.display(), file.display())
}

/// The label, and below it what else is to be known of it.
pub fn text(label: &Labelled) -> Words {
    let first = Words::from(format!("{}: ", label.bag.display())).then(toned(label));
    let mut lines: Vec<Words> = vec![first.then(evidence(label).unwrap_or_default())];
    if let Some(backend) = label.backend.filter(|backend| *backend != Backend::Fleet) {
        lines.push(format!("  robots moved by: {}", backend.in_words()).into());
    }
    for sentence in &label.why {
        lines.push(format!("  why: {sentence}").into());
    }
    // How sure a phase is of poses that cannot be is of no use.
    if let Some(certainty) = label.certainty.as_ref().filter(|_| label.implausible.is_empty()) {
        lines.push(Words::from("  ").then(sure(certainty)));
    }
    for finding in &label.findings {
        let what = if finding.is_mended() { "mended" } else { "note" };
        lines.push(format!("  {what}: {finding}").into());
    }
    for found in &label.implausible {
        lines.push(format!("  implausible (look again): {}", found.text).into());
    }
    for deviation in &label.misplaced {
        lines.push(format!("  start: {deviation}").into());
    }
    for by_hand in &label.labels {
        let differs = if by_hand.phase == label.phase { "" } else { "; differs" };
        lines.push(format!("  by hand: {}{differs}", human(by_hand)).into());
    }
    if !label.controller_only.is_empty() {
        lines
            .push(format!("  lease: controller only: {}", label.controller_only.join(", ")).into());
    }
    for (robot, own) in &label.own_profiles {
        lines.push(format!("  {robot}: {own}").into());
    }
    for lost in &label.lost_robots {
        lines.push(format!("  {lost}").into());
    }
    lines.extend(label.counts_without_lost.map(|counts| {
        Words::from(if counts {
            "  none was lost before the judged time: by `robot_lost: abort_until_judged` of its \
             experiment the run counts"
        } else {
            "  it counts only `--with-lost-robots`"
        })
    }));
    for paused in &label.paused_robots {
        lines.push(format!("  {paused}").into());
    }
    if let Some(ending) = label.ending {
        let reason = label.reason.as_deref().unwrap_or_default();
        lines.push(format!("  the run was not completed: {ending} ({reason})").into());
    }
    if let Some(RunPart { recorded_s, set_s }) = label.part {
        let of = set_s.map_or_else(String::new, |set_s| format!(" of {set_s:.0} s"));
        lines.push(
            format!("  only a part of the run: {recorded_s:.1} s{of}; it does not count").into(),
        );
    }
    lines.extend(label.damage.iter().map(|damage| Words::from(format!("  {damage}"))));
    Words::lines(lines)
}

/// What the phase rests on.
fn evidence(label: &Labelled) -> Option<String> {
    let (evidence, n_robots, duration_s) =
        (label.evidence.as_ref()?, label.n_robots?, label.duration_s?);
    let order = order_parameters(label.phase.behaviour(), evidence);
    Some(format!(" ({n_robots} robots, {duration_s:.0} s; {order})"))
}

/// The order parameters that a behaviour looks at; of milling the few that tell its phases apart.
pub fn shown(behaviour: Behaviour) -> Vec<Parameter> {
    if behaviour != Behaviour::MILLING {
        return behaviour.rules().parameters();
    }
    let shape = [Parameter::ROTATION, Parameter::ORBIT, Parameter::CIRCLINESS];
    shape.into_iter().chain([Parameter::BLOCKED, Parameter::LOST]).collect()
}

/// What a phase of a behaviour rests on: `clustered 0.96, lost 0.00`.
pub fn order_parameters(behaviour: Behaviour, evidence: &OrderParameters) -> String {
    let in_words = |parameter: Parameter| match parameter.value(evidence) {
        None if parameter == Parameter::LOST => {
            format!("{parameter} unknown without the robots' reach")
        }
        None => format!("{parameter} unknown"),
        Some(value) if parameter == Parameter::CIRCLINESS && behaviour == Behaviour::MILLING => {
            format!("{parameter} {value:.2} of {:.2}", evidence.circliness_ceiling)
        }
        Some(value) => format!("{parameter} {}", parameter.with_unit(value)),
    };
    let texts: Vec<String> = shown(behaviour).into_iter().map(in_words).collect();
    texts.join(", ")
}

/// What the numbers behind a label mean.
pub fn explained(behaviour: Behaviour) -> String {
    if behaviour == Behaviour::MILLING {
        return "rotation is 1 where all circle one way; orbit, their way around the centre over the way \
                commanded;\n  circliness, 1 for a thin ring and 0 for a filled disc, of the most that the \
                control period allows;\n  blocked, the share of time held up by others; lost, the share of \
                robots without a neighbour in reach"
            .to_owned();
    }
    let lines: Vec<String> =
        shown(behaviour).into_iter().map(|it| format!("{it}: {}", it.words())).collect();
    lines.join("\n  ")
}

/// How sure a verdict is.
fn sure(certainty: &Certainty) -> Words {
    let settled = if certainty.is_settled {
        Words::from("settled")
    } else {
        Words::toned(Tone::Unclear, LOOK_AGAIN)
    };
    let nearest = certainty.nearest.as_ref().map_or_else(String::new, |nearest| {
        let parameters: Vec<&str> =
            nearest.parameters.iter().map(|parameter| parameter.key()).collect();
        let (phase, distance) = (nearest.becomes, nearest.distance);
        format!("; nearest is {phase}, {distance:.2} away in {}", parameters.join(" and "))
    });
    let blocks = 100.0 * certainty.confidence;
    settled.then(format!("{nearest}; {blocks:.0} % of its 10 s blocks show the same phase"))
}

/// Why a run has no label, for a picture: `no label: 20 s of 60`.
pub fn none(none: &NoLabel) -> String {
    match none {
        NoLabel::Part(RunPart { recorded_s, set_s: Some(set_s) }) => {
            format!("no label: {recorded_s:.0} s of a run of {set_s:.0}")
        }
        NoLabel::Part(RunPart { recorded_s, set_s: None }) => {
            format!("no label: {recorded_s:.0} s of a run whose end is lost")
        }
        NoLabel::Stopped { duration_s, ending, .. } => {
            format!("no label: {ending} after {duration_s:.0} s")
        }
        NoLabel::Judge(JudgeError::TooShort { duration_s, window }) => {
            format!("no label: {duration_s:.0} s of {:.0}", window.least_s())
        }
        NoLabel::Judge(JudgeError::UnknownReach { .. }) => {
            "no label: how far a robot senses another is not known".to_owned()
        }
        NoLabel::Objects(finding) => format!("no label: {finding}"),
        NoLabel::Judge(error) => format!("no label: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_is_a_stronger_warning_than_a_phase_near_another_one() {
        let of = |label: &str| warning(serde_json::from_str(label).expect("it is a label"));

        assert_eq!(of(r#"{"is_settled": false, "implausible": []}"#), Some(IMPLAUSIBLE));
        assert_eq!(of(r#"{"is_settled": false}"#), Some(LOOK_AGAIN));
        assert_eq!((of(r#"{"is_settled": true}"#), of("{}")), (None, None));
    }

    #[test]
    fn a_run_that_was_stopped_early_is_not_just_too_short() {
        let (ending, reason) = ("aborted", "lost robot_2".to_owned());
        let window = rsrs_core::judge::window::Window::default();
        let stopped = NoLabel::Stopped { duration_s: 34.0, ending, reason, window };

        assert_eq!(none(&stopped), "no label: aborted after 34 s");
    }
}
