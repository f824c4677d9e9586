//! What is known of each real run.

use anyhow::Context;
use rsrs_core::judge::certainty::Certainty;
use rsrs_core::judge::window::{WINDOW_S, samples_in};
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_fleet::record::Backend;
use rsrs_pipeline::error::in_one_line;
use rsrs_pipeline::label::{LabelOptions, Labelled};
use rsrs_view::order_over_time::order_svg;
use rsrs_view::replay::{Replay, Shown, bytes_per_frame};
use rsrs_view::report::{RecordedRun, RunFacts};
use rsrs_view::theme::Theme;
use rsrs_view::trajectory::{ring_of, svg};

use super::samples_at_least;
use crate::comparison::{ComparedBag, Report as Comparison};
use crate::label::{human, order_parameters, phase_of};
use crate::recorded_run::DrawnRun;
use crate::wording::quantity;

/// How often poses are kept, in seconds.
const FRAME_S: f64 = 0.5;
/// What the replays of all runs may take, in bytes of the page; where they would take more, poses are
/// further apart.
const BUDGET_BYTES: f64 = 350_000.0;

/// The facts of all runs that count.
pub fn facts(comparison: &Comparison) -> anyhow::Result<Vec<RunFacts>> {
    let most_bytes = BUDGET_BYTES / comparison.bags.len().max(1) as f64;
    comparison.bags.iter().map(|run| facts_of(run, most_bytes)).collect()
}

/// The facts of one run; without poses, its label alone.
fn facts_of(run: &ComparedBag, most_bytes: f64) -> anyhow::Result<RunFacts> {
    let labelled = &run.labelled;
    let mut notes = vec![moved_by(run)];
    // As it was judged; of a run that a person labelled, what it went by.
    let poses = labelled.poses.as_deref().and_then(PoseSource::from_key);
    let recorded =
        match DrawnRun::read(&labelled.bag, LabelOptions { poses, ..LabelOptions::default() }) {
            Err(error) => {
                notes.push(format!("not drawn: {}", in_one_line(&error)));
                None
            }
            Ok(drawn) => {
                match drawn.labelled() {
                    Some(labelled) => notes.extend(evidence(labelled)),
                    None => notes.push(drawn.label_in_words()),
                }
                Some(
                    recorded(run, &drawn, most_bytes)
                        .with_context(|| labelled.bag.display().to_string())?,
                )
            }
        };
    notes.push(format!("run {} in {}", run.record.run_id, labelled.bag.display()));
    Ok(RunFacts {
        name: run.name(),
        cell: quantity::of_cell(&run.cell),
        phase: labelled.phase,
        label: format!("{} by {}", phase_of(labelled), labelled.by),
        notes,
        recorded,
    })
}

fn moved_by(run: &ComparedBag) -> String {
    match run.record.backend {
        Backend::Fleet => "real robots".to_owned(),
        Backend::Simulator => {
            format!("a simulator stood in for the robots, with seed {}", run.record.seed)
        }
        Backend::Mixed => "some of the robots were simulated".to_owned(),
    }
}

fn recorded(run: &ComparedBag, drawn: &DrawnRun, most_bytes: f64) -> anyhow::Result<RecordedRun> {
    let trajectory = &drawn.recorded().trajectory;
    let n_samples = trajectory.n_samples();
    let frame_bytes = bytes_per_frame(trajectory.n_robots, trajectory.n_objects);
    let fitting_s = trajectory.duration_s() * frame_bytes / most_bytes;
    let every = samples_at_least(FRAME_S.max(fitting_s), trajectory.period_s);
    let lost = drawn.lost_rows();
    let phase = drawn.labelled().map(|labelled| labelled.phase);
    let first_judged = n_samples.saturating_sub(samples_in(WINDOW_S, trajectory.period_s));
    let title = format!("order parameters of {} over time", run.name());
    Ok(RecordedRun {
        above_svg: svg(&drawn.above(&lost, Theme::Screen))?,
        order: order_svg(&drawn.order(&drawn.blocks(), &drawn.rules(), &[]), &title),
        replay: Replay::new(&Shown {
            trajectory,
            conditions: &run.record.conditions,
            robots: drawn.recorded().robots.clone(),
            samples: 0..n_samples,
            every,
            ring: phase.and_then(|phase| ring_of(phase, trajectory, first_judged)),
            lost: lost.clone(),
        }),
    })
}

/// What the judge's label rests on, why it is that one, and labels by people.
fn evidence(judged: &Labelled) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(evidence) = &judged.evidence {
        lines.push(order_parameters(judged.phase.behaviour(), evidence));
    }
    if let Some(Certainty { nearest: Some(nearest), confidence, .. }) = &judged.certainty {
        lines.push(format!(
            "judge: {}; {} is {:.2} away; {:.0} % of the window's 10 s blocks show the same phase",
            judged.phase,
            nearest.becomes,
            nearest.distance,
            100.0 * confidence
        ));
    }
    lines.extend(judged.why.iter().map(|why| format!("why: {why}")));
    lines.extend(judged.lost_robots.iter().map(ToString::to_string));
    lines.extend(judged.paused_robots.iter().map(ToString::to_string));
    lines.extend(judged.findings.iter().map(|finding| format!("mended: {finding}")));
    lines.extend(judged.labels.iter().map(|label| format!("by hand: {}", human(label))));
    lines
}
