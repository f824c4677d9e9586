//! Whether conditions make a world: every number against what it can mean.

use super::{
    Conditions, Placement, ROBOT_NUMBERS, Sides, SimulatedRobot, StartsError, Walls, starts,
};
use crate::document::{did_you_mean, nearest};
use crate::help::Help;
use crate::quantity::{Axis, Bounds};
use crate::robot::controller::state_machine::StateMachine;
use crate::robot::controller::structure::{self, Flaw};
use crate::robot::controller::{Command, Controller, ControllerParameters};
use crate::robot::region::Region;
use crate::robot::sensor::file::SensorEntry;
use crate::robot::sensor::{self, Detects, MAX_CORNERS, Sensing, SensorFlaw, is_convex};
use crate::robot::unicycle::Pose;
use crate::world::{Object, ROUNDING, WorldFile, WorldFlaw};

/// Robots of a detection trial.
const PAIR: Bounds = Bounds { least: 0.0, most: 2.0 };

/// Why conditions make no world.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Impossible {
    /// A number lies outside what it can mean, or what single precision can take.
    #[error("{key} is {found}, expected a number from {least} to {most}")]
    Number {
        /// Dotted path of the key; its last part names the unit.
        key: &'static str,
        /// The number found.
        found: f64,
        /// The least that it may be.
        least: f64,
        /// The greatest that it may be.
        most: f64,
    },
    /// Robots cannot start where a table puts them.
    #[error(transparent)]
    Starts(#[from] StartsError),
    /// A robot that is not like the others cannot be.
    #[error("own_robots.{place}: {source}")]
    OwnRobot {
        /// Its place among all robots, from 0.
        place: usize,
        /// Why.
        source: Box<Impossible>,
    },
    /// A robot that is not like the others is none of the swarm.
    #[error("own_robots has one at {place}, and there are {robots} robots, counted from 0")]
    NoSuchRobot {
        /// Its place among all robots, from 0.
        place: usize,
        /// Robots of the swarm.
        robots: usize,
    },
    /// A controller's rows are no machine.
    #[error("controller.rows[{row}]: {source}")]
    Controller {
        /// The row, from 0.
        row: usize,
        /// Why.
        source: Flaw,
    },
    /// A sensor cannot be.
    #[error(transparent)]
    Sensor(#[from] SensorFlaw),
    /// A sensor of walls, objects, goals or classes where there are none.
    #[error("sensor `{name}` detects {}, and there are none", kind.all())]
    NothingToDetect {
        /// Name of its first reading.
        name: String,
        /// What there is nothing of.
        kind: Detects,
    },
    /// A controller's start of a class of robots that there is not.
    #[error(
        "controller.starts has class `{found}`, and no robot is of it{}", did_you_mean(nearest.as_deref())
    )]
    NoSuchClass {
        /// The class.
        found: String,
        /// The class closest in spelling.
        nearest: Option<String>,
    },
    /// What is in the arena besides robots cannot be, or not there.
    #[error(transparent)]
    World(#[from] WorldFlaw),
    /// A robot that a table puts into an object.
    #[error(
        "replicate {replicate}: robot {robot} starts at ({}, {}) m, where an object is at ({}, {}) m",
        place_m[0], place_m[1], object_m[0], object_m[1]
    )]
    StartsInObject {
        /// Number of the set of start poses, from 0.
        replicate: usize,
        /// Number of the robot, from 1.
        robot: usize,
        /// In metres.
        place_m: [f64; 2],
        /// In metres.
        object_m: [f64; 2],
    },
    /// A trial of two robots has nothing else.
    #[error("the placement is a pair, for a trial, and there are objects")]
    TrialWithObjects,
    /// A trial of two robots is on a floor without walls.
    #[error("the placement is a pair, for a trial, and the world has an arena or obstacles")]
    TrialWithWalls,
    /// Obstacles are walls.
    #[error("the world has obstacles, which are walls, and `walls` is none")]
    ObstaclesWithoutWalls,
    /// A controller for robots that report other things; with what they report.
    #[error("controller.sensors are not what the robots report: {0}")]
    Readings(String),
    /// The sensor's polygon is no region.
    #[error(
        "robot.region.polygon.corners_m has {0} corners, expected 3 to {MAX_CORNERS}, \
         convex and counterclockwise"
    )]
    Polygon(usize),
}

