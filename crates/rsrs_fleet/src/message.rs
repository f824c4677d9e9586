//! The messages between nodes, free of any wire format.

use std::collections::BTreeMap;
use std::time::Duration;

pub use rsrs_msgs::rsrs::{LeaseState, RobotState, StopCause};

use crate::timing::LEASE_DURATION;

/// The runner's permission to move, repeated twenty times a second.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lease {
    /// The run that it belongs to.
    pub run_id: String,
    /// Rises with every run; a robot never obeys an epoch lower than one it has received.
    pub epoch: u64,
    /// What the robots may do.
    pub state: LeaseState,
    /// Digest of the controller parameters that the runner confirmed.
    pub parameter_digest: u64,
    /// Robots of the run, each with the counter of the last status the runner received from it. Many
    /// robots take several leases ([`Lease::split`]), each of which is for those alone that it names.
    pub robots: Vec<Echo>,
}

/// The largest lease in a message, in bytes: with the headers of all layers, signatures included, it
/// is one datagram of an ordinary network. Of a larger one each fragment would have to arrive.
pub const MOST_LEASE_BYTES: usize = 1_300;

/// One robot's place in a lease.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Echo {
    /// The robot.
    pub robot: String,
    /// Counter of its last status that the runner received; 0 if none.
    pub counter: u64,
}

impl Lease {
    /// The echo for one robot, if it is part of the run.
    pub fn echo(&self, robot: &str) -> Option<u64> {
        self.robots.iter().find(|echo| echo.robot == robot).map(|echo| echo.counter)
    }

    /// The lease of each of these robots, with nothing in it of the others, and `None` for one that it
    /// does not name: a program that hosts hundreds of them looks each up once, and copies no names of
    /// others.
    pub fn of_each<'a>(&self, robots: impl IntoIterator<Item = &'a str>) -> Vec<Option<Self>> {
        let mut echoes: BTreeMap<&str, &Echo> = BTreeMap::new();
        for echo in &self.robots {
            echoes.entry(&echo.robot).or_insert(echo);
        }
        let of_one = |robot| echoes.get(robot).map(|echo| self.with_only(echo));
        robots.into_iter().map(of_one).collect()
    }

    /// The same for one of its robots alone.
    #[must_use]
    pub fn with_only(&self, echo: &Echo) -> Self {
        Self { run_id: self.run_id.clone(), robots: vec![echo.clone()], ..*self }
    }

    /// The same in as many leases as it takes for none to be larger than [`MOST_LEASE_BYTES`]; each
    /// has one robot at least.
    pub fn split(mut self) -> Vec<Self> {
        let room = MOST_LEASE_BYTES.saturating_sub(fixed_bytes(&self.run_id));
        let (mut parts, mut part, mut taken) = (Vec::new(), Vec::new(), 0);
        for echo in std::mem::take(&mut self.robots) {
            let bytes = echo_bytes(&echo);
            if taken + bytes > room && taken > 0 {
                parts.push(std::mem::take(&mut part));
                taken = 0;
            }
            taken += bytes;
            part.push(echo);
        }
        parts.push(part);
        parts
            .into_iter()
            .map(|robots| Self { run_id: self.run_id.clone(), robots, ..self })
            .collect()
    }
}

/// What a lease without robots takes in a message at most: numbers, lengths and what aligns them.
fn fixed_bytes(run_id: &str) -> usize {
    88 + run_id.len()
}

/// What a robot takes in a lease at most: its counter, its name with length and end, and alignment.
fn echo_bytes(echo: &Echo) -> usize {
    16 + echo.robot.len()
}

/// The status of a robot, or of its controller: twenty times a second and on change.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// Rises with every status sent, over restarts too, because a process that starts begins above
    /// all that it ever counted; the lease echoes it.
    pub counter: u64,
    /// The epoch obeyed; 0 is none. From the simulator: the number of its world, from 1.
    pub epoch: u64,
    /// The run that it belongs to; empty for none.
    pub run_id: String,
    /// Digest of its controller's parameters; 0 is unknown.
    pub parameter_digest: u64,
    /// What it does.
    pub state: RobotState,
    /// Why it stands: what others decide by.
    pub stop_cause: StopCause,
    /// The cause in words, for people only; empty while it may move.
    pub stop_reason: String,
    /// Battery voltage; not a number if unknown.
    pub battery_v: f32,
}

/// The e-stop as the reason of a stop, in words.
pub const E_STOP_REASON: &str = "e-stop";

/// Another runner at work, in words.
pub(crate) const OTHER_RUNNER: &str = "another runner is active";

