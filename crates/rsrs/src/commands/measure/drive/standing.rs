//! Detection trials: a robot stands and senses, another one stands beside it or does not.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::trial::Neighbour;
use rsrs_experiment_runner::plan::{Plan, Trial};
use serde::Serialize;
use tokio::runtime::Runtime;

use super::operator::{self, Ready};
use super::template::{Template, Todo};
use super::trial_nodes::{RunTarget, TrialNodes};
use super::{Arguments, request};
use crate::commands::{Backend, report, runtime};
use crate::failure::Outcome;
use crate::notes::print_note;
use crate::running::RunSummary;
use crate::sensor_readings::{self, Readings};

/// What filling in a table came to.
#[derive(Debug, Serialize)]
struct Progress {
    /// The table.
    table: PathBuf,
    /// Rows that were filled in now.
    n_filled: usize,
    /// Rows that are still without a count.
    n_left: usize,
    /// Messages that the middleware lost.
    n_lost: u64,
}

/// Fills in a table, row by row; what is filled in already stays.
///
/// # Errors
///
/// If the table or the fleet file is wrong, or a trial was not completed; rows before it are kept.
pub fn fill(arguments: &Arguments, path: &Path) -> anyhow::Result<Outcome> {
    let mut template = Template::open(path)?;
    let todo = template.todo()?;
    let bags = arguments.output.clone().unwrap_or_else(|| path.with_extension("bags"));
    // Whatever is wrong with a row is said before the first robot is asked for anything.
    for row in &todo {
        plan(arguments, row, &bags).with_context(|| format!("{}:{}", path.display(), row.line))?;
    }
    let mut filled =
        Progress { table: path.to_owned(), n_filled: 0, n_left: todo.len(), n_lost: 0 };
    if !todo.is_empty() {
        std::fs::create_dir_all(&bags)
            .with_context(|| format!("cannot make {}", bags.display()))?;
        let floor = RunTarget::enter(arguments.backend, arguments.interface.as_deref())?;
        let runtime = runtime()?;
        for rows in todo.chunk_by(|row, next| row.robot == next.robot) {
            let mut shift = Shift { arguments, bags: &bags, template: &mut template };
            if !shift.work((&runtime, &floor), rows, &mut filled)? {
                break;
            }
        }
    }
    report(arguments.format, &filled, &text(&filled))?;
    Ok(if filled.n_lost == 0 { Outcome::Done } else { Outcome::NegativeAnswer })
}

/// Trials of one robot after the other, by one crew.
struct Shift<'a> {
    arguments: &'a Arguments,
    bags: &'a Path,
    template: &'a mut Template,
}

impl Shift<'_> {
    /// Makes the trials; false if the operator ends them.
    fn work(
        &mut self,
        (runtime, floor): (&Runtime, &RunTarget),
        rows: &[Todo],
        filled: &mut Progress,
    ) -> anyhow::Result<bool> {
        let plans = rows.iter().map(|row| plan(self.arguments, row, self.bags));
        let plans = plans.collect::<anyhow::Result<Vec<Plan>>>()?;
        // The one that is measured, and whoever is put beside it in some trial.
        let all = plans.iter().max_by_key(|plan| plan.robots.len());
        let all = all.context("a group of rows has at least one")?;
        let mut trial_nodes = {
            let _guard = runtime.enter();
            TrialNodes::start(floor, &all.record.robots, all.robots[0].cmd_vel)?
        };
        let mut goes_on = true;
        let worked = rows.iter().zip(&plans).try_for_each(|(row, plan)| {
            if !goes_on {
                return Ok(());
            }
            let ready = ready(runtime, self.arguments.backend, &row.robot, row.neighbour)?;
            goes_on = ready != Ready::End;
            if ready == Ready::Go {
                let (found, summary) =
                    runtime.block_on(stand(&mut trial_nodes, plan, row.samples))?;
                self.template.fill(row, found)?;
                filled.n_filled += 1;
                filled.n_left -= 1;
                filled.n_lost += summary.n_lost;
            }
            anyhow::Ok(())
        });
        let stopped = runtime.block_on(trial_nodes.stop());
        worked?;
        stopped?;
        Ok(goes_on)
    }
}

