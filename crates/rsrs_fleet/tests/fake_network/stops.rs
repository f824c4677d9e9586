//! `rsrs stop` and its release, on good networks and bad ones.

use std::collections::BTreeSet;

use rsrs_fleet::runner::Outcome;
use rsrs_fleet::stopper::{RobotAcknowledgement, StopOutcome};

use crate::network::{Faults, Node};
use crate::scenario::{Happening, Scenario};
use crate::{number_of_seeds, play, play_seeds};

const SEEDS: u64 = 1_000;

#[test]
fn no_seed_breaks_an_invariant_of_stops() {
    let n_seeds = number_of_seeds(SEEDS);
    let counts = play_seeds(n_seeds, Scenario::draw_with_stop, |story| {
        let is_e_stop = |end: &Outcome| *end == aborted("e-stop");
        vec![
            story.stops[0].ending == StopOutcome::Acknowledged,
            story.stops[0].ending == StopOutcome::TimedOut,
            story.outcomes.values().any(is_e_stop),
        ]
    });

    // The invariants hold where nothing moves and nothing is received: see that there is more to
    // it.
    let [acknowledged, named, interrupted] = counts[..] else { panic!("{counts:?}") };
    assert!(interrupted >= n_seeds / 4, "{interrupted} of {n_seeds} stops met a run");
    assert!(acknowledged >= n_seeds / 2, "{acknowledged} of {n_seeds} stops were acknowledged");
    assert_eq!(acknowledged + named, n_seeds);
}

fn aborted(reason: &str) -> Outcome {
    Outcome::Aborted { reason: reason.to_owned() }
}

fn silent(answers: &[RobotAcknowledgement]) -> Vec<&str> {
    let silent = answers.iter().filter(|answer| answer.acknowledged_after.is_none());
    silent.map(|answer| answer.robot.as_str()).collect()
}

#[test]
fn a_stop_in_the_middle_of_a_run_ends_it_and_every_robot_acknowledges() {
    let story = play(Scenario::calm(1).with(3_000, Happening::Stop));

    assert_eq!(story.outcomes[&0], aborted("e-stop"));
    let [stop] = &story.stops[..] else { panic!("{:?}", story.stops) };
    assert_eq!(stop.ending, StopOutcome::Acknowledged);
    assert!((2_000..2_030).contains(&stop.took_ms), "{}", stop.took_ms);
    for answer in &stop.answers {
        let after = answer.acknowledged_after.expect("all have acknowledged");
        assert!(after.as_millis() <= 10, "{answer:?}");
    }
}

#[test]
fn a_stop_under_loss_is_acknowledged_by_all() {
    for seed in 0..50 {
        let faults = Faults { loss: 0.5, duplication: 0.2, delay_ms: 100, ..Faults::none() };
        let scenario = Scenario { faults, ..Scenario::calm(seed) }.with(3_000, Happening::Stop);

        let story = play(scenario);

        assert_eq!(story.stops[0].ending, StopOutcome::Acknowledged, "seed {seed}");
    }
}

#[test]
fn a_robot_that_is_cut_off_is_named_and_stands_without_having_received_it() {
    let side: BTreeSet<_> = [Node::Robot(1), Node::Controller(1)].into();
    let faults = Faults { partition: Some((2_500, 20_000, side)), ..Faults::none() };

    let story = play(Scenario { faults, ..Scenario::calm(1) }.with(2_600, Happening::Stop));

    let [stop] = &story.stops[..] else { panic!("{:?}", story.stops) };
    assert_eq!((stop.ending, silent(&stop.answers)), (StopOutcome::TimedOut, vec!["robot_2"]));
}

#[test]
fn under_loss_exactly_the_robots_that_are_dead_are_named() {
    for seed in 0..50 {
        let faults = Faults { loss: 0.4, duplication: 0.2, delay_ms: 100, ..Faults::none() };
        let scenario = Scenario { faults, ..Scenario::calm(seed) }
            .with(2_900, Happening::Crash(Node::Robot(2)))
            .with(3_000, Happening::Stop);

        let story = play(scenario);

        let stop = &story.stops[0];
        let found = (stop.ending, silent(&stop.answers));
        assert_eq!(found, (StopOutcome::TimedOut, vec!["robot_3"]), "seed {seed}");
    }
}

