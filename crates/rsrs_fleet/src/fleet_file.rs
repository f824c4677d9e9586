//! The fleet file: which robots there are and how to reach them.

mod error;
mod tracker;

use std::borrow::Cow;
use std::collections::BTreeMap;

use indexmap::IndexMap;
use rsrs_core::document;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::tracker::Tracker;
use rsrs_msgs::node_names::CONTROLLER;
use rsrs_msgs::topics::{self, Topic};
use schemars::{JsonSchema, Schema, SchemaGenerator};

use crate::geofence::Geofence;

use tracker::WrittenTracker;

pub use error::{FleetFileError, Lack};

/// A fleet, resolved: every robot with its own value of everything.
///
/// The file has the shape of Crazyswarm2's `crazyflies.yaml`: what holds for a robot overrides what
/// holds for its type, which overrides what holds for `all`.
#[derive(Clone, Debug, PartialEq)]
pub struct FleetFile {
    /// All robots, in the order of the file.
    pub robots: Vec<FleetRobot>,
    /// Path of the fleet's measured profile, relative to the file: a robot with another one has its own.
    /// It is that of `all`; without one there, that of the first enabled robot with the profile of its
    /// type, and where only entries of robots have one, that of the first enabled one which does. `None`
    /// if no robot that may be used was measured yet.
    pub profile: Option<String>,
    /// What none of them must leave in a run; `None` if there is nothing.
    pub geofence: Option<Geofence>,
}

/// One robot of a fleet.
#[derive(Clone, Debug, PartialEq)]
pub struct FleetRobot {
    /// Its name, and its namespace in ROS: `robot_1`, or with a namespace of its own `lab/robot_1`.
    pub name: String,
    /// Whether experiments may use it.
    pub enabled: bool,
    /// Path of its measured profile, relative to the fleet file; `None` if it was not measured yet.
    pub profile: Option<String>,
    /// What moves it.
    pub driver: Driver,
    /// The type of its velocity commands.
    pub cmd_vel: CmdVel,
    /// Where its pose comes from.
    pub pose: PoseSource,
    /// How that is published, for all robots alike; names of single robots are in `body`.
    pub tracker: Tracker,
    /// What the tracker calls it, where that is not its name.
    pub body: Option<String>,
    /// Who holds its lease.
    pub lease: LeaseHolder,
    /// Battery voltage below which it starts no run, in volts; `None` if any will do.
    pub battery_min_v: Option<f64>,
    /// Distance up to which what its range sensor measures is a detection, in metres; `None` if its
    /// profile has it, or another node decides.
    pub detection_threshold_m: Option<f64>,
}

/// What moves a robot.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Driver {
    /// A microcontroller on a serial line.
    Serial {
        /// Path of the device.
        port: String,
        /// Baud rate.
        baud: u32,
    },
    /// Another node, which takes velocity commands.
    Ros,
    /// The simulator.
    Virtual,
}

/// The type of a robot's velocity commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CmdVel {
    /// `geometry_msgs/TwistStamped`; lockstep needs the stamp.
    #[default]
    TwistStamped,
    /// `geometry_msgs/Twist`.
    Twist,
}

impl CmdVel {
    /// Both.
    pub const ALL: [Self; 2] = [Self::TwistStamped, Self::Twist];

    /// What files and parameters call it, the topic of a robot that is commanded so, and that of its
    /// base driver.
    fn row(self) -> (&'static str, Topic, Topic) {
        match self {
            Self::TwistStamped => ("twist_stamped", topics::CMD_VEL, topics::HARDWARE_CMD_VEL),
            Self::Twist => ("twist", topics::CMD_VEL_UNSTAMPED, topics::HARDWARE_CMD_VEL_UNSTAMPED),
        }
    }

    /// What files and parameters call it.
    pub fn key(self) -> &'static str {
        self.row().0
    }

    /// The one that files and parameters call so; `None` if there is none.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.key() == key)
    }

    /// The one of messages of a type such as `geometry_msgs/msg/Twist`; `None` if no command is of it.
    pub fn of_type(type_name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.topic().type_name == type_name)
    }

    /// The topic of a robot that is commanded so.
    pub fn topic(self) -> Topic {
        self.row().1
    }

    /// The topic of a base driver that is commanded so.
    pub fn hardware_topic(self) -> Topic {
        self.row().2
    }
}

