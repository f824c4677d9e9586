//! Whether robots do what they are commanded, looked at while they move.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use rsrs_core::judge::plausibility::{Implausible, Known, NOTED_S, implausible};
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;

/// From when on poses are held against commands: the shortest time that shows where a robot heads.
const FIRST_LOOK: Duration = Duration::from_secs(5);
/// How often that is done.
const LOOK_PERIOD: Duration = Duration::from_secs(1);
/// How far back, which is long enough to find whose commands a robot follows.
const MEMORY: Duration = Duration::from_secs(30);
/// Time between two samples of what is looked at.
const GRID: Duration = Duration::from_millis(100);
/// Poses that come faster than this are not kept.
const LEAST_APART: Duration = Duration::from_millis(40);
/// Commands of a robot that are kept, at most.
const MOST_COMMANDS: usize = 2000;
/// A robot without a pose for so long is not looked at until that is forgotten.
const MOST_GAP: Duration = Duration::from_secs(1);
/// A command holds for so long, or for 2.5 periods.
const LEAST_HELD: Duration = Duration::from_millis(300);
/// Robots that are looked at together: more take turns, because leases must not wait.
const AT_A_TIME: usize = 40;

/// What is known of the robots of a run, so that their poses can be held against their commands.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionCheck {
    /// Their control period, in seconds; positive.
    pub period_s: f64,
    /// Their bodies.
    pub bodies: Bodies,
    /// Distance of the arena's walls from the origin, in metres; `None` where there are none.
    pub walls_m: Option<f64>,
}

/// Poses and commands of the last half minute.
#[derive(Clone, Debug, Default)]
pub(super) struct Plausibility {
    check: Option<MotionCheck>,
    /// Names of the robots, in the order of the run.
    names: Vec<String>,
    robots: BTreeMap<String, Received>,
    looked: Option<Duration>,
    /// The robot with which the next look begins.
    next: usize,
    /// What was noted, of whom.
    noted: BTreeSet<(&'static str, usize)>,
}

#[derive(Clone, Debug, Default)]
struct Received {
    poses: VecDeque<(Duration, Pose)>,
    commands: VecDeque<(Duration, Command)>,
}

impl Plausibility {
    pub(super) fn new(check: Option<MotionCheck>, names: &[String]) -> Self {
        let robots = names.iter().map(|name| (name.clone(), Received::default()));
        Self { robots: robots.collect(), names: names.to_vec(), check, ..Self::default() }
    }

    pub(super) fn receive_pose(&mut self, robot: &str, pose: Pose, now: Duration) {
        let Some(received) = self.robots.get_mut(robot) else { return };
        let poses = &mut received.poses;
        if poses.back().is_none_or(|(last, _)| now.saturating_sub(*last) >= LEAST_APART) {
            poses.push_back((now, pose));
        }
        forget(poses, now);
    }

    pub(super) fn receive_command(&mut self, robot: &str, command: Command, now: Duration) {
        let Some(received) = self.robots.get_mut(robot) else { return };
        received.commands.push_back((now, command));
        if received.commands.len() > MOST_COMMANDS {
            received.commands.pop_front();
        }
        forget(&mut received.commands, now);
    }

