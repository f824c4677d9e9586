//! The reference world: a swarm in single precision, defined to the bit.
//!
//! Any faster kernel must pass through exactly these states. So the order of operations is part of
//! the definition, and there is no fused multiply-add, no platform function, no square root in the
//! pair loop, and no sum over robots: only `+ - * /`, compare and select.
//!
//! **Sense**, for every robot, before any robot moves. For every robot `'`, itself included (at
//! distance zero it is neither in front nor a neighbour, so it is neither seen nor in the way):
//! ```text
//! dx = x' - x                      dy = y' - y
//! d2 = dx*dx + dy*dy               forward = dx*cos + dy*sin       lateral = dy*cos - dx*sin
//! seen    |= region(forward, lateral, d2)                          see `field_of_view`
//! ahead   |= d2 < (2r)² and forward*|forward| > cosφ|cosφ| * d2    see `contact`
//! behind  |= the same with -forward
//! ```
//! then `detection = uniform24(step) < (seen ? true_positive : false_positive)`, delivered
//! `latency_steps` later; until the first arrives, nothing is detected.
//!
//! **Advance**, with one command `(u1, u2)` for each robot, rounded to single precision once:
//! ```text
//! blocked = u1 < 0 ? behind : ahead
//! travel = blocked ? 0 : (u1 * (gain1 + sd*normal)) * dt
//! to     = (x + travel*cos, y + travel*sin)          the heading before the turn
//! gust   = decay*gust + kick*normal                  to += gust * dt, also when blocked
//! (x, y) = border(from, to)                          with friction: see `contact`
//! rate   = u2 * (gain2 + sd*normal) + bias
//! yaw    = yaw + (rate - yaw) * share                if there is a lag; then rate = yaw
//! angle  = rate*dt + sd*normal
//! (c, s) = turn(angle)
//! (cos, sin) = (cos*c - sin*s, sin*c + cos*s) * (1.5 - 0.5*(cos² + sin²))
//! ```
//! The last factor is one Newton step that keeps the heading's length at one. A term whose standard
//! deviation is zero is left out altogether, addition and draw.
//!
//! Where robots have profiles of their own, each is sensed for and moved by its own numbers, and two
//! radii take the place of `2r`: the neighbour's is the one by which a body is seen.
//!
//! Where robots have several sensors, or one that is not plain, `crate::sensors` has what each reports.
//!
//! In arenas that are no squares, and where obstacles stand, [`crate::shaped_border`] is the border.
//!
//! Where robots fail, [`crate::failures`] has which; who stands is left out of all of *advance*.
//!
//! Where robots push each other, or objects, [`crate::pushing`] has the last word on `(x, y)`; where they pass through
//! each other, or push, nobody is ahead or behind.
//!
//! # Source
//!
//! `eq:disc_kine`, `eq:disc_func`, `eq:output`, §IV step 2.

mod displace;

use rsrs_core::conditions::Conditions;
use rsrs_core::digest::Digest;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::sensor::Readings;
use rsrs_core::robot::unicycle::Pose;

use crate::contact::{Blocked, Contact};
use crate::detections::Detections;
use crate::draw::{RunKey, Seed};
use crate::failures::Failures;
use crate::field_of_view::FieldOfView;
use crate::grid::{self, Grid, REORDERED_EVERY};
use crate::kinds::{self, Kinds};
use crate::numbering::Numbering;
use crate::objects::Objects;
use crate::placement::{self, PlacementError};
use crate::pushing::Pushing;
use crate::robots::{Drive, Robots, WorldParameters};
use crate::sensors::Sensors;

