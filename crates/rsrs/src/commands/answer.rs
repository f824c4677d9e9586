//! `rsrs answer`: the five questions on a robot.

use std::path::PathBuf;

use rsrs_core::diagram::choice::VIABLE_B_S_LOW;
use rsrs_pipeline::answer::{AnswerOptions, REPLICATES, answer};
use rsrs_render::answers::{json, text};
use rsrs_render::picture::of_answers;

use crate::commands::{Format, report, report_written};
use crate::failure::Outcome;
use crate::page_arguments::PageArguments;
use crate::profile_arguments::ProfileArguments;
use crate::setting_arguments::SettingArguments;

/// Answer the paper's five questions about a robot: how many, how fast, how sharply turning, how good the
/// sensors, how alike.
///
/// A setting is recommended as by `choose`: the one from which each quantity may drift farthest, among
/// speeds and turning rates within the robot's limits, or among the settings of a sweep, confirmed on
/// fresh seeds in both worlds. From it one quantity at a time is moved; the answer is the range over
/// which robots mill as often as wanted, with the reason why it ends there. The picture has all curves,
/// with bands of 95 %. Exit code 3 means that the robots do not do what is wanted; `rsrs diagnose`
/// names what to change.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs answer launch_configs/profiles/flockbot.yaml -o flockbot.png
  rsrs answer mine.yaml --sweep sweep.yaml --format json
  rsrs answer results/flockbot")]
pub struct Arguments {
    /// Profile of a robot, sweep file, or folder of a sweep.
    profile: PathBuf,
    /// Sweep file or folder of a sweep whose settings are tried (default: a built-in grid).
    #[arg(long, value_name = "SWEEP")]
    sweep: Option<PathBuf>,
    #[command(flatten)]
    other: ProfileArguments,
    /// Picture of all curves to write: svg, png or pdf.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    page: PageArguments,
    /// Least lower bound of the share of runs that end as wanted (default: 0.8).
    #[arg(long, value_name = "SHARE", default_value_t = VIABLE_B_S_LOW, hide_default_value = true,
          value_parser = crate::numbers::share())]
    b_s: f64,
    /// Runs of each point of a curve, in each world (default: 250).
    #[arg(long, value_name = "N", default_value_t = REPLICATES, hide_default_value = true,
          value_parser = clap::value_parser!(u64).range(1..))]
    replicates: u64,
    #[command(flatten)]
    setting: SettingArguments,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let picture = arguments.page.file_if(arguments.output.as_deref())?;
    let options = AnswerOptions {
        sweep: arguments.sweep.as_deref(),
        other_profile: arguments.other.profile(),
        replicates: arguments.replicates,
        best: arguments.setting.options(arguments.b_s)?,
    };
    let answers = answer(&arguments.profile, options)?;
    report(arguments.format, &json(&answers), text(&answers))?;
    if let Some(picture) = picture {
        picture.write(&of_answers(&answers, picture.style())?)?;
        report_written(arguments.format, picture.path())?;
    }
    Ok(if answers.best.viable { Outcome::Done } else { Outcome::NegativeAnswer })
}
