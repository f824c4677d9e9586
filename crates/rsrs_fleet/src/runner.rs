//! The conductor of one run: looks, sets, arms, runs, stops, and closes the bag whatever happens.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use rsrs_core::robot::unicycle::Pose;

use crate::e_stop::{EStop, Message};
use crate::epoch::{self, ImplausibleEpoch};
use crate::heartbeat::next_beat;
use crate::message::{Lease, LeaseState, RobotState, Status};
use crate::parameters::GateSettings;
use crate::preflight::{self, Graph, Seen};
use crate::record::{Ending, LostRobot, PausedRobot};
use crate::timing::{
    ARM_TIMEOUT, CATCH_UP_TIMEOUT, CONFIGURE_TIMEOUT, COUNTDOWN_TIMEOUT, FIRST_SAMPLE_TIMEOUT,
    GRAPH_PERIOD, LEASE_DURATION, LOCKSTEP_GRACE, NODE_TIMEOUT, POSE_SEARCH_DURATION,
    RECORDER_TIMEOUT, RESUME_TIMEOUT, SILENCE_TIMEOUT, STAND_TIMEOUT, Transport, most_paused,
};

mod event;
mod gates;
mod grouped;
mod others;
mod outcome;
mod pauses;
mod plausibility;
mod pose_gaps;
mod requests;
mod roster;
mod search;
mod start_check;
mod unexpected_publishers;

pub use event::{Action, Event, RunLength, RunnerOptions};
use gates::Gates;
pub use grouped::grouped;
use others::{Claim, Others};
pub use outcome::{AbortCause, Failure, LossCause, Outcome, SampleKind, Target};
pub use plausibility::MotionCheck;
use plausibility::Plausibility;
use pose_gaps::PoseGaps;
use requests::Requests;
use roster::{LossTimeouts, Roster, RunBinding};
use search::Search;
use start_check::StartCheck;
use unexpected_publishers::UnexpectedPublishers;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Discover,
    Configure,
    ReadBack,
    Record,
    Arm,
    CountDown,
    Run,
    Stop,
    Close,
    Done,
}

/// The conductor of one run.
#[derive(Clone, Debug)]
pub struct Runner {
    options: RunnerOptions,
    transport: Transport,
    phase: Phase,
    /// Since when it is in its phase; `None` before the first event.
    since: Option<Duration>,
    /// When it was given the time last.
    woken: Duration,
    /// Time before the start in which this machine did not keep up, and which counted for no timeout.
    forgiven: Duration,
    graph: Graph,
    /// When it received last what the discovery database holds.
    looked: Duration,
    strangers: UnexpectedPublishers,
    search: Search,
    roster: Roster,
    pose_gaps: PoseGaps,
    start_check: StartCheck,
    plausibility: Plausibility,
    /// Whole seconds of the countdown that were left when it was reported last.
    reported_s: u64,
    requests: Requests,
    gates: Gates,
    others: Others,
    highest_epoch: u64,
    /// The last epoch that no runner made.
    refused_epoch: Option<ImplausibleEpoch>,
    /// The epoch of this run; 0 before it arms.
    epoch: u64,
    e_stop: EStop,
    recorder_opened: bool,
    recorder_closed: bool,
    closing: Closing,
    recorded: u64,
    simulated_at: Option<Duration>,
    last_lease: Option<(LeaseState, Duration)>,
    outcome: Option<Outcome>,
    has_started: bool,
    lost: Vec<LostRobot>,
    paused: Vec<PausedRobot>,
    /// When it armed first: a countdown may start again.
    armed_at: Option<Duration>,
    not_standing: Vec<String>,
    /// Robots whose batteries were reported as low in the run.
    low: BTreeSet<String>,
}

