//! How one robot moved, and how it was commanded to.

use std::f64::consts::{PI, TAU};

use super::{MOST_LAG_S, Unseen};
use crate::judge::trajectory::{Bodies, Trajectory};
use crate::robot::controller::Command;
use crate::robot::unicycle::Pose;
use crate::statistics::median;
use crate::world::FreeSpace;

/// Ways are looked at over this time, in seconds.
const WINDOW_S: f64 = 1.0;

/// Headings are averaged over this time, in seconds: markers 10 cm apart make them 0.1 rad wrong.
const SMOOTHED_S: f64 = 0.4;

/// Bodies touch within so many radii and so many metres of each other's centre: tracked by 1 cm.
const TOUCH_RADII: f64 = 2.2;
const TOUCH_M: f64 = 0.03;
/// Robots of unknown size touch within this, in metres.
const UNKNOWN_TOUCH_M: f64 = 0.30;

/// What is beside a robot blocks it: up to 100° off its way, as headings are not exact. Dimensionless.
const BESIDE: f64 = 0.17;

/// A way that was commanded to be shorter than this, in metres, is not looked at.
const MIN_WAY_M: f64 = 0.02;

/// A robot that went so far drove, in metres: below is noise ...
const MIN_DRIVEN_M: f64 = 0.03;
/// ... and this share of what was commanded: else it may be pushed.
const MIN_DRIVEN: f64 = 0.5;
/// And no more than this share: else a gust carries it.
const MOST_DRIVEN: f64 = 2.0;

/// What may be in a robot's way.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    pub bodies: &'a Bodies,
    pub walls_m: Option<f64>,
    /// Where bodies may be, of an arena that is no plain square.
    pub space: Option<&'a FreeSpace>,
}

/// One robot's poses and commands, with what follows from them.
pub struct Motion {
    /// Control period, in seconds.
    pub period_s: f64,
    pub poses: Vec<Pose>,
    pub commands: Vec<Command>,
    /// Its heading without jumps, averaged over a moment, in radians.
    pub turned_rad: Vec<f64>,
    /// How far it was commanded to turn until then, averaged alike, in radians.
    pub to_turn_rad: Vec<f64>,
    /// Whether another robot, an object or a wall is so near that it may be pushed or blocked, or it was not seen.
    pub touches: Vec<bool>,
    /// Whether one is so near where it is commanded to drive.
    pub is_blocked: Vec<bool>,
}

impl Motion {
    pub fn new(row: usize, trajectory: &Trajectory, around: Surroundings) -> Self {
        let samples = 0..trajectory.n_samples();
        let poses: Vec<Pose> = samples.clone().map(|at| trajectory.poses_at(at)[row]).collect();
        let commands: Vec<Command> =
            samples.clone().map(|at| trajectory.commands_at(at)[row]).collect();
        let period_s = trajectory.period_s;
        let n_smoothed = whole(SMOOTHED_S / period_s).max(1);
        let near = samples.map(|at| {
            let speed_m_s = trajectory.commands_at(at)[row].speed_m_s;
            let (touches, is_blocked) = near(row, trajectory.poses_at(at), speed_m_s, around);
            let pushes = pushes(trajectory.poses_at(at)[row], trajectory.objects_at(at), around);
            (touches || pushes, is_blocked || pushes)
        });
        let (touches, is_blocked) = near.unzip();
        Self {
            period_s,
            turned_rad: smoothed(&unwrapped(&poses), n_smoothed),
            to_turn_rad: smoothed(&summed(&commands, period_s), n_smoothed),
            poses,
            commands,
            touches,
            is_blocked,
        }
    }

