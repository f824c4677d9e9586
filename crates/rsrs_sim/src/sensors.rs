//! Robots with several sensors, or with one that is not plain: what each reports.
//!
//! A sensor looks along its bearing, from the robot's centre. In its frame a robot is at `(f, l)`, ahead and to the
//! left, and is seen as by any sensor ([`crate::field_of_view`]). A wall is seen where the region reaches it, and is as far
//! away as its nearest point in the region ([`crate::wall_view`]).
//!
//! What is *hidden*: the body of a third robot lies across the way from the sensor to the thing, touching it, nearer than
//! its end. That way leads to the centre of a robot and to the nearest point of a wall in the region; along a line of sight
//! it is that line, so that the first body that it meets is seen. Walls stand around everything and hide nothing.
//!
//! *Nearest*, for a sensor that tells kinds from each other: a robot is nearer than a wall at `w` if its centre is at most
//! `w` and as much as of its body is seen away.
//!
//! All sensors look before any robot moves, with one draw for each sensor, robot and step: the first reading whose share
//! of the row of the confusion table, added up in the order of the readings, is above it is reported, or none.

use rsrs_core::conditions::{Conditions, SimulatedRobot, SimulatedSensor};
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, Reading, Readings};

use crate::detections::Detections;
use crate::draw::{Key, RunKey, threshold};
use crate::field_of_view::{FieldOfView, seen_radius_m};
use crate::robots::Robots;
use crate::wall_view::WallView;

/// The sensors of all robots, and what they reported.
pub struct Sensors {
    /// The sensors of each robot; shape `[n_robots][n_sensors]`.
    of_robots: Vec<Vec<Sensor>>,
    /// Radius of each body, in metres; shape `[n_robots]`.
    bodies_m: Vec<f32>,
    /// From the origin to each wall, in metres.
    walls_m: f32,
    /// Shape `[n_readings]`.
    detections: Vec<Detections>,
    /// What arrived last; shape `[n_robots]`.
    arrived: Vec<Readings>,
}

/// One sensor of one robot.
struct Sensor {
    key: Key,
    /// Cosine and sine of its bearing.
    bearing: (f32, f32),
    /// Upon each robot; shape `[n_robots]`.
    views: Vec<FieldOfView>,
    /// How much of each robot is seen around its centre, in metres; shape `[n_robots]`.
    seen_m: Vec<f32>,
    wall: WallView,
    is_line: bool,
    is_hidden_by_robots: bool,
    /// Its reading of a kind, by place among its own.
    of_robot: Option<usize>,
    of_wall: Option<usize>,
    /// For each of its readings, and for nothing as the last: thresholds of a draw, one for each reading.
    confusion: Vec<Vec<u32>>,
}

/// Where a robot's sensor is, and where it looks.
struct Frame {
    robot: usize,
    x_m: f32,
    y_m: f32,
    cosine: f32,
    sine: f32,
}

impl Sensors {
    /// The sensors of a world; `None` if each robot has one plain sensor.
    pub fn new(conditions: &Conditions, run: RunKey) -> Option<Self> {
        if conditions.have_one_plain_sensor() {
            return None;
        }
        let robots = 0..conditions.robots;
        let of_robot = |robot| {
            let sensors = conditions.robot_at(robot).sensors().into_iter().enumerate();
            let sensor = |(place, sensor): (usize, SimulatedSensor)| {
                Sensor::new(&sensor, conditions, run.sensor_key(robot, place))
            };
            sensors.map(sensor).collect()
        };
        // A ring for each reading, with the latency that its sensor has on each robot.
        let latencies = |robot: usize| -> Vec<u32> {
            let sensors = conditions.robot_at(robot).sensors();
            let readings = |it: &SimulatedSensor| vec![it.latency_steps; it.details.n_readings()];
            sensors.iter().flat_map(readings).collect()
        };
        let latencies: Vec<Vec<u32>> = robots.clone().map(latencies).collect();
        let ring = |reading: usize| {
            let of_robots: Vec<u32> = latencies.iter().map(|robot| robot[reading]).collect();
            Detections::with_latencies(&of_robots)
        };
        let n_readings = conditions.robot.reading_names().n_readings();
        Some(Self {
            of_robots: robots.clone().map(of_robot).collect(),
            bodies_m: robots.map(|robot| conditions.robot_at(robot).radius_m as f32).collect(),
            walls_m: (conditions.arena.side_m / 2.0) as f32,
            detections: (0..n_readings).map(ring).collect(),
            arrived: vec![Readings::default(); conditions.robots],
        })
    }

