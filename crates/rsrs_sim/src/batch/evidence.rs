//! The order parameters of many worlds at once.
//!
//! [`rsrs_core::order::Evidence`] is the definition; this is the same arithmetic in the same order,
//! a lane for each world, and a test holds the two together to the bit. Sums run over samples and
//! robots in their order, so no lane's sum depends on another lane.

use std::ops::Range;

use rsrs_core::order::Evidence;
use rsrs_core::trajectory::Bodies;

use super::rows::Rows;
use super::simd::{Mask, Number, Simd, Work};
use super::trigonometry::{atan2, sincos};

/// The constants of [`rsrs_core::order`].
const BLOCKED_SHARE: f64 = 0.2;
const BLOCKED_OVER_S: f64 = 1.0;
const STUCK_SHARE: f64 = 0.9;
pub(super) const LOST_SHARE: f64 = 0.5;
const CONTACT_TOLERANCE: f64 = 0.02;

/// What was commanded in a window: the same for all worlds, as all robots have the same controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Commanded {
    /// Control period, in seconds.
    pub period_s: f64,
    /// Way of all robots together, in metres.
    pub way_m: f64,
    /// `1 - ωΔt/2`
    circliness_ceiling: f64,
    /// Samples back to where a robot that may be blocked was.
    pub back: u64,
    /// Squared way below which it counts as blocked, in square metres.
    pub blocked_below_m2: f64,
}

impl Commanded {
    /// What robots with a controller are told in a window.
    ///
    /// The sums are taken as the judge takes them, term by term.
    pub fn new(
        (speed_m_s, turn_rate_rad_s): (f64, f64),
        period_s: f64,
        (n_samples, n_robots): (usize, usize),
    ) -> Self {
        let (mut way_m, mut turned) = (0.0, 0.0);
        for _ in 0..(n_samples - 1) * n_robots {
            way_m += speed_m_s.abs() * period_s;
        }
        for _ in 0..n_samples * n_robots {
            turned += turn_rate_rad_s.abs();
        }
        let mean_turn_rad = turned * period_s / (n_samples * n_robots) as f64;
        let back = (BLOCKED_OVER_S / period_s).round().max(1.0) as u64;
        let commanded_m = (0..back).map(|_| speed_m_s.abs()).sum::<f64>();
        let limit_m = BLOCKED_SHARE * commanded_m * period_s;
        Self {
            period_s,
            way_m,
            circliness_ceiling: 1.0 - mean_turn_rad / 2.0,
            back,
            blocked_below_m2: limit_m * limit_m,
        }
    }
}

/// A window of the swarms' past.
#[derive(Clone, Copy)]
pub struct Window<'a, F> {
    /// The rows; all samples of the window are among them.
    pub rows: &'a Rows<F>,
    /// Its first sample.
    pub start: u64,
    /// One after its last sample.
    pub end: u64,
    /// What was commanded in it.
    pub commanded: &'a Commanded,
    /// What is known of the robots.
    pub bodies: Bodies,
}

/// Memory for one half of the lanes, used again from window to window.
pub struct Scratch<S: Simd> {
    places: Vec<(S::D, S::D)>,
    arms: Vec<(S::D, S::D)>,
    nearest_m2: Vec<S::D>,
    touched: Vec<S::N>,
    alone: Vec<S::D>,
    blocked: Vec<S::D>,
}

impl<S: Simd> Scratch<S> {
    pub fn new() -> Self {
        Self {
            places: Vec::new(),
            arms: Vec::new(),
            nearest_m2: Vec::new(),
            touched: Vec::new(),
            alone: Vec::new(),
            blocked: Vec::new(),
        }
    }

    fn clear(&mut self, simd: S, n_robots: usize) {
        let zero = simd.double(0.0);
        for pairs in [&mut self.places, &mut self.arms] {
            pairs.clear();
            pairs.resize(n_robots, (zero, zero));
        }
        for numbers in [&mut self.nearest_m2, &mut self.alone, &mut self.blocked] {
            numbers.clear();
            numbers.resize(n_robots, zero);
        }
        self.touched.clear();
        self.touched.resize(n_robots, simd.no_double());
    }
}