    /// The same, in which what the robot did while it was not seen is no evidence.
    pub fn without(mut self, row: usize, unseen: &[Unseen]) -> Self {
        for Unseen { from_s, to_s, .. } in unseen.iter().filter(|unseen| unseen.row == row) {
            let last = self.len().saturating_sub(1);
            let first = whole(from_s.max(0.0) / self.period_s).min(last);
            let end = whole((to_s.max(0.0) + SMOOTHED_S) / self.period_s).clamp(first, last);
            self.touches[first..=end].fill(true);
            self.is_blocked[first..=end].fill(true);
        }
        self
    }

    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Samples in a time, at least one.
    pub fn samples_in(&self, time_s: f64) -> usize {
        whole(time_s / self.period_s).max(1)
    }

    /// Whether it touched something at some time from one sample to another.
    pub fn has_touched(&self, start: usize, end: usize) -> bool {
        self.touches[start..=end].iter().any(|touches| *touches)
    }

    /// Share of the samples from one to another in which something was in its way.
    pub fn blocked_share(&self, start: usize, end: usize) -> f64 {
        let samples = &self.is_blocked[start..=end];
        samples.iter().filter(|is_blocked| **is_blocked).count() as f64 / samples.len() as f64
    }

    /// Places relative to the start that commands lead to, from one sample to another, in metres, for a
    /// robot that heads along x at first.
    pub fn commanded_places(&self, start: usize, end: usize) -> Vec<(f64, f64)> {
        let (mut x_m, mut y_m, mut heading_rad) = (0.0, 0.0, 0.0);
        let mut places = vec![(x_m, y_m)];
        for command in &self.commands[start..end] {
            let turn_rad = command.turn_rate_rad_s * self.period_s;
            let (sine, cosine) = libm::sincos(heading_rad + turn_rad / 2.0);
            x_m += command.speed_m_s * self.period_s * cosine;
            y_m += command.speed_m_s * self.period_s * sine;
            heading_rad += turn_rad;
            places.push((x_m, y_m));
        }
        places
    }

    /// Extent of its places along both axes, without the outermost 5 % at each end, in metres.
    pub fn extents_m(&self) -> [f64; 2] {
        let extent_m = |number: fn(&Pose) -> f64| {
            let mut numbers: Vec<f64> = self.poses.iter().map(number).collect();
            numbers.sort_by(f64::total_cmp);
            let at = |share: f64| numbers[whole(share * (numbers.len() - 1) as f64)];
            at(0.95) - at(0.05)
        };
        [extent_m(|pose| pose.x_m), extent_m(|pose| pose.y_m)]
    }
}

/// Whether another robot or a wall is within touch, and whether one is where the robot is to drive.
///
/// One that stands is touched from behind by those that come after it, which excuses nobody. A robot that
/// is to turn on the spot may be held by anything.
fn near(row: usize, poses: &[Pose], speed_m_s: f64, around: Surroundings) -> (bool, bool) {
    let Surroundings { bodies, walls_m, space } = around;
    let touch_m =
        bodies.radius_m.map_or(UNKNOWN_TOUCH_M, |radius_m| TOUCH_RADII * radius_m + TOUCH_M);
    let own = poses[row];
    let (sine, cosine) = libm::sincos(own.heading_rad);
    let (mut touches, mut is_blocked) = (false, false);
    for (other, pose) in poses.iter().enumerate() {
        let (x_m, y_m) = (pose.x_m - own.x_m, pose.y_m - own.y_m);
        let distance_m2 = x_m * x_m + y_m * y_m;
        if other == row || distance_m2 >= touch_m * touch_m {
            continue;
        }
        touches = true;
        let ahead_m = (x_m * cosine + y_m * sine) * if speed_m_s < 0.0 { -1.0 } else { 1.0 };
        is_blocked |= speed_m_s == 0.0 || ahead_m > -BESIDE * distance_m2.sqrt();
    }
    let at_wall = walls_m.is_some_and(|walls_m| {
        let near_m = touch_m / 2.0 + TOUCH_M;
        match space {
            None => own.x_m.abs().max(own.y_m.abs()) > walls_m - near_m,
            Some(space) => space.clearance_m([own.x_m, own.y_m]) < near_m,
        }
    });
    (touches || at_wall, is_blocked || at_wall)
}

