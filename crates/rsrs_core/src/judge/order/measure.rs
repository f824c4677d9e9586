//! How those order parameters are measured that a window has only where they are asked for.

use std::ops::Range;

use super::cluster::{at_one_goal, clustered_by_class, clustered_objects};
use super::geometry::{Vector, centroid, distance_m2};
use super::samples::Samples;
use crate::judge::number::Number;
use crate::judge::trajectory::Bodies;
use crate::world::{FreeSpace, Goal, WorldFile};

/// How many measures there are.
pub const N_ASKED: usize = 13;

/// How one is measured.
pub struct Measure {
    /// Its value in a window; what it needs is known.
    pub of: fn(&Look) -> f64,
    /// Whether it is a mean over headings, which is [`rounded`](super::rounded).
    pub is_of_headings: bool,
    /// Whether it grows with the window.
    pub adds_up: bool,
}

impl Measure {
    const fn new(of: fn(&Look) -> f64) -> Self {
        Self { of, is_of_headings: false, adds_up: false }
    }
}

/// T. Vicsek et al., Phys. Rev. Lett. 75, 1226 (1995): the absolute value of the average normalised velocity.
pub const POLARISATION: Measure =
    Measure { of: polarisation, is_of_headings: true, adds_up: false };

/// The second moment by which M. Gauci et al., IJRR 33(8), 2014, measure dispersion is this, squared, times the
/// number of robots, over the square of a body's diameter.
pub const SPREAD: Measure = Measure::new(spread_m);

/// Ours.
pub const WALL_DISTANCE: Measure = Measure::new(wall_distance_m);

/// A. Özdemir et al., "Spatial coverage without computation", ICRA 2019, report coverage "with no robot
/// redundancy": of as many cells as there are robots, the share that has one. That the cells are equal squares is
/// how we read it.
pub const COVERAGE: Measure = Measure::new(coverage);

/// Ours: what a robot that cleans would have cleaned.
pub const VISITED: Measure = Measure { of: visited, is_of_headings: false, adds_up: true };

/// Clusters of objects as those of robots ([`super::cluster`]), over the same looks.
pub const OBJECTS_CLUSTERED: Measure = Measure::new(objects_clustered);

/// Ours.
pub const OBJECTS_AT_GOAL: Measure = Measure::new(objects_at_goal);

/// Ours.
pub const AT_GOAL: Measure = Measure::new(at_goal);

/// Ours.
pub const GOAL_DISTANCE: Measure = Measure::new(goal_distance_m);

/// `-γ(t)` of P. Mitrano et al., "A minimalistic approach to segregation in robot swarms", MRS 2019, without the weight of
/// time that their cost has.
pub const SEGREGATED: Measure = Measure::new(segregated);

/// The same without its mean over classes.
pub const LEAST_SEGREGATED: Measure = Measure::new(least_segregated);

/// A. Özdemir et al., "Finding consensus without computation", IEEE RA-L 3(3), 2018, have 20 robots choose one of two
/// options; what counts as there is ours ([`super::cluster`]).
pub const CONSENSUS: Measure = Measure::new(consensus);

/// What A. Özdemir, M. Gauci and R. Groß, "Shepherding with robots that do not compute", ECAL 2017, have shepherds do with
/// sheep; that it is counted in shares is ours.
pub const LAST_CLASS_AT_GOAL: Measure = Measure::new(last_class_at_goal);

/// A window of one world, by itself.
pub struct Look<'a> {
    period_s: f64,
    n_robots: usize,
    /// In metres, sample by sample, robot by robot.
    pub places: Vec<Vector<f64>>,
    /// Of length 1, likewise; empty where nothing is of headings.
    headings: Vec<Vector<f64>>,
    /// Side of the arena, and radius of a body, in metres.
    arena_m: f64,
    radius_m: f64,
    /// Where bodies may be, of an arena that is no plain square.
    space: Option<FreeSpace>,
    /// What is there besides the robots.
    world: &'a WorldFile,
    /// Of each robot; empty where there are none.
    classes: &'a [usize],
    /// Of each object, in metres.
    objects_radius_m: Vec<f64>,
    /// Where objects are, in metres, sample by sample, object by object.
    objects: Vec<Vector<f64>>,
}