/// Who holds a robot's lease.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LeaseHolder {
    /// The gate in front of its wheels: that of `rsrs node robot`, or the simulator's.
    #[default]
    Gate,
    /// Its controller only: the robot takes velocity commands from any node, and nothing of ours is
    /// in front of its wheels. When the lease ends its controller sends zero; if the controller or
    /// the network dies, only the robot itself can stop.
    Controller,
}

impl LeaseHolder {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Gate, Self::Controller];

    /// What files and parameters call it.
    pub fn key(self) -> &'static str {
        match self {
            Self::Gate => "gate",
            Self::Controller => "controller",
        }
    }
}

/// An experiment with more robots than the fleet has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the fleet has {found} enabled robots, expected at least {expected}")]
pub struct TooFewRobots {
    /// Enabled robots in the fleet.
    pub found: usize,
    /// Robots that the cell asks for.
    pub expected: usize,
}

/// The key of a robot's profile.
const PROFILE: &str = "profile";

/// The only version of the format.
const FILE_VERSION: u32 = 1;

impl FleetFile {
    /// What it is called beside a profile, and in the bag of a run.
    pub const NAME: &str = "fleet.yaml";

    /// Reads a fleet file and resolves each robot; `file` names it in errors, and nothing is opened.
    ///
    /// The error is the first problem found; keys that are missing come all at once.
    pub fn parse(file: &str, text: &str) -> Result<Self, FleetFileError> {
        let written: Written = document::parse_with(file, text, &["fileversion", "robots"])?;
        if written.fileversion != FILE_VERSION {
            return Err(FleetFileError::Version {
                file: file.to_owned(),
                found: written.fileversion,
            });
        }
        let lacks: Vec<Lack> =
            written.robots.iter().filter_map(|(name, robot)| written.lack(name, robot)).collect();
        if !lacks.is_empty() {
            return Err(FleetFileError::Missing { file: file.to_owned(), robots: lacks });
        }
        let robots = written
            .robots
            .iter()
            .map(|(name, robot)| written.resolve(file, name, robot))
            .collect::<Result<Vec<_>, _>>()?;
        check_namespaces(file, &robots)?;
        check_bodies(file, &robots)?;
        let invalid = |reason| FleetFileError::Geofence { file: file.to_owned(), reason };
        written.geofence.map_or(Ok(()), |geofence| geofence.check()).map_err(invalid)?;
        let profile = written.fleet_profile();
        Ok(Self { robots, profile, geofence: written.geofence })
    }

    /// Names of the robots that experiments may use, in the order of the file.
    pub fn enabled(&self) -> Vec<&str> {
        self.robots.iter().filter(|robot| robot.enabled).map(|robot| robot.name.as_str()).collect()
    }

    /// The path of a robot's profile, relative to the file, which errors name; an error if the robot
    /// was not measured yet.
    pub fn profile_of<'a>(file: &str, robot: &'a FleetRobot) -> Result<&'a str, FleetFileError> {
        robot.profile.as_deref().ok_or_else(|| FleetFileError::Missing {
            file: file.to_owned(),
            robots: vec![Lack { robot: robot.name.clone(), enabled: false, keys: vec![PROFILE] }],
        })
    }

    /// The first enabled robots: those that a cell with `robots: n` takes.
    pub fn first(&self, n_robots: usize) -> Result<Vec<&FleetRobot>, TooFewRobots> {
        let enabled: Vec<_> = self.robots.iter().filter(|robot| robot.enabled).collect();
        if enabled.len() < n_robots {
            return Err(TooFewRobots { found: enabled.len(), expected: n_robots });
        }
        Ok(enabled.into_iter().take(n_robots).collect())
    }
}

