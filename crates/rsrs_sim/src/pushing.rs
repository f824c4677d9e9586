//! Bodies that push each other, quasi-statically: nothing has momentum, and who is not pushed stays.
//!
//! Every robot first goes where its wheels take it, as if it were alone, in parts of at most a quarter of
//! a radius. After each part, bodies that overlap are moved apart along the line of their centres, each by
//! half, again and again until they only touch. What one gains the other loses, so that `k` robots that
//! drive against `m` that stand move all of them at `k / (k + m)` of their speed. A robot that nobody
//! moves ([`ContactModel::Stop`]) yields nothing, and the other one all; walls yield nothing. Friction
//! holds back the sliding of one body along another, by at most its coefficient times what the two were
//! moved apart (Coulomb). Contact turns nobody.
//!
//! Objects are bodies that have no wheels. Whoever does not pass through others pushes them: robots that push
//! robots share the way with them as with each other, and the more of it, the heavier the object is: `k` robots that drive
//! against objects of weight `w` together move them at `k / (k + w)` of their speed; to robots that only stop at robots
//! they yield all, as to walls. What slides along an object is held back by the object's friction, of two objects by that of the
//! smoother one.
//!
//! Bodies that could not be moved apart in [`MOST_ROUNDS`], or are jammed among objects, go back to where they were before the step, and
//! so does whoever would then overlap with them. So no two bodies ever overlap by more than [`SLACK`] of
//! the distance at which they touch, unless they were put there.
//!
//! What moves a body in a round is summed in whole numbers, of which the order is no part of the sum: so
//! neither the order of the robots nor that of the pairs is part of the definition. It is in double
//! precision, of `+ - * /`, the square root, and casts.

use rsrs_core::conditions::{Conditions, SimulatedRobot};
use rsrs_core::plane::{dot, minus, plus};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::world::Object;

use crate::contact::{Border, Borders};

/// By how much two bodies may overlap, over the distance at which they touch; dimensionless.
pub const SLACK: f64 = 1e-3;

/// Bodies are moved apart until they overlap by no more than this; dimensionless.
const SETTLED: f64 = 0.5 * SLACK;

/// Rounds in which bodies are moved apart after each part of a step.
pub const MOST_ROUNDS: usize = 400;

/// The same where there are objects, of which a robot may push a long row ...
const MOST_ROUNDS_OF_OBJECTS: usize = 4000;

/// ... unless what overlaps most, looked at every so many rounds, has hardly become less: it is jammed.
const LOOKED_AT_EVERY: usize = 50;

/// Hardly: by no more than to this share; dimensionless.
const JAMMED: f64 = 0.97;

/// A step is made in parts in which no robot goes further than this, in radii of the smallest ...
const PART_RADII: f64 = 0.25;

/// ... but in no more parts than this.
const MOST_PARTS: f64 = 64.0;

/// Whole numbers in a metre, of which moves are sums.
const PER_M: f64 = (1_u64 << 40) as f64;

/// A swarm in which somebody pushes or is pushed, with the objects, which are behind the robots in all that follows, and the memory that is used again from step to step.
pub(crate) struct Pushing {
    bodies: Bodies,
    /// Where bodies were before the step, by themselves at its end, and are; shape `[n_bodies]` each.
    from_m: Vec<[f64; 2]>,
    alone_m: Vec<[f64; 2]>,
    at_m: Vec<[f64; 2]>,
    /// Where they were before this part of the step; shape `[n_bodies]`.
    part_from_m: Vec<[f64; 2]>,
    /// By how much this round moves them, in whole numbers, and how many others each overlaps with.
    moved: Vec<[i64; 2]>,
    n_touching: Vec<u32>,
    near: Near,
    overlaps: Vec<Overlap>,
    /// The deepest of them, over the distance at which the two touch; dimensionless.
    deepest: f64,
    has_objects: bool,
    /// Who goes back, and who has gone back; shape `[n_bodies]`.
    returning: Vec<usize>,
    is_back: Vec<bool>,
}

/// What contact is to each body; shape `[n_bodies]`.
struct Bodies(Vec<Body>);

#[derive(Clone)]
struct Body {
    radius_m: f64,
    friction: f64,
    /// Over that of a robot; dimensionless.
    weight: f64,
    contact: ContactModel,
    is_object: bool,
    border: Border,
}

