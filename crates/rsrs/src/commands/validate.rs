//! `rsrs validate`: step 2, are the real trajectories inside the simulated reach?

use std::path::PathBuf;

use rsrs_core::quantity::Cell;
use rsrs_pipeline::validate::{StandIn, ValidateOptions, validate};
use rsrs_render::validation::{text, write};
use rsrs_sim::reachable_set::ReachOptions;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::page_arguments::PageArguments;

/// Check that the simulated robot is worse than the real ones: step 2 of the method.
///
/// Simulated robots drive the commands of real trials; 99 % of them bound where such a robot can be.
/// Real trials must lie inside at every time; robots that the simulator reproduces are refused in at
/// most 5 of 100 cases. A region so large that it contains anything proves nothing, so the area of
/// every region is printed. The simulated robot must also be nowhere better than its profile, and
/// detections must not contradict its sensor. Where the robot pushes an object, one of the sweep's
/// world is pushed in the same way, and must go where the real one went. Exit code 3 means that one of
/// these does not hold. A robot that is worse in all of this does not by itself make reality at least
/// as good as the simulation; `rsrs compare` tests that.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs validate results/flockbot --trajectories tracker.csv --detection detection.csv
  rsrs validate sweep.yaml --trajectories drive_1 drive_2 -o validation
  rsrs validate results/flockbot --trajectories tracker.csv --format json")]
pub struct Arguments {
    /// Sweep file (YAML), or the folder of a sweep.
    sweep: PathBuf,
    /// Real trajectories of robots that drive alone:
    /// `robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s[,object_x_m,object_y_m]`, or bags.
    #[arg(long, value_name = "CSV|BAG", num_args = 1.., required = true)]
    trajectories: Vec<PathBuf>,
    /// Detections: `robot,distance_m,bearing_rad,samples,detections[,backend]`; no distance means no
    /// neighbour.
    #[arg(long, value_name = "CSV")]
    detection: Option<PathBuf>,
    /// Accept trajectories of the simulator instead of real ones; the result says so.
    #[arg(long)]
    simulated: bool,
    /// Values of the capabilities that the sweep varies, as AXIS=VALUE,…: one robot is judged.
    #[arg(long, value_name = "AXIS=V")]
    at: Option<Cell>,
    /// The class whose robot is judged, where classes of the sweep's world have profiles of their
    /// own; of bags with several classes, only its robots' trajectories count.
    #[arg(long, value_name = "NAME")]
    class: Option<String>,
    /// Simulated robots, 200 or more (default: 2000).
    #[arg(long, value_name = "N")]
    robots: Option<usize>,
    /// How far measured positions may be off, in m (default: 0.005).
    #[arg(long, value_name = "M")]
    tolerance: Option<f64>,
    /// How far measured headings may be off, in rad (default: 0.01).
    #[arg(long, value_name = "RAD")]
    tolerance_heading: Option<f64>,
    /// Folder for validation.json and the pictures; drives whose command changes, or that push an
    /// object, are drawn only if they left the region (default: the folder of the sweep, if it is
    /// one, whose diagram then shows the answer).
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    page: PageArguments,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let beside_sweep = arguments.sweep.is_dir().then_some(arguments.sweep.as_path());
    let drawn = arguments.output.as_deref().or(beside_sweep);
    arguments.page.check(drawn, "name a folder for them with `-o`")?;
    let usual = ReachOptions::default();
    let options = ValidateOptions {
        trajectories: arguments.trajectories.clone(),
        detection: arguments.detection.clone(),
        stand_in: if arguments.simulated { StandIn::Allowed } else { StandIn::Refused },
        at: arguments.at.clone().unwrap_or_default(),
        class: arguments.class.clone(),
        reach: ReachOptions {
            n_robots: arguments.robots.unwrap_or(usual.n_robots),
            tolerance_m: arguments.tolerance.unwrap_or(usual.tolerance_m),
            tolerance_rad: arguments.tolerance_heading.unwrap_or(usual.tolerance_rad),
            ..usual
        },
    };
    let validated = validate(&arguments.sweep, &options)?;
    let style = arguments.page.style();
    write(&validated, &arguments.sweep, arguments.output.as_deref(), style)?;
    let answer = validated.answer;
    report(arguments.format, &answer, text(&answer))?;
    Ok(if answer.is_harsher { Outcome::Done } else { Outcome::NegativeAnswer })
}