/// Refuses two robots that the tracker calls alike.
fn check_bodies(file: &str, robots: &[FleetRobot]) -> Result<(), FleetFileError> {
    let mut robot_of: BTreeMap<&str, &str> = BTreeMap::new();
    for robot in robots.iter().filter(|robot| robot.enabled) {
        if let Some(other) = robot_of.insert(robot.body(), &robot.name) {
            return Err(FleetFileError::OneBody {
                file: file.to_owned(),
                robots: [other.to_owned(), robot.name.clone()],
                body: robot.body().to_owned(),
            });
        }
    }
    Ok(())
}

impl FleetRobot {
    /// What the tracker calls it.
    pub fn body(&self) -> &str {
        self.body.as_deref().unwrap_or(&self.name)
    }
}

/// The file as a person writes it.
#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Written {
    /// Version of the format: 1.
    fileversion: u32,
    /// What holds for all robots, unless their type or they themselves have something else.
    #[serde(default)]
    all: Layer,
    /// What holds for the robots of a type.
    #[serde(default)]
    robot_types: IndexMap<String, Layer>,
    /// A rectangle of the floor, in the frame of the poses; a robot whose centre leaves it in a run is
    /// lost (default: there is none).
    geofence: Option<Geofence>,
    /// The robots, in the order in which experiments take them.
    robots: IndexMap<String, WrittenRobot>,
}

/// What can be set for all robots, or for those of a type.
#[derive(Clone, Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Layer {
    /// Path of its measured profile, relative to the fleet file; without one it can only be measured. That
    /// of `all` is the fleet's, from which sweeps must be made.
    profile: Option<String>,
    /// What moves it; a robot, its type or `all` has to have it.
    driver: Option<Driver>,
    /// The type of its velocity commands (default: `twist_stamped`).
    cmd_vel: Option<CmdVel>,
    /// Where its pose comes from (default: `odom`).
    pose: Option<PoseSource>,
    /// How the tracker publishes it, and where the tracker's frame is on the floor; one for all robots
    /// of a run.
    tracker: Option<WrittenTracker>,
    /// Who holds its lease (default: `gate`).
    lease: Option<LeaseHolder>,
    /// Battery voltage below which it starts no run, in volts (default: any will do).
    battery_min_v: Option<f64>,
    /// Up to this distance, a reading of its range sensor is a detection, in metres (default: the range of
    /// its profile's cone).
    detection_threshold_m: Option<f64>,
}

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct WrittenRobot {
    /// Whether experiments may use it.
    #[schemars(required)]
    enabled: Option<bool>,
    /// Name of its type among `robot_types`.
    #[serde(rename = "type")]
    robot_type: Option<String>,
    /// Path of its measured profile, relative to the fleet file; without one it can only be measured. One
    /// that is not the fleet's holds for this robot: its limits, its gate, and how the simulator moves it.
    profile: Option<String>,
    /// What moves it; a robot, its type or `all` has to have it.
    driver: Option<Driver>,
    /// The type of its velocity commands (default: `twist_stamped`).
    cmd_vel: Option<CmdVel>,
    /// Where its pose comes from (default: `odom`).
    pose: Option<PoseSource>,
    /// How the tracker publishes it, and where the tracker's frame is on the floor; one for all robots
    /// of a run.
    tracker: Option<WrittenTracker>,
    /// What the tracker calls it, or with `pose: tf` the frame of its body (default: its name, or
    /// `<robot>/base_link` and `<robot>/base_footprint`).
    body: Option<String>,
    /// Who holds its lease (default: `gate`).
    lease: Option<LeaseHolder>,
    /// Battery voltage below which it starts no run, in volts (default: any will do).
    battery_min_v: Option<f64>,
    /// Up to this distance, a reading of its range sensor is a detection, in metres (default: the range of
    /// its profile's cone).
    detection_threshold_m: Option<f64>,
}

impl Written {
    /// Keys that the file lacks for a robot; those of a robot of an unknown type are not checked.
    fn lack(&self, name: &str, robot: &WrittenRobot) -> Option<Lack> {
        let unspecific = Layer::default();
        let of_type = match &robot.robot_type {
            None => &unspecific,
            Some(found) => self.robot_types.get(found)?,
        };
        let all = &self.all;
        let has_driver =
            [&robot.driver, &of_type.driver, &all.driver].iter().any(|it| it.is_some());
        let keys = if has_driver { Vec::new() } else { vec!["driver"] };
        let enabled = robot.enabled.is_none();
        (enabled || !keys.is_empty()).then(|| Lack { robot: name.to_owned(), enabled, keys })
    }