/// Who is near whom.
struct Near {
    by_x: Vec<usize>,
    pairs: Vec<(usize, usize)>,
}

#[derive(Clone, Copy)]
struct Overlap {
    pair: (usize, usize),
    /// From the second to the first; of length 1.
    normal: [f64; 2],
    depth_m: f64,
}

impl Pushing {
    /// The pushing of a world; `None` if none of its robots pushes, and there are no objects.
    pub fn new(conditions: &Conditions) -> Option<Self> {
        let robots = (0..conditions.robots).map(|robot| conditions.robot_at(robot));
        let n_objects = conditions.world.n_objects();
        if n_objects == 0 && !robots.clone().any(|robot| robot.contact == ContactModel::Push) {
            return None;
        }
        let n_bodies = conditions.robots + n_objects;
        let borders = Borders::new(conditions);
        let body = |robot: &SimulatedRobot| Body {
            radius_m: robot.radius_m,
            friction: robot.contact_friction,
            weight: 1.0,
            contact: robot.contact,
            is_object: false,
            border: borders.for_radius(robot.radius_m),
        };
        let object = |object: Object| Body {
            radius_m: object.radius_m,
            friction: object.friction,
            weight: object.weight,
            contact: ContactModel::Push,
            is_object: true,
            border: borders.for_radius(object.radius_m),
        };
        let places = || vec![[0.0; 2]; n_bodies];
        let objects = conditions.world.each_object().map(object);
        Some(Self {
            bodies: Bodies(robots.map(body).chain(objects).collect()),
            from_m: places(),
            alone_m: places(),
            at_m: places(),
            part_from_m: places(),
            moved: vec![[0; 2]; n_bodies],
            n_touching: vec![0; n_bodies],
            near: Near { by_x: (0..n_bodies).collect(), pairs: Vec::new() },
            overlaps: Vec::new(),
            deepest: 0.0,
            has_objects: n_objects > 0,
            returning: Vec::new(),
            is_back: vec![false; n_bodies],
        })
    }

    /// Takes down where robots and objects are before robots move: x and y in metres, shape
    /// `[n_robots]` and `[n_objects]`.
    pub fn begin(&mut self, robots: [&[f32]; 2], objects: [&[f32]; 2]) {
        read(&mut self.from_m, robots, objects);
    }

    /// Moves all from where each robot would be if it were alone to where they are among each other.
    /// Places are as in [`Self::begin`], and change where somebody is pushed.
    pub fn settle(&mut self, mut robots: [&mut [f32]; 2], mut objects: [&mut [f32]; 2]) {
        read(&mut self.alone_m, shared(&robots), shared(&objects));
        let farthest_m = farthest_m(&self.from_m, &self.alone_m);
        self.near.find(&self.bodies, &self.from_m, 2.0 * farthest_m);
        if self.near.pairs.is_empty() {
            return;
        }
        let parts = (farthest_m / (PART_RADII * self.bodies.smallest_radius_m())).ceil();
        let parts = parts.clamp(1.0, MOST_PARTS);
        self.at_m.copy_from_slice(&self.from_m);
        let mut is_any_pushed = false;
        for _ in 0..parts as usize {
            self.part_from_m.copy_from_slice(&self.at_m);
            let ways = self.from_m.iter().zip(&self.alone_m).zip(&self.bodies.0);
            for (at_m, ((from_m, alone_m), body)) in self.at_m.iter_mut().zip(ways) {
                let way_m = minus(*alone_m, *from_m);
                let to_m = plus(*at_m, way_m.map(|along_m| along_m / parts));
                *at_m = body.border.hold(*at_m, to_m);
            }
            is_any_pushed |= self.move_apart();
        }
        if is_any_pushed {
            // As they are kept, in single precision.
            let rounded = |at_m: f64| f64::from(at_m as f32);
            self.at_m.iter_mut().for_each(|place_m| *place_m = place_m.map(rounded));
            self.go_back();
            let (of_robots, of_objects) = self.at_m.split_at(robots[0].len());
            write(of_robots, &mut robots);
            write(of_objects, &mut objects);
        }
    }

