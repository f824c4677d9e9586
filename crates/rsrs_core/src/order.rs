//! Order parameters: numbers that say how a swarm moves, from poses and commands alone.
//!
//! All are means over a window of time. They are computed in double precision and in the order of
//! the robots, so that a simulated episode and its recording in a bag give the same numbers.

use std::ops::Range;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::trajectory::{Bodies, Trajectory};
use crate::unicycle::Pose;

/// Order parameters of one window: what a verdict rests on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
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
}

/// A robot is blocked when it comes less far than this share of its commanded way.
pub const BLOCKED_SHARE: f64 = 0.2;

/// The time over which that is measured, in seconds. A robot that circles freely in place comes
/// `|sin(ωt/2)| / (ωt/2)` of its way, so up to 5 rad/s no free robot counts as blocked.
pub const BLOCKED_OVER_S: f64 = 1.0;

/// A robot that is blocked for more than this share of the window is stuck.
pub const STUCK_SHARE: f64 = 0.9;

/// A robot without a neighbour for more than this share of the window is lost.
pub const LOST_SHARE: f64 = 0.5;

/// Bodies touch when their centres are within two radii; a tracker may put touching bodies this
/// share further apart.
pub const CONTACT_TOLERANCE: f64 = 0.02;

impl Evidence {
    /// Computes the order parameters of a window.
    ///
    /// # Arguments
    ///
    /// * `trajectory` — of at least one robot, finite throughout.
    /// * `samples` — the window; not empty, within the trajectory.
    /// * `bodies` — what is known of the robots.
    ///
    /// # Panics
    ///
    /// If there is no robot or the window is empty or reaches outside the trajectory.
    ///
    /// # Source
    ///
    /// Fatness, tangentness and circliness as in `Circliness.py` of kenblu24/RobotSwarmSimulator;
    /// normalised angular momentum as in the literature on mills (`MRD-YC-ALB-LSC:06`).
    pub fn of(trajectory: &Trajectory, samples: Range<usize>, bodies: &Bodies) -> Self {
        assert!(trajectory.n_robots > 0, "order needs at least one robot");
        assert!(!samples.is_empty() && samples.end <= trajectory.n_samples());
        let ring = Ring::of(trajectory, samples.clone());
        let neighbours = Neighbours::of(trajectory, samples.clone(), bodies);
        let blocking = Blocking::of(trajectory, samples.clone());
        Self {
            lost: neighbours.lost,
            blocked: blocking.blocked,
            stuck: blocking.stuck,
            rotation: rounded(ring.rotation.abs()),
            orbit: ring.orbit.abs(),
            fatness: ring.fatness,
            tangentness: ring.tangentness,
            circliness: 1.0 - ring.fatness.max(ring.tangentness),
            mean_radius_m: ring.mean_radius_m,
            contact_onsets_per_s: neighbours.contact_onsets_per_s,
            circliness_ceiling: 1.0 - mean_turn_rad(trajectory, samples) / 2.0,
        }
    }
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

/// Mean distance of robots from their centroid, in metres.
///
/// # Arguments
///
/// * `poses` — all robots at one time; shape `[n_robots]`, not empty.
pub fn mean_radius_m(poses: &[Pose]) -> f64 {
    let centroid = centroid(poses);
    poses.iter().map(|pose| (position(pose) - centroid).norm()).sum::<f64>() / poses.len() as f64
}

fn position(pose: &Pose) -> Vector2<f64> {
    Vector2::new(pose.x_m, pose.y_m)
}

fn centroid(poses: &[Pose]) -> Vector2<f64> {
    poses.iter().map(position).sum::<Vector2<f64>>() / poses.len() as f64
}

/// Mean commanded turn in one period, in radians.
fn mean_turn_rad(trajectory: &Trajectory, samples: Range<usize>) -> f64 {
    let commands = samples.clone().flat_map(|sample| trajectory.commands_at(sample));
    let sum: f64 = commands.map(|command| command.turn_rate_rad_s.abs()).sum();
    sum * trajectory.period_s / (samples.len() * trajectory.n_robots) as f64
}

/// The motion around the centroid.
struct Ring {
    rotation: f64,
    orbit: f64,
    fatness: f64,
    tangentness: f64,
    mean_radius_m: f64,
}

impl Ring {
    fn of(trajectory: &Trajectory, samples: Range<usize>) -> Self {
        let (mut rotation, mut tangentness, mut radius_m, mut fatness) = (0.0, 0.0, 0.0, 0.0);
        let mut orbited_m = 0.0;
        // Forward less backward.
        let mut commanded_m = vec![0.0_f64; trajectory.n_robots];
        let mut arms_before: Vec<Vector2<f64>> = Vec::with_capacity(trajectory.n_robots);
        for sample in samples.clone() {
            let poses = trajectory.poses_at(sample);
            let centroid = centroid(poses);
            let (mut least_m2, mut most_m2) = (f64::INFINITY, 0.0_f64);
            for (robot, pose) in poses.iter().enumerate() {
                let arm = position(pose) - centroid;
                let arm_m2 = arm.norm_squared();
                let arm_m = arm_m2.sqrt();
                least_m2 = least_m2.min(arm_m2);
                most_m2 = most_m2.max(arm_m2);
                radius_m += arm_m;
                let (around, outward) = heading_along(arm, arm_m, pose.heading_rad);
                rotation += around;
                tangentness += outward.abs();
                if sample == samples.start {
                    arms_before.push(arm);
                } else {
                    let command = &trajectory.commands_at(sample - 1)[robot];
                    commanded_m[robot] += command.speed_m_s * trajectory.period_s;
                    orbited_m += angle_between(arms_before[robot], arm) * arm_m;
                    arms_before[robot] = arm;
                }
            }
            fatness += if most_m2 > 0.0 { 1.0 - least_m2 / most_m2 } else { 0.0 };
        }
        let commanded_m = commanded_m.iter().map(|way_m| way_m.abs()).sum::<f64>();
        let n_samples = samples.len() as f64;
        let n_poses = n_samples * trajectory.n_robots as f64;
        Self {
            rotation: rotation / n_poses,
            orbit: if commanded_m > 0.0 { orbited_m / commanded_m } else { 0.0 },
            fatness: fatness / n_samples,
            tangentness: rounded(tangentness / n_poses),
            mean_radius_m: radius_m / n_poses,
        }
    }
}

/// Components of a heading around the centroid (counterclockwise) and away from it.
///
/// A robot on the centroid has no direction around it: it counts as facing outward.
fn heading_along(arm: Vector2<f64>, arm_m: f64, heading_rad: f64) -> (f64, f64) {
    if arm_m == 0.0 {
        return (0.0, 1.0);
    }
    let (sine, cosine) = libm::sincos(heading_rad);
    let heading = Vector2::new(cosine, sine);
    (arm.perp(&heading) / arm_m, arm.dot(&heading) / arm_m)
}

/// The angle from one vector to another, in radians, counterclockwise; 0 if either is zero.
fn angle_between(from: Vector2<f64>, to: Vector2<f64>) -> f64 {
    let (across, along) = (from.perp(&to), from.dot(&to));
    let tangent = across / along;
    if along > 0.0 && tangent.abs() < 0.1 {
        // The arctangent's series: a robot goes around by little in one period, and this is ten
        // times cheaper. The first term left out is below 1e-15.
        let square = tangent * tangent;
        let sixth = 1.0 / 13.0 - square * (1.0 / 15.0);
        let fourth = 1.0 / 9.0 - square * (1.0 / 11.0 - square * sixth);
        let second = 1.0 / 5.0 - square * (1.0 / 7.0 - square * fourth);
        return tangent * (1.0 - square * (1.0 / 3.0 - square * second));
    }
    libm::atan2(across, along)
}

/// Who is near whom.
struct Neighbours {
    lost: Option<f64>,
    contact_onsets_per_s: Option<f64>,
}

impl Neighbours {
    fn of(trajectory: &Trajectory, samples: Range<usize>, bodies: &Bodies) -> Self {
        let n_robots = trajectory.n_robots;
        let reach_m2 = bodies.reach_m.map(|reach_m| reach_m * reach_m);
        let contact_m2 = bodies.radius_m.map(|radius_m| {
            let contact_m = 2.0 * radius_m * (1.0 + CONTACT_TOLERANCE);
            contact_m * contact_m
        });
        let mut alone = vec![0_usize; n_robots];
        let mut touched: Option<Vec<bool>> = None;
        let mut onsets = 0_usize;
        let mut nearest_m2 = vec![f64::INFINITY; n_robots];
        for sample in samples.clone() {
            nearest_neighbours(trajectory.poses_at(sample), &mut nearest_m2);
            for (alone, distance_m2) in alone.iter_mut().zip(&nearest_m2) {
                let is_alone =
                    reach_m2.map_or(distance_m2.is_infinite(), |reach_m2| *distance_m2 > reach_m2);
                *alone += usize::from(is_alone);
            }
            let touches = |distance_m2: &f64| contact_m2.is_some_and(|limit| *distance_m2 < limit);
            let before = touched.get_or_insert_with(|| nearest_m2.iter().map(touches).collect());
            for (before, distance_m2) in before.iter_mut().zip(&nearest_m2) {
                let now = touches(distance_m2);
                onsets += usize::from(now && !*before);
                *before = now;
            }
        }
        let n_samples = samples.len() as f64;
        let is_lost = |steps: &&usize| **steps as f64 > LOST_SHARE * n_samples;
        let robot_seconds = n_samples * trajectory.period_s * n_robots as f64;
        // Whoever is alone has lost everybody, at any reach.
        let is_decided = reach_m2.is_some() || n_robots == 1;
        let lost = || alone.iter().filter(is_lost).count() as f64 / n_robots as f64;
        Self {
            lost: is_decided.then(lost),
            contact_onsets_per_s: contact_m2.map(|_| onsets as f64 / robot_seconds),
        }
    }
}

/// Squared distance of every robot to its nearest neighbour, in square metres; infinite for a
/// robot that is the only one.
fn nearest_neighbours(poses: &[Pose], nearest_m2: &mut [f64]) {
    nearest_m2.fill(f64::INFINITY);
    for (robot, pose) in poses.iter().enumerate() {
        let mut nearest = nearest_m2[robot];
        for (other, distance_m2) in poses[robot + 1..].iter().zip(&mut nearest_m2[robot + 1..]) {
            let between_m2 = (position(other) - position(pose)).norm_squared();
            nearest = nearest.min(between_m2);
            *distance_m2 = distance_m2.min(between_m2);
        }
        nearest_m2[robot] = nearest;
    }
}

/// Distance of every robot to its nearest neighbour, in metres; infinite for a robot that is the only
/// one.
///
/// # Arguments
///
/// * `poses` — all robots at one time; shape `[n_robots]`.
pub(crate) fn nearest_neighbours_m(poses: &[Pose]) -> Vec<f64> {
    let mut nearest = vec![f64::INFINITY; poses.len()];
    nearest_neighbours(poses, &mut nearest);
    nearest.into_iter().map(f64::sqrt).collect()
}

/// Who is kept from driving.
struct Blocking {
    blocked: f64,
    stuck: f64,
}

impl Blocking {
    fn of(trajectory: &Trajectory, samples: Range<usize>) -> Self {
        let back = (BLOCKED_OVER_S / trajectory.period_s).round().max(1.0) as usize;
        let n_robots = trajectory.n_robots;
        let n_looks = samples.len().saturating_sub(back);
        if n_looks == 0 {
            return Self { blocked: 0.0, stuck: 0.0 };
        }
        let mut blocked = vec![0_usize; n_robots];
        for (robot, blocked) in blocked.iter_mut().enumerate() {
            let speed_m_s =
                |sample: usize| trajectory.commands[sample * n_robots + robot].speed_m_s;
            let place = |sample: usize| position(&trajectory.poses[sample * n_robots + robot]);
            for now in samples.start + back..samples.end {
                let commanded_m = (now - back..now).map(speed_m_s).sum::<f64>().abs();
                let limit_m = BLOCKED_SHARE * commanded_m * trajectory.period_s;
                let moved_m2 = (place(now) - place(now - back)).norm_squared();
                *blocked += usize::from(moved_m2 < limit_m * limit_m);
            }
        }
        let is_stuck = |looks: &&usize| **looks as f64 > STUCK_SHARE * n_looks as f64;
        Self {
            blocked: blocked.iter().sum::<usize>() as f64 / (n_looks * n_robots) as f64,
            stuck: blocked.iter().filter(is_stuck).count() as f64 / n_robots as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_of_the_angle_agrees_with_the_arctangent() {
        for step in -2000..2000 {
            let angle = f64::from(step) * 1e-3;
            let to = Vector2::new(libm::cos(angle), libm::sin(angle)) * 0.7;

            assert!((angle_between(Vector2::new(0.8, 0.0), to) - angle).abs() < 1e-14, "{angle}");
        }
    }
}