    /// The profile from which robots with another one differ.
    fn fleet_profile(&self) -> Option<String> {
        let enabled = self.robots.values();
        let enabled: Vec<_> = enabled.filter(|robot| robot.enabled == Some(true)).collect();
        let of_type = |robot: &&WrittenRobot| {
            let of_type = self.robot_types.get(robot.robot_type.as_ref()?)?;
            of_type.profile.clone().filter(|_| robot.profile.is_none())
        };
        let all = self.all.profile.clone();
        all.or_else(|| enabled.iter().find_map(of_type))
            .or_else(|| enabled.iter().find_map(|robot| robot.profile.clone()))
    }

    fn resolve(
        &self,
        file: &str,
        name: &str,
        robot: &WrittenRobot,
    ) -> Result<FleetRobot, FleetFileError> {
        if !is_name(name) {
            return Err(FleetFileError::Name { file: file.to_owned(), name: name.to_owned() });
        }
        let unspecific = Layer::default();
        let of_type = match &robot.robot_type {
            None => &unspecific,
            Some(found) => {
                self.robot_types.get(found).ok_or_else(|| FleetFileError::UnknownType {
                    file: file.to_owned(),
                    robot: name.to_owned(),
                    found: found.clone(),
                    expected: self.robot_types.keys().cloned().collect(),
                })?
            }
        };
        let checked = "missing keys are refused before robots are resolved";
        let all = &self.all;
        let driver = first_of([&robot.driver, &of_type.driver, &all.driver]).expect(checked);
        let lease = first_of([&robot.lease, &of_type.lease, &all.lease]).unwrap_or_default();
        if lease == LeaseHolder::Controller && driver != Driver::Ros {
            return Err(FleetFileError::HasGate { file: file.to_owned(), robot: name.to_owned() });
        }
        let pose = first_of([&robot.pose, &of_type.pose, &all.pose]).unwrap_or_default();
        let tracker = tracker::resolved([&robot.tracker, &of_type.tracker, &all.tracker]);
        let fits = tracker::check(&tracker, pose)
            .and_then(|()| tracker.check_body(robot.body.as_deref().unwrap_or(name)));
        fits.map_err(|reason| {
            let (file, robot) = (file.to_owned(), name.to_owned());
            FleetFileError::Tracker { file, robot, pose, reason }
        })?;
        let battery_min_v =
            first_of([&robot.battery_min_v, &of_type.battery_min_v, &all.battery_min_v]);
        let detection_threshold_m = first_of([
            &robot.detection_threshold_m,
            &of_type.detection_threshold_m,
            &all.detection_threshold_m,
        ]);
        for (key, found, most) in [
            ("battery_min_v", battery_min_v, MOST_VOLTS),
            ("detection_threshold_m", detection_threshold_m, MOST_THRESHOLD_M),
        ] {
            if let Some(found) = found.filter(|found| !(*found > 0.0 && *found <= f64::from(most)))
            {
                let (file, robot, found) = (file.to_owned(), name.to_owned(), found.to_string());
                return Err(FleetFileError::Number { file, robot, key, found, most });
            }
        }
        Ok(FleetRobot {
            name: name.to_owned(),
            enabled: robot.enabled.expect(checked),
            profile: first_of([&robot.profile, &of_type.profile, &all.profile]),
            driver,
            lease,
            cmd_vel: first_of([&robot.cmd_vel, &of_type.cmd_vel, &all.cmd_vel]).unwrap_or_default(),
            pose,
            tracker,
            body: robot.body.clone(),
            battery_min_v,
            detection_threshold_m,
        })
    }
}

/// No battery of a robot has more, in volts.
const MOST_VOLTS: u32 = 1000;
/// No gate takes more, in metres: more is likely in millimetres.
const MOST_THRESHOLD_M: u32 = 100;

