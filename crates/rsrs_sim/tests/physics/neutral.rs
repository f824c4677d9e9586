//! Phase shares of another world and another judge, written in Python from the rules and not from
//! this code, of six cells with the robots as measured and made worse.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rsrs_core::conditions::{Conditions, GainDistribution};
use rsrs_core::judge::phase::Phase;
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_sim::sweep::{Runs, Watch, sweep};
use serde_json::{Map, Value, json};

use rsrs_testing::conditions::flockbot_conditions;
use rsrs_testing::python;

use rsrs_testing::environment::or_if_long;

/// Speed in m/s and turning rate in rad/s: mills, borders of mills, and what is none.
const CELLS: [(f64, f64); 6] =
    [(0.15, 0.75), (0.05, 0.25), (0.30, 0.50), (0.20, 1.25), (0.10, 2.0), (0.25, 0.75)];

/// Runs of ours, which take little.
const REPLICATES: u64 = 2000;

/// The Flockbot made worse, and as measured: standard deviation of the gains, detections where
/// something is, and where nothing is.
const WORLDS: [(&str, f64, f64, f64); 2] =
    [("made worse", 0.05, 0.80, 0.08), ("as measured", 0.02, 0.98, 0.065)];

#[test]
fn another_world_and_another_judge_find_the_same_phases() {
    let mut conditions: Vec<Conditions> = Vec::new();
    let mut cells: Vec<Map<String, Value>> = Vec::new();
    for (world, gain_sd, true_positive, false_positive) in WORLDS {
        for (speed, turn) in CELLS {
            let mut cell = flockbot_conditions();
            cell.controller = ControllerParameters::mirrored(speed, turn).into();
            let gain = GainDistribution { mean: 0.97, robot_sd: gain_sd, step_sd: 0.0 };
            (cell.robot.speed_gain, cell.robot.turn_gain) = (gain, gain);
            cell.robot.true_positive = true_positive;
            cell.robot.false_positive = false_positive;
            conditions.push(cell);
            let described = json!({
                "name": format!("{world}, {speed} m/s, {turn} rad/s"),
                "speed": speed, "turn": turn, "gain_mean": gain.mean, "gain_sd": gain_sd,
                "true_positive": true_positive, "false_positive": false_positive,
                "runs": REPLICATES,
                "runs_there": or_if_long(120, 400),
            });
            cells.push(described.as_object().expect("it is one").clone());
        }
    }
    let runs = Runs { seed: 5, replicates: REPLICATES, duration_s: 300.0, n_threads: 2 };
    let watch = Watch { progress: &|_| (), cancel: &AtomicBool::new(false) };
    let swept = sweep(&conditions, runs, watch).expect("the robots fit");
    for (cell, counts) in cells.iter_mut().zip(swept.counts(conditions.len())) {
        let count = |phase: Phase| (phase.key().to_owned(), json!(counts.get(phase)));
        let counts: Map<String, Value> = Phase::BUILT_IN.into_iter().map(count).collect();
        cell.insert("counts".to_owned(), Value::Object(counts));
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/physics/neutral.py");
    let text = json!(cells).to_string();
    let printed = python::answer(&script, env!("CARGO_TARGET_TMPDIR"), &text);

    assert_eq!(printed.trim(), "60 shares agree");
}
