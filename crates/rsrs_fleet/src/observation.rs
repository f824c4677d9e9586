//! What is received of a fleet, for people who watch it: live or out of a bag.
//!
//! An [`Observation`] takes what was decoded, each with the time at which it came, and answers with
//! what a person wants on one screen: the newest of everything, how old it is, how often it comes,
//! and which phase the swarm is in. It publishes nothing and decides nothing.

mod playback;
mod robot;
mod swarm;

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use rsrs_core::conditions::Conditions;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;

use crate::e_stop::{Locks, Message, Source};
use crate::message::{Echo, Lease, LeaseState, Status};
use crate::record::{Ending, ExperimentRecord};
use crate::stopper::MOST_ROBOTS;
use crate::timing::NODE_TIMEOUT;
use crate::wire::Diagnosis;
use rsrs_core::robot::pose_source::PoseSource;

pub use playback::{Playback, RecordedSwarm};
pub use robot::{Condition, LeaseView, ObservedRobot, Rate, Seen};
use swarm::{Name, Swarm};
pub use swarm::{SwarmOrder, order_of};

/// Something that was received.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// There is a robot of this name, or there should be.
    Found {
        /// The robot.
        robot: String,
    },
    /// A reading of a robot's sensor.
    Detection {
        /// The robot.
        robot: String,
        /// Whether it sees another one.
        detected: bool,
    },
    /// A reading of a further sensor of a robot.
    Reading {
        /// The robot.
        robot: String,
        /// Its name.
        reading: String,
        /// Whether it is true.
        is_true: bool,
    },
    /// A robot's velocity command.
    Command {
        /// The robot.
        robot: String,
        /// The command.
        command: Command,
    },
    /// Where a robot is.
    Pose {
        /// The robot.
        robot: String,
        /// By whom.
        source: PoseSource,
        /// There.
        pose: Pose,
    },
    /// Where an object is.
    Object {
        /// The object.
        object: String,
        /// There, in metres.
        place_m: [f64; 2],
    },
    /// The status of a robot.
    Status {
        /// The robot.
        robot: String,
        /// Its status.
        status: Status,
    },
    /// The runner's permission to move.
    Lease(Lease),
    /// A message on one of the e-stop's topics.
    EStop(Message),
    /// What parts of robots say of themselves.
    Diagnoses(Vec<Diagnosis>),
    /// Simulated time.
    Clock(Duration),
    /// The record of a run.
    Experiment(Box<ExperimentRecord>),
    /// How a run ended.
    Ending {
        /// The run.
        run_id: String,
        /// Its ending.
        ending: Ending,
    },
}

impl Event {
    /// Whether it matters however long ago it came: until something else is received, or because a
    /// run began with it.
    pub fn is_lasting(&self) -> bool {
        match self {
            Self::Found { .. }
            | Self::Lease(_)
            | Self::EStop(_)
            | Self::Experiment(_)
            | Self::Ending { .. } => true,
            Self::Detection { .. }
            | Self::Reading { .. }
            | Self::Command { .. }
            | Self::Pose { .. }
            | Self::Object { .. }
            | Self::Status { .. }
            | Self::Diagnoses(_)
            | Self::Clock(_) => false,
        }
    }
}

/// What is known of a fleet.
#[derive(Clone, Debug, Default)]
pub struct Observation {
    freshness: Freshness,
    robots: BTreeMap<Name, ObservedRobot>,
    /// Where objects were seen last, in metres.
    objects_m: BTreeMap<Name, [f64; 2]>,
    lease: Option<Seen<Lease>>,
    /// When the run of the lease was seen to run first.
    running_since: Option<Seen<String>>,
    /// By source: what it published last.
    engaged: BTreeMap<Source, Seen<bool>>,
    /// By who reports them.
    locks: BTreeMap<Source, Locks>,
    experiment: Option<Box<ExperimentRecord>>,
    ending: Option<(String, Ending)>,
    swarm: Swarm,
}

/// How long a status or a lease counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Freshness {
    /// As long as nodes of the protocol wait for the next one.
    #[default]
    ForNodeTimeout,
    /// Until the next one.
    UntilTheNext,
}

impl Freshness {
    fn lasts(self, age: Duration) -> bool {
        match self {
            Self::ForNodeTimeout => age <= NODE_TIMEOUT,
            Self::UntilTheNext => true,
        }
    }
}

/// Where a run is.
#[derive(Clone, Debug, PartialEq)]
pub struct RunView<'a> {
    /// Its name.
    pub run_id: &'a str,
    /// What its newest lease lets robots do.
    pub state: LeaseState,
    /// Whether leases still come.
    pub is_fresh: bool,
    /// How long robots have been permitted to move; `None` before.
    pub running_for: Option<Duration>,
    /// How it ended, if that was published.
    pub ending: Option<&'a Ending>,
}

impl Observation {
    /// Of a recorded run in lockstep. Its times are simulated and its nodes published their statuses
    /// by the wall clock, some simulated seconds apart, so that silence cannot be seen.
    fn of_lockstep() -> Self {
        Self { freshness: Freshness::UntilTheNext, ..Self::default() }
    }

