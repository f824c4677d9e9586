//! `rsrs explore`: what a swarm of these robots can do.

use std::path::PathBuf;

use rsrs_core::conditions::Walls;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::explore::{CONTROLLERS, DURATION_S, ExploreOptions, Files, REPLICATES, explore};
use rsrs_pipeline::sweep::source::behaviour;
use rsrs_sim::exploration::space::Directions;

use crate::commands::{Format, report};
use crate::failure::{Outcome, bad_arguments};
use crate::threads_argument::ThreadsArgument;
use rsrs_render::explored::{draw, text};

/// Explore what a swarm of these robots can do, beyond the given controller.
///
/// A binary controller has one command where something is detected and another where nothing is: four
/// numbers. With `--behaviour` they are searched for that behaviour by an evolution strategy, else for
/// all that differ. What is found is confirmed on fresh seeds, drawn in `gallery.html`, and ready to be
/// swept. A search that was interrupted goes on with the same command. Exit code 3 means that the
/// behaviour was not found.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs explore flockbot.yaml -o results/gallery
  rsrs explore flockbot.yaml -o results/milling --behaviour milling
  rsrs explore flockbot.yaml -o results/aggregation --behaviour aggregation --robots 20
  rsrs sweep results/gallery/sweeps/01_milling.yaml -o results_01_milling")]
pub struct Arguments {
    /// Profile of the measured robot; it is made worse by the usual factors.
    profile: PathBuf,
    /// Folder for what is found.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Behaviour to search for: milling, aggregation, dispersal, or the path of a file (default: all that
    /// differ).
    #[arg(long, value_parser = behaviour)]
    behaviour: Option<Behaviour>,
    /// A controller's table, whose numbers are searched within their bounds in place of two commands.
    #[arg(long, value_name = "FILE", conflicts_with = "forward")]
    controller: Option<PathBuf>,
    /// What is in the arena besides robots: a world's file; `--arena` applies unless it has an arena of
    /// its own.
    #[arg(long = "world-file", value_name = "FILE")]
    world: Option<PathBuf>,
    /// Where robots start: a table of poses, of which replicate k takes set k (default: in a disc, facing away
    /// from its centre).
    #[arg(long, value_name = "CSV")]
    starts: Option<PathBuf>,
    /// Number of robots (default: as in `fleet.yaml` beside the profile, or 9).
    #[arg(long, value_name = "N")]
    robots: Option<usize>,
    /// Side of the square arena, in metres (default: 22.4 radii of a robot's body times the root of their number, to 0.1 m).
    #[arg(long, value_name = "M")]
    arena: Option<f64>,
    /// What happens at the arena's border: robots seldom slide along real walls, as with `clamp`.
    #[arg(long, value_enum, default_value = "stop")]
    walls: WallKind,
    /// Search only controllers that never drive backward.
    #[arg(long)]
    forward: bool,
    /// Controllers that are tried (default: 2,000).
    #[arg(long, value_name = "N", default_value_t = CONTROLLERS, hide_default_value = true,
          value_parser = controllers)]
    controllers: usize,
    /// Runs of each of them (default: 16).
    #[arg(long, value_name = "N", default_value_t = REPLICATES, hide_default_value = true,
          value_parser = clap::value_parser!(u64).range(1..=100_000))]
    replicates: u64,
    /// Simulated time of each run, in seconds (default: 300).
    #[arg(long, value_name = "S", default_value_t = DURATION_S, hide_default_value = true)]
    duration: f64,
    /// Seed of the search and of its runs.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..1 << 63))]
    seed: u64,
    #[command(flatten)]
    threads: ThreadsArgument,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum WallKind {
    /// There is no border.
    None,
    /// A robot slides along it.
    Clamp,
    /// A robot that would cross it stays where it is.
    Stop,
}

fn controllers(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=1_000_000).contains(&n) => Ok(n),
        _ => Err("expected a whole number from 1 to 1,000,000".to_owned()),
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let files = Files {
        controller: arguments.controller.as_deref(),
        world: arguments.world.as_deref(),
        starts: arguments.starts.as_deref(),
    };
    let read = files.read(&arguments.profile, arguments.robots, arguments.arena)?;
    if read.needs_arena() && arguments.arena.is_none() {
        return Err(bad_arguments(with_help(
            "the world has no arena of its own, and there is no `--arena`",
            "give the side of a square in metres, as in `--arena 3`, or the world an `arena`",
        )));
    }
    let least_s = arguments.behaviour.unwrap_or(Behaviour::MILLING).window().least_s();
    if arguments.duration < least_s {
        return Err(bad_arguments(with_help(
            format!("--duration is {} s, too short to be judged", arguments.duration),
            format!("give at least {least_s:.0} s"),
        )));
    }
    let options = ExploreOptions {
        wanted: arguments.behaviour,
        controller: read.controller.as_ref(),
        world: read.world.as_ref(),
        starts: read.starts.as_ref(),
        robots: read.robots,
        arena_m: arguments.arena,
        walls: match arguments.walls {
            WallKind::None => Walls::None,
            WallKind::Clamp => Walls::Clamp,
            WallKind::Stop => Walls::Stop,
        },
        directions: if arguments.forward { Directions::Forward } else { Directions::Both },
        controllers: arguments.controllers,
        replicates: arguments.replicates,
        duration_s: arguments.duration,
        seed: arguments.seed,
        execution: arguments.threads.execution()?,
    };
    let explored = explore(&arguments.profile, &arguments.output, &options)?;
    draw(&explored)?;
    report(arguments.format, &explored, text(&explored))?;
    Ok(if explored.is_found() { Outcome::Done } else { Outcome::NegativeAnswer })
}
