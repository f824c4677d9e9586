//! All trials of one table or of a plan that are not made yet, one after the other.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::trials::trial::TrialKind;
use rsrs_experiment_runner::plan::{Plan, TrialRequest, Unmeasured};
use rsrs_pipeline::error::with_help;
use tokio::runtime::Runtime;

use super::period_table::PeriodTable;
use super::result::{TrialResult, backend};
use super::trial_nodes::TrialNodes;
use super::trial_table::{Todo, TrialTable};
use super::{DriveOptions, Ready, TrialOperator, made};
use crate::run::RunTarget;
use rsrs_files::quoted;
use rsrs_render::driven_trials::Filled;
use rsrs_render::operator_event::OperatorEvent;
use rsrs_ros::runtime::runtime;

/// A trial in which commands pause is made again at once, up to this often in all; after that the same
/// command makes it again.
const ATTEMPTS: usize = 3;

/// The tables to fill in, and where their bags go.
struct Work {
    /// What the user gave.
    given: PathBuf,
    tables: Vec<TrialTable>,
    periods: Option<PeriodTable>,
    bags: PathBuf,
    /// Greatest commands of all tables, in m/s and rad/s.
    limits: [f64; 2],
}

/// One row that is to be filled in.
#[derive(Clone, Debug)]
struct Job {
    /// Position of its table.
    table: usize,
    todo: Todo,
}

/// Fills in one table, row by row; what is filled in already stays, also if a later trial is not
/// completed.
pub fn fill_table(
    options: &DriveOptions,
    path: &Path,
    enter: impl FnOnce() -> anyhow::Result<RunTarget>,
    operator: &dyn TrialOperator,
) -> anyhow::Result<Filled> {
    let tables = vec![TrialTable::open(path)?];
    let bags = options.output.clone().unwrap_or_else(|| path.with_extension("bags"));
    let limits = limits(&tables)?;
    fill(
        options,
        Work { given: path.to_owned(), tables, periods: None, bags, limits },
        enter,
        operator,
    )
}

/// Fills in all tables in the folder of a plan.
pub fn fill_plan(
    options: &DriveOptions,
    folder: &Path,
    enter: impl FnOnce() -> anyhow::Result<RunTarget>,
    operator: &dyn TrialOperator,
) -> anyhow::Result<Filled> {
    let paths = TrialKind::MADE.map(|kind| folder.join(kind.file()));
    let tables = paths.iter().filter(|path| path.exists()).map(|path| TrialTable::open(path));
    let tables = tables.collect::<anyhow::Result<Vec<_>>>()?;
    if tables.is_empty() {
        return Err(with_help(
            format!("{} has none of the tables of a plan", folder.display()),
            format!("make them: `rsrs measure plan FLEET -o {}`", quoted(folder)),
        ));
    }
    let periods = folder.join(TrialKind::Period.file());
    let periods = periods.exists().then(|| PeriodTable::open(&periods)).transpose()?;
    let bags = options.output.clone().unwrap_or_else(|| folder.join("bags"));
    let limits = limits(&tables)?;
    fill(options, Work { given: folder.to_owned(), tables, periods, bags, limits }, enter, operator)
}

/// The greatest commands of all rows, those that are made already too: whatever is left, the robots
/// get the same limits.
fn limits(tables: &[TrialTable]) -> anyhow::Result<[f64; 2]> {
    let mut limits = [0.0_f64; 2];
    for table in tables {
        for (Todo { trial, .. }, _) in table.rows()? {
            let command = trial.command();
            limits = [limits[0].max(command.speed_m_s), limits[1].max(command.turn_rate_rad_s)];
        }
    }
    Ok(limits)
}

fn fill(
    options: &DriveOptions,
    mut work: Work,
    enter: impl FnOnce() -> anyhow::Result<RunTarget>,
    operator: &dyn TrialOperator,
) -> anyhow::Result<Filled> {
    let jobs = work.jobs()?;
    // Whatever is wrong with a row is reported before the first robot is used.
    let mut backends = Vec::new();
    for job in &jobs {
        let path = work.tables[job.table].path().display().to_string();
        let plan = work.plan(options, job).with_context(|| format!("{path}:{}", job.todo.line))?;
        if !backends.contains(&backend(&plan)) {
            backends.push(backend(&plan));
        }
    }
    for (table, backend) in
        work.tables.iter().flat_map(|table| backends.iter().map(move |it| (table, it)))
    {
        table.check_mixture(*backend)?;
    }
    let only = match &work.tables[..] {
        [one] => Some(one.kind().name()),
        _ => None,
    };
    let mut filled = Filled {
        table: work.given.clone(),
        only,
        n_filled: 0,
        n_left: jobs.len(),
        n_attempts: ATTEMPTS,
        n_paused: 0,
        n_lost: 0,
    };
    if !jobs.is_empty() {
        std::fs::create_dir_all(&work.bags)
            .with_context(|| format!("cannot make {}", work.bags.display()))?;
        let target = enter()?;
        let runtime = runtime()?;
        for jobs in jobs.chunk_by(|job, next| job.todo.robot == next.todo.robot) {
            let mut shift = Shift { options, work: &mut work, target: &target, operator };
            if !shift.work(&runtime, jobs, &mut filled)? {
                break;
            }
        }
    }
    Ok(filled)
}

