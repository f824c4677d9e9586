use super::*;

const IDLE: Gate = Gate { state: RobotState::Idle, drive: Command::STOP };

fn gates(simulator: &mut Simulator, now: Duration) -> Vec<Action> {
    pace(simulator, Event::Gates(vec![IDLE]), now)
}

fn sense(step: u64) -> Action {
    Action::Sense { step, stamp_ns: Some(step * 130) }
}

#[test]
fn a_paused_world_makes_as_many_steps_as_are_asked_for() {
    let mut simulator = lockstep(1, 9);
    assert_eq!(simulator.doing(), Doing::AtTheStart);
    let step = Hand::Step { steps: 2 };
    assert_eq!(simulator.by_hand(step, ms(0)), Err(HandRefusal::NotPaused));
    simulator.by_hand(Hand::Pause, ms(0)).unwrap();
    assert_eq!(gates(&mut simulator, ms(1)), []);

    simulator.by_hand(step, ms(1)).unwrap();

    assert_eq!(simulator.due(), Some(Duration::ZERO));
    assert_eq!(gates(&mut simulator, ms(1)), [Action::AdvanceFreely, sense(2)]);
    assert_eq!(simulator.by_hand(step, ms(1)), Err(HandRefusal::NotPaused));
    let last = [Action::AdvanceFreely, sense(3), Action::Stepped { left: 0 }];
    assert_eq!(gates(&mut simulator, ms(1)), last);
    assert_eq!(gates(&mut simulator, ms(1)), []);
    assert_eq!((simulator.doing(), simulator.due()), (Doing::Standing, None));
}

#[test]
fn a_world_that_plays_makes_a_step_each_period_and_none_while_it_is_paused() {
    let mut simulator = real_time(1);
    simulator.by_hand(Hand::Play, ms(0)).unwrap();

    let steps = |simulator: &mut Simulator, now| {
        gates(simulator, now).iter().filter(|action| **action == Action::AdvanceFreely).count()
    };

    assert_eq!(simulator.doing(), Doing::Playing);
    assert_eq!(steps(&mut simulator, ms(0)), 1);
    assert_eq!(steps(&mut simulator, ms(100)), 0);
    assert_eq!(steps(&mut simulator, ms(130)), 1);
    simulator.by_hand(Hand::Pause, ms(140)).unwrap();
    assert_eq!(steps(&mut simulator, ms(500)), 0);
}

#[test]
fn a_world_that_a_hand_has_moved_is_no_runs_until_it_is_placed_anew() {
    for hand in [Hand::Play, Hand::Pause, Hand::Touch] {
        let mut simulator = lockstep(1, 9);

        let actions = simulator.by_hand(hand, ms(0)).unwrap();

        let is_nameless = |action: &Action| {
            matches!(action, Action::Status(status)
                if status.parameter_digest == 0 && status.state == RobotState::Idle)
        };
        assert!(actions.iter().any(is_nameless), "{hand:?}: {actions:?}");
        // Even if a runner arms and starts it.
        assert_eq!(pace(&mut simulator, Event::Gates(vec![MOVING]), ms(1)), []);
        assert_eq!(simulator.doing(), Doing::Standing);
        assert_eq!(simulator.by_hand(hand, ms(1)), Err(HandRefusal::Held));
    }
}

#[test]
fn no_hand_moves_a_world_that_a_run_holds() {
    for gate in [ARMED, MOVING] {
        for mut simulator in [lockstep(1, 9), real_time(1)] {
            simulator.on_event(Event::Gates(vec![gate]), ms(0));

            for hand in [Hand::Play, Hand::Pause, Hand::Touch, Hand::Step { steps: 1 }] {
                assert_eq!(simulator.by_hand(hand, ms(0)), Err(HandRefusal::Held));
            }
        }
    }
    assert_eq!(Simulator::new().by_hand(Hand::Play, ms(0)), Err(HandRefusal::NoWorld));
}

#[test]
fn a_run_that_takes_the_robots_ends_the_steps_of_a_hand() {
    let mut simulator = lockstep(1, 9);
    simulator.by_hand(Hand::Pause, ms(0)).unwrap();
    simulator.by_hand(Hand::Step { steps: 5 }, ms(0)).unwrap();
    gates(&mut simulator, ms(0));

    let actions = pace(&mut simulator, Event::Gates(vec![ARMED]), ms(1));

    assert_eq!(actions, [Action::Stepped { left: 4 }]);
}
