//! Order parameters: numbers that describe how a swarm moves, from poses and commands alone.
//!
//! All are means over a window of time. They are computed in double precision and in the order of
//! the robots, so that a simulated episode and its recording in a bag give the same numbers. They are
//! written over [`Samples`]: a sweep computes them for many worlds at once, by the same functions.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into the function of a vector unit does without its instructions"
)]

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::judge::trajectory::{Bodies, Trajectory};
use crate::robot::unicycle::Pose;

mod asked;
mod cluster;
mod geometry;
mod measure;
mod parameter;
mod samples;
mod sums;

pub use asked::Asked;
pub use geometry::Vector;
pub use parameter::{Parameter, Prerequisite};
pub use samples::{Commanded, Samples};
use sums::OrderAccumulator;
pub use sums::Sums;

/// Order parameters of one window: what a verdict rests on.
#[derive(Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct OrderParameters {
    /// Share of robots that had no neighbour within reach for more than half of the window; `None`
    /// if the reach is unknown.
    pub lost: Option<f64>,
    /// Share of time in which robots were blocked: in one second they came less than 20 % as far
    /// as they were commanded to drive, forward less backward.
    pub blocked: f64,
    /// Share of robots that were blocked for more than 90 % of the window.
    pub stuck: f64,
    /// How well headings circle the centroid: the normalised angular momentum, from 0 to 1;
    /// [`rounded`].
    pub rotation: f64,
    /// How far robots really went around the centroid, over how far they were commanded to drive,
    /// forward less backward; about 1 for a ring that runs freely, 0 for one that is jammed.
    pub orbit: f64,
    /// `1 - (r_min / r_max)²` of the distances from the centroid; 0 for a ring.
    pub fatness: f64,
    /// Mean `|cos|` of the angle between heading and bearing from the centroid; 0 for a ring;
    /// [`rounded`].
    pub tangentness: f64,
    /// `1 - max(fatness, tangentness)`; at most [`Self::circliness_ceiling`] in a mill that steers
    /// once per period.
    pub circliness: f64,
    /// Mean distance from the centroid, in metres.
    pub mean_radius_m: f64,
    /// How often a robot comes into contact, per robot and second; `None` if the body's radius is
    /// unknown.
    pub contact_onsets_per_s: Option<f64>,
    /// `1 - ωΔt/2`: the heading swings by `ωΔt` between left and right, so even a perfect mill is
    /// not more circular than this.
    pub circliness_ceiling: f64,
    /// Share of the robots in the largest cluster, a mean over looks every 10 s; `None` if the body's
    /// radius is unknown. Robots between which no other one fits are of one cluster.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clustered: Option<f64>,
    /// Those that nobody has who does not ask for them.
    #[serde(flatten)]
    pub asked: Asked,
}

/// Those that nobody asked for are not there.
impl fmt::Debug for OrderParameters {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            lost,
            blocked,
            stuck,
            rotation,
            orbit,
            fatness,
            tangentness,
            circliness,
            mean_radius_m,
            contact_onsets_per_s,
            circliness_ceiling,
            clustered,
            asked: _,
        } = self;
        let mut all = formatter.debug_struct("OrderParameters");
        all.field("lost", lost)
            .field("blocked", blocked)
            .field("stuck", stuck)
            .field("rotation", rotation)
            .field("orbit", orbit)
            .field("fatness", fatness)
            .field("tangentness", tangentness)
            .field("circliness", circliness)
            .field("mean_radius_m", mean_radius_m)
            .field("contact_onsets_per_s", contact_onsets_per_s)
            .field("circliness_ceiling", circliness_ceiling)
            .field("clustered", clustered);
        for parameter in Parameter::all_asked() {
            if let Some(value) = parameter.value(self) {
                all.field(parameter.key(), &value);
            }
        }
        all.finish()
    }
}

/// A robot is blocked when it comes less far than this share of its commanded way.
pub const BLOCKED_SHARE: f64 = 0.2;

/// The time over which that is measured, in seconds. A robot that circles freely in place comes
/// `|sin(ωt/2)| / (ωt/2)` of its way, so up to 5 rad/s no free robot counts as blocked.
pub const BLOCKED_OVER_S: f64 = 1.0;

/// Samples back to where a robot that may be blocked was.
pub fn look_back(period_s: f64) -> usize {
    (BLOCKED_OVER_S / period_s).round().max(1.0) as usize
}

/// A robot that is blocked for more than this share of the window is stuck.
pub const STUCK_SHARE: f64 = 0.9;

/// A robot without a neighbour for more than this share of the window is lost.
pub const LOST_SHARE: f64 = 0.5;

/// Bodies touch when their centres are within two radii; a tracker may put touching bodies this
/// share further apart.
pub const CONTACT_TOLERANCE: f64 = 0.02;

