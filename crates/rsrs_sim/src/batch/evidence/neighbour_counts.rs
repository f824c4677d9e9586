//! Who is near whom, who touches whom, and who is held up: counts, for a lane of each world.
//!
//! All of them come from comparing distances with limits, in double precision by definition. Single
//! precision gives the same answer unless a distance is within its error of a limit, and then the
//! definition is asked.
//!
//! Robots go a short way in a period. So once all of them are well within reach of another and touch
//! nobody, that stays so until one has gone as far as there is room, and until then nobody is held
//! against all others.

use rsrs_core::order::CONTACT_TOLERANCE;

use super::super::nearest::{between_m2, nearest_neighbours};
use super::super::sense::Body;
use super::Window;
use crate::vector::simd::{Mask, Number, Simd, Work};

/// What single precision may be off by in a squared distance, relative to it, ten times over.
const MARGIN: f64 = 1e-5;

/// What is smaller has no such relative error in single precision.
const TINY_M2: f64 = 1e-30;

/// The same in a distance that is the sum of some, relative to the greatest of them.
const ROOM_MARGIN: f32 = 1e-4;

/// Counts of one window, and the memory to make them.
pub struct NeighbourCounts<S: Simd> {
    /// Samples in which each robot had nobody within reach; shape `[n_robots]`.
    alone: Vec<S::F>,
    /// Looks at which it was blocked; shape `[n_robots]`.
    blocked: Vec<S::F>,
    /// How many came into contact.
    onsets: S::F,
    touched: Vec<S::M>,
    nearest_m2: Vec<S::F>,
    /// Where the robots were when there last was room, and the squared way for which there is.
    places: Vec<(S::F, S::F)>,
    room_m2: S::F,
}

/// The counts of one lane.
pub struct Counts {
    pub alone: Vec<f64>,
    pub blocked: Vec<f64>,
    pub onsets: f64,
}

impl<S: Simd> NeighbourCounts<S> {
    /// No memory yet.
    pub fn new(simd: S) -> Self {
        Self {
            alone: Vec::new(),
            blocked: Vec::new(),
            onsets: simd.single(0.0),
            touched: Vec::new(),
            nearest_m2: Vec::new(),
            places: Vec::new(),
            room_m2: simd.single(0.0),
        }
    }

    /// What was counted in a lane.
    pub fn counts(&self, lane: usize) -> Counts {
        let of = |counts: &[S::F]| counts.iter().map(|n| f64::from(n.lane(lane))).collect();
        Counts {
            alone: of(&self.alone),
            blocked: of(&self.blocked),
            onsets: f64::from(self.onsets.lane(lane)),
        }
    }

    fn clear(&mut self, simd: S, n_robots: usize) {
        let zero = simd.single(0.0);
        for counts in [&mut self.alone, &mut self.blocked, &mut self.nearest_m2] {
            counts.clear();
            counts.resize(n_robots, zero);
        }
        self.touched.clear();
        self.touched.resize(n_robots, simd.no());
        self.places.clear();
        self.places.resize(n_robots, (zero, zero));
        self.onsets = zero;
        self.room_m2 = simd.single(-1.0);
    }
}

/// A squared distance against which others are held.
#[derive(Clone, Copy)]
#[expect(clippy::struct_field_names, reason = "all three are areas, and say so")]
struct Limit<F> {
    exact_m2: f64,
    /// Up to here it is surely below, in single precision.
    low_m2: F,
    /// From here on surely above.
    high_m2: F,
}

impl<F: Number<Scalar = f32>> Limit<F> {
    #[inline(always)]
    fn new<S: Simd<F = F>>(simd: S, exact_m2: f64) -> Self {
        let low_m2 = if exact_m2 < TINY_M2 { 0.0 } else { exact_m2 * (1.0 - MARGIN) };
        let high_m2 = exact_m2.max(TINY_M2) * (1.0 + MARGIN);
        Self { exact_m2, low_m2: simd.single(low_m2 as f32), high_m2: simd.single(high_m2 as f32) }
    }
}

