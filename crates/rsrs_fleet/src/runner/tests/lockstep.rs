//! Runs in which the world waits for every robot.

use super::*;
use crate::message;

/// What a simulator reports.
pub(super) fn simulator(state: RobotState, reason: &str) -> Event {
    let stop_reason = reason.to_owned();
    let status = message::tests::status(state, StopCause::None);
    Event::SimulatorStatus(Status { parameter_digest: 7, stop_reason, ..status })
}

#[test]
fn a_simulator_that_is_none_of_this_run_ends_it_neither_well_nor_badly() {
    let of_another = |state| match simulator(state, "frozen for 5 s") {
        Event::SimulatorStatus(status) => {
            Event::SimulatorStatus(Status { run_id: "another".to_owned(), ..status })
        }
        other => other,
    };
    for has_one in [false, true] {
        let mut bench = Bench::with(|options| {
            options.length = RunLength::RealTime { duration: Duration::from_secs(4) };
            options.expected.simulator = has_one;
        });
        bench.run();

        for state in [RobotState::Fault, RobotState::Stopped] {
            bench.give(of_another(state));
            if !has_one {
                bench.give(simulator(state, "frozen for 5 s"));
            }
        }

        assert_eq!(bench.end().0, Outcome::Completed, "with a simulator of its own: {has_one}");
    }
}

#[test]
fn a_lockstep_run_is_complete_when_the_recorder_has_taken_the_last_step() {
    let mut bench = Bench::lockstep();
    bench.run();

    bench.give(simulator(RobotState::Stopped, "all steps are made"));
    bench.give(Event::Recorded { step: 9 });
    bench.beat();
    assert_eq!(bench.state(), Some(LeaseState::Running));
    bench.give(Event::Recorded { step: 10 });

    assert_eq!(bench.end(), (Outcome::Completed, Vec::new()));
    assert!(bench.closed);
    let simulator_and_robots = bench.configured.iter().collect::<BTreeSet<_>>().len();
    assert_eq!(simulator_and_robots, 3);
}

#[test]
fn in_lockstep_a_lapse_within_the_grace_is_waited_for() {
    let mut bench = Bench::lockstep();
    bench.run();

    bench.stopped.insert("robot_1");
    for _ in 0..50 {
        bench.beat();
    }
    bench.stopped.clear();
    for _ in 0..50 {
        bench.beat();
    }
    assert_eq!(bench.state(), Some(LeaseState::Running));
    bench.stopped.insert("robot_1");

    assert!(matches!(bench.end().0, Outcome::Void { .. }));
}

#[test]
fn in_lockstep_a_lapse_that_lasts_makes_the_run_void_whoever_finds_it_first() {
    for robot_lost in [RobotLost::Abort, RobotLost::Note] {
        let mut bench = Bench::new(RunLength::Lockstep { steps: 10 }, robot_lost);
        bench.run();

        bench.silent.extend(NAMES);
        let (outcome, not_standing) = bench.end();
        bench.give(simulator(RobotState::Fault, "frozen"));

        let reason = "lost robot_1, robot_2: silent for more than 1 s".to_owned();
        assert_eq!(outcome, Outcome::Void { reason });
        assert_eq!(not_standing, NAMES);
    }
}

#[test]
fn a_void_run_is_closed_with_its_reason() {
    let mut bench = Bench::lockstep();
    bench.run();

    bench.give(simulator(RobotState::Fault, "frozen"));

    assert_eq!(bench.end().0, Outcome::Void { reason: "frozen".to_owned() });
    assert!(bench.closed);
}

#[test]
fn a_recorder_that_does_not_take_the_last_step_fails_the_run() {
    let mut bench = Bench::lockstep();
    bench.run();

    bench.give(simulator(RobotState::Stopped, "all steps are made"));

    assert_eq!(bench.problems(), ["recorder: took step 0, expected 10"]);
}

/// What the simulator reports: the number of the status, the state, and the number and the digest of its
/// world.
type Told = (u64, RobotState, u64, u64);

fn tell(bench: &mut Bench, told: &[Told]) {
    for &(counter, state, epoch, parameter_digest) in told {
        let Event::SimulatorStatus(status) = simulator(state, "") else { unreachable!() };
        // Until it is armed, a robot names the run before.
        let run_id = if state == RobotState::Armed { "run before" } else { "" }.to_owned();
        let status = Status { counter, epoch, run_id, parameter_digest, ..status };
        bench.give(Event::SimulatorStatus(status));
    }
}

fn world_replaced() -> Outcome {
    Outcome::Void { reason: "simulator: its world was placed anew".to_owned() }
}

#[test]
fn a_run_ends_when_the_simulator_has_another_world_or_the_same_from_its_start() {
    use RobotState::{Armed, Idle, Moving};
    let placed = (1, Armed, 1, 7);
    // What it reports before the robots move, and then.
    let cases: [(&str, &[Told], &[Told], bool); 8] = [
        ("its world goes on", &[placed], &[(2, Armed, 1, 7), (3, Moving, 1, 7)], false),
        ("it is placed again before the start", &[placed, (2, Armed, 2, 7)], &[], false),
        ("another one in the countdown", &[placed, (2, Armed, 2, 8)], &[], true),
        ("another one in the run", &[placed], &[(2, Moving, 1, 7), (3, Armed, 2, 8)], true),
        ("the same from its start", &[placed], &[(2, Moving, 1, 7), (3, Armed, 2, 7)], true),
        ("the same, heard when it moves", &[placed], &[(2, Moving, 1, 7), (9, Moving, 2, 7)], true),
        ("it is moved by hand", &[placed], &[(2, Moving, 1, 7), (3, Idle, 1, 0)], true),
        (
            "an old status comes late",
            &[(5, Armed, 1, 7)],
            &[(6, Moving, 1, 7), (4, Idle, 0, 0)],
            false,
        ),
    ];
    for (what, before, then, is_another) in cases {
        let mut bench = Bench::with(|options| {
            options.length = RunLength::RealTime { duration: Duration::from_secs(4) };
            options.countdown = Duration::from_secs(1);
        });
        while bench.state() != Some(LeaseState::Armed) {
            bench.beat();
        }
        tell(&mut bench, before);
        if !before.iter().any(|told| told.3 == 8) {
            bench.run();
        }
        tell(&mut bench, then);

        let expected = if is_another { world_replaced() } else { Outcome::Completed };
        assert_eq!(bench.end().0, expected, "{what}");
    }
}

#[test]
fn the_world_of_a_run_is_that_of_the_simulator_which_confirmed_it() {
    let mut bench = Bench::lockstep();
    bench.placed = 0;
    while bench.runner.phase != Phase::ReadBack {
        bench.beat();
    }
    // Of its earlier process; started again, it counts from the beginning.
    tell(&mut bench, &[(27, RobotState::Armed, 1, 7)]);
    bench.placed = 7;
    while bench.state() != Some(LeaseState::Armed) {
        bench.beat();
    }

    tell(&mut bench, &[(1, RobotState::Armed, 1, 7), (2, RobotState::Armed, 2, 8)]);

    assert_eq!(bench.end().0, world_replaced());
}
