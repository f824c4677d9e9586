//! Robots with several sensors, or with one that is not plain: what each reports.
//!
//! A sensor looks along its bearing, from the robot's centre. In its frame the centre of a robot, an object or a goal
//! is at `(f, l)`, ahead and to the left; all three are discs, and seen as a robot is by any sensor
//! ([`crate::field_of_view`]), an object or a goal also by who is at its centre. A wall is seen where the region
//! reaches it, and is as far away as its nearest point in the region ([`crate::wall_view`]; [`crate::wall_sight`] in arenas
//! that are no squares or have obstacles).
//!
//! What is *hidden*: the disc of a thing that hides others lies across the way from the sensor to the thing that is
//! looked at, touching it, nearer than its end. That way leads to the centre of a disc and to the nearest point of a
//! wall in the region; along a line of sight it is that line, so that the first body that it meets is seen. Walls of a
//! square without obstacles stand around everything and hide nothing; others lie across a way that crosses them.
//!
//! *Nearest*, for a sensor that tells kinds from each other: of discs that one whose centre, less what is seen of it,
//! is nearest, in the order robot, object, goal where they are as near, and of robots the one of the lower number; a
//! disc is nearer than a wall at `w` if its centre is at most `w` and as much as of it is seen away. So a goal is nearest
//! to who is in it.
//!
//! A robot is *kin* to those of its class, and of the *other* ones to all else.
//!
//! All sensors look before any robot moves, with one draw for each sensor, robot and step: the first reading whose share
//! of the row of the confusion table, added up in the order of the readings, is above it is reported, or none.

use rsrs_core::conditions::{Conditions, SimulatedSensor, Walls};
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, Reading, Readings};
use rsrs_core::world::Wall;

use crate::detections::Detections;
use crate::draw::{Key, RunKey, threshold};
use crate::field_of_view::{FieldOfView, seen_radius_m};
use crate::objects::Objects;
use crate::robots::Robots;
use crate::wall_sight::{self, WallSight};
use crate::wall_view::WallView;

/// The sensors of all robots, and what they reported.
pub struct Sensors {
    /// The sensors of each robot; shape `[n_robots][n_sensors]`.
    of_robots: Vec<Vec<Sensor>>,
    /// Radius of each disc of a kind, in metres; shape `[n_kinds][n_discs]`.
    radii_m: [Vec<f32>; N_KINDS],
    /// Where goals are, in metres.
    goals_m: Vec<[f32; 2]>,
    walls: SensedWalls,
    /// Shape `[n_readings]`.
    detections: Vec<Detections>,
    /// What arrived last; shape `[n_robots]`.
    arrived: Vec<Readings>,
}

enum SensedWalls {
    /// Those of a square, so far from the origin, in metres.
    Square(f32),
    /// Those of an arena of another shape, or in which obstacles stand; none where there are no walls.
    Shaped(Vec<Wall>),
}

/// Kinds of discs, in the order in which they are nearest.
const ROBOTS: usize = 0;
const OBJECTS: usize = 1;
const GOALS: usize = 2;
const N_KINDS: usize = 3;

/// A disc: its kind, and which of its kind.
type Disc = (usize, usize);

/// Where all discs are.
#[derive(Clone, Copy)]
struct Floor<'a> {
    robots: &'a Robots,
    /// All x and all y, in metres.
    objects: [&'a [f32]; 2],
    goals_m: &'a [[f32; 2]],
}

