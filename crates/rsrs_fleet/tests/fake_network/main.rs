//! The protocol's invariants under a network that does its worst.
//!
//! No robot moves without a lease that echoes a status of its own younger than 500 ms, or with
//! parameters that the runner has not confirmed; never do robots move in two epochs at once; without
//! a runner all stand within the lease time; after the e-stop none moves; every runner that lives
//! finishes with its bag closed.
//!
//! After a stop, every robot that hears it has stopped, every robot that hears neither it nor the
//! runner stands within its lease, and whoever is said to have acknowledged has heard it.

mod fleet;
mod network;
mod scenario;
mod stops;
mod witness;

use rsrs_fleet::runner::Outcome;
use scenario::Scenario;

const SEEDS: u64 = 300;

#[test]
fn no_seed_breaks_an_invariant() {
    let (mut moved, mut completed, mut ended_early) = (0, 0, 0);

    for seed in 0..SEEDS {
        let scenario = Scenario::draw(seed);
        match fleet::play(scenario.clone()) {
            Ok(story) => {
                moved += u64::from(story.moving_steps > 0);
                let outcomes: Vec<_> = story.outcomes.values().collect();
                completed += u64::from(outcomes.contains(&&Outcome::Completed));
                ended_early += u64::from(outcomes.iter().any(|end| **end != Outcome::Completed));
            }
            Err(violation) => panic!("seed {seed}: {violation}\n{scenario:#?}"),
        }
    }

    // The invariants hold of a fleet that never moves: see that this one does, and that it stops.
    assert!(moved >= SEEDS / 4, "robots moved under {moved} of {SEEDS} seeds");
    assert!(completed >= SEEDS / 10, "{completed} of {SEEDS} completed");
    assert!(ended_early >= SEEDS / 10, "{ended_early} of {SEEDS} ended early");
}

#[test]
fn on_a_calm_network_the_run_is_completed() {
    let story = fleet::play(Scenario::calm(1)).unwrap();

    assert_eq!(story.outcomes[&0], Outcome::Completed);
    assert!(story.moving_steps > 500, "{}", story.moving_steps);
}

#[test]
fn a_second_runner_that_comes_late_is_refused_and_disturbs_nothing() {
    let scenario = Scenario { second_runner_ms: Some(2_000), ..Scenario::calm(1) };

    let story = fleet::play(scenario).unwrap();

    assert_eq!(story.outcomes[&0], Outcome::Completed);
}

#[test]
fn of_two_runners_that_start_at_once_none_moves_a_robot() {
    let scenario = Scenario { second_runner_ms: Some(0), ..Scenario::calm(1) };

    let story = fleet::play(scenario).unwrap();

    assert_eq!(story.moving_steps, 0);
    assert_eq!(story.outcomes.len(), 2);
}

#[test]
fn after_a_crash_the_next_runner_takes_over() {
    let scenario =
        Scenario { crash_ms: Some(2_500), second_runner_ms: Some(4_000), ..Scenario::calm(1) };

    let story = fleet::play(scenario).unwrap();

    assert_eq!(story.outcomes.get(&0), None);
    assert_eq!(story.outcomes[&1], Outcome::Completed);
}

#[test]
fn a_controller_that_lies_about_its_parameters_keeps_the_run_from_starting() {
    let story = fleet::play(Scenario { liar: Some(1), ..Scenario::calm(1) }).unwrap();

    assert_eq!(story.moving_steps, 0);
    assert!(matches!(story.outcomes[&0], Outcome::Failed { .. }), "{story:?}");
}