/// Computes the order parameters of one half of the lanes.
///
/// # Returns
///
/// One entry for each lane of the half, in `evidence`.
pub struct Gather<'a, S: Simd, const HALF: usize> {
    pub simd: S,
    pub window: Window<'a, S::F>,
    pub scratch: &'a mut Scratch<S>,
    pub evidence: &'a mut [Evidence],
}

impl<S: Simd, const HALF: usize> Work for Gather<'_, S, HALF> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { simd, window, scratch, evidence } = self;
        let n_robots = window.rows.at(window.start).len();
        scratch.clear(simd, n_robots);
        let mut ring = Ring::new(simd, n_robots);
        let mut onsets = simd.double(0.0);
        for sample in window.start..window.end {
            place::<S, HALF>(simd, window.rows, sample, &mut scratch.places);
            ring.add::<HALF>(&window, sample, scratch);
            onsets = onsets + meet(simd, &window, sample, scratch);
            if sample >= window.start + window.commanded.back {
                look_back::<S, HALF>(simd, &window, sample, scratch);
            }
        }
        for (lane, evidence) in evidence.iter_mut().enumerate() {
            *evidence = ring.evidence(&window, scratch, (lane, onsets.lane(lane)));
        }
    }
}

/// Where the robots are.
#[inline(always)]
fn place<S: Simd, const HALF: usize>(
    simd: S,
    rows: &Rows<S::F>,
    sample: u64,
    places: &mut [(S::D, S::D)],
) {
    for (place, body) in places.iter_mut().zip(rows.at(sample)) {
        *place = (simd.half::<HALF>(body.x_m), simd.half::<HALF>(body.y_m));
    }
}

/// The sums of the motion around the centroid.
struct Ring<S: Simd> {
    simd: S,
    n_robots: usize,
    rotation: S::D,
    tangentness: S::D,
    radius_m: S::D,
    fatness: S::D,
    orbited_m: S::D,
}

impl<S: Simd> Ring<S> {
    #[inline(always)]
    fn new(simd: S, n_robots: usize) -> Self {
        let zero = simd.double(0.0);
        Self {
            simd,
            n_robots,
            rotation: zero,
            tangentness: zero,
            radius_m: zero,
            fatness: zero,
            orbited_m: zero,
        }
    }

    #[inline(always)]
    fn add<const HALF: usize>(
        &mut self,
        window: &Window<'_, S::F>,
        sample: u64,
        scratch: &mut Scratch<S>,
    ) {
        let simd = self.simd;
        let (zero, one) = (simd.double(0.0), simd.double(1.0));
        let sum = scratch.places.iter().fold((zero, zero), |sum, at| (sum.0 + at.0, sum.1 + at.1));
        let n_robots = simd.double(self.n_robots as f64);
        let centroid = (sum.0 / n_robots, sum.1 / n_robots);
        let (mut least_m2, mut most_m2) = (simd.double(f64::INFINITY), zero);
        let robots = window.rows.at(sample).iter().zip(&scratch.places).zip(&mut scratch.arms);
        for ((body, place), arm_before) in robots {
            let arm = (place.0 - centroid.0, place.1 - centroid.1);
            let arm_m2 = arm.0 * arm.0 + arm.1 * arm.1;
            let arm_m = arm_m2.sqrt();
            least_m2 = least_m2.least(arm_m2);
            most_m2 = most_m2.most(arm_m2);
            self.radius_m = self.radius_m + arm_m;
            let heading = (simd.half::<HALF>(body.cosine), simd.half::<HALF>(body.sine));
            let (sine, cosine) = sincos(simd, atan2(simd, heading.1, heading.0));
            // On the centroid there is no direction around it: such a robot faces outward.
            let is_central = arm_m.le(zero);
            let around = (arm.0 * sine - arm.1 * cosine) / arm_m;
            let outward = (arm.0 * cosine + arm.1 * sine) / arm_m;
            self.rotation = self.rotation + around.unless(is_central);
            self.tangentness = self.tangentness + S::D::select(is_central, one, outward.abs());
            if sample > window.start {
                self.orbited_m = self.orbited_m + angle_between(simd, *arm_before, arm) * arm_m;
            }
            *arm_before = arm;
        }
        let fatness = one - least_m2 / most_m2;
        self.fatness = self.fatness + fatness.unless(most_m2.le(zero));
    }

