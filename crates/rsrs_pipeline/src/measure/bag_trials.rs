//! Trials of single robots in bags: how they drove, how often they decided, and what they saw while
//! they stood.

use std::path::{Path, PathBuf};

use rsrs_bags::Bag;
use rsrs_bags::trajectory::{Needed, RecordedTrajectory};
use rsrs_core::conditions::Placement;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::trials::trial::{
    DetectionTrial, DrivenSample, DrivenTrial, MovedBy, Neighbour, PeriodTrial, SETTLING_TIME_S,
    TrialBackend, Trials, has_moved,
};
use rsrs_fleet::fleet_file::{Driver, FleetFile};
use rsrs_fleet::record::{Backend, ExperimentRecord};
use rsrs_msgs::topics;

use crate::error::{helped, with_help};
use crate::files::names;
use crate::measure::sensor_readings::{self, Readings};
use crate::measure::trial_window::intervals_s;
use crate::recorded_run::{self, PosesOfRun};

/// The trials of one bag.
#[derive(Clone, Debug, Default)]
pub struct BagTrials {
    /// Every robot's drives, from one standstill to the next.
    pub driven: Vec<DrivenTrial>,
    /// The same with the time in which the robot got going, from its standstill.
    pub from_rest: Vec<DrivenTrial>,
    /// Every robot's times from one detection to the next, in seconds.
    pub periods_s: Vec<(String, Vec<f64>)>,
    /// What the robot of a trial saw that stood in it.
    pub standing: Option<StaticSensorTrial>,
    /// What moved the robots; `None` in a bag that no runner of ours has made.
    pub backend: Option<TrialBackend>,
}

/// A robot that stood and sensed, as `rsrs measure drive --distance` and `--alone` make it.
#[derive(Clone, Debug)]
pub struct StaticSensorTrial {
    /// The robot.
    pub robot: String,
    /// Where another robot stood; `None` if it was alone.
    pub neighbour: Option<Neighbour>,
    /// All readings of its sensor.
    pub readings: Readings,
}

/// Whether a path is a bag's: a folder, or an `.mcap` file.
pub fn is_bag(path: &Path) -> bool {
    path.is_dir() || path.extension().is_some_and(|ending| ending == "mcap")
}

/// Reads the trials out of a bag: a rosbag2 folder or an `.mcap` file. Robots in it should drive
/// where nothing is in their way.
///
/// Where the run has classes of robots, `class` is the one whose trials are wanted; robots of
/// several profiles without one are refused.
pub fn read(path: &Path, class: Option<&str>) -> anyhow::Result<BagTrials> {
    let bag = recorded_run::open(path)?;
    let record = recorded_run::record_in(&bag)?;
    let backend = record.as_ref().map(|record| backend(&bag, record));
    if let Some(standing) = standing(&bag, record.as_ref())? {
        return Ok(BagTrials { standing: Some(standing), backend, ..BagTrials::default() });
    }
    let wanted = record.as_ref().map(|record| of_one_profile(path, record, class)).transpose()?;
    let is_wanted =
        |robot: &String| wanted.as_ref().is_none_or(|wanted| wanted.contains(&robot.as_str()));
    let poses = PosesOfRun::new(&bag, record.as_ref(), None)?;
    let recorded = poses.read(&bag, record.as_ref(), Needed::AllOfIt).map_err(|error| {
        let message = format!("{}: {error}", path.display());
        helped(error).context(message)
    })?;
    let n_objects = recorded.trajectory.n_objects;
    if n_objects > 1 && (0..n_objects).any(|object| moves(&recorded.trajectory, object)) {
        return Err(with_help(
            format!("{}: robots push objects, of which there are {n_objects}", path.display()),
            "take drives with one object",
        ));
    }
    let name = path.file_stem().map_or_else(String::new, |stem| stem.display().to_string());
    let drives = |part: fn(&[DrivenSample]) -> &[DrivenSample]| {
        let robots = (0..recorded.robots.len()).filter(|robot| is_wanted(&recorded.robots[*robot]));
        robots.flat_map(|robot| drives(&recorded, robot, &name, part)).collect()
    };
    let (driven, from_rest) = (drives(going), drives(|drive| drive));
    let periods_s = recorded
        .robots
        .iter()
        .filter(|robot| is_wanted(robot))
        .map(|robot| Ok((robot.clone(), periods(&bag, &recorded, robot)?)))
        .collect::<anyhow::Result<_>>()?;
    Ok(BagTrials { driven, from_rest, periods_s, standing: None, backend })
}