/// One sensor of one robot.
struct Sensor {
    key: Key,
    /// Cosine and sine of its bearing.
    bearing: (f32, f32),
    /// Upon each disc of a kind that it detects; shape `[n_kinds][n_discs]`.
    views: [Vec<FieldOfView>; N_KINDS],
    /// How much of each is seen around its centre, in metres; likewise.
    seen_m: [Vec<f32>; N_KINDS],
    wall: WallView,
    sight: WallSight,
    is_line: bool,
    is_hidden_by_walls: bool,
    /// Whether a disc hides things behind it; shape `[n_kinds][n_discs]`.
    hides: [Vec<bool>; N_KINDS],
    /// Its reading of a disc, by place among its own; likewise.
    of_discs: [Vec<Option<usize>>; N_KINDS],
    /// Whether all of them have the same reading, so that which disc is nearest is nothing to it.
    is_of_one: bool,
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
        let classes = conditions.world.classes_of(conditions.robots);
        let of_robot = |robot| {
            let sensors = conditions.robot_at(robot).sensors().into_iter().enumerate();
            let sensor = |(place, sensor): (usize, SimulatedSensor)| {
                Sensor::new(&sensor, (conditions, &classes, robot), run.sensor_key(robot, place))
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
            of_robots: robots.map(of_robot).collect(),
            radii_m: radii_m(conditions)
                .map(|of_kind| of_kind.iter().map(|it| *it as f32).collect()),
            goals_m: (conditions.world.goals.iter())
                .map(|goal| goal.place_m.map(|at_m| at_m as f32))
                .collect(),
            walls: SensedWalls::new(conditions),
            detections: (0..n_readings).map(ring).collect(),
            arrived: vec![Readings::default(); conditions.robots],
        })
    }

    /// Looks with every sensor of every robot.
    pub fn sense(&mut self, robots: &Robots, objects: &Objects, step: u64) {
        let floor = Floor { robots, objects: objects.columns(), goals_m: &self.goals_m };
        for robot in 0..self.of_robots.len() {
            let mut reading = 0;
            for sensor in &self.of_robots[robot] {
                let there = self.there(floor, robot, sensor);
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
    fn there(&self, floor: Floor, robot: usize, sensor: &Sensor) -> Option<usize> {
        let Floor { robots, .. } = floor;
        let (cosine, sine) = (robots.cosine[robot], robots.sine[robot]);
        let (turned_cosine, turned_sine) = sensor.bearing;
        let frame = Frame {
            robot,
            x_m: robots.x_m[robot],
            y_m: robots.y_m[robot],
            cosine: cosine * turned_cosine - sine * turned_sine,
            sine: sine * turned_cosine + cosine * turned_sine,
        };
        let wall_m = sensor.of_wall.and_then(|_| self.wall_m(floor, &frame, sensor));
        let disc = self.nearest_disc(floor, &frame, sensor, wall_m);
        disc.or(sensor.of_wall.filter(|_| wall_m.is_some()))
    }

    /// The reading of the nearest disc that is seen, nearer than the wall, if one is seen.
    fn nearest_disc(
        &self,
        floor: Floor,
        frame: &Frame,
        sensor: &Sensor,
        wall_m: Option<f32>,
    ) -> Option<usize> {
        let mut nearest: Option<(f32, usize)> = None;
        for (kind, of_discs) in sensor.of_discs.iter().enumerate() {
            for (disc, reading) in of_discs.iter().enumerate() {
                let Some(reading) = *reading else { continue };
                let edge_m = self.seen(floor, frame, sensor, ((kind, disc), wall_m));
                if let Some(edge_m) = edge_m
                    && nearest.is_none_or(|(nearest_m, _)| edge_m < nearest_m)
                {
                    if sensor.is_of_one {
                        return Some(reading);
                    }
                    nearest = Some((edge_m, reading));
                }
            }
        }
        nearest.map(|(_, reading)| reading)
    }

    /// How far the edge of a disc is, in metres, if it is seen and nearer than the wall.
    fn seen(
        &self,
        floor: Floor,
        frame: &Frame,
        sensor: &Sensor,
        ((kind, disc), wall_m): (Disc, Option<f32>),
    ) -> Option<f32> {
        let (forward_m, lateral_m) = frame.at(floor.place((kind, disc)));
        let d2_m2 = forward_m * forward_m + lateral_m * lateral_m;
        let seen_m = sensor.seen_m[kind][disc];
        let is_nearest = wall_m.is_none_or(|wall_m| {
            let edge_m = wall_m + seen_m;
            d2_m2 <= edge_m * edge_m
        });
        let way_m = (forward_m, if sensor.is_line { 0.0 } else { lateral_m });
        // Nobody sees itself, but who is at the centre of something else sees that.
        let apart_m2 = if kind == ROBOTS { d2_m2 } else { d2_m2.max(f32::MIN_POSITIVE) };
        let is_seen = is_nearest
            && sensor.views[kind][disc].sees(forward_m, lateral_m, apart_m2)
            && !self.is_hidden(floor, (frame, sensor), (way_m, Some((kind, disc))));
        is_seen.then(|| d2_m2.sqrt() - seen_m)
    }

    /// How far the nearest wall is that is seen, in metres.
    fn wall_m(&self, floor: Floor, frame: &Frame, sensor: &Sensor) -> Option<f32> {
        let mut nearest_m: Option<f32> = None;
        let mut look_at = |there: Option<((f32, f32), f32)>| {
            let Some((point_m, wall_m)) = there else { return };
            let is_nearer = nearest_m.is_none_or(|nearest_m| wall_m < nearest_m);
            if is_nearer && !self.is_hidden(floor, (frame, sensor), (point_m, None)) {
                nearest_m = Some(wall_m);
            }
        };
        match &self.walls {
            SensedWalls::Square(limit_m) => {
                let Frame { x_m, y_m, cosine, sine, .. } = *frame;
                // The outward normal of each wall in the sensor's frame, and how far away the wall is.
                let walls = [
                    ((cosine, -sine), limit_m - x_m),
                    ((-cosine, sine), limit_m + x_m),
                    ((sine, cosine), limit_m - y_m),
                    ((-sine, -cosine), limit_m + y_m),
                ];
                for (normal, gap_m) in walls {
                    look_at(sensor.wall.nearest(normal, gap_m));
                }
            }
            SensedWalls::Shaped(walls) => {
                for wall in walls {
                    let there = sensor.sight.nearest(frame.wall(*wall));
                    look_at(
                        there.map(|([x_m, y_m], away_m)| ((x_m as f32, y_m as f32), away_m as f32)),
                    );
                }
            }
        }
        nearest_m
    }

    /// Whether a wall or a disc that hides things, other than the one that is looked at, lies across the way to a point.
    fn is_hidden(
        &self,
        floor: Floor,
        (frame, sensor): (&Frame, &Sensor),
        (way_m, target): ((f32, f32), Option<Disc>),
    ) -> bool {
        let way2_m2 = way_m.0 * way_m.0 + way_m.1 * way_m.1;
        let lies_across = |third: Disc| {
            if third == (ROBOTS, frame.robot) || Some(third) == target {
                return false;
            }
            let (forward_m, lateral_m) = frame.at(floor.place(third));
            let along_m2 = forward_m * way_m.0 + lateral_m * way_m.1;
            let across_m2 = forward_m * way_m.1 - lateral_m * way_m.0;
            let radius_m = self.radii_m[third.0][third.1];
            (along_m2 > 0.0 && along_m2 < way2_m2)
                && across_m2 * across_m2 <= radius_m * radius_m * way2_m2
        };
        let hiding = sensor.hides.iter().enumerate().flat_map(|(kind, hides)| {
            let discs = hides.iter().enumerate().filter(|(_, hides)| **hides);
            discs.map(move |(disc, _)| (kind, disc))
        });
        let is_behind_wall = || {
            let to_m = [f64::from(way_m.0), f64::from(way_m.1)];
            self.walls.any(|wall| wall_sight::lies_across(frame.wall(wall), to_m))
        };
        hiding.into_iter().any(lies_across) || (sensor.is_hidden_by_walls && is_behind_wall())
    }
}

impl SensedWalls {
    fn new(conditions: &Conditions) -> Self {
        match conditions.free_space() {
            None => Self::Square((conditions.arena.side_m / 2.0) as f32),
            Some(_) if conditions.arena.walls == Walls::None => Self::Shaped(Vec::new()),
            Some(space) => Self::Shaped(space.walls().to_vec()),
        }
    }

    /// Whether something holds of one of the walls that may hide things.
    fn any(&self, holds: impl Fn(Wall) -> bool) -> bool {
        match self {
            Self::Square(_) => false,
            Self::Shaped(walls) => walls.iter().any(|wall| holds(*wall)),
        }
    }
}

impl Floor<'_> {
    /// Where a disc is, in metres.
    fn place(&self, (kind, disc): Disc) -> (f32, f32) {
        match kind {
            ROBOTS => (self.robots.x_m[disc], self.robots.y_m[disc]),
            OBJECTS => (self.objects[0][disc], self.objects[1][disc]),
            _ => (self.goals_m[disc][0], self.goals_m[disc][1]),
        }
    }
}

impl Frame {
    /// Where a place is in the frame, in metres: ahead and to the left.
    fn at(&self, (x_m, y_m): (f32, f32)) -> (f32, f32) {
        let (dx_m, dy_m) = (x_m - self.x_m, y_m - self.y_m);
        (dx_m * self.cosine + dy_m * self.sine, dy_m * self.cosine - dx_m * self.sine)
    }

    /// A wall in the frame.
    fn wall(&self, wall: Wall) -> Wall {
        let [x_m, y_m, cosine, sine] = [self.x_m, self.y_m, self.cosine, self.sine].map(f64::from);
        let at = |[place_x_m, place_y_m]: [f64; 2]| {
            let (dx_m, dy_m) = (place_x_m - x_m, place_y_m - y_m);
            [dx_m * cosine + dy_m * sine, dy_m * cosine - dx_m * sine]
        };
        match wall {
            Wall::Straight(ends) => Wall::Straight(ends.map(at)),
            Wall::Round { centre_m, radius_m } => Wall::Round { centre_m: at(centre_m), radius_m },
        }
    }
}

/// Radius of each disc of a kind, in metres; shape `[n_kinds][n_discs]`.
fn radii_m(conditions: &Conditions) -> [Vec<f64>; N_KINDS] {
    let mut radii_m = [const { Vec::new() }; N_KINDS];
    radii_m[ROBOTS] =
        (0..conditions.robots).map(|robot| conditions.robot_at(robot).radius_m).collect();
    radii_m[OBJECTS] = conditions.world.each_object().map(|object| object.radius_m).collect();
    radii_m[GOALS] = conditions.world.goals.iter().map(|goal| goal.radius_m).collect();
    radii_m
}

/// Whether a disc is of a kind of thing, to a robot.
fn is_a(thing: Detects, (kind, disc): Disc, (classes, robot): (&[usize], usize)) -> bool {
    match thing {
        Detects::Robot => kind == ROBOTS,
        Detects::Kin => kind == ROBOTS && classes.get(disc) == classes.get(robot),
        Detects::Other => kind == ROBOTS && classes.get(disc) != classes.get(robot),
        Detects::Object => kind == OBJECTS,
        Detects::Goal => kind == GOALS,
        Detects::Wall => false,
    }
}

/// Something of each disc; shape `[n_kinds][n_discs]`.
fn each_disc<T>(radii_m: &[Vec<f64>; N_KINDS], of: impl Fn(Disc) -> T) -> [Vec<T>; N_KINDS] {
    std::array::from_fn(|kind| (0..radii_m[kind].len()).map(|disc| of((kind, disc))).collect())
}

impl Sensor {
    /// A sensor of a robot.
    ///
    /// * `classes` — of all robots; shape `[n_robots]`, or empty where there are none.
    fn new(
        sensor: &SimulatedSensor,
        (conditions, classes, robot): (&Conditions, &[usize], usize),
        key: Key,
    ) -> Self {
        let details = &sensor.details;
        let (sine, cosine) = libm::sincos(details.bearing_rad);
        let seen_m = |radius_m: &f64| seen_radius_m(sensor.sees, *radius_m);
        let radii_m = radii_m(conditions);
        let view = |radius_m: &f64| FieldOfView::from_region(&sensor.region, seen_m(radius_m));
        let readings = sensor.readings();
        let of = |disc| readings.iter().position(|it| is_a(it.detects, disc, (classes, robot)));
        let of_discs = each_disc(&radii_m, of);
        let hides =
            |disc| details.hidden_by.iter().any(|thing| is_a(*thing, disc, (classes, robot)));
        let mut found = of_discs.iter().flatten().flatten();
        let first = found.next();
        let is_of_one = found.all(|reading| Some(reading) == first);
        Self {
            key,
            bearing: (cosine as f32, sine as f32),
            views: radii_m.each_ref().map(|of_kind| of_kind.iter().map(view).collect()),
            seen_m: (radii_m.each_ref())
                .map(|of_kind| of_kind.iter().map(|radius_m| seen_m(radius_m) as f32).collect()),
            wall: WallView::new(&sensor.region),
            sight: WallSight::new(&sensor.region),
            is_hidden_by_walls: details.hidden_by.contains(&Detects::Wall),
            is_line: matches!(sensor.region, Region::Cone { half_angle_rad: 0.0, .. }),
            hides: each_disc(&radii_m, hides),
            of_discs,
            is_of_one,
            of_wall: readings.iter().position(|reading| reading.detects == Detects::Wall),
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
