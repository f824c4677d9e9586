use super::*;
use crate::timing::HEARTBEAT_PERIOD;

mod manual;

const FORWARD: Command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };
const DIGEST: u64 = 42;
const PERIOD: Duration = Duration::from_millis(130);

const MOVING: Gate = Gate { state: RobotState::Moving, drive: FORWARD, is_in_run: true };
const ARMED: Gate = Gate { state: RobotState::Armed, drive: Command::STOP, is_in_run: true };
const STOPPED: Gate = Gate { state: RobotState::Stopped, drive: Command::STOP, is_in_run: false };

fn ms(time: u64) -> Duration {
    Duration::from_millis(time)
}

fn command(robot: usize, stamp_ns: Option<u64>) -> Event {
    Event::Command { robot, stamp_ns, command: FORWARD }
}

/// `robot_1` and on.
fn names(n_robots: usize) -> Vec<String> {
    (1..=n_robots).map(|number| format!("robot_{number}")).collect()
}

/// A world in lockstep with a period of 130 ns.
fn placed(n_robots: usize, steps: u64) -> Placed {
    Placed {
        digest: DIGEST,
        robots: names(n_robots),
        steps,
        period_ns: 130,
        time: Time::Lockstep,
        gates: Gates::Here,
    }
}

fn placed_in_real_time(n_robots: usize) -> Placed {
    let period_ns = u64::try_from(PERIOD.as_nanos()).unwrap();
    Placed { period_ns, time: Time::RealTime, ..placed(n_robots, 1) }
}

fn with(placed: Placed) -> Simulator {
    let mut simulator = Simulator::new();
    simulator.on_event(Event::Placed(placed), Duration::ZERO);
    simulator
}

fn lockstep(n_robots: usize, steps: u64) -> Simulator {
    with(placed(n_robots, steps))
}

fn real_time(n_robots: usize) -> Simulator {
    with(placed_in_real_time(n_robots))
}

/// Sends an event, and leaves the statuses out of what follows.
fn pace(simulator: &mut Simulator, event: Event, now: Duration) -> Vec<Action> {
    let mut actions = simulator.on_event(event, now);
    actions.retain(|action| !matches!(action, Action::Status(_)));
    actions
}

/// Sends an event, and returns the status that follows, if one does.
fn status(simulator: &mut Simulator, event: Event, now: Duration) -> Option<Status> {
    simulator.on_event(event, now).into_iter().find_map(|action| match action {
        Action::Status(status) => Some(status),
        _ => None,
    })
}

fn reported(status: Option<Status>) -> (RobotState, u64, String) {
    let status = status.expect("a change is published at once");
    (status.state, status.parameter_digest, status.stop_reason)
}

#[test]
fn the_world_steps_when_every_robot_has_answered_once() {
    let mut simulator = lockstep(2, 2);

    let start = pace(&mut simulator, Event::Gates(vec![MOVING; 2]), Duration::ZERO);
    let one = pace(&mut simulator, command(1, Some(130)), Duration::ZERO);
    let both = pace(&mut simulator, command(0, Some(130)), Duration::ZERO);

    assert_eq!(start, [Action::Sense { step: 1, stamp_ns: Some(130) }]);
    assert_eq!(one, []);
    let next = Action::Sense { step: 2, stamp_ns: Some(260) };
    assert_eq!(both, [Action::Advance { commands: vec![FORWARD; 2] }, next]);
}

#[test]
fn in_lockstep_one_robot_that_may_not_move_holds_all() {
    let mut simulator = lockstep(2, 2);

    assert_eq!(pace(&mut simulator, Event::Gates(vec![MOVING, ARMED]), Duration::ZERO), []);
}

#[test]
fn a_command_that_is_unstamped_late_or_a_second_one_is_refused() {
    let mut simulator = lockstep(2, 2);
    pace(&mut simulator, Event::Gates(vec![MOVING; 2]), Duration::ZERO);

    let mut refusal = |event| pace(&mut simulator, event, Duration::ZERO);

    assert_eq!(
        refusal(command(0, None)),
        [Action::Refuse { robot: 0, reason: Refusal::Unstamped }]
    );
    let reason = Refusal::OtherStep { found_ns: 0, expected_ns: 130 };
    assert_eq!(refusal(command(0, Some(0))), [Action::Refuse { robot: 0, reason }]);
    assert_eq!(refusal(command(0, Some(130))), []);
    assert_eq!(
        refusal(command(0, Some(130))),
        [Action::Refuse { robot: 0, reason: Refusal::Second }]
    );
}