/// The robots of a run whose drives are trials of one profile: those of a class, or all where they are alike.
fn of_one_profile<'a>(
    path: &Path,
    record: &'a ExperimentRecord,
    class: Option<&str>,
) -> anyhow::Result<Vec<&'a str>> {
    let ExperimentRecord { robots, conditions, .. } = record;
    let all: Vec<&str> = robots.iter().map(String::as_str).collect();
    let classes = conditions.world.class_names_of(robots.len());
    if class.is_some() && !conditions.world.classes.is_empty() {
        let of_class = all.into_iter().zip(classes).filter(|(_, of)| *of == class);
        let of_class: Vec<&str> = of_class.map(|(robot, _)| robot).collect();
        if of_class.is_empty() {
            return Err(with_help(
                format!("{}: no robot is of class {}", path.display(), class.unwrap_or_default()),
                "leave this bag out, or name a class that it has",
            ));
        }
        return Ok(of_class);
    }
    let first = conditions.robot_at(0);
    let others = all.iter().enumerate().filter(|(place, _)| conditions.robot_at(*place) != first);
    let others: Vec<&str> = others.map(|(_, robot)| *robot).collect();
    if others.is_empty() {
        return Ok(all);
    }
    Err(with_help(
        format!(
            "{}: its robots are not alike: {} of another profile than {}",
            path.display(),
            match others.as_slice() {
                [other] => format!("{other} is"),
                _ => format!("{} are", others.join(", ")),
            },
            all[0]
        ),
        "give bags in which robots of one profile drive; of classes in a world, `rsrs validate --class NAME` takes \
         those of one",
    ))
}

/// What moved the robots of a run: the simulator also where one of them was virtual in a fleet.
fn backend(bag: &Bag, record: &ExperimentRecord) -> TrialBackend {
    let fleet = bag.attachment(FleetFile::NAME);
    let text = fleet.as_ref().and_then(|file| std::str::from_utf8(&file.data).ok());
    let fleet = text.and_then(|text| FleetFile::parse(FleetFile::NAME, text).ok());
    let robots = fleet.iter().flat_map(|fleet| &fleet.robots);
    let mut of_run = robots.filter(|robot| record.robots.contains(&robot.name));
    match record.backend {
        Backend::Simulator | Backend::Mixed => TrialBackend::Simulator,
        Backend::Fleet if of_run.any(|robot| robot.driver == Driver::Virtual) => {
            TrialBackend::Simulator
        }
        Backend::Fleet => TrialBackend::Fleet,
    }
}

/// What was sensed in a trial in which no robot was to move: of a run of ours that was set to no speed
/// and no turn.
fn standing(
    bag: &Bag,
    record: Option<&ExperimentRecord>,
) -> anyhow::Result<Option<StaticSensorTrial>> {
    let Some(record) = record else { return Ok(None) };
    let stands = record.conditions.controller.fastest() == Command::STOP;
    let (true, Some(robot)) = (stands, record.robots.first()) else {
        return Ok(None);
    };
    let neighbour = match record.conditions.placement {
        Placement::Pair { distance_m, bearing_rad } => Some(Neighbour { distance_m, bearing_rad }),
        Placement::DiscFacingOut { .. }
        | Placement::BoxFacingOut(_)
        | Placement::BoxFacingAnyWay(_)
        | Placement::Given { .. } => None,
    };
    let readings = sensor_readings::count(bag.path(), robot, None)?;
    Ok(Some(StaticSensorTrial { robot: robot.clone(), neighbour, readings }))
}

/// What was seen in several bags as one table; a row's `line` is its position, from 1. `None` if no
/// robot stood and sensed in any of them.
pub fn detection_table(bags: &[(PathBuf, BagTrials)]) -> Option<Trials<DetectionTrial>> {
    let standing =
        || bags.iter().filter_map(|(path, it)| Some((path, it.backend, it.standing.as_ref()?)));
    let paths: Vec<&PathBuf> = standing().map(|(path, ..)| path).collect();
    let mut table = empty_table(&paths);
    for (_, backend, StaticSensorTrial { robot, neighbour, readings }) in standing() {
        table.moved_by = table.moved_by + MovedBy::all(backend, 1);
        let line = table.rows.len() as u64 + 1;
        let robot = position(&mut table.robots, robot);
        let Readings { samples, detections } = *readings;
        let neighbour = *neighbour;
        table.rows.push(DetectionTrial { robot, line, neighbour, samples, detections });
    }
    (!table.rows.is_empty()).then_some(table)
}

