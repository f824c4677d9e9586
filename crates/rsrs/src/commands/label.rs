//! `rsrs label`: what a bag shows, by the one judge.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_bags::Bag;
use rsrs_bags::trajectory::{PoseSource, TrajectoryOptions, read_trajectory};
use rsrs_core::conditions::Region;
use rsrs_core::order::Evidence;
use rsrs_core::phase::{Phase, label};
use rsrs_core::trajectory::Bodies;
use serde::Serialize;

use crate::commands::{Format, report};
use crate::failure::{Outcome, with_help};
use crate::sweep_source::read_profile;

/// Label bags with the phase that their swarm settled into.
///
/// The judge looks at the last 60 s in which the run's lease said RUNNING, or else in which robots
/// were commanded to move. It needs poses; body and range come from `--profile`. Without a range,
/// dispersion is judged by growth alone.
#[derive(clap::Args)]
pub struct Arguments {
    /// Bags: rosbag2 folders or single .mcap files.
    #[arg(required = true)]
    bags: Vec<PathBuf>,
    /// The robots' profile, for the radius of their body and their sensing range.
    #[arg(long, value_name = "PROFILE")]
    profile: Option<PathBuf>,
    /// Topic that poses come from (default: the first of these that the bag has).
    #[arg(long, value_enum)]
    poses: Option<Poses>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Poses {
    /// `/<robot>/odom`.
    Odom,
    /// `/<robot>/pose`.
    Pose,
    /// `/tf`.
    Tf,
}

#[derive(Serialize)]
struct Labelled {
    bag: PathBuf,
    phase: Phase,
    evidence: Evidence,
    n_robots: usize,
    duration_s: f64,
    by: &'static str,
}

/// Runs the command.
///
/// # Errors
///
/// If a bag cannot be read, has no poses, or is too short; the first such bag is named.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let bodies = match &arguments.profile {
        None => Bodies { radius_m: None, range_m: None },
        Some(path) => {
            let profile = read_profile(path)?;
            let range_m = Some(Region::of(&profile.sensing).range_m());
            Bodies { radius_m: Some(profile.body.radius_m), range_m }
        }
    };
    let labelled = arguments
        .bags
        .iter()
        .map(|bag| label_one(bag, arguments.poses, &bodies))
        .collect::<anyhow::Result<Vec<Labelled>>>()?;
    let lines: Vec<String> = labelled.iter().map(line).collect();
    report(arguments.format, &labelled, &lines.join("\n"))?;
    Ok(Outcome::Done)
}

fn label_one(path: &Path, poses: Option<Poses>, bodies: &Bodies) -> anyhow::Result<Labelled> {
    let bag = Bag::open(path).map_err(|error| match error.help() {
        Some(help) => with_help(error.to_string(), help),
        None => error.into(),
    })?;
    let poses = poses.map(|poses| match poses {
        Poses::Odom => PoseSource::Odom,
        Poses::Pose => PoseSource::Pose,
        Poses::Tf => PoseSource::Tf,
    });
    let recorded =
        read_trajectory(&bag, &TrajectoryOptions { poses }).map_err(|error| {
            match error.help() {
                Some(help) => with_help(format!("{}: {error}", path.display()), help),
                None => anyhow::Error::new(error).context(path.display().to_string()),
            }
        })?;
    let verdict =
        label(&recorded.trajectory, bodies).with_context(|| path.display().to_string())?;
    Ok(Labelled {
        bag: path.to_path_buf(),
        phase: verdict.phase,
        evidence: verdict.evidence,
        n_robots: verdict.n_robots,
        duration_s: verdict.duration_s,
        by: "judge",
    })
}

fn line(labelled: &Labelled) -> String {
    let evidence = &labelled.evidence;
    format!(
        "{}: {} ({} robots, {:.0} s; rotation {:.2}, orbit {:.2}, circliness {:.2} of {:.2}, \
         blocked {:.2})",
        labelled.bag.display(),
        labelled.phase,
        labelled.n_robots,
        labelled.duration_s,
        evidence.rotation,
        evidence.orbit,
        evidence.circliness,
        evidence.circliness_ceiling,
        evidence.blocked
    )
}