    /// What is found now that was not noted before, in words, of robots that began to move at
    /// `since`; of lost ones nothing is expected any more.
    pub(super) fn look(
        &mut self,
        since: Duration,
        now: Duration,
        lost: &BTreeSet<&str>,
    ) -> Vec<String> {
        let Some(check) = self.check.clone() else { return Vec::new() };
        let passed = now.saturating_sub(since);
        let is_due = self.looked.is_none_or(|looked| now.saturating_sub(looked) >= LOOK_PERIOD);
        if passed.as_secs_f64() < NOTED_S || !is_due {
            return Vec::new();
        }
        self.looked = Some(now);
        let from = since.max(now.saturating_sub(MEMORY));
        let held = LEAST_HELD.max(Duration::from_secs_f64(2.5 * check.period_s));
        let mut trajectory = Trajectory::new(GRID.as_secs_f64(), self.names.len());
        let later = |time: &Duration| time.checked_add(GRID).filter(|later| *later <= now);
        let times: Vec<Duration> = std::iter::successors(Some(from), later).collect();
        let rows: Vec<_> =
            self.names.iter().map(|name| self.robots[name].at(&times, held)).collect();
        for sample in 0..times.len() {
            for (poses, commands) in &rows {
                trajectory.poses.push(poses.get(sample).copied().unwrap_or(FAR_AWAY));
                trajectory.commands.push(commands[sample]);
            }
        }
        let turn = self.whose_turn();
        let is_left_out = |row: &usize| {
            let is_seen = !rows[*row].0.is_empty();
            !is_seen || !turn.contains(row) || lost.contains(self.names[*row].as_str())
        };
        let left_out: Vec<usize> = (0..self.names.len()).filter(is_left_out).collect();
        let MotionCheck { bodies, walls_m, .. } = check;
        let known = Known { bodies, walls_m, left_out: &left_out, unseen: &[] };
        let found = implausible(&trajectory, &known, NOTED_S);
        // Less than 5 s show who stands, and little else.
        let is_ripe = |found: &Implausible| passed >= FIRST_LOOK || !found.cause.is_of_poses();
        found.into_iter().filter(is_ripe).filter_map(|found| self.note(found)).collect()
    }

    /// Rows that are looked at now.
    fn whose_turn(&mut self) -> BTreeSet<usize> {
        let n_robots = self.names.len();
        let n_now = n_robots.min(AT_A_TIME);
        let turn = (0..n_now).map(|place| (self.next + place) % n_robots).collect();
        self.next = (self.next + n_now) % n_robots.max(1);
        turn
    }

    /// What is found, of robots of which it was not noted before.
    fn note(&mut self, found: Implausible) -> Option<String> {
        let key = found.cause.key();
        let is_news = |robot: &usize| !self.noted.contains(&(key, *robot));
        let robots: Vec<usize> = found.robots.iter().copied().filter(is_news).collect();
        if robots.is_empty() {
            return None;
        }
        self.noted.extend(robots.iter().map(|robot| (key, *robot)));
        // Of robots that are exchanged each one is named with the others.
        let robots = if found.cause.is_of_several() { found.robots } else { robots };
        Some(Implausible { robots, ..found }.in_words(&self.names))
    }
}

/// Where a robot is that was not seen: in nobody's way.
const FAR_AWAY: Pose = Pose { x_m: 1e9, y_m: 1e9, heading_rad: 0.0 };

fn forget<T>(received: &mut VecDeque<(Duration, T)>, now: Duration) {
    while received.front().is_some_and(|(at, _)| now.saturating_sub(*at) > MEMORY + MOST_GAP) {
        received.pop_front();
    }
}

impl Received {
    /// Poses at these times, none if they are not known at all of them, and commands.
    fn at(&self, times: &[Duration], held: Duration) -> (Vec<Pose>, Vec<Command>) {
        let commands = times.iter().map(|time| self.command_at(*time, held)).collect();
        let (Some(first), Some(last)) = (times.first(), times.last()) else {
            return (Vec::new(), commands);
        };
        let within = self.poses.iter().map(|(at, _)| *at).filter(|at| at >= first && at <= last);
        let mut before = *first;
        let mut gap = Duration::ZERO;
        for at in within.chain([*last]) {
            gap = gap.max(at.saturating_sub(before));
            before = at;
        }
        if self.poses.is_empty() || gap > MOST_GAP {
            return (Vec::new(), commands);
        }
        (times.iter().map(|time| self.pose_at(*time)).collect(), commands)
    }

    fn command_at(&self, time: Duration, held: Duration) -> Command {
        let n_before = self.commands.partition_point(|(at, _)| *at <= time);
        match n_before.checked_sub(1).map(|last| self.commands[last]) {
            Some((at, command)) if time.saturating_sub(at) <= held => command,
            _ => Command::STOP,
        }
    }