    /// Moves bodies apart until they only touch, or the rounds are over. Returns whether any was moved.
    fn move_apart(&mut self) -> bool {
        // Whoever is pushed in these rounds may push others, who are near, too.
        self.near.find(&self.bodies, &self.at_m, self.bodies.largest_radius_m());
        let most_rounds = if self.has_objects { MOST_ROUNDS_OF_OBJECTS } else { MOST_ROUNDS };
        let mut before = f64::INFINITY;
        for round in 0..most_rounds {
            self.find_overlaps();
            if self.overlaps.is_empty() {
                return round > 0;
            }
            if self.has_objects && round % LOOKED_AT_EVERY == 0 {
                if self.deepest > JAMMED * before {
                    return true;
                }
                before = self.deepest;
            }
            self.make_round();
        }
        true
    }

    /// Finds the pairs that overlap, and how many of them each body is in.
    fn find_overlaps(&mut self) {
        self.overlaps.clear();
        self.n_touching.fill(0);
        self.deepest = 0.0;
        let mut is_settled = true;
        for (one, other) in self.near.pairs.iter().copied() {
            let between_m = minus(self.at_m[one], self.at_m[other]);
            let touching_m = self.bodies.touching_m(one, other);
            let d2_m2 = dot(between_m, between_m);
            // Centres on one spot lie in no direction from each other.
            if d2_m2 < touching_m * touching_m && d2_m2 > 0.0 {
                let distance_m = d2_m2.sqrt();
                let normal = between_m.map(|along_m| along_m / distance_m);
                let depth_m = touching_m - distance_m;
                is_settled &= depth_m <= SETTLED * touching_m;
                self.deepest = self.deepest.max(depth_m / touching_m);
                self.overlaps.push(Overlap { pair: (one, other), normal, depth_m });
                self.n_touching[one] += 1;
                self.n_touching[other] += 1;
            }
        }
        if is_settled {
            self.overlaps.clear();
        }
    }

    /// Moves every pair that overlaps apart: the more bodies each of the two touches, the less, so that
    /// what they all ask of it together is no more than one would.
    fn make_round(&mut self) {
        self.moved.fill([0; 2]);
        for Overlap { pair: (one, other), normal, depth_m } in self.overlaps.iter().copied() {
            let n_touching = self.n_touching[one].max(self.n_touching[other]);
            let apart_m = depth_m / f64::from(n_touching);
            let slid_m = minus(
                minus(self.at_m[one], self.part_from_m[one]),
                minus(self.at_m[other], self.part_from_m[other]),
            );
            let tangent = [-normal[1], normal[0]];
            let most_m = self.bodies.friction(one, other) * apart_m;
            let held_m = (-dot(slid_m, tangent) / f64::from(n_touching)).clamp(-most_m, most_m);
            let share = self.bodies.yielding(one, other);
            for (body, share) in [(one, share), (other, share - 1.0)] {
                for axis in 0..2 {
                    let by_m = share * (apart_m * normal[axis] + held_m * tangent[axis]);
                    self.moved[body][axis] += (by_m * PER_M) as i64;
                }
            }
        }
        for (robot, at_m) in self.at_m.iter_mut().enumerate() {
            if self.n_touching[robot] > 0 {
                let by_m = self.moved[robot].map(|number| number as f64 / PER_M);
                *at_m = self.bodies.0[robot].border.hold(*at_m, plus(*at_m, by_m));
            }
        }
    }

    /// Puts bodies that still overlap back to where they were, until nobody does whom that can help.
    fn go_back(&mut self) {
        let Self { bodies, from_m, at_m, near, is_back, returning, .. } = self;
        near.find(bodies, from_m, 2.0 * farthest_m(from_m, at_m));
        is_back.fill(false);
        loop {
            // All of them at once, so that it does not matter who is looked at first.
            returning.clear();
            for (one, other) in near.pairs.iter().copied() {
                let between_m = minus(at_m[one], at_m[other]);
                let least_m = (1.0 - SLACK) * bodies.touching_m(one, other);
                if dot(between_m, between_m) < least_m * least_m {
                    returning.extend([one, other].into_iter().filter(|body| !is_back[*body]));
                }
            }
            if returning.is_empty() {
                break;
            }
            for body in returning.iter().copied() {
                (at_m[body], is_back[body]) = (from_m[body], true);
            }
        }
    }
}

