use std::collections::BTreeSet;

use rsrs_core::judge::window::Window;
use rsrs_core::robot::controller::{ControllerParameters, Reaction};

use super::*;
use crate::e_stop::Source;
use crate::experiment::RobotLost;
use crate::message::StopCause;
use crate::placement::PlaceCheck;
use crate::preflight::Expected;

mod closing;
mod gates;
mod geofence;
mod lockstep;
mod pauses;
mod samples;
mod unexpected_publishers;
mod with_operator;

const CONTROLLER: ControllerParameters = ControllerParameters::mirrored(0.15, 0.75);
const NAMES: [&str; 2] = ["robot_1", "robot_2"];

/// How long a bag takes to close.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Disk {
    /// No time.
    Fast,
    /// As long as the test wants.
    Slow,
}

/// A runner among robots that obey, unless a test silences or changes them.
struct Bench {
    runner: Runner,
    now_ms: u64,
    counter: u64,
    lease: Option<Lease>,
    silent: BTreeSet<&'static str>,
    stopped: BTreeSet<&'static str>,
    parameter_digest: u64,
    read_digest: u64,
    /// Names the world that the simulator has.
    placed: u64,
    simulated: bool,
    publishers: Vec<preflight::Endpoint>,
    opened: bool,
    closed: bool,
    disk: Disk,
    configured: Vec<Target>,
    finish: Option<(Outcome, Vec<String>)>,
    stop_cause: StopCause,
    /// What the gates that are ours are set to.
    gates: BTreeMap<String, GateSettings>,
    battery_v: f32,
    /// Notes to the operator.
    notes: Vec<String>,
}

impl Bench {
    fn new(length: RunLength, robot_lost: RobotLost) -> Self {
        Self::with(|options| {
            options.length = length;
            options.robot_lost = robot_lost;
        })
    }

    fn with(change: impl FnOnce(&mut RunnerOptions)) -> Self {
        let expected = Expected {
            robots: NAMES.map(str::to_owned).to_vec(),
            simulator: true,
            ..Expected::default()
        };
        let mut options = RunnerOptions {
            run_id: "run".to_owned(),
            expected,
            controller: CONTROLLER.into(),
            reaction: Reaction::ToDetections,
            simulator_digest: 7,
            length: RunLength::Lockstep { steps: 10 },
            robot_lost: RobotLost::Abort,
            judged: Window::default(),
            countdown: Duration::ZERO,
            start: None,
            place_check: PlaceCheck::On,
            samples: BTreeSet::new(),
            motion: None,
        };
        change(&mut options);
        Self {
            runner: Runner::new(options),
            now_ms: 0,
            counter: 0,
            lease: None,
            silent: BTreeSet::new(),
            stopped: BTreeSet::new(),
            parameter_digest: CONTROLLER.digest(),
            read_digest: CONTROLLER.digest(),
            placed: 7,
            simulated: true,
            publishers: Vec::new(),
            opened: false,
            closed: false,
            disk: Disk::Fast,
            configured: Vec::new(),
            finish: None,
            stop_cause: StopCause::None,
            gates: BTreeMap::new(),
            battery_v: f32::NAN,
            notes: Vec::new(),
        }
    }

    fn lockstep() -> Self {
        Self::new(RunLength::Lockstep { steps: 10 }, RobotLost::Abort)
    }

    fn real_time(robot_lost: RobotLost) -> Self {
        Self::new(RunLength::RealTime { duration: Duration::from_secs(4) }, robot_lost)
    }

    fn give(&mut self, event: Event) {
        for action in self.runner.on_event(event, Duration::from_millis(self.now_ms)) {
            match action {
                Action::PublishLease(lease) => self.lease = Some(lease),
                Action::Configure(target) => {
                    self.configured.push(target.clone());
                    self.give(Event::ParametersSet { target, result: Ok(()) });
                }
                Action::ReadBack(target) => {
                    let digest = match target {
                        Target::Simulator => self.placed,
                        Target::Robot(_) => self.read_digest,
                    };
                    self.give(Event::ReadBack { target, result: Ok(digest) });
                }
                Action::ReadGate(robot) => {
                    let found = self.gates.get(&robot).cloned();
                    self.give(Event::GateRead { robot, found });
                }
                Action::OpenRecorder => {
                    self.opened = true;
                    self.give(Event::RecorderReady);
                }
                Action::CloseRecorder => {
                    self.closed = true;
                    if self.disk == Disk::Fast {
                        self.give(Event::RecorderClosed);
                    }
                }
                Action::Note(text) => self.notes.push(text),
                Action::Finish { outcome, not_standing } => {
                    assert!(self.finish.is_none(), "finished twice");
                    self.finish = Some((outcome, not_standing));
                }
            }
        }
    }

