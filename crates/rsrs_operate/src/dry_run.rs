//! The whole loop on one machine: a sweep, a choice, experiments in a network of their own, and their comparison.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::comparison::{Verdict, decided};
use rsrs_core::diagram::choice::{Choice, VIABLE_B_S_LOW};
use rsrs_core::diagram::folder::CHOICE;
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_core::statistics::e_value::TestedCell;
use rsrs_core::statistics::pooled::PooledTest;
use rsrs_core::statistics::share::Share;
use rsrs_experiment_runner::plan::Request;
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::{Backend, EndingKind};
use rsrs_pipeline::choose::{self, Chosen, SearchOptions};
use rsrs_pipeline::compare::CompareOptions;
use rsrs_pipeline::compare::prediction::CHOSEN;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::execution::Execution;
use rsrs_pipeline::files::write_file;
use rsrs_pipeline::label::{LabelOptions, Labeller, label_bag};
use rsrs_pipeline::run_summary::RunSummary;
use rsrs_pipeline::sweep::result::SweepResult;
use rsrs_pipeline::sweep::source::ResolvedSweep;
use rsrs_pipeline::sweep::sweep_into;
use rsrs_render::comparison::Report;
use rsrs_render::dry_run::{
    Compared, DryRunResult, Left, NothingToRun, NumberOfExperiments, NumberedExperiment, Step,
};
use rsrs_render::picture::{self, DiagramOptions};
use rsrs_render::picture_file::{PageStyle, write_svg_and_png};
use rsrs_render::report::html;

use crate::run::operator::Operator;
use crate::run::own_network::OwnNetwork;
use crate::run::side_by_side::{self, Completed, Experiments};

/// Experiments after which a dry run ends undecided. In fewer than one of twenty it comes to that:
/// `the_default_dry_run_ends_with_a_verdict` in `tests/dry_run.rs`.
const MOST_EXPERIMENTS: u64 = 60;

/// By how much the stand-ins may mill less often: with it about 20 experiments decide, in a minute or two.
/// A tenth, the usual margin, would take some hundred where both mill equally often.
const MARGIN: f64 = 0.25;

/// What a dry run goes through, and where it leaves its results.
#[derive(Clone, Copy)]
pub struct DryRun<'a> {
    /// Folder of the results.
    pub folder: &'a Path,
    /// The files behind it.
    pub launch_configs: LaunchConfigs<'a>,
    /// Experiments to run; `None` for as many as decide.
    pub n_experiments: Option<u64>,
    /// Seed of the first experiment; the next has the next seed.
    pub seed: u64,
    /// Simulations and experiments at a time, and who watches simulations.
    pub execution: Execution<'a>,
    /// The network of the first fleet.
    pub network: &'a OwnNetwork,
    /// Who watches experiments.
    pub operator: &'a (dyn Operator + Sync),
    /// Is called with each step.
    pub show: &'a (dyn Fn(&Step<'_>) -> anyhow::Result<()> + Sync),
}

/// The files behind a dry run.
#[derive(Clone, Copy)]
pub struct LaunchConfigs<'a> {
    /// Where they are.
    pub folder: &'a Path,
    /// The sweep file.
    pub sweep: &'a Path,
    /// The experiment file.
    pub experiment: &'a Path,
    /// Whether they were written for this dry run, below its results.
    pub are_starter_files: bool,
}