/// A swarm of robots, one step at a time.
///
/// # Example
///
/// ```
/// use rsrs_core::conditions::Conditions;
/// use rsrs_sim::{controllers::Controllers, draw::Seed, world::World};
///
/// let conditions = Conditions::flockbots(9);
/// let seed = Seed { seed: 1, replicate: 0 };
/// let mut world = World::new(&conditions, seed)?;
/// let mut controllers = Controllers::new(&conditions, seed);
/// for _ in 0..100 {
///     let mut commands = Vec::new();
///     controllers.decide(world.sense_all(), &mut commands);
///     world.advance(&commands);
/// }
/// assert_eq!(world.step_index(), 100);
/// assert!(world.poses().all(|pose| pose.x_m.hypot(pose.y_m) < 5.0));
/// # Ok::<(), rsrs_sim::placement::PlacementError>(())
/// ```
pub struct World {
    rules: WorldParameters,
    step: u64,
    /// The robots place by place, as what they see and what blocks them.
    robots: Robots,
    seen: Vec<bool>,
    blocked_at: Vec<Blocked>,
    numbering: Numbering,
    /// The same, robot by robot.
    blocked: Vec<bool>,
    detections: Detections,
    is_sensed: bool,
    /// For swarms that are worth it, of robots that are alike.
    grid: Option<Grid>,
    /// Where robots are not all alike; then the rules above are those of nobody, and places are robots.
    kinds: Option<Kinds>,
    /// Where somebody pushes or is pushed.
    pushing: Option<Pushing>,
    objects: Objects,
    /// Where a robot has more than one plain sensor; then the detections above are nobody's, and places are robots.
    sensors: Option<Sensors>,
    /// What was sensed last, robot by robot.
    readings: Vec<Readings>,
    /// Where robots fail.
    failures: Option<Failures>,
}

impl World {
    /// Places the robots and draws their idiosyncrasies.
    pub fn new(conditions: &Conditions, seed: Seed) -> Result<Self, PlacementError> {
        let run = RunKey::new(seed, conditions.digest());
        let poses = placement::place(conditions, run)?;
        let objects = Objects::at(&placement::place_objects(conditions, run, &poses)?);
        let n_robots = conditions.robots;
        let rules = WorldParameters::new(conditions);
        let sensors = Sensors::new(conditions, run);
        let is_plain = conditions.are_robots_alike() && sensors.is_none();
        let is_worth_it = n_robots >= grid::WORTH_FROM && is_plain;
        let grid = is_worth_it.then(|| Grid::new(&rules.view, rules.contact));
        Ok(Self {
            rules,
            step: 0,
            robots: Robots::new(conditions, run, &poses),
            seen: vec![false; n_robots],
            blocked_at: vec![Blocked::default(); n_robots],
            numbering: Numbering::new(n_robots),
            blocked: vec![false; n_robots],
            detections: kinds::detections(conditions),
            is_sensed: false,
            grid: grid.flatten(),
            kinds: Kinds::new(conditions),
            pushing: Pushing::new(conditions),
            objects,
            sensors,
            readings: vec![Readings::default(); n_robots],
            failures: Failures::new(conditions, run),
        })
    }

    /// Number of robots.
    pub fn n_robots(&self) -> usize {
        self.robots.x_m.len()
    }

    /// Steps made so far.
    pub fn step_index(&self) -> u64 {
        self.step
    }

