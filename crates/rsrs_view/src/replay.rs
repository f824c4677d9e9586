//! A run as numbers that a page can move: poses a few times a second, detections at each control
//! period, both packed into text.
//!
//! Places are kept to about a thirty-thousandth of the floor and headings to 1.4°, finer than a pixel
//! shows, so that a page with a hundred runs can be mailed.

use std::collections::BTreeMap;
use std::ops::Range;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rsrs_core::conditions::{Conditions, SimulatedRobot, SimulatedSensor};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::controller::{Command, ControllerParameters};
use rsrs_core::robot::region::Region;
use rsrs_core::world::{Goal, WorldFile};
use serde::Serialize;

use crate::palette::lid;
use crate::scale::ends;
use crate::trajectory::Ring;

/// Chords on the arc of a cone: the widest one is drawn to 0.8 % of its range.
const ARC_CORNERS: u32 = 12;
/// Places are whole numbers of units from the middle, at most so many.
const MOST_UNITS: f64 = 32_000.0;

/// What of a run is shown, and with which bodies and sensors.
#[derive(Clone, Debug)]
pub struct Shown<'a> {
    /// What every robot did.
    pub trajectory: &'a Trajectory,
    /// The robots that did it.
    pub conditions: &'a Conditions,
    /// Names of the robots, row by row; shape `[n_robots]`.
    pub robots: Vec<String>,
    /// The samples to be shown; not empty, within the trajectory.
    pub samples: Range<usize>,
    /// Every so many samples a pose is kept; at least 1. Those between are interpolated.
    pub every: usize,
    /// The ring that was fitted to the judged window, if there is one.
    pub ring: Option<Ring>,
    /// Robots that did not take part to the end, by their row.
    pub lost: Vec<usize>,
}

/// A run, packed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Replay {
    n_robots: usize,
    robots: Vec<String>,
    /// When it begins, in seconds from the start of the run.
    start_s: f64,
    /// From one pose to the next, in seconds.
    frame_s: f64,
    /// From one detection to the next, in seconds.
    period_s: f64,
    /// The middle of the floor, in metres.
    centre_m: [f64; 2],
    /// Half of the side of the square that holds every robot, in metres.
    half_side_m: f64,
    /// One unit of a place, in metres.
    unit_m: f64,
    radius_m: f64,
    /// The region of each sensor, that of `detection` first, in the robot's frame, in metres.
    regions_m: Vec<Vec<[f64; 2]>>,
    /// The same of robots that are not like the others, by their place.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    own_regions_m: BTreeMap<usize, Vec<Vec<[f64; 2]>>>,
    /// Centre and radius, in metres.
    ring_m: Option<[f64; 3]>,
    lost: Vec<usize>,
    /// Of which classes they are, if there are some.
    #[serde(skip_serializing_if = "Option::is_none")]
    classes: Option<PackedClasses>,
    /// What is there besides robots, if anything is.
    #[serde(skip_serializing_if = "Option::is_none")]
    world: Option<PackedWorld>,
    /// x and y of each robot in each frame, 16 bits each, the low byte first; base64.
    places: String,
    /// Heading of each robot in each frame, in 256ths of a turn; base64.
    headings: String,
    /// Whether each robot detected something in each sample, a bit each from the lowest; base64.
    detections: String,
}

/// Classes of robots, packed.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct PackedClasses {
    names: Vec<String>,
    /// The lids of the robots of each, as `#0072b2`; shape `[n_classes]`.
    lids: Vec<String>,
    /// The class of each robot, by its place; shape `[n_robots]`.
    of_robots: Vec<usize>,
}

/// Objects and goals, packed.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct PackedWorld {
    /// Of each object, in metres.
    radii_m: Vec<f64>,
    /// x and y of each object in each frame, as those of robots; base64.
    places: String,
    /// Centre and radius of each, in metres.
    goals_m: Vec<[f64; 3]>,
    /// Corners of the border of an arena that is no plain square, and of each obstacle, in metres; left out where there
    /// are no such walls.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    walls_m: Vec<Vec<[f64; 2]>>,
}

