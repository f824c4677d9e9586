//! A trial of step 1: one robot, one constant command.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};
use rsrs_core::axis::Axis;
use rsrs_core::conditions::{Conditions, Settings, Walls};
use rsrs_core::controller::{ControllerParameters, Reaction};
use rsrs_fleet::experiment::{RobotLost, Time};
use rsrs_fleet::fleet_file::{CmdVel, FleetFile, FleetRobot};
use rsrs_fleet::record::{Backend, ExperimentRecord, Provenance};

use super::{PROGRAM, PlaceCheck, Plan, Poses, common_profile, read, run_id};

/// What a person asks for.
#[derive(Clone, Debug)]
pub struct TrialRequest {
    /// The fleet file.
    pub fleet: PathBuf,
    /// The robot of it.
    pub robot: String,
    /// The command: forward speed, and turning rate counterclockwise.
    pub command: ControllerParameters,
    /// How long, in seconds.
    pub duration_s: f64,
    /// What moves the robot.
    pub backend: Backend,
    /// Where the bag goes; named after the run in the current folder if not said.
    pub bag: Option<PathBuf>,
    /// Seed of the simulated robot.
    pub seed: u64,
}

impl Plan {
    /// The run of a trial. Its controller must turn one way whatever is detected.
    ///
    /// A virtual robot is the measured one in lockstep. Its gains are drawn anew for each command and
    /// seed, so what virtual robots differ by shows between trials.
    ///
    /// # Errors
    ///
    /// If a file cannot be read or is wrong, the fleet has no such robot that may be used, the command
    /// is none, or the bag exists already.
    pub fn of_trial(request: &TrialRequest) -> anyhow::Result<Self> {
        let (name, text) = read(&request.fleet)?;
        let fleet = FleetFile::parse(&name, &text)?;
        let robots = [robot(&fleet, (&name, &request.robot))?.clone()];
        let (profile_text, measured) = common_profile(&robots, &request.fleet)?;
        let time = time(request.backend, &robots[0])?;
        check(request)?;
        let values = vec![
            (Axis::Speed, request.command.speed_m_s),
            (Axis::TurnRate, request.command.turn_rate_rad_s),
            (Axis::Robots, 1.0),
        ];
        let conditions = Conditions::resolve(&measured, &Settings { values, walls: Walls::None })?;
        if conditions.steps(request.duration_s) < LEAST_STEPS {
            bail!(
                "the trial lasts {} s, expected {} s ({LEAST_STEPS} control periods) or more",
                request.duration_s,
                LEAST_STEPS as f64 * conditions.period_s
            );
        }
        let run_id = run_id(Path::new(&format!("trial_{}", request.robot)));
        let record = ExperimentRecord {
            robots: vec![request.robot.clone()],
            provenance: Provenance::new(PROGRAM, &measured.digest(), &conditions),
            conditions,
            duration_s: request.duration_s,
            seed: request.seed,
            replicate: 0,
            robot_lost: RobotLost::Abort,
            backend: request.backend,
            time,
            run_id: run_id.clone(),
        };
        let bag = request.bag.clone().unwrap_or_else(|| PathBuf::from(&run_id));
        if bag.exists() {
            bail!("{} exists already; give another folder for the bag", bag.display());
        }
        let files = vec![("fleet.yaml", text), ("profile.yaml", profile_text)];
        let (poses, place_check) = (Poses::IfThere, PlaceCheck::Off);
        Ok(Self { record, robots: robots.into(), bag, files, poses, place_check })
    }
}

impl Plan {
    /// What its controllers must make of their sensors: nothing in a trial, which is the only run that
    /// needs no poses.
    pub fn reaction(&self) -> Reaction {
        match self.poses {
            Poses::Required => Reaction::ToDetections,
            Poses::IfThere => Reaction::Constant,
        }
    }
}

/// Control periods of the shortest trial: less says nothing of a gain.
const LEAST_STEPS: u64 = 20;

fn robot<'a>(fleet: &'a FleetFile, (file, name): (&str, &str)) -> anyhow::Result<&'a FleetRobot> {
    let found = fleet.robots.iter().find(|robot| robot.name == name).with_context(|| {
        let names: Vec<&str> = fleet.robots.iter().map(|robot| robot.name.as_str()).collect();
        format!("{file} has no robot `{name}`, expected one of: {}", names.join(", "))
    })?;
    if !found.enabled {
        bail!("{file}: {name} has `enabled: false`");
    }
    Ok(found)
}

fn time(backend: Backend, robot: &FleetRobot) -> anyhow::Result<Time> {
    match (backend, robot.cmd_vel) {
        (Backend::Fleet | Backend::Mixed, _) => Ok(Time::RealTime),
        (Backend::Simulator, CmdVel::TwistStamped) => Ok(Time::Lockstep),
        (Backend::Simulator, CmdVel::Twist) => {
            Err(anyhow!("{} takes `cmd_vel: twist`, lockstep needs `twist_stamped`", robot.name))
        }
    }
}

fn check(request: &TrialRequest) -> anyhow::Result<()> {
    let ControllerParameters { speed_m_s, turn_rate_rad_s } = request.command;
    for (what, found, unit) in [
        ("the speed", speed_m_s, "m/s"),
        ("the turning rate", turn_rate_rad_s, "rad/s"),
        ("the duration", request.duration_s, "s"),
    ] {
        if !(found >= 0.0 && found.is_finite()) {
            bail!("{what} is {found} {unit}, expected 0 {unit} or more");
        }
    }
    if speed_m_s == 0.0 && turn_rate_rad_s == 0.0 {
        bail!("speed and turning rate are both 0, expected a command that moves");
    }
    Ok(())
}
