//! `rsrs label`: what a bag shows, by the one judge.

use std::path::PathBuf;

use rsrs_bags::trajectory::PoseSource;
use rsrs_core::conditions::Region;
use rsrs_core::trajectory::Bodies;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::labelling::{LabelOptions, Labelled, label_bag};
use crate::sweep_source::read_profile;

/// Label bags with the phase that their swarm settled into.
///
/// The judge looks at the last 60 s in which the run's lease said RUNNING, or else in which robots
/// were commanded to move. It needs poses. The robots' body and sensing range come from
/// `--profile`, or else from the record of the experiment that bags of `rsrs` hold. Without a
/// range, dispersion is judged by growth alone.
#[derive(clap::Args)]
pub struct Arguments {
    /// Bags: rosbag2 folders or single .mcap files.
    #[arg(required = true)]
    bags: Vec<PathBuf>,
    /// The robots' profile, for the radius of their body and their sensing range (default: what
    /// each bag's record says).
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

/// Runs the command.
///
/// # Errors
///
/// If a bag cannot be read, has no poses, or is too short; the first such bag is named.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let options = options(arguments)?;
    let labelled = arguments
        .bags
        .iter()
        .map(|bag| label_bag(bag, options))
        .collect::<anyhow::Result<Vec<Labelled>>>()?;
    let lines: Vec<String> = labelled.iter().map(line).collect();
    report(arguments.format, &labelled, &lines.join("\n"))?;
    Ok(Outcome::Done)
}

fn options(arguments: &Arguments) -> anyhow::Result<LabelOptions> {
    let bodies = match &arguments.profile {
        None => None,
        Some(path) => {
            let profile = read_profile(path)?;
            let range_m = Some(Region::of(&profile.sensing).range_m());
            Some(Bodies { radius_m: Some(profile.body.radius_m), range_m })
        }
    };
    let poses = arguments.poses.map(|poses| match poses {
        Poses::Odom => PoseSource::Odom,
        Poses::Pose => PoseSource::Pose,
        Poses::Tf => PoseSource::Tf,
    });
    Ok(LabelOptions { bodies, poses })
}

fn line(labelled: &Labelled) -> String {
    let evidence = &labelled.evidence;
    let lost = match evidence.lost {
        Some(lost) => format!("lost {lost:.2}"),
        None => "lost unknown without a sensing range".to_owned(),
    };
    let damage = match &labelled.damage {
        Some(damage) => format!("\n  {damage}; what came before was judged"),
        None => String::new(),
    };
    format!(
        "{}: {} ({} robots, {:.0} s; rotation {:.2}, orbit {:.2}, circliness {:.2} of {:.2}, \
         blocked {:.2}, {lost}){damage}",
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