/// How many bytes the poses of one robot take in one frame, as text.
const BYTES_PER_POSE: f64 = 5.0 * 4.0 / 3.0;
/// How many bytes the place of one object takes in one frame, as text.
const BYTES_PER_PLACE: f64 = 4.0 * 4.0 / 3.0;

/// How many bytes one frame of a run takes, as text.
pub fn bytes_per_frame(n_robots: usize, n_objects: usize) -> f64 {
    n_robots as f64 * BYTES_PER_POSE + n_objects as f64 * BYTES_PER_PLACE
}

impl Replay {
    /// Packs a run.
    ///
    /// # Panics
    ///
    /// If there is no sample to show, or a pose is not finite: a run that was judged has both.
    pub fn new(shown: &Shown) -> Self {
        let Shown { trajectory, conditions, .. } = shown;
        let frames: Vec<usize> = shown.samples.clone().step_by(shown.every).collect();
        assert!(!frames.is_empty(), "a replay has at least one frame");
        let radius_m = conditions.robot.radius_m;
        let square = Square::around(shown);
        let poses = || frames.iter().flat_map(|frame| trajectory.poses_at(*frame));
        let headings: Vec<u8> = poses().map(|pose| to_256ths(pose.heading_rad)).collect();
        let objects_m = frames.iter().flat_map(|frame| trajectory.objects_at(*frame));
        let world = &conditions.world;
        let own_robots = conditions.own_robots.iter();
        let packed_world = (!world.is_empty()).then(|| PackedWorld {
            radii_m: world.each_object().take(trajectory.n_objects).map(|it| it.radius_m).collect(),
            places: square.packed(objects_m.copied()),
            goals_m: world.goals.iter().map(|goal| disc(goal).map(rounded)).collect(),
            walls_m: walls_m(conditions),
        });
        Self {
            n_robots: trajectory.n_robots,
            robots: shown.robots.clone(),
            start_s: seconds(shown.samples.start, trajectory),
            frame_s: rounded(shown.every as f64 * trajectory.period_s),
            period_s: trajectory.period_s,
            centre_m: square.centre_m.map(rounded),
            half_side_m: rounded(square.half_side_m),
            unit_m: square.unit_m(),
            radius_m,
            regions_m: regions(&conditions.robot),
            own_regions_m: own_robots.map(|(place, robot)| (*place, regions(robot))).collect(),
            ring_m: shown
                .ring
                .map(|ring| [ring.centre_m.0, ring.centre_m.1, ring.radius_m].map(rounded)),
            lost: shown.lost.clone(),
            classes: packed_classes(world, trajectory.n_robots),
            world: packed_world,
            places: square.packed(poses().map(|pose| [pose.x_m, pose.y_m])),
            headings: STANDARD.encode(headings),
            detections: STANDARD.encode(detections(shown)),
        }
    }
}

/// Which robot is of which class; `None` where there are none.
fn packed_classes(world: &WorldFile, n_robots: usize) -> Option<PackedClasses> {
    (!world.classes.is_empty()).then(|| PackedClasses {
        names: world.classes.iter().map(|class| class.name.clone()).collect(),
        lids: (0..world.classes.len()).map(|class| lid(class).hex()).collect(),
        of_robots: world.classes_of(n_robots),
    })
}

/// Corners of the border and of each obstacle, in metres, of an arena that is no plain square.
fn walls_m(conditions: &Conditions) -> Vec<Vec<[f64; 2]>> {
    let corners = |corners_m: Vec<[f64; 2]>| {
        corners_m.into_iter().map(|corner| corner.map(rounded)).collect()
    };
    conditions.walls_drawn_m().into_iter().map(corners).collect()
}

/// Centre and radius of a goal, in metres.
fn disc(goal: &Goal) -> [f64; 3] {
    [goal.place_m[0], goal.place_m[1], goal.radius_m]
}

/// The square that holds every robot, every object, every goal and every obstacle, and all of an arena that is no square.
struct Square {
    centre_m: [f64; 2],
    half_side_m: f64,
}

