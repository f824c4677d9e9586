//! What one run is: an experiment file with everything that it names, resolved.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::help::Helpful;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::behaviour::named::NamedBehaviour;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::controller::Reaction;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::other_profile::{OtherProfile, ProfilesDiffer};
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::tracker::Tracker;
use rsrs_files::quoted;
use rsrs_fleet::experiment::{ExperimentFile, SimulatedProfile, Time};
use rsrs_fleet::fleet_file::{CmdVel, Driver, FleetFile, FleetRobot, LeaseHolder};
use rsrs_fleet::geofence::Geofence;
use rsrs_fleet::parameters::{GateSettings, of_gate};
use rsrs_fleet::placement::{PlaceCheck, WantedStart};
use rsrs_fleet::record::{Backend, ExperimentRecord, RecordProvenance, pose_source, tracker};

mod controller;
mod profiles;
mod recording;
mod run_id;
mod starts;
mod swept;
mod trial;
mod world;

use profiles::{Measured, Profiles};
pub use recording::Recording;
use run_id::new_run_id;
pub use swept::{SweptCell, SweptCellError};
pub use trial::{TrialRequest, Unmeasured};

/// What a person asks for.
#[derive(Clone, Debug)]
pub struct Request {
    /// The experiment file.
    pub experiment: PathBuf,
    /// The cell, where the experiment file does not count.
    pub cell: Option<Cell>,
    /// Folder of a sweep; its chosen cell is run if no other one of it is named.
    pub from: Option<PathBuf>,
    /// What moves the robots.
    pub backend: Backend,
    /// Where the bag goes; named after the run in the current folder if not given.
    pub bag: Option<PathBuf>,
    /// Seed of the simulated world, where the experiment file's does not count.
    pub seed: Option<u64>,
    /// Whether the operator is shown where the robots of a fleet stand before they move.
    pub place_check: PlaceCheck,
    /// What to do if the sweep of the cell is of robots with another profile.
    pub other_profile: OtherProfile,
}

/// One run, resolved.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What goes into the bag.
    pub record: ExperimentRecord,
    /// The robots of the run.
    pub robots: Vec<FleetRobot>,
    /// Where the bag goes.
    pub bag: PathBuf,
    /// The files that it was read from, by the name that they get in the bag.
    pub files: Vec<(String, String)>,
    /// Whether there is no run without poses.
    pub poses: Poses,
    /// Whether the operator is shown where the robots stand before they move.
    pub place_check: PlaceCheck,
    /// What is recorded besides the topics of every run.
    pub recording: Recording,
    /// What no robot must leave.
    pub geofence: Option<Geofence>,
    /// Greatest commands of the robots, by the fleet's profile, in m/s and rad/s.
    pub limits: [f64; 2],
    /// The same of robots with a profile of their own, by robot.
    pub own_limits: BTreeMap<String, [f64; 2]>,
    /// What the gates of its real robots must be set to, by robot.
    pub gates: BTreeMap<String, GateSettings>,
    /// Whether its profile is one; a robot that is about to be measured has a stand-in.
    pub is_measured: bool,
    /// The profile of the sweep that the cell is from, where somebody insists on another one.
    pub other_profile: Option<ProfilesDiffer>,
}

/// Whether the poses of the robots must be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Poses {
    /// Without them the bag cannot be labelled.
    Required,
    /// They are recorded where they are published: a trial is also measured with a tape.
    IfThere,
}