impl Runner {
    /// A runner that has not looked yet.
    pub fn new(options: RunnerOptions) -> Self {
        Self {
            transport: Transport::Plain,
            phase: Phase::Discover,
            since: None,
            woken: Duration::ZERO,
            forgiven: Duration::ZERO,
            graph: Graph::default(),
            looked: Duration::ZERO,
            strangers: UnexpectedPublishers::default(),
            search: Search::default(),
            roster: Roster::new(&options.expected.robots),
            pose_gaps: PoseGaps::default(),
            start_check: StartCheck::default(),
            plausibility: Plausibility::new(options.motion.clone(), &options.expected.robots),
            reported_s: 0,
            requests: Requests::default(),
            gates: Gates::default(),
            others: Others::default(),
            highest_epoch: 0,
            refused_epoch: None,
            epoch: 0,
            e_stop: EStop::default(),
            recorder_opened: false,
            recorder_closed: false,
            closing: Closing::default(),
            recorded: 0,
            simulated_at: None,
            last_lease: None,
            outcome: None,
            has_started: false,
            lost: Vec::new(),
            paused: Vec::new(),
            armed_at: None,
            not_standing: Vec::new(),
            low: BTreeSet::new(),
            options,
        }
    }

    /// The same over another transport, on which it depends how long it looks for robots.
    #[must_use]
    pub fn over(self, transport: Transport) -> Self {
        Self { transport, ..self }
    }