impl Help for Impossible {
    fn help(&self) -> Option<String> {
        match self {
            Self::NothingToDetect { kind: Detects::Wall, .. } => {
                Some("give the arena walls, `walls: stop`, or leave the sensor out".to_owned())
            }
            Self::NothingToDetect { kind: Detects::Kin | Detects::Other, .. } => Some(
                "name a world with `classes: [{name: a}, {name: b}]`, as in `world: world.yaml`, or \
                 leave the sensor out"
                    .to_owned(),
            ),
            Self::NothingToDetect { kind, .. } => Some(format!(
                "name a world with `{}s`, as in `world: world.yaml`, or leave the sensor out",
                kind.key()
            )),
            Self::NoSuchClass { found, .. } => Some(format!(
                "name a world with `classes: [{{name: {found}}}, …]`, or leave it out of `starts`"
            )),
            Self::World(flaw) => flaw.help(),
            Self::ObstaclesWithoutWalls => Some(
                "have robots stop or slide at walls, `walls: stop` or `walls: clamp`, or leave `obstacles` out"
                    .to_owned(),
            ),
            Self::StartsInObject { .. } => Some("move the robot, or the object".to_owned()),
            Self::OwnRobot { source, .. } => source.help(),
            _ => None,
        }
    }
}

impl Conditions {
    /// Checks every number, so that a world can be made of conditions that come from elsewhere and
    /// stays free of infinities, whatever its robots are commanded.
    ///
    /// [`Conditions::resolve`] has done so already.
    ///
    /// # Example
    ///
    /// ```
    /// # use rsrs_core::conditions::Conditions;
    /// # fn example(mut conditions: Conditions) {
    /// conditions.period_s = 0.0;
    /// let error = conditions.check().unwrap_err();
    /// assert_eq!(error.to_string(), "period_s is 0, expected a number from 0.001 to 2");
    /// # }
    /// ```
    pub fn check(&self) -> Result<(), Impossible> {
        for (key, found, bounds) in [
            ("robots", self.robots as f64, Axis::Robots.bounds()),
            ("arena.side_m", self.arena.side_m, Axis::Arena.bounds()),
            ("period_s", self.period_s, Axis::Period.bounds()),
        ] {
            within(key, found, bounds)?;
        }
        match &self.controller {
            Controller::Parameters(parameters) => check_parameters(*parameters)?,
            Controller::Machine(machine) => {
                check_machine(machine)?;
                check_starts(machine, &self.world)?;
            }
        }
        check_placement(self)?;
        check_world(self)?;
        check_robot(&self.robot)?;
        for (place, robot) in &self.own_robots {
            let (place, robots) = (*place, self.robots);
            if place >= robots {
                return Err(Impossible::NoSuchRobot { place, robots });
            }
            let own = |source| Impossible::OwnRobot { place, source: Box::new(source) };
            check_robot(robot).map_err(own)?;
            check_sensors(robot, self).map_err(own)?;
        }
        check_sensors(&self.robot, self)
    }
}

fn check_parameters(controller: ControllerParameters) -> Result<(), Impossible> {
    let ControllerParameters { speed_m_s, turn_rate_rad_s, undetected } = controller;
    let bounds = if undetected.is_some() { Bounds::SIGNED } else { Bounds::AMOUNT };
    within("controller.speed_m_s", speed_m_s, bounds)?;
    within("controller.turn_rate_rad_s", turn_rate_rad_s, bounds)?;
    let Some(Command { speed_m_s, turn_rate_rad_s }) = undetected else { return Ok(()) };
    within("controller.undetected.speed_m_s", speed_m_s, Bounds::SIGNED)?;
    within("controller.undetected.turn_rate_rad_s", turn_rate_rad_s, Bounds::SIGNED)
}

