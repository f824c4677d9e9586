//! `rsrs place`: start poses for the floor, and where robots are seen.

mod check;

use std::path::{Path, PathBuf};

use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_experiment_runner::plan::{Plan, Request};
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::Backend;

use rsrs_ros::logging::{self, Level};
use rsrs_ros::security::Member;

use self::check::Until;
use crate::commands::{Format, report, report_written};
use crate::experiment_arguments::ExperimentArguments;
use crate::failure::Outcome;
use crate::fleet_network::chosen_network;
use crate::page_arguments::PageArguments;
use rsrs_operate::run::start_poses::start_poses;
use rsrs_render::picture_file::PictureFile;
use rsrs_render::start_poses::{self, StartPoses};

/// Print start poses for the floor, as a table and a picture.
///
/// The simulator starts this experiment from them with measured robots. The robots' centres lie in a
/// disc or a box around the origin, far enough apart, and every robot faces away from the centre;
/// `--seed` gives others that are as good. With `placement: {kind: file, path: …}` they come from the
/// table, checked against the robots and the arena. Places of the world's objects are shown, too.
///
/// `--check` shows instead where the robots of the fleet are seen now, as a run would read their poses,
/// and what is not as it should be at the start; it sends nothing to any robot. Exit code 3 means that
/// they do not stand as wanted.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs place launch_configs/experiments/flockbot_milling.yaml
  rsrs place launch_configs/experiments/flockbot_milling.yaml -o start.png
  rsrs place milling.yaml --from results/flockbot --seed 7 --format json
  rsrs place milling.yaml --check --interface wlan0
  rsrs place milling.yaml --check --once --interface wlan0 --format json")]
pub struct Arguments {
    #[command(flatten)]
    setup: ExperimentArguments,
    /// Seed of the poses (default: the experiment file's).
    #[arg(long, value_name = "SEED", value_parser = clap::value_parser!(u64).range(..rsrs_core::diagram::sweep_file::SEED_LIMIT))]
    seed: Option<u64>,
    /// Picture to write; its extension selects the format: svg, png or pdf.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    page: PageArguments,
    /// Show where the robots are seen now, until Ctrl-C.
    #[arg(long, conflicts_with = "output")]
    check: bool,
    /// With `--check`: show it once, when all robots were seen, or after 10 s; so does `--format json`.
    #[arg(long, requires = "check")]
    once: bool,
    /// With `--check`: network interface of the fleet, by name or address, more than once for several (or
    /// `RSRS_INTERFACE`, with commas between them).
    #[arg(long, value_name = "NAME|IP", requires = "check")]
    interface: Vec<String>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    if arguments.check {
        arguments.page.check(None, "`--check` draws none: leave it out")?;
    }
    let picture = arguments.page.file_if(arguments.output.as_deref())?;
    let plan = Plan::read(&Request {
        experiment: arguments.setup.experiment.clone(),
        cell: arguments.setup.cell.clone(),
        from: arguments.setup.from.clone(),
        // Whose robots are the measured ones, at any pace.
        backend: Backend::Fleet,
        bag: None,
        seed: arguments.seed,
        place_check: PlaceCheck::Off,
        // Where robots are to stand does not depend on it.
        other_profile: OtherProfile::Insisted,
    })?;
    if arguments.check {
        logging::init(Level::Warn);
        let network = chosen_network(&arguments.interface, Member::Viewer)?;
        let is_once = arguments.once || arguments.format == Format::Json;
        let until = if is_once { Until::AllAreSeen } else { Until::Stopped };
        return check::check(&plan, &network, (until, arguments.format));
    }
    let starts = start_poses(&plan)?;
    if let Some(picture) = picture {
        draw(picture, &arguments.setup.experiment, &starts)?;
    }
    report(arguments.format, &starts, start_poses::text(&starts))?;
    if let Some(picture) = picture {
        report_written(arguments.format, picture.path())?;
    }
    Ok(Outcome::Done)
}

fn draw(picture: PictureFile<'_>, experiment: &Path, starts: &StartPoses) -> anyhow::Result<()> {
    let stem = experiment.file_stem().map_or_else(String::new, |stem| stem.display().to_string());
    picture.write(&start_poses::picture(starts, &stem, picture.style().theme))
}
