//! The judge of [`rsrs_core::judge::order`] and [`rsrs_core::judge::phase`] at work on the lanes.

use std::ops::Range;

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::behaviour::rule::Rules;
use rsrs_core::judge::number::{Mask, Number};
use rsrs_core::judge::order::{Commanded, Samples, Vector, look_back};
use rsrs_core::judge::phase::JudgedWindow;
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::judge::window::{BLOCK_S, samples_in};
use rsrs_core::robot::controller::{Command, ControllerParameters, decide};
use rsrs_core::robot::unicycle::Pose;

use super::rows::Rows;
use super::sense::Body;
use crate::vector::simd::{Simd, Work};

/// The swarms' past, as far as it is kept, with what the judge needs besides.
#[derive(Clone, Copy)]
pub struct Past<'a, S: Simd> {
    pub simd: S,
    pub rows: &'a Rows<S::F>,
    pub commands: &'a Commands,
    pub bodies: &'a Bodies,
}

/// What all robots of all worlds are commanded, as they have the same controller.
///
/// Of a turn only the amount matters to the judge, so a controller whose two commands mirror each other
/// commands the same at all times; of any other it matters what each robot detected.
pub struct Commands {
    controller: ControllerParameters,
    period_s: f64,
    n_robots: usize,
    /// In windows of so many samples.
    windows: [(usize, Commanded); 2],
    /// Whether it matters to the judge which of its two commands a robot was given.
    pub vary: bool,
    /// The speeds of both commands, in metres per second.
    speeds_m_s: [f64; 2],
    /// Over how many samples a robot's way is held against its commands, and the speeds in them,
    /// added up.
    looks: (usize, f64),
}

impl Commands {
    /// Adds up what a controller commands in the judge's window, which has so many samples, and in one of its
    /// blocks.
    pub fn new(conditions: &Conditions, n_window: usize) -> Self {
        let Conditions { period_s, robots: n_robots, .. } = *conditions;
        let controller = conditions.controller.parameters().expect("the lanes have two commands");
        let command = decide(false, controller);
        let in_window = |n| (n, Commanded::new(|_, _| command, period_s, 0..n, n_robots));
        let n_looks = look_back(period_s);
        let speeds_m_s = (0..n_looks).map(|_| command.speed_m_s).sum();
        let n_block = samples_in(BLOCK_S, period_s).min(n_window);
        let windows = [n_window, n_block].map(in_window);
        let looks = (n_looks, speeds_m_s);
        let amounts = |command: Command| (command.speed_m_s, command.turn_rate_rad_s.abs());
        let commands = controller.commands();
        let vary = amounts(commands[0]) != amounts(commands[1]);
        let speeds_m_s = commands.map(|command| command.speed_m_s);
        Self { controller, period_s, n_robots, windows, vary, speeds_m_s, looks }
    }

    /// Whether these are the commands under such conditions, in a window of so many samples.
    pub fn are_of(&self, conditions: &Conditions, n_window: usize) -> bool {
        let of = (conditions.controller.parameters(), conditions.period_s, conditions.robots);
        let is_same = of == (Some(self.controller), self.period_s, self.n_robots);
        is_same && self.windows[0].0 == n_window
    }
}

/// Half of the worlds in double precision: the lower or the upper lanes.
struct Half<'a, S: Simd, const HALF: usize>(Past<'a, S>);

