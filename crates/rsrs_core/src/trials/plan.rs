//! Which trials are worth running: a sheet to print, and tables to fill in.

use serde::Serialize;

use crate::quantity::{Axis, OtherUnit};
use crate::statistics::interval::Interval;
use crate::statistics::quantile;

mod sheet;

/// What is given before the first trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanRequest {
    /// Names of all robots of the fleet.
    pub robots: Vec<String>,
    /// How many of them to measure at most; the paper measured five.
    pub n_robots: usize,
    /// Least and greatest safe speed, in metres per second.
    pub limits_m_s: [f64; 2],
    /// Least and greatest safe turning rate, in radians per second.
    pub limits_rad_s: [f64; 2],
    /// Commands of each kind, evenly spaced within the limits; 1 or more.
    pub n_commands: usize,
    /// Length of the straight track, in metres; the paper's is 2.
    pub track_m: f64,
    /// Half of the width of the 95 % interval that each robot's gain shall have; dimensionless.
    pub gain_precision: f64,
    /// Standard deviation of the gain between trials that is expected; dimensionless.
    pub trial_sd: f64,
    /// Half of the width of the 95 % interval that each rate of detections shall have at most.
    pub rate_precision: f64,
    /// Radius of a robot's body, in metres.
    pub radius_m: f64,
    /// How far the sensor is expected to reach, centre to centre, in metres.
    pub range_m: f64,
    /// To which side the sensor is expected to see, in radians; above 0, at most π.
    pub half_angle_rad: f64,
    /// Distances of the detection grid; `None` for about one in each body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub n_distances: Option<usize>,
    /// Bearings of the detection grid.
    pub n_bearings: usize,
    /// Expected control period, in seconds: how fast readings come.
    pub period_s: f64,
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// The fleet has no robot.
    #[error("no robots, expected 1 or more")]
    NoRobots,
    /// A number outside what it can mean.
    #[error("{name} is {found}, expected {expected}")]
    OutOfRange {
        /// Which number.
        name: &'static str,
        /// What it is.
        found: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// A limit that is likely in another unit.
    #[error(transparent)]
    Unit(#[from] OtherUnit),
}

/// The trials worth running.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Robots to measure, spread over the fleet.
    pub robots: Vec<String>,
    /// Commanded speeds, in metres per second.
    pub speeds_m_s: Vec<f64>,
    /// Commanded turning rates, in radians per second.
    pub turn_rates_rad_s: Vec<f64>,
    /// Speed at which turns are also driven as arcs, in metres per second.
    pub arc_speed_m_s: f64,
    /// Repetitions of each command by each robot.
    pub repetitions: usize,
    /// Distances of the detection grid, centre to centre, in metres.
    pub distances_m: Vec<f64>,
    /// Bearings of the detection grid, in radians; left is positive.
    pub bearings_rad: Vec<f64>,
    /// Readings at each place.
    pub samples: u64,
    /// Readings of each robot without a neighbour.
    pub samples_alone: u64,
    /// Time for all readings without a neighbour, in seconds.
    pub false_positive_s: f64,
    /// Time for all trials without setting up, in seconds.
    pub duration_s: f64,
    /// What was asked for.
    pub request: PlanRequest,
}

impl Default for PlanRequest {
    /// The paper's procedure with a Flockbot; the robots' names are still missing.
    fn default() -> Self {
        Self {
            robots: Vec::new(),
            n_robots: 5,
            limits_m_s: [0.02, 0.30],
            limits_rad_s: [0.1, 2.5],
            n_commands: 5,
            track_m: 2.0,
            gain_precision: 0.02,
            trial_sd: 0.02,
            rate_precision: 0.1,
            radius_m: 0.075,
            range_m: 0.75,
            half_angle_rad: 0.35,
            n_distances: None,
            n_bearings: 9,
            period_s: 0.13,
        }
    }
}

/// Least number of repetitions: fewer give no useful spread.
const LEAST_REPETITIONS: usize = 3;
/// Beyond this, a better track helps more than more trials.
const MOST_REPETITIONS: usize = 1000;

/// Repetitions, 3 to 1000, after which Student's 95 % interval of a mean is expected to reach no
/// farther than `half_width` to either side; in the unit of `sd`, the expected standard deviation
/// of one trial.
///
/// # Example
///
/// ```
/// use rsrs_core::trials::plan::repetitions_for;
///
/// // An interval of one standard deviation to either side takes seven trials.
/// assert_eq!(repetitions_for(1.0, 1.0), 7);
/// ```
pub fn repetitions_for(sd: f64, half_width: f64) -> usize {
    (LEAST_REPETITIONS..MOST_REPETITIONS)
        .find(|n| {
            let n = *n as f64;
            quantile::student(n - 1.0, 0.975) * sd / n.sqrt() <= half_width
        })
        .unwrap_or(MOST_REPETITIONS)
}

/// Readings, a multiple of ten up to 20,000, after which half the exact 95 % interval of a share is
/// no wider than `half_width`; `share` is what is expected, e.g. 0.8 at the sensor's contour.
pub fn samples_for(share: f64, half_width: f64) -> u64 {
    let is_enough = |samples: u64| {
        let hits = (share * samples as f64).round() as u64;
        let Interval { low, high } = Interval::clopper_pearson(hits, samples);
        (high - low) / 2.0 <= half_width
    };
    (1..2000).map(|tens| tens * 10).find(|samples| is_enough(*samples)).unwrap_or(20_000)
}

/// Where the sensor's contour runs, and what the paper found without a neighbour (5 to 8 %).
const EXPECTED_SHARES: (f64, f64) = (crate::trials::fit::RELIABLE, 0.065);
/// False-positive rates are a tenth of the others, and there is one for the whole fleet: it is
/// measured this many times as precisely.
const ALONE_PRECISION: f64 = 5.0;