/// The reason of a robot or controller whose run has not started, in words.
pub fn armed_reason(run_id: &str) -> String {
    format!("armed for run {run_id}, waiting for the start")
}

impl Status {
    /// The run for whose start it waits; `None` if it does not wait.
    pub fn armed_for(&self) -> Option<&str> {
        let is_waiting = self.state == RobotState::Armed && !self.run_id.is_empty();
        is_waiting.then_some(self.run_id.as_str())
    }

    /// Whether it is newer than the newest status of its sender so far, of which `last` has the
    /// counter and when it was received.
    ///
    /// A lower counter is that of a message that was late, or came again. Who was silent for as
    /// long as a lease lasts may contain anything: no lease echoes it, so that nothing in it keeps
    /// a robot moving (of its controller, a robot asks more), and one whose clock was set back before it
    /// started would not be received otherwise.
    pub fn is_news(&self, last: Option<(u64, Duration)>, now: Duration) -> bool {
        last.is_none_or(|(counter, at)| {
            self.counter > counter || now.saturating_sub(at) > LEASE_DURATION
        })
    }

    /// Whether this robot may move in its epoch, now or later: one that has lost its lease or its
    /// controller before it moved may receive the start yet, which is on its way.
    pub fn may_yet_move(&self) -> bool {
        match self.state {
            RobotState::Armed | RobotState::Moving => true,
            RobotState::Stopped => {
                matches!(self.stop_cause, StopCause::Lease | StopCause::Controller)
            }
            RobotState::Idle | RobotState::Fault => false,
        }
    }

    /// Whether it is a robot of a simulator without a world.
    pub fn is_without_world(&self) -> bool {
        self.stop_cause == StopCause::NoWorld
    }

    /// Whether this robot has received the e-stop and is locked by it.
    pub fn holds_e_stop(&self) -> bool {
        self.stop_cause == StopCause::EStop
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The first status of a robot that belongs to no run.
    pub(crate) fn status(state: RobotState, stop_cause: StopCause) -> Status {
        Status {
            counter: 1,
            epoch: 0,
            run_id: String::new(),
            parameter_digest: 0,
            state,
            stop_cause,
            stop_reason: String::new(),
            battery_v: f32::NAN,
        }
    }

    #[test]
    fn the_lease_of_each_robot_has_its_own_echo_and_no_other() {
        let echo = |robot: &str, counter| Echo { robot: robot.to_owned(), counter };
        let lease = Lease {
            run_id: "run".to_owned(),
            epoch: 3,
            state: LeaseState::Running,
            parameter_digest: 7,
            robots: vec![echo("a", 1), echo("b", 2), echo("a", 9)],
        };

        let of_each = lease.of_each(["b", "a", "c"]);

        let echoes: Vec<_> = of_each
            .iter()
            .flatten()
            .map(|one| (&one.robots[..], one.echo(&one.robots[0].robot)))
            .collect();
        assert_eq!(echoes, [(&lease.robots[1..2], Some(2)), (&lease.robots[..1], Some(1))]);
        assert_eq!(of_each[2], None);
        for one in of_each.into_iter().flatten() {
            assert_eq!(Lease { robots: lease.robots.clone(), ..one }, lease);
        }
    }

    #[test]
    fn a_large_fleet_takes_several_leases_that_name_each_robot_once() {
        let robots = (0..300).map(|robot| Echo { robot: format!("robot_{robot}"), counter: robot });
        let lease = Lease {
            run_id: "milling_20261122T102030_045Z_00000000000000ab".to_owned(),
            epoch: 3,
            state: LeaseState::Running,
            parameter_digest: 7,
            robots: robots.collect(),
        };

        let parts = lease.clone().split();
        let small = Lease { robots: lease.robots[..9].to_vec(), ..lease.clone() };

        assert_eq!(
            parts.iter().flat_map(|part| part.robots.clone()).collect::<Vec<_>>(),
            lease.robots
        );
        assert!(parts.len() > 4 && parts.iter().all(|part| part.run_id == lease.run_id));
        assert_eq!(small.clone().split(), [small]);
    }

    /// One that was late has not moved: the start may still be on its way to it.
    #[test]
    fn a_robot_that_lost_its_lease_before_it_moved_does_not_stand_for_good() {
        let may_yet_move = |stop_cause| status(RobotState::Stopped, stop_cause).may_yet_move();

        assert!(may_yet_move(StopCause::Lease) && may_yet_move(StopCause::Controller));
        for latched in [StopCause::Latched, StopCause::EStop, StopCause::NotArmed] {
            assert!(!may_yet_move(latched), "{latched:?}");
        }
    }
}
