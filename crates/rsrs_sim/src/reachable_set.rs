//! Step 2 of the method: the simulated reach under the commands that were sent, and whether real
//! trajectories lie in it.
//!
//! Simulated robots drive every sequence of commands of the trials, one sequence after the other as
//! real ones do, each as often as a real robot drove it. Half of them show where simulated robots
//! can be; the other half calibrate how far from them is far: the region at a time is where no more
//! than 1 % of simulated robots would be further out. So the region holds 99 % of simulated robots
//! whatever its shape (a point, a line, a banana, a ring). As many robots again, which no region was
//! made from, show how often simulated robots leave it. All keep the gains of one robot through all
//! of its trials.
//!
//! Where a real robot has pushed an object, the simulated ones push one of the world's that begins at
//! the same place before them, and the object has regions, too: a trial is inside if both are.
//!
//! # Source
//!
//! `eq:simulatorreq`. The score is the distance to the k-th nearest neighbour; its calibration on
//! held out draws is split conformal prediction: J. Lei, M. G'Sell, A. Rinaldo, R. J. Tibshirani,
//! L. Wasserman, "Distribution-free predictive inference for regression", JASA 113, 2018.

use std::collections::BTreeMap;

use rsrs_core::conditions::{Conditions, ConditionsError, Settings, Walls};
use rsrs_core::help::Help;
use rsrs_core::out_of_range::OutOfRange;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::harsher::NotHarsher;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::sensor::{Detects, SensorDetails};
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::trials::trial::{DrivenSample, DrivenTrial};
use rsrs_core::trials::validation::Validation;
use rsrs_core::world::{ObjectGroup, WorldFile};

use crate::draw::Seed;
use crate::placement::PlacementError;
use crate::world::World;
use regions::Regions;

pub use factors::{SmallestFactors, smallest_factors};

mod drive;
mod factors;
mod judgement;
mod outline;
mod region;
mod regions;

/// How reach is simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachOptions {
    /// Simulated robots, 200 or more: half for the region, half to calibrate it. As many again show
    /// how often robots leave it.
    pub n_robots: usize,
    /// Share of the simulated robots that each region holds, above 0.5 and below 1.
    pub share: f64,
    /// Times at which regions are made, evenly spaced over the longest trial of its kind.
    pub n_horizons: usize,
    /// How far measured positions may be off, in metres.
    pub tolerance_m: f64,
    /// How far measured headings may be off, in radians.
    pub tolerance_rad: f64,
    /// Seed of the simulated robots, below 2^63.
    pub seed: u64,
}

impl Default for ReachOptions {
    fn default() -> Self {
        Self {
            n_robots: 2000,
            share: 0.99,
            n_horizons: 10,
            tolerance_m: 0.005,
            tolerance_rad: 0.01,
            seed: 1,
        }
    }
}

