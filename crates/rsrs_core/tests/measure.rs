//! Step 1 as a user meets it: tables in, a profile out, and what is refused.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::trials::fit::{Fit, FitError, Unmeasured, fit, sensor_map};
use rsrs_core::trials::trial::{detection_trials, period_trials, speed_trials, turn_trials};
use serde_json::Value;

use crate::generate;
use crate::numbers::numbers;
use crate::tables::tables;

const SPEED: &str = include_str!("../../../launch_configs/profiles/flockbot_trials/speed.csv");
const TURN: &str = include_str!("../../../launch_configs/profiles/flockbot_trials/turn.csv");
const DETECTION: &str =
    include_str!("../../../launch_configs/profiles/flockbot_trials/detection.csv");
const PERIOD: &str = include_str!("../../../launch_configs/profiles/flockbot_trials/period.csv");

fn flockbot() -> Fit {
    fit_texts([SPEED, TURN, DETECTION, PERIOD]).expect("the trials that ship can be fitted")
}

fn fit_texts([speed, turn, detection, period]: [&str; 4]) -> Result<Fit, FitError> {
    let speed = speed_trials("speed.csv", speed).expect("valid");
    let turn = turn_trials("turn.csv", turn).expect("valid");
    let detection = detection_trials("detection.csv", detection).expect("valid");
    let period = period_trials("period.csv", period).expect("valid");
    fit(tables(&speed, &turn, &detection, Some(&period)), &Unmeasured::default())
}

#[test]
fn the_committed_trials_are_what_the_example_makes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch_configs/profiles");

    let files = generate::files();

    assert_eq!(files.len(), 3 * 5 + 2);
    for (name, text) in files {
        let committed = std::fs::read_to_string(folder.join(&name)).expect("it is committed");
        assert!(committed == text, "{name}: run `cargo run -p rsrs_core --example make_trials`");
    }
}

#[test]
fn the_flockbots_trials_give_the_gains_of_the_papers_table() {
    let report = flockbot();

    let gains: Vec<(String, String)> = report
        .speed
        .iter()
        .map(|speed| (format!("{:.3}", speed.commanded_m_s), format!("{:.2}", speed.gain)))
        .collect();
    // tab:speed1, by robot and then by command.
    let expected = [
        ("0.025", "0.89"),
        ("0.050", "0.97"),
        ("0.025", "0.86"),
        ("0.050", "0.97"),
        ("0.025", "0.89"),
        ("0.050", "0.97"),
    ];
    assert_eq!(gains, expected.map(|(command, gain)| (command.to_owned(), gain.to_owned())));
    for (speed, sd_mm_s) in report.speed.iter().zip([0.57, 0.38, 0.04, 0.12, 0.46, 0.20]) {
        // Stopwatch times are written to a hundredth of a second.
        assert!((speed.sd_m_s.unwrap() * 1000.0 - sd_mm_s).abs() < 0.01, "{speed:?}");
        assert!(speed.gain_low.unwrap() < speed.gain && speed.gain < speed.gain_high.unwrap());
    }
}

#[test]
fn the_report_has_the_keys_of_the_contract() {
    let report = serde_json::to_value(flockbot()).unwrap();

    let keys = |value: &Value| {
        let keys: BTreeSet<String> =
            value.as_object().expect("an object").keys().cloned().collect();
        keys.into_iter().collect::<Vec<_>>().join(" ")
    };
    let of_motion = |unit: &str| {
        format!("commanded_{unit} gain gain_high gain_low mean_{unit} n_trials robot sd_{unit}")
    };

    assert_eq!(keys(&report), "period_s sensor speed turn");
    assert_eq!(keys(&report["speed"][0]), of_motion("m_s"));
    assert_eq!(keys(&report["turn"][0]), of_motion("rad_s"));
    assert_eq!(
        keys(&report["sensor"]),
        "false_positive false_positive_high false_positive_low polygon_m true_positive \
         true_positive_high true_positive_low"
    );
    assert!(report["period_s"].as_f64().is_some_and(|period_s| (period_s - 0.13).abs() < 0.005));
}

#[test]
fn every_number_of_a_fitted_profile_has_a_source() {
    let profile = flockbot().profile("flockbot", &Unmeasured::default());

    let mut found = BTreeSet::new();
    numbers(&serde_json::to_value(&profile).unwrap(), "", &mut found);
    let explained: BTreeSet<String> = profile.provenance.numbers.keys().cloned().collect();
    assert_eq!(found, explained);
    profile.check().expect("a fitted profile describes a robot");
}

