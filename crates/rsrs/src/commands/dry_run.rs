//! `rsrs dry-run`: the whole loop on this machine, without robots.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::comparison::{Verdict, decided};
use rsrs_core::diagram::choice::{Choice, VIABLE_B_S_LOW};
use rsrs_core::diagram::folder::CHOICE;
use rsrs_core::numerals::counted;
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_core::statistics::e_value::TestedCell;
use rsrs_core::statistics::pooled::PooledTest;
use rsrs_core::statistics::share::Share;
use rsrs_experiment_runner::plan::Request;
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::{Backend, EndingKind};
use rsrs_ros::logging::{self, Level};
use serde::Serialize;

use crate::commands::{self, Format, report};
use crate::experiment_bar::{TerminalOperator, above_bars};
use crate::failure::Outcome;
use crate::notes::print_note;
use crate::starter_files::StarterFiles;
use crate::threads_argument::ThreadsArgument;
use rsrs_operate::run::RunSummary;
use rsrs_operate::run::own_network::OwnNetwork;
use rsrs_operate::run::side_by_side::{self, Completed, Experiments};
use rsrs_pipeline::choose::{self, Chosen};
use rsrs_pipeline::compare;
use rsrs_pipeline::compare::prediction::CHOSEN;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::{ANOTHER_FOLDER, write_file};
use rsrs_pipeline::label::{LabelOptions, Labeller, label_bag};
use rsrs_pipeline::sweep::result::SweepResult;
use rsrs_pipeline::sweep::source::ResolvedSweep;
use rsrs_pipeline::sweep::sweep_into;
use rsrs_render::choice::NoViableCellJson;
use rsrs_render::comparison::{self, Report as Comparison};
use rsrs_render::dry_run::{Left, chosen, left, measured_and_harsher, no_viable_cell, swept};
use rsrs_render::label::toned_phase_of;
use rsrs_render::picture::{self, DiagramOptions};
use rsrs_render::picture_file::{PageStyle, write_svg_and_png};
use rsrs_render::report::html;
use rsrs_render::words::Words;

/// Go through the whole loop on this machine: no robots, no LAN.
///
/// Robots made worse than measured are simulated into a phase diagram, a cell is chosen and run over
/// ROS 2, and the bags are labelled and compared. In these runs, simulated robots as measured stand in
/// for real ones. Runs are made, `--threads` at a time, until they decide whether those mill as often
/// as the worse ones, or at most 25 percentage points less often; looking at the verdict after every
/// run does not weaken it. Everything is left in one folder, and `report.html` shows it. Exit code 3
/// means that no cell is viable.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of your own robots, as `rsrs init` makes it, with sweep.yaml and experiment.yaml (default:
    /// nine Flockbots, whose files are left in the folder of the results).
    folder: Option<PathBuf>,
    /// Experiments to run, each with a seed of its own (default: as many as decide, at most 60).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000))]
    experiments: Option<u64>,
    /// Seed of the first experiment; the next has the next seed (default: 1).
    #[arg(long, value_name = "SEED", default_value_t = 1, hide_default_value = true,
          value_parser = clap::value_parser!(u64).range(..1 << 62))]
    seed: u64,
    #[command(flatten)]
    threads: ThreadsArgument,
    /// Folder to make; it must not exist (default: `results/dry-run`, with a number if taken).
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Experiments after which a dry run ends undecided. In fewer than one of twenty it comes to that:
/// `the_default_dry_run_ends_with_a_verdict` in `tests/dry_run.rs`.
const MOST_EXPERIMENTS: u64 = 60;

/// By how much the stand-ins may mill less often: with it about 20 experiments decide, in a minute or two.
/// A tenth, the usual margin, would take some hundred where both mill equally often.
const MARGIN: f64 = 0.25;

/// What a dry run leaves.
#[derive(Serialize)]
struct Summary {
    folder: PathBuf,
    launch_configs: PathBuf,
    sweep: PathBuf,
    diagram: PathBuf,
    report: PathBuf,
    choice: Choice,
    experiments: Vec<RunSummary>,
    comparison: Comparison,
}

/// What it leaves where no cell is viable.
#[derive(Serialize)]
struct NothingToRun<'a> {
    folder: PathBuf,
    launch_configs: PathBuf,
    sweep: PathBuf,
    choice: NoViableCellJson<'a>,
}

/// The whole loop, and where it leaves its results.
struct DryRun<'a> {
    arguments: &'a Arguments,
    folder: PathBuf,
    network: OwnNetwork,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let folder = match &arguments.output {
        Some(folder) if folder.exists() => {
            return Err(with_help(format!("{} exists", folder.display()), ANOTHER_FOLDER));
        }
        Some(folder) => folder.clone(),
        None => free_folder(),
    };
    // Before the first thread is started.
    let network = OwnNetwork::enter()?;
    logging::init(Level::Warn);
    DryRun { arguments, folder, network }.whole_loop()
}

/// The first of `results/dry-run`, `results/dry-run-2`, … that does not exist.
fn free_folder() -> PathBuf {
    let numbered = (2..).map(|number| PathBuf::from(format!("results/dry-run-{number}")));
    std::iter::once(PathBuf::from("results/dry-run"))
        .chain(numbered)
        .find(|folder| !folder.exists())
        .expect("the numbers do not end before the disk does")
}