    /// Senses for all robots: what the sensor of each reports now, `y`, and of several sensors that
    /// of `detection`. Shape `[n_robots]`. Sensing again before the next step changes nothing.
    pub fn sense(&mut self) -> &[bool] {
        if self.step.is_multiple_of(REORDERED_EVERY) {
            self.reorder();
        }
        let Self { rules, robots, seen, blocked_at, grid, kinds, .. } = self;
        let found = (seen.as_mut_slice(), blocked_at.as_mut_slice());
        let robots = &*robots;
        let around = (robots, rules.contact, grid.as_mut());
        match (kinds, &rules.view) {
            (Some(kinds), _) => kinds.sense(robots, found),
            (None, FieldOfView::Cone(cone)) => {
                let sees = |forward, lateral, d2| cone.sees(forward, lateral, d2);
                sense_with(around, found, sees);
            }
            (None, FieldOfView::Polygon(polygon)) => {
                let sees = |forward, lateral, d2| polygon.sees(forward, lateral, d2);
                sense_with(around, found, sees);
            }
        }
        self.is_sensed = true;
        for (place, robot) in self.numbering.robots().iter().enumerate() {
            self.blocked[*robot as usize] = self.blocked_at[place].ahead;
        }
        if let Some(sensors) = &mut self.sensors {
            sensors.sense(&self.robots, &self.objects, self.step);
            let Some(failures) = &mut self.failures else { return sensors.detection(self.step) };
            failures.take(self.step, sensors.arrived().iter().copied());
            return failures.detection();
        }
        let row = self.detections.row_mut(self.step);
        let keys = &self.robots.detection_keys;
        for (place, robot) in self.numbering.robots().iter().enumerate() {
            let robot = *robot as usize;
            let is_seen = self.seen[place];
            let rules = self.kinds.as_ref().map_or(&self.rules, |kinds| kinds.rules_for(robot));
            let limit = if is_seen { rules.true_positive } else { rules.false_positive };
            row[robot] = keys[place].uniform24(self.step as u32) < limit;
        }
        self.detections.overtake(self.step);
        let delivered = self.detections.delivered(self.step);
        let Some(failures) = &mut self.failures else { return delivered };
        failures.take(self.step, delivered.iter().copied().map(Readings::from));
        failures.detection()
    }

    /// As [`Self::sense`], with what all sensors of each robot report now; shape `[n_robots]`.
    pub fn sense_all(&mut self) -> &[Readings] {
        self.sense();
        if let Some(failures) = &self.failures {
            return failures.readings();
        }
        if let Some(sensors) = &self.sensors {
            return sensors.arrived();
        }
        let arrived = self.readings.iter_mut().zip(self.detections.delivered(self.step));
        arrived.for_each(|(readings, detected)| *readings = Readings::from(*detected));
        &self.readings
    }

    /// Keeps the robots of a large swarm in the order of their cells.
    fn reorder(&mut self) {
        if let Some(order) = self.grid.as_mut().and_then(|grid| grid.order(&self.robots)) {
            self.robots.reorder(order);
            self.numbering.reorder(order);
        }
    }

    /// Which robots could not drive forward when they last sensed; shape `[n_robots]`.
    pub fn blocked(&self) -> &[bool] {
        &self.blocked
    }

    /// Moves every robot by one control period, by one command each; shape `[n_robots]`.
    ///
    /// # Panics
    ///
    /// If the world was not sensed since the last step, if the number of commands is not the number
    /// of robots, or if a command is not finite in single precision.
    pub fn advance(&mut self, commands: &[Command]) {
        assert!(self.is_sensed, "every robot senses before any robot moves");
        assert_eq!(commands.len(), self.n_robots(), "one command for each robot");
        if let Some(pushing) = &mut self.pushing {
            pushing.begin([&self.robots.x_m, &self.robots.y_m], self.objects.columns());
        }
        for (place, robot) in self.numbering.robots().iter().enumerate() {
            let command = commands[*robot as usize];
            let speed_m_s = command.speed_m_s as f32;
            let turn_rate_rad_s = command.turn_rate_rad_s as f32;
            assert!(
                speed_m_s.is_finite() && turn_rate_rad_s.is_finite(),
                "the command of robot {robot} is not finite: {command:?}"
            );
            let is_blocked = self.blocked_at[place].at(speed_m_s);
            let stands = |failures: &Failures| failures.stands(*robot as usize, self.step);
            if self.failures.as_ref().is_some_and(stands) {
                continue;
            }
            let drive = Drive { speed_m_s, turn_rate_rad_s, is_blocked, step: self.step as u32 };
            let rules = match &self.kinds {
                None => &self.rules,
                Some(kinds) => kinds.rules_for(*robot as usize),
            };
            self.robots.advance(rules, place, drive);
        }
        if let Some(pushing) = &mut self.pushing {
            let robots = [self.robots.x_m.as_mut_slice(), self.robots.y_m.as_mut_slice()];
            pushing.settle(robots, self.objects.columns_mut());
        }
        self.step += 1;
        self.is_sensed = false;
    }

