//! `rsrs dry-run`: the whole loop on this machine, without robots.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::comparison::{Verdict, decided};
use rsrs_core::diagram::choice::{Choice, VIABLE_B_S_LOW};
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_core::statistics::e_value::TestedCell;
use rsrs_core::statistics::pooled::PooledTest;
use rsrs_core::statistics::share::Share;
use rsrs_experiment_runner::plan::{Plan, Request};
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::{Backend, EndingKind};
use rsrs_ros::logging::{self, Level};
use serde::Serialize;

use crate::commands::{self, Format, report};
use crate::experiment_bar::TerminalOperator;
use crate::failure::Outcome;
use crate::notes::print_note;
use crate::progress::execution;
use crate::starter_files::StarterFiles;
use crate::sweep_report::in_words;
use crate::verdicts;
use crate::words::Words;
use rsrs_operate::run::own_network::OwnNetwork;
use rsrs_operate::run::simulated_fleet::SimulatedFleet;
use rsrs_operate::run::{RunSummary, on_simulated_fleet};
use rsrs_operate::runtime::runtime;
use rsrs_pipeline::attempt::{SIMULATED_TRIES, keep_aside};
use rsrs_pipeline::choose::{self, Chosen};
use rsrs_pipeline::compare;
use rsrs_pipeline::compare::prediction::CHOSEN;
use rsrs_pipeline::compare::report::Report as Comparison;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::{write_file, write_svg_and_png};
use rsrs_pipeline::label::{LabelOptions, Labeller, label_bag};
use rsrs_pipeline::picture::{self, DiagramOptions};
use rsrs_pipeline::sweep::result::SweepResult;
use rsrs_pipeline::sweep::settling;
use rsrs_pipeline::sweep::source::ResolvedSweep;
use rsrs_pipeline::sweep::sweep_into;
use rsrs_pipeline::wording::shell::quoted;

/// Go through the whole loop on this machine: no robots, no LAN.
///
/// From the measured profile over a simulator that is made worse to the phase diagram, the chosen
/// cell, experiments over ROS 2, bags, labels, and the comparison of real with simulated runs. The
/// measured profile, moved by the simulator, stands in for the real robots. Experiments are run until
/// they decide whether those mill as often as the worse ones, or at most 25 percentage points less
/// often; as the verdict may be looked at after every run, that is no less sure. Every file that was
/// used is left in the folder, to be changed and run again.
#[derive(clap::Args)]
pub struct Arguments {
    /// Experiments to run, each with a seed of its own (default: as many as decide, at most 60).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000))]
    experiments: Option<u64>,
    /// Seed of the first experiment; the next has the next seed (default: 1).
    #[arg(long, value_name = "SEED", default_value_t = 1, hide_default_value = true,
          value_parser = clap::value_parser!(u64).range(..1 << 62))]
    seed: u64,
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
    choice: Choice,
    experiments: Vec<RunSummary>,
    comparison: Comparison,
}

/// The whole loop, and where it leaves its results.
struct DryRun<'a> {
    arguments: &'a Arguments,
    folder: PathBuf,
    network: OwnNetwork,
}

