//! From a profile and settings to conditions.

use std::collections::BTreeMap;

use super::check::Impossible;
use super::controller_table::{ControllerTable, TableFlaw};
use super::limits::BeyondLimits;
use super::own_robots::ClassChanges;
use super::{
    Arena, Conditions, GainDistribution, Placement, SimulatedRobot, SimulatedSensor, Walls,
};
use crate::document::{did_you_mean, nearest};
use crate::help::Help;
use crate::judge::behaviour::Behaviour;
use crate::quantity::{Axis, Bounds, Cell};
use crate::robot::controller::{Command, Controller, ControllerParameters};
use crate::robot::harsher::NotHarsher;
use crate::robot::profile::{ProfileError, RobotProfile};
use crate::robot::sensor::DETECTION;
use crate::world::WorldFile;

/// What a sweep or an experiment fixes besides the robots: settings that belong to `E`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Values by axis; of an axis that occurs twice the later one counts.
    pub values: Vec<(Axis, f64)>,
    /// What happens at the arena's border.
    pub walls: Walls,
    /// Where the robots start, if not in a disc of the radius among the values.
    pub placement: Option<Placement>,
    /// What the swarm is judged for.
    pub behaviour: Behaviour,
    /// The table of its controller, which has been checked; `None` for speeds and turning rates among the values.
    pub controller: Option<ControllerTable>,
    /// What is in the arena besides the robots.
    pub world: WorldFile,
    /// What is done to the profiles of the world's classes.
    pub class_changes: ClassChanges,
}