    /// Names the state: equal digests after the same number of steps mean equal futures under equal
    /// commands.
    ///
    /// It covers the step, position and heading of every robot and the position of every object to the bit, and what
    /// these do not show: gusts, lagging turning rates, detections under way and at which sensors stick, where there are any.
    pub fn digest(&self) -> u64 {
        let robots = &self.robots;
        let mut columns = vec![&robots.x_m, &robots.y_m, &robots.cosine, &robots.sine];
        let rules = self.kinds.as_ref().map_or(std::slice::from_ref(&self.rules), Kinds::rules);
        if rules.iter().any(|rules| rules.gusts.is_some()) {
            columns.extend([&robots.gust_x_m_s, &robots.gust_y_m_s]);
        }
        if rules.iter().any(|rules| rules.yaw_share.is_some()) {
            columns.push(&robots.yaw_rate_rad_s);
        }
        let numbers = columns.into_iter().flat_map(|column| self.numbering.by_robot(column));
        let numbers = numbers.chain(self.objects.columns().into_iter().flatten().copied());
        let stuck = self.failures.iter().flat_map(Failures::stuck);
        if let Some(sensors) = &self.sensors {
            return digest(self.step, numbers, sensors.under_way(self.step).copied().chain(stuck));
        }
        digest(self.step, numbers, self.detections.under_way(self.step).copied().chain(stuck))
    }

    /// Puts the centre of an object, counted from 0, somewhere else. Whom it overlaps with there is
    /// pushed apart from it in the next step.
    pub fn put_object(&mut self, object: usize, place_m: [f64; 2]) {
        for (column, place_m) in self.objects.columns_mut().into_iter().zip(place_m) {
            column[object] = place_m as f32;
        }
    }

    /// Where every object is, in metres; shape `[n_objects][2]`.
    pub fn objects_m(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.objects.places().map(|place_m| place_m.map(f64::from))
    }

    /// Position and heading of every robot, the heading from -π to π.
    pub fn poses(&self) -> impl Iterator<Item = Pose> + '_ {
        let robots = &self.robots;
        self.numbering.places().iter().map(|place| {
            let number = |column: &[f32]| f64::from(column[*place as usize]);
            let (cosine, sine) = (number(&robots.cosine), number(&robots.sine));
            let heading_rad = libm::atan2(sine, cosine);
            Pose { x_m: number(&robots.x_m), y_m: number(&robots.y_m), heading_rad }
        })
    }
}

/// Senses with a grid, if there is one.
fn sense_with(
    (robots, contact, grid): (&Robots, Contact, Option<&mut Grid>),
    found: (&mut [bool], &mut [Blocked]),
    sees: impl Fn(f32, f32, f32) -> bool,
) {
    match grid {
        Some(grid) => grid.sense(robots, contact, found, sees),
        None => robots.sense_pairs(contact, found, sees),
    }
}

