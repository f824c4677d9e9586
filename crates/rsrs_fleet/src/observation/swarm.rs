//! What the swarm does as a whole: its last minute, and the order parameters of it.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::behaviour::rule::Rules;
use rsrs_core::judge::order::{OrderParameters, Prerequisite};
use rsrs_core::judge::phase::{JudgedWindow, Phase};
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::judge::window::{WINDOW_S, samples_in};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;

use super::robot::{ObservedRobot, Seen};
use crate::timing::{NODE_TIMEOUT, POSE_TIMEOUT, Transport, command_timeout};

/// How often robots are looked at where their control period is unknown, in seconds.
const SOME_PERIOD_S: f64 = 0.1;
/// What is kept beyond the judge's window before it is given up at once, in seconds.
const SPARE_S: f64 = 10.0;
/// A longer time without samples begins a new trajectory; a viewer on a busy machine misses some.
const LONGEST_GAP: Duration = Duration::from_secs(3);

/// Order parameters, and the phase that they are those of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwarmOrder {
    /// The order parameters.
    pub evidence: OrderParameters,
    /// The phase by the judge's rules; over less than its window, the phase so far.
    pub phase: Phase,
    /// How much was looked at, in seconds: at most the window of the behaviour, and of one that asks whether
    /// something ever was, what there is now.
    pub over_s: f64,
    /// What the swarm is judged for.
    pub behaviour: Behaviour,
}

impl SwarmOrder {
    /// Whether the judge would look at as much.
    pub fn is_whole(&self) -> bool {
        self.over_s + 1e-9 >= self.behaviour.window().least_s()
    }
}

/// The order parameters of the last window of a trajectory's first `n_samples`, or of what there is
/// of it.
///
/// `None` for less than two samples of a robot, and where the behaviour looks at what is not known,
/// as at objects of which nobody publishes where they are: no phase follows from that.
pub fn order_of(
    trajectory: &Trajectory,
    n_samples: usize,
    bodies: &Bodies,
    behaviour: Behaviour,
) -> Option<SwarmOrder> {
    if trajectory.n_robots == 0 || n_samples < 2 {
        return None;
    }
    let rules = behaviour.rules();
    let asked = rules.asked();
    let window = rules.window.at_the_moment();
    let n_window = samples_in(window.least_s(), trajectory.period_s);
    let is_known = |evidence: &OrderParameters| asked.iter().all(|it| it.value(evidence).is_some());
    if n_samples < n_window {
        let evidence = OrderParameters::with(trajectory, 0..n_samples, bodies, &asked);
        if !is_known(&evidence) {
            return None;
        }
        let over_s = n_samples as f64 * trajectory.period_s;
        return Some(SwarmOrder { evidence, phase: rules.phase(&evidence), over_s, behaviour });
    }
    let rules = Rules { window, ..rules };
    let judged = JudgedWindow::new(trajectory, n_samples, bodies, &rules).remove(0);
    is_known(&judged.whole).then(|| SwarmOrder {
        evidence: judged.whole,
        phase: judged.phase,
        over_s: window.reaches_back_s().min(n_samples as f64 * trajectory.period_s),
        behaviour,
    })
}

/// The last minute of a swarm that moves, sampled as its poses come.
#[derive(Clone, Debug)]
pub(super) struct Swarm {
    trajectory: Trajectory,
    bodies: Bodies,
    behaviour: Behaviour,
    /// Simulated time, which passes faster or slower than wall-clock time.
    clock: Option<Seen<Duration>>,
    /// The time of the last sample: simulated where there is such a time.
    last: Option<Duration>,
}

impl Default for Swarm {
    fn default() -> Self {
        Self {
            trajectory: Trajectory::new(SOME_PERIOD_S, 0),
            bodies: Bodies::UNKNOWN,
            behaviour: Behaviour::default(),
            clock: None,
            last: None,
        }
    }
}

impl Swarm {
    pub(super) fn take_clock(&mut self, time: Duration, now: Duration) {
        self.clock = Some(Seen { value: time, at: now });
    }

    pub(super) fn set_conditions(&mut self, conditions: &Conditions) {
        self.bodies = conditions.bodies();
        self.behaviour = conditions.behaviour;
        if self.trajectory.period_s.to_bits() != conditions.period_s.to_bits() {
            self.trajectory.period_s = conditions.period_s;
            self.clear();
        }
    }

    pub(super) fn clear(&mut self) {
        self.trajectory = Trajectory::new(self.trajectory.period_s, 0);
        self.last = None;
    }