impl<'a> Look<'a> {
    pub fn new<S: Samples>(
        samples: &S,
        bodies: &'a Bodies,
        window: &Range<usize>,
        lane: usize,
    ) -> Self {
        let in_lane = |(x, y): Vector<S::Number>| (x.lane(lane), y.lane(lane));
        let heading = |pose: &S::Pose| {
            let (along, inverse) = samples.heading(pose);
            in_lane((along.0 * inverse, along.1 * inverse))
        };
        let poses = || window.clone().flat_map(|sample| samples.poses_at(sample));
        let world = &bodies.world;
        let objects = || window.clone().flat_map(|sample| samples.objects_at(sample));
        Self {
            period_s: samples.period_s(),
            n_robots: samples.poses_at(window.start).len(),
            places: poses().map(|pose| in_lane(samples.place(pose))).collect(),
            headings: poses().map(heading).collect(),
            arena_m: bodies.arena_m.unwrap_or(f64::NAN),
            radius_m: bodies.radius_m.unwrap_or(f64::NAN),
            space: bodies.arena_m.and_then(|arena_m| world.free_space(arena_m)),
            world,
            classes: &bodies.classes,
            objects_radius_m: world.each_object().map(|object| object.radius_m).collect(),
            objects: objects().map(|[x_m, y_m]| (*x_m, *y_m)).collect(),
        }
    }

    /// The mean of a number of each sample.
    fn mean(&self, of: impl Fn(&[Vector<f64>]) -> f64, vectors: &[Vector<f64>]) -> f64 {
        let samples = vectors.chunks_exact(self.n_robots);
        let n_samples = samples.len() as f64;
        samples.map(of).sum::<f64>() / n_samples
    }

    fn clustered_by_class(&self) -> Vec<f64> {
        clustered_by_class(self.radius_m, self.classes, &self.places)
    }

    /// How far a place is from the nearest goal, in metres; 0 in it.
    fn outside_goals_m(&self, place: Vector<f64>) -> f64 {
        let from_m = |goal: &Goal| {
            let [x_m, y_m] = goal.place_m;
            (distance_m2(place, (x_m, y_m)).sqrt() - goal.radius_m).max(0.0)
        };
        self.world.goals.iter().map(from_m).fold(f64::INFINITY, f64::min)
    }

    fn share_at_goal(&self, places: &[Vector<f64>]) -> f64 {
        let n_there = places.iter().filter(|place| self.outside_goals_m(**place) <= 0.0).count();
        n_there as f64 / places.len() as f64
    }

    /// The number of the cell that holds a place, of so many along each side of the arena; who is beyond it is in
    /// the nearest.
    fn cell(&self, place: Vector<f64>, n_along: usize) -> usize {
        let along = |coordinate_m: f64| {
            let share = coordinate_m / self.arena_m + 0.5;
            (share * n_along as f64).clamp(0.0, n_along as f64 - 1.0) as usize
        };
        along(place.0) * n_along + along(place.1)
    }
}

fn polarisation(look: &Look) -> f64 {
    let length = |headings: &[Vector<f64>]| {
        let (x, y) = centroid(0.0, headings);
        (x * x + y * y).sqrt()
    };
    look.mean(length, &look.headings)
}

fn spread_m(look: &Look) -> f64 {
    let spread_m = |places: &[Vector<f64>]| {
        let centre = centroid(0.0, places);
        let squares: f64 = places.iter().map(|place| distance_m2(*place, centre)).sum();
        (squares / places.len() as f64).sqrt()
    };
    look.mean(spread_m, &look.places)
}

fn wall_distance_m(look: &Look) -> f64 {
    let distance_m = |(x, y): &Vector<f64>| {
        let clearance_m = match &look.space {
            None => look.arena_m / 2.0 - x.abs().max(y.abs()),
            Some(space) => space.clearance_m([*x, *y]),
        };
        clearance_m.max(0.0)
    };
    let mean_m =
        |places: &[Vector<f64>]| places.iter().map(distance_m).sum::<f64>() / places.len() as f64;
    look.mean(mean_m, &look.places)
}

