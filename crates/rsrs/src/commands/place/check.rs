//! `rsrs place --check`: where robots are seen now.

use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;
use std::time::Duration;

use anyhow::Context;
use rsrs_core::printable;
use rsrs_experiment_runner::places;
use rsrs_experiment_runner::plan::Plan;
use rsrs_fleet::placement::SeenPlaces;
use rsrs_ros::runtime::runtime;
use rsrs_ros::session::SessionOptions;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::interrupt::requested;
use rsrs_render::seen_places::text;

/// How often the screen is written anew.
const EVERY: Duration = Duration::from_millis(500);
/// How long robots are given to be seen before `--once` gives up, in seconds: as long as a run gives
/// them.
const PATIENCE_S: f64 = 10.0;
/// How long they are looked at, in seconds, so that rates and disagreements of machines show.
const OBSERVED_S: f64 = 2.0;

/// How long it is looked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// Once, when all are seen.
    AllAreSeen,
    Stopped,
}

/// Shows where the robots of a plan are seen.
pub fn check(
    plan: &Plan,
    network: &SessionOptions,
    (until, format): (Until, Format),
) -> anyhow::Result<Outcome> {
    let mut screen = Screen::default();
    let mut last = None;
    let mut show = |seen: &SeenPlaces| {
        last = Some(seen.clone());
        if until == Until::Stopped {
            screen.show(&text(seen))?;
            return Ok(ControlFlow::Continue(()));
        }
        let all_are_seen = seen.robots.iter().all(|robot| robot.pose.is_some());
        let is_enough = if all_are_seen { OBSERVED_S } else { PATIENCE_S };
        Ok(if seen.looked_for_s >= is_enough {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        })
    };
    runtime()?.block_on(places::watch(plan, network, EVERY, &mut show, requested()))?;
    let Some(seen) = last else { return Ok(Outcome::NegativeAnswer) };
    if until == Until::AllAreSeen {
        report(format, &seen, text(&seen))?;
    }
    Ok(if seen.is_as_wanted { Outcome::Done } else { Outcome::NegativeAnswer })
}

/// A text that is written over itself on a terminal; elsewhere, whenever something but a number has
/// changed.
#[derive(Default)]
struct Screen {
    n_lines: usize,
    shown: String,
}

impl Screen {
    fn show(&mut self, text: &str) -> anyhow::Result<()> {
        let text = &*printable::lines(text);
        let mut out = std::io::stdout();
        let written = if out.is_terminal() {
            let up =
                if self.n_lines > 0 { format!("\x1b[{}A", self.n_lines) } else { String::new() };
            let lines: Vec<String> = text.lines().map(|line| format!("\x1b[2K{line}\n")).collect();
            self.n_lines = lines.len();
            write!(out, "{up}\x1b[J{}", lines.concat()).and_then(|()| out.flush())
        } else {
            let words: String = text.chars().filter(|c| !c.is_ascii_digit()).collect();
            if words == self.shown {
                return Ok(());
            }
            self.shown = words;
            writeln!(out, "{text}\n").and_then(|()| out.flush())
        };
        written.context("writing to standard output")
    }
}