#[test]
fn a_robot_that_is_not_placed_does_not_answer_for_one_that_is() {
    for mut simulator in [lockstep(1, 2), real_time(1)] {
        pace(&mut simulator, Event::Gates(vec![MOVING]), Duration::ZERO);

        let actions = pace(&mut simulator, command(1, Some(130)), Duration::ZERO);

        let reason = Refusal::NotPlaced { n_robots: 1 };
        assert_eq!(actions, [Action::Refuse { robot: 1, reason }]);
    }
}

#[test]
fn a_command_that_single_precision_cannot_follow_is_refused_at_any_pace() {
    for speed_m_s in [1e300, -1e4, f64::NAN, f64::INFINITY] {
        let command = Command { speed_m_s, turn_rate_rad_s: 0.0 };
        for mut simulator in [lockstep(1, 2), real_time(1)] {
            pace(&mut simulator, Event::Gates(vec![MOVING]), Duration::ZERO);

            let event = Event::Command { robot: 0, stamp_ns: Some(130), command };
            let actions = pace(&mut simulator, event, Duration::ZERO);

            let refused = matches!(
                actions[..],
                [Action::Refuse { robot: 0, reason: Refusal::TooGreat { .. } }]
            );
            assert!(refused, "{actions:?}");
        }
    }
}

#[test]
fn the_world_waits_for_a_recorder_that_is_too_far_behind() {
    let mut simulator = lockstep(1, 100);
    pace(&mut simulator, Event::Gates(vec![MOVING]), Duration::ZERO);
    for step in 1..=RECORDER_WINDOW {
        pace(&mut simulator, command(0, Some(step * 130)), Duration::ZERO);
    }

    assert_eq!(simulator.step(), RECORDER_WINDOW);
    pace(&mut simulator, Event::Recorded { step: 1 }, Duration::ZERO);
    assert_eq!(simulator.step(), RECORDER_WINDOW + 1);
}

#[test]
fn a_recorder_cannot_have_taken_what_was_not_sensed() {
    let mut simulator = lockstep(1, 100);
    pace(&mut simulator, Event::Recorded { step: u64::MAX }, Duration::ZERO);
    pace(&mut simulator, Event::Gates(vec![MOVING]), Duration::ZERO);

    for step in 1..=RECORDER_WINDOW {
        pace(&mut simulator, command(0, Some(step * 130)), Duration::ZERO);
    }

    assert_eq!(simulator.step(), RECORDER_WINDOW);
}

#[test]
fn a_freeze_that_lasts_voids_the_run() {
    let mut simulator = lockstep(1, 100);
    pace(&mut simulator, Event::Gates(vec![MOVING]), Duration::ZERO);
    pace(&mut simulator, Event::Gates(vec![STOPPED]), ms(1000));

    assert_eq!(pace(&mut simulator, Event::Gates(vec![STOPPED]), ms(5900)), []);
    let end = simulator.on_event(Event::Gates(vec![STOPPED]), ms(6000));

    let reason = "frozen for 5 s at step 1 of 100".to_owned();
    assert_eq!(end[0], Action::Void { reason: reason.clone() });
    let [_, Action::Status(status)] = &end[..] else { panic!("{end:?}") };
    assert_eq!(reported(Some(status.clone())), (RobotState::Fault, DIGEST, reason));
}

#[test]
fn the_last_step_completes_the_run() {
    let mut simulator = lockstep(1, 1);
    pace(&mut simulator, Event::Gates(vec![MOVING]), Duration::ZERO);

    let end = simulator.on_event(command(0, Some(130)), Duration::ZERO);

    let reason = "all steps are made";
    assert_eq!(
        end[..2],
        [Action::Advance { commands: vec![FORWARD] }, Action::Complete { reason }]
    );
    let [_, _, Action::Status(status)] = &end[..] else { panic!("{end:?}") };
    let word = (RobotState::Stopped, DIGEST, reason.to_owned());
    assert_eq!(reported(Some(status.clone())), word);
}

#[test]
fn a_run_of_no_steps_senses_nothing() {
    let mut simulator = lockstep(1, 0);

    let end = pace(&mut simulator, Event::Gates(vec![MOVING]), Duration::ZERO);

    assert_eq!(end, [Action::Complete { reason: "all steps are made" }]);
}

#[test]
fn the_status_distinguishes_an_empty_simulator_from_a_placed_a_moving_and_a_failed_one() {
    let mut simulator = Simulator::new();
    let empty = status(&mut simulator, Event::Removed, Duration::ZERO);
    let reason = "they do not fit".to_owned();
    let refused = status(&mut simulator, Event::NotPlaced { reason: reason.clone() }, ms(1));
    let mut simulator = lockstep(1, 1);
    let again = status(&mut simulator, Event::Gates(vec![ARMED]), Duration::ZERO);
    let moving = status(&mut simulator, Event::Gates(vec![MOVING]), Duration::ZERO);

    assert_eq!(reported(empty), (RobotState::Idle, 0, "no world is placed".to_owned()));
    assert_eq!(reported(refused), (RobotState::Fault, 0, reason));
    assert_eq!(again, None, "it was published when the world was placed");
    assert_eq!(reported(moving), (RobotState::Moving, DIGEST, String::new()));
}

