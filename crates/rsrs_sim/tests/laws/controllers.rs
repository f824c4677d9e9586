//! Swarms whose controllers have states.

use rsrs_core::conditions::Conditions;
use rsrs_core::conditions::controller_table::ControllerTable;

use rsrs_sim::batch::runs_in_lanes;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};

use crate::support::{PERFECT, assert_judged_alike, flockbots};

use rsrs_testing::conditions::flockbot;
const SEARCH: &str = include_str!("../../../../launch_configs/controllers/search_and_dwell.yaml");

fn searching() -> Conditions {
    let robot = flockbot();
    let table = ControllerTable::parse("search.yaml", SEARCH, &robot).expect("it is shipped");
    let conditions = flockbots(0.15, 0.75, &PERFECT);
    let controller = table.resolve(&[], None, conditions.period_s).expect("no wheels");
    Conditions { controller, ..conditions }
}

#[test]
fn a_run_with_draws_of_transitions_repeats_to_the_bit_and_another_seed_is_another() {
    let conditions = searching();
    let digests =
        |replicate| episode_digests(&conditions, Seed { seed: 3, replicate }, 120.0).unwrap();

    assert_eq!(digests(0), digests(0));
    assert_ne!(digests(0), digests(1));
}

#[test]
fn a_controller_with_states_is_swept_in_the_reference_world() {
    let conditions = searching();
    assert!(!runs_in_lanes(&conditions, 120.0));
    assert!(runs_in_lanes(&flockbots(0.15, 0.75, &PERFECT), 120.0));

    assert_judged_alike(&conditions, 4);
}

#[test]
fn robots_go_through_all_states() {
    let run = run_episode(&searching(), Seed { seed: 3, replicate: 0 }, 120.0).unwrap();

    let speeds: Vec<f64> = run.commands.iter().map(|command| command.speed_m_s).collect();
    for speed_m_s in [0.0_f64, 0.15, 0.2] {
        let n = speeds.iter().filter(|found| found.to_bits() == speed_m_s.to_bits()).count();
        assert!(n > 100, "{n} commands of {speed_m_s} m/s");
    }
}