impl Bodies {
    fn largest_radius_m(&self) -> f64 {
        self.0.iter().map(|body| body.radius_m).fold(0.0, f64::max)
    }

    fn smallest_radius_m(&self) -> f64 {
        self.0.iter().map(|body| body.radius_m).fold(f64::INFINITY, f64::min)
    }

    /// Distance of two centres at which the bodies touch, in metres.
    fn touching_m(&self, one: usize, other: usize) -> f64 {
        self.0[one].radius_m + self.0[other].radius_m
    }

    /// Whether one of two can push the other.
    fn push(&self, one: usize, other: usize) -> bool {
        let contacts = [self.0[one].contact, self.0[other].contact];
        contacts.contains(&ContactModel::Push) && !contacts.contains(&ContactModel::None)
    }

    /// Which share of the way apart the first of two makes: half of bodies of one weight, unless nobody moves one of them.
    fn yielding(&self, one: usize, other: usize) -> f64 {
        let [weight, of_other] = [one, other].map(|body| self.0[body].weight);
        match [one, other].map(|body| self.0[body].contact == ContactModel::Push) {
            [true, true] => of_other / (weight + of_other),
            [true, false] => 1.0,
            _ => 0.0,
        }
    }

    /// The friction of two bodies, which is that of the smoother one; one that only stands has none of its own, and no
    /// robot has beside an object.
    fn friction(&self, one: usize, other: usize) -> f64 {
        let (one, other) = (&self.0[one], &self.0[other]);
        match [one.is_object, other.is_object] {
            [true, false] => return one.friction,
            [false, true] => return other.friction,
            _ => {}
        }
        match [one, other].map(|body| body.contact == ContactModel::Push) {
            [true, true] => one.friction.min(other.friction),
            [true, false] => one.friction,
            _ => other.friction,
        }
    }
}

impl Near {
    /// Finds all pairs of which one may push the other, and whose bodies are nearer than `reach_m` to each
    /// other.
    fn find(&mut self, bodies: &Bodies, at_m: &[[f64; 2]], reach_m: f64) {
        let Self { by_x, pairs } = self;
        pairs.clear();
        // Nearly sorted from step to step.
        by_x.sort_by(|one, other| at_m[*one][0].total_cmp(&at_m[*other][0]));
        let farthest_m = 2.0 * bodies.largest_radius_m() + reach_m;
        for (position, one) in by_x.iter().copied().enumerate() {
            let later = by_x[position + 1..].iter().copied();
            let beside = later.take_while(|other| at_m[*other][0] - at_m[one][0] <= farthest_m);
            pairs.extend(beside.map(|other| (one, other)).filter(|(one, other)| {
                let between_m = minus(at_m[*one], at_m[*other]);
                let near_m = bodies.touching_m(*one, *other) + reach_m;
                dot(between_m, between_m) <= near_m * near_m && bodies.push(*one, *other)
            }));
        }
    }
}

fn shared<'a>(columns: &'a [&mut [f32]; 2]) -> [&'a [f32]; 2] {
    [&*columns[0], &*columns[1]]
}

fn read(places_m: &mut [[f64; 2]], robots: [&[f32]; 2], objects: [&[f32]; 2]) {
    let both = [robots, objects].into_iter().flat_map(|[x_m, y_m]| x_m.iter().zip(y_m));
    for (place_m, (x_m, y_m)) in places_m.iter_mut().zip(both) {
        *place_m = [f64::from(*x_m), f64::from(*y_m)];
    }
}

fn write(places_m: &[[f64; 2]], [x_m, y_m]: &mut [&mut [f32]; 2]) {
    for (place_m, (x_m, y_m)) in places_m.iter().zip(x_m.iter_mut().zip(y_m.iter_mut())) {
        (*x_m, *y_m) = (place_m[0] as f32, place_m[1] as f32);
    }
}

/// The longest way that any body made, in metres.
fn farthest_m(from_m: &[[f64; 2]], to_m: &[[f64; 2]]) -> f64 {
    let ways = from_m.iter().zip(to_m).map(|(from_m, to_m)| minus(*to_m, *from_m));
    ways.map(|way_m| dot(way_m, way_m)).fold(0.0, f64::max).sqrt()
}