/// Names a state: the step, the numbers of all robots column by column, and the detections under
/// way.
pub(crate) fn digest(
    step: u64,
    numbers: impl Iterator<Item = f32>,
    under_way: impl Iterator<Item = bool>,
) -> u64 {
    let mut digest = Digest::new("world");
    digest.word(step);
    for number in numbers {
        digest.bytes(&number.to_bits().to_le_bytes());
    }
    for detection in under_way {
        digest.bytes(&[u8::from(detection)]);
    }
    digest.value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rsrs_core::conditions::{Arena, Placement, Walls};
    use rsrs_core::robot::controller::{ControllerParameters, decide};
    use rsrs_core::robot::profile::Sees;
    use rsrs_core::robot::region::Region;
    use rsrs_testing::conditions::flockbot_conditions;

    fn run(world: &mut World, conditions: &Conditions, n_steps: usize) {
        for _ in 0..n_steps {
            let commands: Vec<Command> = world
                .sense()
                .iter()
                .map(|detected| decide(*detected, conditions.controller.parameters().unwrap()))
                .collect();
            world.advance(&commands);
        }
    }

    /// A world that holds every robot against all others.
    fn without_grid(conditions: &Conditions, seed: Seed) -> World {
        World { grid: None, ..World::new(conditions, seed).unwrap() }
    }

    /// A world with a grid, however few its robots are.
    fn with_grid(conditions: &Conditions, seed: Seed) -> World {
        let world = World::new(conditions, seed).unwrap();
        let grid = Grid::new(&world.rules.view, world.rules.contact);
        World { grid, ..world }
    }

    #[test]
    fn the_order_of_the_robots_does_not_matter() {
        let mut conditions = flockbot_conditions();
        conditions.robot.gust_sd_m_s = 0.005;
        conditions.robot.speed_gain.step_sd = 0.02;
        conditions.robot.heading_noise_sd_rad = 0.01;
        let seed = Seed { seed: 1, replicate: 0 };
        let backward_order: Vec<u32> = (0..conditions.robots as u32).rev().collect();
        let mut forward = World::new(&conditions, seed).unwrap();
        let mut backward = World::new(&conditions, seed).unwrap();
        backward.robots.reorder(&backward_order);

        run(&mut forward, &conditions, 2000);
        run(&mut backward, &conditions, 2000);
        backward.robots.reorder(&backward_order);

        assert_eq!(backward.digest(), forward.digest());
    }

    /// Who sees another, robot by robot.
    fn seen_by(world: &World) -> Vec<bool> {
        world.numbering.by_robot(&world.seen).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn the_grid_changes_no_bit(
            robots in 1_usize..400,
            crowding in 0.6..3.0,
            (half_angle_rad, range_m) in (0.05..1.5, 0.05..3.0),
            kind in 0..4,
            (speed_m_s, gust_sd_m_s) in (0.0..1.0, 0.0..0.3),
            front_half_angle_rad in 0.1..3.1,
        ) {
            let mut conditions = flockbot_conditions();
            conditions.robots = robots;
            // Small bodies find room in a crowd; a wide sensor sees many of them.
            conditions.robot.radius_m = 0.02;
            let radius_m = crowding * 0.06 * (robots as f64).sqrt();
            conditions.placement = Placement::DiscFacingOut { radius_m };
            conditions.arena = Arena { side_m: 3.0 * radius_m + 0.1, walls: Walls::Clamp };
            conditions.controller = ControllerParameters::mirrored(speed_m_s, 0.75).into();
            conditions.robot.gust_sd_m_s = gust_sd_m_s;
            conditions.robot.front_half_angle_rad = front_half_angle_rad;
            conditions.robot.sees = if kind % 2 == 0 { Sees::Body } else { Sees::Centre };
            conditions.robot.region = if kind < 2 {
                Region::Cone { half_angle_rad, range_m }
            } else {
                let (near_m, far_m) = (0.1 * range_m, 0.5 * range_m);
                let corners_m =
                    vec![[0.0, -near_m], [range_m, -far_m], [range_m, far_m], [0.0, near_m]];
                Region::Polygon { corners_m }
            };
            let seed = Seed { seed: 1, replicate: robots as u64 };
            let (mut plain, mut grid) =
                (without_grid(&conditions, seed), with_grid(&conditions, seed));

            for step in 0..40 {
                run(&mut plain, &conditions, 1);
                run(&mut grid, &conditions, 1);

                prop_assert_eq!(seen_by(&plain), seen_by(&grid), "{}", step);
                prop_assert_eq!(&plain.blocked, &grid.blocked, "{}", step);
                prop_assert_eq!(plain.digest(), grid.digest(), "{}", step);
            }
        }
    }

    #[test]
    fn a_large_swarm_has_a_grid_and_a_small_one_does_not() {
        let seed = Seed { seed: 1, replicate: 0 };
        let mut conditions = flockbot_conditions();
        conditions.placement = Placement::DiscFacingOut { radius_m: 10.0 };

        for (robots, expected) in [(9, false), (1000, true)] {
            conditions.robots = robots;
            assert_eq!(World::new(&conditions, seed).unwrap().grid.is_some(), expected);
        }
    }
}