/// Why a profile and settings do not make conditions.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConditionsError {
    /// The robot is impossible.
    #[error(transparent)]
    Robot(#[from] ProfileError),
    /// The numbers together make no world.
    #[error(transparent)]
    Impossible(#[from] Impossible),
    /// A setting without which there is no experiment.
    #[error("no value for {0}")]
    Missing(Axis),
    /// A value outside what the axis can mean.
    #[error("{axis} is {found}, expected {expected}")]
    OutOfRange {
        /// The axis.
        axis: Axis,
        /// The value found.
        found: f64,
        /// What it may be.
        expected: String,
    },
    /// An axis that this robot does not have.
    #[error("{axis} does not apply to a robot {which}")]
    NotOfThisRobot {
        /// The axis.
        axis: Axis,
        /// What robots are that do not have it: `whose sensor is a cone`.
        which: &'static str,
    },
    /// A speed or turning rate beside a table that has them.
    #[error("{axis} is that of a controller without a table")]
    BesideTable {
        /// The axis.
        axis: Axis,
        /// The table's own numbers, as axes.
        numbers: Vec<String>,
    },
    /// A number that the controller's table does not have.
    #[error("{axis} is no number of the controller's table{}", did_you_mean(nearest.as_deref()))]
    NoSuchNumber {
        /// The axis.
        axis: Axis,
        /// The number closest in spelling, as an axis.
        nearest: Option<String>,
        /// All numbers of the table, as axes.
        numbers: Vec<String>,
    },
    /// A number of a table where there is none.
    #[error("{0} is a number of a controller's table, and none is named")]
    NoTable(Axis),
    /// A side of a square beside a world whose arena is none.
    #[error("`arena_m` is {side_m} m, and the world has an arena of its own, {arena}")]
    ArenaTwice {
        /// In metres.
        side_m: f64,
        /// The world's, in words.
        arena: String,
    },
    /// A table that these robots cannot follow.
    #[error(transparent)]
    Table(#[from] TableFlaw),
    /// A robot among others whose controller is told other things.
    #[error("its sensors report {found}, and those of the first robots {expected}")]
    OtherReadings {
        /// Names of its readings, in words.
        found: String,
        /// Those of the first robots.
        expected: String,
    },
    /// A robot among others for which the table is another controller.
    #[error(
        "its wheels make other commands of the controller's table than those of the first robots"
    )]
    OtherWheels,
    /// A robot whose body is not as large as those that it is judged and drawn with.
    #[error("the radius of its body is {found_m} m, and that of the other robots {expected_m} m")]
    OtherRadius {
        /// In metres.
        found_m: f64,
        /// Of the first robots, in metres.
        expected_m: f64,
    },
    /// A robot that was measured at another control period than it would have here.
    #[error("its control period is {found_s} s, and that of the other robots {expected_s} s")]
    OtherPeriod {
        /// In seconds.
        found_s: f64,
        /// Of the first robots, in seconds.
        expected_s: f64,
    },
    /// A command that its profile forbids.
    #[error(transparent)]
    Limits(#[from] BeyondLimits),
    /// Factors that would make a better robot of it.
    #[error(transparent)]
    NotHarsher(#[from] NotHarsher),
    /// A class of robots that are not for this swarm.
    #[error("class {class}, by its own profile{}: {source}", at(path.as_deref()))]
    OfClass {
        /// The class.
        class: String,
        /// Path of its profile as the world names it; `None` of a world that holds it.
        path: Option<String>,
        /// Why.
        source: Box<ConditionsError>,
    },
    /// A class whose profile was not read.
    #[error("the profile of class {class}, {path}, was not read")]
    ProfileNotRead {
        /// The class.
        class: String,
        /// As the world names it.
        path: String,
    },
}

/// The path of a file, behind what it holds.
fn at(path: Option<&str>) -> String {
    path.map_or_else(String::new, |path| format!(" {path}"))
}

impl Help for ConditionsError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::BesideTable { numbers, .. } | Self::NoSuchNumber { numbers, .. } => {
                return Some(match numbers.as_slice() {
                    [] => "its table has no `numbers`".to_owned(),
                    numbers => format!("the numbers of its table are: {}", numbers.join(", ")),
                });
            }
            Self::NoTable { .. } => "name its file: `controller: controllers/FILE.yaml`",
            Self::ArenaTwice { .. } => "leave `arena_m` out, or `arena` out of the world",
            Self::Table(flaw) => return flaw.help(),
            Self::Impossible(impossible) => return impossible.help(),
            Self::OtherReadings { .. } => "give its sensors the same names, in the same order",
            Self::OtherRadius { .. } => {
                "classes may differ in much, but contact and clusters are judged by one radius"
            }
            Self::OtherPeriod { .. } => "measure them at one control period, which their swarm has",
            Self::Limits(beyond) => return beyond.help(),
            Self::OfClass { source, .. } => return source.help(),
            _ => return None,
        };
        Some(help.to_owned())
    }
}

impl Conditions {
    /// Resolves a simulated robot, as measured or made harsher, and settings to numbers.
    ///
    /// Precedence is profile, then harsher (already in `robot`), then the settings in order: at
    /// least speed, turning rate and number of robots. Gain means are read at the commanded speed
    /// and turning rate.
    pub fn resolve(robot: &RobotProfile, settings: &Settings) -> Result<Self, ConditionsError> {
        settings.check_axes()?;
        let mut operator = BTreeMap::new();
        let (mut numbers, mut capabilities) = (Vec::new(), Vec::new());
        for (axis, value) in &settings.values {
            check_value(*axis, *value)?;
            if let Axis::Number(number) = axis {
                numbers.push((*number, *value));
            } else if axis.is_capability() {
                capabilities.push((*axis, *value));
            } else {
                operator.insert(*axis, *value);
            }
        }
        let robot = robot.with_capabilities(&capabilities)?;
        let set = |axis| operator.get(&axis).copied();
        let required = |axis| set(axis).ok_or(ConditionsError::Missing(axis));
        let controller = if let Some(table) = &settings.controller {
            table.check_values(&numbers)?;
            let (wheels, period_s) = (robot.actuation.wheels, robot.computation.period_s);
            table.resolve(&numbers, wheels, period_s)?.for_robots_with(robot.reading_names())
        } else {
            let detected = Command {
                speed_m_s: required(Axis::Speed)?,
                turn_rate_rad_s: required(Axis::TurnRate)?,
            };
            commands(detected, [Axis::UndetectedSpeed, Axis::UndetectedTurnRate].map(set))?.into()
        };
        if let (Some(side_m), Some(arena)) = (set(Axis::Arena), &settings.world.arena) {
            return Err(ConditionsError::ArenaTwice { side_m, arena: arena.in_words() });
        }
        let simulated = simulated_robot(&robot, &controller);
        let default_radius_m = PLACEMENT_OVER_RANGE * simulated.region.range_m();
        let mut conditions = Self {
            robots: required(Axis::Robots)? as usize,
            controller,
            behaviour: settings.behaviour,
            placement: settings.placement.clone().unwrap_or(Placement::DiscFacingOut {
                radius_m: set(Axis::PlacementRadius).unwrap_or(default_radius_m),
            }),
            arena: Arena {
                side_m: settings.world.side_m().or(set(Axis::Arena)).unwrap_or(ARENA_M),
                walls: settings.walls,
            },
            world: settings.world.clone(),
            robot: simulated,
            own_robots: BTreeMap::new(),
            period_s: robot.computation.period_s,
        };
        conditions.check()?;
        if conditions.world.classes.iter().any(|class| class.profile.is_some()) {
            conditions.put_classes(settings)?;
            conditions.check()?;
        }
        Ok(conditions)
    }
}