fn empty_table<T>(paths: &[&PathBuf]) -> Trials<T> {
    Trials {
        file: names(paths),
        robots: Vec::new(),
        rows: Vec::new(),
        paused: Vec::new(),
        moved_by: MovedBy::default(),
    }
}

/// The position of a name, which is added if it is new.
fn position(robots: &mut Vec<String>, name: &str) -> usize {
    robots.iter().position(|known| known == name).unwrap_or_else(|| {
        robots.push(name.to_owned());
        robots.len() - 1
    })
}

/// The periods of several bags as one table; a row's `line` is its position, from 1. `None` if no
/// bag has detections.
pub fn period_table(bags: &[(PathBuf, BagTrials)]) -> Option<Trials<PeriodTrial>> {
    let paths: Vec<&PathBuf> = bags.iter().map(|(path, _)| path).collect();
    let mut table = empty_table(&paths);
    for (_, trials) in bags {
        for (name, periods_s) in &trials.periods_s {
            let robot = position(&mut table.robots, name);
            table.moved_by = table.moved_by + MovedBy::all(trials.backend, periods_s.len());
            for period_s in periods_s {
                let line = table.rows.len() as u64 + 1;
                table.rows.push(PeriodTrial { robot, line, period_s: *period_s });
            }
        }
    }
    (!table.rows.is_empty()).then_some(table)
}

/// Whether an object did not stay where it was.
fn moves(trajectory: &Trajectory, object: usize) -> bool {
    has_moved(trajectory.objects_m.iter().skip(object).step_by(trajectory.n_objects).copied())
}

/// One robot's drives: a part of what lies between one standstill and the next.
fn drives(
    recorded: &RecordedTrajectory,
    robot: usize,
    bag: &str,
    part: fn(&[DrivenSample]) -> &[DrivenSample],
) -> Vec<DrivenTrial> {
    let trajectory = &recorded.trajectory;
    let has_object = trajectory.n_objects == 1;
    let sample = |sample: usize| DrivenSample {
        time_s: sample as f64 * trajectory.period_s,
        pose: trajectory.poses_at(sample)[robot],
        command: trajectory.commands_at(sample)[robot],
        object_m: has_object.then(|| trajectory.objects_m[sample]),
    };
    let samples: Vec<DrivenSample> = (0..trajectory.n_samples()).map(sample).collect();
    let name = |drive: usize| if drive == 0 { bag.to_owned() } else { format!("{bag}:{drive}") };
    samples
        .split(|sample| sample.command == Command::STOP)
        .map(|whole| (whole, part(whole)))
        .filter(|(_, samples)| samples.len() >= 2)
        .enumerate()
        .map(|(drive, (whole, samples))| DrivenTrial {
            robot: recorded.robots[robot].clone(),
            trial: name(drive),
            going_s: samples[0].time_s - whole[0].time_s,
            samples: continuous(samples),
        })
        .collect()
}

/// A drive without the time in which the robot got going.
fn going(drive: &[DrivenSample]) -> &[DrivenSample] {
    let is_early = |sample: &DrivenSample| sample.time_s < drive[0].time_s + SETTLING_TIME_S;
    &drive[drive.partition_point(is_early)..]
}

/// Samples with headings that do not jump by a turn.
fn continuous(samples: &[DrivenSample]) -> Vec<DrivenSample> {
    let mut before_rad = samples[0].pose.heading_rad;
    let unwrapped = |sample: &DrivenSample| {
        let turns = ((sample.pose.heading_rad - before_rad) / std::f64::consts::TAU).round();
        before_rad = sample.pose.heading_rad - turns * std::f64::consts::TAU;
        DrivenSample { pose: Pose { heading_rad: before_rad, ..sample.pose }, ..*sample }
    };
    samples.iter().map(unwrapped).collect()
}

/// Times from one detection of a robot to the next while it was running, by the sender's stamps.
fn periods(bag: &Bag, recorded: &RecordedTrajectory, robot: &str) -> anyhow::Result<Vec<f64>> {
    let mut stamps_ns = Vec::new();
    for message in bag.messages_on([topics::DETECTION.for_robot(robot)]) {
        let message = match message {
            Ok(message) => message,
            // All that there is before the break has come.
            Err(rsrs_bags::BagError::Incomplete { .. }) => break,
            Err(error) => return Err(error.into()),
        };
        if recorded.window.contains(message.log_time_ns) {
            stamps_ns.push(message.publish_time_ns);
        }
    }
    Ok(intervals_s(&mut stamps_ns))
}