/// Whether a robot is beside an object, which may hold it back; where nobody knows where objects are, it may be.
fn pushes(own: Pose, objects_m: &[[f64; 2]], around: Surroundings) -> bool {
    let Surroundings { bodies, .. } = around;
    if objects_m.len() != bodies.world.n_objects() {
        return true;
    }
    let robot_m = bodies.radius_m.unwrap_or(UNKNOWN_TOUCH_M / 2.0);
    bodies.world.each_object().zip(objects_m).any(|(object, [x_m, y_m])| {
        let touch_m = TOUCH_RADII / 2.0 * (robot_m + object.radius_m) + TOUCH_M;
        libm::hypot(x_m - own.x_m, y_m - own.y_m) < touch_m
    })
}

/// Headings without jumps, in radians.
fn unwrapped(poses: &[Pose]) -> Vec<f64> {
    let mut headings_rad = Vec::with_capacity(poses.len());
    let mut last_rad: Option<f64> = None;
    for pose in poses {
        let heading_rad = match last_rad {
            None => pose.heading_rad,
            Some(last_rad) => last_rad + libm::remainder(pose.heading_rad - last_rad, TAU),
        };
        headings_rad.push(heading_rad);
        last_rad = Some(heading_rad);
    }
    headings_rad
}

/// Turns that were commanded until each sample, in radians.
fn summed(commands: &[Command], period_s: f64) -> Vec<f64> {
    let mut sum_rad = 0.0;
    let mut sums_rad = Vec::with_capacity(commands.len());
    for command in commands {
        sums_rad.push(sum_rad);
        sum_rad += command.turn_rate_rad_s * period_s;
    }
    sums_rad
}

/// Means over so many samples, of which the first ones have fewer.
fn smoothed(numbers: &[f64], n_samples: usize) -> Vec<f64> {
    let mut sum = 0.0;
    let mut means = Vec::with_capacity(numbers.len());
    for (at, number) in numbers.iter().enumerate() {
        sum += number;
        if at >= n_samples {
            sum -= numbers[at - n_samples];
        }
        means.push(sum / n_samples.min(at + 1) as f64);
    }
    means
}

/// How concentrated angles are: 0 is any angle, 1 always the same.
#[derive(Clone, Copy, Debug, Default)]
pub struct Angles {
    pub concentration: f64,
    /// Their mean, in radians.
    pub mean_rad: f64,
}

impl Angles {
    fn new(angles_rad: impl Iterator<Item = f64>) -> Self {
        let (mut cosines, mut sines, mut n) = (0.0, 0.0, 0.0);
        for angle_rad in angles_rad {
            let (sine, cosine) = libm::sincos(angle_rad);
            (cosines, sines, n) = (cosines + cosine, sines + sine, n + 1.0);
        }
        let concentration = if n > 0.0 { libm::hypot(cosines, sines) / n } else { 0.0 };
        Self { concentration, mean_rad: libm::atan2(sines, cosines) }
    }

    /// The same of angles that count alike half a turn apart.
    fn axial(angles_rad: impl Iterator<Item = f64>) -> Self {
        let doubled = Self::new(angles_rad.map(|angle_rad| 2.0 * angle_rad));
        Self { mean_rad: doubled.mean_rad / 2.0, ..doubled }
    }
}

/// Medians over windows, in metres.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_field_names, reason = "names end in units")]
pub struct Distances {
    /// How far it went, straight from start to end.
    pub moved_m: f64,
    /// How far commands lead, straight from start to end.
    pub commanded_m: f64,
    /// How far they lead along the way, to and fro.
    pub along_m: f64,
}

