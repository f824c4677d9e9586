//! Labels as a person reads them.

use std::fmt::Write;

use rsrs_core::certainty::Certainty;

use rsrs_pipeline::label::{Labelled, RunPart};

/// What the judge says of a bag: the label, and below it what else there is to know.
pub fn judged(labelled: &Labelled) -> String {
    let mut text = format!("{}: {}", labelled.bag.display(), labelled.phase);
    if let (Some(evidence), Some(n_robots), Some(duration_s)) =
        (&labelled.evidence, labelled.n_robots, labelled.duration_s)
    {
        let lost = match evidence.lost {
            Some(lost) => format!("lost {lost:.2}"),
            None => "lost unknown without the robots' reach".to_owned(),
        };
        write!(
            text,
            " ({n_robots} robots, {duration_s:.0} s; rotation {:.2}, orbit {:.2}, circliness {:.2} \
             of {:.2}, blocked {:.2}, {lost})",
            evidence.rotation,
            evidence.orbit,
            evidence.circliness,
            evidence.circliness_ceiling,
            evidence.blocked
        )
        .expect("a string takes any text");
    }
    let mut line = |said: String| write!(text, "\n  {said}").expect("a string takes any text");
    if let Some(certainty) = &labelled.certainty {
        line(sure(certainty));
    }
    for finding in &labelled.findings {
        line(format!("mended: {finding}"));
    }
    for label in &labelled.labels {
        let differs = if label.phase == labelled.phase { "" } else { "; differs" };
        line(format!("by hand: {label}{differs}"));
    }
    if !labelled.controller_only.is_empty() {
        line(format!("lease: controller only: {}", labelled.controller_only.join(", ")));
    }
    for lost in &labelled.lost_robots {
        line(lost.to_string());
    }
    if let Some(ending) = labelled.ending {
        let reason = labelled.reason.as_deref().unwrap_or_default();
        line(format!("the run was not completed: {ending} ({reason})"));
    }
    if let Some(RunPart { recorded_s, set_s }) = labelled.part {
        let of = set_s.map_or_else(String::new, |set_s| format!(" of {set_s:.0} s"));
        line(format!("only a part of the run: {recorded_s:.1} s{of}; it counts nowhere"));
    }
    if let Some(damage) = &labelled.damage {
        line(damage.clone());
    }
    text
}

/// How sure a verdict is.
fn sure(certainty: &Certainty) -> String {
    let settled = if certainty.is_settled { "settled" } else { "not settled" };
    let nearest = certainty.nearest.as_ref().map_or_else(String::new, |nearest| {
        let parameters: Vec<&str> =
            nearest.parameters.iter().map(|parameter| parameter.key()).collect();
        let (phase, distance) = (nearest.becomes, nearest.distance);
        format!("; nearest is {phase}, {distance:.2} away in {}", parameters.join(" and "))
    });
    let blocks = 100.0 * certainty.confidence;
    format!("{settled}{nearest}; {blocks:.0} % of its 10 s blocks show the same phase")
}