/// Why trajectories cannot be held against a simulator.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReachError {
    /// There is nothing to hold against it.
    #[error("no trajectories, expected 1 or more")]
    NoTrials,
    /// An option outside what it can mean.
    #[error(transparent)]
    Option(#[from] OutOfRange),
    /// A trial that is over before a robot decides twice.
    #[error(
        "trial `{trial}` of {robot} lasts {duration_s} s, expected two control periods of {period_s} s or more"
    )]
    TooShort {
        /// The robot.
        robot: String,
        /// The trial.
        trial: String,
        /// Its duration, in seconds.
        duration_s: f64,
        /// The control period, in seconds.
        period_s: f64,
    },
    /// A trial in which an object is pushed, and a world without any.
    #[error("trial `{trial}` of {robot} has an object, and the world has none")]
    NoObject {
        /// The robot.
        robot: String,
        /// The trial.
        trial: String,
    },
    /// An object that begins in the robot.
    #[error(
        "trial `{trial}` of {robot} begins with its object {apart_m:.3} m from the robot, expected the radii of both, \
         {touching_m:.3} m, or more"
    )]
    Overlap {
        /// The robot.
        robot: String,
        /// The trial.
        trial: String,
        /// How far apart the two centres are, in metres.
        apart_m: f64,
        /// At how much they touch, in metres.
        touching_m: f64,
    },
    /// An object that goes where no robot pushes it.
    #[error(
        "the object of trial `{trial}` of {robot} goes {object_m:.3} m, and the robot {robot_m:.3} m, which cannot \
         have pushed it"
    )]
    NotPushed {
        /// The robot.
        robot: String,
        /// The trial.
        trial: String,
        /// How far the object is from its start, in metres.
        object_m: f64,
        /// How far the robot drives, in metres.
        robot_m: f64,
    },
    /// Objects to push, of which nobody knows which.
    #[error("the objects of the world are not all alike, and trials have one each")]
    ObjectsDiffer,
    /// Robots that would never push what was pushed.
    #[error("trials have an object, and the simulated robots pass through objects")]
    PassesThrough,
    /// The robot cannot be simulated.
    #[error(transparent)]
    Conditions(#[from] ConditionsError),
    /// The robot cannot be placed.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// Factors that would make a better robot.
    #[error(transparent)]
    NotHarsher(#[from] NotHarsher),
}

impl Help for ReachError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::NoObject { .. } => {
                "name a world in the sweep whose `objects` are as that one, or leave these trials out"
            }
            Self::Overlap { .. } => {
                "give the world's object its `radius_m`, and places of centres, in metres"
            }
            Self::NotPushed { .. } => {
                "give all places in metres and in one frame, and leave trials out in which a tracker took the object \
                 for another"
            }
            Self::ObjectsDiffer => {
                "name a world in the sweep that has objects of one radius, friction and weight"
            }
            Self::PassesThrough => "set `body.contact` in the profile to `push` or `stop`",
            _ => return None,
        };
        Some(help.to_owned())
    }
}

/// Trials under the same commands; of those with an object each is of a kind of its own.
struct Kind<'a> {
    /// The longest of them; its commands are sent.
    longest: &'a DrivenTrial,
    horizons_s: Vec<f64>,
    /// Most trials of one robot.
    n_repeats: usize,
}

/// One robot's displacement since a start, at each horizon; shape `[n_horizons]`.
type Path = Vec<Pose>;

/// Where one drive took the robot, and the object if there is one; shape `[n_bodies]`.
type Moved = Vec<Path>;

/// What one simulated robot drove; shape `[n_kinds][n_repeats]`.
type Drives = Vec<Vec<Moved>>;

/// Holds real trajectories, one or more, against the reach of the simulated robot: the measured
/// profile with the sweep's factors applied.
///
/// Of the sweep's fixed values, speed, turning rate, number of robots and walls are not taken,
/// because trials drive alone under their own commands. Robots of the simulated population are
/// refused ([`Validation::is_contained`] is false) with a probability of at most 5 %, because what
/// is compared is how many trials of how many robots leave, and the simulated robots show how often
/// that happens to them.
pub fn validate(
    robot: &RobotProfile,
    settings: &Settings,
    trials: &[DrivenTrial],
    options: &ReachOptions,
) -> Result<Validation, ReachError> {
    check(options)?;
    let (kinds, kind_of) = kinds(trials, options, robot.computation.period_s)?;
    let conditions = conditions(robot, settings, trials, options)?;
    let driver = drive::Driver::new(robot, &conditions, options);
    let mut simulated = Vec::with_capacity(2 * options.n_robots);
    for replicate in 0..2 * options.n_robots as u64 {
        let seed = Seed { seed: options.seed, replicate };
        let mut world = World::new(&conditions, seed)?;
        simulated.push(driver.all(&mut world, &kinds, seed));
    }
    let (of_regions, fresh) = simulated.split_at(options.n_robots);
    let (reference, calibration) = of_regions.split_at(options.n_robots / 2);
    let of_kind = |kind: usize| {
        let n_bodies = reference[0][kind][0].len();
        (0..n_bodies).map(move |body| Regions::new((kind, body), reference, calibration, options))
    };
    let regions: Vec<Vec<Regions>> = (0..kinds.len()).map(|kind| of_kind(kind).collect()).collect();
    let places = judgement::places(trials, &kinds, &kind_of, &regions);
    let tubes = judgement::tubes(trials, &kinds, &regions, &places);
    let chances = judgement::chances(trials, &kind_of, fresh, |moved, kind| {
        regions[kind].iter().zip(moved).all(|(regions, path)| regions.contain(path))
    });
    Ok(judgement::summary(places, tubes, &chances, options.share))
}