    /// One beat: every robot and controller publishes.
    fn beat(&mut self) {
        self.now_ms += 100;
        self.counter += 1;
        let (simulator, publishers) = (self.simulated, self.publishers.clone());
        self.give(Event::Seen(Graph { publishers, simulator, ..Graph::default() }));
        for name in NAMES {
            if self.silent.contains(name) {
                continue;
            }
            let (epoch, state) = match &self.lease {
                Some(lease) if lease.epoch > 0 => (
                    lease.epoch,
                    match lease.state {
                        _ if self.stopped.contains(name) => RobotState::Stopped,
                        LeaseState::Running => RobotState::Moving,
                        LeaseState::Stopped => RobotState::Stopped,
                        LeaseState::Idle | LeaseState::Armed => RobotState::Armed,
                    },
                ),
                _ => (3, RobotState::Idle),
            };
            let status = Status {
                counter: self.counter,
                epoch,
                run_id: String::new(),
                parameter_digest: self.parameter_digest,
                state,
                stop_cause: self.stop_cause,
                // Nothing is decided by it.
                stop_reason: "armed for run of another, waiting for the start".to_owned(),
                battery_v: self.battery_v,
            };
            let robot = name.to_owned();
            self.give(Event::ControllerStatus { robot: robot.clone(), status: status.clone() });
            self.give(Event::RobotStatus { robot, status });
        }
    }

    fn state(&self) -> Option<LeaseState> {
        self.lease.as_ref().map(|lease| lease.state)
    }

    fn run(&mut self) {
        for _ in 0..40 {
            if self.state() == Some(LeaseState::Running) {
                return;
            }
            self.beat();
        }
        panic!("not running after 4 s: {:?}", self.finish);
    }

    fn end(&mut self) -> (Outcome, Vec<String>) {
        for _ in 0..300 {
            if let Some(finish) = &self.finish {
                return finish.clone();
            }
            self.beat();
        }
        panic!("no end after 30 s");
    }