impl Square {
    fn around(shown: &Shown) -> Self {
        let Shown { trajectory, conditions, .. } = shown;
        let samples = || shown.samples.clone();
        let poses = samples().flat_map(|sample| trajectory.poses_at(sample));
        let objects_m = samples().flat_map(|sample| trajectory.objects_at(sample));
        let goals = conditions.world.goals.iter().flat_map(|goal| {
            let [x_m, y_m, r_m] = disc(goal);
            [[x_m - r_m, y_m - r_m], [x_m + r_m, y_m + r_m]]
        });
        // A square may be much wider than where robots are.
        let is_square = conditions.world.arena.is_none();
        let walls_m = walls_m(conditions).into_iter().skip(usize::from(is_square)).flatten();
        let places_m = poses.map(|pose| [pose.x_m, pose.y_m]).chain(objects_m.copied());
        let places_m: Vec<[f64; 2]> = places_m.chain(goals).chain(walls_m).collect();
        let [x_m, y_m] = [0, 1].map(|axis| ends(places_m.iter().map(|place_m| place_m[axis])));
        let half_m = |[low, high]: [f64; 2]| (high - low) / 2.0;
        let half_extent_m = half_m(x_m).max(half_m(y_m));
        // Room for bodies, and for most of what they see; a line of sight across the hall would leave none for them.
        let robot = &conditions.robot;
        let seen_m = (0.3 * robot.region.range_m()).min(half_extent_m.max(8.0 * robot.radius_m));
        let half_side_m = half_extent_m + (1.8 * robot.radius_m + seen_m);
        assert!(half_side_m.is_finite(), "poses that were judged are finite");
        Self { centre_m: [x_m, y_m].map(|[low, high]| f64::midpoint(low, high)), half_side_m }
    }

    fn unit_m(&self) -> f64 {
        self.half_side_m / MOST_UNITS
    }

    /// Places as whole numbers of units from the middle, 16 bits each, in base64.
    fn packed(&self, places_m: impl Iterator<Item = [f64; 2]>) -> String {
        let units =
            |value: f64, centre: f64| to_i16((value - centre) / self.unit_m()).to_le_bytes();
        let [x_m, y_m] = self.centre_m;
        let bytes: Vec<u8> =
            places_m.flat_map(|at| [units(at[0], x_m), units(at[1], y_m)].concat()).collect();
        STANDARD.encode(bytes)
    }
}

/// Whether each robot detected something in each sample, by the command that answered it.
fn detections(shown: &Shown) -> Vec<u8> {
    let parameters = shown.conditions.controller.parameters();
    let commands = shown.samples.clone().flat_map(|at| shown.trajectory.commands_at(at));
    // The commands of a machine with states do not tell what was detected, so nothing is shown of it.
    let is_answer =
        |command: &Command| parameters.is_some_and(|it| answers_detection(*command, it));
    let bits: Vec<bool> = commands.map(is_answer).collect();
    let byte =
        |bits: &[bool]| bits.iter().rev().fold(0_u8, |byte, bit| (byte << 1) | u8::from(*bit));
    bits.chunks(8).map(byte).collect()
}

/// Whether a command is the one that answers a detection, rather than the one that answers none, or
/// stands.
fn answers_detection(command: Command, controller: ControllerParameters) -> bool {
    let away = |answer: Command| {
        libm::hypot(
            command.speed_m_s - answer.speed_m_s,
            command.turn_rate_rad_s - answer.turn_rate_rad_s,
        )
    };
    let [detected, undetected] = controller.commands();
    // A robot that was stopped answers nothing, unless standing is an answer of its controller.
    let is_answer = command != Command::STOP || detected == Command::STOP;
    is_answer && away(detected) < away(undetected)
}

fn regions(robot: &SimulatedRobot) -> Vec<Vec<[f64; 2]>> {
    robot.sensors().iter().map(region).collect()
}