    /// Looks with every sensor of every robot.
    pub fn sense(&mut self, robots: &Robots, step: u64) {
        for robot in 0..self.of_robots.len() {
            let mut reading = 0;
            for sensor in &self.of_robots[robot] {
                let there = self.there(robots, robot, sensor);
                let reported = sensor.reported(there, step);
                for place in 0..sensor.n_readings() {
                    let is_reported = reported == Some(place);
                    self.detections[reading + place].row_mut(step)[robot] = is_reported;
                }
                reading += sensor.n_readings();
            }
        }
        for (reading, detections) in self.detections.iter_mut().enumerate() {
            detections.overtake(step);
            let arrived = self.arrived.iter_mut().zip(detections.delivered(step));
            arrived.for_each(|(readings, is_detected)| readings.set(reading, *is_detected));
        }
    }

    /// What arrived; shape `[n_robots]`.
    pub fn arrived(&self) -> &[Readings] {
        &self.arrived
    }

    /// What arrived of `detection`; shape `[n_robots]`.
    pub fn detection(&self, step: u64) -> &[bool] {
        self.detections[0].delivered(step)
    }

    /// All that was made before a step and arrives in it or later, reading by reading.
    pub fn under_way(&self, step: u64) -> impl Iterator<Item = &bool> {
        self.detections.iter().flat_map(move |detections| detections.under_way(step))
    }

    /// Of which of a sensor's readings a thing is there.
    fn there(&self, robots: &Robots, robot: usize, sensor: &Sensor) -> Option<usize> {
        let (cosine, sine) = (robots.cosine[robot], robots.sine[robot]);
        let (turned_cosine, turned_sine) = sensor.bearing;
        let frame = Frame {
            robot,
            x_m: robots.x_m[robot],
            y_m: robots.y_m[robot],
            cosine: cosine * turned_cosine - sine * turned_sine,
            sine: sine * turned_cosine + cosine * turned_sine,
        };
        let wall_m = sensor.of_wall.and_then(|_| self.wall_m(robots, &frame, sensor));
        let is_robot = sensor.of_robot.is_some() && self.sees_robot(robots, &frame, sensor, wall_m);
        if is_robot { sensor.of_robot } else { sensor.of_wall.filter(|_| wall_m.is_some()) }
    }

    /// Whether a robot is seen that is nearer than the wall, if one is seen.
    fn sees_robot(
        &self,
        robots: &Robots,
        frame: &Frame,
        sensor: &Sensor,
        wall_m: Option<f32>,
    ) -> bool {
        (0..self.bodies_m.len()).any(|other| {
            let (forward_m, lateral_m) = frame.at(robots, other);
            let d2_m2 = forward_m * forward_m + lateral_m * lateral_m;
            let is_nearest = wall_m.is_none_or(|wall_m| {
                let edge_m = wall_m + sensor.seen_m[other];
                d2_m2 <= edge_m * edge_m
            });
            let way_m = (forward_m, if sensor.is_line { 0.0 } else { lateral_m });
            is_nearest
                && sensor.views[other].sees(forward_m, lateral_m, d2_m2)
                && !(sensor.is_hidden_by_robots
                    && self.is_hidden(robots, frame, (way_m, Some(other))))
        })
    }

    /// How far the nearest wall is that is seen, in metres.
    fn wall_m(&self, robots: &Robots, frame: &Frame, sensor: &Sensor) -> Option<f32> {
        let Frame { x_m, y_m, cosine, sine, .. } = *frame;
        let limit_m = self.walls_m;
        // The outward normal of each wall in the sensor's frame, and how far away the wall is.
        let walls = [
            ((cosine, -sine), limit_m - x_m),
            ((-cosine, sine), limit_m + x_m),
            ((sine, cosine), limit_m - y_m),
            ((-sine, -cosine), limit_m + y_m),
        ];
        let mut nearest_m: Option<f32> = None;
        for (normal, gap_m) in walls {
            let Some((point_m, wall_m)) = sensor.wall.nearest(normal, gap_m) else { continue };
            let is_nearer = nearest_m.is_none_or(|nearest_m| wall_m < nearest_m);
            if is_nearer
                && !(sensor.is_hidden_by_robots && self.is_hidden(robots, frame, (point_m, None)))
            {
                nearest_m = Some(wall_m);
            }
        }
        nearest_m
    }