impl Settings {
    /// Whether its axes are those of its controller.
    pub fn check_axes(&self) -> Result<(), ConditionsError> {
        let axes = self.values.iter().map(|(axis, _)| *axis);
        axes.into_iter().try_for_each(|axis| check_axis(axis, self.controller.as_ref()))
    }
}

/// Whether an axis is one of a sweep with this table, or with none.
pub fn check_axis(axis: Axis, table: Option<&ControllerTable>) -> Result<(), ConditionsError> {
    let numbers =
        |table: &ControllerTable| table.axes().map(|axis| axis.key().to_owned()).collect();
    match (axis, table) {
        (Axis::Number(_), None) => Err(ConditionsError::NoTable(axis)),
        (Axis::Number(number), Some(table)) if !table.numbers.contains_key(number.name()) => {
            let nearest = nearest(axis.key(), table.axes().map(Axis::key)).map(str::to_owned);
            Err(ConditionsError::NoSuchNumber { axis, nearest, numbers: numbers(table) })
        }
        (
            Axis::Speed | Axis::TurnRate | Axis::UndetectedSpeed | Axis::UndetectedTurnRate,
            Some(table),
        ) => Err(ConditionsError::BesideTable { axis, numbers: numbers(table) }),
        _ => Ok(()),
    }
}

/// Robots start in a circle "slightly larger than their maximum vision distance" (§IV step 3).
pub const PLACEMENT_OVER_RANGE: f64 = 1.1;

/// Side of the arena where none is given, in metres: large enough never to be reached in a run.
pub const ARENA_M: f64 = 15.0;

/// The controller with this command where something is detected: mirrored, unless another speed or turning rate is
/// set where nothing is.
fn commands(
    detected: Command,
    undetected: [Option<f64>; 2],
) -> Result<ControllerParameters, ConditionsError> {
    let Command { speed_m_s, turn_rate_rad_s } = detected;
    if undetected == [None; 2] {
        check_bounds(Axis::Speed, speed_m_s, Bounds::AMOUNT)?;
        check_bounds(Axis::TurnRate, turn_rate_rad_s, Bounds::AMOUNT)?;
    }
    let undetected = Command {
        speed_m_s: undetected[0].unwrap_or(speed_m_s),
        turn_rate_rad_s: undetected[1].unwrap_or(-turn_rate_rad_s),
    };
    Ok(ControllerParameters::new(detected, undetected))
}