    /// The epoch of this run; 0 before it arms.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// How the run ended; `None` while it goes on. It is set before the bag is closed.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.outcome.as_ref()
    }

    /// Whether the robots have been allowed to move, and so whether there was anything to see.
    pub fn has_started(&self) -> bool {
        self.has_started
    }

    /// Robots that were lost while they should have moved, in that order.
    pub fn lost(&self) -> &[LostRobot] {
        &self.lost
    }

    /// What the gates of its robots are set to, by robot, as far as it was read.
    pub fn gates(&self) -> &BTreeMap<String, GateSettings> {
        self.gates.found()
    }

    /// When robots stood in the run because their leases had run out, and went on; known when the
    /// run has ended.
    pub fn paused(&self) -> &[PausedRobot] {
        &self.paused
    }

    /// How the run ended, as its bag has it; `None` while it goes on.
    pub fn ending(&self) -> Option<Ending> {
        self.outcome.as_ref().map(|outcome| Ending::new(outcome, &self.lost, &self.paused))
    }

    /// Whether it needs what the discovery database holds now: all the time until all is
    /// found, then now and then, because another node may start to steer its robots.
    pub fn looks(&self, now: Duration) -> bool {
        match self.phase {
            Phase::Discover => true,
            Phase::Stop | Phase::Close | Phase::Done => false,
            _ => now.saturating_sub(self.looked) >= GRAPH_PERIOD,
        }
    }

    fn see(&mut self, graph: Graph, now: Duration, actions: &mut Vec<Action>) {
        self.looked = now;
        if self.phase == Phase::Discover {
            self.graph = graph;
        } else if let Some(found) = self.strangers.find(&self.options.expected, &graph, now) {
            self.abort(&found, now, actions);
        }
    }

    /// How long the robots have been allowed to move; `None` before and after.
    pub fn running_for(&self, now: Duration) -> Option<Duration> {
        (self.phase == Phase::Run).then(|| self.elapsed(now))
    }

    /// Takes an event, and returns what to do, in order.
    ///
    /// Answers to [`Action::Configure`] and [`Action::ReadBack`] come back as events; those that
    /// never come are asked for again.
    pub fn on_event(&mut self, event: Event, now: Duration) -> Vec<Action> {
        let mut actions = Vec::new();
        if self.phase == Phase::Done {
            return actions;
        }
        self.since.get_or_insert(now);
        self.forgive(now);
        // Words of hundreds of robots are judged together when time passes: each for itself would
        // cost the square of their number.
        let is_a_word = event.is_a_word();
        self.take(event, now, &mut actions);
        if !is_a_word {
            self.go_on(now, &mut actions);
        }
        if self.phase != Phase::Done {
            actions.extend(self.leases_due(now).into_iter().map(Action::PublishLease));
        }
        actions
    }

    fn take(&mut self, event: Event, now: Duration, actions: &mut Vec<Action>) {
        match event {
            Event::Seen(graph) => self.see(graph, now, actions),
            Event::RobotStatus { robot, status } => {
                self.raise_epoch(status.epoch, &robot, actions);
                self.roster.receive_robot(&robot, status, now);
            }
            Event::ControllerStatus { robot, status } => {
                self.raise_epoch(status.epoch, &robot, actions);
                self.roster.receive_controller(&robot, status, now);
            }
            Event::ClockAhead { robot, seconds } => {
                self.start_check.receive_clock(robot, seconds, now);
            }
            Event::Behind { seconds } => self.start_check.receive_delay(seconds),
            Event::Diagnosed { robot, part, error } => {
                let news = self.start_check.receive_diagnosis(robot, part, error);
                self.note_in_run(news, actions);
            }
            Event::Pose { robot, frame, pose } => self.receive_pose(robot, frame, pose, now),
            Event::PoseUnusable { robot, reason } => {
                let news = self.start_check.receive_unusable_pose(robot, reason);
                self.note_in_run(news, actions);
            }
            Event::Commanded { robot, command } => {
                self.plausibility.receive_command(&robot, command, now);
            }
            Event::Sampled { robot, kind } => self.roster.receive_sample(&robot, kind, now),
            Event::ParametersSet { target, result } if self.phase == Phase::Configure => {
                self.requests.answer(&target, result);
            }
            Event::ReadBack { target, result } if self.phase == Phase::ReadBack => {
                let confirmed = result.and_then(|found| self.confirm(&target, found));
                self.requests.answer(&target, confirmed);
            }
            Event::GateRead { robot, found } => self.gates.receive(&robot, found),
            Event::RecorderReady if self.phase == Phase::Record => self.arm(now, actions),
            // Answers that come after their phase is over: to repeated requests, or too late.
            Event::ParametersSet { .. }
            | Event::ReadBack { .. }
            | Event::RecorderReady
            | Event::Tick
            // Robots state in their statuses, too, what they have locked.
            | Event::EStop(Message::Locks { .. }) => {}
            Event::Recorded { step } => self.recorded = self.recorded.max(step),
            Event::RecorderFailed { reason } => self.fail_recorder(reason, now, actions),
            Event::RecorderCloses { done, left_bytes } => {
                let note = self.closing.receive(done, left_bytes, now);
                actions.extend(note.map(Action::Note));
            }
            Event::RecorderClosed => self.recorder_closed = true,
            Event::SimulatorStatus(status) => self.receive_simulator(status, now, actions),
            Event::LeaseReceived(lease) => self.receive_lease(lease, now, actions),
            Event::EStop(Message::State { source, engaged }) => {
                self.e_stop.receive((source, engaged), now);
                if engaged && self.phase != Phase::Discover {
                    self.abort(&AbortCause::EStop, now, actions);
                }
            }
            Event::EStop(Message::Release(sources)) => self.e_stop.release(&sources),
            Event::PoseAhead { robot, seconds } => {
                self.start_check.receive_pose_clock(robot, seconds, now);
            }
            Event::Transform { child, parent } => {
                self.start_check.receive_transform(&child, parent);
            }
            Event::Interrupt { reason } => self.interrupt(reason, now, actions),
        }
    }

    /// News of a robot; before it moves, the search for robots has the same.
    fn note_in_run(&self, news: Option<String>, actions: &mut Vec<Action>) {
        if self.phase == Phase::Run {
            actions.extend(news.map(Action::Note));
        }
    }

    fn receive_pose(&mut self, robot: String, frame: String, pose: Pose, now: Duration) {
        if self.phase == Phase::Run {
            self.plausibility.receive_pose(&robot, pose, now);
            if let Some(geofence) = self.options.expected.geofence {
                self.roster.receive_place(&robot, pose, geofence, now);
            }
        }
        self.start_check.receive_pose(robot, frame, pose, now);
    }

    fn confirm(&self, target: &Target, found: u64) -> Result<(), String> {
        let expected = match target {
            Target::Robot(_) => self.options.controller_digest(),
            Target::Simulator => self.options.simulator_digest,
        };
        if found == expected {
            return Ok(());
        }
        Err(format!("digest {found:016x}, expected {expected:016x}"))
    }

    /// The simulator of this run, if it has one, ends it; another one has nothing to do with it.
    fn receive_simulator(&mut self, status: Status, now: Duration, actions: &mut Vec<Action>) {
        let is_of_another = !status.run_id.is_empty() && status.run_id != self.options.run_id;
        // Before the recorder is open, a status still refers to the run before.
        if !self.options.expected.simulator || is_of_another || !self.recorder_opened {
            return;
        }
        match status.state {
            RobotState::Stopped => {
                self.simulated_at.get_or_insert(now);
            }
            RobotState::Fault => {
                self.end(Outcome::Void { reason: status.stop_reason }, now, actions);
            }
            RobotState::Idle | RobotState::Armed | RobotState::Moving => {}
        }
    }

    /// A runner that hears another one which wants a robot of its own gives way, or is given way to;
    /// runs of other robots go on beside it.
    fn receive_lease(&mut self, lease: Lease, now: Duration, actions: &mut Vec<Action>) {
        if lease.run_id == self.options.run_id {
            return;
        }
        // No gate obeys an epoch that no runner made, so it takes no robot away.
        if !self.raise_epoch(lease.epoch, &format!("run {}", lease.run_id), actions) {
            return;
        }
        let own = Claim { run_id: &self.options.run_id, epoch: self.epoch };
        let claim = Claim { run_id: &lease.run_id, epoch: lease.epoch };
        let shares = lease.robots.iter().any(|echo| self.roster.has(&echo.robot));
        if !shares || !own.gives_way_to(claim) {
            return;
        }
        if self.phase != Phase::Discover {
            let run_id = lease.run_id.clone();
            self.abort(&AbortCause::OtherRunner { run_id }, now, actions);
        }
        self.others.receive(lease.run_id, now);
    }

    /// Takes note of an epoch; one that no runner made is reported once and otherwise ignored.
    fn raise_epoch(&mut self, epoch: u64, who: &str, actions: &mut Vec<Action>) -> bool {
        match epoch::check(epoch, self.highest_epoch) {
            Ok(epoch) => self.highest_epoch = self.highest_epoch.max(epoch),
            Err(refused) => {
                if self.refused_epoch.replace(refused) != Some(refused) {
                    actions.push(Action::Note(format!("{who}: {refused}")));
                }
                return false;
            }
        }
        true
    }

    /// Ends the run; while the bag is closed, the second one gives the bag up.
    fn interrupt(&mut self, reason: String, now: Duration, actions: &mut Vec<Action>) {
        let is_again = self.closing.interrupt();
        if self.phase != Phase::Close {
            return self.abort(&AbortCause::Interrupted { reason }, now, actions);
        }
        let left = self.closing.left();
        if is_again {
            self.fail_recorder(format!("given up when asked to, {left} left"), now, actions);
            self.finish(now, actions);
        } else {
            let text = format!("closing the bag, {left} left; once more gives it up");
            actions.push(Action::Note(text));
        }
    }

    fn abort(&mut self, cause: &AbortCause, now: Duration, actions: &mut Vec<Action>) {
        let reason = cause.to_string();
        self.end(Outcome::Aborted { reason }, now, actions);
    }

    fn fail(&mut self, problems: Vec<Failure>, now: Duration, actions: &mut Vec<Action>) {
        self.end(Outcome::Failed { problems }, now, actions);
    }

    /// Data that is lost outweighs a run that went well until then.
    fn fail_recorder(&mut self, reason: String, now: Duration, actions: &mut Vec<Action>) {
        actions.push(Action::Note(format!("recorder: {reason}")));
        let problems = vec![Failure::Recorder { reason }];
        if self.outcome == Some(Outcome::Completed) {
            self.outcome = Some(Outcome::Failed { problems });
        } else {
            self.fail(problems, now, actions);
        }
    }

    /// Ends the run; the first reason to do so is the one that counts.
    fn end(&mut self, outcome: Outcome, now: Duration, actions: &mut Vec<Action>) {
        if self.outcome.is_some() {
            return;
        }
        self.outcome = Some(outcome);
        self.paused = self.roster.end(now);
        if self.epoch == 0 {
            self.close(now, actions);
        } else {
            actions.push(Action::Note("stopping every robot".to_owned()));
            self.enter(Phase::Stop, now);
        }
    }

    fn enter(&mut self, phase: Phase, now: Duration) {
        self.phase = phase;
        self.since = Some(now);
    }

    /// Lets time in which this machine did not keep up count for no timeout, as long as no robot has
    /// moved, or when a world in lockstep waits for its recorder: what did not come meanwhile may only
    /// not have been looked at.
    fn forgive(&mut self, now: Duration) {
        let passed = now.saturating_sub(std::mem::replace(&mut self.woken, now));
        let stood_still = passed > LEASE_DURATION;
        let is_behind = stood_still || preflight::too_slow(self.start_check.behind_s()).is_some();
        let forgiven = self.forgiven + passed;
        if !is_behind || forgiven > CATCH_UP_TIMEOUT {
            return;
        }
        match self.phase {
            // While it is behind, the search waits by itself.
            Phase::Discover if stood_still => self.search.forgive(passed),
            Phase::Configure | Phase::ReadBack | Phase::Record | Phase::Arm => {
                self.since = self.since.map(|since| since + passed);
            }
            Phase::Run if self.simulated_at.is_some() => {
                self.simulated_at = self.simulated_at.map(|at| at + passed);
            }
            _ => return,
        }
        self.forgiven = forgiven;
    }

    /// How long the runner is in its phase.
    fn elapsed(&self, now: Duration) -> Duration {
        now.saturating_sub(self.since.unwrap_or(now))
    }

    fn lease_state(&self) -> LeaseState {
        match self.phase {
            Phase::Arm | Phase::CountDown => LeaseState::Armed,
            Phase::Run => LeaseState::Running,
            Phase::Stop | Phase::Close if self.epoch > 0 => LeaseState::Stopped,
            _ => LeaseState::Idle,
        }
    }

    /// The lease of all robots, in parts, twenty times a second, and at once when the permission
    /// changes.
    fn leases_due(&mut self, now: Duration) -> Vec<Lease> {
        let state = self.lease_state();
        let at = match self.last_lease {
            Some((last, at)) if last == state => next_beat(at, now),
            _ => Some(now),
        };
        let Some(at) = at else { return Vec::new() };
        self.last_lease = Some((state, at));
        let robots = match state {
            // A robot that was given up stands when no lease names it any more.
            LeaseState::Running => self.roster.echoes_of_present(),
            LeaseState::Idle | LeaseState::Armed | LeaseState::Stopped => self.roster.echoes(),
        };
        let lease = Lease {
            run_id: self.options.run_id.clone(),
            epoch: self.epoch,
            state,
            parameter_digest: self.options.controller_digest(),
            robots,
        };
        lease.split()
    }
}

