//! What a swarm did: the poses and commands of every robot over time, as a bag can contain them.

use serde::{Deserialize, Serialize};

use crate::robot::controller::Command;
use crate::robot::unicycle::Pose;
use crate::world::WorldFile;

/// Poses and commands of `n_robots` robots, sampled once per control period.
///
/// Sample `k` holds the pose that was sensed in period `k` and the command that answered it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// Control period `Δt` between samples, in seconds; positive.
    pub period_s: f64,
    /// Number of robots.
    pub n_robots: usize,
    /// Poses, sample by sample, robot by robot; shape `[n_samples * n_robots]`.
    pub poses: Vec<Pose>,
    /// Commands, in the order of `poses`; shape `[n_samples * n_robots]`.
    pub commands: Vec<Command>,
    /// Number of objects of which it is known where they were.
    pub n_objects: usize,
    /// Where they were, in metres, sample by sample, object by object; shape `[n_samples * n_objects][2]`.
    pub objects_m: Vec<[f64; 2]>,
}

/// What the judge needs of the robots and their arena besides their trajectory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bodies {
    /// Radius of one robot's body, in metres; unknown for many a foreign bag.
    pub radius_m: Option<f64>,
    /// Reach: how far from a robot's centre the centre of another can be seen, in metres; unknown
    /// for many a foreign bag.
    ///
    /// Where bodies are seen this is more than the sensor's range: see
    /// [`Region::reach_m`](crate::robot::region::Region::reach_m).
    pub reach_m: Option<f64>,
    /// Side of the square arena around the origin that walls enclose, in metres; `None` where there is none,
    /// or none is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arena_m: Option<f64>,
    /// What is there besides the robots.
    #[serde(default, skip_serializing_if = "WorldFile::is_empty")]
    pub world: WorldFile,
    /// The class of each robot, by place among those of the world; shape `[n_robots]`, or empty where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub classes: Vec<usize>,
}

impl Bodies {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self {
        radius_m: None,
        reach_m: None,
        arena_m: None,
        world: WorldFile::NOTHING,
        classes: Vec::new(),
    };
}

impl Trajectory {
    /// An empty trajectory to be filled sample by sample.
    pub fn new(period_s: f64, n_robots: usize) -> Self {
        Self {
            period_s,
            n_robots,
            poses: Vec::new(),
            commands: Vec::new(),
            n_objects: 0,
            objects_m: Vec::new(),
        }
    }

    /// Poses of which nobody knows what was commanded: all commands are to stand still.
    ///
    /// `poses` has shape `[n_samples * n_robots]`, sample by sample.
    pub fn of_poses(period_s: f64, n_robots: usize, poses: Vec<Pose>) -> Self {
        let commands = vec![Command::STOP; poses.len()];
        Self { poses, commands, ..Self::new(period_s, n_robots) }
    }

    /// Number of samples in time.
    pub fn n_samples(&self) -> usize {
        self.poses.len().checked_div(self.n_robots).unwrap_or(0)
    }

    /// Recorded time, in seconds: one period for each sample.
    pub fn duration_s(&self) -> f64 {
        self.n_samples() as f64 * self.period_s
    }

    /// Poses of all robots in one sample; shape `[n_robots]`.
    pub fn poses_at(&self, sample: usize) -> &[Pose] {
        &self.poses[sample * self.n_robots..(sample + 1) * self.n_robots]
    }

    /// Where all known objects were in one sample, in metres; shape `[n_objects][2]`.
    pub fn objects_at(&self, sample: usize) -> &[[f64; 2]] {
        &self.objects_m[sample * self.n_objects..(sample + 1) * self.n_objects]
    }

    /// Commands of all robots in one sample; shape `[n_robots]`.
    pub fn commands_at(&self, sample: usize) -> &[Command] {
        &self.commands[sample * self.n_robots..(sample + 1) * self.n_robots]
    }
}