fn check(options: &ReachOptions) -> Result<(), ReachError> {
    let refuse = |name, found, expected: &'static str| {
        Err(OutOfRange { name, found, expected: expected.into() }.into())
    };
    if options.n_robots < 200 {
        return refuse("the number of simulated robots", options.n_robots as f64, "200 or more");
    }
    if !(options.share > 0.5 && options.share < 1.0) {
        return refuse("the share of a region", options.share, "above 0.5 and below 1");
    }
    if options.n_horizons == 0 {
        return refuse("the number of horizons", 0.0, "1 or more");
    }
    for (name, found) in [
        ("the tolerance of positions in m", options.tolerance_m),
        ("the tolerance of headings in rad", options.tolerance_rad),
    ] {
        if !(found > 0.0 && found.is_finite()) {
            return refuse(name, found, "a number above 0");
        }
    }
    Ok(())
}

/// Sorts trials by their commands and, roughly, by their duration, so that every trial reaches at
/// least the middle of the horizons of its kind.
fn kinds<'a>(
    trials: &'a [DrivenTrial],
    options: &ReachOptions,
    period_s: f64,
) -> Result<(Vec<Kind<'a>>, Vec<usize>), ReachError> {
    let mut members: BTreeMap<(Option<usize>, Vec<u64>), Vec<usize>> = BTreeMap::new();
    for (index, trial) in trials.iter().enumerate() {
        let duration_s = trial.duration_s();
        if duration_s < 2.0 * period_s {
            let (robot, trial) = (trial.robot.clone(), trial.trial.clone());
            return Err(ReachError::TooShort { robot, trial, duration_s, period_s });
        }
        let own = trial.object_start_m().map(|_| index);
        members.entry((own, signature(trial))).or_default().push(index);
    }
    let mut kinds = Vec::new();
    let mut kind_of = vec![0; trials.len()];
    for indices in members.into_values() {
        let mut by_robot: BTreeMap<&str, usize> = BTreeMap::new();
        for index in &indices {
            kind_of[*index] = kinds.len();
            *by_robot.entry(&trials[*index].robot).or_default() += 1;
        }
        let longest = indices
            .iter()
            .map(|index| &trials[*index])
            .max_by(|left, right| left.duration_s().total_cmp(&right.duration_s()))
            .ok_or(ReachError::NoTrials)?;
        let n = options.n_horizons;
        let horizon_s = |step: usize| longest.duration_s() * (step + 1) as f64 / n as f64;
        let n_repeats = by_robot.into_values().max().unwrap_or(1);
        kinds.push(Kind { longest, horizons_s: (0..n).map(horizon_s).collect(), n_repeats });
    }
    if kinds.is_empty() { Err(ReachError::NoTrials) } else { Ok((kinds, kind_of)) }
}

/// What trials of one kind have in common: a constant command, or all of them with their times.
fn signature(trial: &DrivenTrial) -> Vec<u64> {
    let bits = |command: Command| [command.speed_m_s, command.turn_rate_rad_s].map(f64::to_bits);
    let mut signature = bits(trial.samples[0].command).to_vec();
    signature.push(libm::log2(trial.duration_s()).floor().to_bits());
    // Those from a standstill are others than those that were going.
    signature.push(u64::from(trial.going_s > 0.0));
    if trial.constant_command().is_none() {
        for sample in &trial.samples[..trial.samples.len() - 1] {
            signature.push((sample.time_s - trial.samples[0].time_s).to_bits());
            signature.extend(bits(sample.command));
        }
    }
    signature
}

