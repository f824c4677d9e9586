//! `rsrs diagnose`: why robots do not mill, and what would have to be changed.

use std::path::PathBuf;

use rsrs_core::diagram::choice::VIABLE_B_S_LOW;
use rsrs_core::quantity::Axis;
use rsrs_pipeline::diagnose::{DiagnoseOptions, diagnose};

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::setting_arguments::SettingArguments;
use rsrs_render::diagnosis::{json, text};

/// Find out why robots do not mill, and what would have to be changed about them.
///
/// The best setting is sought as by `choose` and `answer`, among speeds and turning rates within the
/// robot's limits, or among the settings of a sweep. If the robots fail there, too, capabilities are
/// moved, each by itself and together, towards a perfect robot; the smallest change that reaches the
/// wanted share of mills is confirmed on fresh seeds, in both worlds. What is needed is a measured
/// value: a robot that has it is made worse, too. For robots that mill, the output lists what could be
/// worse. Exit code 3 means that they do not mill, or not surely.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs diagnose launch_configs/profiles/smars.yaml
  rsrs diagnose mine.yaml --sweep sweep.yaml --cost range_m=200 --cost sensor_bearing_rad=5
  rsrs diagnose results/flockbot --format json")]
pub struct Arguments {
    /// Profile of a robot, sweep file, or folder of a sweep.
    profile: PathBuf,
    /// Sweep file or folder of a sweep whose settings are tried (default: a built-in grid).
    #[arg(long, value_name = "SWEEP")]
    sweep: Option<PathBuf>,
    /// Least confirmed lower bound of the share of runs that end as wanted (default: 0.8).
    #[arg(long, value_name = "SHARE", default_value_t = VIABLE_B_S_LOW, hide_default_value = true,
          value_parser = crate::numbers::share())]
    b_s: f64,
    /// What changing a capability costs, in any currency; changes are listed by it, cheapest first.
    #[arg(long, value_name = "CAPABILITY=NUMBER", value_parser = cost)]
    cost: Vec<(Axis, f64)>,
    #[command(flatten)]
    setting: SettingArguments,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// What a change costs, from the command line.
fn cost(text: &str) -> Result<(Axis, f64), String> {
    let (axis, cost) = text.split_once('=').ok_or("expected CAPABILITY=NUMBER")?;
    let axis: Axis = axis.trim().parse().map_err(|error| format!("{error}"))?;
    let cost: f64 = cost.trim().parse().map_err(|error| format!("{error}"))?;
    if cost >= 0.0 && cost.is_finite() {
        Ok((axis, cost))
    } else {
        Err("expected a cost from 0".into())
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let options = DiagnoseOptions {
        sweep: arguments.sweep.as_deref(),
        costs: &arguments.cost,
        best: arguments.setting.options(arguments.b_s)?,
    };
    let diagnosis = diagnose(&arguments.profile, options)?;
    report(arguments.format, &json(&diagnosis), text(&diagnosis))?;
    Ok(if diagnosis.best.viable { Outcome::Done } else { Outcome::NegativeAnswer })
}