#[test]
fn a_world_that_is_placed_is_published_at_once_and_so_are_another_one_and_the_same_anew() {
    let placed = placed(1, 1);
    let mut simulator = Simulator::new();
    simulator.on_event(Event::Removed, Duration::ZERO);

    let first = status(&mut simulator, Event::Placed(placed.clone()), Duration::ZERO);
    let other = Event::Placed(Placed { digest: DIGEST + 1, ..placed });
    let second = status(&mut simulator, other.clone(), Duration::ZERO);
    let twice = status(&mut simulator, other.clone(), Duration::ZERO);
    simulator.on_event(Event::Gates(vec![MOVING]), Duration::ZERO);
    let anew = status(&mut simulator, other, Duration::ZERO);
    let numbers = [&first, &second, &anew].map(|status| Some(status.as_ref()?.epoch));

    let waiting = "placed, waiting for the start".to_owned();
    assert_eq!(reported(first), (RobotState::Armed, DIGEST, waiting.clone()));
    assert_eq!(reported(second), (RobotState::Armed, DIGEST + 1, waiting));
    assert_eq!(twice, None, "it was there, and untouched");
    assert_eq!(numbers, [1, 2, 3].map(Some));
}

#[test]
fn the_status_is_repeated_twenty_times_a_second_and_counted() {
    let mut simulator = lockstep(1, 1);
    let idle = || Event::Gates(vec![ARMED]);

    assert_eq!(status(&mut simulator, idle(), ms(49)), None);
    let second = status(&mut simulator, idle(), HEARTBEAT_PERIOD).expect("a beat has passed");
    assert_eq!(status(&mut simulator, idle(), ms(99)), None);
    let third = status(&mut simulator, idle(), HEARTBEAT_PERIOD * 2).expect("a beat has passed");

    assert_eq!((second.counter, third.counter), (2, 3));
    assert_eq!((second.epoch, second.battery_v.is_nan()), (1, true), "it is its first world");
}

#[test]
fn a_fleet_all_of_which_stands_for_a_moment_has_not_ended_its_run() {
    let mut simulator = real_time(2);
    let paused = Gate { is_in_run: true, ..STOPPED };
    status(&mut simulator, Event::Gates(vec![MOVING; 2]), ms(1));

    let all_pause = status(&mut simulator, Event::Gates(vec![paused; 2]), ms(2));
    let end = status(&mut simulator, Event::Gates(vec![STOPPED; 2]), ms(3));

    assert_eq!(all_pause, None, "nothing has changed");
    assert_eq!(end.map(|status| status.state), Some(RobotState::Stopped));
}

#[test]
fn in_real_time_sensors_work_before_the_start_and_the_world_stands() {
    let mut simulator = real_time(2);

    for period in 0..3 {
        let now = PERIOD * period;
        assert_eq!(simulator.due(), Some(now));
        let actions = pace(&mut simulator, Event::Gates(vec![ARMED; 2]), now);
        assert_eq!(actions, [Action::Sense { step: 1, stamp_ns: None }]);
        assert_eq!(pace(&mut simulator, Event::Gates(vec![ARMED; 2]), now + ms(129)), []);
    }
}

#[test]
fn in_real_time_each_robot_does_what_its_gate_lets_through() {
    let mut simulator = real_time(2);
    pace(&mut simulator, Event::Gates(vec![ARMED; 2]), Duration::ZERO);

    let actions = pace(&mut simulator, Event::Gates(vec![MOVING, STOPPED]), PERIOD);

    let commands = vec![FORWARD, Command::STOP];
    let sense = Action::Sense { step: 2, stamp_ns: None };
    assert_eq!(actions, [Action::Advance { commands }, sense]);
}

#[test]
fn in_real_time_a_command_goes_to_the_robots_gate_stamped_or_not() {
    let mut simulator = real_time(1);

    for stamp_ns in [None, Some(7)] {
        let actions = pace(&mut simulator, command(0, stamp_ns), Duration::ZERO);

        assert_eq!(actions, [Action::Obey { robot: 0, command: FORWARD }]);
    }
}