impl Plan {
    /// Reads an experiment file and all that it names.
    pub fn read(request: &Request) -> anyhow::Result<Self> {
        let (name, text) = read(&request.experiment)?;
        let mut experiment = ExperimentFile::parse(&name, &text).map_err(Helpful::from)?;
        let beside = request.experiment.parent().unwrap_or(Path::new(""));
        let (cell, swept) = cell(request, &experiment, beside)?;
        let starts = starts::read(&mut experiment.placement, beside)?;
        if let Some(NamedBehaviour::File(path)) = &experiment.behaviour {
            let (name, text) = read_named("behaviour", &beside.join(path), &name)?;
            let behaviour = Behaviour::parse(&name, &text).map_err(Helpful::from)?;
            experiment.behaviour = Some(NamedBehaviour::Known(behaviour));
        }
        let fleet_path = beside.join(&experiment.fleet);
        let (fleet_name, fleet_text) = read_named("fleet", &fleet_path, &name)?;
        let fleet = FleetFile::parse(&fleet_name, &fleet_text).map_err(Helpful::from)?;
        let of_fleet = Measured::of_fleet(&fleet, &fleet_path)?;
        let table = controller::read(
            &mut experiment,
            swept.as_ref(),
            (&request.experiment, &of_fleet.profile),
        )?;
        let world = world::read(&mut experiment, (&cell, swept.as_ref()), &request.experiment)?;
        let of_cell = || format!("cell `{cell}`");
        let mut settings = settings(&experiment, &cell, swept.as_ref()).with_context(of_cell)?;
        let first = Conditions::resolve(&of_fleet.profile, &settings).map_err(Helpful::from);
        let n_robots = match &starts {
            None => first?.robots,
            Some(table) => first.with_context(|| table.name.clone())?.robots,
        };
        let mut robots: Vec<FleetRobot> =
            fleet.first(n_robots).context(fleet_name.clone())?.into_iter().cloned().collect();
        as_simulated(request.backend, &mut robots);
        let names: Vec<String> = robots.iter().map(|robot| robot.name.clone()).collect();
        let profiles = Profiles::read(of_fleet, &robots, &fleet_path)?;
        profiles.check_classes(&robots, &settings.world).with_context(|| fleet_name.clone())?;
        let measured = &profiles.fleet.profile;
        starts.iter().try_for_each(|table| table.check(&robots))?;

        let Moved { time, factors, capabilities } =
            pace_and_factors(request.backend, &experiment, measured, swept.as_ref())?;
        settings.values.extend(capabilities);
        let conditions = profiles.conditions(&robots, factors, &settings)?;
        profiles.check_limits(&conditions.controller).with_context(of_cell)?;
        let run_id = new_run_id(&request.experiment)?;
        let backend = backend(request.backend, &robots);
        world::refuse_unordered(&names, &conditions).with_context(|| fleet_name.clone())?;
        world::refuse_objects(backend, &conditions).with_context(|| name.clone())?;
        refuse_sensors(backend, &robots, &conditions).with_context(|| fleet_name.clone())?;
        let record = ExperimentRecord {
            robots: names,
            provenance: RecordProvenance::new(&measured.digest(), &conditions),
            conditions,
            duration_s: experiment.duration_s,
            seed: request.seed.unwrap_or(experiment.seed),
            replicate: 0,
            robot_lost: experiment.robot_lost,
            controller_only: controller_only(backend, &robots),
            pose_source: Some(pose_source(backend, &robots).context(fleet_name.clone())?),
            tracker: tracker(backend, &robots).context(fleet_name)?,
            backend,
            time,
            run_id: run_id.clone(),
            gates: BTreeMap::new(),
            own_profiles: profiles.recorded(),
            fixed: None,
        };
        let profile_path = profiles.fleet.path.clone();
        let other_profile = admit(swept.as_ref(), &record, (request, profile_path))?;
        let geofence = geofence(&fleet, &fleet_path, &record)?;
        let bag = new_bag(request.bag.as_deref(), &run_id)?;
        let recording = Recording::read(&experiment.record, beside, &record.robots)?;
        Ok(Self {
            record,
            bag,
            files: profiles.with_files(
                [text, fleet_text],
                [
                    ("starts.csv", starts.map(|table| table.text)),
                    ("controller.yaml", table),
                    ("world.yaml", world),
                ],
            ),
            poses: Poses::Required,
            place_check: request.place_check,
            recording,
            limits: limits(measured),
            own_limits: profiles.own_limits(),
            geofence,
            gates: gates(backend, &robots, |robot| Some(profiles.of(robot))),
            robots,
            is_measured: true,
            other_profile,
        })
    }

