//! One moment of the world, as viewers see it.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use rsrs_core::conditions::{Conditions, SimulatedRobot, SimulatedSensor};
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::Readings;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{self, Transform, TransformStamped, Vector3};
use rsrs_msgs::std_msgs::Header;
use rsrs_msgs::tf2_msgs::TFMessage;

use super::Names;
use crate::frames::{FRAME, base_link, rotation};

/// Points on the arc of a cone: the widest one is drawn to 0.5 % of its range.
const N_ARC: usize = 17;

/// What all robots look like, and what there is besides them.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Radius of the body, in metres.
    pub radius_m: f64,
    /// The sensors, that of `detection` first.
    pub sensors: Vec<SensorLook>,
    /// The same of robots that are not like the others, by their place.
    pub own_sensors: BTreeMap<usize, Vec<SensorLook>>,
    /// Objects and goals.
    pub world: WorldFile,
    /// Corners of the border of an arena that is no plain square, and of each obstacle, in metres; empty where there are
    /// no such walls.
    pub walls_m: Vec<Vec<[f64; 2]>>,
}

/// What a sensor looks like.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorLook {
    /// Corners of its region in the robot's frame, in metres.
    pub corners_m: Vec<[f64; 2]>,
    /// Its readings, by place among all.
    pub readings: Range<usize>,
}

impl Look {
    /// That of the robots under these conditions.
    pub fn new(conditions: &Conditions) -> Self {
        let sensors = sensors(&conditions.robot);
        let own_robots = conditions.own_robots.iter();
        let own_sensors = own_robots.map(|(place, robot)| (*place, self::sensors(robot))).collect();
        let walls_m = conditions.walls_drawn_m();
        let (radius_m, world) = (conditions.robot.radius_m, conditions.world.clone());
        Self { radius_m, sensors, own_sensors, world, walls_m }
    }

    /// The sensors of one robot.
    pub fn sensors_of(&self, robot: usize) -> &[SensorLook] {
        self.own_sensors.get(&robot).unwrap_or(&self.sensors)
    }
}

fn sensors(robot: &SimulatedRobot) -> Vec<SensorLook> {
    let mut n_readings = 0;
    let look = |sensor: SimulatedSensor| {
        let first = n_readings;
        n_readings += sensor.details.n_readings();
        let corners_m = corners_m(&sensor.region).into_iter();
        let turned = corners_m.map(|corner| sensor.in_frame_of_robot(corner));
        SensorLook { corners_m: turned.collect(), readings: first..n_readings }
    };
    robot.sensors().into_iter().map(look).collect()
}

/// The corners of a region that points ahead.
fn corners_m(region: &Region) -> Vec<[f64; 2]> {
    match region {
        Region::Polygon { corners_m } => corners_m.clone(),
        Region::Cone { half_angle_rad, range_m } => {
            let on_arc = |point: usize| {
                let share = 2.0 * point as f64 / (N_ARC - 1) as f64 - 1.0;
                let (sine, cosine) = libm::sincos(half_angle_rad * share);
                [range_m * cosine, range_m * sine]
            };
            [[0.0, 0.0]].into_iter().chain((0..N_ARC).map(on_arc)).collect()
        }
    }
}

/// One moment of the world.
#[derive(Clone, Debug)]
pub struct Scene {
    /// When.
    pub stamp: Time,
    /// Names of the robots; shape `[n_robots]`.
    pub names: Names,
    /// Whether the simulator moves a robot, and so publishes its frame; shape `[n_robots]`.
    pub is_ours: Arc<[bool]>,
    /// Where they are; shape `[n_robots]`.
    pub poses: Vec<Pose>,
    /// Where objects are, in metres; shape `[n_objects][2]`.
    pub objects_m: Vec<[f64; 2]>,
    /// What the robots' sensors report; shape `[n_robots]`.
    pub readings: Vec<Readings>,
    /// What they look like.
    pub look: Arc<Look>,
    /// What is written above them.
    pub text: String,
}

impl Scene {
    /// The frame of every robot that the simulator moves.
    pub fn frames(&self) -> TFMessage {
        let ours = self.names.iter().zip(&self.poses).zip(self.is_ours.iter());
        let frame = |(name, pose): (&String, &Pose)| TransformStamped {
            header: self.header(),
            child_frame_id: base_link(name),
            transform: Transform {
                translation: Vector3 { x: pose.x_m, y: pose.y_m, z: 0.0 },
                rotation: rotation(pose.heading_rad),
            },
        };
        let ours = ours.filter(|(_, is_ours)| **is_ours);
        TFMessage { transforms: ours.map(|(robot, _)| frame(robot)).collect() }
    }

    /// When and where all of it is.
    pub fn header(&self) -> Header {
        Header { stamp: self.stamp, frame_id: FRAME.to_owned() }
    }
}

/// A point of a robot's frame, on the floor.
pub fn seen_from(pose: &Pose, [x_m, y_m]: [f64; 2]) -> geometry_msgs::Point {
    let (sine, cosine) = libm::sincos(pose.heading_rad);
    geometry_msgs::Point {
        x: pose.x_m + x_m * cosine - y_m * sine,
        y: pose.y_m + x_m * sine + y_m * cosine,
        z: 0.0,
    }
}
