//! The e-stop of several sources, and epochs that no runner made.

use super::*;

#[test]
fn a_source_that_publishes_false_all_the_time_undoes_no_stop_of_another() {
    let mut robot = moving();
    let stop = Source([2; 16]);
    robot.on_event(released(), ms(0));
    robot.on_event(Event::EStop(Message::State { source: stop, engaged: true }), ms(10));

    for beat in 1..100 {
        let status = robot.on_event(released(), ms(100 * beat));
        assert!(status.is_none_or(|status| status.holds_e_stop()));
    }

    assert_eq!(robot.locks(), Locks([(stop, LockCause::Engaged)].into()));
    robot.on_event(Event::EStop(Message::Release([BUTTON].into())), ms(10_000));
    assert_eq!(robot.standing(ms(10_000)), Some(StandReason::EStop), "another one was released");
    robot.on_event(Event::EStop(Message::Release([stop].into())), ms(10_000));
    assert_ne!(robot.standing(ms(10_000)), Some(StandReason::EStop));
}

#[test]
fn of_two_sources_each_locks_by_its_silence() {
    let mut robot = moving();
    let other = Source([2; 16]);
    robot.on_event(released(), ms(0));
    for beat in 1..8 {
        robot.on_event(controller(DIGEST, ms(beat * 100)), ms(beat * 100));
        let status = robot.on_event(
            Event::EStop(Message::State { source: other, engaged: false }),
            ms(beat * 100),
        );
        let counter = status.map_or(robot.beat.counter(), |status| status.counter);
        robot.on_event(lease(1, LeaseState::Running, counter), ms(beat * 100));
    }

    assert_eq!(robot.locks(), Locks([(BUTTON, LockCause::Silent)].into()));
}

#[test]
fn a_robot_that_was_started_again_asks_before_it_belongs_to_a_run() {
    let mut robot = robot().of_a_new_process();
    let status = robot.on_event(Event::Tick, ms(0)).unwrap();
    assert_eq!((status.state, status.holds_e_stop()), (RobotState::Idle, false));
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(100));
    assert_eq!(robot.epoch(), 0, "it has not asked yet");

    let locks = Locks([(BUTTON, LockCause::Engaged)].into());
    let status = robot
        .on_event(
            Event::EStop(Message::Locks { reporter: BUTTON, locks: locks.clone() }),
            ms(1_000),
        )
        .unwrap();
    assert!(status.holds_e_stop(), "{status:?}");

    let status = robot.on_event(Event::Tick, ms(3_000)).unwrap();
    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(3_000));
    assert_eq!(robot.standing(ms(3_000)), Some(StandReason::EStop));
    assert_eq!(robot.locks(), locks, "it answers others");
    robot.on_event(released(), ms(3_010));
    robot.on_event(Event::EStop(Message::Locks { reporter: BUTTON, locks }), ms(3_020));
    assert_ne!(robot.standing(ms(3_020)), Some(StandReason::EStop), "what is late is ignored");
}

#[test]
fn an_epoch_that_no_runner_made_binds_nobody() {
    let mut robot = robot();
    let status = robot.on_event(Event::Tick, ms(0)).unwrap();

    robot.on_event(lease(u64::MAX, LeaseState::Armed, status.counter), ms(0));
    assert_eq!(robot.epoch(), 0);
    let refused = robot.refused_epoch().expect("it reports it");
    assert_eq!((refused.found, refused.highest), (u64::MAX, 0));

    robot.on_event(lease(1, LeaseState::Armed, status.counter), ms(0));
    assert_eq!(robot.epoch(), 1);
}

#[test]
fn a_robot_in_fault_reports_that_the_e_stop_holds_it_too() {
    let mut robot = moving();
    robot.on_event(Event::Fault("wheel".to_owned()), ms(10));

    let status = robot.on_event(engaged(), ms(200)).expect("a status is due");

    assert_eq!(status.stop_reason, "e-stop; hardware fault: wheel");
    assert!(status.holds_e_stop() && status.state == RobotState::Fault);
}

#[test]
fn a_robot_without_a_world_reports_it_from_the_beginning() {
    let mut robot = robot().of_a_new_process();

    robot.on_event(Event::WithoutWorld(true), ms(0));

    let status = robot.on_event(Event::Tick, ms(100)).expect("a status is due");
    assert!(status.is_without_world(), "{status:?}");
    robot.on_event(Event::WithoutWorld(false), ms(100));
    assert_eq!(robot.standing(ms(100)), Some(StandReason::Asking));
    assert_eq!(robot.standing(ms(2_000)), Some(StandReason::Idle));
}