#[test]
fn a_fitted_profile_survives_being_written_and_read() {
    let profile = flockbot().profile("flockbot", &Unmeasured::default());

    let text = profile.to_yaml();

    assert_eq!(RobotProfile::parse("p.yaml", &text).unwrap(), profile);
}

#[test]
fn the_fitted_flockbot_is_the_one_of_the_paper() {
    let profile = flockbot().profile("flockbot", &Unmeasured::default());

    let gains = &profile.actuation.speed.gain_by_command;
    assert!((gains[0].mean - 0.879).abs() < 1e-3 && (gains[1].mean - 0.971).abs() < 1e-3);
    assert!(profile.sensing.true_positive > 0.95 && profile.sensing.true_positive < 1.0);
    assert!((0.05..=0.08).contains(&profile.sensing.false_positive));
}

#[test]
fn the_polygon_lies_inside_the_measured_contour_and_covers_most_of_it() {
    let map = flockbot().details.sensor;

    let area = |polygon: &[[f64; 2]]| -> f64 {
        polygon
            .iter()
            .zip(polygon.iter().cycle().skip(1))
            .map(|([x, y], [next_x, next_y])| (x * next_y - next_x * y) / 2.0)
            .sum()
    };
    // The winding number of points along the polygon's border, a hair inside it.
    let centre = map.polygon_m.iter().fold([0.0, 0.0], |sum, corner| {
        let n = map.polygon_m.len() as f64;
        [sum[0] + corner[0] / n, sum[1] + corner[1] / n]
    });
    for (from, to) in map.polygon_m.iter().zip(map.polygon_m.iter().cycle().skip(1)) {
        for step in 0..=20 {
            let share = f64::from(step) / 20.0;
            let point = [0, 1].map(|axis| {
                let border = from[axis] + share * (to[axis] - from[axis]);
                border + 0.002 * (centre[axis] - border)
            });
            assert!(is_in_simple_polygon(&map.contour_m, point), "{point:?}");
        }
    }
    assert!(map.polygon_m.len() <= 8);
    let share = area(&map.polygon_m) / area(&map.contour_m);
    assert!((0.6..=1.0).contains(&share), "{share}");
}

fn is_in_simple_polygon(polygon: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let crossings = edges.filter(|([from_x, from_y], [to_x, to_y])| {
        (*from_y > y) != (*to_y > y)
            && x < (to_x - from_x) * (y - from_y) / (to_y - from_y) + from_x
    });
    crossings.count() % 2 == 1
}

#[test]
fn the_order_of_the_rows_does_not_matter_to_the_report() {
    let mut rows: Vec<&str> = SPEED.lines().skip(1).collect();
    rows.reverse();
    let reversed = format!("{}\n{}\n", SPEED.lines().next().unwrap(), rows.join("\n"));

    let (one, other) = (flockbot(), fit_texts([&reversed, TURN, DETECTION, PERIOD]).unwrap());

    for (one, other) in one.speed.iter().zip(&other.speed) {
        assert_eq!((&one.robot, one.n_trials), (&other.robot, other.n_trials));
        assert!((one.gain - other.gain).abs() < 1e-12, "{one:?} {other:?}");
    }
}

#[test]
fn few_trials_are_fitted_as_far_as_they_go_with_a_note() {
    let speed = "robot,commanded_m_s,distance_m,duration_s\na,0.1,2,21\n";
    let turn = "robot,commanded_rad_s,angle_rad,duration_s\na,0.75,6.2832,8.6\n";

    let report = fit_texts([speed, turn, DETECTION, PERIOD]).unwrap();

    let only = &report.speed[0];
    assert_eq!((only.sd_m_s, only.gain_low, only.gain_high), (None, None, None));
    let cautions: Vec<String> = report.details.cautions.iter().map(ToString::to_string).collect();
    assert!(cautions.iter().any(|caution| caution.contains("one robot only")), "{cautions:?}");
    assert!(cautions.iter().any(|caution| caution.contains("one command only (0.1 m/s)")));
    assert!(cautions.iter().any(|caution| caution.contains("no robot repeated")));
    report.profile("few", &Unmeasured::default()).check().expect("it still is a robot");
}

