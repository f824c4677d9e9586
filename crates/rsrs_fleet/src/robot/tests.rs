use super::*;
use crate::e_stop::{LockCause, Source};
use crate::message::{self, Echo};

mod of_two_sources;

const DIGEST: u64 = 7;
const FORWARD: Command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };

fn ms(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

fn robot() -> Robot {
    Robot::new(RobotOptions {
        name: "robot_1".to_owned(),
        command_timeout: ms(325),
        lapse: Lapse::Stops,
    })
}

fn lease(epoch: u64, state: LeaseState, counter: u64) -> Event {
    Event::Lease(Lease {
        run_id: format!("run {epoch}"),
        epoch,
        state,
        parameter_digest: DIGEST,
        robots: vec![Echo { robot: "robot_1".to_owned(), counter }],
    })
}

/// The status of its controller at that time in epoch 1, ten thousand times a second at most.
fn controller(parameter_digest: u64, at: Duration) -> Event {
    controller_in(1, parameter_digest, at)
}

fn controller_in(epoch: u64, parameter_digest: u64, at: Duration) -> Event {
    Event::Controller(Status {
        counter: 1 + u64::try_from(at.as_micros() / 100).unwrap(),
        epoch,
        parameter_digest,
        ..message::tests::status(RobotState::Moving, StopCause::None)
    })
}

/// The one source of most tests.
const BUTTON: Source = Source([1; 16]);

fn engaged() -> Event {
    Event::EStop(Message::State { source: BUTTON, engaged: true })
}

fn released() -> Event {
    Event::EStop(Message::State { source: BUTTON, engaged: false })
}

/// A robot that moves at time 0 under epoch 1.
fn moving() -> Robot {
    let mut robot = robot();
    let status = robot.on_event(Event::Tick, ms(0)).expect("the first status is due");
    robot.on_event(controller(DIGEST, ms(0)), ms(0));
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(0));
    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(0));
    robot.on_event(Event::Command(FORWARD), ms(0));
    assert_eq!(robot.drive(ms(0)), FORWARD);
    robot
}

#[test]
fn a_robot_without_a_lease_stands() {
    let mut robot = robot();

    robot.on_event(Event::Command(Command { speed_m_s: 1.0, turn_rate_rad_s: 0.0 }), ms(0));

    assert_eq!(robot.drive(ms(0)), Command::STOP);
}

#[test]
fn a_delayed_lease_cannot_stretch_itself() {
    let mut robot = moving();
    // Every beat brings a lease, but all of them echo the first status.
    for beat in 1..=5 {
        robot.on_event(controller(DIGEST, ms(beat * 100)), ms(beat * 100));
        robot.on_event(lease(1, LeaseState::Running, 1), ms(beat * 100));
        robot.on_event(Event::Command(FORWARD), ms(beat * 100));
    }

    assert_ne!(robot.drive(ms(500)), Command::STOP);
    assert_eq!(robot.drive(ms(501)), Command::STOP);
}

/// The same a moment after its lease ran out: what it reports then.
fn lapsed() -> (Robot, Status) {
    let mut robot = moving();
    robot.on_event(controller(DIGEST, ms(480)), ms(480));
    let status = robot.on_event(Event::Tick, ms(510)).expect("a change is published at once");
    assert_eq!((status.state, status.stop_cause), (RobotState::Stopped, StopCause::Lease));
    (robot, status)
}

#[test]
fn a_robot_whose_lease_ran_out_goes_on_when_its_runner_knows_that_it_stands() {
    let (mut robot, status) = lapsed();
    robot.on_event(Event::Command(FORWARD), ms(700));
    robot.on_event(controller(DIGEST, ms(700)), ms(700));
    assert_eq!(robot.drive(ms(700)), Command::STOP);

    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(710));

    assert_eq!((robot.state(ms(710)), robot.drive(ms(710))), (RobotState::Moving, FORWARD));
    assert_eq!(robot.state(ms(1_011)), RobotState::Stopped, "500 ms after that status");
}

#[test]
fn a_lease_that_echoes_a_status_from_before_its_lapse_lets_no_robot_go_on() {
    let mut robot = moving();
    let before = robot.on_event(Event::Tick, ms(450)).expect("a status is due");
    robot.on_event(controller(DIGEST, ms(480)), ms(480));
    robot.on_event(Event::Tick, ms(510));

    robot.on_event(lease(1, LeaseState::Running, before.counter), ms(520));

    assert_eq!(robot.standing(ms(520)), Some(StandReason::LeaseLapsed));
}