/// Counts over a window.
pub struct CountNeighbours<'a, S: Simd> {
    pub simd: S,
    pub window: Window<'a, S::F>,
    pub neighbour_counts: &'a mut NeighbourCounts<S>,
}

impl<S: Simd> Work for CountNeighbours<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Self { simd, window, .. } = self;
        let bodies = window.bodies;
        let reach_m2 = bodies.reach_m.map_or(f64::INFINITY, |reach_m| reach_m * reach_m);
        let contact_m2 = bodies.radius_m.map_or(0.0, |radius_m| {
            let contact_m = 2.0 * radius_m * (1.0 + CONTACT_TOLERANCE);
            contact_m * contact_m
        });
        let reach = Limit::new(simd, reach_m2);
        let contact = Limit::new(simd, contact_m2);
        let blocked = Limit::new(simd, window.commanded.blocked_below_m2);
        self.neighbour_counts.clear(simd, window.rows.at(window.start).len());
        for sample in window.start..window.end {
            if !self.has_room(sample) && !self.makes_room(sample, reach, contact) {
                self.meet(sample, reach, contact);
            }
            // Who is told to stand is not blocked.
            if blocked.exact_m2 > 0.0 && sample >= window.start + window.commanded.back {
                self.look_back(sample, blocked);
            }
        }
    }
}

impl<'a, S: Simd> CountNeighbours<'a, S> {
    fn row(&self, sample: u64) -> &'a [Body<S::F>] {
        self.window.rows.at(sample)
    }

    /// Whether nobody has gone further than there was room for.
    #[inline(always)]
    fn has_room(&self, sample: u64) -> bool {
        let neighbour_counts = &*self.neighbour_counts;
        if neighbour_counts.room_m2.lt(self.simd.single(0.0)).any() {
            return false;
        }
        let mut gone_m2 = self.simd.single(0.0);
        for (body, place) in self.row(sample).iter().zip(&neighbour_counts.places) {
            let (dx_m, dy_m) = (body.x_m - place.0, body.y_m - place.1);
            gone_m2 = gone_m2.most(dx_m * dx_m + dy_m * dy_m);
        }
        is_everywhere::<S>(gone_m2.le(neighbour_counts.room_m2))
    }

    /// Holds everybody against all others, and says whether all are near another and touch nobody.
    /// Then there may be room to go on.
    #[inline(always)]
    fn makes_room(&mut self, sample: u64, reach: Limit<S::F>, contact: Limit<S::F>) -> bool {
        let (simd, row) = (self.simd, self.row(sample));
        let one = |number| simd.single(number);
        let neighbour_counts = &mut *self.neighbour_counts;
        nearest_neighbours(simd, row, &mut neighbour_counts.nearest_m2);
        let (mut least_m2, mut most_m2) = (one(f32::INFINITY), one(0.0));
        for nearest_m2 in &neighbour_counts.nearest_m2 {
            least_m2 = least_m2.least(*nearest_m2);
            most_m2 = most_m2.most(*nearest_m2);
        }
        let is_good = most_m2.lt(reach.low_m2) & contact.high_m2.lt(least_m2);
        if !is_everywhere::<S>(is_good) {
            neighbour_counts.room_m2 = one(-1.0);
            return false;
        }
        // Two robots come closer by twice the way that each has gone.
        let reach_m = reach.low_m2.least(one(f32::MAX)).sqrt();
        let to_reach_m = reach_m - most_m2.sqrt();
        let to_contact_m = least_m2.sqrt() - contact.high_m2.sqrt();
        let margin_m = one(ROOM_MARGIN) * most_m2.sqrt();
        let room_m = (to_reach_m.least(to_contact_m) - margin_m) * one(0.499);
        neighbour_counts.room_m2 = S::F::select(room_m.gt(one(0.0)), room_m * room_m, one(-1.0));
        for (place, body) in neighbour_counts.places.iter_mut().zip(row) {
            *place = (body.x_m, body.y_m);
        }
        neighbour_counts.touched.fill(simd.no());
        true
    }

    /// Counts who is alone and who comes into contact, with the nearest neighbours as they are.
    #[inline(always)]
    fn meet(&mut self, sample: u64, reach: Limit<S::F>, contact: Limit<S::F>) {
        let (simd, row) = (self.simd, self.row(sample));
        let one = simd.single(1.0);
        let is_first = sample == self.window.start;
        let neighbour_counts = &mut *self.neighbour_counts;
        for robot in 0..row.len() {
            let nearest_m2 = neighbour_counts.nearest_m2[robot];
            let exact = |lane: usize| nearest_by_definition(row, robot, lane);
            let is_near = is_below(simd, nearest_m2, reach, |lane| exact(lane) <= reach.exact_m2);
            let touches =
                is_below(simd, nearest_m2, contact, |lane| exact(lane) < contact.exact_m2);
            neighbour_counts.alone[robot] = neighbour_counts.alone[robot] + one.unless(is_near);
            if touches.any() && !is_first {
                let now = one - one.unless(touches);
                neighbour_counts.onsets =
                    neighbour_counts.onsets + now.unless(neighbour_counts.touched[robot]);
            }
            neighbour_counts.touched[robot] = touches;
        }
    }

    /// Counts who has hardly moved since a second ago.
    #[inline(always)]
    fn look_back(&mut self, sample: u64, below: Limit<S::F>) {
        let (simd, now) = (self.simd, self.row(sample));
        let before = self.row(sample - self.window.commanded.back);
        let one = simd.single(1.0);
        let mut least_m2 = simd.single(f32::INFINITY);
        for (now, before) in now.iter().zip(before) {
            least_m2 = least_m2.least(between_m2(now, before));
        }
        if is_everywhere::<S>(below.high_m2.lt(least_m2)) {
            return;
        }
        for ((now, before), blocked) in
            now.iter().zip(before).zip(&mut self.neighbour_counts.blocked)
        {
            let is_blocked = is_below(simd, between_m2(now, before), below, |lane| {
                between_by_definition(now, before, lane) < below.exact_m2
            });
            *blocked = *blocked + (one - one.unless(is_blocked));
        }
    }
}