    fn evidence(
        &self,
        window: &Window<'_, S::F>,
        scratch: &Scratch<S>,
        (lane, onsets): (usize, f64),
    ) -> Evidence {
        let commanded = window.commanded;
        let n_samples = (window.end - window.start) as f64;
        let n_robots = self.n_robots as f64;
        let n_poses = n_samples * n_robots;
        let n_looks = (window.end - window.start).saturating_sub(commanded.back);
        let looks = || scratch.blocked.iter().map(|looks| looks.lane(lane));
        let is_stuck = |looks: &f64| *looks > STUCK_SHARE * n_looks as f64;
        let is_lost = |steps: &f64| *steps > LOST_SHARE * n_samples;
        let n_lost = scratch.alone.iter().map(|steps| steps.lane(lane)).filter(is_lost).count();
        let orbit =
            if commanded.way_m > 0.0 { self.orbited_m.lane(lane) / commanded.way_m } else { 0.0 };
        let fatness = self.fatness.lane(lane) / n_samples;
        let tangentness = self.tangentness.lane(lane) / n_poses;
        let (blocked, stuck) = if n_looks == 0 {
            (0.0, 0.0)
        } else {
            let n_stuck = looks().filter(is_stuck).count() as f64;
            (looks().sum::<f64>() / (n_looks as f64 * n_robots), n_stuck / n_robots)
        };
        let robot_seconds = n_samples * commanded.period_s * n_robots;
        Evidence {
            lost: window.bodies.range_m.map(|_| n_lost as f64 / n_robots),
            blocked,
            stuck,
            rotation: (self.rotation.lane(lane) / n_poses).abs(),
            orbit: orbit.abs(),
            fatness,
            tangentness,
            circliness: 1.0 - fatness.max(tangentness),
            mean_radius_m: self.radius_m.lane(lane) / n_poses,
            contact_onsets_per_s: window.bodies.radius_m.map(|_| onsets / robot_seconds),
            circliness_ceiling: commanded.circliness_ceiling,
        }
    }
}

/// The angle from one vector to another, as the judge takes it.
#[inline(always)]
fn angle_between<S: Simd>(simd: S, from: (S::D, S::D), to: (S::D, S::D)) -> S::D {
    let one = |number| simd.double(number);
    let across = from.0 * to.1 - from.1 * to.0;
    let along = from.0 * to.0 + from.1 * to.1;
    let tangent = across / along;
    let square = tangent * tangent;
    let sixth = one(1.0 / 13.0) - square / one(15.0);
    let fourth = one(1.0 / 9.0) - square * (one(1.0 / 11.0) - square * sixth);
    let second = one(1.0 / 5.0) - square * (one(1.0 / 7.0) - square * fourth);
    let angle = tangent * (one(1.0) - square * (one(1.0 / 3.0) - square * second));
    let is_small = along.gt(one(0.0)) & tangent.abs().lt(one(0.1));
    if is_small.bits() == (1 << (S::LANES / 2)) - 1 {
        return angle;
    }
    S::D::select(is_small, angle, atan2(simd, across, along))
}