/// Runs the command.
///
/// # Errors
///
/// If the folder exists, or a step fails.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let folder = match &arguments.output {
        Some(folder) if folder.exists() => {
            return Err(with_help(
                format!("{} exists", folder.display()),
                "give another folder with `-o`, or remove this one",
            ));
        }
        Some(folder) => folder.clone(),
        None => free_folder(),
    };
    // Before the first thread is started.
    let network = OwnNetwork::enter()?;
    logging::init(Level::Warn, std::env::var("RUST_LOG").ok().as_deref());
    let dry_run = DryRun { arguments, folder, network };
    let summary = dry_run.whole_loop()?;
    if arguments.format == Format::Json {
        report(Format::Json, &summary, "")?;
    }
    Ok(Outcome::Done)
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
    fn whole_loop(&self) -> anyhow::Result<Summary> {
        let launch_configs = self.folder.join("launch_configs");
        let files = StarterFiles::write(&launch_configs)?;
        let source = ResolvedSweep::read(&files.sweep)?;
        self.print(measured_and_harsher(&source)?)?;

        let sweep = self.folder.join("sweep");
        let name = files.sweep.display().to_string();
        let result = sweep_into(&sweep, &name, source, execution(None)?, picture::into_folder)?;
        self.print(swept(&result))?;
        let choice = choose_cell(&sweep)?;
        self.print(chosen(&choice))?;

        let experiments = self.run_experiments(&files, &sweep, &choice)?;
        let counted = experiments.iter().filter(|run| run.ending == EndingKind::Completed.key());
        let bags = counted.filter_map(|summary| summary.bag.clone()).collect();
        let runs = compare::Options {
            bags,
            labels: Labeller::Judge,
            with_lost_robots: false,
            with_implausible: false,
            margin: MARGIN,
            poses: None,
            other_profile: OtherProfile::Refused,
        };
        let mut comparison = compare::compare(&sweep, &runs)?;
        comparison.at_hand.experiment = quoted(&files.experiment);
        self.print("")?;
        self.print(verdicts::comparison(&comparison))?;
        let json = serde_json::to_string_pretty(&comparison).context("the comparison as JSON")?;
        write_file(&self.folder.join("comparison.json"), format!("{json}\n").as_bytes())?;

        let diagram = self.draw(&result, &choice, &comparison)?;
        self.print(self.files(&runs.bags))?;
        let folder = self.folder.clone();
        Ok(Summary { folder, launch_configs, sweep, diagram, choice, experiments, comparison })
    }

    /// Prints in text how far it is; JSON comes whole at the end.
    fn print(&self, words: impl Into<Words>) -> anyhow::Result<()> {
        match self.arguments.format {
            Format::Json => Ok(()),
            Format::Text => commands::print_text(words),
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
        let first = Plan::read(&requests[0])?;
        runtime()?.block_on(async {
            let mut fleet = SimulatedFleet::start(&self.network, &first)?;
            let summaries = self.run_all(&requests, choice, &mut fleet).await;
            fleet.stop().await?;
            summaries
        })
    }

    async fn run_all(
        &self,
        requests: &[Request],
        choice: &Choice,
        fleet: &mut SimulatedFleet,
    ) -> anyhow::Result<Vec<RunSummary>> {
        let of = match self.arguments.experiments {
            Some(n) => format!("of {n}"),
            None => format!("of at most {}", requests.len()),
        };
        let mut summaries = Vec::new();
        let mut real = Share::default();
        for (request, number) in requests.iter().zip(1..) {
            let experiment = format!("experiment {number} {of}");
            let summary = self.until_completed(request, &experiment, fleet, &mut summaries).await?;
            let bag = summary.bag.as_deref().context("a completed experiment has a bag")?;
            let labelled = label_bag(bag, LabelOptions::default())?;
            let phase = labelled.phase;
            let pace = summary
                .real_time_factor
                .map_or_else(String::new, |factor| format!(", {factor:.0} times real time"));
            let run = format!(
                "{experiment}: seed {}, {} s over DDS{pace}, {} messages recorded: ",
                request.seed.unwrap_or_default(),
                summary.duration_s,
                summary.n_messages
            );
            self.print(verdicts::phase(&labelled, run))?;
            summaries.push(summary);
            real.n += 1;
            real.hits += u64::from(phase == phase.behaviour().wanted());
            if self.arguments.experiments.is_none() && is_decided(real, choice)? {
                break;
            }
        }
        Ok(summaries)
    }

    /// Runs an experiment, again where it gave no result for a cause that was known before.
    ///
    /// # Errors
    ///
    /// If it may not be tried again, or has been often enough.
    async fn until_completed(
        &self,
        request: &Request,
        experiment: &str,
        fleet: &mut SimulatedFleet,
        summaries: &mut Vec<RunSummary>,
    ) -> anyhow::Result<RunSummary> {
        let mut n_tries = 0;
        loop {
            n_tries += 1;
            let plan = Plan::read(request)?;
            let mut summary =
                on_simulated_fleet(&plan, &self.network, fleet, &TerminalOperator).await?;
            if summary.ending == EndingKind::Completed.key() {
                return Ok(summary);
            }
            let attempt = summary.attempt(&plan.record);
            if !attempt.is_made_again(&plan.record, n_tries, SIMULATED_TRIES) {
                return Err(with_help(
                    format!("{experiment} {}: {}", summary.ending, summary.reason),
                    format!("what there is so far is in {}", self.folder.display()),
                ));
            }
            self.print(format!(
                "{experiment}: seed {}: {attempt}; it does not count, and is tried again",
                plan.record.seed
            ))?;
            summary.bag = keep_aside(&plan.bag)?;
            summaries.push(summary);
        }
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
        write_svg_and_png(&self.folder, "diagram", &svg)?;
        Ok(self.folder.join("diagram.png"))
    }

    fn files(&self, bags: &[PathBuf]) -> String {
        let folder = self.folder.display();
        let mut lines = vec![
            String::new(),
            format!("{folder}/launch_configs   the files behind it: change them and run again"),
            format!("{folder}/sweep            cells.csv, replicates.parquet, choice.json"),
            format!("{folder}/diagram.png      the phase diagram (also as .svg)"),
            format!("{folder}/comparison.json"),
        ];
        lines.push(match bags {
            [] => format!("{folder}/bags             no experiment was completed"),
            [bag] => format!("{}   its recording", bag.display()),
            [.., last] => {
                format!("{folder}/bags             experiment_1 and on, to {}", last.display())
            }
        });
        lines.push(format!(
            "another cell: rsrs run {folder}/launch_configs/experiments/flockbot_milling.yaml --cell \
             speed_m_s=0.15,turn_rate_rad_s=0.75,robots=9"
        ));
        lines.join("\n")
    }
}

