//! The protocol's invariants under a network, machines and people that do their worst.
//!
//! Every seed draws a fleet of real robots, or of the simulator's, with controllers, runners and
//! a stopper; what the network does to messages; which processes die, hang and start
//! again; and whose clocks are wrong. At every instant, at the wheels:
//!
//! - no robot moves without a lease that rests on a status of its own younger than 500 ms, under one
//!   epoch, with the parameters that this epoch's runner confirmed, by a command younger than its
//!   timeout and within its limits, while a bag records it;
//! - no robot obeys an epoch after a newer one, and never do robots move in two epochs at once, nor
//!   for two runs, even if their runners cannot receive each other and have taken the same epoch;
//! - what stops a robot in a run stops it until a newer epoch arms it, but for a lease that ran out:
//!   within a second, one that echoes a status from after that lets the robot go on, and that it
//!   stood is in its runner's account;
//! - a robot that receives a stop stands within 200 ms, and one that has acknowledged it has
//!   received it;
//! - of two who engage the e-stop, none undoes what the other did: a lock ends when the same source
//!   publishes `false`, or by a release that names it, and a source that falls silent in a run
//!   locks;
//! - wheels whose process has died or hangs stand within their own 250 ms;
//! - a runner that hears another one which goes before it, or that its simulated world has gone, neither
//!   arms nor runs, and parameters stay while a run holds them;
//! - in lockstep every robot moves once in every step, by the answer to what it sensed in that step;
//! - every runner that lives finishes with its bag closed;
//! - when all is healed, another run arms, moves every robot and is completed.
//!
//! - a controller that holds the lease of a robot without a gate publishes nothing else on
//!   `cmd_vel` than what such a gate would let through.
//!
//! Messages come late, and some come again seconds later, when their content is long over.
//!
//! `RSRS_SEED=N` plays one seed and prints everything that happens; `RSRS_SEEDS=N` plays so many.

mod fleet;
mod network;
mod ordinary_radio;
mod safety_oracle;
mod scenario;
mod stops;

use fleet::{LAST_RUNNER, Story, Verbosity};
use network::Node;
use rsrs_fleet::runner::Outcome;
use rsrs_fleet::stopper::StopOutcome;
use rsrs_testing::environment::number;
use scenario::{Body, Happening, Scenario};

const SEEDS: u64 = 4_000;

/// How many seeds to play: as many as usual, or as the environment asks for.
fn number_of_seeds(usual: u64) -> u64 {
    number("RSRS_SEEDS").unwrap_or(usual)
}

/// Plays so many seeds on all processors, or the one that the environment asks for.
///
/// # Panics
///
/// If a seed breaks an invariant; the first ones are named.
fn play_seeds(
    n_seeds: u64,
    draw: impl Fn(u64) -> Scenario + Sync,
    count: impl Fn(&Story) -> Vec<bool> + Sync,
) -> Vec<u64> {
    if let Some(seed) = number("RSRS_SEED") {
        let scenario = draw(seed);
        let (violation, story) = match fleet::play(scenario.clone(), Verbosity::Everything) {
            Ok(story) => ("no violation".to_owned(), story),
            Err(found) => *found,
        };
        panic!("{scenario:#?}\n{}\nseed {seed}: {violation}", story.narrative.join("\n"));
    }
    let n_processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let n_threads = n_seeds.min(n_processors as u64);
    let (draw, count) = (&draw, &count);
    let play = |first| {
        let (mut counts, mut violations) = (Vec::new(), Vec::new());
        for seed in (first..n_seeds).step_by(n_processors) {
            match fleet::play(draw(seed), Verbosity::Nothing) {
                Ok(story) => {
                    let found = count(&story);
                    counts.resize(found.len(), 0);
                    for (total, is_so) in counts.iter_mut().zip(found) {
                        *total += u64::from(is_so);
                    }
                }
                Err(found) => violations.push(format!("seed {seed} {}", found.0)),
            }
        }
        (counts, violations)
    };
    let (counts, violations) = std::thread::scope(|scope| {
        let start = |first| scope.spawn(move || play(first));
        let threads: Vec<_> = (0..n_threads).map(start).collect();
        let found = threads.into_iter().map(|thread| thread.join().expect("it does not panic"));
        found.collect::<(Vec<Vec<u64>>, Vec<Vec<String>>)>()
    });
    let violations = violations.concat();
    assert!(
        violations.is_empty(),
        "{} of {n_seeds} seeds break an invariant, `RSRS_SEED=N` prints the whole story:\n{}",
        violations.len(),
        violations[..violations.len().min(12)].join("\n")
    );
    let sum = |sum: Vec<u64>, more: Vec<u64>| sum.iter().zip(more).map(|(a, b)| a + b).collect();
    counts.into_iter().reduce(sum).expect("there is at least one thread")
}