/// Who is near whom; returns how many came into contact, for each lane.
#[inline(always)]
fn meet<S: Simd>(
    simd: S,
    window: &Window<'_, S::F>,
    sample: u64,
    scratch: &mut Scratch<S>,
) -> S::D {
    let (zero, one) = (simd.double(0.0), simd.double(1.0));
    nearest_neighbours(simd, &scratch.places, &mut scratch.nearest_m2);
    let range_m2 = window.bodies.range_m.map_or(f64::INFINITY, |range_m| range_m * range_m);
    let contact_m2 = window.bodies.radius_m.map_or(0.0, |radius_m| {
        let contact_m = 2.0 * radius_m * (1.0 + CONTACT_TOLERANCE);
        contact_m * contact_m
    });
    let (range_m2, contact_m2) = (simd.double(range_m2), simd.double(contact_m2));
    let mut onsets = zero;
    let robots = scratch.nearest_m2.iter().zip(&mut scratch.alone).zip(&mut scratch.touched);
    for ((nearest_m2, alone), touched) in robots {
        *alone = *alone + one.unless(nearest_m2.le(range_m2));
        let touches = nearest_m2.lt(contact_m2);
        if touches.any() && sample > window.start {
            onsets = onsets + (one - one.unless(touches)).unless(*touched);
        }
        *touched = touches;
    }
    onsets
}

#[inline(always)]
fn nearest_neighbours<S: Simd>(simd: S, places: &[(S::D, S::D)], nearest_m2: &mut [S::D]) {
    nearest_m2.fill(simd.double(f64::INFINITY));
    let (mut places, mut nearest_m2) = (places, nearest_m2);
    while let (Some((me, others)), Some((mine, theirs))) =
        (places.split_first(), nearest_m2.split_first_mut())
    {
        let mut nearest = *mine;
        for (other, their_nearest) in others.iter().zip(&mut *theirs) {
            let (dx_m, dy_m) = (other.0 - me.0, other.1 - me.1);
            let between_m2 = dx_m * dx_m + dy_m * dy_m;
            nearest = nearest.least(between_m2);
            *their_nearest = their_nearest.least(between_m2);
        }
        *mine = nearest;
        (places, nearest_m2) = (others, theirs);
    }
}

/// Who has hardly moved since a second ago.
#[inline(always)]
fn look_back<S: Simd, const HALF: usize>(
    simd: S,
    window: &Window<'_, S::F>,
    sample: u64,
    scratch: &mut Scratch<S>,
) {
    let one = simd.double(1.0);
    let below_m2 = simd.double(window.commanded.blocked_below_m2);
    let before = window.rows.at(sample - window.commanded.back);
    for ((place, body), blocked) in scratch.places.iter().zip(before).zip(&mut scratch.blocked) {
        let dx_m = place.0 - simd.half::<HALF>(body.x_m);
        let dy_m = place.1 - simd.half::<HALF>(body.y_m);
        let moved_m2 = dx_m * dx_m + dy_m * dy_m;
        *blocked = *blocked + (one - one.unless(moved_m2.lt(below_m2)));
    }
}

/// Gathers the evidence of all lanes of a window.
pub fn gather<S: Simd>(
    simd: S,
    window: Window<'_, S::F>,
    scratch: &mut Scratch<S>,
    lanes: Range<usize>,
) -> Vec<Evidence> {
    let half = S::LANES / 2;
    let mut evidence = vec![NOTHING; S::LANES];
    let (lower, upper) = evidence.split_at_mut(half);
    if lanes.start < half {
        let scratch = &mut *scratch;
        simd.vectorize(Gather::<S, 0> { simd, window, scratch, evidence: lower });
    }
    if lanes.end > half {
        simd.vectorize(Gather::<S, 1> { simd, window, scratch, evidence: upper });
    }
    evidence
}

/// What fills the lanes that were not asked for.
const NOTHING: Evidence = Evidence {
    lost: None,
    blocked: 0.0,
    stuck: 0.0,
    rotation: 0.0,
    orbit: 0.0,
    fatness: 0.0,
    tangentness: 0.0,
    circliness: 0.0,
    mean_radius_m: 0.0,
    contact_onsets_per_s: None,
    circliness_ceiling: 0.0,
};
