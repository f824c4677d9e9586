//! `rsrs sweep`: step 3, exploration.

use std::path::{Path, PathBuf};

use rsrs_core::capability::lost_capabilities;
use rsrs_core::conditions::ClassChanges;
use rsrs_core::diagram::adaptive::Adaptive;
use rsrs_core::world::WorldFile;

use crate::commands::{Format, print_text, report};
use crate::failure::{Outcome, check_flag};
use crate::notes::print_always;
use crate::threads_argument::ThreadsArgument;
use rsrs_pipeline::error::helped;
use rsrs_pipeline::execution::Execution;
use rsrs_pipeline::sweep::shard::Shard;
use rsrs_pipeline::sweep::source::ResolvedSweep;
use rsrs_pipeline::sweep::{sweep_into, sweep_shard};
use rsrs_render::sweep::{ShardReport, SweepReport, of_shard, text};
use rsrs_render::{axes, picture};

/// Simulate every cell of a sweep into a phase diagram.
///
/// Every replicate follows from the seed, the cell and its own number: the folder is the same byte
/// for byte for any number of threads, however often the sweep was interrupted, and a cell keeps its
/// results when the grid around it changes. After Ctrl-C, a crash or a full disk, the same command
/// goes on where it was.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs sweep launch_configs/sweeps/flockbot_speed_turn.yaml -o results/flockbot
  rsrs sweep launch_configs/sweeps/flockbot_speed_turn.yaml -o results/precise --adaptive
  rsrs sweep results/flockbot/sweep.yaml -o results/flockbot     finish what was interrupted
  rsrs sweep sweep.yaml -o part_1 --shard 1/2                    one of two machines' part")]
pub struct Arguments {
    /// Sweep file (YAML), or the `sweep.yaml` of a result folder.
    #[arg(required_unless_present = "list_axes")]
    sweep: Option<PathBuf>,
    /// Folder to make; it must not exist, unless it holds this very sweep.
    #[arg(short, long, value_name = "DIR", required_unless_present = "list_axes")]
    output: Option<PathBuf>,
    /// List what can be an axis, with its unit, and simulate nothing.
    #[arg(long, exclusive = true)]
    list_axes: bool,
    /// Go on simulating where the phase is uncertain, until every cell is certain.
    ///
    /// The sweep file's `replicates` are what each cell begins with. A cell has enough when its
    /// interval is narrow or its phase is settled; next to a cell on the other side of one half, it
    /// must be narrow. The intervals hold although the runs decided their number.
    #[arg(long)]
    adaptive: bool,
    /// Width of an interval of `B_s` that is narrow enough, as a share (default: 0.2).
    #[arg(long, value_name = "SHARE", requires = "adaptive")]
    width: Option<f64>,
    /// Replicates that a cell gets at most (default: 1000).
    #[arg(long, value_name = "N", requires = "adaptive")]
    most_replicates: Option<u64>,
    /// Simulate only every N-th part, the I-th, and leave it for `rsrs merge`.
    ///
    /// So a sweep is spread over machines: each makes a folder of its own.
    #[arg(long, value_name = "I/N", conflicts_with = "adaptive")]
    shard: Option<Shard>,
    #[command(flatten)]
    threads: ThreadsArgument,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let (Some(file), Some(folder)) = (&arguments.sweep, &arguments.output) else {
        print_text(axes::table())?;
        return Ok(Outcome::Done);
    };
    let name = file.display().to_string();
    let mut source = ResolvedSweep::read_either(file)?;
    if arguments.adaptive {
        source.sweep.adaptive = Some(arguments.adapt(source.sweep.adaptive.unwrap_or_default()));
        check_flag("--adaptive", source.sweep.check(&name).map_err(helped))?;
    }
    warn_of_lost_capabilities(&source);
    let execution = arguments.threads.execution()?;
    if let Some(shard) = arguments.shard {
        return run_shard((folder, shard), &name, &source, arguments.format, execution);
    }
    let result = sweep_into(folder, &name, source, execution, picture::into_folder)?;
    let summary = SweepReport::new(folder, &result, execution)?;
    if let Some(warning) = summary.warning() {
        print_always(format!("warning: {warning}"));
    }
    report(arguments.format, &summary, text(&summary))?;
    Ok(Outcome::Done)
}

/// Warns of the capabilities that the factors take away, before anything is simulated.
fn warn_of_lost_capabilities(source: &ResolvedSweep) {
    let measured = &source.profile;
    let factors = source.sweep.factors(measured);
    // Factors that are refused are an error of the sweep, with their place in the file.
    let simulated = factors.apply(measured);
    for lost in simulated.iter().flat_map(|simulated| lost_capabilities(measured, simulated)) {
        print_always(format!("warning: {lost}"));
    }
    let changes = ClassChanges::as_of(measured, factors);
    for (class, measured) in source.sweep.world().into_iter().flat_map(WorldFile::profiles) {
        let simulated = changes.simulated(measured);
        for lost in simulated.iter().flat_map(|simulated| lost_capabilities(measured, simulated)) {
            print_always(format!("warning: class {class}: {lost}"));
        }
    }
}

fn run_shard(
    (folder, shard): (&Path, Shard),
    name: &str,
    source: &ResolvedSweep,
    format: Format,
    execution: Execution<'_>,
) -> anyhow::Result<Outcome> {
    let runs = sweep_shard(folder, name, source, shard, execution)?;
    let summary = ShardReport { folder: folder.into(), shard: shard.to_string(), runs };
    report(format, &summary, of_shard(&summary))?;
    Ok(Outcome::Done)
}

impl Arguments {
    /// Options of an adaptive sweep, which override the file.
    fn adapt(&self, file: Adaptive) -> Adaptive {
        Adaptive {
            width: self.width.unwrap_or(file.width),
            most_replicates: self.most_replicates.unwrap_or(file.most_replicates),
        }
    }
}