    /// Steps of the run.
    pub fn steps(&self) -> u64 {
        self.record.conditions.steps(self.record.duration_s)
    }

    /// What its controllers must make of their sensors: nothing in a trial, which is the only run that
    /// needs no poses.
    pub fn reaction(&self) -> Reaction {
        match self.poses {
            Poses::Required => Reaction::ToDetections,
            Poses::IfThere => Reaction::Constant,
        }
    }

    /// Whether the simulator stands in for a robot of this run.
    pub fn is_virtual(&self, robot: &FleetRobot) -> bool {
        !self.record.backend.is_real(robot)
    }

    /// That keys of the fleet file are not used, if there are any.
    pub fn unused_keys(&self) -> Option<String> {
        unused_keys(&self.robots)
    }

    /// Greatest commands of a robot of this run, in m/s and rad/s.
    pub fn limits_of(&self, robot: &str) -> [f64; 2] {
        self.own_limits.get(robot).copied().unwrap_or(self.limits)
    }

    /// Who holds the lease of a robot of this run.
    pub fn lease_of(&self, robot: &str) -> LeaseHolder {
        if self.record.controller_only.iter().any(|other| other == robot) {
            LeaseHolder::Controller
        } else {
            LeaseHolder::Gate
        }
    }

    /// Where the real robots' poses come from, by which the simulator follows them in a mixed fleet.
    ///
    /// # Panics
    ///
    /// Never: the plan of a run states it.
    pub fn tracked_by(&self) -> PoseSource {
        self.record.pose_source.expect("the plan of a run states it")
    }
}

/// The settings of a cell: what the experiment file gives, and for the rest those of the sweep that the
/// cell is from.
fn settings(
    experiment: &ExperimentFile,
    cell: &Cell,
    swept: Option<&SweptCell>,
) -> anyhow::Result<Settings> {
    let mut settings = experiment.settings(cell)?;
    let named = experiment.behaviour.as_ref().map(NamedBehaviour::known);
    settings.behaviour = named.unwrap_or_default();
    if let Some(SweptCell { operator_conditions, .. }) = swept {
        settings.behaviour = named.unwrap_or(operator_conditions.behaviour);
        settings.walls = operator_conditions.arena.walls;
        let is_square = operator_conditions.world.arena.is_none();
        if is_square && cell.get(Axis::Arena).is_none() {
            settings.values.push((Axis::Arena, operator_conditions.arena.side_m));
        }
        settings.world = operator_conditions.world.clone();
    }
    Ok(settings)
}

/// Refuses a run that could not be compared with the sweep that its cell is from; admits robots
/// with another profile if somebody insists.
fn admit(
    swept: Option<&SweptCell>,
    record: &ExperimentRecord,
    (request, profile): (&Request, PathBuf),
) -> anyhow::Result<Option<ProfilesDiffer>> {
    let Some(swept) = swept else { return Ok(None) };
    let name = || format!("{} could not be compared with the sweep", request.experiment.display());
    swept.operator_conditions.admit(&record.operator_conditions()).with_context(name)?;
    let found = &record.provenance.profile_digest;
    let admitted = request.other_profile.admit(&swept.profile_digest, found);
    let help = ProfilesDiffer::help(&profile.display().to_string());
    admitted.map_err(|differ| Helpful::new(differ.to_string(), help)).with_context(name)
}

/// Where the bag goes, which must not be there yet.
fn new_bag(wanted: Option<&Path>, run_id: &str) -> anyhow::Result<PathBuf> {
    let bag = wanted.unwrap_or(Path::new(run_id));
    if bag.exists() {
        bail!("{} exists already; give another folder for the bag", bag.display());
    }
    Ok(bag.to_owned())
}

/// What the gates of the robots must be set to; the simulator's have no such settings, and a robot whose
/// lease is its controller's has none of ours.
fn gates<'a>(
    backend: Backend,
    robots: &[FleetRobot],
    profile: impl Fn(&str) -> Option<&'a RobotProfile>,
) -> BTreeMap<String, GateSettings> {
    let has_gate = |robot: &&FleetRobot| {
        backend != Backend::Simulator
            && robot.driver != Driver::Virtual
            && robot.lease == LeaseHolder::Gate
    };
    let of_robot = |robot: &FleetRobot| (robot.name.clone(), of_gate(robot, profile(&robot.name)));
    robots.iter().filter(has_gate).map(of_robot).collect()
}

