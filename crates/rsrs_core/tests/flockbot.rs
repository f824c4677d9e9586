//! The files that ship with the project: the measured Flockbot and its sweep.

use std::collections::BTreeSet;

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::profile::RobotProfile;

use crate::numbers::numbers;

use rsrs_testing::conditions::flockbot;
const GROUP_SENSOR: &str =
    include_str!("../../../launch_configs/profiles/flockbot_group_sensor.yaml");
const SWEEP: &str = include_str!("../../../launch_configs/sweeps/flockbot_speed_turn.yaml");

#[test]
fn every_number_of_the_flockbots_has_a_source() {
    let group = RobotProfile::parse("flockbot_group_sensor.yaml", GROUP_SENSOR)
        .expect("the profile that ships is valid");
    for profile in [flockbot(), group] {
        assert_explained(&profile);
    }
}

fn assert_explained(profile: &RobotProfile) {
    let value = serde_json::to_value(profile).expect("a profile is plain data");
    let mut found = BTreeSet::new();
    numbers(&value, "", &mut found);

    let explained: BTreeSet<String> = profile.provenance.numbers.keys().cloned().collect();

    assert!(found.len() > 20, "{found:?}");
    assert_eq!(found, explained);
    for (key, source) in &profile.provenance.numbers {
        let is_given = source.contains("assumed") || source.contains(':') || source == "tab:speed1";
        assert!(is_given, "{key}: {source}");
    }
}

#[test]
fn the_second_flockbot_differs_in_how_far_it_sees_and_in_nothing_else() {
    let mut group = RobotProfile::parse("group.yaml", GROUP_SENSOR).expect("it is valid");
    let ours = flockbot();

    let cone = group.sensing.cone.as_mut().expect("it sees a cone");
    assert!((cone.range_m - 3.6).abs() < 1e-12);
    cone.range_m = 0.75;

    group.name.clone_from(&ours.name);
    group.provenance = ours.provenance.clone();
    assert_eq!(group, ours);
}

#[test]
fn the_speed_gains_are_the_means_of_the_papers_table() {
    // tab:speed1, in millimetres per second.
    for (commanded, measured) in [(25.0, [22.15, 21.48, 22.32]), (50.0, [48.47, 48.66, 48.54])] {
        let expected = measured.iter().sum::<f64>() / 3.0 / commanded;

        let found = flockbot().actuation.speed.gain_at(commanded / 1000.0);

        assert!((found.mean - expected).abs() < 5e-4 && !found.held, "{found:?} {expected}");
    }
}

#[test]
fn the_sweep_spans_the_papers_plane_with_the_harsher_robot() {
    let sweep = SweepFile::parse("sweep.yaml", SWEEP).expect("the sweep that ships is valid");

    let cells = sweep.resolve("sweep.yaml", &flockbot()).expect("all cells can be simulated");

    assert_eq!((cells.len(), sweep.replicates), (11 * 8, 100));
    let best = |entry: &&(rsrs_core::quantity::Cell, Conditions)| {
        entry.0.get(Axis::Speed) == Some(0.15) && entry.0.get(Axis::TurnRate) == Some(0.75)
    };
    let (_, conditions) = cells.iter().find(best).expect("the paper's best cell is swept");
    let robot = &conditions.robot;
    assert_eq!(conditions.robots, 9);
    assert_eq!(conditions.steps(sweep.duration_s), 2307);
    for (found, expected) in [
        (robot.speed_gain.robot_sd, 0.05),
        (robot.turn_gain.robot_sd, 0.05),
        (robot.true_positive, 0.80),
        (robot.false_positive, 0.08),
        (robot.speed_gain.mean, 0.971),
    ] {
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    }
}
