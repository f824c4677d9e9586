//! `rsrs dry-run`: the whole loop on this machine, without robots.

use std::path::PathBuf;

use rsrs_ros::logging::{self, Level};

use crate::commands::{Format, print_text, report};
use crate::experiment_bar::{TerminalOperator, above_bars};
use crate::failure::Outcome;
use crate::notes::print_note;
use crate::starter_files::StarterFiles;
use crate::threads_argument::ThreadsArgument;
use rsrs_operate::dry_run::{DryRun, LaunchConfigs};
use rsrs_operate::run::own_network::OwnNetwork;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::ANOTHER_FOLDER;
use rsrs_render::dry_run::{DryRunResult, Step, no_viable_cell, text};

/// Go through the whole loop on this machine: no robots, no LAN.
///
/// Robots made worse than measured are simulated into a phase diagram, a cell is chosen and run over
/// ROS 2, and the bags are labelled and compared. In these runs, simulated robots as measured stand in
/// for real ones. Runs are made, `--threads` at a time, until they decide whether those mill as often
/// as the worse ones, or at most 25 percentage points less often; looking at the verdict after every
/// run does not weaken it. Everything is left in one folder, and `report.html` shows it. Exit code 3
/// means that no cell is viable.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs dry-run
  rsrs dry-run mine -o results/mine
  rsrs dry-run --experiments 3 --format json")]
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
    let (configs, files) = if let Some(folder) = &arguments.folder {
        (folder.clone(), StarterFiles::in_folder(folder)?)
    } else {
        let folder = folder.join("launch_configs");
        let files = StarterFiles::write(&folder)?;
        (folder, files)
    };
    let format = arguments.format;
    let result = DryRun {
        folder: &folder,
        launch_configs: LaunchConfigs {
            folder: &configs,
            sweep: &files.sweep,
            experiment: &files.experiment,
            are_starter_files: arguments.folder.is_none(),
        },
        n_experiments: arguments.experiments,
        seed: arguments.seed,
        execution: arguments.threads.execution()?,
        network: &network,
        operator: &TerminalOperator,
        show: &|step| print(format, step),
    }
    .run()?;
    if let DryRunResult::NothingToRun(nothing) = &result {
        report(format, &result, no_viable_cell(&nothing.choice, &nothing.sweep))?;
        return Ok(Outcome::NegativeAnswer);
    }
    // In text every step was printed when it was made.
    if format == Format::Json {
        report(format, &result, "")?;
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

/// Prints in text how far it is; JSON comes whole at the end.
fn print(format: Format, step: &Step<'_>) -> anyhow::Result<()> {
    match (step, format) {
        (Step::NetworkEntered(_), _) => print_note(text(step)),
        (_, Format::Json) => {}
        (_, Format::Text) => return above_bars(|| print_text(text(step))),
    }
    Ok(())
}
