//! `rsrs watch`: a fleet that runs, or a recorded one, in the terminal.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use rsrs_ros::environment::Environment;
use rsrs_ros::logging::{self, Level};
use rsrs_ros::security::Member;

use crate::failure::Outcome;
use crate::fleet_network::{InterfaceArguments, chosen_network, other_middleware};
use crate::interrupt;
use crate::notes::print_note;
use crate::watch::{Fleet, Look, check, play, view};
use rsrs_operate::watch::recording;
use rsrs_pipeline::error::{in_one_line, with_help};
use rsrs_pipeline::measure::plan_folder::enabled_robots;

/// Watch a fleet that runs, or a recorded run, in the terminal.
///
/// Shows every robot with its state and why it stands, what it sees, how often its detections,
/// commands and poses come, its last command and its lease; all robots from above; and the order
/// parameters of the last minute with the phase in words. `s` stops all robots, at once and without a
/// question, as `rsrs stop` does; `?` lists the other keys, `q` quits and leaves robots as they are.
/// Without a fleet file robots are found by what they publish. Colours obey `--color` and `NO_COLOR`.
///
/// A run that has a network of its own is watched from inside, with the command that it prints:
/// `nsenter … env ROS_DOMAIN_ID=0 rsrs watch --interface lo`. A secured fleet is watched with the
/// enclave `/viewer`, and stopped with `/stop`: docs/security.md.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs watch --interface wlan0
  rsrs watch launch_configs/fleets/nine_virtual.yaml --interface wlan0
  rsrs watch milling")]
pub struct Arguments {
    /// Fleet file (YAML), whose enabled robots are shown, seen or not; or a bag, which is played.
    #[arg(value_name = "FLEET|BAG")]
    what: Option<PathBuf>,
    #[command(flatten)]
    network: InterfaceArguments,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    if let Some(bag) = arguments.bag()
        && !arguments.network.interface.is_empty()
    {
        return Err(with_help(
            format!("{}: a bag is on no interface", bag.display()),
            "leave `--interface` out, or name a fleet file",
        ));
    }
    let environment = Environment::of_this_process();
    check(&environment)?;
    // What is logged to the terminal would lie over the picture.
    if !std::io::stderr().is_terminal() {
        logging::init(Level::Warn);
    }
    let look = Look::new(anstream::ColorChoice::global(), &environment);
    match arguments.bag() {
        Some(bag) => play_bag(bag, look),
        None => view_fleet(arguments.what.as_deref(), &arguments.network.interface, look),
    }
}

impl Arguments {
    /// What is named, if it is a bag.
    fn bag(&self) -> Option<&Path> {
        self.what.as_deref().filter(|path| is_bag(path))
    }
}

/// Bags are folders, or files with the extension of one.
fn is_bag(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.is_dir() || name.ends_with(".mcap") || name.ends_with(".mcap.zstd")
}

fn play_bag(bag: &Path, look: Look) -> anyhow::Result<Outcome> {
    let recorded = recording::read(bag)?;
    let interrupted = interrupt::listen()?;
    let name = bag.display().to_string();
    let note = (!recorded.notes.is_empty()).then(|| recorded.notes.join("; "));
    play(recorded.playback, (&name, note), look, interrupted)?;
    Ok(Outcome::Done)
}

fn view_fleet(file: Option<&Path>, interfaces: &[String], look: Look) -> anyhow::Result<Outcome> {
    let robots = file.map_or_else(|| Ok(Vec::new()), enabled_robots)?;
    let network = chosen_network(interfaces, Member::Viewer)?;
    let stop = match &network.enclave {
        None => Ok(network.clone()),
        Some(_) => chosen_network(interfaces, Member::Stop).map_err(|error| in_one_line(&error)),
    };
    let addresses = network.interfaces.iter().map(ToString::to_string).collect::<Vec<_>>();
    let named = if interfaces.is_empty() { addresses.join(", ") } else { interfaces.join(", ") };
    let domain = format!("{named}, domain {}", network.domain_id);
    let place = file.map_or(domain.clone(), |file| format!("{} on {domain}", file.display()));
    let interrupted = interrupt::listen()?;
    let other_middleware = other_middleware();
    let fleet = Fleet { network, stop, robots, place, other_middleware };
    let outcome = view(&fleet, look, interrupted)?;
    let Some(stop) = outcome else { return Ok(Outcome::Done) };
    print_note(&stop.text);
    Ok(if stop.is_acknowledged { Outcome::Done } else { Outcome::NegativeAnswer })
}
