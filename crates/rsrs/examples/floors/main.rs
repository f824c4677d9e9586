//! What `docs/floors/compare.py` and `docs/floors/discovery.py` ask for: drives on the floor of [`ray_floor`], and labels of anybody's
//! trajectories by the one judge.
//!
//! ```text
//! cargo run --release --example floors drive
//! cargo run --release --example floors judge SWEEP
//! cargo run --release --example floors call SEARCH
//! ```
//!
//! Each line of standard input is a request in JSON, which one line of standard output answers. `SWEEP` is the
//! folder of the sweep that predicts the runs: robots have the body and the reach of its profile, as measured.
//! `SEARCH` is the folder of `rsrs explore`, by whose names runs are called.

mod mechanics;
mod ray_floor;

use std::collections::BTreeMap;
use std::io::{BufRead, Write, stdin, stdout};
use std::path::Path;

use anyhow::{Context, bail};
use rsrs_core::judge::order::Parameter;
use rsrs_core::judge::phase::label;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::program;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;
use rsrs_pipeline::explore::judge::{Judge, Seen};
use rsrs_pipeline::sweep::folder;
use serde::Deserialize;
use serde_json::{Value, json};

/// What robots did, sampled every `period_s` seconds.
#[derive(Deserialize)]
struct Recorded {
    period_s: f64,
    /// x and y in metres, heading in radians; shape `[n_samples][n_robots][3]`.
    poses: Vec<Vec<[f64; 3]>>,
    /// Speed in m/s and turning rate in rad/s; shape `[n_samples][n_robots][2]`.
    commands: Vec<Vec<[f64; 2]>>,
}

fn main() -> anyhow::Result<()> {
    program::set_commit("floors");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["drive"] => answer_each(|line| {
            let task = serde_json::from_str(line).context("this is no drive")?;
            Ok(serde_json::to_value(ray_floor::drive(&task))?)
        }),
        ["judge", sweep] => {
            let source = folder::read(Path::new(sweep))?.source;
            let bodies = source.as_measured().unwrap_or(source).conditions_of(0)?.bodies();
            answer_each(|line| {
                let run: Recorded = serde_json::from_str(line).context("this is no recording")?;
                let verdict = label(&run.trajectory(), &bodies)?;
                Ok(json!({ "phase": verdict.phase.key() }))
            })
        }
        ["call", search] => {
            let judge = Judge::of_search(Path::new(search))?;
            answer_each(|line| {
                let run: Recorded = serde_json::from_str(line).context("this is no recording")?;
                let Seen { names, niche, evidence } = judge.see(&run.trajectory())?;
                let measured =
                    Parameter::all().filter_map(|it| Some((it.key(), it.value(&evidence)?)));
                let measured: BTreeMap<&str, f64> = measured.collect();
                Ok(json!({ "names": names, "niche": niche, "order_parameters": measured }))
            })
        }
        _ => bail!(
            "expected `drive`, `judge` and the folder of a sweep, or `call` and that of a search; \
             got {arguments:?}"
        ),
    }
}

fn answer_each(answer: impl Fn(&str) -> anyhow::Result<Value>) -> anyhow::Result<()> {
    for (number, line) in (1..).zip(stdin().lock().lines()) {
        let answered = answer(&line?).with_context(|| format!("line {number}"))?;
        writeln!(stdout(), "{answered}")?;
    }
    Ok(())
}

impl Recorded {
    fn trajectory(&self) -> Trajectory {
        let n_robots = self.poses.first().map_or(0, Vec::len);
        let pose = |&[x_m, y_m, heading_rad]: &[f64; 3]| Pose { x_m, y_m, heading_rad };
        let command =
            |&[speed_m_s, turn_rate_rad_s]: &[f64; 2]| Command { speed_m_s, turn_rate_rad_s };
        Trajectory {
            poses: self.poses.iter().flatten().map(pose).collect(),
            commands: self.commands.iter().flatten().map(command).collect(),
            ..Trajectory::new(self.period_s, n_robots)
        }
    }
}
