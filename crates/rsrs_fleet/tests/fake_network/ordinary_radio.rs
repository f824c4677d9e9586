//! Healthy fleets behind ordinary radio links finish their runs; the safety oracles look on.

use rsrs_fleet::runner::Outcome;

use crate::fleet::Story;
use crate::network::{Controllers, Faults, Stalled, Stalls};
use crate::scenario::Scenario;
use crate::{number_of_seeds, play_seeds};

const NINE: u64 = 20;
const A_HUNDRED: u64 = 2;

/// Every second fleet has its controllers on the workstation, so that commands and statuses of
/// controllers take the same way.
fn floor(seed: u64, n_robots: usize, faults: Faults) -> Scenario {
    let controllers =
        if seed.is_multiple_of(2) { Controllers::OnRobots } else { Controllers::AtTheRunner };
    Scenario::on_a_floor(seed, n_robots, Faults { controllers, ..faults })
}

/// Three of a hundred packets get lost, and each link stalls for 200 ms once a minute.
fn nine(seed: u64, stalled: Stalled) -> Scenario {
    let stalls = Stalls { every_ms: 60_000, length_ms: 200, stalled };
    floor(seed, 9, Faults { loss: 0.03, stalls: Some(stalls), ..Faults::none() })
}

fn completed(story: &Story) -> Vec<bool> {
    vec![story.outcomes[&0] == Outcome::Completed, story.n_pauses == 0]
}

#[test]
fn nine_robots_finish_99_of_100_runs_of_300_s_where_stalls_delay_packets() {
    let n_seeds = number_of_seeds(NINE);

    let counts = play_seeds(n_seeds, |seed| nine(seed, Stalled::Late), completed);

    assert!(counts[0] >= n_seeds * 99 / 100, "{counts:?} of {n_seeds}");
    assert!(counts[1] >= n_seeds * 95 / 100, "in few does a robot stand: {counts:?}");
}

#[test]
fn nine_robots_finish_95_of_100_runs_of_300_s_where_stalls_lose_packets() {
    let n_seeds = number_of_seeds(NINE);

    let counts = play_seeds(n_seeds, |seed| nine(seed, Stalled::Lost), completed);

    assert!(counts[0] >= n_seeds * 95 / 100, "{counts:?} of {n_seeds}");
    assert!(counts[1] >= n_seeds / 2, "in few does a robot stand: {counts:?}");
}

#[test]
fn a_hundred_robots_finish_95_of_100_runs_of_300_s_at_1_percent_loss() {
    let n_seeds = number_of_seeds(A_HUNDRED);
    let faults = Faults { loss: 0.01, ..Faults::none() };

    let counts = play_seeds(n_seeds, |seed| floor(seed, 100, faults.clone()), completed);

    assert!(counts[0] >= (n_seeds * 95).div_ceil(100), "{counts:?} of {n_seeds}");
}

#[test]
fn a_robot_whose_link_is_down_for_up_to_1_3_s_goes_on_and_one_that_is_gone_longer_is_lost() {
    for (length_ms, ending) in [(700, "completed"), (1_300, "completed"), (2_500, "aborted")] {
        let stalls = Stalls { every_ms: 60_000, length_ms, stalled: Stalled::Lost };
        let faults = Faults { stalls: Some(stalls), ..Faults::none() };
        let scenario = Scenario { run_ms: 59_000, ..floor(2, 9, faults) };

        let story = crate::play(scenario);

        match &story.outcomes[&0] {
            Outcome::Completed => {
                assert!(ending == "completed" && story.n_pauses >= 9, "{}", story.n_pauses);
            }
            Outcome::Aborted { reason } => {
                assert!(ending == "aborted" && reason.starts_with("lost robot_"), "{reason}");
            }
            other => panic!("{other:?}"),
        }
    }
}