/// Asks a person to put the neighbour there; a simulator does so by itself.
///
/// # Errors
///
/// If nobody answers.
pub fn ready(
    runtime: &Runtime,
    backend: Backend,
    robot: &str,
    neighbour: Option<Neighbour>,
) -> anyhow::Result<Ready> {
    match backend {
        Backend::Sim => Ok(Ready::Go),
        Backend::Fleet => runtime.block_on(operator::ready(&place(robot, neighbour))),
    }
}

/// Makes one trial, and counts the readings in its bag.
///
/// # Errors
///
/// If it was not completed, or the bag has no readings.
pub async fn stand(
    trial_nodes: &mut TrialNodes<'_>,
    plan: &Plan,
    samples: u64,
) -> anyhow::Result<(Readings, RunSummary)> {
    let summary = trial_nodes.conduct(plan).await?;
    let robot = &plan.robots[0].name;
    let found = sensor_readings::count(&plan.bag, robot, Some(samples))?;
    if found.samples < samples {
        print_note(&format!(
            "{robot}: {} readings came while the trial ran, {samples} were planned",
            found.samples
        ));
    }
    Ok((found, summary))
}

/// The trial of one row, each from a seed of its own.
fn plan(arguments: &Arguments, row: &Todo, bags: &Path) -> anyhow::Result<Plan> {
    let mut request = request(arguments);
    request.robot.clone_from(&row.robot);
    request.trial = Trial::Stand { neighbour: row.neighbour, samples: row.samples };
    request.seed += row.line as u64;
    request.bag = Some(free_name(bags, &format!("row_{}", row.line)));
    Plan::of_trial(&request)
}

/// A folder that is not there: a trial that was broken off has left its bag.
fn free_name(bags: &Path, name: &str) -> PathBuf {
    let again = (2..).map(|attempt| bags.join(format!("{name}_{attempt}")));
    std::iter::once(bags.join(name))
        .chain(again)
        .find(|bag| !bag.exists())
        .expect("there are more numbers than folders")
}

/// Where a person puts what is to be detected.
fn place(robot: &str, neighbour: Option<Neighbour>) -> String {
    let Some(Neighbour { distance_m, bearing_rad }) = neighbour else {
        return format!("{robot} alone: take away all that it could detect");
    };
    let side = if bearing_rad > 0.0 { "to the left" } else { "to the right" };
    let bearing = if bearing_rad == 0.0 {
        "straight ahead of it".to_owned()
    } else {
        let degrees = bearing_rad.abs().to_degrees();
        format!("{:.3} rad ({degrees:.1}°) {side}", bearing_rad.abs())
    };
    format!("put another robot {distance_m:.3} m from {robot}, {bearing}, centre to centre")
}

fn text(filled: &Progress) -> String {
    let Progress { table, n_filled, n_left, n_lost } = filled;
    let table = table.display();
    let mut lines = vec![format!("{table}: {n_filled} rows filled in, {n_left} left")];
    if *n_lost > 0 {
        lines.push(format!("{n_lost} messages were lost on the way to the bags"));
    }
    lines.push(if *n_left == 0 {
        format!("next: rsrs measure fit --detection {table} --speed … --turn … --name NAME")
    } else {
        "next: the same command again; it goes on with the rows that are left".to_owned()
    });
    lines.join("\n")
}

/// The trial that the command line itself asks for.
pub fn asked(arguments: &Arguments) -> Trial {
    let place = arguments.distance.zip(arguments.bearing);
    let neighbour = place.map(|(distance_m, bearing_rad)| Neighbour { distance_m, bearing_rad });
    Trial::Stand { neighbour, samples: arguments.samples }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_person_is_told_where_the_neighbour_stands() {
        let at = |distance_m, bearing_rad| Some(Neighbour { distance_m, bearing_rad });

        for (neighbour, expected) in [
            (at(0.3, 0.2), "0.300 m from a, 0.200 rad (11.5°) to the left, centre to centre"),
            (at(0.3, -0.2), "0.300 m from a, 0.200 rad (11.5°) to the right, centre to centre"),
            (at(0.5, 0.0), "0.500 m from a, straight ahead of it, centre to centre"),
            (None, "a alone: take away all that it could detect"),
        ] {
            let told = place("a", neighbour);
            assert!(told.contains(expected), "{told}");
        }
    }
}