impl<S: Simd, const HALF: usize> Samples for Half<'_, S, HALF> {
    type Number = S::D;
    type Pose = Body<S::F>;

    #[inline(always)]
    fn zero(&self) -> S::D {
        self.half(self.0.simd.single(0.0))
    }
    #[inline(always)]
    fn period_s(&self) -> f64 {
        self.0.commands.period_s
    }
    #[inline(always)]
    fn poses_at(&self, sample: usize) -> &[Body<S::F>] {
        self.0.rows.at(sample as u64)
    }
    #[inline(always)]
    fn place(&self, body: &Body<S::F>) -> Vector<S::D> {
        (self.half(body.x_m), self.half(body.y_m))
    }
    /// The length of what is simulated is 1 but for roundings in single precision, so one step of
    /// Newton's method finds its inverse.
    #[inline(always)]
    fn heading(&self, body: &Body<S::F>) -> (Vector<S::D>, S::D) {
        let (cosine, sine) = (self.half(body.cosine), self.half(body.sine));
        let square = cosine * cosine + sine * sine;
        ((cosine, sine), square.all(1.5) - square.all(0.5) * square)
    }
    fn commanded(&self, window: Range<usize>, lane: usize) -> Commanded {
        let commands = self.0.commands;
        if commands.vary {
            let command = |sample, robot| self.command(window.start + sample, robot, lane);
            return Commanded::new(command, commands.period_s, 0..window.len(), commands.n_robots);
        }
        let is_asked = |(n_samples, _): &&(usize, Commanded)| *n_samples == window.len();
        self.0.commands.windows.iter().find(is_asked).expect("a window or a block").1
    }
    #[inline(always)]
    fn speeds_m_s(&self, samples: Range<usize>, robot: usize) -> S::D {
        let Past { simd, rows, commands, .. } = self.0;
        let zero = self.zero();
        let (n_samples, speeds_m_s) = commands.looks;
        debug_assert_eq!(samples.len(), n_samples);
        if !commands.vary {
            return zero.all(speeds_m_s);
        }
        let [detected, undetected] = commands.speeds_m_s.map(|speed_m_s| zero.all(speed_m_s));
        let (one, none) = (simd.single(1.0), simd.single(0.0));
        let mut sum = zero;
        for sample in samples {
            let flags = S::F::select(rows.detected(sample as u64, robot), one, none);
            let is_detected = self.half(flags).gt(zero);
            sum = sum + S::D::select(is_detected, detected, undetected);
        }
        sum
    }
    fn trajectory(&self, lane: usize, samples: Range<usize>) -> Option<Trajectory> {
        let rows = self.0.rows;
        let mut trajectory = Trajectory::new(self.period_s(), self.0.commands.n_robots);
        for sample in samples {
            for (robot, body) in rows.at(sample as u64).iter().enumerate() {
                let number = |number: S::F| f64::from(number.lane(HALF * S::LANES / 2 + lane));
                let heading_rad = libm::atan2(number(body.sine), number(body.cosine));
                let pose = Pose { x_m: number(body.x_m), y_m: number(body.y_m), heading_rad };
                trajectory.poses.push(pose);
                trajectory.commands.push(self.command(sample, robot, lane));
            }
        }
        Some(trajectory)
    }
}

impl<S: Simd, const HALF: usize> Half<'_, S, HALF> {
    /// This half of the lanes in double precision. The compiler leaves a closure of the same as a call.
    #[inline(always)]
    fn half(&self, numbers: S::F) -> S::D {
        self.0.simd.half::<HALF>(numbers)
    }

    /// What a robot was commanded in one lane.
    fn command(&self, sample: usize, robot: usize, lane: usize) -> Command {
        let Past { rows, commands, .. } = self.0;
        let is_detected = commands.vary && {
            let lane = HALF * S::LANES / 2 + lane;
            rows.detected(sample as u64, robot).bits() >> lane & 1 == 1
        };
        decide(is_detected, commands.controller)
    }
}

/// Looks at what decides on runs of so many samples.
pub struct LookAtEnd<'a, S: Simd> {
    pub past: Past<'a, S>,
    pub n_samples: usize,
    /// By which they are judged.
    pub rules: &'a Rules,
    /// Lanes that matter, from the first one on.
    pub n_lanes: usize,
}

impl<S: Simd> Work for LookAtEnd<'_, S> {
    type Output = Vec<JudgedWindow>;

    #[inline(always)]
    fn run(self) -> Vec<JudgedWindow> {
        let Self { past, n_samples, rules, n_lanes } = self;
        let bodies = past.bodies;
        let mut windows = JudgedWindow::new(&Half::<S, 0>(past), n_samples, bodies, rules);
        if n_lanes > S::LANES / 2 {
            windows.extend(JudgedWindow::new(&Half::<S, 1>(past), n_samples, bodies, rules));
        }
        windows.truncate(n_lanes);
        windows
    }
}
