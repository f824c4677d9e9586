//! `rsrs place`: start poses for the floor.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use rsrs_core::axis::Cell;
use rsrs_core::conditions::Conditions;
use rsrs_core::unicycle::Pose;
use rsrs_experiment_runner::plan::{PlaceCheck, Plan, Request};
use rsrs_fleet::placement::CLEARANCE_RADII;
use rsrs_fleet::record::Backend;
use rsrs_sim::draw::{RunKey, Seed};
use rsrs_sim::placement;
use rsrs_view::placement::PlacementPicture;
use serde::Serialize;

use crate::commands::{Format, report};
use crate::failure::{Outcome, explained, with_help};
use crate::picture::PNG_WIDTH_PX;
use crate::result_folder::write_file;

/// Print start poses for the floor, as a table and a picture.
///
/// They are those with which the simulator starts this experiment with measured robots. The robots'
/// centres lie in a disc around the origin, far enough apart, and every robot faces away from the
/// centre; `--seed` gives others that are as good.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs place launch_configs/experiments/flockbot_milling.yaml
  rsrs place launch_configs/experiments/flockbot_milling.yaml -o start.png
  rsrs place milling.yaml --from results/flockbot --seed 7 --format json")]
pub struct Arguments {
    /// Experiment file (YAML).
    experiment: PathBuf,
    /// Folder of a sweep: the robots of its chosen cell, or of the one that `--cell` names.
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
    /// Cell to run, as AXIS=VALUE,…
    #[arg(long)]
    cell: Option<Cell>,
    /// Seed of the poses (default: the experiment file's).
    #[arg(long, value_name = "SEED", value_parser = clap::value_parser!(u64).range(..rsrs_core::sweep_file::SEED_LIMIT))]
    seed: Option<u64>,
    /// Picture to write; its ending says how: svg or png.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Start poses.
#[derive(Debug, Serialize)]
pub struct StartPoses {
    /// Of the poses.
    seed: u64,
    /// Radius of the disc of the robots' centres, in metres.
    disc_radius_m: f64,
    /// Least distance between two centres, in metres.
    clearance_m: f64,
    /// Radius of a robot's body, in metres.
    body_radius_m: f64,
    /// In the order of the fleet file.
    robots: Vec<StartPose>,
}

#[derive(Debug, Serialize)]
pub struct StartPose {
    robot: String,
    x_m: f64,
    y_m: f64,
    /// In (-π, π].
    heading_rad: f64,
    /// In (-180, 180].
    heading_deg: f64,
}

/// Runs the command.
///
/// # Errors
///
/// If a file is wrong, the robots do not fit, or the picture cannot be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let plan = Plan::read(&Request {
        experiment: arguments.experiment.clone(),
        cell: arguments.cell.clone(),
        from: arguments.from.clone(),
        // Whose robots are the measured ones, at any pace.
        backend: Backend::Fleet,
        bag: None,
        seed: arguments.seed,
        place_check: PlaceCheck::Off,
    })?;
    let poses = start_poses(&plan)?;
    if let Some(path) = &arguments.output {
        draw(path, &arguments.experiment, &poses)?;
    }
    report(arguments.format, &poses, &text(&poses))?;
    Ok(Outcome::Done)
}

/// Where the robots of a plan start.
///
/// # Errors
///
/// If the robots do not fit into the disc.
pub fn start_poses(plan: &Plan) -> anyhow::Result<StartPoses> {
    let record = &plan.record;
    let seed = Seed { seed: record.seed, replicate: record.replicate };
    let poses = poses(&record.conditions, seed)?;
    let robots = record.robots.iter().zip(poses).map(|(robot, pose)| StartPose {
        robot: robot.clone(),
        x_m: pose.x_m,
        y_m: pose.y_m,
        heading_rad: wrapped(pose.heading_rad),
        heading_deg: wrapped(pose.heading_rad).to_degrees(),
    });
    Ok(StartPoses {
        seed: record.seed,
        disc_radius_m: record.conditions.placement.radius_m(),
        clearance_m: CLEARANCE_RADII * record.conditions.robot.radius_m,
        body_radius_m: record.conditions.robot.radius_m,
        robots: robots.collect(),
    })
}

/// Where the simulator starts a replicate of these conditions.
fn poses(conditions: &Conditions, seed: Seed) -> anyhow::Result<Vec<Pose>> {
    let run = RunKey::new(seed, conditions.digest());
    placement::place(conditions, run).map_err(|error| {
        let (message, help) = (error.to_string(), error.help());
        explained(error, message, Some(&help))
    })
}