#[test]
fn a_late_tick_makes_one_step_and_counts_the_periods_left_out() {
    let mut simulator = real_time(1);
    let tick = |simulator: &mut Simulator, now| {
        let actions = pace(simulator, Event::Gates(vec![MOVING]), now);
        let steps = actions.iter().filter(|action| matches!(action, Action::Advance { .. }));
        let missed = actions.iter().find_map(|action| match action {
            Action::Overrun { missed } => Some(*missed),
            _ => None,
        });
        (steps.count(), missed)
    };
    tick(&mut simulator, Duration::ZERO);

    assert_eq!(tick(&mut simulator, PERIOD + ms(20)), (1, None), "late, but none is left out");
    assert_eq!(simulator.due(), Some(PERIOD * 2), "lateness does not add up");
    assert_eq!(tick(&mut simulator, PERIOD * 5 + ms(1)), (1, Some(3)));
    assert_eq!(simulator.due(), Some(PERIOD * 6));
    assert_eq!(tick(&mut simulator, PERIOD * 7), (1, None), "it has warned in this second");
    assert_eq!(tick(&mut simulator, PERIOD * 20), (1, Some(16)));
}

#[test]
fn in_real_time_the_run_is_over_when_no_robot_can_move_any_more() {
    let mut simulator = real_time(2);
    pace(&mut simulator, Event::Gates(vec![ARMED; 2]), Duration::ZERO);
    let moving = status(&mut simulator, Event::Gates(vec![MOVING, ARMED]), ms(1));
    let one = status(&mut simulator, Event::Gates(vec![STOPPED, MOVING]), ms(2));
    let all = status(&mut simulator, Event::Gates(vec![STOPPED; 2]), ms(3));

    assert_eq!(reported(moving), (RobotState::Moving, DIGEST, String::new()));
    assert_eq!(one, None);
    assert_eq!(reported(all), (RobotState::Stopped, DIGEST, "every robot has stopped".to_owned()));
    // Sensors work on, but the world stands until it is placed again.
    let look = [Action::Sense { step: 1, stamp_ns: None }];
    assert_eq!(pace(&mut simulator, Event::Gates(vec![MOVING; 2]), PERIOD), look);
}

#[test]
fn a_lockstep_run_in_which_a_command_is_lost_is_void_and_names_who_owes_it() {
    let mut simulator = lockstep(2, 5);
    pace(&mut simulator, Event::Gates(vec![MOVING; 2]), ms(0));
    pace(&mut simulator, command(0, Some(130)), ms(1));
    pace(&mut simulator, command(1, Some(7)), ms(2));

    assert_eq!(pace(&mut simulator, Event::Gates(vec![MOVING; 2]), ms(29_999)), []);
    let end = pace(&mut simulator, Event::Gates(vec![MOVING; 2]), ms(30_000));

    let reason = "no step for 30 s at step 1 of 5: no command from robot_2 (command stamped 7 ns, \
                  expected 130 ns)";
    assert_eq!(end, [Action::Void { reason: reason.to_owned() }]);
    assert_eq!(simulator.step(), 1, "it never steps with an invented command");
}

#[test]
fn a_lockstep_run_whose_recorder_is_not_received_any_more_is_void_with_that_reason() {
    let mut simulator = lockstep(1, 50);
    let mut now = ms(0);
    pace(&mut simulator, Event::Gates(vec![MOVING]), now);
    for step in 1..=20 {
        now += ms(10);
        pace(&mut simulator, command(0, Some(130 * step)), now);
    }

    let end = pace(&mut simulator, Event::Gates(vec![MOVING]), now + ms(30_000));

    let reason = "no step for 30 s at step 20 of 50: the recorder has confirmed step 0, expected at \
                  least 1";
    assert_eq!(end, [Action::Void { reason: reason.to_owned() }]);
}

#[test]
fn a_confirmation_that_comes_again_lets_a_lockstep_run_go_on() {
    let mut simulator = lockstep(1, 50);
    pace(&mut simulator, Event::Gates(vec![MOVING]), ms(0));
    for step in 1..=20 {
        pace(&mut simulator, command(0, Some(130 * step)), ms(10));
    }

    let next = pace(&mut simulator, Event::Recorded { step: 20 }, ms(29_000));

    assert_eq!(next, [Action::Sense { step: 21, stamp_ns: Some(130 * 21) }]);
    assert_eq!(pace(&mut simulator, Event::Gates(vec![MOVING]), ms(58_000)), []);
}

#[test]
fn robots_with_gates_of_their_own_may_stand_and_move_again() {
    let mut simulator = with(Placed { gates: Gates::Elsewhere, ..placed_in_real_time(1) });
    pace(&mut simulator, Event::Gates(vec![MOVING]), Duration::ZERO);

    let stands = pace(&mut simulator, Event::Gates(vec![STOPPED]), PERIOD);
    let moves = pace(&mut simulator, Event::Gates(vec![MOVING]), PERIOD * 2);

    assert!(!stands.iter().any(|action| matches!(action, Action::Complete { .. })), "{stands:?}");
    assert!(moves.contains(&Action::Advance { commands: vec![FORWARD] }), "{moves:?}");
}
