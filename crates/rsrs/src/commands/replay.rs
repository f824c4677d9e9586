//! `rsrs replay`: a bag back on the network, or into today's controller.

use std::path::PathBuf;

use rsrs_core::robot::controller::ControllerParameters;
use rsrs_ros::logging::{self, Level};
use rsrs_ros::security::Member;

use crate::commands::{Format, report};
use crate::experiment_bar::TerminalOperator;
use crate::failure::{Outcome, bad_arguments};
use crate::fleet_network::chosen_network;
use crate::numbers::number;
use rsrs_operate::publish::{PublishOptions, publish};
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::recorded_run;
use rsrs_pipeline::replay::{replay_into_controller, replay_into_judge, select};
use rsrs_render::replay as render;
use rsrs_ros::runtime::runtime;

/// Publish a bag on the network, or feed it to the controller or the judge.
///
/// On the network, messages go out at the pace of their recording and with the quality of service that
/// was recorded; `/clock` has the recorded time. Topics by which robots are steered (detections,
/// velocity commands, poses of a tracker, `hardware/…`, leases, the e-stop, statuses) are left out
/// unless `--topics` names them, and so is what another program publishes now. To pause and to seek,
/// play the bag with `ros2 bag play` or open it in Foxglove.
///
/// With `--into controller` nothing is published: recorded detections are fed to the controller of
/// this program, and its commands are compared with the recorded ones. With `--into judge` the run is
/// labelled by the judge of this program, and its label compared with the recorded one: `label.json`
/// beside the bag, which a campaign leaves, or the one that `--recorded` names. Exit code 3 means that
/// they differ.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs replay results/run_1 --interface lo --rate 4
  rsrs replay results/run_1 --interface wlan0 --topics /robot_1/odom /robot_2/odom --loop
  rsrs replay results/run_1 --into controller
  rsrs replay results/campaign/001_milling/bag --into judge")]
pub struct Arguments {
    /// Bag: a rosbag2 folder or a single .mcap file.
    bag: PathBuf,
    /// Network interface to publish on, by name or address, more than once for several (or
    /// `RSRS_INTERFACE`, with commas between them).
    #[arg(long, value_name = "NAME|IP")]
    interface: Vec<String>,
    /// How many times faster than it was recorded (default: 1).
    #[arg(long, value_name = "TIMES", default_value_t = 1.0, hide_default_value = true,
          value_parser = number("a positive number", |rate| rate > 0.0))]
    rate: f64,
    /// Topics to publish (default: all that steer no robot).
    #[arg(long, value_name = "TOPIC", num_args = 1..)]
    topics: Vec<String>,
    /// Start again at the end, until SIGINT or SIGTERM.
    #[arg(long = "loop")]
    is_loop: bool,
    /// Leave out what was recorded in the first S seconds (default: 0).
    #[arg(long, value_name = "S", default_value_t = 0.0, hide_default_value = true,
          value_parser = not_negative())]
    start: f64,
    /// Time for subscribers to find the topics before the first message, in s (default: 1).
    #[arg(long, value_name = "S", default_value_t = 1.0, hide_default_value = true,
          value_parser = not_negative())]
    delay: f64,
    /// Feed the bag to a part of this program, instead of publishing it.
    #[arg(long, value_enum, conflicts_with_all =
          ["interface", "rate", "topics", "is_loop", "start", "delay"])]
    into: Option<Target>,
    /// File with the label to compare with, as `rsrs label --format json` prints it (default:
    /// `label.json` beside the bag).
    #[arg(long, value_name = "FILE", requires = "into")]
    recorded: Option<PathBuf>,
    /// Speed of the controller, in m/s (default: from the bag's record).
    #[arg(long, value_name = "M_PER_S", requires_all = ["into", "turn_rate"], value_parser = not_negative())]
    speed: Option<f64>,
    /// Turning rate of the controller, in rad/s (default: from the bag's record).
    #[arg(long, value_name = "RAD_PER_S", requires_all = ["into", "speed"], value_parser = not_negative())]
    turn_rate: Option<f64>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Target {
    /// The controller: detections in, commands out.
    Controller,
    /// The judge: poses and commands in, a label out.
    Judge,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let bag = recorded_run::open(&arguments.bag)?;
    if let Some(Target::Judge) = arguments.into {
        return judge(arguments);
    }
    if let Some(Target::Controller) = arguments.into {
        if arguments.recorded.is_some() {
            anyhow::bail!("`--recorded` is for `--into judge`; the bag itself holds the commands");
        }
        let set = arguments.speed.zip(arguments.turn_rate);
        let mirrored = |(speed, turn_rate)| ControllerParameters::mirrored(speed, turn_rate);
        let parameters = set.map(mirrored);
        let replay = replay_into_controller(&bag, parameters)?;
        report(arguments.format, &replay, render::into_controller(&replay))?;
        return Ok(if replay.is_same() { Outcome::Done } else { Outcome::NegativeAnswer });
    }
    let duration_s = bag.info().duration_s;
    if arguments.start > duration_s {
        return Err(bad_arguments(with_help(
            format!("`--start` is {} s, and the bag ends after {duration_s:.1} s", arguments.start),
            "give a time from the start of the recording",
        )));
    }
    logging::init(Level::Warn);
    let network = chosen_network(&arguments.interface, Member::Runner)?;
    let selection = select(&bag, &arguments.topics)?;
    let options = PublishOptions {
        rate: arguments.rate,
        is_loop: arguments.is_loop,
        start_s: arguments.start,
        delay_s: arguments.delay,
    };
    let published =
        runtime()?.block_on(publish(&bag, &selection, &options, &network, &TerminalOperator))?;
    report(arguments.format, &published, render::published(&published))?;
    Ok(Outcome::Done)
}

fn judge(arguments: &Arguments) -> anyhow::Result<Outcome> {
    if arguments.speed.is_some() {
        anyhow::bail!("`--speed` and `--turn-rate` are for `--into controller`");
    }
    let replay = replay_into_judge(&arguments.bag, arguments.recorded.as_deref())?;
    report(arguments.format, &replay, render::into_judge(&replay))?;
    Ok(if replay.is_same { Outcome::Done } else { Outcome::NegativeAnswer })
}

fn not_negative() -> impl Fn(&str) -> Result<f64, String> + Clone {
    number("a number that is not negative", |number| number >= 0.0)
}