#[test]
fn a_robot_that_stood_too_long_latches_until_a_newer_epoch_arms() {
    let (mut robot, status) = lapsed();
    robot.on_event(Event::Tick, ms(1_499));
    assert_eq!((robot.latched(), robot.is_in_run(ms(1_499))), (None, true));
    let late = robot.on_event(Event::Tick, ms(1_500)).expect("a change is published at once");
    assert_eq!(late.stop_cause, StopCause::Latched);

    for counter in [status.counter, late.counter] {
        robot.on_event(lease(1, LeaseState::Running, counter), ms(1_510));
        assert_eq!(robot.latched(), Some("lease ran out"));
        assert!(!robot.is_in_run(ms(1_510)));
    }

    robot.on_event(lease(2, LeaseState::Armed, late.counter), ms(1_520));
    assert_eq!(robot.state(ms(1_520)), RobotState::Armed);
}

#[test]
fn a_stop_ends_the_time_in_which_a_robot_may_go_on() {
    for stop in [lease(1, LeaseState::Stopped, 0), engaged()] {
        let (mut robot, status) = lapsed();

        robot.on_event(stop, ms(600));
        robot.on_event(controller(DIGEST, ms(610)), ms(610));
        robot.on_event(released(), ms(620));
        robot.on_event(lease(1, LeaseState::Running, status.counter), ms(630));

        assert_eq!(robot.state(ms(630)), RobotState::Stopped);
        assert!(robot.latched().is_some());
    }
}

#[test]
fn a_robot_goes_on_only_with_a_controller_that_is_received_and_confirmed() {
    let (mut robot, status) = lapsed();
    // Its controller was out of reach as well, and is received a moment later.
    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(990));
    assert_eq!(robot.standing(ms(990)), Some(StandReason::ControllerUnconfirmed));

    robot.on_event(controller(DIGEST, ms(1_000)), ms(1_000));

    assert_eq!(robot.state(ms(1_000)), RobotState::Moving);
}

#[test]
fn a_lease_that_comes_late_or_again_arms_nobody() {
    let mut robot = robot();
    robot.on_event(Event::Tick, ms(0));
    let restarted = Robot::new(robot.options.clone()).counting_from(900);
    let status = robot.on_event(Event::Tick, ms(100)).unwrap();
    let armed = lease(1, LeaseState::Armed, status.counter);

    robot.on_event(armed.clone(), ms(601));
    assert_eq!(robot.epoch(), 0, "what it echoes is too old");

    let mut robot = restarted;
    robot.on_event(Event::Tick, ms(1_000));
    robot.on_event(armed, ms(1_000));
    assert_eq!(robot.epoch(), 0, "what it echoes was published before the robot was started again");
}

#[test]
fn a_robot_that_receives_no_lease_any_more_is_no_longer_armed_and_may_be_again() {
    let mut robot = robot();
    let status = robot.on_event(Event::Tick, ms(0)).unwrap();
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(0));
    assert_eq!(robot.state(ms(500)), RobotState::Armed);

    assert_eq!(robot.state(ms(501)), RobotState::Stopped);
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(600));

    assert_eq!(robot.state(ms(600)), RobotState::Armed);
}

#[test]
fn of_two_runs_of_one_epoch_it_receives_its_own_only() {
    let mut robot = moving();
    let of_another = |state| match lease(1, state, 1) {
        Event::Lease(lease) => Event::Lease(Lease { run_id: "another".to_owned(), ..lease }),
        other => panic!("{other:?}"),
    };

    robot.on_event(of_another(LeaseState::Stopped), ms(10));
    assert_eq!((robot.run_id(), robot.latched()), (Some("run 1"), None));
    let status = robot.on_event(Event::Tick, ms(400)).unwrap();
    let mut another = of_another(LeaseState::Running);
    if let Event::Lease(lease) = &mut another {
        lease.robots[0].counter = status.counter;
    }
    robot.on_event(another, ms(410));

    assert_eq!(robot.state(ms(501)), RobotState::Stopped, "its own lease has run out");
}

#[test]
fn an_older_epoch_is_not_obeyed() {
    let mut robot = moving();
    robot.on_event(lease(3, LeaseState::Armed, 1), ms(10));

    robot.on_event(lease(1, LeaseState::Running, 1), ms(20));
    robot.on_event(lease(2, LeaseState::Armed, 1), ms(20));

    assert_eq!(robot.epoch(), 3);
    assert_eq!(robot.state(ms(20)), RobotState::Armed);
}

