use super::*;

const IDLE: Gate = Gate { state: RobotState::Idle, drive: Command::STOP, is_in_run: false };

fn gates(simulator: &mut Simulator, now: Duration) -> Vec<Action> {
    pace(simulator, Event::Gates(vec![IDLE]), now)
}

fn sense(step: u64) -> Action {
    Action::Sense { step, stamp_ns: Some(step * 130) }
}

#[test]
fn a_paused_world_makes_as_many_steps_as_are_asked_for() {
    let mut simulator = lockstep(1, 9);
    assert_eq!(simulator.playback_state(), PlaybackState::Stopped);
    let step = ManualCommand::Step { steps: 2 };
    assert_eq!(simulator.apply_manual(step, ms(0)), Err(ManualControlRefused::NotPaused));
    simulator.apply_manual(ManualCommand::Pause, ms(0)).unwrap();
    assert_eq!(gates(&mut simulator, ms(1)), []);

    simulator.apply_manual(step, ms(1)).unwrap();

    assert_eq!(simulator.due(), Some(Duration::ZERO));
    assert_eq!(gates(&mut simulator, ms(1)), [Action::AdvanceFreely, sense(2)]);
    assert_eq!(simulator.apply_manual(step, ms(1)), Err(ManualControlRefused::NotPaused));
    let last = [Action::AdvanceFreely, sense(3), Action::Stepped { left: 0 }];
    assert_eq!(gates(&mut simulator, ms(1)), last);
    assert_eq!(gates(&mut simulator, ms(1)), []);
    assert_eq!((simulator.playback_state(), simulator.due()), (PlaybackState::Paused, None));
}

#[test]
fn a_world_that_plays_makes_a_step_each_period_and_none_while_it_is_paused() {
    let mut simulator = real_time(1);
    simulator.apply_manual(ManualCommand::Play, ms(0)).unwrap();

    let steps = |simulator: &mut Simulator, now| {
        gates(simulator, now).iter().filter(|action| **action == Action::AdvanceFreely).count()
    };

    assert_eq!(simulator.playback_state(), PlaybackState::Playing);
    assert_eq!(steps(&mut simulator, ms(0)), 1);
    assert_eq!(steps(&mut simulator, ms(100)), 0);
    assert_eq!(steps(&mut simulator, ms(130)), 1);
    simulator.apply_manual(ManualCommand::Pause, ms(140)).unwrap();
    assert_eq!(steps(&mut simulator, ms(500)), 0);
}

#[test]
fn sensors_of_a_world_in_real_time_work_on_while_it_is_paused_and_those_of_lockstep_do_not() {
    for command in [ManualCommand::Pause, ManualCommand::EntityMoved] {
        let mut simulator = real_time(1);
        gates(&mut simulator, ms(0));
        simulator.apply_manual(command, ms(10)).unwrap();

        let at: Vec<u64> = (20..=1000)
            .step_by(10)
            .filter(|now| !gates(&mut simulator, ms(*now)).is_empty())
            .collect();

        // Once in each period of 130 ms.
        assert_eq!(at, [140, 270, 400, 530, 660, 790, 920], "{command:?}");
        let again = [Action::Sense { step: 1, stamp_ns: None }];
        assert_eq!(gates(&mut simulator, ms(1050)), again, "{command:?}");
        assert_eq!(simulator.playback_state(), PlaybackState::Paused);
    }
    let mut simulator = lockstep(1, 9);
    simulator.apply_manual(ManualCommand::Pause, ms(0)).unwrap();
    assert_eq!((gates(&mut simulator, ms(1000)), simulator.due()), (Vec::new(), None));
}

#[test]
fn a_manually_moved_world_is_not_used_by_a_run_until_it_is_placed_again() {
    for command in [ManualCommand::Play, ManualCommand::Pause, ManualCommand::EntityMoved] {
        let mut simulator = lockstep(1, 9);

        let actions = simulator.apply_manual(command, ms(0)).unwrap();

        let is_nameless = |action: &Action| {
            matches!(action, Action::Status(status)
                if status.parameter_digest == 0 && status.state == RobotState::Idle)
        };
        assert!(actions.iter().any(is_nameless), "{command:?}: {actions:?}");
        // Even if a runner arms and starts it.
        assert_eq!(pace(&mut simulator, Event::Gates(vec![MOVING]), ms(1)), []);
        assert_eq!(simulator.playback_state(), PlaybackState::Paused);
        assert_eq!(simulator.apply_manual(command, ms(1)), Err(ManualControlRefused::Held));
    }
}

#[test]
fn manual_control_is_refused_while_a_run_holds_the_world() {
    for gate in [ARMED, MOVING] {
        for mut simulator in [lockstep(1, 9), real_time(1)] {
            simulator.on_event(Event::Gates(vec![gate]), ms(0));

            for command in [
                ManualCommand::Play,
                ManualCommand::Pause,
                ManualCommand::EntityMoved,
                ManualCommand::Step { steps: 1 },
            ] {
                assert_eq!(simulator.apply_manual(command, ms(0)), Err(ManualControlRefused::Held));
            }
        }
    }
    assert_eq!(
        Simulator::new().apply_manual(ManualCommand::Play, ms(0)),
        Err(ManualControlRefused::NoWorld)
    );
}

#[test]
fn a_run_that_takes_the_robots_ends_manual_steps() {
    let mut simulator = lockstep(1, 9);
    simulator.apply_manual(ManualCommand::Pause, ms(0)).unwrap();
    simulator.apply_manual(ManualCommand::Step { steps: 5 }, ms(0)).unwrap();
    gates(&mut simulator, ms(0));

    let actions = pace(&mut simulator, Event::Gates(vec![ARMED]), ms(1));

    assert_eq!(actions, [Action::Stepped { left: 4 }]);
}