/// The outline of a sensor's region as it is turned on the robot, in the robot's frame, in metres.
fn region(sensor: &SimulatedSensor) -> Vec<[f64; 2]> {
    let corners_m = outline(&sensor.region).into_iter();
    if sensor.details.bearing_rad == 0.0 {
        return corners_m.collect();
    }
    corners_m.map(|corner| sensor.in_frame_of_robot(corner).map(rounded)).collect()
}

/// The outline of a region that points ahead, in the robot's frame, in metres.
pub fn outline(region: &Region) -> Vec<[f64; 2]> {
    match region {
        Region::Polygon { corners_m } => {
            corners_m.iter().map(|corner| corner.map(rounded)).collect()
        }
        Region::Cone { half_angle_rad, range_m } => {
            let corner = |step: u32| {
                let share = f64::from(step) / f64::from(ARC_CORNERS);
                let (sine, cosine) = libm::sincos((2.0 * share - 1.0) * half_angle_rad);
                [rounded(range_m * cosine), rounded(range_m * sine)]
            };
            std::iter::once([0.0, 0.0]).chain((0..=ARC_CORNERS).map(corner)).collect()
        }
    }
}

fn seconds(sample: usize, trajectory: &Trajectory) -> f64 {
    rounded(sample as f64 * trajectory.period_s)
}

/// To a tenth of a millimetre, or of a millisecond.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn to_i16(units: f64) -> i16 {
    units.round() as i16
}

fn to_256ths(heading_rad: f64) -> u8 {
    let turns = heading_rad / std::f64::consts::TAU;
    let share = turns - turns.floor();
    ((share * 256.0).round() as u16 % 256) as u8
}

#[cfg(test)]
mod tests {
    use rsrs_core::robot::unicycle::Pose;
    use rsrs_testing::conditions::flockbot_conditions;

    use super::*;

    fn two_robots() -> Trajectory {
        let pose = |x_m, y_m, heading_rad| Pose { x_m, y_m, heading_rad };
        let command = |turn_rate_rad_s| Command { speed_m_s: 0.15, turn_rate_rad_s };
        let mut trajectory = Trajectory::new(0.13, 2);
        for sample in 0..5 {
            let x_m = 0.1 * f64::from(sample);
            trajectory.poses.extend([pose(x_m, 0.0, -0.5), pose(-x_m, 1.0, 7.0)]);
            trajectory.commands.extend([command(0.75), command(-0.75)]);
        }
        trajectory
    }

    fn replay(every: usize) -> Replay {
        of_two_robots(&two_robots(), &flockbot_conditions(), every)
    }

    fn of_two_robots(trajectory: &Trajectory, conditions: &Conditions, every: usize) -> Replay {
        Replay::new(&Shown {
            trajectory,
            conditions,
            robots: vec!["robot_1".to_owned(), "robot_2".to_owned()],
            samples: 0..5,
            every,
            ring: None,
            lost: Vec::new(),
        })
    }

    #[test]
    fn objects_are_packed_as_robots_are_and_goals_have_room() {
        let mut conditions = flockbot_conditions();
        let world = "objects: [{places_m: [[0, 0], [0, 2]], radius_m: 0.1}]\n\
                     goals: [{place_m: [3, 0], radius_m: 0.5}]\n";
        conditions.world = WorldFile::parse("world.yaml", world, &[15.0], &[]).unwrap();
        let mut trajectory = two_robots();
        trajectory.n_objects = 2;
        for sample in 0..5 {
            trajectory.objects_m.extend([[0.0, 0.1 * f64::from(sample)], [0.0, 2.0]]);
        }

        let replay = of_two_robots(&trajectory, &conditions, 2);

        let world = replay.world.as_ref().unwrap();
        assert_eq!(world.radii_m, [0.1, 0.1]);
        assert_eq!(world.goals_m, [[3.0, 0.0, 0.5]]);
        let places = bytes(&world.places);
        assert_eq!(places.len(), 3 * 2 * 2 * 2, "three frames");
        let y_m = |at: usize| {
            let units = i16::from_le_bytes([places[at + 2], places[at + 3]]);
            replay.centre_m[1] + f64::from(units) * replay.unit_m
        };
        assert!((y_m(8) - 0.2).abs() < 1e-3 && (y_m(12) - 2.0).abs() < 1e-3);
        let right_m = replay.centre_m[0] + replay.half_side_m;
        assert!(right_m > 3.5, "{right_m}");
        let json = serde_json::to_string(&self::replay(2)).unwrap();
        assert!(!json.contains("world"), "there is nothing besides robots: {json}");
    }