/// What no robot of the run must leave, and where none must start.
fn geofence(
    fleet: &FleetFile,
    path: &Path,
    record: &ExperimentRecord,
) -> anyhow::Result<Option<Geofence>> {
    let geofence = fleet.geofence.filter(|_| record.backend != Backend::Simulator);
    let start = WantedStart::new(&record.conditions, record.replicate);
    let checked = geofence.map_or(Ok(()), |geofence| geofence.check_start(&start));
    checked.with_context(|| path.display().to_string())?;
    Ok(geofence)
}

/// Greatest commands of a robot, in m/s and rad/s.
fn limits(profile: &RobotProfile) -> [f64; 2] {
    [profile.actuation.speed.limits_m_s[1], profile.actuation.turn.limits_rad_s[1]]
}

/// The cell to run, and the swept one that it is held against, if there is one.
fn cell(
    request: &Request,
    experiment: &ExperimentFile,
    beside: &Path,
) -> anyhow::Result<(Cell, Option<SweptCell>)> {
    if let Some(folder) = &request.from {
        let swept = SweptCell::find(folder, request.cell.as_ref())?;
        return Ok((swept.cell.clone(), Some(swept)));
    }
    if let Some(cell) = &request.cell {
        if let Some(from) = &experiment.from {
            // Whether it is a cell of that sweep is not stated.
            let twice = format!(
                "{}: its cell is `from` a sweep, and the cell `{cell}` is asked for, expected one of \
                 them",
                request.experiment.display()
            );
            let help = format!(
                "`--from {}` (`from:` in a campaign) runs that cell of the sweep; without `from:` in \
                 the experiment file it is run on its own",
                quoted(beside.join(from))
            );
            return Err(Helpful::new(twice, help).into());
        }
        return Ok((cell.clone(), None));
    }
    match (&experiment.cell, &experiment.from) {
        (Some(cell), _) => Ok((cell.clone(), None)),
        (None, Some(from)) => {
            let swept = SweptCell::find(&beside.join(from), None)?;
            Ok((swept.cell.clone(), Some(swept)))
        }
        (None, None) => bail!(
            "{}: neither `cell` nor `from`, expected one of them here or on the command line",
            request.experiment.display()
        ),
    }
}

/// What is moved, and how fast.
struct Moved {
    time: Time,
    /// By what robots are worse than they were measured; `None` if they are moved as they were.
    factors: Option<HarsherFactors>,
    /// Capabilities of the robots in the cell of the sweep, where it has any.
    capabilities: Vec<(Axis, f64)>,
}

/// The pace of the run, and by what its robots are made worse.
fn pace_and_factors(
    backend: Backend,
    experiment: &ExperimentFile,
    measured: &RobotProfile,
    swept: Option<&SweptCell>,
) -> anyhow::Result<Moved> {
    let time = match backend {
        Backend::Fleet | Backend::Mixed => Time::RealTime,
        Backend::Simulator => experiment.simulator.time,
    };
    let is_simulated = backend == Backend::Simulator;
    if is_simulated && experiment.simulator.profile == SimulatedProfile::Harsher {
        let usual = || HarsherFactors::for_robot(measured);
        let factors = swept.map_or_else(usual, |swept| swept.factors);
        let capabilities = swept.map(|swept| swept.capabilities.clone()).unwrap_or_default();
        return Ok(Moved { time, factors: Some(factors), capabilities });
    }
    swept.map_or(Ok(()), SweptCell::check_measured).map_err(Helpful::from)?;
    Ok(Moved { time, factors: None, capabilities: Vec::new() })
}