/// How far a robot went, and whether it went where it headed, in windows that overlap by half.
#[derive(Debug, Default)]
pub struct Way {
    /// How far it went in windows; `None` where it was hardly commanded to go.
    pub distances: Option<Distances>,
    /// Windows in which it drove by itself.
    pub n_driven: usize,
    /// In those: where it went against where it headed.
    pub against_heading: Angles,
    /// Where it went and where it headed, added: constant if one of them is mirrored; half a turn apart
    /// is alike.
    pub mirrored: Angles,
    /// Where it headed, likewise.
    pub heading: Angles,
    /// Where it went, likewise.
    pub direction: Angles,
    /// Where it headed in all windows, likewise.
    pub all_headings: Angles,
}

impl Way {
    pub fn new(motion: &Motion) -> Self {
        let n_window = motion.samples_in(WINDOW_S);
        let n_lag = motion.samples_in(MOST_LAG_S);
        let (mut moved_m, mut commanded_m, mut along_m) = (Vec::new(), Vec::new(), Vec::new());
        // Direction of the way, and heading.
        let mut driven: Vec<(f64, f64)> = Vec::new();
        let mut headings_rad = Vec::new();
        for start in (0..motion.len().saturating_sub(n_window)).step_by(n_window.div_ceil(2)) {
            let end = start + n_window;
            let (from, to) = (motion.poses[start], motion.poses[end]);
            let (x_m, y_m) = (to.x_m - from.x_m, to.y_m - from.y_m);
            let way_m = libm::hypot(x_m, y_m);
            let places = motion.commanded_places(start, end);
            let (to_x_m, to_y_m) = places[places.len() - 1];
            let to_go_m = libm::hypot(to_x_m, to_y_m);
            let window = &motion.poses[start..=end];
            headings_rad.extend(window.iter().map(|pose| pose.heading_rad));
            if to_go_m < MIN_WAY_M {
                continue;
            }
            moved_m.push(way_m);
            commanded_m.push(to_go_m);
            let speeds = motion.commands[start..end].iter().map(|command| command.speed_m_s.abs());
            along_m.push(speeds.sum::<f64>() * motion.period_s);
            let drove =
                way_m >= MIN_DRIVEN_M.max(MIN_DRIVEN * to_go_m) && way_m <= MOST_DRIVEN * to_go_m;
            // To and fro within a window, a robot may go anywhere against its heading.
            let commands =
                &motion.commands[start.saturating_sub(n_lag)..motion.len().min(end + n_lag)];
            let Some(back_rad) = reversed_rad(commands) else { continue };
            if drove && !motion.has_touched(start, end) {
                let heading = Angles::new(window.iter().map(|pose| pose.heading_rad));
                driven.push((libm::atan2(y_m, x_m) + back_rad, heading.mean_rad));
            }
        }
        let against_heading = Angles::new(driven.iter().map(|(way, heading)| way - heading));
        Self {
            distances: (moved_m.len() >= 4).then(|| Distances {
                moved_m: median(moved_m),
                commanded_m: median(commanded_m),
                along_m: median(along_m),
            }),
            n_driven: driven.len(),
            against_heading,
            mirrored: Angles::axial(driven.iter().map(|(way, heading)| way + heading)),
            heading: Angles::axial(driven.iter().map(|(_, heading)| *heading)),
            all_headings: Angles::axial(headings_rad.into_iter()),
            direction: Angles::axial(driven.iter().map(|(way, _)| *way)),
        }
    }

    /// How much where it went has to do with where it headed, from 0 to 1.
    pub fn together(&self) -> f64 {
        self.against_heading.concentration
    }
}

/// By how much the way is turned against the heading: half a turn for a robot that is commanded
/// backward; `None` for one that is commanded to and fro.
fn reversed_rad(commands: &[Command]) -> Option<f64> {
    let speeds_m_s = || commands.iter().map(|command| command.speed_m_s);
    if speeds_m_s().all(|speed_m_s| speed_m_s >= 0.0) {
        return Some(0.0);
    }
    speeds_m_s().all(|speed_m_s| speed_m_s <= 0.0).then_some(PI)
}

/// The whole number nearest to one that is not negative.
pub fn whole(number: f64) -> usize {
    number.round() as usize
}