impl DryRun<'_> {
    /// Goes through the whole loop.
    pub fn run(self) -> anyhow::Result<DryRunResult> {
        let files = self.launch_configs;
        let (folder, launch_configs) = (self.folder.to_owned(), files.folder.to_owned());
        let source = ResolvedSweep::read(files.sweep)?;
        let measured = &source.profile;
        let simulated = source.sweep.factors(measured).apply(measured)?;
        (self.show)(&Step::Profiles { measured, simulated: &simulated })?;

        let sweep = folder.join("sweep");
        let name = files.sweep.display().to_string();
        let result = sweep_into(&sweep, &name, source, self.execution, picture::into_folder)?;
        (self.show)(&Step::Swept(&result))?;
        let options = SearchOptions {
            robots: None,
            wanted: VIABLE_B_S_LOW,
            confirm: choose::CONFIRM,
            execution: self.execution,
        };
        let choice = match choose::choose(&sweep, options)? {
            Chosen::Viable(choice) => choice,
            Chosen::NoViableCell(choice) => {
                let nothing = NothingToRun { folder, launch_configs, sweep, choice };
                return Ok(DryRunResult::NothingToRun(Box::new(nothing)));
            }
        };
        choose::write(&sweep.join(CHOICE), &choice)?;
        (self.show)(&Step::Chosen(&choice))?;

        let experiments = self.run_experiments(&sweep, &choice)?;
        let counted = experiments.iter().filter(|run| run.ending == EndingKind::Completed);
        let bags = counted.filter_map(|summary| summary.bag.clone()).collect();
        let runs = CompareOptions {
            bags,
            labels: Labeller::Judge,
            with_lost_robots: false,
            with_implausible: false,
            margin: Some(MARGIN),
            poses: None,
            other_profile: OtherProfile::Refused,
        };
        let (page, comparison) = html(&sweep, Some(&runs))?;
        let mut comparison = comparison.context("a report of runs compares them")?;
        comparison.at_hand.experiment = Some(files.experiment.to_owned());
        (self.show)(&Step::Compared(&comparison))?;
        let json = serde_json::to_string_pretty(&comparison).context("the comparison as JSON")?;
        write_file(&folder.join("comparison.json"), format!("{json}\n").as_bytes())?;
        let report = folder.join("report.html");
        write_file(&report, page.as_bytes())?;

        let diagram = self.draw(&result, &choice, &comparison)?;
        (self.show)(&Step::Left(Left {
            folder: self.folder,
            has_starter_files: files.are_starter_files,
            experiment: files.experiment,
            bags: &runs.bags,
        }))?;
        Ok(DryRunResult::Compared(Box::new(Compared {
            folder,
            launch_configs,
            sweep,
            diagram,
            report,
            choice,
            experiments,
            comparison,
        })))
    }

    /// Runs experiments in the chosen cell until they decide, or as many as are asked for.
    fn run_experiments(&self, sweep: &Path, choice: &Choice) -> anyhow::Result<Vec<RunSummary>> {
        let requests = (1..=self.n_experiments.unwrap_or(MOST_EXPERIMENTS))
            .map(|number| Request {
                experiment: self.launch_configs.experiment.to_owned(),
                cell: None,
                from: Some(sweep.to_path_buf()),
                backend: Backend::Simulator,
                bag: Some(self.folder.join(format!("bags/experiment_{number}"))),
                seed: Some(self.seed + number - 1),
                place_check: PlaceCheck::Off,
                other_profile: OtherProfile::Refused,
            })
            .collect::<Vec<Request>>();
        (self.show)(&Step::NetworkEntered(&self.network.isolation))?;
        let mut summaries = Vec::new();
        let mut real = Share::default();
        let experiments = Experiments {
            requests: &requests,
            n_at_once: self.execution.n_threads,
            network: self.network,
            operator: self.operator,
            made_again: &|index, attempt| {
                let experiment = self.numbered(index);
                // What cannot be shown is no reason to end an experiment.
                drop((self.show)(&Step::TriedAgain { experiment, attempt }));
            },
        };
        let ran = side_by_side::run(experiments, |index, Completed { summary, before }| {
            summaries.extend(before);
            let bag = summary.bag.as_deref().context("a completed experiment has a bag")?;
            let label = label_bag(bag, LabelOptions::default())?;
            let experiment = self.numbered(index);
            (self.show)(&Step::Ran { experiment, summary: &summary, label: &label })?;
            summaries.push(summary);
            real.n += 1;
            real.hits += u64::from(label.phase == label.phase.behaviour().wanted());
            let is_enough = self.n_experiments.is_none() && is_decided(real, choice)?;
            Ok(if is_enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
        });
        ran.map_err(|error| {
            let there = format!("what there is so far is in {}", self.folder.display());
            with_help(format!("{error:#}"), there)
        })?;
        Ok(summaries)
    }

    fn numbered(&self, index: usize) -> NumberedExperiment {
        let n_experiments = self
            .n_experiments
            .map_or(NumberOfExperiments::AtMost(MOST_EXPERIMENTS), NumberOfExperiments::Fixed);
        let index = index as u64;
        NumberedExperiment { number: index + 1, n_experiments, seed: self.seed + index }
    }

    /// The diagram with the chosen cell and the experiments on it.
    fn draw(
        &self,
        result: &SweepResult,
        choice: &Choice,
        comparison: &Report,
    ) -> anyhow::Result<PathBuf> {
        let options = DiagramOptions {
            chosen: Some(choice.clone()),
            experiments: comparison.marks(),
            ..DiagramOptions::default()
        };
        let svg = picture::of_sweep(result, &options)?;
        write_svg_and_png(self.folder, "diagram", &svg, PageStyle::default())?;
        Ok(self.folder.join("diagram.png"))
    }
}

/// Whether so many runs in the chosen cell end in a verdict.
fn is_decided(real: Share, choice: &Choice) -> anyhow::Result<bool> {
    let phases = choice.phases.context("a choice that was just made has its phases")?;
    let simulated = Share::milling(&phases);
    let test = PooledTest::new(&[TestedCell { real, simulated, part: CHOSEN }], MARGIN);
    Ok(decided(&test) != Verdict::Undecided)
}