fn first_of<T: Clone>(layers: [&Option<T>; 3]) -> Option<T> {
    layers.into_iter().flatten().next().cloned()
}

/// Whether a robot may have this name: each part of it is one of a namespace in ROS, and its topics are
/// not taken for those of another one.
pub(crate) fn is_name(name: &str) -> bool {
    let is_hidden = |part: &str| part.starts_with('_');
    let last = name.rsplit_once('/').map(|(_, last)| last);
    topics::is_namespace(name)
        && !name.split('/').any(is_hidden)
        && !matches!(last, Some(CONTROLLER | "hardware"))
}

/// Refuses a robot in whose namespace another one is: its topics would be taken for that one's.
fn check_namespaces(file: &str, robots: &[FleetRobot]) -> Result<(), FleetFileError> {
    for robot in robots {
        let is_within = |other: &&FleetRobot| {
            other.name.strip_prefix(&robot.name).is_some_and(|rest| rest.starts_with('/'))
        };
        if let Some(other) = robots.iter().find(is_within) {
            return Err(FleetFileError::Within {
                file: file.to_owned(),
                robot: robot.name.clone(),
                other: other.name.clone(),
            });
        }
    }
    Ok(())
}

impl JsonSchema for FleetFile {
    fn schema_name() -> Cow<'static, str> {
        "FleetFile".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Written::json_schema(generator)
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::help::Help;

    use super::*;

    const LAYERED: &str = "\
fileversion: 1
all: {profile: p.yaml, driver: {kind: ros}, cmd_vel: twist, pose: pose, battery_min_v: 6.6, detection_threshold_m: 0.5}
robot_types:
  flockbot: {driver: {kind: serial, port: /dev/ttyACM0, baud: 115200}, cmd_vel: twist_stamped,
    detection_threshold_m: 0.3}
robots:
  zebra: {enabled: true, type: flockbot, driver: {kind: virtual}}
  ant: {enabled: false, battery_min_v: 7.0}
  bee: {enabled: true, type: flockbot}
";

    #[test]
    fn the_fleets_profile_is_that_of_all_or_of_the_first_robot_that_has_its_types_or_has_one() {
        let profile = |all: &str, of_type: &str, robots: [&str; 3]| {
            let [one, two, three] = robots;
            let text = format!(
                "fileversion: 1\nall: {{driver: {{kind: ros}}{all}}}\nrobot_types:\n  bot: {{{of_type}}}\n\
                 robots:\n  zebra: {{enabled: false, profile: z.yaml}}\n  one: {{enabled: true{one}}}\n  \
                 two: {{enabled: true{two}}}\n  three: {{enabled: true{three}}}\n"
            );
            FleetFile::parse("fleet.yaml", &text).unwrap().profile
        };
        let (own, typed) = (", profile: own.yaml", ", type: bot");
        let (of_all, of_type) = (", profile: all.yaml", "profile: bot.yaml");
        let both = ", type: bot, profile: own.yaml";

        assert_eq!(profile(of_all, of_type, [own, typed, ""]).unwrap(), "all.yaml");
        assert_eq!(profile("", of_type, [both, typed, ""]).unwrap(), "bot.yaml");
        assert_eq!(profile("", "", ["", own, ", profile: other.yaml"]).unwrap(), "own.yaml");
        assert_eq!(profile("", of_type, ["", "", ""]), None, "nobody is of that type");
    }

    #[test]
    fn a_robot_overrides_its_type_which_overrides_all() {
        let fleet = FleetFile::parse("fleet.yaml", LAYERED).unwrap();

        let [zebra, ant, bee] = &fleet.robots[..] else { panic!("three robots") };
        assert_eq!((&zebra.driver, zebra.cmd_vel), (&Driver::Virtual, CmdVel::TwistStamped));
        assert_eq!((&ant.driver, ant.cmd_vel), (&Driver::Ros, CmdVel::Twist));
        assert!(matches!(bee.driver, Driver::Serial { baud: 115_200, .. }));
        assert_eq!(bee.pose, PoseSource::Pose);
        assert_eq!((ant.battery_min_v, bee.battery_min_v), (Some(7.0), Some(6.6)));
        assert_eq!(fleet.geofence, None);
        assert_eq!((ant.detection_threshold_m, bee.detection_threshold_m), (Some(0.5), Some(0.3)));
    }