    #[test]
    fn robots_of_classes_have_their_lids() {
        let mut conditions = flockbot_conditions();
        let world = "classes: [{name: sheep}, {name: dog}]\n";
        conditions.world = WorldFile::parse("world.yaml", world, &[15.0], &[]).unwrap();

        let replay = of_two_robots(&two_robots(), &conditions, 2);

        let classes = replay.classes.as_ref().unwrap();
        assert_eq!(classes.names, ["sheep", "dog"]);
        assert_eq!(classes.lids, [lid(0).hex(), lid(1).hex()]);
        assert_eq!(classes.of_robots, [0, 1]);
        let json = serde_json::to_string(&self::replay(2)).unwrap();
        assert!(!json.contains("classes"), "all robots are alike: {json}");
    }

    #[test]
    fn a_line_of_sight_across_the_hall_leaves_room_for_the_robots() {
        let mut conditions = flockbot_conditions();
        conditions.robot.region = Region::Cone { half_angle_rad: 0.0, range_m: 20.0 };
        let trajectory = two_robots();

        let replay = of_two_robots(&trajectory, &conditions, 2);

        assert!(replay.half_side_m < 1.5, "{} m for robots 1 m apart", replay.half_side_m);
    }

    fn bytes(text: &str) -> Vec<u8> {
        STANDARD.decode(text).unwrap()
    }

    #[test]
    fn places_and_headings_are_those_of_the_run() {
        let replay = replay(2);

        let places = bytes(&replay.places);
        let place_m = |frame: usize, robot: usize, axis: usize| {
            let at = 2 * (2 * (2 * frame + robot) + axis);
            let units = i16::from_le_bytes([places[at], places[at + 1]]);
            replay.centre_m[axis] + f64::from(units) * replay.unit_m
        };
        assert_eq!(places.len(), 3 * 2 * 2 * 2);
        assert!((replay.frame_s - 0.26).abs() < 1e-9);
        for frame in 0..3 {
            let x_m = 0.2 * frame as f64;
            assert!((place_m(frame, 0, 0) - x_m).abs() < 1e-3, "{}", place_m(frame, 0, 0));
            assert!((place_m(frame, 1, 0) + x_m).abs() < 1e-3 && place_m(frame, 1, 1) > 0.999);
        }
        let turn = |heading_rad: f64| f64::from(to_256ths(heading_rad)) / 256.0;
        let headings = bytes(&replay.headings);
        assert_eq!(headings[..2], [to_256ths(-0.5), to_256ths(7.0)]);
        assert!((turn(-0.5) - (1.0 - 0.5 / std::f64::consts::TAU)).abs() < 0.003);
        assert_eq!(to_256ths(-1e-9), 0, "a turn is no turn");
    }

    #[test]
    fn detections_are_those_that_the_commands_answer_at_full_rate() {
        // The first robot turns left in all five samples, the second one right.
        assert_eq!(bytes(&replay(4).detections), [0b0101_0101, 0b01]);
        let controller = flockbot_conditions().controller.parameters().unwrap();
        assert!(!answers_detection(Command::STOP, controller));
    }

    #[test]
    fn a_cone_is_outlined_by_its_arc() {
        let outline = outline(&Region::Cone { half_angle_rad: 0.2, range_m: 0.75 });

        assert_eq!(outline.len(), 14);
        assert!((outline[7][0] - 0.75).abs() < 1e-9 && outline[7][1].abs() < 1e-9);
        assert!(outline[1][1] < 0.0 && outline[13][1] > 0.0);
    }
}