pub(super) fn simulated_robot(robot: &RobotProfile, controller: &Controller) -> SimulatedRobot {
    let (speed, turn) = (&robot.actuation.speed, &robot.actuation.turn);
    // One gain serves all commands: that of the fastest, which moves the robot most.
    let Command { speed_m_s, turn_rate_rad_s } = controller.fastest();
    let first = SimulatedSensor::new(DETECTION, &robot.sensing);
    SimulatedRobot {
        radius_m: robot.body.radius_m,
        front_half_angle_rad: robot.body.front_half_angle_rad,
        rotates_while_blocked: robot.body.rotates_while_blocked,
        contact: robot.body.contact,
        contact_friction: robot.body.contact_friction.unwrap_or_default(),
        speed_gain: GainDistribution {
            mean: speed.gain_at(speed_m_s).mean,
            robot_sd: speed.robot_sd,
            step_sd: speed.step_sd,
        },
        turn_gain: GainDistribution {
            mean: turn.gain_at(turn_rate_rad_s, speed_m_s).mean,
            robot_sd: turn.robot_sd,
            step_sd: turn.step_sd,
        },
        turn_bias_sd_rad_s: turn.bias_sd_rad_s,
        heading_noise_sd_rad: turn.heading_noise_sd_rad,
        gust_sd_m_s: robot.actuation.gust.sd_m_s,
        gust_time_constant_s: robot.actuation.gust.time_constant_s,
        yaw_lag_s: robot.actuation.yaw_lag_s,
        sees: first.sees,
        region: first.region,
        true_positive: first.true_positive,
        false_positive: first.false_positive,
        latency_steps: first.latency_steps,
        details: first.details,
        further_sensors: (robot.further_sensors.iter())
            .map(|sensor| SimulatedSensor::new(&sensor.name, &sensor.sensing))
            .collect(),
    }
}

impl Settings {
    /// The settings with the values of a cell on top.
    #[must_use]
    pub fn with_cell(&self, cell: &Cell) -> Self {
        let mut settings = self.clone();
        settings.values.extend(cell.iter());
        settings
    }
}

/// What changes the region of a sensor, in the order in which it does.
const OF_THE_REGION: [Axis; 4] =
    [Axis::PolygonScale, Axis::HalfAngle, Axis::Range, Axis::SensorBearing];

impl RobotProfile {
    /// The robot with other capabilities; of an axis that occurs twice the later value counts.
    ///
    /// The region of a sensor is scaled, opened, given its range and turned, in this order, whatever
    /// the order of the values. A cone that is turned becomes a polygon
    /// ([`crate::robot::shape::turned_cone`]).
    ///
    /// # Panics
    ///
    /// If an axis is a setting, as the speed is.
    pub fn with_capabilities(&self, values: &[(Axis, f64)]) -> Result<Self, ConditionsError> {
        let mut robot = self.clone();
        for (axis, value) in values {
            check_value(*axis, *value)?;
        }
        let others = values.iter().filter(|(axis, _)| !OF_THE_REGION.contains(axis));
        let of_the_region = OF_THE_REGION
            .iter()
            .filter_map(|wanted| values.iter().rev().find(|(axis, _)| axis == wanted));
        for (axis, value) in others.chain(of_the_region) {
            axis.set(&mut robot, *value)
                .map_err(|which| ConditionsError::NotOfThisRobot { axis: *axis, which })?;
        }
        robot.check()?;
        Ok(robot)
    }
}

/// Refuses a value outside what the axis can mean.
fn check_value(axis: Axis, found: f64) -> Result<(), ConditionsError> {
    check_bounds(axis, found, axis.bounds())
}

/// Refuses a value outside bounds.
fn check_bounds(axis: Axis, found: f64, bounds: Bounds) -> Result<(), ConditionsError> {
    let whole = !axis.is_count() || found.fract() == 0.0;
    if bounds.contains(found) && whole {
        return Ok(());
    }
    let kind = if axis.is_count() { "a whole number" } else { "a number" };
    Err(ConditionsError::OutOfRange { axis, found, expected: format!("{kind} {bounds}") })
}