    #[test]
    fn the_lease_of_a_robot_without_a_gate_of_ours_is_held_by_its_controller() {
        let text = LAYERED.replace("enabled: false", "enabled: true, lease: controller");

        let fleet = FleetFile::parse("fleet.yaml", &text).unwrap();

        let leases: Vec<_> = fleet.robots.iter().map(|robot| robot.lease).collect();
        assert_eq!(leases, [LeaseHolder::Gate, LeaseHolder::Controller, LeaseHolder::Gate]);
    }

    #[test]
    fn the_first_robots_are_the_enabled_ones_in_the_order_of_the_file() {
        let fleet = FleetFile::parse("fleet.yaml", LAYERED).unwrap();

        assert_eq!(fleet.enabled(), ["zebra", "bee"]);
        assert_eq!(fleet.first(1).unwrap()[0].name, "zebra");
        assert_eq!(
            fleet.first(3).unwrap_err().to_string(),
            "the fleet has 2 enabled robots, expected at least 3"
        );
    }

    #[test]
    fn names_may_have_capital_letters() {
        let fleet = FleetFile::parse("fleet.yaml", &LAYERED.replace("zebra:", "Alice:")).unwrap();

        assert!(fleet.robots.iter().any(|robot| robot.name == "Alice"));
    }

    #[test]
    fn names_keys_types_and_versions_that_do_not_fit_are_refused() {
        for (from, to, expected) in [
            ("zebra:", "3zebra:", "robot name `3zebra`"),
            ("zebra:", "_zebra:", "robot name `_zebra`"),
            ("zebra:", "/zebra:", "robot name `/zebra`"),
            ("zebra:", "lab//zebra:", "robot name `lab//zebra`"),
            ("zebra:", "lab/controller:", "robot name `lab/controller`"),
            (
                "zebra:",
                "ant/zebra:",
                "ant/zebra is in the namespace `/ant`, which is that of another",
            ),
            ("zebra:", "Zébra:", "robot name `Zébra`"),
            ("zebra:", "ze__bra:", "robot name `ze__bra`, expected a letter, then letters, digits"),
            ("  bee:", "  ant:", "key `ant` is given twice"),
            ("enabled: false", "enable: false", "did you mean `enabled`?"),
            ("type: flockbot}", "type: flocbot}", "type `flocbot`, expected one of: flockbot"),
            ("fileversion: 1", "fileversion: 2", "fileversion is 2, expected 1"),
            ("fileversion: 1\n", "", "missing key `fileversion`"),
            ("1\nall: {", "1\nall: {lease: controller, ", "zebra has a gate"),
            ("1\nall", "1\ngeofence: {x_m: [0, 1], y_m: [2, 1]}\nall", "`y_m` is [2.0, 1.0]"),
            (
                "1\nall",
                "1\ngeofence: {x_m: [-2500, 2500], y_m: [0, 1]}\nall",
                "likely in millimetres",
            ),
            (
                "battery_min_v: 7.0",
                "battery_min_v: .nan",
                "`battery_min_v` of ant is NaN, expected more than 0",
            ),
            (
                "battery_min_v: 7.0",
                "battery_min_v: -3",
                "is -3, expected more than 0 and at most 1000",
            ),
            (
                "_m: 0.5}",
                "_m: 750}",
                "`detection_threshold_m` of ant is 750, expected more than 0 and at most 100",
            ),
            ("_m: 0.5}", "_m: 0}", "is 0, expected more than 0 and at most 100"),
        ] {
            let error = FleetFile::parse("fleet.yaml", &LAYERED.replace(from, to)).unwrap_err();

            assert!(error.to_string().contains(expected), "{error}");
        }
    }