#[test]
fn an_outlier_is_named_and_still_counts() {
    let wild = SPEED.replacen(SPEED.lines().nth(1).unwrap(), "made_up_1,0.025,2,150,0,0", 1);

    let report = fit_texts([&wild, TURN, DETECTION, PERIOD]).unwrap();

    let cautions: Vec<String> = report.details.cautions.iter().map(ToString::to_string).collect();
    assert!(
        cautions
            .iter()
            .any(|caution| caution.starts_with("speed.csv:2: made_up_1 has a gain of 0.533")),
        "{cautions:?}"
    );
    assert_eq!(report.speed[0].n_trials, 5);
    assert!(report.speed[0].gain < 0.85, "{:?}", report.speed[0]);
}

#[test]
fn a_sensor_that_may_see_beyond_what_was_tried_is_named() {
    let place = |distance_m: f64, bearing_rad: f64, detections: u64| {
        format!("a,{distance_m},{bearing_rad},100,{detections}\n")
    };
    let grid = |detections: [[u64; 3]; 3]| {
        let rows = [0.2, 0.5, 0.8].into_iter().zip(detections).flat_map(|(distance_m, row)| {
            let row = [-0.4, 0.0, 0.4].into_iter().zip(row);
            row.map(move |(bearing_rad, detections)| place(distance_m, bearing_rad, detections))
        });
        let rows: String = rows.collect();
        format!("robot,distance_m,bearing_rad,samples,detections\n{rows}a,,,100,5\n")
    };
    let cautions = |detections| {
        let report = fit_texts([SPEED, TURN, &grid(detections), PERIOD]).unwrap();
        let texts = report.details.cautions.iter().map(ToString::to_string);
        texts.filter(|text| text.contains("tried")).collect::<Vec<_>>()
    };

    assert_eq!(cautions([[2, 98, 3], [1, 97, 2], [3, 4, 2]]), [""; 0]);
    let [right, far] = &cautions([[99, 98, 3], [95, 97, 2], [3, 96, 2]])[..] else {
        panic!("the right and the far end are open")
    };
    assert!(right.contains("the outermost bearing tried, -0.40 rad"), "{right}");
    assert!(far.contains("the farthest distance tried, 0.800 m"), "{far}");
}

#[test]
fn a_sensor_that_is_nowhere_reliable_is_refused() {
    let without =
        DETECTION.lines().filter(|row| !row.contains(",,")).collect::<Vec<_>>().join("\n");
    let weak = "robot,distance_m,bearing_rad,samples,detections\na,0.3,0,100,70\na,,,100,5\n";

    let refused = |detection: &str| {
        fit_texts([SPEED, TURN, detection, PERIOD]).expect_err("this is refused").to_string()
    };

    insta::assert_snapshot!(refused(&without), @"detection.csv: no row has an empty distance_m, expected readings without a neighbour (false positives)");
    insta::assert_snapshot!(refused(weak), @"detection.csv: no region with detections in 80 % of the readings: 1 places, the best with 70 %; expected some at two or more bearings");
}

#[test]
fn trajectories_without_turns_are_refused() {
    let speed = speed_trials("speed.csv", SPEED).expect("valid");
    let mut turn = turn_trials("turn.csv", TURN).expect("valid");
    turn.rows.clear();
    let detection = detection_trials("detection.csv", DETECTION).expect("valid");
    let tables = tables(&speed, &turn, &detection, None);

    let error = fit(tables, &Unmeasured::default()).expect_err("there is nothing to fit");

    assert_eq!(error.to_string(), "turn.csv: no turns in place, expected 1 or more");
}

#[test]
fn a_reach_lies_between_the_last_reading_that_detected_and_the_first_that_did_not() {
    let mut table = "robot,distance_m,bearing_rad,samples,detections\na,,,70,4\n".to_owned();
    for bearing_rad in [-0.2, 0.0, 0.2] {
        for (distance_m, detections) in [(0.487, 69), (0.622, 70), (0.757, 68), (0.892, 5)] {
            writeln!(table, "a,{distance_m},{bearing_rad},70,{detections}").unwrap();
        }
    }
    // A sensor that fades: 64 of 70 and then 54, and the share of 0.8 is between them.
    table.push_str("a,0.487,0.4,70,64\na,0.622,0.4,70,54\n");

    let map = sensor_map(&detection_trials("d.csv", &table).unwrap(), 0.075).unwrap();

    let [.., ahead, _, fading] = map.reach[..] else { panic!("{:?}", map.reach) };
    assert!((ahead.far_m - 0.8245).abs() < 1e-9, "{ahead:?}");
    assert_eq!((ahead.low_m, ahead.high_m), (0.757, Some(0.892)));
    let share = (64.0 / 70.0 - 0.8) / (10.0 / 70.0);
    assert!((fading.far_m - (0.487 + share * 0.135)).abs() < 1e-9, "{fading:?}");
}