impl OrderParameters {
    /// Computes the order parameters of a window of a trajectory that is finite throughout.
    ///
    /// # Panics
    ///
    /// If there is no robot or the window is empty or reaches outside the trajectory.
    ///
    /// # Source
    ///
    /// Fatness, tangentness and circliness as in `Circliness.py` of kenblu24/RobotSwarmSimulator;
    /// normalised angular momentum as in the literature on mills (`MRD-YC-ALB-LSC:06`).
    pub fn new(trajectory: &Trajectory, samples: Range<usize>, bodies: &Bodies) -> Self {
        Self::with(trajectory, samples, bodies, &[])
    }

    /// As [`Self::new`], with those of `asked` that are measured only where they are asked for
    /// ([`Rules::asked`](crate::judge::behaviour::rule::Rules::asked)).
    ///
    /// # Panics
    ///
    /// As [`Self::new`].
    pub fn with(
        trajectory: &Trajectory,
        samples: Range<usize>,
        bodies: &Bodies,
        asked: &[Parameter],
    ) -> Self {
        assert!(trajectory.n_robots > 0, "order needs at least one robot");
        assert!(!samples.is_empty() && samples.end <= trajectory.n_samples());
        let (sums, _) = sums_with_blocks(trajectory, samples, bodies, usize::MAX);
        sums.evidence((trajectory, bodies), 0, asked)
    }
}

/// Adds up a window, which is not empty, of all worlds, and each of its blocks of `n_block`
/// samples by itself. Blocks begin with the window; what is left over at its end belongs to none.
#[inline(always)]
pub fn sums_with_blocks<S: Samples>(
    samples: &S,
    window: Range<usize>,
    bodies: &Bodies,
    n_block: usize,
) -> (Sums<S::Number>, Vec<Sums<S::Number>>) {
    let mut walk = OrderAccumulator::new(samples, bodies, samples.poses_at(window.start).len());
    let mut whole = walk.sums(window.start);
    let n_blocks = window.len() / n_block;
    let mut blocks = Vec::with_capacity(n_blocks);
    for block in 0..n_blocks {
        let start = window.start + block * n_block;
        let mut sums = walk.sums(start);
        for sample in start..start + n_block {
            walk.add(sample, [&mut whole, &mut sums]);
        }
        blocks.push(sums);
    }
    for sample in window.start + n_blocks * n_block..window.end {
        walk.add(sample, [&mut whole]);
    }
    (whole, blocks)
}

/// What [`rounded`] rounds to a multiple of: about one part in 10^9.
pub const RESOLUTION: f64 = 1.0 / 1_073_741_824.0;

/// Rounds a mean over headings, so that it does not depend on the last bits of sines and cosines.
///
/// A heading is known as an angle here and as a unit vector where it is simulated. Both agree to
/// some 15 digits; rounded, they are the same number.
pub fn rounded(mean: f64) -> f64 {
    (mean / RESOLUTION).round() * RESOLUTION
}

/// Whether all numbers within a margin of a mean are rounded to the same one. What is not a number
/// is not.
fn rounds_surely(mean: f64, margin: f64) -> bool {
    let whole = mean / RESOLUTION;
    ((whole - whole.floor()) - 0.5).abs() * RESOLUTION > margin
}

/// The centroid of some places, in metres; not empty.
pub fn centre(places: &[Vector<f64>]) -> Vector<f64> {
    geometry::centroid(0.0, places)
}

/// Mean distance of robots from their centroid at one time, in metres; there is at least one robot.
pub fn mean_radius_m(poses: &[Pose]) -> f64 {
    let places: Vec<_> = poses.iter().map(|pose| (pose.x_m, pose.y_m)).collect();
    let centroid = centre(&places);
    let radius_m = |place: &Vector<f64>| geometry::distance_m2(*place, centroid).sqrt();
    places.iter().map(radius_m).sum::<f64>() / poses.len() as f64
}

/// Distance of every robot to its nearest neighbour at one time, in metres; infinite for a robot that
/// is the only one.
pub(crate) fn nearest_neighbours_m(poses: &[Pose]) -> Vec<f64> {
    let places: Vec<_> = poses.iter().map(|pose| (pose.x_m, pose.y_m)).collect();
    let mut nearest_m2 = vec![0.0; poses.len()];
    geometry::nearest_neighbours(0.0, &places, &mut nearest_m2);
    nearest_m2.into_iter().map(f64::sqrt).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_next_to_where_rounding_changes_is_left_to_the_definition() {
        let middle = (12_345.0 + 0.5) * RESOLUTION;

        for (mean, is_sure) in [
            (middle, false),
            (middle - 0.9e-12, false),
            (middle + 0.9e-12, false),
            (middle - 1.1e-12, true),
            (middle + 1.1e-12, true),
            (f64::NAN, false),
        ] {
            assert_eq!(rounds_surely(mean, 1e-12), is_sure, "{mean}");
        }
    }
}
