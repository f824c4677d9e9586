use std::sync::atomic::{AtomicU64, Ordering};

use super::*;
use crate::message::{self, StopCause};

fn ms(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

fn status(state: RobotState, stop_cause: StopCause) -> Status {
    // Each is newer than all before it.
    static COUNTER: AtomicU64 = AtomicU64::new(1);
    let counter = COUNTER.fetch_add(1, Ordering::Relaxed);
    // Nothing is decided by it.
    let stop_reason = "e-stop, or anything else".to_owned();
    Status { counter, stop_reason, ..message::tests::status(state, stop_cause) }
}

fn received(robot: &str, state: RobotState, stop_cause: StopCause) -> Event {
    Event::Status { robot: robot.to_owned(), status: status(state, stop_cause) }
}

fn found(robot: &str) -> Event {
    Event::Discovered { robot: robot.to_owned() }
}

#[test]
fn the_first_message_is_published_at_once_and_then_ten_times_a_second() {
    let mut stopper = Stopper::new(StopCommand::Engage);

    let times: Vec<_> = (0..30)
        .map(|tick| 10 * tick)
        .filter(|at| stopper.on_event(Event::Tick, ms(*at)) == [Action::Publish(true)])
        .collect();

    assert_eq!(times, [0, 100, 200]);
}

#[test]
fn it_ends_when_every_robot_stands_and_none_turns_up_any_more() {
    // In a secured fleet robots have more time to turn up.
    for (transport, ends_ms) in [(Transport::Plain, 2_000), (Transport::Secured, 5_000)] {
        let mut stopper = Stopper::new(StopCommand::Engage).over(transport);
        assert_eq!(stopper.on_event(Event::Tick, ms(0)), [Action::Publish(true)]);
        stopper.on_event(received("robot_1", RobotState::Stopped, StopCause::EStop), ms(40));

        assert!(!stopper.on_event(Event::Tick, ms(ends_ms - 1)).contains(&finished()));
        assert!(stopper.on_event(Event::Tick, ms(ends_ms)).contains(&finished()));
        assert_eq!(stopper.answers()[0].acknowledged_after, Some(ms(40)));
    }
}

fn finished() -> Action {
    Action::Finish(StopOutcome::Acknowledged)
}

#[test]
fn a_robot_that_stands_for_another_reason_has_not_acknowledged() {
    for (state, cause) in [
        (RobotState::Idle, StopCause::NoRun),
        (RobotState::Armed, StopCause::Waiting),
        (RobotState::Moving, StopCause::None),
        (RobotState::Stopped, StopCause::Lease),
        (RobotState::Fault, StopCause::Hardware),
    ] {
        let mut stopper = Stopper::new(StopCommand::Engage);
        stopper.on_event(Event::Tick, ms(0));

        stopper.on_event(received("robot_1", state, cause), ms(50));

        assert_eq!(stopper.answers()[0].acknowledged_after, None, "{state}");
    }
}

#[test]
fn who_is_expected_and_silent_is_named_after_a_bounded_time() {
    let mut stopper = Stopper::new(StopCommand::Engage);
    stopper.on_event(found("robot_9"), ms(0));
    stopper.on_event(received("robot_1", RobotState::Fault, StopCause::EStop), ms(50));

    let end = stopper.on_event(Event::Tick, ms(7_000));

    assert!(end.contains(&Action::Finish(StopOutcome::TimedOut)), "{end:?}");
    let silent: Vec<_> = stopper
        .answers()
        .into_iter()
        .filter(|answer| answer.acknowledged_after.is_none())
        .map(|answer| answer.robot)
        .collect();
    assert_eq!(silent, ["robot_9"]);
}

#[test]
fn an_acknowledgement_that_comes_late_or_again_is_none() {
    let mut stopper = Stopper::new(StopCommand::Engage);
    stopper.on_event(Event::Tick, ms(0));
    let earlier = received("a", RobotState::Stopped, StopCause::EStop);
    stopper.on_event(received("a", RobotState::Moving, StopCause::None), ms(10));

    stopper.on_event(earlier, ms(20));

    assert_eq!(stopper.answers()[0].acknowledged_after, None);
}

#[test]
fn no_robot_at_all_is_no_acknowledgement() {
    let mut stopper = Stopper::new(StopCommand::Engage);
    stopper.on_event(Event::Tick, ms(0));

    let end = stopper.on_event(Event::Tick, ms(7_000));

    assert!(end.contains(&Action::Finish(StopOutcome::TimedOut)), "{end:?}");
}

#[test]
fn a_robot_that_is_released_by_someone_else_has_no_longer_acknowledged() {
    let mut stopper = Stopper::new(StopCommand::Engage);
    stopper.on_event(Event::Tick, ms(0));
    stopper.on_event(received("robot_1", RobotState::Stopped, StopCause::EStop), ms(50));

    stopper.on_event(received("robot_1", RobotState::Stopped, StopCause::Latched), ms(90));

    assert_eq!(stopper.answers()[0].acknowledged_after, None);
}

#[test]
fn a_release_looks_first_and_ends_when_no_robot_is_locked() {
    let mut stopper = Stopper::new(StopCommand::Release);
    let locked = || received("robot_1", RobotState::Stopped, StopCause::EStop);
    assert_eq!(stopper.on_event(locked(), ms(0)), []);

    assert_eq!(stopper.on_event(locked(), ms(2_000)), [Action::Publish(false)]);
    let end =
        stopper.on_event(received("robot_1", RobotState::Stopped, StopCause::Lease), ms(2_050));

    assert_eq!(end, [finished()]);
}

#[test]
fn a_release_among_moving_robots_publishes_nothing() {
    let mut stopper = Stopper::new(StopCommand::Release);
    stopper.on_event(received("robot_1", RobotState::Moving, StopCause::None), ms(0));

    assert_eq!(stopper.on_event(Event::Tick, ms(2_000)), [Action::Finish(StopOutcome::InRun)]);
}

const LEFT: Source = Source([1; 16]);
const THERE: Source = Source([2; 16]);
const REPORTER: Source = Source([9; 16]);

fn locked_by(sources: &[(Source, LockCause)]) -> Event {
    let locks = Locks(sources.iter().copied().collect());
    Event::EStop(Message::Locks { reporter: REPORTER, locks })
}

#[test]
fn a_release_ends_the_locks_of_who_has_left_and_names_who_still_holds() {
    let mut stopper = Stopper::new(StopCommand::Release);
    stopper.on_event(received("robot_1", RobotState::Stopped, StopCause::EStop), ms(0));
    stopper.on_event(locked_by(&[(LEFT, LockCause::Engaged), (THERE, LockCause::Engaged)]), ms(0));
    stopper.on_event(Event::Publishers([THERE].into()), ms(0));

    let actions = stopper.on_event(Event::Tick, ms(2_000));
    assert_eq!(actions, [Action::Publish(false), Action::Release([LEFT].into())]);
    assert_eq!(stopper.holding(ms(2_000)), Locks([(THERE, LockCause::Engaged)].into()));

    // It goes.
    stopper.on_event(locked_by(&[(THERE, LockCause::Engaged)]), ms(2_010));
    stopper.on_event(Event::Publishers(BTreeSet::new()), ms(2_020));
    let actions = stopper.on_event(Event::Tick, ms(2_100));
    assert_eq!(actions, [Action::Publish(false), Action::Release([THERE].into())]);
}

#[test]
fn a_source_that_fell_silent_is_released_and_one_that_publishes_true_is_not() {
    let mut stopper = Stopper::new(StopCommand::Release);
    stopper.on_event(locked_by(&[(LEFT, LockCause::Engaged), (THERE, LockCause::Silent)]), ms(0));
    stopper.on_event(Event::Publishers([THERE].into()), ms(0));
    stopper.on_event(Event::EStop(Message::State { source: LEFT, engaged: true }), ms(1_500));

    let actions = stopper.on_event(Event::Tick, ms(2_000));

    assert_eq!(actions, [Action::Publish(false), Action::Release([THERE].into())]);
    assert_eq!(stopper.holding(ms(2_000)), Locks([(LEFT, LockCause::Engaged)].into()));
}

#[test]
fn any_number_of_names_is_followed_up_to_a_bound() {
    let mut stopper = Stopper::new(StopCommand::Engage);
    stopper.on_event(found("robot_1"), ms(0));

    for name in 0..5_000 {
        stopper.on_event(found(&format!("nobody_{name}")), ms(0));
    }

    assert_eq!(stopper.answers().len(), MOST_ROBOTS);
    assert!(stopper.follows("robot_1") && !stopper.follows("robot_2"));
}
