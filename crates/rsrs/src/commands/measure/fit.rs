//! `rsrs measure fit`: from trials to a profile.

use std::path::PathBuf;

use rsrs_core::capability::{LostCapability, lost_capabilities};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::trials::fit::{Details, Fit, Unmeasured};
use rsrs_pipeline::files::write_file;
use rsrs_pipeline::init::{check_name, check_radius};
use rsrs_pipeline::measure::fit::{Mixture, fit_files};
use rsrs_pipeline::measure::sources::Paths;
use rsrs_render::fit::{draw, text};
use serde::Serialize;

use crate::commands::{Format, report};
use crate::failure::{Outcome, bad_arguments};
use crate::page_arguments::PageArguments;
use crate::wheel_arguments::WheelArguments;

/// Fit a profile to trials: every number with its interval and where it comes from.
///
/// Tables are CSV with the header of `rsrs measure plan`. All of them may come from bags instead, and
/// straight runs and turns from trajectories; a table that is given takes precedence. Outliers are
/// named, not dropped. A profile fitted to trials of the simulator says so wherever it is used; trials
/// of simulator and robots are mixed only with `--mixed`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs measure fit --speed speed.csv --turn turn.csv --detection detection.csv --period period.csv \\
      --name flockbot -o flockbot.yaml --pictures pictures
  rsrs measure fit --plan trials --name flockbot -o flockbot.yaml
  rsrs measure fit --bags straight_* turn_* standing_* --name flockbot -o flockbot.yaml
  rsrs measure fit --speed speed.csv --turn turn.csv --detection detection.csv --name flockbot \\
      --format json")]
pub struct Arguments {
    /// Folder of `rsrs measure plan`, filled in: its tables, and the bags that `rsrs measure drive
    /// --plan` recorded.
    #[arg(
        long,
        value_name = "DIR",
        conflicts_with_all = ["speed", "turn", "arcs", "detection", "period", "bags"]
    )]
    plan: Option<PathBuf>,
    /// Straight runs:
    /// `robot,commanded_m_s,distance_m,duration_s[,lateral_m,heading_change_rad,paused_s,backend]`.
    #[arg(long, value_name = "CSV", required_unless_present_any = ["trajectories", "bags", "plan"])]
    speed: Option<PathBuf>,
    /// Turns in place: `robot,commanded_rad_s,angle_rad,duration_s[,paused_s,backend]`.
    #[arg(long, value_name = "CSV", required_unless_present_any = ["trajectories", "bags", "plan"])]
    turn: Option<PathBuf>,
    /// Turns while driving:
    /// `robot,commanded_m_s,commanded_rad_s,angle_rad,duration_s[,paused_s,backend]`; without them, robots turn while they drive as they do in place.
    #[arg(long, value_name = "CSV")]
    arcs: Option<PathBuf>,
    /// Detections: `robot,distance_m,bearing_rad,samples,detections[,backend]`; no distance means no
    /// neighbour.
    #[arg(long, value_name = "CSV", required_unless_present_any = ["bags", "plan"])]
    detection: Option<PathBuf>,
    /// Control periods: `robot,period_s[,backend]`.
    #[arg(long, value_name = "CSV")]
    period: Option<PathBuf>,
    /// Trajectories:
    /// `robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s`.
    #[arg(long, value_name = "CSV", num_args = 1..)]
    trajectories: Vec<PathBuf>,
    /// Bags of trials: of robots that drive alone, poses and commands are trajectories, and the stamps
    /// of detections are control periods; of robots that stand, as `rsrs measure drive` makes them
    /// with `--distance` or `--alone`, all readings are detections.
    #[arg(long, value_name = "BAG", num_args = 1..)]
    bags: Vec<PathBuf>,
    /// Fit trials of the simulator and of robots together.
    #[arg(long)]
    mixed: bool,
    /// Radius of a robot's body, in m (default: 0.075).
    #[arg(long, value_name = "M")]
    radius: Option<f64>,
    /// What robots do when they touch: `stop`, `push` or `none`, as in `rsrs init` (default: stop).
    #[arg(long, value_name = "CONTACT")]
    contact: Option<ContactModel>,
    #[command(flatten)]
    wheels: WheelArguments,
    /// Name of the kind of robot.
    #[arg(long)]
    name: String,
    /// Profile to write (YAML).
    #[arg(short, long, value_name = "PROFILE")]
    output: Option<PathBuf>,
    /// Folder to write the pictures into: the speeds of each robot, and the sensor.
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    #[command(flatten)]
    page: PageArguments,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// The output for programs: the report, and behind it all that it was made of.
#[derive(Serialize)]
struct FitOutput<'a> {
    #[serde(flatten)]
    fitted: &'a Fit,
    details: &'a Details,
    /// What the default factors of a sweep would leave next to nothing of.
    lost_capabilities: &'a [LostCapability],
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    arguments
        .page
        .check(arguments.pictures.as_deref(), "name a folder for them with `--pictures`")?;
    check_name(&arguments.name).map_err(bad_arguments)?;
    let unmeasured = unmeasured(arguments)?;
    let mixture = if arguments.mixed { Mixture::Allowed } else { Mixture::Refused };
    let files = fit_files(&paths(arguments)?, &unmeasured, mixture)?;
    let fitted = &files.fit;
    let profile = fitted.profile(&arguments.name, &unmeasured);
    let simulated = HarsherFactors::for_robot(&profile).apply(&profile)?;
    let lost = lost_capabilities(&profile, &simulated);
    if let Some(path) = &arguments.output {
        let text = profile.to_yaml();
        write_file(path, text.as_bytes())?;
    }
    if let Some(folder) = &arguments.pictures {
        let style = arguments.page.style();
        draw(folder, &files, &arguments.name, unmeasured.radius_m, style)?;
    }
    let words = text(&arguments.name, &files, &lost);
    let given = FitOutput { fitted, details: &fitted.details, lost_capabilities: &lost };
    report(arguments.format, &given, words)?;
    Ok(Outcome::Done)
}

fn paths(arguments: &Arguments) -> anyhow::Result<Paths> {
    let mut paths = match &arguments.plan {
        Some(folder) => Paths::of_plan(folder)?,
        None => Paths {
            speed: arguments.speed.clone(),
            turn: arguments.turn.clone(),
            arcs: arguments.arcs.clone(),
            detection: arguments.detection.clone(),
            period: arguments.period.clone(),
            bags: arguments.bags.clone(),
            ..Paths::default()
        },
    };
    paths.trajectories.clone_from(&arguments.trajectories);
    Ok(paths)
}

fn unmeasured(arguments: &Arguments) -> anyhow::Result<Unmeasured> {
    let mut unmeasured = Unmeasured::default();
    if let Some(radius_m) = arguments.radius {
        check_radius(radius_m).map_err(bad_arguments)?;
        unmeasured.radius_m = radius_m;
        unmeasured.radius_source = Some("given to rsrs measure fit".to_owned());
    }
    unmeasured.contact = arguments.contact.unwrap_or_default();
    unmeasured.wheels = arguments.wheels.wheels()?;
    Ok(unmeasured)
}
