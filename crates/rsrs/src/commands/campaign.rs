//! `rsrs campaign`: many experiments, one after the other, each in a folder with all of its files.

mod prompt;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_experiment_runner::{backends, place_checks};
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::Backend;

use crate::commands::{Format, report};
use crate::experiment_bar::TerminalOperator;
use crate::failure::Outcome;
use crate::fleet_network::{InterfaceArguments, enter, refuse_flags_of_a_fleet};
use crate::notes::print_note;
use crate::profile_arguments::ProfileArguments;
use prompt::Prompt;
use rsrs_files::quoted;
use rsrs_operate::campaign::{self, Campaign, CampaignRunner};
use rsrs_pipeline::campaign::{CampaignFolder, Summary};
use rsrs_pipeline::error::with_help;
use rsrs_render::campaign as render;
use rsrs_ros::runtime::runtime;

/// Run many experiments one after the other, and continue where it was interrupted.
///
/// The campaign file names experiment files, cells, seeds and repetitions. Each experiment gets a
/// folder with its bag, the files behind it, the judge's label, and a manifest with a checksum of
/// every file. The same command continues a campaign that was interrupted or killed: finished
/// experiments are verified and never run again. Runs that were void, aborted or could not be judged
/// are run again; their recordings are kept beside as `bag.unfinished_1`, and each stays in
/// `attempts.json` with its cause.
///
/// With the simulator, the world is placed anew before each run. With the fleet, you are asked to
/// place the robots before each run, or a program does it (`--place-command`). Exit code 3 means
/// that experiments are missing, void or not judged, or lost a robot or data.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs campaign launch_configs/campaigns/flockbot_milling.yaml -o results/campaign
  rsrs campaign floor.yaml -o results/floor --backend fleet --interface wlan0
  rsrs campaign floor.yaml -o results/floor --backend fleet --interface wlan0 \\
      --place-command './drive_to_places.py --map lab.yaml'
  rsrs compare results/flockbot --bags results/floor/*/bag")]
pub struct Arguments {
    /// Campaign file (YAML).
    campaign: PathBuf,
    /// Folder of the campaign; an existing one is continued.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// What moves the robots (default: sim).
    #[arg(long, value_parser = backends("The simulator, in a network of its own"), default_value = "sim", hide_default_value = true)]
    backend: Backend,
    #[command(flatten)]
    network: InterfaceArguments,
    /// Start every run of a fleet without asking, where robots need not be placed.
    #[arg(long)]
    yes: bool,
    /// Program that places the robots of a fleet before each run, instead of asking you: it gets one
    /// line of JSON on its standard input; another exit code than 0 stops the campaign
    /// (docs/campaigns.md).
    #[arg(long, value_name = "PROGRAM", conflicts_with = "yes")]
    place_command: Option<String>,
    /// What to do, before robots of a fleet move, about those that do not stand where they should
    /// (default: on).
    #[arg(long, value_parser = place_checks())]
    place_check: Option<PlaceCheck>,
    /// How often to try an experiment again at once if its run gave no result, for a cause that was known
    /// before: void, failed before the robots moved, not judged, or a robot lost before the time that is
    /// judged, mostly the last minute; never for its result (default: 2 in the simulator, 0 with a fleet).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=100))]
    retry: Option<u32>,
    #[command(flatten)]
    other: ProfileArguments,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let backend = arguments.backend;
    refuse_flags_of_a_fleet(
        backend,
        &arguments.network,
        arguments.place_command.as_deref(),
        arguments.place_check,
    )?;
    let Campaign { text, mut items } =
        campaign::read(&arguments.campaign, backend, arguments.other.profile())?;
    for differ in items.iter().filter_map(|item| item.other_profile.as_ref()).take(1) {
        print_note(format!("note: {differ}"));
    }
    for item in &mut items {
        item.place_check = arguments.place_check.unwrap_or_default();
    }
    let is_asked = !arguments.yes && arguments.place_command.is_none();
    let asks = arguments.backend == Backend::Fleet && is_asked;
    if asks && !std::io::stdin().is_terminal() {
        return Err(with_help(
            "stdin is not a terminal, in which somebody would confirm that the robots are placed",
            "run it in a terminal, name a program that places them with `--place-command`, or use \
             `--yes` where nobody has to place them",
        ));
    }
    let target = enter(arguments.backend, &arguments.network.interface)?;
    let folder = CampaignFolder::open(&arguments.output, &text, &items)?;
    // Threads begin here, behind the network.
    let ended = runtime()?.block_on(async {
        let prompt = match &arguments.place_command {
            Some(program) => Prompt::Program(program.clone()),
            None if asks => Prompt::at_keyboard(),
            None => Prompt::Silent,
        };
        let campaign_runner = CampaignRunner::new(&folder, target, prompt, &TerminalOperator);
        campaign_runner.with_tries(arguments.retry.map(|retry| retry + 1)).run_all(&items).await
    });
    if let Err(error) = ended {
        return Err(interrupted(&error, arguments));
    }
    let summary = Summary::new(&folder, &items, &command(arguments))?;
    report(arguments.format, &summary, render::text(&summary))?;
    Ok(if summary.is_whole() { Outcome::Done } else { Outcome::NegativeAnswer })
}

/// The command that goes on.
fn command(arguments: &Arguments) -> String {
    let path = |path: &Path| quoted(path);
    let mut words = vec!["rsrs campaign".to_owned(), path(&arguments.campaign)];
    words.extend(["-o".to_owned(), path(&arguments.output)]);
    if arguments.backend == Backend::Fleet {
        words.push("--backend fleet".to_owned());
    }
    words.extend(arguments.network.interface.iter().map(|name| format!("--interface {name}")));
    if arguments.other.profile() == OtherProfile::Insisted {
        words.push("--other-profile".to_owned());
    }
    if arguments.yes {
        words.push("--yes".to_owned());
    }
    if let Some(program) = &arguments.place_command {
        words.push(format!("--place-command {}", quoted(program)));
    }
    words.extend(arguments.place_check.map(|check| format!("--place-check {}", check.key())));
    words.extend(arguments.retry.map(|retry| format!("--retry {retry}")));
    words.join(" ")
}

fn interrupted(error: &anyhow::Error, arguments: &Arguments) -> anyhow::Error {
    let own = rsrs_pipeline::error::help_of(error);
    let goes_on = format!("`{}` goes on where it was", command(arguments));
    with_help(
        rsrs_pipeline::error::in_one_line(error),
        own.map_or_else(|| goes_on.clone(), |own| format!("{own}; {goes_on}")),
    )
}
