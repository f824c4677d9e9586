//! The statistics of a fit are those of scipy and statsmodels on the same data.

use std::path::Path;

use rsrs_core::trials::fit::{Fit, Unmeasured, fit};
use rsrs_core::trials::trial::{PeriodTrial, SpeedTrial, Trials, TurnTrial, detection_trials};
use rsrs_testing::draw::Draw;
use rsrs_testing::python;
use serde_json::{Value, json};

use crate::tables::{tables, trials};

const DETECTION: &str = "robot,distance_m,bearing_rad,samples,detections\n\
    a,0.3,-0.2,40,38\na,0.3,0,40,40\na,0.3,0.2,40,39\n\
    a,0.5,-0.2,40,36\na,0.5,0,40,37\na,0.5,0.2,40,10\na,,,700,47\n";

/// How many robots, commands and trials; whether some are missing.
#[derive(Clone, Copy)]
struct Design {
    seed: u64,
    n_robots: usize,
    n_commands: usize,
    n_trials: usize,
    is_uneven: bool,
}

fn case(design: Design) -> Value {
    let mut draw = Draw::new(design.seed);
    let mut rows = Vec::new();
    for robot in 0..design.n_robots {
        let differs = draw.normal(0.0, 0.03);
        for command in 0..design.n_commands {
            let n_fewer = if design.is_uneven { (robot + command) % 3 } else { 0 };
            for _ in n_fewer..design.n_trials {
                let commanded_m_s = 0.05 * (command as f64 + 1.0);
                let gain = 0.95 + differs + draw.normal(0.0, 0.01);
                rows.push(SpeedTrial {
                    robot,
                    line: rows.len() as u64 + 2,
                    commanded_m_s,
                    distance_m: 2.0,
                    duration_s: 2.0 / (gain * commanded_m_s),
                    lateral_m: None,
                    heading_change_rad: None,
                });
            }
        }
    }
    // One trial that is not like the others.
    rows[0].duration_s *= 1.07;
    let names: Vec<String> = (0..design.n_robots).map(|robot| format!("robot_{robot}")).collect();
    let speed = trials("speed.csv", names.clone(), rows);
    let periods = (0..12)
        .map(|line| PeriodTrial {
            robot: line % design.n_robots,
            line: line as u64 + 2,
            period_s: draw.normal(0.13, 0.004),
        })
        .collect();
    let period = trials("period.csv", names, periods);
    let fitted = fitted(&speed, &period);
    json!({
        "trials": speed.rows.iter().map(|trial| json!({
            "robot": trial.robot,
            "line": trial.line,
            "commanded_m_s": trial.commanded_m_s,
            "speed_m_s": trial.distance_m / trial.duration_s,
        })).collect::<Vec<_>>(),
        "periods": period.rows.iter().map(|trial| json!([trial.robot, trial.period_s]))
            .collect::<Vec<_>>(),
        "report": fitted,
        "details": fitted.details,
    })
}

fn fitted(speed: &Trials<SpeedTrial>, period: &Trials<PeriodTrial>) -> Fit {
    let turn = TurnTrial {
        robot: 0,
        line: 2,
        commanded_rad_s: 0.75,
        angle_rad: std::f64::consts::TAU,
        duration_s: 8.6,
    };
    let turn = trials("turn.csv", vec!["robot_0".to_owned()], vec![turn]);
    let detection = detection_trials("detection.csv", DETECTION).expect("valid");
    let tables = tables(speed, &turn, &detection, Some(period));
    fit(tables, &Unmeasured::default()).expect("there is a region")
}

#[test]
fn intervals_variance_components_and_outliers_agree_with_scipy_and_statsmodels() {
    let design = Design { seed: 1, n_robots: 5, n_commands: 1, n_trials: 6, is_uneven: false };
    let cases: Vec<Value> = [
        design,
        Design { seed: 2, n_commands: 3, ..design },
        Design { seed: 3, n_robots: 3, n_commands: 2, n_trials: 4, is_uneven: true },
        Design { seed: 4, n_robots: 12, n_commands: 1, n_trials: 3, is_uneven: false },
        Design { seed: 5, n_robots: 6, n_commands: 4, n_trials: 5, is_uneven: true },
        Design { seed: 6, n_robots: 7, n_commands: 1, n_trials: 5, is_uneven: true },
    ]
    .map(case)
    .into();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fit_oracle.py");
    let text = json!(cases).to_string();
    let printed = python::answer(&script, env!("CARGO_TARGET_TMPDIR"), &text);

    assert_eq!(printed.trim(), "6 cases agree");
}