fn play(scenario: Scenario) -> Story {
    let played = fleet::play(scenario, Verbosity::Nothing);
    played.map_err(|found| found.0).expect("a directed story breaks no invariant")
}

#[test]
fn no_seed_breaks_an_invariant() {
    let n_seeds = number_of_seeds(SEEDS);
    let counts = play_seeds(n_seeds, Scenario::draw, |story| {
        let before: Vec<_> =
            story.outcomes.iter().filter(|(runner, _)| **runner < LAST_RUNNER).collect();
        let (meddled, refused) = story.meddled;
        vec![
            story.movements > 0,
            before.iter().any(|(_, outcome)| **outcome == Outcome::Completed),
            before.iter().any(|(_, outcome)| **outcome != Outcome::Completed),
            refused > 0,
            meddled > refused,
            story.n_without_world > 0,
        ]
    });

    // The invariants hold of a fleet that never moves: see that there is more to it.
    for (what, count) in ["moved", "completed", "ended early"].iter().zip(&counts) {
        assert!(*count >= n_seeds / 10, "only {count} of {n_seeds} {what}");
    }
    assert!(counts[3] > n_seeds / 100 && counts[4] > n_seeds / 100, "meddlers were {counts:?}");
    assert!(counts[5] > n_seeds / 1_000, "{} runs heard that their world had gone", counts[5]);
}

#[test]
fn on_a_calm_network_the_run_is_completed() {
    for body in [Body::Real, Body::Simulated, Body::Lockstep] {
        let story = play(Scenario { body, ..Scenario::calm(1) });

        assert_eq!(story.outcomes[&0], Outcome::Completed, "{body:?}");
        assert!(story.movements >= 60, "{body:?}: {}", story.movements);
    }
}

#[test]
fn a_second_runner_that_comes_late_is_refused_and_disturbs_nothing() {
    let story = play(Scenario::calm(1).with(2_000, Happening::Start(1)));

    assert_eq!(story.outcomes[&0], Outcome::Completed);
}

#[test]
fn of_two_runners_that_start_at_once_the_later_one_gives_way() {
    let long = Scenario { run_ms: 15_000, ..Scenario::calm(1) };

    let story = play(long.with(1, Happening::Start(1)));

    assert_eq!(story.outcomes[&0], Outcome::Completed);
    let Outcome::Failed { problems } = &story.outcomes[&1] else { panic!("{story:?}") };
    assert!(problems[0].to_string().contains("run 0"), "{problems:?}");
}

#[test]
fn a_runner_that_is_started_while_another_prepares_takes_no_robot_from_it() {
    for after_ms in (900..1_300).step_by(10) {
        let story = play(Scenario::calm(1).with(after_ms, Happening::Start(1)));

        assert_eq!(story.outcomes[&0], Outcome::Completed, "started after {after_ms} ms");
    }
}

#[test]
fn runs_of_different_robots_go_on_side_by_side_and_a_stop_ends_both() {
    let teams = vec![vec![0, 2], vec![1]];
    for after_ms in [1, 500, 1_500, 2_500] {
        let beside = Scenario { teams: teams.clone(), ..Scenario::calm(1) }
            .with(after_ms, Happening::Start(1));

        let story = play(beside.clone());
        let stopped = play(beside.with(4_000, Happening::Stop));

        for runner in 0..2 {
            assert_eq!(story.outcomes[&runner], Outcome::Completed, "{after_ms} ms: {runner}");
            let ending = &stopped.outcomes[&runner];
            let is_stopped = *ending == Outcome::Aborted { reason: "e-stop".to_owned() };
            assert!(is_stopped || *ending == Outcome::Completed, "{ending:?}");
        }
        let n_completed =
            stopped.outcomes.values().filter(|end| **end == Outcome::Completed).count();
        assert!(n_completed == 0, "{after_ms} ms: {:?}", stopped.outcomes);
    }
}

#[test]
fn of_two_runs_with_one_robot_in_common_one_at_most_moves_it() {
    for after_ms in [1, 300, 900, 1_100, 1_500, 2_500] {
        let teams = vec![vec![0, 1], vec![1, 2]];

        let long = Scenario { teams, run_ms: 15_000, ..Scenario::calm(1) };
        let story = play(long.with(after_ms, Happening::Start(1)));

        assert_eq!(story.outcomes[&0], Outcome::Completed, "{after_ms} ms");
        assert!(matches!(story.outcomes[&1], Outcome::Failed { .. }), "{after_ms} ms");
    }
}

#[test]
fn runners_out_of_reach_of_each_other_learn_from_the_robots_whose_run_they_are_in() {
    let mut n_met = 0;
    for after_ms in 1..60 {
        let apart = Scenario { are_runners_apart: true, ..Scenario::calm(after_ms) };

        let story = play(apart.with(after_ms, Happening::Start(1)));

        // Each ends; that robots never move for both at once is judged all the time.
        assert_eq!(story.outcomes.len(), 2);
        let ends = format!("{:?}", story.outcomes);
        n_met += u64::from(ends.contains("armed for run run "));
    }
    assert!(n_met > 0, "no two of these runs met");
}

