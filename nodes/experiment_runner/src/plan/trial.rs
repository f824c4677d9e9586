//! A trial of step 1: one robot that drives by one constant command, or stands and senses.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::conditions::{Conditions, Placement, Settings, Walls};
use rsrs_core::help::Helpful;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::trials::trial::{Neighbour, Trial};
use rsrs_fleet::experiment::{RobotLost, Time};
use rsrs_fleet::fleet_file::{FleetFile, FleetRobot};
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::{Backend, ExperimentRecord, RecordProvenance, pose_source, tracker};

use super::{Measured, Plan, Poses, Recording, as_simulated, new_run_id, read};

/// What a person asks for.
#[derive(Clone, Debug)]
pub struct TrialRequest {
    /// The fleet file.
    pub fleet: PathBuf,
    /// The robot of it.
    pub robot: String,
    /// What it does.
    pub trial: Trial,
    /// What moves the robot.
    pub backend: Backend,
    /// Where the bag goes; named after the run in the current folder if not given.
    pub bag: Option<PathBuf>,
    /// Seed of the simulated robot.
    pub seed: u64,
    /// What stands in for the profile of a robot of the floor that was not measured yet.
    pub unmeasured: Unmeasured,
}

/// What is known of a robot before it is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unmeasured {
    /// Greatest commands of its trials, in m/s and rad/s; `None` for those of the trial itself.
    pub limits: Option<[f64; 2]>,
    /// Interval of its detections, in seconds.
    pub period_s: f64,
}

impl Plan {
    /// The run of a trial. Its controller must turn one way whatever is detected.
    ///
    /// A virtual robot is the measured one in lockstep. Its gains are drawn anew for each command and
    /// seed, so what virtual robots differ by shows between trials. Beside one that stands, the
    /// fleet's first other robot is put; both are held, so that no gust moves them. Beside a robot of
    /// the floor, a person puts whatever is to be detected.
    pub fn of_trial(request: &TrialRequest) -> anyhow::Result<Self> {
        let (name, text) = read(&request.fleet)?;
        let fleet = FleetFile::parse(&name, &text).map_err(Helpful::from)?;
        let mut robots = vec![robot(&fleet, &name, &request.robot)?.clone()];
        if request.backend == Backend::Simulator && request.trial.neighbour().is_some() {
            robots.push(neighbour_of(&fleet, &name, &robots[0])?.clone());
        }
        let stand_in = unmeasured(request, &robots[0]).with_context(|| name.clone())?;
        let is_measured = stand_in.is_none();
        let (profile_text, measured) = if let Some(stand_in) = stand_in {
            stand_in
        } else {
            let measured = Measured::of_robot(&robots[0], &request.fleet)?;
            (measured.text, measured.profile)
        };
        as_simulated(request.backend, &mut robots);
        let time = time(request.backend);
        let conditions = conditions(request, &measured, robots.len())?;
        let duration_s = request.trial.duration_s(conditions.period_s);
        let run_id = new_run_id(Path::new(&format!("trial_{}", request.robot)))?;
        let record = ExperimentRecord {
            robots: robots.iter().map(|robot| robot.name.clone()).collect(),
            provenance: RecordProvenance::new(&measured.digest(), &conditions),
            conditions,
            duration_s,
            seed: request.seed,
            replicate: 0,
            robot_lost: RobotLost::Abort,
            controller_only: super::controller_only(request.backend, &robots),
            pose_source: Some(pose_source(request.backend, &robots)?),
            tracker: tracker(request.backend, &robots)?,
            backend: request.backend,
            time,
            run_id: run_id.clone(),
            gates: BTreeMap::new(),
            // The profile of a trial is that of its robot.
            own_profiles: BTreeMap::new(),
            fixed: None,
        };
        let bag = super::new_bag(request.bag.as_deref(), &run_id)?;
        let files = [(FleetFile::NAME, text), ("profile.yaml", profile_text)];
        let files = files.map(|(name, text)| (name.to_owned(), text)).to_vec();
        let (poses, place_check) = (Poses::IfThere, PlaceCheck::Off);
        let (recording, limits) = (Recording::default(), super::limits(&measured));
        let gates = super::gates(request.backend, &robots, |_| is_measured.then_some(&measured));
        let other_profile = None;
        // A robot that is measured with a tape may have any origin of its odometry.
        let is_tracked =
            request.backend != Backend::Simulator && robots[0].pose != PoseSource::Odom;
        let geofence = fleet.geofence.filter(|_| is_tracked);
        Ok(Self {
            record,
            robots,
            bag,
            files,
            poses,
            place_check,
            recording,
            geofence,
            limits,
            own_limits: BTreeMap::new(),
            gates,
            is_measured,
            other_profile,
        })
    }
}