#[test]
fn other_parameters_than_the_confirmed_ones_stop_the_robot() {
    let mut robot = moving();

    robot.on_event(controller(DIGEST + 1, ms(50)), ms(50));

    assert_eq!(robot.drive(ms(50)), Command::STOP);
    assert_eq!(robot.latched(), Some("controller silent or its parameters not the confirmed ones"));
}

#[test]
fn a_stale_command_stops_the_wheels_without_a_latch() {
    let mut robot = moving();
    let status = robot.on_event(Event::Tick, ms(300)).expect("a status is due");
    robot.on_event(controller(DIGEST, ms(300)), ms(300));
    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(300));

    assert_eq!(robot.drive(ms(326)), Command::STOP);
    assert_eq!(robot.latched(), None);
}

#[test]
fn a_silent_e_stop_publisher_locks() {
    let mut robot = moving();
    robot.on_event(released(), ms(0));

    assert_ne!(robot.drive(ms(300)), Command::STOP);
    robot.on_event(lease(1, LeaseState::Running, 1), ms(400));
    assert_eq!(robot.standing(ms(501)), Some(StandReason::EStop));
}

#[test]
fn a_lock_by_silence_is_released_by_a_word_and_not_by_arming() {
    let mut robot = moving();
    robot.on_event(released(), ms(0));
    robot.on_event(lease(1, LeaseState::Running, 1), ms(400));
    robot.on_event(Event::Tick, ms(501));

    robot.on_event(lease(2, LeaseState::Armed, robot.beat.counter()), ms(600));
    assert_eq!(robot.standing(ms(600)), Some(StandReason::EStop));

    robot.on_event(released(), ms(700));
    robot.on_event(lease(3, LeaseState::Armed, robot.beat.counter()), ms(800));
    assert_eq!(robot.state(ms(800)), RobotState::Armed);
}

#[test]
fn a_release_does_not_lock_a_robot_whose_runner_died_before_the_start() {
    let mut robot = robot();
    let status = robot.on_event(Event::Tick, ms(0)).unwrap();
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(0));

    robot.on_event(released(), ms(5_000));

    robot.on_event(Event::Tick, ms(6_000));
    assert_eq!(robot.standing(ms(6_000)), Some(StandReason::LeaseLapsed));
}

#[test]
fn who_engages_the_e_stop_may_leave_and_the_robot_still_stands() {
    let mut robot = moving();
    robot.on_event(engaged(), ms(10));

    let status = robot.on_event(Event::Tick, ms(60_000)).unwrap();
    robot.on_event(lease(2, LeaseState::Armed, status.counter), ms(60_000));

    assert_eq!((robot.epoch(), robot.standing(ms(60_000))), (2, Some(StandReason::EStop)));
}

#[test]
fn who_releases_the_e_stop_may_leave_and_a_newer_epoch_moves() {
    let mut robot = moving();
    robot.on_event(engaged(), ms(10));
    robot.on_event(released(), ms(1_000));
    let stopped = robot.standing(ms(5_000));

    let status = robot.on_event(Event::Tick, ms(5_000)).expect("a status is due");
    robot.on_event(controller_in(2, DIGEST, ms(5_000)), ms(5_000));
    robot.on_event(lease(2, LeaseState::Armed, status.counter), ms(5_000));
    robot.on_event(lease(2, LeaseState::Running, status.counter), ms(5_000));

    assert_eq!(stopped, Some(StandReason::Latched("stopped by the e-stop".to_owned())));
    assert_eq!(robot.state(ms(5_000)), RobotState::Moving);
}

#[test]
fn a_robot_that_stands_for_another_reason_reports_that_it_has_received_the_e_stop() {
    let mut robot = moving();
    robot.on_event(Event::Tick, ms(1_600));

    let status = robot.on_event(engaged(), ms(1_610)).expect("a change is published at once");

    assert!(status.holds_e_stop(), "{status:?}");
    let status = robot.on_event(released(), ms(1_620)).expect("a change is published at once");
    assert_eq!(status.stop_reason, "lease ran out");
}

#[test]
fn a_rebooted_robot_does_not_join_a_running_lease() {
    let mut robot = robot();
    robot.on_event(controller(DIGEST, ms(0)), ms(0));

    robot.on_event(lease(1, LeaseState::Running, 0), ms(0));

    assert_eq!(robot.state(ms(0)), RobotState::Idle);
}

#[test]
fn a_refused_command_stops_the_wheels_without_a_latch() {
    let mut robot = moving();

    robot.on_event(Event::CommandRefused, ms(10));

    assert_eq!(robot.drive(ms(10)), Command::STOP);
    assert_eq!(robot.state(ms(10)), RobotState::Moving);
}