/// One robot without walls, with an object if any trial has one; its gains are those at the first trial's command,
/// and the driver converts the others to it.
fn conditions(
    robot: &RobotProfile,
    settings: &Settings,
    trials: &[DrivenTrial],
    options: &ReachOptions,
) -> Result<Conditions, ReachError> {
    let command = trials[0].samples[0].command;
    let world = world(robot, settings, trials, options)?;
    // Robots drive as the trials did, whatever their controller would do.
    let mut values = settings.values.clone();
    values.retain(|(axis, _)| !matches!(axis, Axis::Number(_)));
    values.extend([
        (Axis::Speed, command.speed_m_s.abs()),
        (Axis::TurnRate, command.turn_rate_rad_s.abs()),
        (Axis::Robots, 1.0),
    ]);
    let settings = Settings { values, walls: Walls::None, world, ..Settings::default() };
    Ok(Conditions::resolve(&alone(robot), &settings)?)
}

/// One of the world's objects, if any trial has one.
fn world(
    robot: &RobotProfile,
    settings: &Settings,
    trials: &[DrivenTrial],
    options: &ReachOptions,
) -> Result<WorldFile, ReachError> {
    let Some(pushes) = trials.iter().find(|trial| trial.object_start_m().is_some()) else {
        return Ok(WorldFile::NOTHING);
    };
    let one = |group: &ObjectGroup| ObjectGroup { count: Some(1), places_m: None, ..group.clone() };
    let mut groups = settings.world.objects.iter().map(one);
    let Some(group) = groups.next() else {
        let (robot, trial) = (pushes.robot.clone(), pushes.trial.clone());
        return Err(ReachError::NoObject { robot, trial });
    };
    if groups.any(|other| other != group) {
        return Err(ReachError::ObjectsDiffer);
    }
    if robot.body.contact == ContactModel::None {
        return Err(ReachError::PassesThrough);
    }
    for trial in trials {
        check_object(trial, robot.body.radius_m + group.radius_m, options)?;
    }
    Ok(WorldFile { objects: vec![group], ..WorldFile::NOTHING })
}

/// Whether the object of a trial, if it has one, can be one that its robot pushes.
fn check_object(
    trial: &DrivenTrial,
    touching_m: f64,
    options: &ReachOptions,
) -> Result<(), ReachError> {
    let Some([ahead_m, left_m]) = trial.object_start_m() else { return Ok(()) };
    let (robot, name) = (trial.robot.clone(), trial.trial.clone());
    let apart_m = libm::hypot(ahead_m, left_m);
    if apart_m < touching_m - 2.0 * options.tolerance_m {
        return Err(ReachError::Overlap { robot, trial: name, apart_m, touching_m });
    }
    let apart = |one: [f64; 2], other: [f64; 2]| libm::hypot(one[0] - other[0], one[1] - other[1]);
    let place = |sample: &DrivenSample| [sample.pose.x_m, sample.pose.y_m];
    let robot_m: f64 =
        trial.samples.windows(2).map(|pair| apart(place(&pair[0]), place(&pair[1]))).sum();
    let start_m = trial.samples[0].object_m.unwrap_or_default();
    let places_m = trial.samples.iter().filter_map(|sample| sample.object_m);
    let object_m = places_m.map(|place_m| apart(place_m, start_m)).fold(0.0, f64::max);
    // What rolls off goes on by a part of a radius.
    if object_m > robot_m + touching_m {
        return Err(ReachError::NotPushed { robot, trial: name, object_m, robot_m });
    }
    Ok(())
}

/// A robot that may be where nothing but robots is: its sensors, which move no robot that is driven, would be refused
/// if they were to detect anything else.
fn alone(robot: &RobotProfile) -> RobotProfile {
    let mut alone = robot.clone();
    let mut kinds = robot.sensors().flat_map(|(_, sensing)| sensing.details.kinds());
    if kinds.any(|kind| kind != Detects::Robot) {
        alone.sensing.details = SensorDetails::default();
        alone.further_sensors.clear();
    }
    alone
}
