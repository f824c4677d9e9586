//! `rsrs stop` and its release, on good networks and bad ones.

use std::collections::BTreeSet;

use rsrs_fleet::runner::Outcome;
use rsrs_fleet::stopper::Ending;

use crate::fleet;
use crate::network::{Faults, Node};
use crate::scenario::Scenario;

const SEEDS: u64 = 300;

#[test]
fn no_seed_breaks_an_invariant_of_stops() {
    let (mut interrupted, mut acknowledged, mut named) = (0, 0, 0);

    for seed in 0..SEEDS {
        let scenario = Scenario::draw_with_stop(seed);
        match fleet::play(scenario.clone()) {
            Ok(story) => {
                let [stop] = &story.stops[..] else { panic!("seed {seed}: {:?}", story.stops) };
                acknowledged += u64::from(stop.ending == Ending::Acknowledged);
                named += u64::from(stop.ending == Ending::TimedOut);
                let is_e_stop = |end: &Outcome| *end == aborted("e-stop");
                interrupted += u64::from(story.outcomes.values().any(is_e_stop));
            }
            Err(violation) => panic!("seed {seed}: {violation}\n{scenario:#?}"),
        }
    }

    // The invariants hold where nothing moves and nobody hears: see that there is more to it.
    assert!(interrupted >= SEEDS / 4, "{interrupted} of {SEEDS} stops met a run");
    assert!(acknowledged >= SEEDS / 2, "{acknowledged} of {SEEDS} stops were acknowledged");
    assert_eq!(acknowledged + named, SEEDS);
}

fn aborted(reason: &str) -> Outcome {
    Outcome::Aborted { reason: reason.to_owned() }
}

#[test]
fn a_stop_in_the_middle_of_a_run_ends_it_and_every_robot_acknowledges() {
    let story = fleet::play(Scenario { stop_ms: Some(3_000), ..Scenario::calm(1) }).unwrap();

    assert_eq!(story.outcomes[&0], aborted("e-stop"));
    let [stop] = &story.stops[..] else { panic!("{:?}", story.stops) };
    assert_eq!((stop.ending, stop.took_ms), (Ending::Acknowledged, 2_000));
    for answer in &stop.answers {
        let after = answer.acknowledged_after.expect("all have acknowledged");
        assert!(after.as_millis() <= 10, "{answer:?}");
    }
}

#[test]
fn a_stop_under_loss_is_acknowledged_by_all() {
    for seed in 0..50 {
        let faults = Faults { loss: 0.5, duplication: 0.2, delay_ms: 100, partition: None };
        let scenario = Scenario { stop_ms: Some(3_000), faults, ..Scenario::calm(seed) };

        let story = fleet::play(scenario).unwrap();

        assert_eq!(story.stops[0].ending, Ending::Acknowledged, "seed {seed}");
    }
}

#[test]
fn a_robot_that_is_cut_off_is_named_and_stands_without_having_heard_it() {
    let side: BTreeSet<_> = [Node::Robot(1), Node::Controller(1)].into();
    let faults = Faults { partition: Some((2_500, 20_000, side)), ..Scenario::calm(1).faults };

    let story =
        fleet::play(Scenario { stop_ms: Some(2_600), faults, ..Scenario::calm(1) }).unwrap();

    let [stop] = &story.stops[..] else { panic!("{:?}", story.stops) };
    let silent: Vec<_> = stop
        .answers
        .iter()
        .filter(|answer| answer.acknowledged_after.is_none())
        .map(|answer| answer.robot.as_str())
        .collect();
    assert_eq!((stop.ending, silent), (Ending::TimedOut, vec!["robot_2"]));
}

#[test]
fn a_stop_works_without_a_runner() {
    let scenario = Scenario { crash_ms: Some(2_900), stop_ms: Some(3_000), ..Scenario::calm(1) };

    let story = fleet::play(scenario).unwrap();

    assert_eq!(story.stops[0].ending, Ending::Acknowledged);
}

#[test]
fn after_a_stop_no_run_starts_until_it_is_released() {
    let stopped =
        Scenario { stop_ms: Some(2_000), second_runner_ms: Some(5_000), ..Scenario::calm(1) };
    let released =
        Scenario { second_runner_ms: Some(9_000), release_ms: Some(5_000), ..stopped.clone() };

    let refused = fleet::play(stopped).unwrap();
    let allowed = fleet::play(released).unwrap();

    let Outcome::Failed { problems } = &refused.outcomes[&1] else {
        panic!("{:?}", refused.outcomes)
    };
    assert_eq!(
        problems[0].to_string(),
        "the e-stop holds robot_1, robot_2, robot_3 (`rsrs stop --release` lets them go)"
    );
    assert_eq!(allowed.stops[1].ending, Ending::Acknowledged);
    assert_eq!(allowed.outcomes[&1], Outcome::Completed);
}

#[test]
fn a_release_in_the_middle_of_a_run_disturbs_nothing() {
    let story = fleet::play(Scenario { release_ms: Some(2_000), ..Scenario::calm(1) }).unwrap();

    assert_eq!(story.stops[0].ending, Ending::InRun);
    assert_eq!(story.outcomes[&0], Outcome::Completed);
}