#[test]
fn after_a_crash_the_next_runner_takes_over() {
    let crash = Happening::Crash(Node::Runner(0));
    let scenario = Scenario::calm(1).with(2_500, crash).with(4_000, Happening::Start(1));

    let story = play(scenario);

    assert_eq!(story.outcomes.get(&0), None);
    assert_eq!(story.outcomes[&1], Outcome::Completed);
}

#[test]
fn robots_without_a_gate_are_moved_and_stopped_by_their_controllers() {
    let alone = Scenario { controller_only: vec![true, false, true], ..Scenario::calm(1) };
    let stopped = alone.clone().with(2_500, Happening::Stop);
    let crash = Happening::Crash(Node::Runner(0));

    let (completed, stopped) = (play(alone.clone()), play(stopped));
    let taken_over = play(alone.with(2_500, crash).with(4_000, Happening::Start(1)));

    assert_eq!(completed.outcomes[&0], Outcome::Completed);
    assert!(completed.movements >= 60, "{}", completed.movements);
    assert_eq!(stopped.stops[0].ending, StopOutcome::Acknowledged);
    assert_eq!(taken_over.outcomes[&1], Outcome::Completed);
}

#[test]
fn a_robot_that_dies_under_the_eyes_of_its_controller_ends_the_run() {
    for robot in 0..3 {
        let alone = Scenario { controller_only: vec![true; 3], ..Scenario::calm(1) };
        let crash = Happening::Crash(Node::Robot(robot));

        let story = play(alone.with(2_000, crash));

        let Outcome::Aborted { reason } = &story.outcomes[&0] else { panic!("{story:?}") };
        assert!(reason.contains("no detection received for more than 1 s"), "{reason}");
    }
}

#[test]
fn a_controller_that_lies_about_its_parameters_keeps_the_run_from_starting() {
    let story = play(Scenario { liar: Some(1), ..Scenario::calm(1) });

    assert_eq!(story.movements, 0);
    assert!(matches!(story.outcomes[&0], Outcome::Failed { .. }), "{story:?}");
}

#[test]
fn a_clock_that_is_wrong_and_goes_evenly_keeps_no_run_from_its_end() {
    for ahead_ms in [6_000, -1_763_969_600] {
        let story = play(Scenario { ahead_ms: vec![0, ahead_ms, 0], ..Scenario::calm(1) });

        assert_eq!(story.outcomes[&0], Outcome::Completed, "{ahead_ms}");
        assert!(story.movements > 0);
    }
}

#[test]
fn in_lockstep_a_dead_simulator_ends_the_run_and_the_next_one_works() {
    let scenario = Scenario { body: Body::Lockstep, ..Scenario::calm(1) }
        .with(1_300, Happening::Crash(Node::Simulator))
        .with(1_400, Happening::Restart(Node::Simulator))
        .with(3_000, Happening::Heal);

    let story = play(scenario);

    assert_ne!(story.outcomes[&0], Outcome::Completed);
    assert_eq!(story.outcomes[&LAST_RUNNER], Outcome::Completed);
}

#[test]
fn a_run_does_not_go_on_without_its_world() {
    for body in [Body::Simulated, Body::Lockstep] {
        let calm = Scenario { body, ..Scenario::calm(1) };
        let mut ends = Vec::new();
        for at_ms in (900..1_300).step_by(5) {
            let story = play(calm.clone().with(at_ms, Happening::PlaceAnother));
            let n_without_world = story.n_without_world;
            assert!(n_without_world == 0 || story.outcomes[&0] != Outcome::Completed, "{at_ms} ms");
            ends.push(format!("{:?}", story.outcomes[&0]));
        }
        // Before it is set, it is placed; once the robots are armed, it is held.
        assert!(ends.first().is_some_and(|end| end == "Completed"), "{body:?}: {ends:#?}");
        assert!(ends.last().is_some_and(|end| end == "Completed"), "{body:?}: {ends:#?}");
        assert!(ends.iter().any(|end| end.contains("placed anew")), "{body:?}: {ends:#?}");
    }

    // A pause is over when its runner goes on, which finds another world then.
    let mut n_replaced = 0;
    for at_ms in (1_200..1_500).step_by(25) {
        let paused = Scenario { body: Body::Lockstep, ..Scenario::calm(1) }
            .with(at_ms, Happening::Stall(Node::Runner(0), 700))
            .with(at_ms + 650, Happening::PlaceAnother);
        let story = play(paused);
        let has_its_world = story.n_without_world == 0;
        assert_eq!(
            story.outcomes[&0] == Outcome::Completed,
            has_its_world,
            "{at_ms} ms: {story:?}"
        );
        n_replaced += u64::from(!has_its_world);
    }
    assert!(n_replaced > 0, "no world was placed in a pause");
}