#[test]
fn a_repaired_robot_stays_out_of_the_run_in_which_it_failed() {
    let mut robot = moving();
    robot.on_event(Event::Fault("wheel".to_owned()), ms(10));
    assert_eq!(robot.state(ms(10)), RobotState::Fault);

    robot.on_event(Event::Repaired, ms(20));
    assert_eq!(robot.state(ms(20)), RobotState::Stopped);
    assert_eq!(robot.latched(), Some("hardware fault: wheel"));

    robot.on_event(lease(2, LeaseState::Armed, 1), ms(30));
    assert_eq!(robot.state(ms(30)), RobotState::Armed);
}

#[test]
fn a_robot_that_is_repaired_before_the_start_may_start() {
    let mut robot = robot();
    let status = robot.on_event(Event::Tick, ms(0)).expect("the first status is due");
    robot.on_event(Event::Fault("no microcontroller yet".to_owned()), ms(0));
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(0));
    assert_eq!(robot.state(ms(0)), RobotState::Fault);

    robot.on_event(Event::Repaired, ms(10));
    assert_eq!(robot.state(ms(10)), RobotState::Armed);

    robot.on_event(Event::Fault("no microcontroller again".to_owned()), ms(20));
    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(30));
    robot.on_event(Event::Repaired, ms(40));
    assert_eq!(robot.state(ms(40)), RobotState::Stopped);
}

#[test]
fn a_fault_outside_a_run_leaves_no_trace() {
    let mut robot = robot();
    robot.on_event(Event::Fault("no microcontroller yet".to_owned()), ms(0));
    robot.on_event(Event::Repaired, ms(10));

    assert_eq!(robot.state(ms(10)), RobotState::Idle);
    assert_eq!(robot.latched(), None);
}

#[test]
fn the_status_contains_the_battery() {
    let mut robot = robot();

    robot.on_event(Event::Battery(7.4), ms(0));

    let status = robot.on_event(Event::Tick, ms(200)).expect("a status is due");
    assert_eq!(status.battery_v.to_bits(), 7.4_f32.to_bits());
}

#[test]
fn a_word_of_its_controller_that_comes_late_or_again_confirms_nothing() {
    let mut robot = moving();
    // As in lockstep, where a lapse may heal.
    robot.options.lapse = Lapse::Freezes;
    let confirmed = controller(DIGEST, ms(100));
    robot.on_event(confirmed.clone(), ms(100));
    // It has started again, on its defaults.
    robot.on_event(controller_in(0, DIGEST + 1, ms(200)), ms(200));

    robot.on_event(confirmed, ms(300));

    assert_eq!(robot.standing(ms(300)), Some(StandReason::ControllerUnconfirmed));
}

#[test]
fn what_has_run_out_has_run_out_whatever_comes_then() {
    let mut robot = moving();
    let status = robot.on_event(Event::Tick, ms(490)).unwrap();
    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(495));

    // Its controller is late; no event came in between.
    robot.on_event(controller(DIGEST, ms(501)), ms(501));

    let unconfirmed = StandReason::ControllerUnconfirmed.to_string();
    assert_eq!(robot.latched(), Some(unconfirmed.as_str()));
}

#[test]
fn while_a_run_holds_the_robot_silence_makes_no_old_word_true() {
    let mut robot = moving();
    robot.options.lapse = Lapse::Freezes;
    robot.on_event(controller(DIGEST, ms(100)), ms(0));
    for beat in 1..8 {
        let status = robot.on_event(Event::Tick, ms(100 * beat)).unwrap();
        robot.on_event(lease(1, LeaseState::Running, status.counter), ms(100 * beat));
    }

    robot.on_event(controller(DIGEST, ms(50)), ms(700));

    assert_eq!(robot.standing(ms(700)), Some(StandReason::ControllerUnconfirmed));
}

#[test]
fn an_old_word_confirms_nothing_while_a_silent_runner_may_come_back() {
    let mut robot = robot();
    robot.options.lapse = Lapse::Freezes;
    let status = robot.on_event(Event::Tick, ms(0)).expect("the first status is due");
    robot.on_event(controller(DIGEST, ms(0)), ms(0));
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(0));
    // The robot hangs, and then everything comes at once.
    let status = robot.on_event(Event::Tick, ms(600)).expect("a status is due");

    robot.on_event(controller_in(1, DIGEST, ms(0)), ms(600));
    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(600));

    assert_eq!(robot.standing(ms(600)), Some(StandReason::ControllerUnconfirmed));
}

