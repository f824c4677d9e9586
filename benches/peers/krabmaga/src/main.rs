//! The mill on krABMaga: its schedule, its field with neighbours, one agent for each robot.
//!
//! Robots, sensor, contact and placement are those of `rsrs_benches::flockbots`; draws come from a
//! small generator of its own. Prints one line: name, robots, agent-steps, CPU seconds.

use std::any::Any;
use std::fmt;
use std::hash::{Hash, Hasher};

use krabmaga::engine::agent::Agent;
use krabmaga::engine::fields::field::Field;
use krabmaga::engine::fields::field_2d::{Field2D, Location2D};
use krabmaga::engine::location::Real2D;
use krabmaga::engine::schedule::Schedule;
use krabmaga::engine::state::State;

const SIDE_M: f32 = 15.0;
const BODY_M: f32 = 0.075;
const RANGE_M: f32 = 0.75;
const HALF_ANGLE_RAD: f32 = 0.2;
const FRONT_RAD: f32 = 70.0 * std::f32::consts::PI / 180.0;
const SPEED_M_S: f32 = 0.15;
const TURN_RATE_RAD_S: f32 = 0.75;
const PERIOD_S: f32 = 0.13;
const TRUE_POSITIVE: f32 = 0.80;
const FALSE_POSITIVE: f32 = 0.08;

#[derive(Clone, Copy)]
struct Robot {
    id: u32,
    at: Real2D,
    heading_rad: f32,
    speed_gain: f32,
    turn_gain: f32,
    draw: u32,
}

impl Robot {
    /// A number from 0 to 1.
    fn uniform(&mut self) -> f32 {
        self.draw ^= self.draw << 13;
        self.draw ^= self.draw >> 17;
        self.draw ^= self.draw << 5;
        (self.draw >> 8) as f32 / 16_777_216.0
    }
}

impl Agent for Robot {
    fn step(&mut self, state: &mut dyn State) {
        let world = state.as_any().downcast_ref::<World>().expect("there is one kind of state");
        let (sine, cosine) = self.heading_rad.sin_cos();
        let (edge_y, edge_x) = HALF_ANGLE_RAD.sin_cos();
        let (reach_m, contact_m) = (RANGE_M + BODY_M, 2.0 * BODY_M);
        let (mut seen, mut blocked) = (false, false);
        for other in world.field.get_neighbors_within_relax_distance(self.at, reach_m) {
            if other.id == self.id {
                continue;
            }
            let (dx, dy) = (other.at.x - self.at.x, other.at.y - self.at.y);
            let d2 = dx * dx + dy * dy;
            let forward = dx * cosine + dy * sine;
            let lateral = dy * cosine - dx * sine;
            // From the edge of the cone, and along it.
            let beside = lateral.abs() * edge_x - forward * edge_y;
            let along = lateral.abs() * edge_y + forward * edge_x;
            let beyond = along - along.clamp(0.0, RANGE_M);
            let touches = beside * beside + beyond * beyond <= BODY_M * BODY_M;
            seen |= d2 <= reach_m * reach_m && (beside <= 0.0 || touches);
            blocked |= d2 < contact_m * contact_m && forward > FRONT_RAD.cos() * d2.sqrt();
        }
        let detected = self.uniform() < if seen { TRUE_POSITIVE } else { FALSE_POSITIVE };
        if !blocked {
            let travel_m = SPEED_M_S * self.speed_gain * PERIOD_S;
            let (x, y) = (self.at.x + travel_m * cosine, self.at.y + travel_m * sine);
            let is_inside = |c: f32| (BODY_M..=SIDE_M - BODY_M).contains(&c);
            if is_inside(x) && is_inside(y) {
                self.at = Real2D { x, y };
            }
        }
        let turn_rate_rad_s = if detected { TURN_RATE_RAD_S } else { -TURN_RATE_RAD_S };
        self.heading_rad += turn_rate_rad_s * self.turn_gain * PERIOD_S;
        world.field.set_object_location(*self, self.at);
    }
}

impl Hash for Robot {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        self.id.hash(hasher);
    }
}

impl PartialEq for Robot {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Eq for Robot {}

impl fmt::Display for Robot {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "robot {}", self.id)
    }
}

impl Location2D<Real2D> for Robot {
    fn get_location(self) -> Real2D {
        self.at
    }
    fn set_location(&mut self, at: Real2D) {
        self.at = at;
    }
}

struct World {
    field: Field2D<Robot>,
    n_robots: u32,
}

impl World {
    fn new(n_robots: u32) -> Self {
        Self { field: Field2D::new(SIDE_M, SIDE_M, RANGE_M + BODY_M, false), n_robots }
    }
}

impl State for World {
    fn init(&mut self, schedule: &mut Schedule) {
        let mut robot = Robot {
            id: 0,
            at: Real2D::default(),
            heading_rad: 0.0,
            speed_gain: 0.97,
            turn_gain: 0.97,
            draw: 0x9e37_79b9,
        };
        let radius_m = 0.825 * (self.n_robots as f32 / 9.0).sqrt();
        let mut places: Vec<Real2D> = Vec::new();
        while robot.id < self.n_robots {
            let bearing_rad = robot.uniform() * std::f32::consts::TAU;
            let from_centre_m = radius_m * robot.uniform().sqrt();
            let (sine, cosine) = bearing_rad.sin_cos();
            let middle_m = SIDE_M / 2.0;
            let at = Real2D {
                x: middle_m + from_centre_m * cosine,
                y: middle_m + from_centre_m * sine,
            };
            let is_free = |place: &Real2D| (place.x - at.x).hypot(place.y - at.y) >= 2.2 * BODY_M;
            if !places.iter().all(is_free) {
                continue;
            }
            places.push(at);
            (robot.at, robot.heading_rad) = (at, bearing_rad);
            robot.speed_gain = 0.97 + 0.1 * (robot.uniform() - 0.5);
            robot.turn_gain = 0.97 + 0.1 * (robot.uniform() - 0.5);
            self.field.set_object_location(robot, at);
            schedule.schedule_repeating(Box::new(robot), 0.0, 0);
            robot.id += 1;
        }
    }
    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
    fn as_any(&self) -> &dyn Any {
        self
    }
    fn as_state_mut(&mut self) -> &mut dyn State {
        self
    }
    fn as_state(&self) -> &dyn State {
        self
    }
    fn reset(&mut self) {
        *self = Self::new(self.n_robots);
    }
    fn update(&mut self, _step: u64) {
        self.field.lazy_update();
    }
}

/// CPU time of this thread, in seconds, as Linux counts it.
fn cpu_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux counts it");
    let on_cpu = text.split_whitespace().next().expect("three numbers");
    on_cpu.parse::<f64>().expect("nanoseconds") * 1e-9
}

fn main() {
    let n_robots: u32 = match std::env::args().nth(1) {
        Some(text) => text.parse().expect("a number of robots"),
        None => 9,
    };
    let mut world = World::new(n_robots);
    let mut schedule = Schedule::new();
    world.init(&mut schedule);
    let n_steps = 900_000 / u64::from(n_robots);
    let start_s = cpu_s();
    for _ in 0..n_steps {
        schedule.step(&mut world);
    }
    let elapsed_s = cpu_s() - start_s;
    println!("krABMaga 0.6 (Rust),{n_robots},{},{elapsed_s:.4}", n_steps * u64::from(n_robots));
}
