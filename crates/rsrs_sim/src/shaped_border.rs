//! The walls of arenas that are no squares, and of obstacles, as the centres of bodies meet them.
//!
//! A body of radius `r` is within the walls while its centre is `r` or farther from all of them. It goes from one place to
//! another in equal parts of at most `r / 2`, so that no centre ever comes to the other side of a wall:
//! - where walls stop, it stays where it was if any of these places is not within the walls;
//! - where it slides, it is moved straight away from the nearest wall until it is `r` away, and then from that which is
//!   nearest now, until none is nearer than `r`; in a corner that is too sharp for [`MOST_ROUNDS`] of this, it stays where
//!   it was before the part.
//!
//! Places are kept in single precision, so that a body may be in a wall by [`FreeSpace::slack_m`], a millionth of the
//! arena's side. All of this is in double precision, of `+ - * /`, the square root and casts.
//!
//! In a rectangle this is where [`crate::contact::Border`] of a square leads to, up to rounding.

use std::sync::Arc;

use rsrs_core::conditions::Walls;
use rsrs_core::plane::between;
use rsrs_core::world::FreeSpace;

/// How often a body is moved away from the wall that is nearest.
pub const MOST_ROUNDS: usize = 256;

/// Nobody goes farther near walls in one step than so many parts.
const MOST_PARTS: f64 = 10_000.0;

/// A body is moved away from walls that are nearer than its radius by more than this, over the slack; dimensionless.
const SETTLED: f64 = 0.1;

/// The border for bodies of one radius.
#[derive(Clone, Debug)]
pub struct ShapedBorder {
    walls: Walls,
    space: Arc<FreeSpace>,
    radius_m: f64,
    slack_m: f64,
}

impl ShapedBorder {
    /// Walls, for bodies of a radius in metres.
    pub fn new(walls: Walls, space: Arc<FreeSpace>, radius_m: f64) -> Self {
        let slack_m = space.slack_m();
        Self { walls, space, radius_m, slack_m }
    }

    /// Whether a body can be at a place in metres.
    pub fn admits(&self, place_m: [f64; 2]) -> bool {
        self.walls == Walls::None || self.space.clearance_m(place_m) >= self.radius_m - self.slack_m
    }

    /// Where a robot ends that drives from one point to another, in metres.
    pub fn drive(&self, from: (f32, f32), to: (f32, f32)) -> (f32, f32) {
        let [from_m, to_m] = [from, to].map(|(x_m, y_m)| [f64::from(x_m), f64::from(y_m)]);
        if self.is_clear(from_m, to_m) {
            return to;
        }
        let [x_m, y_m] = match self.walls {
            Walls::None => return to,
            Walls::Stop => {
                let is_admitted = self.n_parts(from_m, to_m) <= MOST_PARTS
                    && self.parts(from_m, to_m).all(|part_m| self.admits(part_m));
                return if is_admitted { to } else { from };
            }
            Walls::Clamp => self.slide(from_m, to_m),
        };
        (x_m as f32, y_m as f32)
    }

    /// Where a body that is pushed from one place to another, in metres, is held by the walls, if there are any.
    pub fn hold(&self, from_m: [f64; 2], to_m: [f64; 2]) -> [f64; 2] {
        if self.walls == Walls::None || self.is_clear(from_m, to_m) {
            return to_m;
        }
        self.slide(from_m, to_m)
    }

    /// Whether no wall is near the way.
    fn is_clear(&self, from_m: [f64; 2], to_m: [f64; 2]) -> bool {
        let (_, wall_m) = self.space.nearest_wall_m(from_m);
        let free_m = wall_m - self.radius_m;
        free_m > 0.0 && distance_m2(from_m, to_m) < free_m * free_m
    }

    /// How many parts a way has.
    fn n_parts(&self, from_m: [f64; 2], to_m: [f64; 2]) -> f64 {
        (distance_m2(from_m, to_m).sqrt() / (0.5 * self.radius_m)).ceil().max(1.0)
    }

    /// The places at the ends of the parts of a way, of no more than [`MOST_PARTS`] of them.
    fn parts(&self, from_m: [f64; 2], to_m: [f64; 2]) -> impl Iterator<Item = [f64; 2]> + use<> {
        let n_parts = self.n_parts(from_m, to_m);
        (1..=n_parts.min(MOST_PARTS) as u32)
            .map(move |part| between(from_m, to_m, f64::from(part) / n_parts))
    }

    /// Where a body comes to that slides along walls.
    fn slide(&self, from_m: [f64; 2], to_m: [f64; 2]) -> [f64; 2] {
        let (mut at_m, mut along_m) = (from_m, from_m);
        for part_m in self.parts(from_m, to_m) {
            let next_m = [0, 1].map(|axis| at_m[axis] + (part_m[axis] - along_m[axis]));
            along_m = part_m;
            at_m = self.moved_away(next_m).unwrap_or(at_m);
        }
        at_m
    }

    /// The place to which walls move a body from where it is in them, if there is one.
    fn moved_away(&self, mut at_m: [f64; 2]) -> Option<[f64; 2]> {
        let least_m = self.radius_m - SETTLED * self.slack_m;
        for _ in 0..MOST_ROUNDS {
            let (wall_m, distance_m) = self.space.nearest_wall_m(at_m);
            if distance_m >= least_m {
                return Some(at_m);
            }
            if distance_m <= 0.0 {
                return None;
            }
            let by = self.radius_m / distance_m;
            at_m = [0, 1].map(|axis| wall_m[axis] + by * (at_m[axis] - wall_m[axis]));
        }
        None
    }
}

fn distance_m2(one_m: [f64; 2], other_m: [f64; 2]) -> f64 {
    let (x_m, y_m) = (one_m[0] - other_m[0], one_m[1] - other_m[1]);
    x_m * x_m + y_m * y_m
}