#[test]
fn a_run_that_was_paused_goes_on_in_its_own_world_only() {
    for is_placed_anew in [false, true] {
        let mut robot = moving();
        robot.options.lapse = Lapse::Freezes;
        robot.on_event(Event::Tick, ms(700));
        assert_eq!(robot.standing(ms(700)), Some(StandReason::LeaseLapsed));
        if is_placed_anew {
            robot.on_event(Event::WithoutWorld(false), ms(800));
        }

        let status = robot.on_event(controller(DIGEST, ms(900)), ms(900)).expect("a status is due");
        robot.on_event(lease(1, LeaseState::Running, status.counter), ms(900));

        let stands = is_placed_anew.then(|| StandReason::Latched(WORLD_REPLACED.to_owned()));
        assert_eq!(robot.standing(ms(900)), stands);
        let status = robot.on_event(Event::Tick, ms(1_000)).expect("a status is due");
        robot.on_event(lease(2, LeaseState::Armed, status.counter), ms(1_000));
        assert_eq!(robot.latched(), None, "the next run may have it");
    }
}

#[test]
fn a_robot_that_a_runner_stopped_stands_for_that_in_any_world() {
    let mut robot = moving();
    let status = robot.on_event(Event::Tick, ms(100)).expect("a status is due");
    robot.on_event(lease(1, LeaseState::Stopped, status.counter), ms(100));
    let stopped = robot.latched().map(str::to_owned);

    robot.on_event(Event::WithoutWorld(false), ms(200));

    assert!(stopped.is_some());
    assert_eq!(robot.latched().map(str::to_owned), stopped);
}

#[test]
fn a_controller_that_was_started_again_and_set_anew_is_of_no_run() {
    let mut robot = moving();
    robot.options.lapse = Lapse::Freezes;

    robot.on_event(controller_in(0, DIGEST, ms(100)), ms(100));

    assert_eq!(robot.standing(ms(100)), Some(StandReason::ControllerUnconfirmed));
}

#[test]
fn a_controller_whose_clock_was_set_back_is_received_after_a_silence_and_obeyed_in_the_next_run() {
    // It is of no run, or has joined the one that has just been stopped.
    for epoch in [0, 1] {
        let mut robot = moving();
        robot.on_event(controller(DIGEST, ms(5_000)), ms(0));
        robot.on_event(lease(1, LeaseState::Stopped, 1), ms(0));

        let again = |at| controller_in(epoch, DIGEST + 1, ms(at));
        let deaf = robot.on_event(again(1), ms(400)).unwrap();
        let reception = robot.on_event(again(2), ms(510)).unwrap();
        assert_eq!((deaf.parameter_digest, reception.parameter_digest), (DIGEST, DIGEST + 1));

        for state in [LeaseState::Armed, LeaseState::Running] {
            robot.on_event(controller_in(2, DIGEST, ms(3)), ms(520));
            robot.on_event(lease(2, state, reception.counter), ms(520));
        }
        assert_eq!(robot.standing(ms(520)), None, "after epoch {epoch}");
    }
}

#[test]
fn words_of_a_controller_that_has_died_do_not_come_to_life_before_the_robot_is_bound() {
    let mut robot = robot();
    robot.options.lapse = Lapse::Freezes;
    let before = controller_in(0, DIGEST, ms(10));
    let confirmed: Vec<_> = [100, 150].map(|at| controller(DIGEST, ms(at))).into();
    for word in [&before].into_iter().chain(&confirmed) {
        robot.on_event(word.clone(), ms(200));
    }

    // All comes again after a silence; the lease of its epoch arrives only now.
    let status = robot.on_event(before, ms(800)).expect("a status is due");
    robot.on_event(confirmed[0].clone(), ms(810));
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(820));
    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(820));
    robot.on_event(confirmed[1].clone(), ms(830));

    assert_eq!(robot.standing(ms(830)), Some(StandReason::ControllerUnconfirmed));
}

#[test]
fn an_old_word_that_was_refused_is_still_known_as_old() {
    let mut robot = robot();
    robot.options.lapse = Lapse::Freezes;
    // Of two that come late, its next process is received first, and dies, too.
    robot.on_event(controller_in(0, DIGEST, ms(500)), ms(500));
    let late = [100, 150].map(|at| controller(DIGEST, ms(at)));
    for word in &late {
        robot.on_event(word.clone(), ms(510));
    }

    let status = robot.on_event(late[0].clone(), ms(1_100)).expect("a status is due");
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(1_110));
    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(1_110));
    robot.on_event(late[1].clone(), ms(1_120));

    assert_eq!(robot.standing(ms(1_120)), Some(StandReason::ControllerUnconfirmed));
}