impl Plan {
    /// Plans trials.
    ///
    /// # Source
    ///
    /// §IV step 1: "constant control inputs at intervals within the safe bounds", "a representative
    /// group of five", "different distances and angles".
    pub fn new(request: PlanRequest) -> Result<Self, PlanError> {
        request.check()?;
        let samples = samples_for(EXPECTED_SHARES.0, request.rate_precision);
        let robots = spread_over(&request.robots, request.n_robots);
        let alone = samples_for(EXPECTED_SHARES.1, request.rate_precision / ALONE_PRECISION);
        let samples_alone = alone.div_ceil(robots.len() as u64);
        let false_positive_s = samples_alone as f64 * request.period_s * robots.len() as f64;
        let mut plan = Self {
            arc_speed_m_s: levels(request.limits_m_s, 1)[0],
            speeds_m_s: levels(request.limits_m_s, request.n_commands),
            turn_rates_rad_s: levels(request.limits_rad_s, request.n_commands),
            repetitions: repetitions_for(request.trial_sd, request.gain_precision),
            distances_m: distances_m(&request),
            bearings_rad: bearings_rad(&request),
            robots,
            samples,
            samples_alone,
            false_positive_s,
            duration_s: 0.0,
            request,
        };
        plan.duration_s = plan.duration_s();
        Ok(plan)
    }

    fn duration_s(&self) -> f64 {
        let each = (self.robots.len() * self.repetitions) as f64;
        let straight_s: f64 =
            self.speeds_m_s.iter().map(|speed_m_s| self.request.track_m / speed_m_s).sum();
        let turns_s: f64 =
            self.turn_rates_rad_s.iter().map(|rate_rad_s| std::f64::consts::TAU / rate_rad_s).sum();
        let places = (self.distances_m.len() * self.bearings_rad.len()) as f64;
        let readings_s = places * self.samples as f64 * self.request.period_s;
        // Every turn in place, and once more as an arc.
        each * (straight_s + 2.0 * turns_s) + readings_s + self.false_positive_s
    }
}

impl PlanRequest {
    fn check(&self) -> Result<(), PlanError> {
        let refuse = |name, found, expected| Err(PlanError::OutOfRange { name, found, expected });
        if self.robots.is_empty() {
            return Err(PlanError::NoRobots);
        }
        for (name, found) in [
            ("robots to measure", self.n_robots as f64),
            ("commands of each kind", self.n_commands as f64),
            ("the number of bearings", self.n_bearings as f64),
            ("the number of distances", self.n_distances.map_or(1.0, |n| n as f64)),
            ("the least safe speed in m/s", self.limits_m_s[0]),
            ("the least safe turning rate in rad/s", self.limits_rad_s[0]),
            ("the track in m", self.track_m),
            ("the precision of the gains", self.gain_precision),
            ("the precision of the rates", self.rate_precision),
            ("the body's radius in m", self.radius_m),
            ("the sensor's range in m", self.range_m),
            ("the sensor's half-angle in rad", self.half_angle_rad),
            ("the control period in s", self.period_s),
        ] {
            if !(found > 0.0 && found.is_finite()) {
                return refuse(name, found, "a number above 0");
            }
        }
        for (name, [least, most]) in [
            ("the greatest safe speed in m/s", self.limits_m_s),
            ("the greatest safe turning rate in rad/s", self.limits_rad_s),
        ] {
            if !(most > least && most.is_finite()) {
                return refuse(name, most, "more than the least");
            }
        }
        Axis::Speed.check_unit(self.limits_m_s[1])?;
        Axis::TurnRate.check_unit(self.limits_rad_s[1])?;
        Axis::Range.check_unit(self.range_m)?;
        Axis::HalfAngle.check_unit(self.half_angle_rad)?;
        Axis::Period.check_unit(self.period_s)?;
        if !(self.trial_sd >= 0.0 && self.trial_sd.is_finite()) {
            return refuse("the spread between trials", self.trial_sd, "0 or more");
        }
        if self.range_m <= 2.0 * self.radius_m {
            return refuse("the sensor's range in m", self.range_m, "more than two radii");
        }
        Ok(())
    }
}

/// Robots evenly spread over a fleet, the first among them.
fn spread_over(robots: &[String], n: usize) -> Vec<String> {
    let n = n.min(robots.len());
    (0..n).map(|position| robots[position * robots.len() / n].clone()).collect()
}

/// Evenly spaced commands within limits, both included.
fn levels([least, most]: [f64; 2], n: usize) -> Vec<f64> {
    if n == 1 {
        return vec![rounded(f64::midpoint(least, most))];
    }
    (0..n).map(|level| rounded(least + (most - least) * level as f64 / (n as f64 - 1.0))).collect()
}

/// From contact to a quarter beyond the expected range, about a body apart.
fn distances_m(request: &PlanRequest) -> Vec<f64> {
    let (nearest_m, farthest_m) = (2.0 * request.radius_m, 1.25 * request.range_m);
    let usual = ((farthest_m - nearest_m) / (1.5 * request.radius_m)).ceil() as usize + 1;
    levels([nearest_m, farthest_m], request.n_distances.unwrap_or(usual.clamp(5, 15)))
}

/// From the right to the left, half as far again as expected, the axis among them.
fn bearings_rad(request: &PlanRequest) -> Vec<f64> {
    let widest_rad = (1.5 * request.half_angle_rad).min(std::f64::consts::PI);
    levels([-widest_rad, widest_rad], request.n_bearings)
}

/// Three decimals are what a tape measure and a protractor give.
fn rounded(number: f64) -> f64 {
    (number * 1000.0).round() / 1000.0
}