mod phases;

/// When the operator reads for the first time what is left, and how often then.
const NOTE_PERIOD: Duration = Duration::from_secs(2);

/// How far the bag is.
#[derive(Clone, Copy, Debug, Default)]
struct Closing {
    /// What was done, and since when no more was; `None` before the first word.
    done: Option<(u64, Duration)>,
    left_bytes: u64,
    noted: Option<Duration>,
    /// Whether somebody wanted the run to end, or the bag to be given up.
    is_interrupted: bool,
}

impl Closing {
    /// Somebody wants the run to end; returns whether it is not for the first time.
    fn interrupt(&mut self) -> bool {
        std::mem::replace(&mut self.is_interrupted, true)
    }

    /// Takes a word of the recorder, and returns a note for the operator if one is due.
    fn receive(&mut self, done: u64, left_bytes: u64, now: Duration) -> Option<String> {
        self.left_bytes = left_bytes;
        if self.done.is_none_or(|(before, _)| before != done) {
            self.done = Some((done, now));
        }
        let last = *self.noted.get_or_insert(now);
        if now.saturating_sub(last) < NOTE_PERIOD {
            return None;
        }
        self.noted = Some(now);
        Some(format!("closing the bag, {} left", self.left()))
    }

    /// Why a bag that began to be closed at `since` is given up, if nothing was written for too long.
    fn is_stuck(&self, since: Duration, now: Duration) -> Option<String> {
        let last = self.done.map_or(since, |(_, at)| at.max(since));
        (now.saturating_sub(last) >= RECORDER_TIMEOUT).then(|| {
            format!(
                "nothing was written for {} s, {} left",
                RECORDER_TIMEOUT.as_secs(),
                self.left()
            )
        })
    }

    /// What is still to be written, in words.
    fn left(&self) -> String {
        format!("{} MB", self.left_bytes.div_ceil(1_000_000))
    }
}

#[cfg(test)]
mod tests;
