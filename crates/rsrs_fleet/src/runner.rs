//! The conductor of one run: looks, sets, arms, runs, stops, and closes the bag whatever happens.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use rsrs_core::robot::unicycle::Pose;

use crate::e_stop::{EStop, Message};
use crate::epoch::{self, ImplausibleEpoch};
use crate::heartbeat::next_beat;
use crate::message::{Lease, LeaseState, RobotState, Status};
use crate::parameters::GateSettings;
use crate::placement::PlaceCheck;
use crate::preflight::{self, Graph, Problem, Seen};
use crate::record::{Ending, LostRobot, PausedRobot};
use crate::timing::{
    ARM_TIMEOUT, CATCH_UP_TIMEOUT, CONFIGURE_TIMEOUT, COUNTDOWN_TIMEOUT, FIRST_SAMPLE_TIMEOUT,
    GRAPH_PERIOD, LEASE_DURATION, LOCKSTEP_GRACE, NODE_TIMEOUT, POSE_SEARCH_DURATION,
    RECORDER_TIMEOUT, RESUME_TIMEOUT, SILENCE_TIMEOUT, STAND_TIMEOUT, Transport, most_paused,
};

mod closing;
mod ending;
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
mod simulated_world;
mod start_check;
mod unexpected_publishers;

use closing::Closing;
pub use event::{Action, Event, RunLength, RunnerOptions};
use gates::Gates;
pub use grouped::grouped;
use grouped::{by_reason, names};
use others::{Claim, Others};
pub use outcome::{AbortCause, Failure, LossCause, Outcome, SampleKind, Target};
pub use plausibility::MotionCheck;
use plausibility::Plausibility;
use pose_gaps::PoseGaps;
use requests::Requests;
use roster::{LossTimeouts, Roster, RunBinding, Unarmed};
use search::Search;
use simulated_world::SimulatedWorld;
pub(crate) use simulated_world::world_replaced;
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
    unexpected_publishers: UnexpectedPublishers,
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
    /// The simulator's world, once that was confirmed.
    simulated_world: Option<SimulatedWorld>,
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
            unexpected_publishers: UnexpectedPublishers::default(),
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
            simulated_world: None,
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
        } else if let Some(found) =
            self.unexpected_publishers.find(&self.options.expected, &graph, now)
        {
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
                if target == Target::Simulator && confirmed.is_ok() {
                    self.simulated_world = Some(SimulatedWorld::default());
                }
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

    /// The simulator of this run, if it has one, ends it, and so does a world that is not the run's.
    fn receive_simulator(&mut self, status: Status, now: Duration, actions: &mut Vec<Action>) {
        // Until it has confirmed that it has the run's, it may have any world, or be an earlier process.
        let Some(world) = &mut self.simulated_world else { return };
        if !world.goes_on(&status, self.options.simulator_digest) {
            return self.end(Outcome::Void { reason: world_replaced() }, now, actions);
        }
        let is_of_another = !status.run_id.is_empty() && status.run_id != self.options.run_id;
        // Before the recorder is open, a status still refers to the run before.
        if is_of_another || !self.recorder_opened {
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

/// What it waits for in each phase, and for how long.
impl Runner {
    /// Looks whether the phase is over.
    fn go_on(&mut self, now: Duration, actions: &mut Vec<Action>) {
        match self.phase {
            Phase::Discover => self.discover(now, actions),
            Phase::Configure => self.configure(now, actions),
            Phase::ReadBack => self.read_back(now, actions),
            Phase::Record => {
                if self.elapsed(now) >= RECORDER_TIMEOUT {
                    self.fail_recorder("did not open in time".to_owned(), now, actions);
                }
            }
            Phase::Arm => self.await_armed(now, actions),
            Phase::CountDown => self.count_down(now, actions),
            Phase::Run => self.watch(now, actions),
            Phase::Stop => self.await_standing(now, actions),
            Phase::Close => self.await_closed(now, actions),
            Phase::Done => {}
        }
    }

    fn discover(&mut self, now: Duration, actions: &mut Vec<Action>) {
        let seen = Seen {
            graph: std::mem::take(&mut self.graph),
            robots: self.roster.recent_robots(now),
            controllers: self.roster.recent_controllers(now),
            other_runs: self.others.recent(now).cloned().collect(),
            e_stop: self.e_stop.locks(),
            highest_epoch: self.highest_epoch,
            clocks: self.start_check.clocks(),
            pose_clocks: self.start_check.pose_clocks(),
            poses: self.start_check.poses.clone(),
            unusable_poses: self.start_check.unusable_poses.clone(),
            parents: self.start_check.parents.clone(),
            behind_s: self.start_check.behind_s(),
            diagnostic_errors: self.start_check.diagnostic_errors(),
        };
        let mut problems = preflight::problems(&self.options.expected, &seen);
        // A run places the robots of a simulator when it sets their world; before they move, all are looked at.
        if !self.options.expected.simulator {
            problems.extend(self.misplaced());
        }
        let clocks = preflight::clock_notes(&self.options.expected, &seen);
        let objects = preflight::object_note(&self.options.expected, &seen.graph);
        self.graph = seen.graph;
        let onlookers: Vec<Action> =
            self.graph.onlookers.iter().map(|it| Action::Note(format!("note: {it}"))).collect();
        // Another runner publishes leases all the time: a shorter look might miss them.
        if problems.is_empty() && self.elapsed(now) >= NODE_TIMEOUT {
            self.unexpected_publishers = UnexpectedPublishers::none_of(&self.graph);
            let robots = self.options.expected.robots.len();
            actions.extend(onlookers);
            actions.extend(clocks.into_iter().chain(objects).map(Action::Note));
            actions.extend(self.options.expected.leases().into_iter().map(Action::Note));
            actions.push(Action::Note(format!("found all {robots} robots; setting parameters")));
            self.requests = Requests::new(self.targets());
            self.gates = Gates::new(&self.options.expected.gates);
            actions.extend(self.gates.robots().cloned().map(Action::ReadGate));
            self.enter(Phase::Configure, now);
            self.configure(now, actions);
            return;
        }
        actions.extend(self.search.look(&problems, now).into_iter().map(Action::Note));
        if self.search.is_over(self.since.unwrap_or(now), now, self.transport) {
            actions.extend(onlookers);
            self.fail(problems.into_iter().map(Failure::from).collect(), now, actions);
        }
    }

    fn targets(&self) -> Vec<Target> {
        let expected = &self.options.expected;
        let simulator = expected.simulator.then_some(Target::Simulator);
        expected.robots.iter().cloned().map(Target::Robot).chain(simulator).collect()
    }

    fn configure(&mut self, now: Duration, actions: &mut Vec<Action>) {
        if self.requests.is_done() {
            self.requests = Requests::new(self.targets());
            self.enter(Phase::ReadBack, now);
            self.read_back(now, actions);
        } else if self.elapsed(now) >= CONFIGURE_TIMEOUT {
            let problems = self.requests.problems().into_iter();
            let failures =
                problems.map(|(target, reason)| Failure::NotSet { target, reason }).collect();
            self.fail(failures, now, actions);
        } else {
            actions.extend(self.requests.due(now).into_iter().map(Action::Configure));
        }
    }

    fn read_back(&mut self, now: Duration, actions: &mut Vec<Action>) {
        // A gate that does not answer is not ours, or of no help: nothing of it is known.
        let is_read = self.gates.is_done() || self.elapsed(now) >= CONFIGURE_TIMEOUT;
        if self.requests.is_done() && is_read {
            let problems = self.gates.problems();
            if !problems.is_empty() {
                self.fail(problems.into_iter().map(Failure::from).collect(), now, actions);
                return;
            }
            actions.extend(self.gates.notes().into_iter().map(Action::Note));
            actions.push(Action::Note("parameters confirmed; opening the recorder".to_owned()));
            actions.push(Action::OpenRecorder);
            self.recorder_opened = true;
            self.enter(Phase::Record, now);
        } else if self.elapsed(now) >= CONFIGURE_TIMEOUT {
            let problems = self.requests.problems().into_iter();
            let not_confirmed =
                problems.map(|(target, reason)| Failure::NotConfirmed { target, reason });
            let of_gates = self.gates.problems().into_iter().map(Failure::from);
            self.fail(not_confirmed.chain(of_gates).collect(), now, actions);
        } else {
            actions.extend(self.requests.due(now).into_iter().map(Action::ReadBack));
        }
    }

    /// Takes an epoch above all that were ever received.
    fn arm(&mut self, now: Duration, actions: &mut Vec<Action>) {
        self.epoch =
            self.highest_epoch.checked_add(1).expect("epochs in the upper half are refused");
        actions.push(Action::Note(format!("arming, epoch {}", self.epoch)));
        self.armed_at = Some(now);
        self.enter(Phase::Arm, now);
    }

    fn binding(&self) -> RunBinding<'_> {
        RunBinding {
            run_id: &self.options.run_id,
            epoch: self.epoch,
            parameter_digest: self.options.controller_digest(),
        }
    }

    fn await_armed(&mut self, now: Duration, actions: &mut Vec<Action>) {
        if self.is_taken_away(now, actions) {
            return;
        }
        let waiting = self.roster.not_armed(self.binding(), now);
        if waiting.is_empty() {
            let robots = &self.options.expected.robots;
            let needs_poses = self.options.samples.contains(&SampleKind::Pose);
            // Poses may come seldom; a robot without any delays the run only briefly.
            if (needs_poses || self.options.start.is_some())
                && !self.start_check.has_poses_of(robots)
                && self.elapsed(now) < POSE_SEARCH_DURATION
            {
                return;
            }
            if let Some(start) = &self.options.start {
                let notes = self.start_check.standing_places(start, robots);
                actions.extend(notes.into_iter().map(Action::Note));
            }
            let problems = self.unfit_to_start(now);
            if problems.is_empty() {
                self.begin(now, actions);
            } else {
                self.fail(problems, now, actions);
            }
        } else if self.elapsed(now) >= ARM_TIMEOUT {
            self.fail_to_arm(waiting, now, actions);
        }
    }

    /// What keeps robots that are armed from moving: what was not so when they were found, or was not
    /// known.
    fn unfit_to_start(&self, now: Duration) -> Vec<Failure> {
        let mut problems = self.unusable_poses();
        if self.options.samples.contains(&SampleKind::Pose) {
            let robots = self.start_check.without_poses(&self.options.expected.robots);
            problems.extend(robots.into_iter().map(|robot| Failure::NoPose { robot }));
        }
        problems.extend(self.misplaced().into_iter().map(Failure::from));
        problems.extend(self.unfit_to_move(now));
        problems
    }

    /// Robots whose batteries, diagnostics or places keep them from moving.
    fn unfit_to_move(&self, now: Duration) -> Vec<Failure> {
        let seen = Seen {
            robots: self.roster.recent_robots(now),
            diagnostic_errors: self.start_check.diagnostic_errors(),
            ..Seen::default()
        };
        let mut problems = preflight::health(&self.options.expected, &seen);
        let (expected, poses) = (&self.options.expected, &self.start_check.poses);
        problems.extend(preflight::outside(expected.geofence, &expected.robots, poses));
        problems.into_iter().map(Failure::from).collect()
    }

    /// Robots that do not stand where they are required to.
    fn misplaced(&self) -> Vec<Problem> {
        match (&self.options.start, self.options.place_check) {
            (Some(start), PlaceCheck::Require) => {
                self.start_check.misplaced(start, &self.options.expected.robots)
            }
            _ => Vec::new(),
        }
    }

    /// Poses that came after the robots were found may be the first.
    fn unusable_poses(&self) -> Vec<Failure> {
        let reasons = &self.start_check.unusable_poses;
        let apart = self.options.expected.apart.iter();
        let problems = apart.flat_map(|apart| preflight::unusable_poses(apart, reasons));
        problems.map(Failure::from).collect()
    }

    fn fail_to_arm(&mut self, waiting: Vec<Unarmed>, now: Duration, actions: &mut Vec<Action>) {
        self.fail(waiting.into_iter().map(|it| it.failure).collect(), now, actions);
    }

    /// Counts down, where a person stands beside the robots.
    fn begin(&mut self, now: Duration, actions: &mut Vec<Action>) {
        if self.options.countdown.is_zero() {
            self.start(now, actions);
            return;
        }
        if !self.e_stop.is_used() {
            let alone = "no e-stop publisher is received; `rsrs stop` or Ctrl-C stops the robots";
            actions.push(Action::Note(alone.to_owned()));
        }
        self.reported_s = u64::MAX;
        self.enter(Phase::CountDown, now);
        self.count_down(now, actions);
    }

    fn start(&mut self, now: Duration, actions: &mut Vec<Action>) {
        actions.push(Action::Note("running".to_owned()));
        self.roster.forget_samples();
        self.has_started = true;
        if let Some(world) = &mut self.simulated_world {
            world.start();
        }
        // In lockstep a lapse freezes the world, and no robot stands while others move.
        if matches!(self.options.length, RunLength::RealTime { .. }) {
            self.roster.follow_pauses(self.epoch, now);
        }
        self.enter(Phase::Run, now);
    }

    fn count_down(&mut self, now: Duration, actions: &mut Vec<Action>) {
        if self.is_taken_away(now, actions) {
            return;
        }
        let waiting = self.roster.not_armed(self.binding(), now);
        if !waiting.is_empty() {
            self.break_off_countdown(waiting, now, actions);
            return;
        }
        let unfit = self.unfit_to_move(now);
        if !unfit.is_empty() {
            self.fail(unfit, now, actions);
            return;
        }
        let left = self.options.countdown.saturating_sub(self.elapsed(now));
        if left.is_zero() {
            self.start(now, actions);
            return;
        }
        let left_s = left.as_nanos().div_ceil(1_000_000_000).try_into().unwrap_or(u64::MAX);
        if left_s < self.reported_s {
            self.reported_s = left_s;
            actions.push(Action::Note(format!("the robots move in {left_s} s")));
        }
    }

    /// Arms again the robots whose leases ran out: nothing has moved yet.
    fn break_off_countdown(
        &mut self,
        waiting: Vec<Unarmed>,
        now: Duration,
        actions: &mut Vec<Action>,
    ) {
        let is_over = now.saturating_sub(self.armed_at.unwrap_or(now)) >= COUNTDOWN_TIMEOUT;
        if is_over || !waiting.iter().all(|unarmed| unarmed.may_heal) {
            self.fail_to_arm(waiting, now, actions);
            return;
        }
        let found: Vec<_> = waiting.into_iter().map(|it| it.failure).collect();
        actions.push(Action::Note(format!(
            "{}; the countdown starts again when all are armed",
            grouped(&found).join("; ")
        )));
        self.enter(Phase::Arm, now);
    }

    /// Ends the run if it is no longer this runner's to conduct: robots that obey a higher epoch are
    /// another runner's, and the e-stop is for all robots, whichever receives it first.
    fn is_taken_away(&mut self, now: Duration, actions: &mut Vec<Action>) -> bool {
        if self.roster.holds_e_stop() {
            self.abort(&AbortCause::EStop, now, actions);
            return true;
        }
        let highest = self.roster.highest_epoch();
        if highest > self.epoch {
            let cause = AbortCause::HigherEpoch { found: highest, expected: self.epoch };
            self.abort(&cause, now, actions);
            return true;
        }
        if let Some(other) = self.roster.armed_for_another(self.binding(), now) {
            let run_id = other.to_owned();
            self.abort(&AbortCause::ArmedForAnother { run_id }, now, actions);
            return true;
        }
        false
    }

    fn watch(&mut self, now: Duration, actions: &mut Vec<Action>) {
        if self.is_taken_away(now, actions) {
            return;
        }
        actions.extend(self.low_batteries(now).into_iter().map(Action::Note));
        let lost = self.newly_lost(now, actions);
        let news = self.roster.news_of_lost(self.epoch, now).into_iter();
        actions.extend(news.map(Action::Note));
        actions.extend(resumed(&self.roster.newly_resumed()).map(Action::Note));
        let given_up: BTreeSet<&str> = self.lost.iter().map(|lost| lost.robot.as_str()).collect();
        let since = self.since.unwrap_or(now);
        let implausible = self.plausibility.look(since, now, &given_up);
        actions.extend(implausible.into_iter().map(Action::Note));
        if let Some(robot) = lost.first() {
            let cause = AbortCause::LostRobots { by_reason: by_reason(&lost) };
            match (self.options.length, self.options.robot_lost) {
                // The world stands still without it, and it is chance whether the simulator or the
                // runner finds that first.
                (RunLength::Lockstep { .. }, _) => {
                    return self.end(Outcome::Void { reason: cause.to_string() }, now, actions);
                }
                (RunLength::RealTime { duration }, rule)
                    if rule.ends_run(
                        robot.after_s,
                        duration.as_secs_f64(),
                        self.options.judged,
                    ) =>
                {
                    return self.abort(&cause, now, actions);
                }
                (RunLength::RealTime { .. }, _) => {}
            }
        }
        if self.roster.all_lost() {
            self.abort(&AbortCause::LostAll, now, actions);
            return;
        }
        match self.options.length {
            RunLength::RealTime { duration } => {
                let is_over = self.elapsed(now) >= duration;
                self.note_pose_gaps(duration.saturating_sub(self.elapsed(now)), now, actions);
                if is_over || self.elapsed(now) >= FIRST_SAMPLE_TIMEOUT {
                    self.need_samples(now, actions);
                }
                if is_over {
                    self.end(Outcome::Completed, now, actions);
                }
            }
            RunLength::Lockstep { steps } => self.await_recorded(steps, now, actions),
        }
    }

    /// Batteries that have fallen below their limits in the run, each once.
    fn low_batteries(&mut self, now: Duration) -> Vec<String> {
        let limits = &self.options.expected.battery_min_v;
        if limits.is_empty() {
            return Vec::new();
        }
        let mut notes = Vec::new();
        for (robot, status) in self.roster.recent_robots(now) {
            match preflight::battery(&robot, &status, limits.get(&robot)) {
                Some(problem @ Problem::BatteryLow { .. }) if self.low.insert(robot) => {
                    notes.push(problem.to_string());
                }
                _ => {}
            }
        }
        notes
    }

    /// Robots that were lost just now, which are noted.
    fn newly_lost(&mut self, now: Duration, actions: &mut Vec<Action>) -> Vec<LostRobot> {
        // In lockstep a lapse freezes the world and harms nothing; what the simulator reports on it
        // comes first. In real time a robot needs a moment to receive that it may move; one that is
        // silent may have been so since before the start, while the others move.
        let lapse = LOCKSTEP_GRACE + NODE_TIMEOUT;
        // A robot whose lease ran out stands, and latches if it is not let go on in time.
        let paused = RESUME_TIMEOUT + NODE_TIMEOUT;
        let (timeouts, length) = match self.options.length {
            RunLength::Lockstep { .. } => {
                let timeouts = LossTimeouts { standing: lapse, paused: lapse, silent: lapse };
                (timeouts, Duration::MAX)
            }
            RunLength::RealTime { duration } => {
                let is_starting = self.elapsed(now) < NODE_TIMEOUT;
                let standing = if is_starting { NODE_TIMEOUT } else { Duration::ZERO };
                let silent = SILENCE_TIMEOUT.saturating_sub(NODE_TIMEOUT);
                (LossTimeouts { standing, paused, silent }, duration)
            }
        };
        let lost = self.roster.newly_lost(self.epoch, timeouts, most_paused(length), now);
        self.note_losses(lost, now, actions)
    }

    /// Notes that robots were lost, and why.
    fn note_losses(
        &mut self,
        lost: Vec<(String, String)>,
        now: Duration,
        actions: &mut Vec<Action>,
    ) -> Vec<LostRobot> {
        if !lost.is_empty() {
            let ours = preflight::too_slow(self.start_check.behind_s());
            actions.extend(ours.map(|problem| Action::Note(problem.to_string())));
        }
        let notes = lost.iter().map(|(robot, reason)| format!("lost {robot}: {reason}"));
        actions.extend(notes.map(Action::Note));
        let after_s = self.elapsed(now).as_secs_f64();
        let lost = lost.into_iter();
        let lost: Vec<_> =
            lost.map(|(robot, reason)| LostRobot { robot, after_s, reason }).collect();
        self.lost.extend(lost.iter().cloned());
        lost
    }

    /// Notes at once that a run will not be labelled; one that needs no poses is none.
    fn note_pose_gaps(&mut self, left: Duration, now: Duration, actions: &mut Vec<Action>) {
        if self.options.samples.contains(&SampleKind::Pose) {
            let news =
                self.pose_gaps.news(self.roster.pose_silences(now), left, self.options.judged);
            actions.extend(news.into_iter().map(Action::Note));
        }
    }

    /// A robot without detections has not moved by them, and one without poses cannot be judged: a
    /// run in which either never came is none.
    fn need_samples(&mut self, now: Duration, actions: &mut Vec<Action>) {
        let missing = self.roster.without_samples(&self.options.samples).into_iter();
        let problems: Vec<_> =
            missing.map(|(robot, kind)| Failure::NoSample { robot, kind }).collect();
        if !problems.is_empty() {
            self.fail(problems, now, actions);
        }
    }

    fn await_recorded(&mut self, steps: u64, now: Duration, actions: &mut Vec<Action>) {
        let Some(simulated_at) = self.simulated_at else { return };
        if self.recorded >= steps {
            self.end(Outcome::Completed, now, actions);
        } else if now.saturating_sub(simulated_at) >= RECORDER_TIMEOUT {
            let reason = format!("took step {}, expected {steps}", self.recorded);
            self.fail_recorder(reason, now, actions);
        }
    }

    fn await_standing(&mut self, now: Duration, actions: &mut Vec<Action>) {
        let since = self.since.unwrap_or(now);
        self.not_standing = self.roster.not_standing(self.epoch, since);
        if self.not_standing.is_empty() {
            self.close(now, actions);
        } else if self.elapsed(now) >= STAND_TIMEOUT {
            actions.push(Action::Note(format!(
                "not confirmed to stand after {} s: {}",
                STAND_TIMEOUT.as_secs(),
                self.not_standing.join(", ")
            )));
            self.close(now, actions);
        }
    }

    fn close(&mut self, now: Duration, actions: &mut Vec<Action>) {
        self.enter(Phase::Close, now);
        if self.recorder_opened {
            actions.push(Action::CloseRecorder);
        } else {
            self.finish(now, actions);
        }
    }

    fn await_closed(&mut self, now: Duration, actions: &mut Vec<Action>) {
        if self.recorder_closed {
            self.finish(now, actions);
        } else if let Some(stuck) = self.closing.is_stuck(self.since.unwrap_or(now), now) {
            self.fail_recorder(stuck, now, actions);
            self.finish(now, actions);
        }
    }

    fn finish(&mut self, now: Duration, actions: &mut Vec<Action>) {
        self.enter(Phase::Done, now);
        let outcome = self.outcome.clone().expect("only `end` leads to the phases after it");
        actions.push(Action::Finish { outcome, not_standing: self.not_standing.clone() });
    }
}

/// Robots that go on after their leases had run out, as a note for the operator.
fn resumed(robots: &[(String, Duration)]) -> Option<String> {
    let longest = robots.iter().map(|(_, stood)| *stood).max()?;
    let names = names(&robots.iter().map(|(robot, _)| robot.as_str()).collect::<Vec<_>>());
    let (goes, whose) =
        if robots.len() == 1 { ("goes", "its lease") } else { ("go", "their leases") };
    let stood_s = longest.as_secs_f64();
    Some(format!("{names} {goes} on, and stood for at most {stood_s:.1} s: {whose} ran out"))
}

#[cfg(test)]
mod tests;