    /// Takes what was received at a time that is not before that of an earlier event.
    pub fn on_event(&mut self, event: Event, now: Duration) {
        match event {
            Event::Found { robot } => {
                self.robot_mut(robot);
            }
            Event::Detection { robot, detected } => {
                if let Some(robot) = self.robot_mut(robot) {
                    robot.detection = Some(Seen { value: detected, at: now });
                    robot.detection_rate.received(now);
                }
            }
            Event::Reading { robot, reading, is_true } => {
                if let Some(robot) = self.robot_mut(robot) {
                    robot.take_reading(reading, is_true, now);
                }
            }
            Event::Command { robot, command } => {
                if let Some(robot) = self.robot_mut(robot) {
                    robot.command = Some(Seen { value: command, at: now });
                    robot.command_rate.received(now);
                }
            }
            Event::Pose { robot, source, .. } if self.is_passed_over(&robot, source, now) => {
                self.robot_mut(robot);
            }
            Event::Pose { robot, source, pose } => {
                if let Some(robot) = self.robot_mut(robot) {
                    robot.take_pose(source, pose, now);
                }
            }
            Event::Object { object, place_m } => {
                let object = Name::new(object);
                if self.objects_m.contains_key(&object) || self.objects_m.len() < MOST_ROBOTS {
                    self.objects_m.insert(object, place_m);
                }
            }
            Event::Status { robot, status } => {
                if let Some(robot) = self.robot_mut(robot) {
                    robot.take_status(status, now);
                }
            }
            Event::Lease(lease) => self.take_lease(lease, now),
            Event::EStop(Message::State { source, engaged }) => {
                if self.engaged.contains_key(&source) || self.engaged.len() < MOST_ROBOTS {
                    self.engaged.insert(source, Seen { value: engaged, at: now });
                }
            }
            Event::EStop(Message::Locks { reporter, locks }) => {
                if self.locks.contains_key(&reporter) || self.locks.len() < MOST_ROBOTS {
                    self.locks.insert(reporter, locks);
                }
            }
            Event::EStop(Message::Release(_)) => {}
            Event::Diagnoses(diagnoses) => {
                for diagnosis in diagnoses {
                    let mut robots = self.robots.iter_mut();
                    let of_it = robots.find(|(name, _)| diagnosis.is_of(name.as_str()));
                    if let Some((_, robot)) = of_it {
                        robot.take_diagnosis(diagnosis, now);
                    }
                }
            }
            Event::Clock(time) => self.swarm.take_clock(time, now),
            Event::Experiment(record) => {
                self.swarm.set_conditions(&record.conditions);
                self.experiment = Some(record);
            }
            Event::Ending { run_id, ending } => self.ending = Some((run_id, ending)),
        }
        if self.is_running(now) {
            self.swarm.sample(&self.robots, &self.objects_m, now);
        }
    }

    /// All robots, `robot_2` before `robot_10`.
    pub fn robots(&self) -> impl ExactSizeIterator<Item = (&str, &ObservedRobot)> {
        self.robots.iter().map(|(name, robot)| (name.as_str(), robot))
    }

    /// Where objects were seen last, in metres.
    pub fn objects_m(&self) -> impl Iterator<Item = [f64; 2]> {
        self.objects_m.values().copied()
    }

    /// What robots say is wrong with them: robot, part and message.
    pub fn faults(&self, now: Duration) -> impl Iterator<Item = (&str, &str, &str)> {
        self.robots().flat_map(move |(name, robot)| {
            robot.faults(now).map(move |(part, message)| (name, part, message))
        })
    }

    /// How many robots there are.
    pub fn n_robots(&self) -> usize {
        self.robots.len()
    }

