//! The conditions of one experiment: everything that the outcome may depend on, the paper's `E`.

mod check;
pub mod controller_table;
mod error;
mod flockbots;
pub mod limits;
pub mod operator;
mod own_robots;
mod resolve;
mod robot_number;
mod sensors;
mod settings;
pub mod start_file;
mod starts;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::digest::Digest;
use crate::judge::behaviour::Behaviour;
use crate::judge::trajectory::Bodies;
use crate::numerals::is_zero;
use crate::robot::contact::ContactModel;
use crate::robot::controller::Controller;
use crate::robot::region::Region;
use crate::robot::sensor::{Sees, SensorDetails};
use crate::robot::unicycle::Pose;
use crate::world::{FreeSpace, Outline, ROUNDING, WorldFile};

pub use check::Impossible;
pub use error::ConditionsError;
pub use resolve::{ARENA_M, PLACEMENT_OVER_RANGE};
pub(crate) use robot_number::ROBOT_NUMBERS;
pub use sensors::SimulatedSensor;
pub use settings::{ClassChanges, Settings, check_axis};
pub use starts::StartsError;

/// All aspects of a world, resolved to numbers: the paper's `E`.
///
/// # Source
///
/// "Lumping all aspects of the simulator into a variable `E`", before `eq:finalgap`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// Number of robots `N`.
    pub robots: usize,
    /// What every robot's controller is set to.
    pub controller: Controller,
    /// What the swarm is judged for; milling where a file does not name it.
    #[serde(default, skip_serializing_if = "Behaviour::is_usual")]
    pub behaviour: Behaviour,
    /// Where the robots start.
    pub placement: Placement,
    /// Where they may go.
    pub arena: Arena,
    /// What is there besides them.
    #[serde(default, skip_serializing_if = "WorldFile::is_empty")]
    pub world: WorldFile,
    /// What the robots are.
    pub robot: SimulatedRobot,
    /// Robots that are not like the others, by their place among all, from 0: those with a profile of
    /// their own.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub own_robots: BTreeMap<usize, SimulatedRobot>,
    /// Control period `Δt`, in seconds.
    pub period_s: f64,
}

/// Where the robots start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Placement {
    /// Uniform in a disc, facing away from its centre, as in §IV step 3.
    DiscFacingOut {
        /// Radius of the disc, in metres.
        radius_m: f64,
    },
    /// Uniform in a box around the origin, facing away from its centre.
    BoxFacingOut(Sides),
    /// Uniform in a box around the origin, heading anywhere.
    BoxFacingAnyWay(Sides),
    /// Where a table puts them: replicate k takes set k, and after the last one the first again.
    Given {
        /// Shape `[n_sets][n_robots]`.
        starts: Vec<Vec<Pose>>,
    },
    /// One robot at the origin, heading along x, and at most one other beside it, facing away: a
    /// detection trial of §IV step 1.
    Pair {
        /// Distance of the two centres, in metres.
        distance_m: f64,
        /// Bearing of the other from the first, in radians; left is positive.
        bearing_rad: f64,
    },
}

/// The sides of a box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Sides {
    /// Along x, in metres.
    pub width_m: f64,
    /// Along y, in metres.
    pub height_m: f64,
}

impl Placement {
    /// Radius of the disc about the origin that holds every centre, in metres.
    pub fn radius_m(&self) -> f64 {
        match self {
            Self::DiscFacingOut { radius_m } => *radius_m,
            Self::BoxFacingOut(Sides { width_m, height_m })
            | Self::BoxFacingAnyWay(Sides { width_m, height_m }) => {
                libm::hypot(*width_m, *height_m) / 2.0
            }
            Self::Given { starts } => {
                let poses = starts.iter().flatten();
                poses.map(|pose| libm::hypot(pose.x_m, pose.y_m)).fold(0.0, f64::max)
            }
            Self::Pair { distance_m, .. } => *distance_m,
        }
    }
}

/// A square arena around the origin, unless the world has one of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arena {
    /// Side of the square, in metres; of the one that holds all of the world's own arena.
    pub side_m: f64,
    /// What happens at its border, and at obstacles.
    pub walls: Walls,
}

impl Arena {
    /// Distance of the walls of a square arena from the origin, in metres; `None` where there are none.
    pub fn walls_m(&self) -> Option<f64> {
        (self.walls != Walls::None).then_some(self.side_m / 2.0)
    }
}

/// What happens at the arena's border, and at obstacles.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Walls {
    /// There is no border.
    None,
    /// A robot slides along it.
    Clamp,
    /// A robot that would cross it stays where it is.
    #[default]
    Stop,
}