fn check_machine(machine: &StateMachine) -> Result<(), Impossible> {
    structure::check(machine).map_err(|(row, source)| Impossible::Controller { row, source })?;
    for row in &machine.rows {
        let Command { speed_m_s, turn_rate_rad_s } = row.command;
        within("controller.rows.command.speed_m_s", speed_m_s, Bounds::SIGNED)?;
        within("controller.rows.command.turn_rate_rad_s", turn_rate_rad_s, Bounds::SIGNED)?;
        for next in &row.next {
            within("controller.rows.next.probability", next.probability, Bounds::PROBABILITY)?;
        }
    }
    Ok(())
}

/// Whether the classes that start in states of their own are there.
fn check_starts(machine: &StateMachine, world: &WorldFile) -> Result<(), Impossible> {
    let names = || world.classes.iter().map(|class| class.name.as_str());
    match machine.starts.keys().find(|found| !names().any(|name| name == *found)) {
        None => Ok(()),
        Some(found) => {
            let nearest = nearest(found, names()).map(str::to_owned);
            Err(Impossible::NoSuchClass { found: found.clone(), nearest })
        }
    }
}

fn check_placement(conditions: &Conditions) -> Result<(), Impossible> {
    match conditions.placement {
        Placement::DiscFacingOut { radius_m } => {
            within("placement.radius_m", radius_m, Axis::PlacementRadius.bounds())
        }
        Placement::BoxFacingOut(Sides { width_m, height_m })
        | Placement::BoxFacingAnyWay(Sides { width_m, height_m }) => {
            within("placement.width_m", width_m, Bounds::SIZE)?;
            within("placement.height_m", height_m, Bounds::SIZE)
        }
        Placement::Given { ref starts } => Ok(starts::check(starts, conditions)?),
        Placement::Pair { distance_m, bearing_rad } => {
            within("robots", conditions.robots as f64, PAIR)?;
            within("placement.distance_m", distance_m, Bounds::SIZE)?;
            within("placement.bearing_rad", bearing_rad, Bounds::BEARING)
        }
    }
}

