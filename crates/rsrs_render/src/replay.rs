//! Bags that were replayed, into today's controller, into the judge or into a network, in words.

use std::path::PathBuf;

use rsrs_core::judge::order::Parameter;
use rsrs_core::numerals::{count, counted};
use rsrs_core::robot::controller::Command;
use rsrs_pipeline::replay::ControllerReplay;
use rsrs_pipeline::replay::JudgeReplay;
use serde::Serialize;

use crate::columns::columns;
use crate::label::shown;
use crate::words::{Tone, Words};

/// Whether the controller commands the same.
pub fn into_controller(replay: &ControllerReplay) -> Words {
    let robots = counted(replay.robots.len() as u64, "robot");
    let commands = counted(replay.n_steps, "command");
    let mut words =
        Words::from(format!("{}: {commands} of {robots} compared, ", replay.bag.display()))
            .then_toned(
                Tone::good_if(replay.is_same()),
                format!("{} different", count(replay.n_different)),
            );
    for (n, what) in [
        (replay.n_unanswered, "detection without a recorded command"),
        (replay.n_unasked, "command without a detection"),
        (replay.n_held, "zero that a controller with the lease has to send"),
    ] {
        if n > 0 {
            let plural = what.replacen(' ', "s ", usize::from(n > 1));
            words = words.then(format!(", {} {plural}", count(n)));
        }
    }
    for robot in &replay.robots {
        let Some(first) = &robot.first else { continue };
        let is_detection = replay.controller.reading_names().is_detection();
        let reported = match (is_detection, first.detected, &first.reported[..]) {
            (true, true, _) => "it detected something".to_owned(),
            (true, false, _) => "it detected nothing".to_owned(),
            (false, _, []) => "it reported nothing".to_owned(),
            (false, _, reported) => format!("it reported {}", reported.join(", ")),
        };
        let text = |command: Command| {
            format!("{:.3} m/s, {:.3} rad/s", command.speed_m_s, command.turn_rate_rad_s)
        };
        words = words.below(format!(
            "  {}: {} different, the first at {:.3} s: {reported}, the recording has {}, \
             today's controller commands {}",
            robot.robot,
            count(robot.n_different),
            first.time_s,
            text(first.recorded),
            text(first.today)
        ));
    }
    words
}

/// Whether the judge labels it as it was labelled.
pub fn into_judge(replay: &JudgeReplay) -> Words {
    let verdict = if replay.is_same { "the same label" } else { "another label" };
    let parameters = shown(replay.today.phase.behaviour());
    let names = parameters.iter().map(ToString::to_string);
    let head = ["", "phase"].map(str::to_owned).into_iter().chain(names);
    let mut rows: Vec<Vec<String>> = vec![head.collect()];
    for (when, judged) in [("recorded", &replay.recorded), ("today", &replay.today)] {
        let number = |parameter: &Parameter| {
            let value = judged.evidence.as_ref().and_then(|it| parameter.value(it));
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"))
        };
        let first = [when.to_owned(), judged.phase.to_string()].into_iter();
        rows.push(first.chain(parameters.iter().map(number)).collect());
    }
    Words::from(format!("{}: ", replay.bag.display()))
        .then_toned(Tone::good_if(replay.is_same), verdict)
        .below(columns(&rows))
}

/// What was published of a bag.
#[derive(Clone, Debug, Serialize)]
pub struct Published {
    /// The bag.
    pub bag: PathBuf,
    /// Messages that went out.
    pub n_messages: u64,
    /// Topics that they went out on.
    pub n_topics: usize,
    /// Topics that were left out.
    pub left_out: Vec<String>,
    /// How long it took, in seconds.
    pub took_s: f64,
    /// How far it fell behind its pace at worst, in seconds.
    pub late_s: f64,
}

/// How much was published, and how well in time.
pub fn published(published: &Published) -> String {
    format!(
        "{}: {} on {} in {:.1} s, at most {:.3} s late",
        published.bag.display(),
        counted(published.n_messages, "message"),
        counted(published.n_topics as u64, "topic"),
        published.took_s,
        published.late_s
    )
}
