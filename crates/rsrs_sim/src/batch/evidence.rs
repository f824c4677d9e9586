//! The order parameters of many worlds at once.
//!
//! [`rsrs_core::order::Evidence`] is the definition; these are the same numbers for a lane of each
//! world, and a test holds the two together to the bit. Sums run over samples and robots in their
//! order, so no lane's sum depends on another lane.
//!
//! The motion around the centroid ([`ring`]) is summed in double precision. Who is near whom and who
//! is held up ([`neighbour_counts`]) is counted: there single precision decides wherever it surely can.

use std::ops::Range;

use rsrs_core::order::{BLOCKED_OVER_S, BLOCKED_SHARE, Evidence, LOST_SHARE, STUCK_SHARE};
use rsrs_core::trajectory::Bodies;

use super::rows::Rows;
use crate::vector::simd::Simd;
use neighbour_counts::{CountNeighbours, NeighbourCounts};
use ring::{Arms, Motion, SumMotion};

mod neighbour_counts;
mod ring;

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
        let (mut way_of_one_m, mut turned) = (0.0_f64, 0.0);
        for _ in 1..n_samples {
            way_of_one_m += speed_m_s * period_s;
        }
        let way_m = (0..n_robots).map(|_| way_of_one_m.abs()).sum::<f64>();
        for _ in 0..n_samples * n_robots {
            turned += turn_rate_rad_s.abs();
        }
        let mean_turn_rad = turned * period_s / (n_samples * n_robots) as f64;
        let back = (BLOCKED_OVER_S / period_s).round().max(1.0) as u64;
        let commanded_m = (0..back).map(|_| speed_m_s).sum::<f64>().abs();
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

/// Memory for one window, used again from window to window.
pub struct Scratch<S: Simd> {
    arms: Arms<S>,
    neighbour_counts: NeighbourCounts<S>,
}

impl<S: Simd> Scratch<S> {
    /// No memory yet.
    pub fn new(simd: S) -> Self {
        Self { arms: Arms::new(), neighbour_counts: NeighbourCounts::new(simd) }
    }
}

/// Gathers the evidence of some lanes of a window.
///
/// # Returns
///
/// One entry for each of the lanes.
pub fn gather<S: Simd>(
    simd: S,
    window: Window<'_, S::F>,
    scratch: &mut Scratch<S>,
    lanes: Range<usize>,
) -> Vec<Evidence> {
    let Scratch { arms, neighbour_counts } = scratch;
    simd.vectorize(CountNeighbours { simd, window, neighbour_counts: &mut *neighbour_counts });
    let mut motions = Vec::with_capacity(S::LANES);
    motions.extend(simd.vectorize(SumMotion::<S, 0> { simd, window, arms: &mut *arms }));
    if lanes.end > S::LANES / 2 {
        motions.extend(simd.vectorize(SumMotion::<S, 1> { simd, window, arms }));
    }
    lanes.map(|lane| evidence(&window, neighbour_counts, &motions[lane], lane)).collect()
}

fn evidence<S: Simd>(
    window: &Window<'_, S::F>,
    neighbour_counts: &NeighbourCounts<S>,
    motion: &Motion,
    lane: usize,
) -> Evidence {
    let commanded = window.commanded;
    let n_samples = (window.end - window.start) as f64;
    let n_robots = window.rows.at(window.start).len() as f64;
    let n_looks = (window.end - window.start).saturating_sub(commanded.back);
    let counts = neighbour_counts.counts(lane);
    let is_stuck = |looks: &&f64| **looks > STUCK_SHARE * n_looks as f64;
    let is_lost = |steps: &&f64| **steps > LOST_SHARE * n_samples;
    let n_lost = counts.alone.iter().filter(is_lost).count();
    let (blocked, stuck) = if n_looks == 0 {
        (0.0, 0.0)
    } else {
        let n_stuck = counts.blocked.iter().filter(is_stuck).count() as f64;
        let n_blocked = counts.blocked.iter().sum::<f64>();
        (n_blocked / (n_looks as f64 * n_robots), n_stuck / n_robots)
    };
    let (rotation, tangentness) = motion.headings(window, lane);
    let robot_seconds = n_samples * commanded.period_s * n_robots;
    Evidence {
        lost: window.bodies.reach_m.map(|_| n_lost as f64 / n_robots),
        blocked,
        stuck,
        rotation,
        orbit: motion.orbit(commanded),
        fatness: motion.fatness(n_samples),
        tangentness,
        circliness: 1.0 - motion.fatness(n_samples).max(tangentness),
        mean_radius_m: motion.mean_radius_m(n_samples * n_robots),
        contact_onsets_per_s: window.bodies.radius_m.map(|_| counts.onsets / robot_seconds),
        circliness_ceiling: commanded.circliness_ceiling,
    }
}