fn objects_clustered(look: &Look) -> f64 {
    clustered_objects(look.period_s, &look.objects_radius_m, &look.objects)
}

fn objects_at_goal(look: &Look) -> f64 {
    // Of as many objects in each sample, the share of all is the mean of the shares.
    look.share_at_goal(&look.objects)
}

fn at_goal(look: &Look) -> f64 {
    look.share_at_goal(&look.places)
}

fn last_class_at_goal(look: &Look) -> f64 {
    let last = look.classes.iter().max();
    let robots = look.places.iter().zip(look.classes.iter().cycle());
    let of_class: Vec<Vector<f64>> =
        robots.filter(|(_, class)| Some(*class) == last).map(|(place, _)| *place).collect();
    look.share_at_goal(&of_class)
}

fn goal_distance_m(look: &Look) -> f64 {
    let distances_m = look.places.iter().map(|place| look.outside_goals_m(*place));
    distances_m.sum::<f64>() / look.places.len() as f64
}

fn segregated(look: &Look) -> f64 {
    let shares = look.clustered_by_class();
    shares.iter().sum::<f64>() / shares.len() as f64
}

fn least_segregated(look: &Look) -> f64 {
    look.clustered_by_class().into_iter().fold(f64::INFINITY, f64::min)
}

fn consensus(look: &Look) -> f64 {
    let scale = (look.period_s, look.radius_m);
    at_one_goal(scale, &look.world.goals, look.n_robots, &look.places)
}

fn coverage(look: &Look) -> f64 {
    // No more cells than robots, so that all of them can be covered.
    let cells = match &look.space {
        None => Cells::all(look.n_robots.isqrt()),
        Some(space) => Cells::at_most(look.n_robots, (space, look.arena_m)),
    };
    look.mean(|places| cells.share_held(look, places), &look.places)
}

/// More cells along a side than that would be finer than what poses are known to, and cost memory.
const MOST_ALONG: usize = 1000;

fn visited(look: &Look) -> f64 {
    let n_along =
        (look.arena_m / (2.0 * look.radius_m)).floor().clamp(1.0, MOST_ALONG as f64) as usize;
    let cells = match &look.space {
        None => Cells::all(n_along),
        Some(space) => Cells::free(n_along, (space, look.arena_m)),
    };
    cells.share_held(look, &look.places)
}

/// Equal squares, as many along each side of the square that holds the arena.
struct Cells {
    n_along: usize,
    /// Which of them count: those whose middle is free. Empty if all do.
    is_free: Vec<bool>,
    n_free: usize,
}

impl Cells {
    fn all(n_along: usize) -> Self {
        Self { n_along, is_free: Vec::new(), n_free: n_along * n_along }
    }

    fn free(n_along: usize, (space, side_m): (&FreeSpace, f64)) -> Self {
        let middle_m = |cell: usize| side_m * ((cell as f64 + 0.5) / n_along as f64 - 0.5);
        let cells = 0..n_along * n_along;
        let is_free: Vec<bool> = cells
            .map(|cell| space.is_free([middle_m(cell / n_along), middle_m(cell % n_along)]))
            .collect();
        let n_free = is_free.iter().filter(|is_free| **is_free).count();
        Self { n_along, is_free, n_free }
    }

    /// The finest of them of which no more count than a number; more only where else none would.
    fn at_most(most: usize, arena: (&FreeSpace, f64)) -> Self {
        let mut cells = Self::free(1, arena);
        while cells.n_along < MOST_ALONG {
            let finer = Self::free(cells.n_along + 1, arena);
            if cells.n_free > 0 && finer.n_free > most {
                break;
            }
            cells = finer;
        }
        cells
    }

    /// Share of them that hold one of these places or more.
    fn share_held(&self, look: &Look, places: &[Vector<f64>]) -> f64 {
        let mut is_held = vec![false; self.n_along * self.n_along];
        for place in places {
            is_held[look.cell(*place, self.n_along)] = true;
        }
        let held = is_held.iter().enumerate().filter(|(_, is_held)| **is_held);
        let counted = held.filter(|(cell, _)| self.is_free.get(*cell).copied().unwrap_or(true));
        counted.count() as f64 / self.n_free.max(1) as f64
    }
}
