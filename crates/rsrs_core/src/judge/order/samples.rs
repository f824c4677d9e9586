//! What order parameters are measured on: poses and commands over time.

use std::ops::Range;

use super::geometry::Vector;
use crate::judge::number::Number;
use crate::judge::trajectory::Trajectory;
use crate::robot::controller::Command;
use crate::robot::unicycle::Pose;

/// Poses and commands over time, of one world or of several.
pub trait Samples {
    /// A number of each world.
    type Number: Number<Scalar = f64>;
    /// The pose of one robot in each world.
    type Pose;

    /// Any number: others are made from it.
    fn zero(&self) -> Self::Number;
    /// Control period, in seconds.
    fn period_s(&self) -> f64;
    /// All robots in one sample; shape `[n_robots]`.
    fn poses_at(&self, sample: usize) -> &[Self::Pose];
    /// Where a robot is, in metres.
    fn place(&self, pose: &Self::Pose) -> Vector<Self::Number>;
    /// A vector along its heading, and one over its length.
    fn heading(&self, pose: &Self::Pose) -> (Vector<Self::Number>, Self::Number);
    /// What was commanded in a window of one lane: [`Commanded::new`].
    fn commanded(&self, window: Range<usize>, lane: usize) -> Commanded;
    /// Commanded speeds of a robot, added up over samples.
    fn speeds_m_s(&self, samples: Range<usize>, robot: usize) -> Self::Number;
    /// How many objects there are of which it is known where they are; none in lanes.
    fn n_objects(&self) -> usize {
        0
    }
    /// Where they are in one sample, in metres; shape `[n_objects][2]`.
    fn objects_at(&self, _: usize) -> &[[f64; 2]] {
        &[]
    }
    /// One lane by itself, where headings are vectors that were never angles; `None` for what is a
    /// trajectory already.
    fn trajectory(&self, lane: usize, samples: Range<usize>) -> Option<Trajectory>;
}

impl Samples for Trajectory {
    type Number = f64;
    type Pose = Pose;

    fn zero(&self) -> f64 {
        0.0
    }
    fn period_s(&self) -> f64 {
        self.period_s
    }
    fn poses_at(&self, sample: usize) -> &[Pose] {
        self.poses_at(sample)
    }
    fn place(&self, pose: &Pose) -> (f64, f64) {
        (pose.x_m, pose.y_m)
    }
    fn heading(&self, pose: &Pose) -> ((f64, f64), f64) {
        let (sine, cosine) = libm::sincos(pose.heading_rad);
        ((cosine, sine), 1.0)
    }
    fn commanded(&self, window: Range<usize>, _: usize) -> Commanded {
        let command = |sample, robot| self.commands_at(sample)[robot];
        Commanded::new(command, self.period_s, window, self.n_robots)
    }
    fn speeds_m_s(&self, samples: Range<usize>, robot: usize) -> f64 {
        samples.map(|sample| self.commands_at(sample)[robot].speed_m_s).sum()
    }
    fn n_objects(&self) -> usize {
        self.n_objects
    }
    fn objects_at(&self, sample: usize) -> &[[f64; 2]] {
        self.objects_at(sample)
    }
    fn trajectory(&self, _: usize, _: Range<usize>) -> Option<Self> {
        None
    }
}

/// What was commanded in a window.
#[derive(Clone, Copy, Debug)]
pub struct Commanded {
    /// How far all robots were to drive, forward less backward, in metres.
    pub way_m: f64,
    /// Mean turn in one period, in radians.
    pub mean_turn_rad: f64,
}

impl Commanded {
    /// Adds up what was commanded, by sample and robot, in a window.
    pub fn new(
        command: impl Fn(usize, usize) -> Command,
        period_s: f64,
        window: Range<usize>,
        n_robots: usize,
    ) -> Self {
        let mut ways_m = vec![0.0; n_robots];
        let mut turn_rates_rad_s = 0.0;
        for sample in window.clone() {
            for (robot, way_m) in ways_m.iter_mut().enumerate() {
                let Command { speed_m_s, turn_rate_rad_s } = command(sample, robot);
                turn_rates_rad_s += turn_rate_rad_s.abs();
                // The last command is carried out after the last sample.
                *way_m += if sample + 1 < window.end { speed_m_s * period_s } else { 0.0 };
            }
        }
        Self {
            way_m: ways_m.iter().map(|way_m: &f64| way_m.abs()).sum(),
            mean_turn_rad: turn_rates_rad_s * period_s / (window.len() * n_robots) as f64,
        }
    }
}
