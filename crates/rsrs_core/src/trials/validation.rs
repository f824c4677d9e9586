//! Step 2 of the method: do the real trajectories lie in the reachable set of the simulated ones?
//!
//! This holds what the answer consists of and its statistics; `rsrs_sim::reach` simulates.

use serde::Serialize;

use crate::robot::controller::Command;
use crate::statistics::interval::Interval;

/// The answer for all trials.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Validation {
    /// Share of the simulated robots that each region holds, e.g. 0.99.
    pub share: f64,
    /// Whether the trials are compatible with robots that the simulator can be: `p_value` is at
    /// least [`LEVEL`].
    pub is_contained: bool,
    /// Probability that as many simulated trials leave their regions as real ones did.
    pub p_value: f64,
    /// Trials that were held against the simulator.
    pub n_trials: usize,
    /// Trials that were inside at every horizon.
    pub n_inside: usize,
    /// Share of such trials, with its exact interval.
    pub coverage: Interval,
    /// Every robot.
    pub robots: Vec<RobotCoverage>,
    /// Every kind of drive.
    pub tubes: Vec<Tube>,
    /// Every trial, those outside with where they left.
    pub trials: Vec<TrialPlace>,
}

/// How many trials of one robot were inside at every horizon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotCoverage {
    /// The robot.
    pub robot: String,
    /// Its trials.
    pub n_trials: usize,
    /// Those that were inside at every horizon.
    pub n_inside: usize,
    /// Share of such trials, with its exact interval.
    pub coverage: Interval,
}

/// The simulated reach under one sequence of commands.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tube {
    /// The command; `None` if it changed during the drive.
    pub command: Option<Command>,
    /// Whether it is that of the object which the robot of the only trial under these commands is to push.
    #[serde(skip_serializing_if = "is_of_robot")]
    pub of_object: bool,
    /// Longest trial, in seconds.
    pub duration_s: f64,
    /// The region at each time, ascending.
    pub horizons: Vec<Horizon>,
}

/// The simulated region at one time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Horizon {
    /// Time since the start, in seconds.
    pub time_s: f64,
    /// Area of the region of positions, in square metres, tolerance included. An area that is large
    /// for the distance driven means that containment is weak evidence.
    pub area_m2: f64,
    /// Mean simulated displacement in the frame of the start, in metres: ahead, left.
    pub mean_m: [f64; 2],
    /// Least and greatest heading change, in radians, tolerance included.
    pub heading_rad: [f64; 2],
    /// Trials that lasted so long.
    pub n_trials: usize,
    /// Those inside at this time.
    pub n_inside: usize,
    /// Share of such trials, with its exact interval.
    pub coverage: Interval,
    /// The region of positions, for pictures.
    #[serde(skip)]
    pub region: RegionOutline,
}

/// A region by its outline, in the frame of the start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RegionOutline {
    /// Closed loops of vertices on the region's border, in metres: ahead, left. The region is to the
    /// left of each: outer loops are counterclockwise, holes clockwise.
    pub loops_m: Vec<Vec<[f64; 2]>>,
}

/// Where one trial was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialPlace {
    /// The robot.
    pub robot: String,
    /// The trial.
    pub trial: String,
    /// Position of its tube.
    pub tube: usize,
    /// The times at which the robot was outside; none for a trial inside.
    pub exits: Vec<Exit>,
    /// The object that it is to push; `None` if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<ObjectPlace>,
}

/// Where the object of one trial was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectPlace {
    /// Position of its tube.
    pub tube: usize,
    /// The times at which it was outside.
    pub exits: Vec<Exit>,
}

impl TrialPlace {
    /// Whether the robot, and its object if it has one, were inside at every horizon.
    pub fn is_inside(&self) -> bool {
        self.exits.is_empty() && self.object.as_ref().is_none_or(|object| object.exits.is_empty())
    }

    /// The times at which the robot or its object was outside a tube; `None` if it is that of another kind.
    pub fn exits_of(&self, tube: usize) -> Option<&[Exit]> {
        if self.tube == tube {
            return Some(&self.exits);
        }
        self.object.as_ref().filter(|object| object.tube == tube).map(|object| &*object.exits)
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_of_robot(of_object: &bool) -> bool {
    !of_object
}

/// A trial outside the simulated region at one time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Exit {
    /// Time since the start, in seconds.
    pub time_s: f64,
    /// Whether the position was outside.
    pub by_position: bool,
    /// Whether the heading was outside.
    pub by_heading: bool,
    /// How far it was from the mean simulated position along the mean simulated heading, in metres;
    /// ahead is positive.
    pub ahead_m: f64,
    /// How far it was beside it, in metres; left is positive.
    pub left_m: f64,
    /// How much more it had turned than the mean simulated robot, in radians; counterclockwise is
    /// positive.
    pub turned_rad: f64,
}

/// How often robots within the simulated population are refused.
pub const LEVEL: f64 = 0.05;

/// Probability that independent robots together leave their regions in `n_outside` trials or more.
///
/// Trials of one robot are not independent: a fast robot is fast in all of them. So each robot
/// brings the distribution of how many of its own trials would be outside, from 0 on, and only
/// robots are multiplied. Shape `[n_robots][n_trials + 1]`, each summing to 1.
///
/// # Example
///
/// Two robots with one trial each, of which 1 in 100 would be outside: both, 1 in 10,000.
///
/// ```
/// use rsrs_core::trials::validation::at_least_outside;
///
/// let robot = vec![0.99, 0.01];
/// assert!((at_least_outside(&[robot.clone(), robot], 2) - 0.0001).abs() < 1e-12);
/// ```
pub fn at_least_outside(robots: &[Vec<f64>], n_outside: usize) -> f64 {
    let mut total = vec![1.0];
    for robot in robots {
        let mut longer = vec![0.0; total.len() + robot.len() - 1];
        for (before, probability) in total.iter().enumerate() {
            for (own, share) in robot.iter().enumerate() {
                longer[before + own] += probability * share;
            }
        }
        total = longer;
    }
    total.iter().skip(n_outside).sum::<f64>().min(1.0)
}

impl Validation {
    /// Trials that were outside at some time, in order.
    pub fn outside(&self) -> impl Iterator<Item = &TrialPlace> {
        self.trials.iter().filter(|trial| !trial.is_inside())
    }
}