/// Robots whose lease is their controller's only; where the simulator stands in, it has a gate.
fn controller_only(backend: Backend, robots: &[FleetRobot]) -> Vec<String> {
    let is_alone = |robot: &&FleetRobot| {
        backend != Backend::Simulator && robot.lease == LeaseHolder::Controller
    };
    robots.iter().filter(is_alone).map(|robot| robot.name.clone()).collect()
}

/// That keys of virtual robots are not used, as the simulator publishes their poses.
fn unused_keys(robots: &[FleetRobot]) -> Option<String> {
    let is_asked = |robot: &&FleetRobot| {
        let has_keys = robot.pose != PoseSource::default()
            || robot.tracker != Tracker::default()
            || robot.body.is_some();
        robot.driver == Driver::Virtual && has_keys
    };
    let asked: Vec<&str> =
        robots.iter().filter(is_asked).map(|robot| robot.name.as_str()).collect();
    (!asked.is_empty()).then(|| {
        format!(
            "virtual, so their poses are the simulator's odometry, and `pose`, `tracker` and `body` of \
             the fleet file are not used: {}",
            asked.join(", ")
        )
    })
}

/// The robots of the simulator take commands with a stamp, which lockstep needs, whatever those do in whose place they are.
fn as_simulated(backend: Backend, robots: &mut [FleetRobot]) {
    if backend == Backend::Simulator {
        for robot in robots {
            robot.cmd_vel = CmdVel::TwistStamped;
        }
    }
}

/// A fleet some of whose robots are virtual and some are not is a mixed one.
///
/// One without any real robot, too: it is on a fleet's network, but moved by the simulator, which has to
/// be given its conditions.
fn backend(asked: Backend, robots: &[FleetRobot]) -> Backend {
    let has_virtual = robots.iter().any(|robot| robot.driver == Driver::Virtual);
    if asked == Backend::Fleet && has_virtual { Backend::Mixed } else { asked }
}

/// What real robots would detect of virtual ones is known for one plain sensor.
fn refuse_sensors(
    backend: Backend,
    robots: &[FleetRobot],
    conditions: &Conditions,
) -> anyhow::Result<()> {
    let is_real = |robot: &FleetRobot| robot.driver != Driver::Virtual;
    let is_mixed = robots.iter().any(is_real) && !robots.iter().all(is_real);
    if backend != Backend::Simulator && is_mixed && !conditions.have_one_plain_sensor() {
        bail!(
            "real and virtual robots meet in this fleet, and their sensor is not plain, expected one that \
             detects robots ahead, whatever stands in between"
        );
    }
    Ok(())
}

fn read(path: &Path) -> anyhow::Result<(String, String)> {
    let name = path.display().to_string();
    let text = rsrs_files::read_text(path).with_context(|| format!("cannot read {name}"))?;
    Ok((name, text))
}

