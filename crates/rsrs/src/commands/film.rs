//! `rsrs film`: a recorded run as a film.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_pipeline::files::write_file;
use rsrs_pipeline::sweep::source::behaviour;
use rsrs_render::recorded_run::{FilmOptions, film, kind};
use rsrs_sim::sweep::Progress;

use crate::commands::{Format, report_written};
use crate::failure::{Outcome, bad_arguments};
use crate::interrupt;
use crate::progress::Counter;

/// Film a recorded run: robots from above with their paths, as an animated GIF or PNG.
///
/// Below them is the time, and the phase of the last minute; before a minute is over, the phase so far. It needs no display, and the same run gives the same bytes.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs film runs/monday -o monday.gif
  rsrs film runs/monday -o monday.png --rate 20 --width 960")]
pub struct Arguments {
    /// Bag of a run: rosbag2 folder or single `.mcap` file.
    bag: PathBuf,
    /// Film to write; its extension selects the format: gif, or png for an animated PNG.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Seconds of the run in a second of the film (default: 10).
    #[arg(long, alias = "speed", value_name = "TIMES", default_value_t = 10.0, hide_default_value = true,
          value_parser = crate::numbers::number("a positive number", |rate| rate > 0.0))]
    rate: f64,
    /// Frames in a second, from 1 to 50 (default: 15).
    #[arg(long, value_name = "N", default_value_t = 15, hide_default_value = true,
          value_parser = clap::value_parser!(u32).range(1..=50))]
    fps: u32,
    /// Width in pixels, from 64 to 2048 (default: 480).
    #[arg(long, value_name = "PX", default_value_t = 480, hide_default_value = true,
          value_parser = clap::value_parser!(u32).range(64..=2048))]
    width: u32,
    /// What to judge it for: milling, aggregation, dispersal, or the path of a file (default: what the
    /// bag's record has, else milling).
    #[arg(long, value_parser = behaviour)]
    behaviour: Option<Behaviour>,
    /// Where poses come from (default: what the run went by).
    #[arg(long, value_parser = crate::pose_arguments::pose_sources())]
    poses: Option<PoseSource>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let kind = kind(&arguments.output).map_err(bad_arguments)?;
    let options = FilmOptions {
        speed: arguments.rate,
        frames_per_s: arguments.fps,
        width_px: arguments.width,
        poses: arguments.poses,
        behaviour: arguments.behaviour,
    };
    let cancel = interrupt::listen()?;
    let counter = Counter::new("filming", "frames");
    let filmed = film(&arguments.bag, kind, options, &|done, total| {
        counter.show(Progress { done, total });
        !cancel.load(Ordering::Relaxed)
    });
    drop(counter);
    let bytes = filmed?;
    write_file(&arguments.output, &bytes)?;
    report_written(Format::Text, &arguments.output)?;
    Ok(Outcome::Done)
}