impl Work {
    /// All rows that are to be filled in, robot after robot, each from drives to readings.
    fn jobs(&self) -> anyhow::Result<Vec<Job>> {
        let mut jobs = Vec::new();
        for (table, rows) in self.tables.iter().enumerate() {
            jobs.extend(rows.todo()?.into_iter().map(|todo| Job { table, todo }));
        }
        if self.tables.len() > 1 {
            let mut robots: Vec<String> = Vec::new();
            for job in &jobs {
                if !robots.contains(&job.todo.robot) {
                    robots.push(job.todo.robot.clone());
                }
            }
            jobs.sort_by_key(|job| robots.iter().position(|robot| *robot == job.todo.robot));
        }
        Ok(jobs)
    }

    /// The trial of one row, each from a seed of its own.
    fn plan(&self, options: &DriveOptions, job: &Job) -> anyhow::Result<Plan> {
        let Todo { line, robot, trial } = &job.todo;
        let usual = options.request(robot, *trial);
        let measured_s = self.periods.as_ref().and_then(PeriodTable::mean_s);
        let period_s = options.period_s.or(measured_s).unwrap_or(usual.unmeasured.period_s);
        // Rows of different tables are drawn from different seeds.
        let seed = usual.seed + *line as u64 + 100_000 * job.table as u64;
        Plan::of_trial(&TrialRequest {
            seed,
            bag: Some(free_name(&self.bags, &self.bag_name(job))),
            unmeasured: Unmeasured { limits: Some(self.limits), period_s },
            ..usual
        })
    }

    fn bag_name(&self, job: &Job) -> String {
        let kind =
            if self.tables.len() == 1 { "row" } else { self.tables[job.table].kind().name() };
        format!("{kind}_{}", job.todo.line)
    }
}

/// Trials of one robot after the other, by one crew.
struct Shift<'a> {
    options: &'a DriveOptions,
    work: &'a mut Work,
    target: &'a RunTarget,
    operator: &'a dyn TrialOperator,
}

impl Shift<'_> {
    /// Makes the trials; false if the operator ends them.
    fn work(
        &mut self,
        runtime: &Runtime,
        jobs: &[Job],
        filled: &mut Filled,
    ) -> anyhow::Result<bool> {
        let plans = jobs.iter().map(|job| self.work.plan(self.options, job));
        let plans = plans.collect::<anyhow::Result<Vec<Plan>>>()?;
        // The one that is measured, and those that are put beside it in some trial.
        let all = plans.iter().max_by_key(|plan| plan.robots.len());
        let all = all.context("a group of rows has at least one")?;
        let mut trial_nodes = {
            let _guard = runtime.enter();
            TrialNodes::start(self.target, all, self.operator.operator())?
        };
        let mut goes_on = true;
        let worked = jobs.iter().try_for_each(|job| {
            if goes_on {
                goes_on = self.job(runtime, &mut trial_nodes, job, filled)?;
            }
            anyhow::Ok(())
        });
        let stopped = runtime.block_on(trial_nodes.stop());
        worked?;
        stopped?;
        Ok(goes_on)
    }

    /// Makes the trial of one row, again if commands paused; false if the operator ends here.
    fn job(
        &mut self,
        runtime: &Runtime,
        trial_nodes: &mut TrialNodes,
        job: &Job,
        filled: &mut Filled,
    ) -> anyhow::Result<bool> {
        let Job { table, todo } = job;
        let (n_left, n_rows) = (filled.n_left, filled.n_filled + filled.n_left);
        let row = self.work.bag_name(job);
        let (robot, trial) = (&todo.robot, &todo.trial);
        self.operator.operator().inform(&OperatorEvent::RowBegun {
            row: &row,
            n_left,
            n_rows,
            robot,
            trial,
        });
        for attempt in 1..=ATTEMPTS {
            match runtime.block_on(self.operator.ready(robot, trial))? {
                Ready::Go => {}
                Ready::Skip => return Ok(true),
                Ready::End => return Ok(false),
            }
            let plan = self.work.plan(self.options, job)?;
            let (found, summary) =
                runtime.block_on(made(trial_nodes, &plan, todo.trial, self.operator))?;
            self.work.tables[*table].fill(todo, &found.found())?;
            filled.n_lost += summary.n_lost;
            self.note_periods(&found)?;
            let Some(paused_s) = found.paused_s else {
                filled.n_filled += 1;
                filled.n_left -= 1;
                return Ok(true);
            };
            self.operator.operator().inform(&OperatorEvent::RowPaused {
                table: self.work.tables[*table].path(),
                line: todo.line,
                paused_s,
                is_made_again: attempt < ATTEMPTS,
            });
        }
        filled.n_paused += 1;
        Ok(true)
    }

    /// Control periods come with every trial; one in which commands paused gives none.
    fn note_periods(&mut self, found: &TrialResult) -> anyhow::Result<()> {
        match &mut self.work.periods {
            Some(periods) if found.paused_s.is_none() => {
                periods.fill(&found.robot, &found.periods_s, found.backend)
            }
            _ => Ok(()),
        }
    }
}

/// A folder that is not there: a trial that was broken off has left its bag.
fn free_name(bags: &Path, name: &str) -> PathBuf {
    let again = (2..).map(|attempt| bags.join(format!("{name}_{attempt}")));
    std::iter::once(bags.join(name))
        .chain(again)
        .find(|bag| !bag.exists())
        .expect("there are more numbers than folders")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bag_that_was_broken_off_stays_and_the_next_one_has_another_name() {
        let bags = tempfile::tempdir().unwrap();
        let name = |bag: PathBuf| bag.file_name().unwrap().to_string_lossy().into_owned();

        assert_eq!(name(free_name(bags.path(), "turn_2")), "turn_2");
        for made in ["turn_2", "turn_2_2"] {
            std::fs::create_dir(bags.path().join(made)).unwrap();
        }
        assert_eq!(name(free_name(bags.path(), "turn_2")), "turn_2_3");
    }
}