    fn problems(&mut self) -> Vec<String> {
        match self.end().0 {
            Outcome::Failed { problems } => problems.iter().map(ToString::to_string).collect(),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_real_time_run_is_complete_when_its_time_is_over() {
    let mut bench = Bench::real_time(RobotLost::Abort);
    bench.run();
    let start_ms = bench.now_ms;

    let end = bench.end();

    assert_eq!(end, (Outcome::Completed, Vec::new()));
    assert!((4000..4500).contains(&(bench.now_ms - start_ms)), "{}", bench.now_ms - start_ms);
}

#[test]
fn the_epoch_is_above_every_one_that_was_received() {
    let mut bench = Bench::lockstep();

    bench.run();

    assert_eq!(bench.runner.epoch(), 4);
}

#[test]
fn nothing_is_set_while_anything_is_missing() {
    let mut bench = Bench::lockstep();
    bench.simulated = false;
    bench.silent.insert("robot_2");

    let problems = bench.problems();

    assert_eq!(
        problems,
        [
            "no simulator discovered",
            "robot_2: no status received",
            "robot_2: no status of its controller received"
        ]
    );
    assert_eq!(bench.configured, []);
}

#[test]
fn while_ever_more_of_the_fleet_is_found_it_is_waited_for() {
    let mut bench = Bench::lockstep();
    bench.silent.extend(NAMES);

    for found in NAMES {
        (0..90).for_each(|_| bench.beat());
        assert_eq!(bench.finish, None);
        bench.silent.remove(found);
    }

    bench.run();
}

/// Lets both robots' clocks be received in every beat, with delays.
fn with_clocks(bench: &mut Bench, n_beats: u32, second_s: impl Fn(f64) -> f64) {
    for beat in 0..n_beats {
        let delay_s = [0.4, 0.03, 0.2][beat as usize % 3];
        for (robot, clock_s) in [("robot_1", 0.0), ("robot_2", second_s(f64::from(beat) / 10.0))] {
            let seconds = clock_s - delay_s;
            bench.give(Event::ClockAhead { robot: robot.to_owned(), seconds });
        }
        bench.beat();
    }
}

#[test]
fn a_clock_that_counts_from_its_start_is_noted_and_delay_makes_none_wrong() {
    let mut bench = Bench::lockstep();

    with_clocks(&mut bench, 19, |_| -1_763_969_600.0);
    assert_eq!(bench.configured, [], "it is looked at for longer than it takes to find the robots");
    with_clocks(&mut bench, 10, |_| -1_763_969_600.0);

    bench.run();
    let clocks: Vec<&String> = bench.notes.iter().filter(|note| note.contains("clock")).collect();
    let expected = "note: robot_2: clock 1763969600.0 s behind ours; stamps are aligned by when they \
                    are received";
    assert_eq!(clocks, [expected]);
}

#[test]
fn a_clock_that_is_being_set_keeps_a_run_from_starting() {
    // It stands.
    let mut bench = Bench::lockstep();

    with_clocks(&mut bench, 150, |now_s| -3.0 - now_s);

    let problems = bench.problems();
    let [clock] = &problems[..] else { panic!("{problems:?}") };
    assert!(clock.starts_with("robot_2: clock 1"), "{clock}");
    assert!(
        clock.contains("since it was received first, so its stamps cannot be aligned"),
        "{clock}"
    );
}

#[test]
fn a_machine_that_stood_still_or_is_behind_fails_no_run_that_has_not_begun() {
    let preparing = || {
        let mut bench = Bench::lockstep();
        bench.stopped.insert("robot_1");
        while !bench.opened {
            bench.beat();
        }
        bench
    };

    let mut stood_still = preparing();
    stood_still.now_ms += 8_000;
    stood_still.give(Event::Tick);
    stood_still.stopped.clear();
    stood_still.run();

    let mut behind = preparing();
    for _ in 0..80 {
        behind.give(Event::Behind { seconds: 0.9 });
        behind.beat();
    }
    behind.stopped.clear();
    behind.run();

    // It was looking for the robots.
    let mut looking = Bench::lockstep();
    looking.silent.insert("robot_2");
    (0..50).for_each(|_| looking.beat());
    looking.now_ms += 12_000;
    looking.give(Event::Tick);
    looking.silent.clear();
    looking.run();

    // Not for ever.
    let mut behind = preparing();
    let start_ms = behind.now_ms;
    while behind.finish.is_none() {
        behind.give(Event::Behind { seconds: 0.9 });
        behind.beat();
    }
    assert!((64_000..67_000).contains(&(behind.now_ms - start_ms)), "{}", behind.now_ms);
    assert!(behind.problems()[0].starts_with("robot_1: did not arm"));
}

#[test]
fn a_machine_that_stood_still_while_the_last_steps_were_written_fails_no_run_in_lockstep() {
    let mut bench = Bench::lockstep();
    bench.run();
    bench.give(lockstep::simulator(RobotState::Stopped, "all steps are made"));

    bench.now_ms += 12_000;
    bench.give(Event::Tick);
    bench.give(Event::Recorded { step: 10 });

    assert_eq!(bench.end().0, Outcome::Completed);
}

#[test]
fn parameters_that_read_back_otherwise_are_refused_before_anything_is_recorded() {
    let mut bench = Bench::lockstep();
    bench.read_digest = 1;

    let problems = bench.problems();

    assert_eq!(problems.len(), 2);
    assert!(problems[0].starts_with("robot_1: parameters not confirmed: digest 0000000000000001"));
    assert!(!bench.opened);
}

#[test]
fn a_robot_with_other_parameters_is_never_started() {
    let mut bench = Bench::lockstep();
    bench.parameter_digest = 1;

    let problems = bench.problems();

    assert!(problems[0].starts_with("robot_1: did not arm: parameter digest"), "{problems:?}");
    assert!(bench.closed);
    assert!(!bench.runner.has_started());
}

#[test]
fn an_interrupt_at_any_moment_ends_in_a_closed_bag() {
    for beats in 0..40 {
        let mut bench = Bench::lockstep();
        for _ in 0..beats {
            bench.beat();
        }

        bench.give(Event::Interrupt { reason: "interrupted".to_owned() });
        let (outcome, not_standing) = bench.end();

        assert_eq!(outcome, Outcome::Aborted { reason: "interrupted".to_owned() });
        assert_eq!((bench.closed, not_standing), (bench.opened, Vec::new()));
    }
}

#[test]
fn the_e_stop_ends_the_run() {
    let mut bench = Bench::lockstep();
    bench.run();

    bench.give(Event::EStop(Message::State { source: Source([1; 16]), engaged: true }));

    assert_eq!(bench.state(), Some(LeaseState::Stopped));
    assert_eq!(bench.end().0, Outcome::Aborted { reason: "e-stop".to_owned() });
}

#[test]
fn a_runner_that_receives_another_with_as_high_an_epoch_stops() {
    let mut bench = Bench::lockstep();
    bench.run();
    let own = bench.lease.clone().expect("a running runner has published a lease");

    bench.give(Event::LeaseReceived(own.clone()));
    bench.give(Event::LeaseReceived(Lease { run_id: "low".to_owned(), epoch: 3, ..own.clone() }));
    assert_eq!(bench.state(), Some(LeaseState::Running));
    bench.give(Event::LeaseReceived(Lease { run_id: "other".to_owned(), ..own }));

    assert_eq!(
        bench.end().0,
        Outcome::Aborted { reason: "another runner is active, run other".to_owned() }
    );
}

#[test]
fn a_silent_robot_aborts_the_run_and_is_named_at_its_end() {
    let mut bench = Bench::real_time(RobotLost::Abort);
    bench.run();
    bench.beat();

    bench.silent.insert("robot_2");
    let (outcome, not_standing) = bench.end();

    assert_eq!(
        outcome,
        Outcome::Aborted { reason: "lost robot_2: silent for more than 1 s".to_owned() }
    );
    assert_eq!(not_standing, ["robot_2"]);
}

#[test]
fn a_lost_robot_may_be_noted_and_the_run_go_on() {
    let mut bench = Bench::real_time(RobotLost::Note);
    bench.run();

    bench.silent.insert("robot_2");

    assert_eq!(bench.end(), (Outcome::Completed, vec!["robot_2".to_owned()]));
    let [lost] = bench.runner.lost() else { panic!("{:?}", bench.runner.lost()) };
    assert_eq!(
        (lost.robot.as_str(), lost.reason.as_str()),
        ("robot_2", "silent for more than 1 s")
    );
    assert!((1.5..2.0).contains(&lost.after_s), "{}", lost.after_s);
}

#[test]
fn until_the_judged_time_begins_a_lost_robot_ends_the_run_and_then_it_is_noted() {
    // 64 s, of which the last 60 are judged.
    let length = RunLength::RealTime { duration: Duration::from_secs(64) };
    for (lost_ms, expected) in [(1_000, "aborted"), (6_000, "completed")] {
        let mut bench = Bench::new(length, RobotLost::AbortUntilJudged);
        bench.run();
        assert!(bench.runner.has_started());
        let start_ms = bench.now_ms;
        while bench.now_ms - start_ms < lost_ms {
            bench.beat();
        }

        bench.silent.insert("robot_2");
        while bench.finish.is_none() {
            bench.beat();
        }

        let (outcome, _) = bench.end();
        let ending = Ending::new(&outcome, bench.runner.lost(), bench.runner.paused());
        assert_eq!(ending.kind.key(), expected, "{outcome:?}");
        assert_eq!(bench.runner.lost().len(), 1);
    }
}

#[test]
fn a_lost_robot_that_is_received_again_is_named_and_stays_lost() {
    let mut bench = Bench::real_time(RobotLost::Note);
    bench.run();
    bench.silent.insert("robot_2");
    while bench.runner.lost().is_empty() {
        bench.beat();
    }

    bench.silent.remove("robot_2");
    bench.stopped.insert("robot_2");
    bench.end();

    let back = "robot_2 is received again, and stands until the next run";
    assert_eq!(bench.notes.iter().filter(|note| *note == back).count(), 1, "{:?}", bench.notes);
    assert_eq!(bench.runner.lost().len(), 1);
}

#[test]
fn robots_that_are_lost_because_this_machine_is_too_slow_are_reported_so() {
    let mut bench = Bench::real_time(RobotLost::Note);
    bench.run();

    bench.give(Event::Behind { seconds: 0.9 });
    bench.silent.insert("robot_2");
    bench.end();

    let notes = bench.notes.iter().position(|notes| notes.starts_with("this machine is too slow"));
    let lost = bench.notes.iter().position(|notes| notes.starts_with("lost robot_2"));
    assert!(notes.is_some_and(|notes| lost == Some(notes + 1)), "{:?}", bench.notes);
}