/// Whether what is there besides robots can be there, and leaves them room.
fn check_world(conditions: &Conditions) -> Result<(), Impossible> {
    let world = &conditions.world;
    world.check()?;
    world.check_in(conditions.arena.side_m)?;
    world.check_classes_of(conditions.robots)?;
    world.check_failures_of(conditions.robots)?;
    if conditions.arena.walls == Walls::None && !world.obstacles.is_empty() {
        return Err(Impossible::ObstaclesWithoutWalls);
    }
    let placed = || world.each_object().filter_map(|object| Some((object, object.place_m?)));
    match &conditions.placement {
        Placement::Pair { .. } if world.n_objects() > 0 => Err(Impossible::TrialWithObjects),
        Placement::Pair { .. } if conditions.free_space().is_some() => {
            Err(Impossible::TrialWithWalls)
        }
        Placement::Given { starts } => {
            let each = |set: &Vec<Pose>| set.clone().into_iter().enumerate();
            let all = starts.iter().enumerate().flat_map(|(replicate, set)| {
                each(set).map(move |(robot, pose)| (replicate, robot, [pose.x_m, pose.y_m]))
            });
            for (replicate, robot, place_m) in all {
                let radius_m = conditions.robot_at(robot).radius_m;
                let is_in = |(object, object_m): &(Object, [f64; 2])| {
                    let apart_m = libm::hypot(place_m[0] - object_m[0], place_m[1] - object_m[1]);
                    apart_m < (radius_m + object.radius_m) * (1.0 - ROUNDING)
                };
                if let Some((_, object_m)) = placed().find(is_in) {
                    let robot = robot + 1;
                    return Err(Impossible::StartsInObject { replicate, robot, place_m, object_m });
                }
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

fn check_robot(robot: &SimulatedRobot) -> Result<(), Impossible> {
    for (key, found, bounds) in [
        ("robot.radius_m", robot.radius_m, Bounds::SIZE),
        ("robot.front_half_angle_rad", robot.front_half_angle_rad, Bounds::SECTOR),
        ("robot.gust_time_constant_s", robot.gust_time_constant_s, Bounds::SIZE),
    ] {
        within(key, found, bounds)?;
    }
    for number in &ROBOT_NUMBERS {
        within(number.key, (number.get)(robot), number.axis.bounds())?;
    }
    check_region(&robot.region)
}

fn check_sensors(robot: &SimulatedRobot, conditions: &Conditions) -> Result<(), Impossible> {
    if !robot.has_one_plain_sensor() {
        let sensors = robot.sensors();
        let entries: Vec<SensorEntry> =
            sensors.iter().map(|it| SensorEntry::new(&it.name, &Sensing::from(it))).collect();
        sensor::file::sensors(&entries)?;
        for sensor in sensors {
            let is_there = |kind: &Detects| match kind {
                Detects::Wall => conditions.arena.walls != Walls::None,
                kind => conditions.world.has(*kind),
            };
            let detected = Detects::ALL
                .into_iter()
                .filter(|kind| sensor.details.kinds().any(|it| it == *kind));
            if let Some(kind) = detected.into_iter().find(|kind| !is_there(kind)) {
                return Err(Impossible::NothingToDetect { name: sensor.name, kind });
            }
        }
    }
    let names = robot.reading_names();
    match &conditions.controller {
        Controller::Machine(machine) if machine.sensors != names => {
            Err(Impossible::Readings(names.to_string()))
        }
        _ => Ok(()),
    }
}

fn check_region(region: &Region) -> Result<(), Impossible> {
    match region {
        Region::Cone { half_angle_rad, range_m } => {
            within("robot.region.cone.half_angle_rad", *half_angle_rad, Axis::HalfAngle.bounds())?;
            within("robot.region.cone.range_m", *range_m, Axis::Range.bounds())
        }
        Region::Polygon { corners_m } => {
            for coordinate in corners_m.iter().flatten() {
                within("robot.region.polygon.corners_m", *coordinate, Bounds::COORDINATE)?;
            }
            if is_convex(corners_m) {
                return Ok(());
            }
            Err(Impossible::Polygon(corners_m.len()))
        }
    }
}

fn within(key: &'static str, found: f64, bounds: Bounds) -> Result<(), Impossible> {
    if bounds.contains(found) {
        return Ok(());
    }
    Err(Impossible::Number { key, found, least: bounds.least, most: bounds.most })
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::conditions::Settings;
    use crate::conditions::resolve::simulated_robot;
    use crate::robot::contact::ContactModel;
    use crate::robot::profile::RobotProfile;
    use crate::robot::sensor::{Cone, Sees};

    use rsrs_testing::conditions::FLOCKBOT;

    fn conditions() -> Conditions {
        let profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 9.0)];
        Conditions::resolve(&profile, &Settings { values, ..Settings::default() }).unwrap()
    }

    /// Every path to a number in a document, outermost key first.
    fn numbers(value: &Value, path: &str) -> Vec<String> {
        match value {
            Value::Number(_) => vec![path.to_owned()],
            Value::Object(map) => map
                .iter()
                .flat_map(|(key, inner)| numbers(inner, &format!("{path}/{key}")))
                .collect(),
            _ => Vec::new(),
        }
    }

    #[test]
    fn every_number_is_checked_and_named() {
        let document = serde_json::to_value(conditions()).unwrap();
        let paths = numbers(&document, "");
        assert_eq!(paths.len(), 24, "{paths:?}");

        for path in paths {
            for impossible in [json!(-1e9), json!(1e9)] {
                let mut document = document.clone();
                *document.pointer_mut(&path).unwrap() = impossible.clone();
                let is_count = path.ends_with("robots") || path.ends_with("latency_steps");
                if is_count {
                    *document.pointer_mut(&path).unwrap() = json!(1_000_000_000);
                }

                let conditions: Conditions = serde_json::from_value(document).unwrap();
                let error = conditions.check().unwrap_err().to_string();

                let key = path.trim_start_matches('/').replace('/', ".");
                assert!(error.starts_with(&format!("{key} is ")), "{path}: {error}");
            }
        }
    }

    #[test]
    fn each_capability_has_the_bounds_of_its_row_in_profiles_and_in_conditions() {
        let mut flockbot = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        flockbot.body.contact = ContactModel::Push;
        flockbot.sensing.sees = Sees::Body;
        flockbot.sensing.polygon_m = None;
        flockbot.sensing.cone = Some(Cone { half_angle_rad: 0.2, range_m: 1.0 });
        let with = |axis: Axis, value: f64| {
            let mut robot = flockbot.clone();
            match axis {
                Axis::SensorBearing => robot.sensing.details.bearing_rad = value,
                _ => axis.set(&mut robot, value).unwrap(),
            }
            robot
        };
        let base = conditions();
        let check_both = |robot: &RobotProfile| {
            let simulated = Conditions {
                robot: simulated_robot(robot, &base.controller),
                period_s: robot.computation.period_s,
                ..base.clone()
            };
            let of_profile = robot.check().map_err(|error| error.to_string());
            [of_profile, simulated.check().map_err(|error| error.to_string())]
        };
        // The size of a region is a change of it, and no number of a robot.
        let axes = Axis::ALL.into_iter();
        let axes = axes.filter(|axis| axis.is_capability() && *axis != Axis::PolygonScale);

        for axis in axes {
            let Bounds { least, most } = axis.bounds();
            for possible in [least, most] {
                for checked in check_both(&with(axis, possible)) {
                    assert_eq!(checked, Ok(()), "{axis} of {possible}");
                }
            }
            let beyond = if axis.is_count() {
                vec![most + 1.0]
            } else {
                vec![least.next_down(), most.next_up(), f64::NAN]
            };
            for impossible in beyond {
                for checked in check_both(&with(axis, impossible)) {
                    let error = checked.expect_err(axis.key());
                    let names_both = [least, most].iter().all(|it| error.contains(&it.to_string()));
                    assert!(names_both, "{axis} of {impossible}: {error}");
                }
            }
        }
    }

    #[test]
    fn what_is_not_a_number_is_refused() {
        let conditions = Conditions { period_s: f64::NAN, ..conditions() };

        let error = conditions.check().unwrap_err();

        let expected = "period_s is NaN, expected a number from 0.001 to 2";
        assert_eq!(error.to_string(), expected);
    }

    #[test]
    fn a_polygon_must_be_convex_counterclockwise_and_small() {
        let check = |corners_m: &[[f64; 2]]| {
            check_region(&Region::Polygon { corners_m: corners_m.to_vec() })
        };
        let square = [[0.0, -0.1], [1.0, -0.1], [1.0, 0.1], [0.0, 0.1]];
        let clockwise: Vec<_> = square.into_iter().rev().collect();
        let star: Vec<[f64; 2]> = (0..5)
            .map(|corner| {
                let angle_rad = f64::from(corner) * 2.0 * std::f64::consts::TAU / 5.0;
                [libm::cos(angle_rad), libm::sin(angle_rad)]
            })
            .collect();

        assert_eq!(check(&square), Ok(()));
        assert_eq!(check(&clockwise), Err(Impossible::Polygon(4)));
        assert_eq!(check(&star), Err(Impossible::Polygon(5)));
        assert_eq!(check(&[]), Err(Impossible::Polygon(0)));
        assert_eq!(check(&[[0.5, 0.5]; 3]), Err(Impossible::Polygon(3)));
        let far = check(&[[0.0, 0.0], [1e7, 0.0], [1.0, 1.0]]).unwrap_err();
        assert!(far.to_string().contains("corners_m is 10000000"), "{far}");
    }
}