    /// Whether the body of a robot, other than the one that is looked at, lies across the way to a point.
    fn is_hidden(
        &self,
        robots: &Robots,
        frame: &Frame,
        (way_m, target): ((f32, f32), Option<usize>),
    ) -> bool {
        let way2_m2 = way_m.0 * way_m.0 + way_m.1 * way_m.1;
        (0..self.bodies_m.len()).any(|third| {
            if third == frame.robot || Some(third) == target {
                return false;
            }
            let (forward_m, lateral_m) = frame.at(robots, third);
            let along_m2 = forward_m * way_m.0 + lateral_m * way_m.1;
            let across_m2 = forward_m * way_m.1 - lateral_m * way_m.0;
            let body_m = self.bodies_m[third];
            (along_m2 > 0.0 && along_m2 < way2_m2)
                && across_m2 * across_m2 <= body_m * body_m * way2_m2
        })
    }
}

impl Frame {
    /// Where a robot is in the frame, in metres: ahead and to the left.
    fn at(&self, robots: &Robots, other: usize) -> (f32, f32) {
        let (dx_m, dy_m) = (robots.x_m[other] - self.x_m, robots.y_m[other] - self.y_m);
        (dx_m * self.cosine + dy_m * self.sine, dy_m * self.cosine - dx_m * self.sine)
    }
}

impl Sensor {
    fn new(sensor: &SimulatedSensor, conditions: &Conditions, key: Key) -> Self {
        let details = &sensor.details;
        let (sine, cosine) = libm::sincos(details.bearing_rad);
        let robots = (0..conditions.robots).map(|robot| conditions.robot_at(robot));
        let seen_m = |robot: &SimulatedRobot| seen_radius_m(sensor.sees, robot.radius_m);
        let views = robots.clone().map(|robot| FieldOfView::of(&sensor.region, seen_m(robot)));
        let readings = sensor.readings();
        let of = |kind| readings.iter().position(|reading| reading.detects == kind);
        Self {
            key,
            bearing: (cosine as f32, sine as f32),
            views: views.collect(),
            seen_m: robots.map(|robot| seen_m(robot) as f32).collect(),
            wall: WallView::new(&sensor.region),
            is_line: matches!(sensor.region, Region::Cone { half_angle_rad: 0.0, .. }),
            is_hidden_by_robots: details.hidden_by.contains(&Detects::Robot),
            of_robot: of(Detects::Robot),
            of_wall: of(Detects::Wall),
            confusion: confusion(&readings),
        }
    }

    fn n_readings(&self) -> usize {
        self.confusion.len() - 1
    }

    /// Which of its readings it reports where a thing of one of them is, or nothing.
    fn reported(&self, there: Option<usize>, step: u64) -> Option<usize> {
        let draw = self.key.uniform24(step as u32);
        let row = &self.confusion[there.unwrap_or(self.n_readings())];
        row.iter().position(|limit| draw < *limit)
    }
}

/// The confusion table, added up along each row.
fn confusion(readings: &[Reading]) -> Vec<Vec<u32>> {
    let row = |probability: &dyn Fn(&Reading) -> f64| {
        let mut sum = 0.0;
        let mut limit = |reading: &Reading| {
            sum += probability(reading);
            threshold(f64::min(sum, 1.0))
        };
        readings.iter().map(&mut limit).collect::<Vec<u32>>()
    };
    let of_kind = |there: &Reading| {
        row(&|reading| {
            if reading.name == there.name {
                there.true_positive
            } else {
                there.taken_for.get(&reading.name).copied().unwrap_or_default()
            }
        })
    };
    let nothing = row(&|reading| reading.false_positive);
    readings.iter().map(of_kind).chain(std::iter::once(nothing)).collect()
}
