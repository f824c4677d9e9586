//! `rsrs plan-experiments`: how many real runs, before the first of them.

use std::path::PathBuf;

use anyhow::Context;
use rsrs_core::comparison::MARGIN;
use rsrs_core::quantity::Cell;
use rsrs_pipeline::files::experiment_file_beside;
use rsrs_pipeline::files::write_once;
use rsrs_pipeline::plan_experiments::fixed::plan_campaign;
use rsrs_pipeline::plan_experiments::{PlanOptions, REPLICATES, WANTED, plan_experiments};
use rsrs_render::planned_experiments::{
    TO_WRITE, after_written, campaign_text, json, next, not_written, text,
};
use rsrs_render::words::Words;

use crate::bag_arguments::margin;
use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::threads_argument::ThreadsArgument;

/// Plan real runs: how many decide whether robots mill as often as simulated.
///
/// Real robots are assumed to mill as often as simulated ones as measured, which are run again many
/// times. The real runs are shared out evenly among the cells, and `rsrs compare` is run after each;
/// the number is the least after which it has decided, either way, with the wanted probability. Exit
/// code 3 means that 1,024 runs are too few. Where simulated robots hardly mill, nothing is claimed,
/// and no run is planned.
///
/// With `--fixed` nobody looks before the last run, so that fewer suffice: their number is written
/// into a campaign file (`-o`) before the first, and `rsrs compare` gives its verdict at that
/// number, once.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs plan-experiments results/flockbot
  rsrs plan-experiments results/flockbot --margin 0.2 --decided 0.9
  rsrs plan-experiments results/flockbot --margin 0.2 --fixed -o floor.yaml
  rsrs plan-experiments results/flockbot --cell speed_m_s=0.15,turn_rate_rad_s=0.75 \\
      --cell speed_m_s=0.2,turn_rate_rad_s=0.75")]
pub struct Arguments {
    /// Folder of a sweep; with `choice.json` in it, runs of the chosen cell are planned.
    folder: PathBuf,
    /// Cell in which runs are planned, as AXIS=VALUE,…; may be given several times.
    #[arg(long)]
    cell: Vec<Cell>,
    /// By how much real robots may mill less often than simulated ones and still support the claim, as
    /// in the comparison (default: 0.1).
    #[arg(long, value_name = "SHARE", default_value_t = MARGIN, hide_default_value = true,
          value_parser = margin())]
    margin: f64,
    /// Probability with which the runs are to decide (default: 0.8).
    #[arg(long, value_name = "SHARE", default_value_t = WANTED, hide_default_value = true,
          value_parser = crate::numbers::share())]
    decided: f64,
    /// Simulated runs of robots as measured, in each cell (default: 20,000).
    #[arg(long, value_name = "N", default_value_t = REPLICATES, hide_default_value = true,
          value_parser = clap::value_parser!(u64).range(1..))]
    replicates: u64,
    /// Fix the number of runs before the first: `rsrs compare` decides at that number, and not before.
    #[arg(long)]
    fixed: bool,
    /// Campaign file to write, with the number of runs and the margin that are fixed; another plan in a file
    /// that exists is not overwritten.
    #[arg(short, long, value_name = "FILE", requires = "fixed")]
    output: Option<PathBuf>,
    #[command(flatten)]
    threads: ThreadsArgument,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let options = PlanOptions {
        cells: arguments.cell.clone(),
        margin: arguments.margin,
        wanted: arguments.decided,
        replicates: arguments.replicates,
        execution: arguments.threads.execution()?,
    };
    if arguments.fixed {
        return fixed(arguments, &options);
    }
    let planned = plan_experiments(&arguments.folder, &options)?;
    let next = next(&planned, &arguments.folder);
    let words = next.into_iter().fold(text(&planned), Words::below);
    report(arguments.format, &json(&planned, planned.note.as_ref()), words)?;
    Ok(if planned.runs.is_some() { Outcome::Done } else { Outcome::NegativeAnswer })
}

/// Plans a campaign of a number of runs that is fixed, and writes its file.
fn fixed(arguments: &Arguments, options: &PlanOptions) -> anyhow::Result<Outcome> {
    let folder = &arguments.folder;
    let experiment = arguments.output.as_ref().map(|output| {
        let there = experiment_file_beside(folder).with_context(|| {
            format!(
                "no experiment.yaml here or beside {}, which the campaign would run",
                folder.display()
            )
        })?;
        Ok::<_, anyhow::Error>((output, there))
    });
    let experiment = experiment.transpose()?;
    let planned = plan_campaign(folder, options)?;
    let outcome = if planned.is_enough() { Outcome::Done } else { Outcome::NegativeAnswer };
    let mut words = campaign_text(&planned);
    if planned.claims_nothing() {
        let unwritten = experiment.map(|(output, _)| not_written(output));
        words = unwritten.into_iter().fold(words, Words::below);
    } else if let Some((output, experiment)) = experiment {
        let file = planned.file(output, &experiment, folder)?;
        let another = "give another file with `-o`: a plan that is fixed is not overwritten";
        write_once(output, file.as_bytes(), another)?;
        words = words.below(after_written(output));
    } else {
        words = words.below(TO_WRITE);
    }
    report(arguments.format, &json(&planned, planned.note.as_ref()), words)?;
    Ok(outcome)
}