/// Whether so many runs in the chosen cell end in a verdict.
fn is_decided(real: Share, choice: &Choice) -> anyhow::Result<bool> {
    let phases = choice.phases.context("a choice that was just made has its phases")?;
    let simulated = Share::milling(&phases);
    let test = PooledTest::new(&[TestedCell { real, simulated, part: CHOSEN }], MARGIN);
    Ok(decided(&test) != Verdict::Undecided)
}

fn choose_cell(sweep: &Path) -> anyhow::Result<Choice> {
    let options = choose::Options {
        robots: None,
        wanted: VIABLE_B_S_LOW,
        confirm: choose::CONFIRM,
        execution: execution(None)?,
    };
    match choose::choose(sweep, options)? {
        Chosen::Viable(choice) => {
            choose::write(&sweep.join("choice.json"), &choice)?;
            Ok(choice)
        }
        Chosen::NoViableCell(none) => Err(anyhow::anyhow!("no viable cell: {}", none.reason)),
    }
}

fn measured_and_harsher(source: &ResolvedSweep) -> anyhow::Result<String> {
    let measured = &source.profile;
    let simulated = source.sweep.factors(measured).apply(measured)?;
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    Ok(format!(
        "profile: {}, as measured; simulated worse: spread of the gains {} to {}, missed detections \
         {} to {}, false ones {} to {}",
        measured.name,
        percent(measured.actuation.speed.robot_sd),
        percent(simulated.actuation.speed.robot_sd),
        percent(1.0 - measured.sensing.true_positive),
        percent(1.0 - simulated.sensing.true_positive),
        percent(measured.sensing.false_positive),
        percent(simulated.sensing.false_positive),
    ))
}

fn swept(result: &SweepResult) -> String {
    format!(
        "sweep: {} cells, {} runs of {} s each in both worlds: {}",
        result.diagram.cells.len(),
        result.source.sweep.replicates,
        result.source.sweep.duration_s,
        in_words(&result.diagram.majorities())
    )
}

fn chosen(choice: &Choice) -> String {
    let chosen = format!(
        "chosen: {}, which mills in {:.1} % of {} fresh runs (95 % interval {:.1} to {:.1} %)",
        choice.cell,
        100.0 * choice.b_s,
        choice.n_replicates,
        100.0 * choice.b_s_low,
        100.0 * choice.b_s_high
    );
    let measured = choose::as_measured(choice);
    let settling = choice.settling.map(|settling| settling::text(&settling));
    [Some(chosen), measured, settling].into_iter().flatten().collect::<Vec<_>>().join("\n  ")
}