    /// Where the newest run is; `None` before any lease.
    pub fn run(&self, now: Duration) -> Option<RunView<'_>> {
        let lease = self.lease.as_ref()?;
        let run_id = lease.value.run_id.as_str();
        let since = self.running_since.as_ref().filter(|since| since.value == run_id);
        let ended = self.ending.as_ref().filter(|(of, _)| of == run_id);
        // The clock of a run stops with its last lease that let robots move.
        let until = if self.is_running(now) { now } else { lease.at };
        Some(RunView {
            run_id,
            state: lease.value.state,
            is_fresh: self.freshness.lasts(lease.age(now)),
            running_for: since.map(|since| until.saturating_sub(since.at)),
            ending: ended.map(|(_, ending)| ending),
        })
    }

    /// The lease from a robot's point of view.
    pub fn lease_of(&self, robot: &ObservedRobot, now: Duration) -> LeaseView {
        let lasts = |age| self.freshness.lasts(age);
        let Some(Seen { value: lease, .. }) =
            robot.lease.as_ref().filter(|lease| lasts(lease.age(now)))
        else {
            let some_lease = self.lease.as_ref().filter(|lease| lasts(lease.age(now)));
            return some_lease.map_or(LeaseView::None, |_| LeaseView::NotNamed);
        };
        match &robot.status {
            Some(status) if status.value.epoch == lease.epoch => LeaseView::Holds(lease.state),
            _ => LeaseView::OtherEpoch,
        }
    }

    /// How long the run is set to last; `None` without its record.
    pub fn duration_s(&self) -> Option<f64> {
        let run_id = &self.lease.as_ref()?.value.run_id;
        let record = self.experiment.as_ref().filter(|record| record.run_id == *run_id)?;
        Some(record.duration_s)
    }

    /// Under which conditions the newest run is; `None` without its record.
    pub fn conditions(&self) -> Option<&Conditions> {
        self.experiment.as_ref().map(|record| &record.conditions)
    }

    /// Sources that hold the e-stop now, as far as robots or they themselves report it.
    pub fn e_stop(&self) -> BTreeSet<Source> {
        let locked = self.locks.values().flat_map(|locks| locks.0.keys().copied());
        let engaged = self.engaged.iter().filter(|(_, seen)| seen.value);
        locked.chain(engaged.map(|(source, _)| *source)).collect()
    }

    /// Robots that the e-stop holds.
    pub fn n_held_by_e_stop(&self) -> usize {
        let holds = |robot: &&ObservedRobot| {
            robot.status.as_ref().is_some_and(|status| status.value.holds_e_stop())
        };
        self.robots.values().filter(holds).count()
    }

    /// Order parameters of what the swarm did while it was last permitted to move; `None` before.
    pub fn order(&self) -> Option<SwarmOrder> {
        self.swarm.order()
    }

    /// Whether the swarm is judged by where objects are, of which not all were seen.
    pub fn lacks_objects(&self) -> bool {
        self.swarm.lacks(self.objects_m.len())
    }

    /// Where robots were in the last seconds of their movement, in any order.
    pub fn trail(&self, over_s: f64) -> &[Pose] {
        self.swarm.trail(over_s)
    }

    /// Whether robots may move now.
    fn is_running(&self, now: Duration) -> bool {
        if let Some(lease) = &self.lease {
            return self.freshness.lasts(lease.age(now))
                && lease.value.state == LeaseState::Running;
        }
        // Where nobody holds leases, who is commanded to move does; robots with a gate stand.
        let mut robots = self.robots.values();
        robots.clone().all(|robot| robot.status.is_none())
            && robots.any(|robot| robot.is_commanded_to_move(now))
    }

    /// Whether the run that goes on takes the poses of a robot from another source.
    fn is_passed_over(&self, robot: &str, source: PoseSource, now: Duration) -> bool {
        let run_id = self.lease.as_ref().map(|lease| &lease.value.run_id);
        let record = self.experiment.as_ref().filter(|record| Some(&record.run_id) == run_id);
        let of_run = record.filter(|record| record.robots.iter().any(|other| other == robot));
        let stated = of_run.and_then(|record| record.pose_source);
        stated.is_some_and(|stated| stated != source) && self.is_running(now)
    }

    fn take_lease(&mut self, lease: Lease, now: Duration) {
        let is_beside = self.is_beside(&lease, now);
        for echo in &lease.robots {
            if let Some(robot) = self.robot_mut(echo.robot.clone()) {
                robot.lease = Some(Seen { value: lease.with_only(echo), at: now });
            }
        }
        // A run of other robots goes its own way; the one that was watched is watched on.
        if is_beside {
            return;
        }
        let is_known = |since: &Seen<String>| since.value == lease.run_id;
        if lease.state == LeaseState::Running && !self.running_since.as_ref().is_some_and(is_known)
        {
            self.running_since = Some(Seen { value: lease.run_id.clone(), at: now });
            self.swarm.clear();
        }
        self.lease = Some(Seen { value: lease, at: now });
    }

    /// Whether a lease is of a run that goes on beside the one that is watched, with other robots.
    fn is_beside(&self, lease: &Lease, now: Duration) -> bool {
        let Some(watched) = &self.lease else { return false };
        let run_id = &watched.value.run_id;
        let is_of_watched = |robot: &ObservedRobot| {
            robot.lease.as_ref().is_some_and(|lease| lease.value.run_id == *run_id)
        };
        let has_members = self.robots.values().any(is_of_watched);
        let named = |echo: &Echo| self.robots.get(&Name::new(echo.robot.clone()));
        let shares = lease.robots.iter().filter_map(named).any(is_of_watched);
        lease.run_id != *run_id
            && self.is_running(now)
            && has_members
            && !lease.robots.is_empty()
            && !shares
    }

    /// A robot, new or known; names come from the network, and a sender may send any number.
    fn robot_mut(&mut self, name: String) -> Option<&mut ObservedRobot> {
        let name = Name::new(name);
        if !self.robots.contains_key(&name) && self.robots.len() >= MOST_ROBOTS {
            return None;
        }
        let freshness = self.freshness;
        let robot = move || ObservedRobot::watched(freshness);
        Some(self.robots.entry(name).or_insert_with(robot))
    }
}

#[cfg(test)]
mod tests;
