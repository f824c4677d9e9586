//! Gates that are set otherwise than the fleet file and the profile determine, and those of others.

use super::*;
use crate::parameters::{Value, gate};

fn settings(of: &[(&str, f64)]) -> GateSettings {
    of.iter().map(|(name, value)| ((*name).to_owned(), Value::Double(*value))).collect()
}

/// Robots whose gates should have a threshold of 0.75 m, and have these.
fn bench(thresholds_m: [Option<f64>; 2]) -> Bench {
    let expected = settings(&[(gate::DETECTION_THRESHOLD, 0.75)]);
    let mut bench = Bench::with(|options| {
        options.expected.gates =
            NAMES.map(|robot| (robot.to_owned(), expected.clone())).into_iter().collect();
    });
    for (robot, threshold_m) in NAMES.into_iter().zip(thresholds_m) {
        if let Some(threshold_m) = threshold_m {
            let found = settings(&[
                (gate::DETECTION_THRESHOLD, threshold_m),
                (gate::SENSOR_TIMEOUT, 0.5 + 0.1 * threshold_m),
            ]);
            bench.gates.insert(robot.to_owned(), found);
        }
    }
    bench
}

#[test]
fn a_gate_with_another_threshold_is_named_before_anything_is_opened_or_armed() {
    let mut bench = bench([Some(0.75), Some(0.6)]);

    let problems = bench.problems();

    let expected = "robot_2: `detection_threshold` is 0.6 m, expected 0.75 m by the fleet file";
    assert!(problems.len() == 1 && problems[0].starts_with(expected), "{problems:?}");
    assert!(!bench.opened && bench.runner.epoch() == 0);
}

#[test]
fn gates_of_others_are_noted_and_keep_no_run_from_starting() {
    let mut bench = bench([Some(0.75), None]);

    bench.run();

    assert_eq!(bench.runner.gates().keys().collect::<Vec<_>>(), ["robot_1"]);
    let of_gates: Vec<_> = bench.notes.iter().filter(|note| note.contains("gates")).collect();
    assert_eq!(
        of_gates,
        ["settings of the gates of robot_2 are not known: their nodes are not `rsrs node robot`"]
    );
}

#[test]
fn what_nothing_determines_is_noted_where_robots_differ() {
    let mut bench = Bench::with(|options| {
        options.expected.gates =
            NAMES.map(|robot| (robot.to_owned(), GateSettings::new())).into_iter().collect();
    });
    for (robot, timeout_s) in NAMES.into_iter().zip([0.5, 2.0]) {
        let found = settings(&[(gate::SENSOR_TIMEOUT, timeout_s)]);
        bench.gates.insert(robot.to_owned(), found);
    }

    bench.run();

    let expected = "`sensor_timeout` differs between robots: 0.5 on robot_1; 2 on robot_2";
    assert!(bench.notes.iter().any(|note| note == expected), "{:?}", bench.notes);
}
