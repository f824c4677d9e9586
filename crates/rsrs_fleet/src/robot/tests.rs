use super::*;
use crate::message::Echo;

const DIGEST: u64 = 7;

fn ms(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

fn robot() -> Robot {
    Robot::new(RobotOptions {
        name: "robot_1".to_owned(),
        command_timeout: ms(325),
        lapse_grace: Duration::ZERO,
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

/// A robot that moves at time 0 under epoch 1.
fn moving() -> Robot {
    let mut robot = robot();
    let status = robot.on_event(Event::Tick, ms(0)).expect("the first status is due");
    robot.on_event(Event::Controller { parameter_digest: DIGEST }, ms(0));
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(0));
    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(0));
    let forward = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };
    robot.on_event(Event::Command(forward), ms(0));
    assert_eq!(robot.drive(ms(0)), forward);
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
        robot.on_event(Event::Controller { parameter_digest: DIGEST }, ms(beat * 100));
        robot.on_event(lease(1, LeaseState::Running, 1), ms(beat * 100));
        robot.on_event(
            Event::Command(Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 }),
            ms(beat * 100),
        );
    }

    assert_ne!(robot.drive(ms(500)), Command::STOP);
    assert_eq!(robot.drive(ms(501)), Command::STOP);
}

#[test]
fn a_lapse_latches_until_a_newer_epoch_arms() {
    let mut robot = moving();
    robot.on_event(Event::Tick, ms(600));
    let counter = robot.counter;

    robot.on_event(lease(1, LeaseState::Running, counter), ms(610));
    assert_eq!(robot.state(ms(610)), RobotState::Stopped);

    robot.on_event(lease(2, LeaseState::Armed, counter), ms(620));
    assert_eq!(robot.state(ms(620)), RobotState::Armed);
}

#[test]
fn a_robot_that_hears_no_lease_any_more_is_no_longer_armed_and_may_be_again() {
    let mut robot = robot();
    robot.on_event(lease(1, LeaseState::Armed, 0), ms(0));
    assert_eq!(robot.state(ms(500)), RobotState::Armed);

    assert_eq!(robot.state(ms(501)), RobotState::Stopped);
    robot.on_event(lease(1, LeaseState::Armed, 0), ms(600));

    assert_eq!(robot.state(ms(600)), RobotState::Armed);
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

    robot.on_event(Event::Controller { parameter_digest: DIGEST + 1 }, ms(50));

    assert_eq!(robot.drive(ms(50)), Command::STOP);
    assert_eq!(robot.latched(), Some("controller silent or its parameters not the confirmed ones"));
}

#[test]
fn a_stale_command_stops_the_wheels_without_a_latch() {
    let mut robot = moving();
    let status = robot.on_event(Event::Tick, ms(300)).expect("a status is due");
    robot.on_event(Event::Controller { parameter_digest: DIGEST }, ms(300));
    robot.on_event(lease(1, LeaseState::Running, status.counter), ms(300));

    assert_eq!(robot.drive(ms(326)), Command::STOP);
    assert_eq!(robot.latched(), None);
}

#[test]
fn a_silent_e_stop_publisher_locks() {
    let mut robot = moving();
    robot.on_event(Event::EStop(false), ms(0));

    assert_ne!(robot.drive(ms(300)), Command::STOP);
    robot.on_event(lease(1, LeaseState::Running, 1), ms(400));
    assert_eq!(robot.standing(ms(501)), Some(StandReason::EStop));
}

#[test]
fn a_lock_by_silence_is_released_by_a_word_and_not_by_arming() {
    let mut robot = moving();
    robot.on_event(Event::EStop(false), ms(0));
    robot.on_event(lease(1, LeaseState::Running, 1), ms(400));
    robot.on_event(Event::Tick, ms(501));

    robot.on_event(lease(2, LeaseState::Armed, 1), ms(600));
    assert_eq!(robot.standing(ms(600)), Some(StandReason::EStop));

    robot.on_event(Event::EStop(false), ms(700));
    robot.on_event(lease(3, LeaseState::Armed, 1), ms(800));
    assert_eq!(robot.state(ms(800)), RobotState::Armed);
}

#[test]
fn a_release_does_not_lock_a_robot_whose_runner_died_before_the_start() {
    let mut robot = robot();
    robot.on_event(lease(1, LeaseState::Armed, 0), ms(0));

    robot.on_event(Event::EStop(false), ms(5_000));

    robot.on_event(Event::Tick, ms(6_000));
    assert_eq!(robot.standing(ms(6_000)), Some(StandReason::LeaseLapsed));
}

#[test]
fn who_engages_the_e_stop_may_leave_and_the_robot_still_stands() {
    let mut robot = moving();
    robot.on_event(Event::EStop(true), ms(10));

    robot.on_event(lease(2, LeaseState::Armed, 1), ms(60_000));

    assert_eq!(robot.standing(ms(60_000)), Some(StandReason::EStop));
}

#[test]
fn who_releases_the_e_stop_may_leave_and_a_newer_epoch_moves() {
    let mut robot = moving();
    robot.on_event(Event::EStop(true), ms(10));
    robot.on_event(Event::EStop(false), ms(1_000));
    let stopped = robot.standing(ms(5_000));

    let status = robot.on_event(Event::Tick, ms(5_000)).expect("a status is due");
    robot.on_event(Event::Controller { parameter_digest: DIGEST }, ms(5_000));
    robot.on_event(lease(2, LeaseState::Armed, status.counter), ms(5_000));
    robot.on_event(lease(2, LeaseState::Running, status.counter), ms(5_000));

    assert_eq!(stopped, Some(StandReason::Latched("stopped by the e-stop".to_owned())));
    assert_eq!(robot.state(ms(5_000)), RobotState::Moving);
}

#[test]
fn a_robot_that_stands_for_another_reason_says_that_it_has_heard_the_e_stop() {
    let mut robot = moving();
    robot.on_event(Event::Tick, ms(600));

    let status = robot.on_event(Event::EStop(true), ms(700)).expect("a status is due");

    assert!(status.holds_e_stop(), "{status:?}");
    let status = robot.on_event(Event::EStop(false), ms(800)).expect("a status is due");
    assert_eq!(status.stop_reason, "lease ran out");
}

#[test]
fn a_rebooted_robot_does_not_join_a_running_lease() {
    let mut robot = robot();
    robot.on_event(Event::Controller { parameter_digest: DIGEST }, ms(0));

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
fn the_status_tells_the_battery() {
    let mut robot = robot();

    robot.on_event(Event::Battery(7.4), ms(0));

    let status = robot.on_event(Event::Tick, ms(200)).expect("a status is due");
    assert_eq!(status.battery_v.to_bits(), 7.4_f32.to_bits());
}