    #[test]
    fn the_tracker_of_a_robot_is_put_together_key_by_key() {
        let text = "\
fileversion: 1
all:
  driver: {kind: ros}
  pose: named_poses
  tracker: {topics: [/a/poses, /b/poses], offset_m: [1, -2.5], scale: 0.001, axes: [x, -z, y]}
robot_types:
  marked: {tracker: {rotation_rad: 1.5, scale: 0.01}}
robots:
  robot_1: {enabled: true, type: marked, body: RigidBody 7}
  robot_2: {enabled: true}
";

        let fleet = FleetFile::parse("fleet.yaml", text).unwrap();

        let [first, second] = &fleet.robots[..] else { panic!("two robots") };
        assert_eq!(first.tracker.topics, ["/a/poses", "/b/poses"]);
        assert_eq!(first.tracker.frame.offset_m.map(f64::to_bits), [1.0, -2.5].map(f64::to_bits));
        assert_eq!((first.tracker.frame.scale, second.tracker.frame.scale), (0.01, 0.001));
        assert_eq!(
            (first.tracker.frame.rotation_rad, second.tracker.frame.rotation_rad),
            (1.5, 0.0)
        );
        assert_eq!(second.tracker.frame.axes.to_string(), "[x, -z, y]");
        assert_eq!((first.body(), second.body()), ("RigidBody 7", "robot_2"));
    }

    #[test]
    fn trackers_that_cannot_be_are_refused_with_what_to_write() {
        let fleet = |all: &str, robots: &str| {
            let text = format!(
                "fileversion: 1\nall: {{driver: {{kind: ros}}, {all}}}\nrobots: {{{robots}}}\n"
            );
            FleetFile::parse("fleet.yaml", &text).map_err(|error| error.text_with_help())
        };
        let one = "robot_1: {enabled: true}";
        for (all, robots, expected) in [
            ("pose: pose_array", one, "`names` is missing"),
            ("pose: tf, tracker: {topics: [/tf]}", one, "transforms come on /tf"),
            ("pose: named_poses, tracker: {names: [robot_1]}", one, "`names` is given"),
            ("tracker: {axes: [x, z, y]}", one, "left-handed"),
            ("tracker: {axes: [x, y]}", one, "fleet.yaml:2"),
            ("tracker: {rotation_rad: 90}", one, "(90° is 1.5708)"),
            ("tracker: {scale: 0}", one, "(0.001 for millimetres)"),
            ("tracker: {offset: [0, 0]}", one, "did you mean `offset_m`?"),
            ("pose: pose", "a: {enabled: true, body: b}, b: {enabled: true}", "both a and b `b`"),
        ] {
            let error = fleet(all, robots).unwrap_err();

            assert!(error.contains(expected), "{all}: {error}");
        }
        assert!(fleet("pose: pose", "a: {enabled: true, body: b}, b: {enabled: false}").is_ok());
    }

    #[test]
    fn everything_that_is_missing_is_named_at_once() {
        let text = "fileversion: 1\nrobots:\n  a: {enabled: true}\n  b: {driver: {kind: ros}}\n";

        let error = FleetFile::parse("fleet.yaml", text).unwrap_err();

        assert_eq!(
            error.to_string(),
            "fleet.yaml: a has no `driver`, nor has its type or `all`; b has no `enabled`"
        );
        assert_eq!(
            error.help().unwrap(),
            "give `driver` under the robot, its type or `all`; set `enabled: true` or `false` of \
             each robot"
        );
        let nothing = FleetFile::parse("fleet.yaml", "{}").unwrap_err().to_string();
        assert!(nothing.ends_with("missing keys `fileversion`, `robots`"), "{nothing}");
    }

    #[test]
    fn the_shipped_fleet_of_three_kinds_has_one_robot_of_each() {
        let text = include_str!("../../../launch_configs/fleets/three_kinds.yaml");

        let fleet = FleetFile::parse("three_kinds.yaml", text).unwrap();

        let [ours, foreign, simulated] = &fleet.robots[..] else { panic!("three robots") };
        assert!(matches!(ours.driver, Driver::Serial { .. }) && ours.lease == LeaseHolder::Gate);
        assert_eq!((&foreign.driver, foreign.lease), (&Driver::Ros, LeaseHolder::Controller));
        assert_eq!(simulated.driver, Driver::Virtual);
    }
}