    /// Takes a sample if one is due; only while robots may move. Objects stand where they were seen
    /// last, in metres, unless they are pushed.
    pub(super) fn sample(
        &mut self,
        robots: &BTreeMap<Name, ObservedRobot>,
        objects_m: &BTreeMap<Name, [f64; 2]>,
        now: Duration,
    ) {
        let clock = self.clock.filter(|clock| clock.age(now) <= NODE_TIMEOUT);
        let time = clock.map_or(now, |clock| clock.value);
        let period = Duration::from_secs_f64(self.trajectory.period_s);
        let n_due = match self.last {
            None => 1,
            Some(last) if time < last || time.saturating_sub(last) > LONGEST_GAP => {
                self.clear();
                1
            }
            Some(last) => time.saturating_sub(last).as_nanos() / period.as_nanos().max(1),
        };
        if n_due == 0 {
            return;
        }
        let timeout = command_timeout(self.trajectory.period_s, Transport::Secured);
        let seen: Vec<_> = robots
            .values()
            .filter_map(|robot| {
                let pose = robot.pose(now).filter(|pose| pose.age(now) <= POSE_TIMEOUT)?.value;
                let fresh = robot.command.filter(|command| command.age(now) <= timeout);
                Some((pose, fresh.map_or(Command::STOP, |command| command.value)))
            })
            .collect();
        // Some of the objects say nothing of all.
        let are_all = objects_m.len() == self.bodies.world.n_objects();
        let n_objects = if are_all { objects_m.len() } else { 0 };
        let counts = (seen.len(), n_objects);
        if counts != (self.trajectory.n_robots, self.trajectory.n_objects) {
            self.clear();
            (self.trajectory.n_robots, self.trajectory.n_objects) = counts;
        }
        // What was missed is held, so that time does not shrink.
        for _ in 0..n_due {
            self.trajectory.poses.extend(seen.iter().map(|(pose, _)| *pose));
            self.trajectory.commands.extend(seen.iter().map(|(_, command)| *command));
            self.trajectory.objects_m.extend(objects_m.values().take(n_objects));
        }
        let last = self.last.map_or(time, |last| last + period * u32::try_from(n_due).unwrap_or(1));
        self.last = Some(last);
        self.forget();
    }

    /// Gives up what is older than the judge looks back.
    fn forget(&mut self) {
        let kept_s = self.behaviour.window().at_the_moment().reaches_back_s();
        if kept_s.is_infinite() {
            return;
        }
        let Trajectory { period_s, n_robots, n_objects, poses, commands, objects_m } =
            &mut self.trajectory;
        let most = samples_in(kept_s.max(WINDOW_S) + SPARE_S, *period_s) * *n_robots;
        if poses.len() > most {
            let n_old = samples_in(SPARE_S, *period_s);
            poses.drain(..n_old * *n_robots);
            commands.drain(..n_old * *n_robots);
            objects_m.drain(..n_old * *n_objects);
        }
    }

    pub(super) fn trail(&self, over_s: f64) -> &[Pose] {
        let Trajectory { period_s, n_robots, poses, .. } = &self.trajectory;
        let n_poses = samples_in(over_s, *period_s) * n_robots;
        &poses[poses.len().saturating_sub(n_poses)..]
    }

    pub(super) fn lacks(&self, n_objects: usize) -> bool {
        n_objects != self.bodies.world.n_objects()
            && self.behaviour.rules().asked().iter().any(|it| it.needs(Prerequisite::Objects))
    }

    pub(super) fn order(&self) -> Option<SwarmOrder> {
        order_of(&self.trajectory, self.trajectory.n_samples(), &self.bodies, self.behaviour)
    }
}

/// The name of a robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Name(String);

impl Name {
    pub(super) fn new(name: String) -> Self {
        Self(name)
    }

    pub(super) fn as_str(&self) -> &str {
        &self.0
    }

    /// What comes before the number at its end, and the number.
    fn parts(&self) -> (&str, Option<u64>) {
        let letters = self.0.trim_end_matches(|sign: char| sign.is_ascii_digit());
        (letters, self.0[letters.len()..].parse().ok())
    }
}

impl Ord for Name {
    fn cmp(&self, other: &Self) -> Ordering {
        self.parts().cmp(&other.parts()).then_with(|| self.0.cmp(&other.0))
    }
}

impl PartialOrd for Name {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_are_in_the_order_of_their_numbers() {
        let mut names = ["robot_10", "robot_9", "base", "robot_2", "robot_02", "anna"]
            .map(|name| Name::new(name.to_owned()));

        names.sort();

        let names = names.each_ref().map(Name::as_str);
        assert_eq!(names, ["anna", "base", "robot_02", "robot_2", "robot_9", "robot_10"]);
    }
}