/// A robot as the world moves it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulatedRobot {
    /// Radius of the body, in metres.
    pub radius_m: f64,
    /// Front sector of contact, in radians.
    pub front_half_angle_rad: f64,
    /// Whether a blocked robot still turns.
    pub rotates_while_blocked: bool,
    /// What it and its neighbours do when their bodies touch.
    #[serde(default, skip_serializing_if = "ContactModel::is_usual")]
    pub contact: ContactModel,
    /// Coulomb's coefficient of the friction between bodies that push, and along walls; dimensionless.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub contact_friction: f64,
    /// Gain of the speed, `θᵃ₁`.
    pub speed_gain: GainDistribution,
    /// Gain of the turning rate, `θᵃ₂`.
    pub turn_gain: GainDistribution,
    /// Standard deviation between robots of a constant turning-rate bias, in radians per second.
    pub turn_bias_sd_rad_s: f64,
    /// Standard deviation of the heading's random change per step, in radians.
    pub heading_noise_sd_rad: f64,
    /// Standard deviation of the velocity disturbance on each axis, in metres per second.
    pub gust_sd_m_s: f64,
    /// Its correlation time, in seconds.
    pub gust_time_constant_s: f64,
    /// Time constant of the turning rate, in seconds; 0 is at once.
    pub yaw_lag_s: f64,
    /// What of a neighbour must lie in the region, or touch it.
    pub sees: Sees,
    /// Where a neighbour is detected.
    pub region: Region,
    /// Probability of a detection when a neighbour is in the region.
    pub true_positive: f64,
    /// Probability of a detection when none is.
    pub false_positive: f64,
    /// Steps by which a detection arrives late.
    pub latency_steps: u32,
    /// What else its first sensor, to which all above belongs, tells.
    #[serde(default, skip_serializing_if = "SensorDetails::is_plain")]
    pub details: SensorDetails,
    /// Its other sensors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub further_sensors: Vec<SimulatedSensor>,
}

/// How a gain varies: normal, truncated at three standard deviations; dimensionless.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainDistribution {
    /// Mean over robots at the commanded value.
    pub mean: f64,
    /// Standard deviation between robots.
    pub robot_sd: f64,
    /// Standard deviation from step to step.
    pub step_sd: f64,
}

/// The longest run, in seconds: a week. What is longer is a slip, and would fill memory or disk.
pub const MOST_DURATION_S: f64 = 604_800.0;

impl Conditions {
    /// Names these conditions: equal digests mean equal worlds. The duration is not part of it, so
    /// that a longer run passes through the states of a shorter one.
    pub fn digest(&self) -> u64 {
        let mut digest = Digest::new("conditions");
        let text = serde_json::to_string(self).expect("conditions are plain data");
        digest.text(&text);
        digest.value()
    }

    /// Steps of a run: `floor(duration / Δt)`.
    pub fn steps(&self, duration_s: f64) -> u64 {
        // A duration that is a whole number of periods may fall short of it by a rounding error.
        (duration_s / self.period_s + 1e-9).floor() as u64
    }

    /// Where bodies may be, in an arena that is no square or that obstacles stand in; `None` for a plain square, which
    /// [`Self::arena`] has. Whatever simulates asks here which of the two it is.
    pub fn free_space(&self) -> Option<FreeSpace> {
        self.world.free_space(self.arena.side_m)
    }

    /// Corners of the border, and of each obstacle, by which the walls of an arena that is no plain square are drawn, in
    /// metres; empty where there are no such walls. Shape `[n_outlines][n_corners][2]`.
    pub fn walls_drawn_m(&self) -> Vec<Vec<[f64; 2]>> {
        let space = self.free_space().filter(|_| self.arena.walls != Walls::None);
        let outlines = |space: &FreeSpace| {
            std::iter::once(space.border()).chain(space.obstacles()).map(Outline::drawn_m).collect()
        };
        space.as_ref().map(outlines).unwrap_or_default()
    }

    /// Whether a body at a place in metres is within the walls, which there may be none of.
    pub fn is_within_walls(&self, place_m: [f64; 2], radius_m: f64) -> bool {
        if self.arena.walls == Walls::None {
            return true;
        }
        match self.free_space() {
            None => {
                let most_m = (self.arena.side_m / 2.0 - radius_m) * (1.0 + ROUNDING);
                place_m.iter().all(|at_m| at_m.abs() <= most_m)
            }
            Some(space) => space.clearance_m(place_m) >= radius_m - space.slack_m(),
        }
    }

    /// Properties of the robots and their arena that the judge needs.
    pub fn bodies(&self) -> Bodies {
        Bodies {
            radius_m: Some(self.robot.radius_m),
            reach_m: Some(self.robot.reach_m()),
            arena_m: self.arena.walls_m().map(|walls_m| 2.0 * walls_m),
            world: self.world.clone(),
            classes: self.world.classes_of(self.robots),
        }
    }
}