impl DryRun<'_> {
    fn whole_loop(&self) -> anyhow::Result<Outcome> {
        let (launch_configs, files) = if let Some(folder) = &self.arguments.folder {
            (folder.clone(), StarterFiles::in_folder(folder)?)
        } else {
            let folder = self.folder.join("launch_configs");
            let files = StarterFiles::write(&folder)?;
            (folder, files)
        };
        let source = ResolvedSweep::read(&files.sweep)?;
        self.print(measured_and_harsher(&source)?)?;

        let (folder, sweep) = (self.folder.clone(), self.folder.join("sweep"));
        let name = files.sweep.display().to_string();
        let watched = self.arguments.threads.execution()?;
        let result = sweep_into(&sweep, &name, source, watched, picture::into_folder)?;
        self.print(swept(&result))?;
        let options = choose::SearchOptions {
            robots: None,
            wanted: VIABLE_B_S_LOW,
            confirm: choose::CONFIRM,
            execution: watched,
        };
        let choice = match choose::choose(&sweep, options)? {
            Chosen::Viable(choice) => choice,
            Chosen::NoViableCell(none) => {
                let printed = no_viable_cell(&none, &sweep);
                let choice = NoViableCellJson::from(&none);
                let nothing = NothingToRun { folder, launch_configs, sweep, choice };
                report(self.arguments.format, &nothing, printed)?;
                return Ok(Outcome::NegativeAnswer);
            }
        };
        choose::write(&sweep.join(CHOICE), &choice)?;
        self.print(chosen(&choice))?;

        let experiments = self.run_experiments(&files, &sweep, &choice)?;
        let counted = experiments.iter().filter(|run| run.ending == EndingKind::Completed);
        let bags = counted.filter_map(|summary| summary.bag.clone()).collect();
        let runs = compare::CompareOptions {
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
        comparison.at_hand.experiment = Some(files.experiment.clone());
        self.print("")?;
        self.print(comparison::text(&comparison))?;
        let json = serde_json::to_string_pretty(&comparison).context("the comparison as JSON")?;
        write_file(&folder.join("comparison.json"), format!("{json}\n").as_bytes())?;
        let report = folder.join("report.html");
        write_file(&report, page.as_bytes())?;

        let diagram = self.draw(&result, &choice, &comparison)?;
        self.print(left(&Left {
            folder: &self.folder,
            has_starter_files: self.arguments.folder.is_none(),
            experiment: &files.experiment,
            bags: &runs.bags,
        }))?;
        if self.arguments.format == Format::Json {
            let summary = Summary {
                folder,
                launch_configs,
                sweep,
                diagram,
                report,
                choice,
                experiments,
                comparison,
            };
            commands::report(Format::Json, &summary, "")?;
        }
        Ok(Outcome::Done)
    }

    /// Prints in text how far it is; JSON comes whole at the end.
    fn print(&self, words: impl Into<Words>) -> anyhow::Result<()> {
        match self.arguments.format {
            Format::Json => Ok(()),
            Format::Text => above_bars(|| commands::print_text(words)),
        }
    }

    fn run_experiments(
        &self,
        files: &StarterFiles,
        sweep: &Path,
        choice: &Choice,
    ) -> anyhow::Result<Vec<RunSummary>> {
        let requests = (1..=self.arguments.experiments.unwrap_or(MOST_EXPERIMENTS))
            .map(|number| Request {
                experiment: files.experiment.clone(),
                cell: None,
                from: Some(sweep.to_path_buf()),
                backend: Backend::Simulator,
                bag: Some(self.folder.join(format!("bags/experiment_{number}"))),
                seed: Some(self.arguments.seed + number - 1),
                place_check: PlaceCheck::Off,
                other_profile: OtherProfile::Refused,
            })
            .collect::<Vec<Request>>();
        print_note(&self.network.note);
        let of = match self.arguments.experiments {
            Some(n) => format!("of {n}"),
            None => format!("of at most {}", requests.len()),
        };
        let name = |index: usize| {
            let seed = self.arguments.seed + index as u64;
            format!("experiment {} {of}: seed {seed}", index + 1)
        };
        let mut summaries = Vec::new();
        let mut real = Share::default();
        let experiments = Experiments {
            requests: &requests,
            n_at_once: self.arguments.threads.number(),
            network: &self.network,
            operator: &TerminalOperator,
            made_again: &|index, attempt| {
                let name = name(index);
                // What cannot be printed is no reason to end an experiment.
                drop(
                    self.print(format!("{name}: {attempt}; it does not count, and is tried again")),
                );
            },
        };
        let ran = side_by_side::run(experiments, |index, Completed { summary, before }| {
            summaries.extend(before);
            let bag = summary.bag.as_deref().context("a completed experiment has a bag")?;
            let labelled = label_bag(bag, LabelOptions::default())?;
            let phase = labelled.phase;
            let pace = summary
                .real_time_factor
                .map_or_else(String::new, |factor| format!(", {factor:.0} times real time"));
            let run = format!(
                "{}, {} s over DDS{pace}, {} recorded: ",
                name(index),
                summary.duration_s,
                counted(summary.n_messages, "message")
            );
            self.print(Words::from(run).then(toned_phase_of(&labelled)))?;
            summaries.push(summary);
            real.n += 1;
            real.hits += u64::from(phase == phase.behaviour().wanted());
            let is_enough = self.arguments.experiments.is_none() && is_decided(real, choice)?;
            Ok(if is_enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
        });
        ran.map_err(|error| {
            let there = format!("what there is so far is in {}", self.folder.display());
            with_help(format!("{error:#}"), there)
        })?;
        Ok(summaries)
    }

    /// The diagram with the chosen cell and the experiments on it.
    fn draw(
        &self,
        result: &SweepResult,
        choice: &Choice,
        comparison: &Comparison,
    ) -> anyhow::Result<PathBuf> {
        let experiments = comparison.marks();
        let options = DiagramOptions {
            chosen: Some(choice.clone()),
            experiments,
            ..DiagramOptions::default()
        };
        let svg = picture::of_sweep(result, &options)?;
        write_svg_and_png(&self.folder, "diagram", &svg, PageStyle::default())?;
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