/// An angle in (-π, π].
fn wrapped(angle_rad: f64) -> f64 {
    let turns = (angle_rad / std::f64::consts::TAU).round();
    let wrapped = angle_rad - turns * std::f64::consts::TAU;
    if wrapped <= -std::f64::consts::PI { std::f64::consts::PI } else { wrapped }
}

/// The poses as a table.
pub fn text(poses: &StartPoses) -> String {
    let width = poses.robots.iter().map(|pose| pose.robot.len()).max().unwrap_or(0).max(5);
    let mut text = format!(
        "{} robots in a disc of radius {} m, centres at least {:.3} m apart, seed {}\n\
         x and y from the centre of the disc; heading counterclockwise from x\n\n\
         {:width$}   x (m)   y (m)  heading (°)  heading (rad)\n",
        poses.robots.len(),
        poses.disc_radius_m,
        poses.clearance_m,
        poses.seed,
        "robot",
    );
    for StartPose { robot, x_m, y_m, heading_rad, heading_deg } in &poses.robots {
        writeln!(
            text,
            "{robot:width$}  {x_m:>6.3}  {y_m:>6.3}  {heading_deg:>11.0}  {heading_rad:>13.3}"
        )
        .expect("a string takes any text");
    }
    text
}

fn draw(path: &Path, experiment: &Path, poses: &StartPoses) -> anyhow::Result<()> {
    let robots: Vec<(String, Pose)> = poses
        .robots
        .iter()
        .map(|StartPose { robot, x_m, y_m, heading_rad, .. }| {
            (robot.clone(), Pose { x_m: *x_m, y_m: *y_m, heading_rad: *heading_rad })
        })
        .collect();
    let stem = experiment.file_stem().map_or_else(String::new, |stem| stem.display().to_string());
    let svg = rsrs_view::placement::svg(&PlacementPicture {
        robots: &robots,
        disc_m: poses.disc_radius_m,
        radius_m: poses.body_radius_m,
        title: format!("Start of {stem}"),
        subtitle: format!(
            "{} robots facing out, disc of radius {} m, seed {}",
            robots.len(),
            poses.disc_radius_m,
            poses.seed
        ),
    });
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("svg") => write_file(path, svg.as_bytes()),
        Some("png") => write_file(path, &rsrs_view::raster::png(&svg, PNG_WIDTH_PX)?),
        _ => Err(with_help(
            format!("{} ends in neither .svg nor .png", path.display()),
            "name the picture `-o start.svg` or `-o start.png`",
        )),
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::conditions::Settings;
    use rsrs_core::profile::RobotProfile;
    use rsrs_fleet::placement::{StartDisc, deviations};

    use super::*;

    fn flockbots() -> Conditions {
        let text = include_str!("../../../../launch_configs/profiles/flockbot.yaml");
        let profile = RobotProfile::parse("flockbot.yaml", text).unwrap();
        let cell: Cell = "speed_m_s=0.15,turn_rate_rad_s=0.75,robots=9".parse().unwrap();
        let mut settings = Settings::default().with_cell(&cell);
        settings.values.push((rsrs_core::axis::Axis::PlacementRadius, 0.825));
        Conditions::resolve(&profile, &settings).unwrap()
    }

    #[test]
    fn what_the_runner_checks_is_what_the_simulator_places() {
        let conditions = flockbots();
        let clearance_m = CLEARANCE_RADII * conditions.robot.radius_m;
        let wanted = StartDisc { radius_m: 0.825, clearance_m };

        for seed in 0..200 {
            let poses = poses(&conditions, Seed { seed, replicate: 0 }).unwrap();
            let named: Vec<_> = poses
                .into_iter()
                .enumerate()
                .map(|(robot, pose)| (robot.to_string(), pose))
                .collect();

            assert_eq!(deviations(wanted, &named), [], "seed {seed}");
        }
    }

    #[test]
    fn angles_are_told_between_minus_and_plus_a_half_turn() {
        use std::f64::consts::PI;

        for (angle_rad, expected_rad) in
            [(0.0, 0.0), (1.5 * PI, -0.5 * PI), (-PI, PI), (PI, PI), (2.0 * PI, 0.0)]
        {
            assert!((wrapped(angle_rad) - expected_rad).abs() < 1e-12, "{angle_rad}");
        }
    }
}
