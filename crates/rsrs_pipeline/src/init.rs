//! A folder to begin with: profile, fleet, sweep and experiment of one's own robots.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::axis::Axis;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_fleet::experiment::ExperimentFile;
use rsrs_fleet::fleet_file::FleetFile;
use serde::Serialize;

use crate::error::with_help;
use crate::files::write_file;

/// What is given of the robots; all else is assumed, and marked so.
#[derive(Clone, Debug, PartialEq)]
pub struct Robots {
    /// Name of the kind: letters, digits and `_`.
    pub name: String,
    /// How many there are; at least 1.
    pub n_robots: usize,
    /// Radius of the body, in metres.
    pub radius_m: f64,
    /// Fastest safe command, in metres per second.
    pub speed_m_s: f64,
    /// Fastest safe turn, in radians per second.
    pub turn_rate_rad_s: f64,
    /// How far from its centre a robot detects another, in metres.
    pub range_m: f64,
    /// Half of the sensor's opening angle, in radians.
    pub half_angle_rad: f64,
    /// Time between two detections, in seconds.
    pub period_s: f64,
}

/// What was written.
#[derive(Clone, Debug, Serialize)]
pub struct Begun {
    /// The folder.
    pub folder: PathBuf,
    /// Its files, in the order in which one reads them.
    pub files: Vec<&'static str>,
}

const PROFILE: &str = "profile.yaml";
const FLEET: &str = "fleet.yaml";
const SWEEP: &str = "sweep.yaml";
const EXPERIMENT: &str = "experiment.yaml";

/// Slowest command over the fastest, and slowest turn over the fastest.
const SLOWEST: [f64; 2] = [0.1, 0.05];
/// Robots start in a circle slightly larger than they can see (§IV step 3).
const PLACEMENT_OVER_RANGE: f64 = 1.1;
/// Side of the arena over a robot's range: never reached in a run.
const ARENA_OVER_RANGE: f64 = 20.0;

/// Writes the folder.
///
/// # Errors
///
/// If the folder exists, a number makes no robot, or a file cannot be written; then nothing is.
pub fn init(folder: &Path, robots: &Robots) -> anyhow::Result<Begun> {
    if folder.exists() {
        return Err(with_help(
            format!("{} exists", folder.display()),
            "give a folder that does not exist",
        ));
    }
    check(robots)?;
    let texts = texts(robots);
    check_texts(&texts)?;
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    for (name, text) in &texts {
        write_file(&folder.join(name), text.as_bytes())?;
    }
    let files = texts.iter().map(|(name, _)| *name).collect();
    Ok(Begun { folder: folder.to_owned(), files })
}

/// Refuses what is no name, and numbers that are likely in another unit.
fn check(robots: &Robots) -> anyhow::Result<()> {
    let is_name = |name: &str| {
        let mut characters = name.chars();
        characters.next().is_some_and(|first| first.is_ascii_lowercase())
            && characters
                .all(|other| other.is_ascii_lowercase() || other.is_ascii_digit() || other == '_')
    };
    if !is_name(&robots.name) {
        return Err(with_help(
            format!("the name is `{}`, expected small letters, digits and `_`", robots.name),
            "names of robots begin with it: `--name flockbot`",
        ));
    }
    for (axis, value) in [
        (Axis::Speed, robots.speed_m_s),
        (Axis::TurnRate, robots.turn_rate_rad_s),
        (Axis::Range, robots.range_m),
        (Axis::HalfAngle, robots.half_angle_rad),
        (Axis::Period, robots.period_s),
    ] {
        axis.check_unit(value)?;
        if !(value > 0.0 && value.is_finite()) {
            anyhow::bail!("{axis} is {value}, expected a number above 0");
        }
    }
    Ok(())
}

/// The files, in the order in which one reads them.
fn texts(robots: &Robots) -> Vec<(&'static str, String)> {
    let Robots { name, n_robots, speed_m_s, turn_rate_rad_s, range_m, .. } = robots;
    let rounded = |number: f64| {
        // Three significant digits, as a person would write it.
        let scale = libm::pow(10.0, 2.0 - libm::log10(number).floor());
        (number * scale).round() / scale
    };
    let [least_m_s, least_rad_s] =
        [rounded(SLOWEST[0] * speed_m_s), rounded(SLOWEST[1] * turn_rate_rad_s)];
    let values = [
        ("@NAME@", name.clone()),
        ("@N_ROBOTS@", n_robots.to_string()),
        ("@RADIUS_M@", robots.radius_m.to_string()),
        ("@SPEED_M_S@", speed_m_s.to_string()),
        ("@LEAST_SPEED_M_S@", least_m_s.to_string()),
        ("@SWEEP_FROM_M_S@", rounded(0.2 * speed_m_s).to_string()),
        ("@TURN_RATE_RAD_S@", turn_rate_rad_s.to_string()),
        ("@LEAST_TURN_RATE_RAD_S@", least_rad_s.to_string()),
        ("@SWEEP_FROM_RAD_S@", rounded(0.1 * turn_rate_rad_s).to_string()),
        ("@HALF_ANGLE_RAD@", robots.half_angle_rad.to_string()),
        ("@RANGE_M@", range_m.to_string()),
        ("@PERIOD_S@", robots.period_s.to_string()),
        ("@PLACEMENT_M@", rounded(PLACEMENT_OVER_RANGE * placement_m(robots)).to_string()),
        ("@ARENA_M@", rounded(ARENA_OVER_RANGE * placement_m(robots)).to_string()),
    ];
    let filled = |template: &str| {
        values.iter().fold(template.to_owned(), |text, (key, value)| text.replace(key, value))
    };
    let member = |robot: usize| format!("  {name}_{robot}: {{enabled: true, type: {name}}}\n");
    let members: Vec<String> = (1..=*n_robots).map(member).collect();
    vec![
        (PROFILE, filled(include_str!("init/profile.yaml"))),
        (FLEET, filled(include_str!("init/fleet.yaml")) + &members.concat()),
        (SWEEP, filled(include_str!("init/sweep.yaml"))),
        (EXPERIMENT, filled(include_str!("init/experiment.yaml"))),
    ]
}

/// What the placement follows from: the range, or where bodies do not fit into that, their size.
fn placement_m(robots: &Robots) -> f64 {
    let crowded_m = 3.0 * robots.radius_m * (robots.n_robots as f64).sqrt();
    robots.range_m.max(crowded_m)
}

/// Reads what is about to be written as it will be read, so that no folder is left that does not work.
fn check_texts(texts: &[(&'static str, String)]) -> anyhow::Result<()> {
    let text = |wanted: &str| {
        let found = texts.iter().find(|(name, _)| *name == wanted);
        found.map(|(_, text)| text.as_str()).expect("every file is among them")
    };
    let profile = RobotProfile::parse(PROFILE, text(PROFILE))?;
    let sweep = SweepFile::parse(SWEEP, text(SWEEP)).map_err(crate::error::helped)?;
    let cells = sweep.resolve(SWEEP, &profile).map_err(crate::error::helped)?;
    let conditions: Vec<Conditions> = cells.into_iter().map(|(_, conditions)| conditions).collect();
    let runs = rsrs_sim::sweep::Runs {
        seed: sweep.seed,
        replicates: 1,
        duration_s: sweep.duration_s,
        n_threads: 1,
    };
    rsrs_sim::sweep::check(&conditions[..1], runs)?;
    FleetFile::parse(FLEET, text(FLEET)).map_err(crate::error::helped)?;
    ExperimentFile::parse(EXPERIMENT, text(EXPERIMENT)).map_err(crate::error::helped)?;
    Ok(())
}