#[test]
fn a_stop_works_without_a_runner() {
    let crash = Happening::Crash(Node::Runner(0));

    let story = play(Scenario::calm(1).with(2_900, crash).with(3_000, Happening::Stop));

    assert_eq!(story.stops[0].ending, StopOutcome::Acknowledged);
}

#[test]
fn after_a_stop_no_run_starts_until_it_is_released() {
    let stopped = Scenario::calm(1).with(2_000, Happening::Stop);
    let released = stopped.clone().with(5_000, Happening::Release);

    let refused = play(stopped.with(5_000, Happening::Start(1)));
    let allowed = play(released.with(9_000, Happening::Start(1)));

    let Outcome::Failed { problems } = &refused.outcomes[&1] else {
        panic!("{:?}", refused.outcomes)
    };
    assert_eq!(
        problems[0].to_string(),
        "the e-stop holds robot_1, robot_2, robot_3 (`rsrs stop --release` lets them go)"
    );
    assert_eq!(allowed.stops[1].ending, StopOutcome::Acknowledged);
    assert_eq!(allowed.outcomes[&1], Outcome::Completed);
}

#[test]
fn a_release_in_the_middle_of_a_run_disturbs_nothing() {
    let story = play(Scenario::calm(1).with(2_000, Happening::Release));

    assert_eq!(story.stops[0].ending, StopOutcome::InRun);
    assert_eq!(story.outcomes[&0], Outcome::Completed);
}

/// A stop in the second second, and another run that is tried in the sixth.
fn stopped_then_run() -> Scenario {
    Scenario::calm(1).with(2_000, Happening::Stop).with(6_000, Happening::Start(1))
}

fn first_problem(story: &crate::fleet::Story) -> String {
    match &story.outcomes[&1] {
        Outcome::Failed { problems } => problems[0].to_string(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_box_that_publishes_false_all_the_time_undoes_no_stop() {
    let story = play(Scenario { has_button: [true, false], ..stopped_then_run() });

    assert_eq!(story.stops[0].ending, StopOutcome::Acknowledged);
    assert!(first_problem(&story).starts_with("the e-stop holds robot_1, robot_2, robot_3"));
}

#[test]
fn a_release_ends_no_lock_of_a_button_that_is_pressed() {
    let pressed = Scenario { has_button: [true, true], ..Scenario::calm(1) }
        .with(2_000, Happening::Press(0))
        .with(2_500, Happening::Stop);
    let held = pressed.clone().with(6_000, Happening::Release);
    let free = pressed.with(6_000, Happening::Unpress(0)).with(6_500, Happening::Release);

    let (held, free) = (play(held), play(free.with(12_000, Happening::Start(1))));

    assert_eq!(held.stops[1].ending, StopOutcome::TimedOut);
    assert_eq!(free.stops[1].ending, StopOutcome::Acknowledged);
    assert_eq!(free.outcomes[&1], Outcome::Completed);
}

#[test]
fn a_robot_that_is_started_again_learns_from_the_others_that_it_is_stopped() {
    for controller_only in [[false; 3], [true; 3]] {
        let node = if controller_only[1] { Node::Controller(1) } else { Node::Robot(1) };
        let controller_only = controller_only.to_vec();
        let restarted = Scenario { controller_only, ..Scenario::calm(1) }
            .with(2_000, Happening::Stop)
            .with(4_500, Happening::Crash(node))
            .with(4_600, Happening::Restart(node));

        let refused = play(restarted.clone().with(7_000, Happening::Start(1)));
        let released = restarted.with(7_000, Happening::Release);
        let released = play(released.with(11_000, Happening::Start(1)));

        assert!(first_problem(&refused).starts_with("the e-stop holds robot_1, robot_2, robot_3"));
        assert_eq!(released.outcomes[&1], Outcome::Completed);
    }
}