    /// The pose between the two that are nearest.
    fn pose_at(&self, time: Duration) -> Pose {
        let after = self.poses.partition_point(|(at, _)| *at < time).min(self.poses.len() - 1);
        let ((from_at, from), (to_at, to)) =
            (self.poses[after.saturating_sub(1)], self.poses[after]);
        let step_s = to_at.saturating_sub(from_at).as_secs_f64();
        if step_s == 0.0 {
            return to;
        }
        from.between(to, (time.saturating_sub(from_at).as_secs_f64() / step_s).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(100);
    const START: Duration = Duration::from_secs(100);

    fn names() -> Vec<String> {
        (1..=3).map(|robot| format!("robot_{robot}")).collect()
    }

    /// Three robots that drive in circles, apart from each other, as commanded; what is noted when.
    fn notes(
        duration_s: u64,
        change: impl Fn(usize, Duration, Pose) -> Option<Pose>,
    ) -> Vec<(u64, String)> {
        let bodies = Bodies { radius_m: Some(0.075), reach_m: Some(0.8), ..Bodies::UNKNOWN };
        let check = MotionCheck { period_s: 0.1, bodies, walls_m: None };
        let mut plausibility = Plausibility::new(Some(check), &names());
        let command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.5 };
        let mut noted = Vec::new();
        for step in 0..duration_s * 10 {
            let passed = PERIOD * u32::try_from(step).expect("short");
            let now = START + passed;
            let angle_rad = 0.5 * passed.as_secs_f64();
            for (row, name) in names().iter().enumerate() {
                let (sine, cosine) = libm::sincos(angle_rad + row as f64);
                let pose = Pose {
                    x_m: 0.3 * sine + 2.0 * row as f64,
                    y_m: -0.3 * cosine,
                    heading_rad: angle_rad + row as f64,
                };
                plausibility.receive_command(name, command, now);
                if let Some(pose) = change(row, passed, pose) {
                    plausibility.receive_pose(name, pose, now);
                }
            }
            let lost = BTreeSet::from(["robot_3"]);
            let lost = if passed.as_secs() >= 50 { lost } else { BTreeSet::new() };
            let notes = plausibility.look(START, now, &lost);
            noted.extend(notes.into_iter().map(|note| (passed.as_secs(), note)));
        }
        noted
    }

    #[test]
    fn robots_that_do_as_they_are_commanded_are_not_mentioned() {
        assert_eq!(notes(60, |_, _, pose| Some(pose)), []);
    }

    #[test]
    fn millimetres_are_noted_once_after_5_seconds() {
        let notes = notes(60, |_, _, pose| {
            Some(Pose { x_m: 1000.0 * pose.x_m, y_m: 1000.0 * pose.y_m, ..pose })
        });

        let text = "all 3 robots: poses move 1,000 times too far: millimetres?".to_owned();
        assert_eq!(notes, [(5, text)]);
    }

    #[test]
    fn a_robot_that_stands_is_noted_after_3_seconds_and_once() {
        let notes = notes(60, |row, _, pose| {
            Some(if row == 1 { Pose { x_m: 2.0, y_m: 0.0, heading_rad: 0.0 } } else { pose })
        });

        let text = "robot_2 is commanded 0.15 m/s and has moved 0.00 m in 3 s".to_owned();
        assert_eq!(notes, [(3, text)]);
    }

    #[test]
    fn a_robot_that_was_lost_or_is_not_seen_is_not_asked_to_move() {
        let lost = notes(60, |row, passed, pose| {
            let stands = row == 2 && passed >= Duration::from_secs(50);
            Some(if stands { Pose { x_m: 4.0, y_m: 0.0, heading_rad: 0.0 } } else { pose })
        });
        let unseen = notes(45, |row, passed, pose| {
            let is_seen = row != 1 || passed < Duration::from_secs(10);
            is_seen.then_some(pose)
        });

        assert_eq!(lost, []);
        assert_eq!(unseen, []);
    }

    #[test]
    fn many_robots_take_turns() {
        let names: Vec<String> = (0..100).map(|robot| format!("robot_{robot}")).collect();
        let mut plausibility = Plausibility::new(None, &names);

        let turns: Vec<usize> = (0..5).flat_map(|_| plausibility.whose_turn()).collect();

        assert!((0..100).all(|row| turns.contains(&row)));
        assert_eq!(turns.len(), 5 * AT_A_TIME);
    }
}