/// What stands in for the profile of a robot of the floor if its fleet file names none, or one that is
/// not there yet; the simulator moves measured robots only.
///
/// Its limits are the greatest commands that it gets; the rest has no influence on a robot of the
/// floor but the interval of its detections.
fn unmeasured(
    request: &TrialRequest,
    robot: &FleetRobot,
) -> anyhow::Result<Option<(String, RobotProfile)>> {
    let folder = request.fleet.parent().unwrap_or(Path::new(""));
    let missing = match &robot.profile {
        Some(profile) if folder.join(profile).exists() => return Ok(None),
        Some(profile) => format!("the profile `{profile}` of {} is not there", robot.name),
        None => format!("{} has no `profile`", robot.name),
    };
    if request.backend == Backend::Simulator {
        bail!(
            "{missing}, so it cannot be simulated; with `--backend fleet` the robot itself is driven"
        );
    }
    let command = request.trial.command();
    let limits = request.unmeasured.limits;
    let limits = limits.unwrap_or([command.speed_m_s, command.turn_rate_rad_s]);
    let profile = RobotProfile::unmeasured(limits, request.unmeasured.period_s);
    let text = serde_json::to_string_pretty(&profile).context("the profile as JSON")?;
    Ok(Some((text, profile)))
}

/// Control periods of the shortest trial: less does not determine a gain.
const LEAST_STEPS: u64 = 20;

fn robot<'a>(fleet: &'a FleetFile, file: &str, name: &str) -> anyhow::Result<&'a FleetRobot> {
    let found = fleet.robots.iter().find(|robot| robot.name == name).with_context(|| {
        let names: Vec<&str> = fleet.robots.iter().map(|robot| robot.name.as_str()).collect();
        format!("{file} has no robot `{name}`, expected one of: {}", names.join(", "))
    })?;
    if !found.enabled {
        bail!("{file}: {name} has `enabled: false`");
    }
    Ok(found)
}

/// The first other robot of the same kind.
fn neighbour_of<'a>(
    fleet: &'a FleetFile,
    file: &str,
    robot: &FleetRobot,
) -> anyhow::Result<&'a FleetRobot> {
    let is_other = |other: &&FleetRobot| {
        other.enabled && other.name != robot.name && other.profile == robot.profile
    };
    fleet.robots.iter().find(is_other).with_context(|| {
        format!("{file} has no other robot of its kind that could stand beside {}", robot.name)
    })
}

fn time(backend: Backend) -> Time {
    match backend {
        Backend::Simulator => Time::Lockstep,
        Backend::Fleet | Backend::Mixed => Time::RealTime,
    }
}

/// The world of a trial: a robot with all the floor for itself, or held beside another.
fn conditions(
    request: &TrialRequest,
    measured: &RobotProfile,
    n_robots: usize,
) -> anyhow::Result<Conditions> {
    let command = request.trial.command();
    let values = vec![
        (Axis::Speed, command.speed_m_s),
        (Axis::TurnRate, command.turn_rate_rad_s),
        (Axis::Robots, n_robots as f64),
    ];
    let settings = Settings { values, walls: Walls::None, ..Settings::default() };
    let mut conditions = match request.trial {
        Trial::Drive { command, duration_s } => {
            check_drive(command, duration_s)?;
            Conditions::resolve(measured, &settings)?
        }
        Trial::Stand { samples: 0, .. } => bail!("0 readings, expected 1 or more"),
        Trial::Stand { .. } => held(Conditions::resolve(measured, &settings)?),
    };
    if let Some(Neighbour { distance_m, bearing_rad }) = request.trial.neighbour() {
        let least_m = 2.0 * conditions.robot.radius_m;
        if distance_m.is_nan() || distance_m < least_m * (1.0 - ROUNDING) {
            bail!(
                "the neighbour is {distance_m} m away, expected {least_m} m or more: two bodies \
                 that touch"
            );
        }
        conditions.placement = Placement::Pair { distance_m, bearing_rad };
        conditions.check()?;
    }
    let duration_s = request.trial.duration_s(conditions.period_s);
    let is_drive = matches!(request.trial, Trial::Drive { .. });
    if is_drive && conditions.steps(duration_s) < LEAST_STEPS {
        bail!(
            "the trial lasts {duration_s} s, expected {} s ({LEAST_STEPS} control periods) or more",
            LEAST_STEPS as f64 * conditions.period_s
        );
    }
    Ok(conditions)
}

/// Lengths that differ by less than this share were the same before they were rounded; dimensionless.
const ROUNDING: f64 = 1e-6;

/// Nothing moves a robot that is held where it was put.
fn held(mut conditions: Conditions) -> Conditions {
    let robot = &mut conditions.robot;
    robot.turn_bias_sd_rad_s = 0.0;
    robot.heading_noise_sd_rad = 0.0;
    robot.gust_sd_m_s = 0.0;
    conditions
}

fn check_drive(command: ControllerParameters, duration_s: f64) -> anyhow::Result<()> {
    let ControllerParameters { speed_m_s, turn_rate_rad_s, .. } = command;
    for (what, found, unit) in [
        ("the speed", speed_m_s, "m/s"),
        ("the turning rate", turn_rate_rad_s, "rad/s"),
        ("the duration", duration_s, "s"),
    ] {
        if !(found >= 0.0 && found.is_finite()) {
            bail!("{what} is {found} {unit}, expected 0 {unit} or more");
        }
    }
    Axis::Speed.check_unit(speed_m_s)?;
    Axis::TurnRate.check_unit(turn_rate_rad_s)?;
    if speed_m_s == 0.0 && turn_rate_rad_s == 0.0 {
        bail!("speed and turning rate are both 0, expected a command that moves");
    }
    Ok(())
}