/// Reads a file that a key of the experiment names, for which a person looks where the key is.
fn read_named(key: &str, path: &Path, experiment: &str) -> anyhow::Result<(String, String)> {
    read(path).with_context(|| format!("{experiment}: the file that `{key}` names cannot be read"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_for_a_tracker_are_not_used_for_virtual_robots() {
        let sources = [PoseSource::Pose, PoseSource::Odom, PoseSource::Pose];

        assert_eq!(unused_keys(&robots(sources, 0)), None);
        let note = unused_keys(&robots(sources, 2)).unwrap();
        assert!(note.ends_with("of the fleet file are not used: robot_0"), "{note}");
    }

    fn robots(poses: [PoseSource; 3], n_virtual: usize) -> Vec<FleetRobot> {
        let robot = |(index, pose): (usize, PoseSource)| FleetRobot {
            name: format!("robot_{index}"),
            enabled: true,
            profile: Some("flockbot.yaml".to_owned()),
            driver: if index < n_virtual { Driver::Virtual } else { Driver::Ros },
            cmd_vel: CmdVel::TwistStamped,
            pose,
            lease: LeaseHolder::Gate,
            battery_min_v: None,
            detection_threshold_m: None,
            tracker: Tracker::default(),
            body: None,
        };
        poses.into_iter().enumerate().map(robot).collect()
    }

    #[test]
    fn a_fleet_with_virtual_robots_among_real_ones_is_mixed() {
        let asked = |n_virtual| backend(Backend::Fleet, &robots([PoseSource::Odom; 3], n_virtual));

        assert_eq!(asked(0), Backend::Fleet);
        assert_eq!(asked(1), Backend::Mixed);
        assert_eq!(asked(2), Backend::Mixed);
        assert_eq!(asked(3), Backend::Mixed, "a simulator moves all of them");
        let simulated = backend(Backend::Simulator, &robots([PoseSource::Odom; 3], 1));
        assert_eq!(simulated, Backend::Simulator, "then the simulator is all of them");
    }

    #[test]
    fn where_the_simulator_stands_in_no_lease_is_the_controllers() {
        let mut robots = robots([PoseSource::Odom; 3], 1);
        robots[2].lease = LeaseHolder::Controller;

        assert_eq!(controller_only(Backend::Mixed, &robots), ["robot_2"]);
        assert_eq!(controller_only(Backend::Simulator, &robots), Vec::<String>::new());
    }

    #[test]
    fn all_robots_of_a_run_have_poses_from_one_source() {
        use PoseSource::{Odom, Pose};

        let source = |backend, poses, n_virtual| pose_source(backend, &robots(poses, n_virtual));

        assert_eq!(source(Backend::Fleet, [Pose; 3], 0), Ok(Pose));
        assert_eq!(source(Backend::Mixed, [Odom, Pose, Pose], 1), Ok(Pose), "as the real ones do");
        assert_eq!(source(Backend::Mixed, [Pose; 3], 3), Ok(Odom), "there are no real ones");
        assert_eq!(source(Backend::Simulator, [Odom, Pose, Pose], 0), Ok(Odom));
        for (backend, n_virtual) in [(Backend::Fleet, 0), (Backend::Mixed, 1)] {
            let error = source(backend, [Odom, Odom, Pose], n_virtual).unwrap_err();
            let text =
                "come from `odom` and those of robot_2 from `pose`, expected one `pose:` for all";
            assert!(error.to_string().contains(text), "{error}");
        }
    }

    #[test]
    fn a_run_has_one_tracker_and_virtual_robots_none_that_the_simulator_cannot_follow() {
        use PoseSource::{NamedPoses, Pose};

        let of = |backend, robots: &[FleetRobot]| tracker(backend, robots);
        let mut named = robots([NamedPoses; 3], 0);
        named[1].body = Some("RigidBody 2".to_owned());
        let mut differing = robots([Pose; 3], 0);
        differing[2].tracker.frame.scale = 0.001;
        let mut moved = robots([Pose; 3], 1);
        moved[2].body = Some("R".to_owned());

        assert_eq!(of(Backend::Fleet, &robots([Pose; 3], 0)), Ok(None), "they are as they come");
        let found = of(Backend::Fleet, &named).unwrap().unwrap();
        assert_eq!(found.body_of("robot_1"), "RigidBody 2");
        assert_eq!(of(Backend::Simulator, &named), Ok(None));
        let several = of(Backend::Fleet, &differing).unwrap_err().to_string();
        assert!(several.starts_with("robot_0 and robot_2 have a `tracker` each"), "{several}");
        let unfollowed = of(Backend::Mixed, &moved).unwrap_err().to_string();
        assert!(unfollowed.contains("and a `tracker` or `body`, expected `odom`"), "{unfollowed}");
        assert!(of(Backend::Mixed, &robots([NamedPoses; 3], 1)).is_err());
        let mut unnamed = robots([PoseSource::PoseArray; 3], 0);
        for robot in &mut unnamed {
            robot.tracker.names = ["robot_0", "box", "robot_2"].map(str::to_owned).to_vec();
        }
        let unnamed = of(Backend::Fleet, &unnamed).unwrap_err().to_string();
        assert!(unnamed.contains("have no `robot_1`, only robot_0, box, robot_2"), "{unnamed}");
        assert_eq!(of(Backend::Mixed, &robots([NamedPoses; 3], 3)), Ok(None), "none is real");
    }
}