/// Whether it is so in all lanes.
#[inline(always)]
fn is_everywhere<S: Simd>(mask: S::M) -> bool {
    mask.bits() == (1 << S::LANES) - 1
}

/// Whether a squared distance is below a limit; where that is in doubt, `exact` says so.
#[inline(always)]
fn is_below<S: Simd>(
    simd: S,
    distance_m2: S::F,
    limit: Limit<S::F>,
    exact: impl Fn(usize) -> bool,
) -> S::M {
    let surely = distance_m2.lt(limit.low_m2);
    if is_everywhere::<S>(surely | limit.high_m2.lt(distance_m2)) {
        return surely;
    }
    in_doubt(simd, surely.bits(), |lane| {
        let distance_m2 = distance_m2.lane(lane);
        let is_above = limit.high_m2.lane(lane) < distance_m2;
        !is_above && exact(lane)
    })
}

/// The mask of the lanes of `surely`, and of those of the others that are asked one by one.
#[cold]
#[inline(never)]
fn in_doubt<S: Simd>(simd: S, surely: u32, is_so: impl Fn(usize) -> bool) -> S::M {
    let answer = |lane: usize| if surely >> lane & 1 == 1 || is_so(lane) { 1.0 } else { 0.0 };
    simd.single(0.5).lt(simd.singles(answer))
}

fn between_by_definition<F>(one: &Body<F>, other: &Body<F>, lane: usize) -> f64
where
    F: Number<Scalar = f32>,
{
    let number = |number: F| f64::from(number.lane(lane));
    let dx_m = number(one.x_m) - number(other.x_m);
    let dy_m = number(one.y_m) - number(other.y_m);
    dx_m * dx_m + dy_m * dy_m
}

fn nearest_by_definition<F>(row: &[Body<F>], robot: usize, lane: usize) -> f64
where
    F: Number<Scalar = f32>,
{
    let others = (0..row.len()).filter(|other| *other != robot);
    others
        .map(|other| between_by_definition(&row[other], &row[robot], lane))
        .fold(f64::INFINITY, f64::min)
}
